"""The learning curve of study/learning_curve/study.py as a table, a plot and one report.html."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lfdcore.pictures.course import arm_name
from lfdcore.pictures.style import METHOD_COLOURS, PAGE, RULE, Picture, png, styled
from lfdcore.study.learning_curve.study import METHODS, NOBODY, CurvePoint, LearningCurve
from lfdcore.study.prediction.study import STRAIGHT
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import Summary
from lfdcore.study.report.table import Table

Estimate = tuple[float, float, float]
"""figure, and its 95 % interval"""

MARKS = {"primitives": "o", "heatmaps": "s"}
TITLE = "How much demonstration is enough"
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


def _cell(estimate: Estimate, digits: int) -> str:
    value, low, high = estimate
    if np.isnan(value):
        return "-"
    if np.isnan(low):
        return f"{value:.{digits}f}"
    return f"{value:.{digits}f}\n[{low:.{digits}f}, {high:.{digits}f}]"


def _row(point: CurvePoint) -> tuple[str, ...]:
    arrived, n = point.completed
    share, low, high = (100 * value for value in point.completion)
    _, rate_low, rate_high = point.contact_rate
    alone = point.method == NOBODY
    jerk, time = (_cell(_of_summary(ratio), 2) for ratio in (point.jerk_ratio, point.time_ratio))
    return (
        arm_name(point.method).removesuffix(" (learned)"),
        "-" if alone else str(point.demonstrations),
        f"{arrived} of {n}\n{share:.0f} % [{low:.0f}, {high:.0f}]",
        f"{point.contacts} in {n}\n[{rate_low:.2f}, {rate_high:.2f}]",
        _cell(_of_summary(point.path_rmse), 3),
        "1" if alone else jerk,
        "1" if alone else time,
        _cell(_of_summary(point.path_error), 3),
    )


def origin(curve: LearningCurve) -> str:
    """n and seeds of everything."""
    study = curve.study
    first = 1000 * study.seed
    samples = sum(e["samples"] for e in curve.errors if e["method"] == STRAIGHT)
    return (
        f"Demonstrations: the first n of the runs in the mazes, seeds {first}..{first + max(study.runs) - 1}. Closed "
        f"loop: n = {study.drivers} simulated impaired drivers, each on a way of its own in home_20x19, seeds "
        f"{first + 600}..{first + 599 + study.drivers}. Predicted paths: {study.predicted} runs of simulated able "
        f"drivers there, seeds {first + 500}..{first + 499 + study.predicted}, {samples} scans."
    )


def curve_table(curve: LearningCurve) -> Table:
    """A row a method and number of runs."""
    header = (
        "",
        "runs",
        "completed",
        "contacts\n[a run]",
        "path RMSE [m]",
        "angular jerk /\nunassisted",
        "time /\nunassisted",
        "error of predicted\npaths, to 2.5 m [m]",
    )
    note = (
        f"{origin(curve)} In brackets 95 % intervals: of the share Wilson's, of contacts a run Garwood's (Poisson), of "
        "means over drivers and runs Student's. Ratios: means over the drivers who arrived with and without. One "
        "training for each n: the intervals know nothing of what other runs or another start of the network would "
        "have taught."
    )
    name, error = curve.baseline()
    baseline = (f"{name}\n(baseline)", *["-"] * 6, _cell(_of_summary(error), 3))
    return Table(TITLE, header, (*map(_row, curve.points()), baseline), note)


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
            label=arm_name(method).removesuffix(" (learned)"),
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


def write_learning_curve(curve: LearningCurve, folder: Path, command: str = "") -> Path:
    """learning-curve.png, figures.json and report.html in `folder` -> the report's path."""
    figure = curve_figure(curve)
    (folder / "learning-curve.png").write_bytes(png(figure))
    write_figures(folder / "figures.json", [*curve.rows, *curve.errors])
    text = (
        "Models of the first n of 72 runs in two mazes, in a home like neither. All is simulated: drivers, chair, "
        "courses. Bars: 95 % intervals. Dashed: unassisted; dotted: the better of straight on and a constant arc."
    )
    section = Section(TITLE, text, [curve_table(curve)], [Picture(figure, f"{text} {origin(curve)}")])
    made = f"Made by `{command}`" if command else ""
    return write_report(folder / "report.html", TITLE, [section], origin=made)
