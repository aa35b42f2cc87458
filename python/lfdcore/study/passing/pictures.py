"""Fig. 5.5-5.7: demonstrations and generated paths, paths from growing observations, DTW distance against those."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle as Box
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.pictures.style import BODY, INK, METHOD_COLOURS, PAGE, REFERENCE, RULE, SEEN, UNKNOWN, WAY, styled
from lfdcore.simulated.passing import GROUND, MIDDLE, NOVEL, SCREEN, STEPS, TRAINING, Rectangle
from lfdcore.study.passing.study import AXES, Group, PassingExample, PassingResult
from lfdcore.study.report.statistics import summarise

Floats = NDArray[np.float64]
SHOWN_ARMS = ("IP", "EaIP")
DEMONSTRATION, GENERATED, MEAN = BODY, METHOD_COLOURS["EaIP"], INK
SHOWN = (0, 20, 60, 100)
"""L of Fig. 5.6's rows"""
_TOP = 180.0
"""[px] y of the upper edge of a panel: nothing goes higher"""


@styled
def demonstrations_figure(example: PassingExample) -> Figure:
    """As Fig. 5.5: what is learned from, and motions drawn from p(theta | e) with nothing of the partner seen."""
    figure = Figure(figsize=(PAGE, 2.35), layout="constrained")
    panels = figure.subplots(1, len(TRAINING), sharey=True)
    each = len(example.data.training) // len(TRAINING)
    for k, (axes, rectangle) in enumerate(zip(panels, TRAINING, strict=True)):
        demonstrations = example.data.training[k * each : (k + 1) * each]
        motions, _ = example.drawn(demonstrations[0], 0)
        _scene(axes, rectangle)
        _lines(axes, [one.partner for one in demonstrations], DEMONSTRATION, 2.2, 2, 0.45)
        _lines(axes, list(motions[:each]), GENERATED, 0.6, 3, 0.9)
        axes.set_title(f"e = {rectangle.width:g} x {rectangle.height:g} px", loc="left")
        axes.set_xlabel("x [px]")
    panels[0].set_ylabel("y [px]")
    for colour, width, label in ((DEMONSTRATION, 2.2, "demonstrations"), (GENERATED, 0.9, "generated, L = 0")):
        panels[0].plot([], [], color=colour, lw=width, label=f"{each} {label}")
    _legend_below(figure, panels[0])
    return figure


@styled
def observations_figure(example: PassingExample) -> Figure:
    """As Fig. 5.6: one person a rectangle (the first held out), rows of L; samples of the posterior and its mean."""
    people = [(r, several[0]) for group in (example.data.known, example.data.novel) for r, several in group.items()]
    figure = Figure(figsize=(PAGE, 0.8 * len(SHOWN) + 0.8), layout="constrained")
    panels = figure.subplots(len(SHOWN), len(people), sharex=True, sharey=True)
    for row, length in zip(panels, SHOWN, strict=True):
        for axes, (rectangle, person) in zip(row, people, strict=True):
            _draw_glimpse(axes, example, rectangle, person, length)
        row[0].set_ylabel(f"L = {length}\ny [px]")
    for axes, (rectangle, _) in zip(panels[0], people, strict=True):
        axes.set_title(f"{'novel' if rectangle in NOVEL else 'known'} {rectangle.name}", loc="left")
    for axes in panels[-1]:
        axes.set_xlabel("x [px]")
    lines = ((GENERATED, "-", f"{example.samples} samples"), (MEAN, "--", "their mean"), (SEEN, "-", "observed"))
    for colour, style, label in lines:
        panels[0, 0].plot([], [], color=colour, ls=style, label=label)
    _legend_below(figure, panels[0, 0])
    return figure


def _draw_glimpse(
    axes: Axes, example: PassingExample, rectangle: Rectangle, person: InteractionRecording, length: int
) -> None:
    motions, mean = example.drawn(person, length)
    _scene(axes, rectangle, dashed=rectangle in NOVEL)
    _lines(axes, list(motions), GENERATED, 0.5, 2, 0.5)
    axes.plot(*mean.T, color=MEAN, ls="--", lw=1.3, zorder=3)
    if length:
        axes.plot(*person.partner[:length].T, color=SEEN, lw=3.0, solid_capstyle="round", zorder=1.5)


def _scene(axes: Axes, rectangle: Rectangle, dashed: bool = False) -> None:
    """The rectangle on its ground, y downwards as on a screen."""
    corner = (MIDDLE - rectangle.width / 2, GROUND - rectangle.height)
    box = Box(corner, rectangle.width, rectangle.height, facecolor=UNKNOWN, edgecolor=WAY, linewidth=1.0, zorder=1)
    box.set_linestyle((0, (4, 3)) if dashed else "-")
    axes.add_patch(box)
    axes.axhline(GROUND, color=REFERENCE, lw=0.7, zorder=0.5)
    axes.set(xlim=(0, SCREEN[0]), ylim=(GROUND + 15, _TOP), aspect="equal", xticks=(0, 200, 400, 600))
    axes.tick_params(length=2.5, width=0.6)


def _lines(axes: Axes, paths: Sequence[Floats], colour: str, width: float, order: float, alpha: float) -> None:
    axes.add_collection(LineCollection(paths, colors=colour, linewidths=width, alpha=alpha, zorder=order))


def _legend_below(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)


@styled
def distance_figure(result: PassingResult) -> Figure:
    """As Fig. 5.7a, b: DTW distance against L with 95 % bands over seeds, novel rectangles above, known below."""
    figure = Figure(figsize=(PAGE, 6.0), layout="constrained")
    panels = figure.subplots(2, len(AXES), sharex=True, sharey=True)
    groups: tuple[Group, ...] = ("novel", "known")
    for row, group in zip(panels, groups, strict=True):
        for axes, (letter, seen) in zip(row, zip("ab", AXES, strict=True), strict=True):
            _draw_distances(axes, result, seen, group)
            axes.set_title(f"{letter}) {seen} observed, {group} rectangles", loc="left")
        row[0].set_ylabel("DTW distance [px per sample]")
    for axes in panels[-1]:
        axes.set_xlabel("L, samples observed")
    panels[0, 0].set(xlim=(-3, STEPS + 3), xticks=range(0, STEPS + 1, 20))
    panels[0, 0].set_ylim(bottom=0)
    _legend_below(figure, panels[0, 0])
    return figure


def _draw_distances(axes: Axes, result: PassingResult, seen: str, group: Group) -> None:
    lengths = result.study.lengths
    for arm in SHOWN_ARMS:
        colour = METHOD_COLOURS[arm]
        by_seed = result.by_seed(result.distance, arm, seen, group)
        summaries = [summarise(column) for column in by_seed.T]
        mean, low, high = (np.array([getattr(s, name) for s in summaries]) for name in ("mean", "low", "high"))
        axes.plot(lengths, mean, "o-", color=colour, lw=1.4, ms=3.5, label=arm, zorder=4)
        axes.fill_between(lengths, low, high, color=colour, alpha=0.2, lw=0, zorder=2)
        known = result.by_seed(result.distance, f"{arm}, phase given", seen, group).mean(axis=0)
        axes.plot(lengths, known, ":", color=colour, lw=1.2, label=f"{arm}, phase given", zorder=3)
    floor = float(result.floor_by_seed(group).mean())
    axes.axhline(floor, color=REFERENCE, lw=0.8, ls="--", label="two demonstrations", zorder=1)
    axes.grid(axis="y", lw=0.4, color=RULE)
    axes.spines[["top", "right"]].set_visible(False)
