"""The report of study handovers: errors against the share observed, differences to the baselines, a picture a task."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore import __version__
from lfdcore.pictures.style import (
    ANOTHER,
    BASELINE,
    BLUE,
    GREEN,
    INK,
    PAGE,
    PURPLE,
    RULE,
    SKY,
    VERMILLION,
    Picture,
    styled,
)
from lfdcore.study.handovers.study import MEASURES, METHODS, SHARES, STEPS, TESTED, HandoverStudy, TaskErrors
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import block_bootstrap
from lfdcore.study.report.table import Table

Array = NDArray[np.float64]
WARPED, MEAN, NEAREST = (
    METHODS.index("IP, phase by time warping"),
    METHODS.index("mean trajectory"),
    METHODS.index("nearest demonstration"),
)
LIKELIEST = METHODS.index("IP")
COLOURS = (BLUE, PURPLE, SKY, ANOTHER, BASELINE, VERMILLION, GREEN, INK)
"""of METHODS"""
ABOUT = (
    "People hand something to each other; the giver is the partner, the taker's hand stands for the robot's. Of each "
    "handover held out a share of the giver's motion is seen, and the whole motion of the taker's hand is foretold and "
    f"compared in normalised time ({STEPS} steps). {TESTED:.0%} of the handovers are held out in each split, and "
    "sigma^2 is chosen from those that teach.\n\n"
    "Nothing of the scene is known beforehand in these data, so that there is no environment: IP is the plain "
    "interaction primitive, whose phase is where the samples are likeliest (humanoid/partner_phase), which is ours; "
    "by time warping, it is DTW's against the giver's mean motion (5.5), with IP's sigma^2; by the clock, the time "
    "over the demonstrations' mean duration. KTH's recordings were cut to one "
    "duration, so that there the clock tells as much as the oracle. Oracles are told what nobody can know by then: "
    "the phase, or where the handover takes place (given as e, with IP's sigma^2)."
)


@dataclass(frozen=True)
class Interval:
    """A mean over tests and its 95 % interval by a bootstrap of whole demonstrations, [m]."""

    mean: float
    low: float
    high: float

    def as_text(self) -> str:
        """In mm."""
        return f"{1e3 * self.mean:.0f}\n[{1e3 * self.low:.0f}, {1e3 * self.high:.0f}]"


def intervals(values: Array, tested: NDArray[np.int_], seed: int) -> list[Interval]:
    """Of values (n, k) whose row i is of the recording tested[i]: a recording is tested in several splits."""
    low, high = block_bootstrap(values, tested, seed)
    return [Interval(*map(float, one)) for one in zip(values.mean(axis=0), low, high, strict=True)]


def _header(first: str = "") -> tuple[str, ...]:
    return (first, *("first sample" if share == 0 else f"{share:.0%}" for share in SHARES))


def _caption(result: TaskErrors) -> str:
    tests = len(result.tested)
    return f"n = {len(result.task.recordings)} handovers, {tests} tests in {len(result.splits)} splits"


def error_table(result: TaskErrors, measure: int, seed: int) -> Table:
    """A row a method, a column a share."""
    errors, spread = result.errors[..., measure], result.split_means[..., measure]
    rows = [
        (name, *(one.as_text() for one in intervals(errors[:, k], result.tested, seed)))
        for k, name in enumerate(METHODS)
    ]
    sd = spread[:, LIKELIEST].std(axis=0, ddof=1) if len(spread) > 1 else np.full(len(SHARES), np.nan)
    return Table(
        f"{result.task.name}: RMS error of the taker's hands {MEASURES[measure]} [mm] by share observed "
        f"({_caption(result)}, seed {seed})",
        _header(),
        tuple(rows),
        "Below: 95 % interval by a bootstrap of whole demonstrations. Standard deviation of a split's mean, IP with "
        f"positions: {1e3 * np.nanmin(sd):.0f}-{1e3 * np.nanmax(sd):.0f} mm."
        if np.isfinite(sd).any()
        else "Below: 95 % interval by a bootstrap of whole demonstrations.",
    )


def difference_table(result: TaskErrors, seed: int) -> Table:
    """IP less each baseline, paired: below 0 it is better."""
    rows = []
    for measure, words in enumerate(MEASURES):
        errors = result.errors[..., measure]
        for way, what in ((WARPED, "DTW"), (LIKELIEST, "likeliest")):
            for other, name in ((MEAN, "mean"), (NEAREST, "nearest")):
                found = intervals(errors[:, way] - errors[:, other], result.tested, seed)
                rows.append((f"{words}: {what} - {name}", *(one.as_text() for one in found)))
    return Table(
        f"{result.task.name}: error of IP with positions, phase by DTW or the likeliest, less that of a "
        f"baseline, paired [mm] ({_caption(result)})",
        _header(),
        tuple(rows),
        "Below 0: IP is better; an interval that holds 0 decides nothing.",
    )


def seen_tables(results: Sequence[TaskErrors], seed: int) -> list[Table]:
    """What more that is seen is worth: tasks on the same recordings and splits, paired (Sec. 6.2.2)."""
    pairs = [(a, b) for a, b in pairwise(results) if np.array_equal(a.tested, b.tested)]
    return [_seen_table(few, more, seed) for few, more in pairs]


def _seen_table(few: TaskErrors, more: TaskErrors, seed: int) -> Table:
    rows = []
    for measure, words in enumerate(MEASURES):
        for way in (WARPED, LIKELIEST):
            apart = more.errors[:, way, :, measure] - few.errors[:, way, :, measure]
            rows.append((f"{words}, {METHODS[way]}", *(one.as_text() for one in intervals(apart, few.tested, seed))))
    return Table(
        f"{more.task.name} less {few.task.name}: error, paired [mm] ({_caption(few)}, seed {seed})",
        _header(),
        tuple(rows),
        "Below 0: seeing more is better.",
    )


def task_tables(result: TaskErrors, seed: int) -> list[Table]:
    """All tables of a task."""
    return [*(error_table(result, k, seed) for k in range(len(MEASURES))), difference_table(result, seed)]


@styled
def error_figure(result: TaskErrors, seed: int) -> Figure:
    """Errors against the share observed, a panel a measure."""
    figure = Figure(figsize=(PAGE, 3.9), layout="constrained")
    panels = figure.subplots(1, len(MEASURES), sharex=True)
    for measure, axes in enumerate(panels):
        _draw_errors(axes, result, measure, seed)
    panels[0].set_ylabel("RMS error of the taker's hands [mm]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(f"{result.task.name} ({_caption(result)})", fontsize=9.5)
    return figure


def _draw_errors(axes: Axes, result: TaskErrors, measure: int, seed: int) -> None:
    at = 100 * np.array(SHARES)
    for k, name in enumerate(METHODS):
        found = 1e3 * np.array(
            [(one.mean, one.low, one.high) for one in intervals(result.errors[:, k, :, measure], result.tested, seed)]
        )
        oracle = name.startswith("oracle")
        axes.plot(at, found[:, 0], color=COLOURS[k], lw=1.1 if oracle else 1.6, ls="--" if oracle else "-", label=name)
        if k in (WARPED, LIKELIEST, NEAREST):
            axes.fill_between(at, found[:, 1], found[:, 2], color=COLOURS[k], alpha=0.14, lw=0)
    axes.set(title=MEASURES[measure], xlabel="of the giver's motion seen [%]", xlim=(0, 100))
    axes.set_ylim(bottom=0)
    axes.grid(color=RULE, lw=0.6)


def handover_headline(results: Sequence[TaskErrors], study: HandoverStudy) -> str:
    """What came of it, in a sentence a task, at 30 % observed."""
    at, parts = SHARES.index(0.3), []
    for result in results:
        errors = result.errors[:, :, at, 0]
        ip, tempo, mean, near = (1e3 * errors[:, k].mean() for k in (WARPED, LIKELIEST, MEAN, NEAREST))
        said = [
            _verdict(result, at, way, other, study.seed) for way in (WARPED, LIKELIEST) for other in (MEAN, NEAREST)
        ]
        parts.append(
            f"{result.task.name} (n = {len(result.task.recordings)}): IP with DTW {ip:.0f} mm, {said[0]} the mean "
            f"trajectory ({mean:.0f}) and {said[1]} the nearest demonstration ({near:.0f}); with the likeliest phase "
            f"{tempo:.0f}, {said[2]} the mean and {said[3]} the nearest."
        )
    return (
        f"Taker's hands foretold after 30 % of the giver's motion, RMS over time, {study.splits} random splits, seed "
        f"{study.seed}. " + " ".join(parts)
    )


def _verdict(result: TaskErrors, share: int, way: int, other: int, seed: int) -> str:
    errors = result.errors[:, :, share, 0]
    found = intervals((errors[:, way] - errors[:, other])[:, None], result.tested, seed)[0]
    if found.high < 0:
        return "better than"
    return "worse than" if found.low > 0 else "not to be told from"


def handover_rows(results: Sequence[TaskErrors], study: HandoverStudy) -> list[dict[str, object]]:
    """Every figure, for machines."""
    rows: list[dict[str, object]] = []
    for result in results:
        spread = (
            result.split_means.std(axis=0, ddof=1) if study.splits > 1 else np.full(result.errors.shape[1:], np.nan)
        )
        for measure, words in enumerate(MEASURES):
            for k, method in enumerate(METHODS):
                found = intervals(result.errors[:, k, :, measure], result.tested, study.seed)
                for at, (share, one) in enumerate(zip(SHARES, found, strict=True)):
                    rows.append(
                        {
                            "task": result.task.name,
                            "n": len(result.task.recordings),
                            "tests": len(result.tested),
                            "splits": study.splits,
                            "seed": study.seed,
                            "measure": words,
                            "method": method,
                            "share": share,
                            "error": one.mean,
                            "low": one.low,
                            "high": one.high,
                            "sd_of_splits": float(spread[k, at, measure]),
                        }
                    )
    return rows


def handover_sections(results: Sequence[TaskErrors], study: HandoverStudy) -> list[Section]:
    """One a task."""
    sections = []
    for k, result in enumerate(results):
        factors = sorted({split.factors[0] for split in result.splits})
        chosen = ", ".join(f"{factor:g}" for factor in factors)
        text = (
            f"Seen and foretold: {result.task.description}. sigma^2 over the fit's residual, as chosen in the splits "
            f"for positions: {chosen}."
        )
        sections.append(
            Section(
                result.task.name,
                f"{ABOUT}\n\n{text}" if k == 0 else text,
                task_tables(result, study.seed),
                [
                    Picture(
                        error_figure(result, study.seed),
                        f"{result.task.name}: error against the share of the giver's motion observed. Bands: 95 % "
                        "intervals by a bootstrap of whole demonstrations. Dashed: oracles.",
                    )
                ],
            )
        )
    if tables := seen_tables(results, study.seed):
        text = "The same recordings and splits, but more of the giver (and, with poses, of the taker) in the model."
        sections.append(Section("Is seeing more better?", text, tables))
    return sections


def write_handover_report(results: Sequence[TaskErrors], study: HandoverStudy, folder: Path, command: str) -> Path:
    """Writes report.html and figures.json into `folder` -> the report's path. The same results give the same bytes."""
    write_figures(folder / "figures.json", handover_rows(results, study))
    origin = f"lfdcore {__version__}, seed {study.seed}. Made by: `{command}`"
    sections, lead = handover_sections(results, study), handover_headline(results, study)
    return write_report(folder / "report.html", "lfdcore: real handovers", sections, lead, origin)
