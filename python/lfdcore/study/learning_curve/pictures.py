"""The picture of study learning-curve: what a method is worth over the number of runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lfdcore.pictures.course import arm_name
from lfdcore.pictures.style import METHOD_COLOURS, PAGE, RULE, styled
from lfdcore.study.learning_curve.curve import CurvePoint, LearningCurve
from lfdcore.study.learning_curve.study import METHODS, NOBODY
from lfdcore.study.report.statistics import Summary

Estimate = tuple[float, float, float]
"""figure, and its 95 % interval"""

MARKS = {"primitives": "o", "heatmaps": "s"}
_APART = 1.03  # the methods stand side by side


def _of_summary(s: Summary) -> Estimate:
    return s.mean, max(s.low, 0.0), s.high


PANELS: tuple[tuple[str, Callable[[CurvePoint], Estimate]], ...] = (
    ("contacts a run", lambda p: p.contact_rate),
    ("share completed", lambda p: p.completion),
    ("path RMSE [m]", lambda p: _of_summary(p.path_rmse)),
    ("angular jerk / unassisted", lambda p: _of_summary(p.jerk_ratio)),
    ("error of the path\npredicted to 2.5 m [m]", lambda p: _of_summary(p.path_error)),
)


def method_name(method: str) -> str:
    """As people call it in a study where all but unassisted are learned."""
    return arm_name(method).removesuffix(" (learned)")


def _draw(axes: Axes, points: Sequence[CurvePoint], estimate: Callable[[CurvePoint], Estimate]) -> None:
    for method, shift in zip(METHODS, (1 / _APART, _APART), strict=True):
        mine = [point for point in points if point.method == method]
        value, low, high = np.array([estimate(point) for point in mine]).T
        at = np.array([point.demonstrations for point in mine]) * shift
        axes.errorbar(
            at,
            value,
            [np.nan_to_num(value - low), np.nan_to_num(high - value)],
            color=METHOD_COLOURS[method],
            marker=MARKS[method],
            ms=4,
            lw=1.3,
            elinewidth=0.9,
            capsize=2.5,
            clip_on=False,
            label=method_name(method),
        )
    alone = estimate(next(point for point in points if point.method == NOBODY))
    if np.isfinite(alone[0]):
        axes.axhline(alone[0], color=METHOD_COLOURS[NOBODY], lw=1.0, ls="--", label="unassisted")


@styled
def curve_figure(curve: LearningCurve) -> Figure:
    """Contacts, completion, path RMSE, jerk and predicted path over the number of runs, with 95 % intervals."""
    figure = Figure(figsize=(PAGE, 2.7), layout="constrained")
    points = curve.points()
    panels = figure.subplots(1, len(PANELS))
    baseline, error = curve.baseline()
    line = panels[-1].axhline(error.mean, color=METHOD_COLOURS[NOBODY], lw=1.0, ls=":")
    for axes, (label, estimate) in zip(panels, PANELS, strict=True):
        _draw(axes, points, estimate)
        axes.set_xscale("log")
        axes.set_xticks(curve.study.runs, [str(n) for n in curve.study.runs])
        axes.minorticks_off()
        axes.set(xlabel="runs demonstrated", title=label)
        axes.set_ylim(bottom=0)
        axes.grid(axis="y", lw=0.4, color=RULE)
        axes.spines[["top", "right"]].set_visible(False)
    handles, names = panels[0].get_legend_handles_labels()
    handles, names = [*handles, line], [*names, f"{baseline} (last panel)"]
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), frameon=False)
    return figure
