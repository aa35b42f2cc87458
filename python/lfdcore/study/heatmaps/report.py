"""The report's parts on heatmaps: Table 4.2 with Fig. 4.14 and 4.16, the calibration, the stages (Fig. 4.6-4.12)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.heatmap_stages import heatmap_figures
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.courses import home_20x19
from lfdcore.study.demonstrations import RecordedDrives, drive_to_destinations
from lfdcore.study.heatmaps.calibration import REACH, CalibrationCheck, check_calibration, judged_cells
from lfdcore.study.heatmaps.comparison import METHODS, STEP, Comparison, ModelFiles, compare_on_logs
from lfdcore.study.heatmaps.comparison import REACH as WAY
from lfdcore.study.heatmaps.pictures import (
    METHOD_NAMES,
    concatenated_figure,
    destinations_figure,
    learning_curves_figure,
    median_runs,
    reliability_figure,
)
from lfdcore.study.report.cells import p_cell, summary_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import paired_test, summarise, summarise_bounded
from lfdcore.study.report.table import Row, Table
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlannerConfig
from lfdcore.wheelchair.planner import LOOK_AHEAD
from lfdcore.wheelchair.window import RESOLUTION

_ROWS = (
    ("reward", "reward at positions", 3, ("0.62+-0.10", "0.56+-0.17", "0.67+-0.051")),
    ("rank", "its percentile rank [%]", 1, ("-", "-", "-")),
    ("near", f"path RMSE, first {LOOK_AHEAD:g} m [m]", 3, ("0.05+-0.12", "0.14+-0.18", "0.047+-0.09")),
    ("whole", f"... up to {WAY:g} m [m]", 3, ("-", "-", "-")),
    ("at_equal_length", "... at equal arc length [m]", 3, ("-", "-", "-")),
    ("without_path", "frames without a path", 3, ("-", "-", "-")),
)
_TIMES = "0.5 s, 0.2 s, 0.2 s"
MOST_ERROR = 0.05
"""calibration error of a run that is to be reached"""
_KNOWN_TO = 0.25
"""[m] on either side, to say what a probability of a cell can be"""
_DEFINITIONS = (
    "mean+-sd over runs (several of one driver, not independent), the mean's 95 % interval (Student's; of the "
    "share of frames a seeded bootstrap's), below it the thesis's figure (its users, home and chair). p: against "
    "heatmaps, paired over runs (exact Wilcoxon signed-rank), not corrected for their number. Reward: mean at the "
    "positions driven, every {step:g} m, of the concatenated landscapes (Alg. 4), each squashed to (0, 1): less its "
    "smallest value over cells that may be entered, divided by its largest, the same for all methods. How fast "
    "values fall with the distance from a goal is set by the discount ({discounts}), so that rewards of different "
    "optimisers hardly compare; the percentile rank among all cells seen does not depend on the scale of the map. "
    "Path RMSE: root mean square of the distance from the planned path's points to the way then driven, mean over "
    "a run's frames, for the first {look_ahead:g} m (pure pursuit's look-ahead) and up to {reach:g} m; the thesis does "
    "not define its own. A plan starts at the centre of the chair's cell, {half_cell:g} m left of the axle: along a "
    "straight way that alone makes {half_cell:g} m. At equal arc length: both compared up to {reach:g} m, the path "
    "straight on beyond its end."
)


def _cell(values: np.ndarray, digits: int, thesis: str = "-", bounded: bool = False) -> str:
    cell = summary_cell(summarise_bounded(values) if bounded else summarise(values), digits)
    return cell if thesis == "-" else f"{cell}\nthesis {thesis}"


def comparison_table(comparison: Comparison, seed: int | None) -> Table:
    """Table 4.2 beside the thesis's figures; `seed`: what the unassisted drives were made with, None for a user's own
    logs."""
    rows: list[Row] = []
    for figure, label, digits, thesis in _ROWS:
        columns = [comparison.column(method, figure) for method in METHODS]
        cells = (
            _cell(column, digits, said, figure == "without_path") for column, said in zip(columns, thesis, strict=True)
        )
        rows.append((label, *cells, *(p_cell(paired_test(columns[-1], other).p) for other in columns[:-1])))
    seconds = [comparison.column(method, "seconds") for method in METHODS]
    times = (_cell(own / seconds[-1], 1) for own in seconds[:-1])
    last = f"1\n{1e3 * float(np.median(seconds[-1])):.1f} ms here"
    rows.append(("computation time,\nratio to heatmaps", *times, last, "", ""))
    config = comparison.config
    discounts = f"{config.primitives.dpp.discount:g} of DPP, {config.heatmaps.q_learning.discount:g} of Q-learning"
    runs, drawn = ("logs", "") if seed is None else ("unassisted runs", f", seed {seed}")
    return Table(
        f"A-posteriori comparison (as Table 4.2; n = {len(comparison.runs)} {runs}, {comparison.frames} frames every "
        f"{config.period:g} s of driving{drawn})",
        ("", *(METHOD_NAMES[method].replace(" (", "\n(") for method in METHODS), "p,\nprimitives", "p,\nnaive"),
        tuple(rows),
        _DEFINITIONS.format(discounts=discounts, step=STEP, look_ahead=LOOK_AHEAD, reach=WAY, half_cell=RESOLUTION / 2)
        + f" {_doubt(config.heatmaps)} Time: from the observation to the end of the coarse path, medians of runs; "
        f"thesis: {_TIMES}.",
    )


def _doubt(config: HeatmapPlannerConfig) -> str:
    return f"Doubt about the driver's stick, beside the Gaussian processes' (driver_sd): {config.driver_sd:g} rad."


def comparison_verdict(comparison: Comparison) -> str:
    """What came out beside what the thesis says: heatmaps before primitives before the naive network."""
    parts = []
    for figure, name, better in (("reward", "reward", -1), ("rank", "percentile rank", -1), ("near", "path RMSE", 1)):
        means = {method: float(np.nanmean(comparison.column(method, figure))) for method in METHODS}
        order = sorted(METHODS, key=lambda method, means=means: better * means[method])  # type: ignore[misc]
        shown = ", ".join(f"{METHOD_NAMES[m]} {means[m]:.{1 if figure == 'rank' else 3}f}" for m in order)
        agrees = "as in the thesis" if order == ["heatmaps", "primitives", "naive"] else "not the thesis's order"
        parts.append(f"By {name}, best first: {shown} ({agrees}).")
    return " ".join(parts)


def comparison_section(
    comparison: Comparison, drives: RecordedDrives | None = None, home: OccupancyGrid | None = None, seed: int = 1
) -> Section:
    """Table 4.2, Fig. 4.16 and, with the drives in their map, Fig. 4.14."""
    pictures = []
    if drives is not None and home is not None:
        pictures.append(
            Picture(
                destinations_figure(drives.traces, home),
                f"As Fig. 4.14: {len(drives.traces)} unassisted runs of simulated able drivers (a colour a driver) to "
                f"arbitrary destinations in a home unlike the mazes, from ring to square; seed {seed}, "
                f"{drives.collisions} contacts, {drives.unfinished} runs unfinished.",
            )
        )
    shown = median_runs(comparison.runs)
    pictures.append(
        Picture(
            concatenated_figure(shown),
            f"As Fig. 4.16: landscapes after optimisation, put together by Alg. 4, of {len(shown)} of "
            f"{len(comparison.runs)} runs (rows; lower quartile, median and upper quartile of the heatmaps' rank; seed "
            f"{seed}); way and footprints in black; white: never seen free, grey: seen occupied.",
        )
    )
    return Section(
        "What the methods predict, a posteriori (Sec. 4.6.2)",
        "All three methods see the same unassisted drives and plan every "
        f"{comparison.config.period:g} s. {comparison_verdict(comparison)}",
        [comparison_table(comparison, seed)],
        pictures,
    )


def calibration_table(check: CalibrationCheck, seed: int) -> Table:
    """The error and the Brier score beside the constant rate's."""
    judged, each = check.judged, summarise(check.errors)
    cells = int(judged.count.sum())
    rows = (
        ("calibrated heat", f"{judged.error:.4f}", f"{judged.top_error:.4f}", f"{judged.brier:.5f}"),
        ("constant rate", f"{judged.constant_error:.4f}", "-", f"{judged.constant_brier:.5f}"),
        ("heat itself", f"{check.raw.error:.4f}", f"{check.raw.top_error:.4f}", f"{check.raw.brier:.5f}"),
    )
    skill = 1 - judged.brier / judged.constant_brier
    return Table(
        f"Calibration: the driver's path crosses this cell within {REACH:g} m (n = {len(check.errors)} home runs, "
        f"{cells} cells, seed {seed})",
        ("", "expected\ncalibration error", "... of the\nlikeliest cells", "Brier score"),
        rows,
        f"Fitted on {check.fitted_runs} maze runs ({check.fitted_cells} cells) that the network was not trained on, "
        "though others in the same mazes were and the joystick's Gaussian processes saw them. Error of a run: "
        f"{each.mean:.4f}+-{each.sd:.4f}, 95 % interval [{each.low:.4f}, {each.high:.4f}]; to reach: {MOST_ERROR:g}. "
        f"Likeliest cells: those that hold half of all crossings. A cell is {RESOLUTION:g} m wide, so that a way known "
        f"to {_KNOWN_TO:g} m on either side crosses it with a probability of {RESOLUTION / (2 * _KNOWN_TO):g}: no "
        "heatmap comes near 1. A constant rate is calibrated and knows "
        f"nothing: of its Brier score calibrated heat takes off {100 * skill:.1f} %.",
    )


