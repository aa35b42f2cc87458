"""Pictures of the a-posteriori comparison: drives (Fig. 4.14), concatenated heatmaps (Fig. 4.16), calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.geometry import Footprint
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.course import draw_footprints, draw_grid, every, label_metres
from lfdcore.pictures.style import (
    ANOTHER,
    BASELINE,
    LANDSCAPE,
    LEARNED,
    METHOD_COLOURS,
    PAGE,
    REFERENCE,
    WALL,
    WAY,
    series_colour,
    styled,
)
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.heatmaps.calibration import CalibrationCheck, Reliability
from lfdcore.study.heatmaps.comparison import METHODS, ComparedRun
from lfdcore.wheelchair.window import free_mask

METHOD_NAMES = {"primitives": "primitives (Ch. 3)", "naive": "naive CNN", "heatmaps": "heatmaps (CNN/GP)"}


@styled
def destinations_figure(traces: Sequence[DriveTrace], grid: OccupancyGrid) -> Figure:
    """All drives in one map, a colour a driver (Fig. 4.14). A ring is where a drive begins."""
    figure = Figure(figsize=(0.63 * PAGE, 0.61 * PAGE), layout="compressed")
    axes = figure.subplots()
    draw_grid(axes, grid)
    for k, trace in enumerate(traces):
        colour = series_colour(k)
        axes.plot(*trace.pose[:, :2].T, color=colour, lw=1.1, alpha=0.9, zorder=2)
        axes.plot(*trace.pose[0, :2], "o", color="white", mec=colour, ms=4.5, mew=1.2, zorder=3)
        axes.plot(*trace.pose[-1, :2], "s", color=colour, ms=4.0, mew=0, zorder=3)
    return figure


def _shown(run: ComparedRun, margin: float = 2.2) -> tuple[tuple[float, float], tuple[float, float]]:
    """x and y limits [m] around the way."""
    low, high = run.driven[:, :2].min(axis=0) - margin, run.driven[:, :2].max(axis=0) + margin
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def _draw_concatenated(axes: Axes, run: ComparedRun, method: str) -> None:
    grid = run.grid
    x, y = grid.origin
    extent = (x, x + grid.width * grid.resolution, y, y + grid.height * grid.resolution)
    heat = np.where(free_mask(grid), run.methods[method].concatenated, np.nan)
    colours = colormaps[LANDSCAPE].with_extremes(bad="white")
    axes.imshow(heat, origin="lower", extent=extent, cmap=colours, vmin=0, vmax=1, interpolation="nearest")
    shade = np.zeros((*grid.data.shape, 4))
    shade[grid.occupied_mask()] = to_rgba(WALL, 0.6)
    axes.imshow(shade, origin="lower", extent=extent, interpolation="nearest")
    draw_footprints(axes, every(run.driven, 0.5), Footprint(), "black")
    axes.plot(*run.driven[:, :2].T, color="black", lw=1.2, zorder=3)
    label_metres(axes)
    limits = _shown(run)
    axes.set(xlim=limits[0], ylim=limits[1])


@styled
def concatenated_figure(runs: Sequence[ComparedRun]) -> Figure:
    """Concatenated heatmaps: a row a run, a column a method, footprints and way in black (Fig. 4.16)."""
    shapes = [np.ptp(np.array(_shown(run)), axis=1) for run in runs]
    width = (PAGE - 0.8) / len(METHODS)
    heights = [width * float(shape[1] / shape[0]) for shape in shapes]
    figure = Figure(figsize=(PAGE, sum(heights) + 0.5 * len(runs) + 0.3), layout="compressed")
    panels = figure.subplots(len(runs), len(METHODS), squeeze=False, height_ratios=heights)
    for row, run in zip(panels, runs, strict=True):
        for axes, method in zip(row, METHODS, strict=True):
            _draw_concatenated(axes, run, method)
            found = run.methods[method]
            axes.set_title(f"{METHOD_NAMES[method]}\nreward {found.reward:.2f}, rank {found.rank:.0f} %")
            if axes is not row[0]:
                axes.set_ylabel("")
            if run is not runs[-1]:
                axes.set_xlabel("")
    image = panels[0, 0].images[0]
    figure.colorbar(image, ax=panels, shrink=0.5, aspect=35, label="reward, mean over frames")
    return figure


def median_runs(runs: Sequence[ComparedRun]) -> list[ComparedRun]:
    """At most three: those at the lower quartile, the median and the upper quartile of the heatmaps' rank."""
    order = sorted(range(len(runs)), key=lambda k: runs[k].methods["heatmaps"].rank)
    chosen = [order[round(share * (len(runs) - 1))] for share in (0.25, 0.5, 0.75)]
    return [runs[k] for k in dict.fromkeys(chosen)]