def calibration_section(
    model: HeatmapModel, held_out: Sequence[DriveLog], judged: Sequence[DriveLog], seed: int = 1
) -> Section:
    """Fits on runs held out of training (`model.metadata['held_out']` says which), judges on others."""
    config = HeatmapPlannerConfig()
    check = check_calibration(judged_cells(held_out, model, config), judged_cells(judged, model, config))
    caption = (
        f"Reliability of heatmaps on {len(judged)} home runs never trained on or fitted to (seed {seed}). A: bins of "
        "equal width, larger dots for more cells (logarithmic). B: tenths of all cells. C: from heat to probability, "
        "fitted on maze runs held out of training."
    )
    return Section(
        "What heat is worth as a probability",
        f"Heat of the product of both heatmaps. {_doubt(config)}",
        [calibration_table(check, seed)],
        [Picture(reliability_figure(check), caption)],
    )


def heatmap_section(
    model: HeatmapModel, demonstrations: Sequence[DriveLog], drive: DriveLog, naive: NaiveHeatmapModel | None = None
) -> Section:
    """The stages (Fig. 4.6-4.12) and the learning curves, as far as the models' files hold them."""
    pictures = heatmap_figures(model, demonstrations, drive, origin="Simulated able driver, unassisted.")
    named = {"sensor": model.metadata, "naive": {} if naive is None else naive.metadata}
    curves = {
        name: (said["train_losses"], said["validation_losses"])
        for name, said in named.items()
        if "train_losses" in said
    }
    if curves:
        runs = f"{len(model.metadata['logs'])} runs, of which {len(model.metadata['held_out'])} were held out"
        caption = f"Learning curves of the networks, with augmentation (mirroring) only while training; {runs}."
        pictures.append(Picture(learning_curves_figure(curves), caption))
    return Section("From a scan and a stick to a path, by heatmaps", "", (), pictures)


def a_posteriori_sections(
    folder: Path,
    files: ModelFiles,
    demonstrations: Sequence[Path],
    seed: int,
    progress: StageProgress | None = None,
) -> list[Section]:
    """All of it: 30 drives to destinations, recorded in `folder`; their comparison; the stages; and the calibration,
    if the model says which of its `demonstrations` (all its logs, in their order) were held out."""
    tell = progress or silent
    drives = drive_to_destinations(folder, seed, progress=partial(tell, "drive to destinations"))
    comparison = compare_on_logs(drives.paths, files, progress=partial(tell, "compare"))
    models, logs = files.load(), [open_log(path) for path in drives.paths]
    demonstrated = [open_log(path) for path in demonstrations]
    sections = [
        heatmap_section(models.heatmaps, demonstrated, logs[0], models.naive),
        comparison_section(comparison, drives, home_20x19().grid, seed),
    ]
    if "held_out" in models.heatmaps.metadata:
        held_out = held_out_logs(models.heatmaps, demonstrations)
        sections.append(calibration_section(models.heatmaps, held_out, logs, seed))
    return sections


def held_out_logs(model: HeatmapModel, demonstrations: Sequence[Path]) -> list[DriveLog]:
    """Of the files that a model learned from, in their order, those that its network was validated on. ValueError if
    the model does not say which, or learned from another number of logs."""
    held_out, logs = model.metadata.get("held_out"), model.metadata.get("logs", [])
    if held_out is None or len(logs) != len(demonstrations):
        raise ValueError(f"the model learned from {len(logs)} logs, {len(demonstrations)} are given")
    return [open_log(demonstrations[k]) for k in held_out]