# ---- calibration ---------------------------------------------------------------------------------------------------


def _reliability_axes(axes: Axes, top: float) -> None:
    axes.plot([0, top], [0, top], color=REFERENCE, lw=0.8, ls="--", zorder=1, label="as predicted")
    axes.set(xlabel="predicted probability", ylabel="share that was crossed", xlim=(0, top), ylim=(0, top))
    axes.set_aspect("equal")
    axes.tick_params(length=2.5, width=0.6)


def _draw_reliability(axes: Axes, found: Reliability, colour: str, label: str) -> None:
    size = 2.5 + 1.1 * np.log10(np.maximum(found.count, 1))
    axes.plot(found.predicted, found.happened, color=colour, lw=1.0, zorder=2, label=label)
    for said, happened, ms in zip(found.predicted, found.happened, size, strict=True):
        axes.plot(said, happened, "o", color=colour, ms=ms, mew=0, zorder=3)


@styled
def reliability_figure(check: CalibrationCheck) -> Figure:
    """A: heat taken for a probability, and calibrated; B: the calibrated one in bins of equally many cells, with the
    constant-rate predictor; C: the table from heat to probability."""
    figure = Figure(figsize=(PAGE, 3.3), layout="compressed")
    a, b, c = figure.subplots(1, 3)
    _draw_reliability(a, check.raw, ANOTHER, f"heat itself: error {check.raw.error:.3f}")
    _draw_reliability(a, check.judged, LEARNED, f"calibrated: error {check.judged.error:.4f}")
    _reliability_axes(a, 1.0)
    a.set_title("A  all cells, bins of equal width")
    said, happened = check.tenths
    top = 1.1 * float(max(said.max(), happened.max()))
    b.plot(said, happened, "o-", color=LEARNED, ms=4, lw=1.0, zorder=3, label="calibrated")
    rate = check.judged.constant_rate
    b.plot(rate, check.happened, "D", color=BASELINE, ms=6, zorder=4, label="constant rate")
    _reliability_axes(b, top)
    b.set_title("B  tenths of the cells by probability")
    c.plot(np.maximum(check.calibration.heat, 1e-3), check.calibration.probability, color=WAY, lw=1.2)
    c.set(xscale="log", xlim=(1e-3, 1), xlabel="heat", ylabel="probability", ylim=(0, None))
    c.set_title("C  the calibration")
    for axes in (a, b):
        axes.legend(frameon=False, loc="upper left")
    return figure


@styled
def learning_curves_figure(curves: Mapping[str, tuple[Sequence[float], Sequence[float]]]) -> Figure:
    """Of each named network the loss of every epoch on what it was trained on, and on what was held out."""
    figure = Figure(figsize=(0.6 * PAGE, 3.1), layout="compressed")
    axes = figure.subplots()
    for name, (train, held_out) in curves.items():
        epochs: NDArray[np.int_] = np.arange(1, len(train) + 1)
        axes.plot(epochs, train, "--", color=METHOD_COLOURS[name], lw=1.0, label=f"{name}, trained on")
        axes.plot(epochs, held_out, "o-", color=METHOD_COLOURS[name], ms=3.5, lw=1.3, label=f"{name}, held out")
    axes.set(xlabel="epoch", ylabel="cross-entropy of a cell", yscale="log")
    axes.legend(frameon=False)
    return figure
