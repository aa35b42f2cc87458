"""Pictures of courses: runs side by side with footprints (Fig. 3.13-3.15, 3.18) and demonstrations (Fig. 3.12).

Every function makes a matplotlib Figure without pyplot, in one style whatever the user's matplotlibrc says, so that the
same inputs give the same bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Footprint, Pose2, arc_length
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.style import (
    BODY,
    CONTACT,
    DISCARDED,
    DRIVEN,
    FOLLOWED,
    FREE,
    PAGE,
    PLANNED,
    UNKNOWN,
    WALL,
    WAY,
    line_handle,
    styled,
    translucent,
)
from lfdcore.simulated.courses import Course
from lfdcore.simulated.trace import DriveTrace

Array = NDArray[np.float64]
Limits = tuple[float, float, float, float]
"""x0, x1, y0, y1 [m]"""

ARM_NAMES = {
    "none": "unassisted",
    "dwa": "DWA",
    "primitives": "primitives (learned)",
    "heatmaps": "heatmaps (learned)",
    "heatmaps_thesis": "heatmaps, driven as printed",
    "dwa_1s": "DWA, horizon 1 s",
    "thesis": "primitives, driven as printed",
    "supervisor": "supervisor only",
    "two_way": "heatmaps, both ways",
}
"""Driven as printed: the model is learned by default, not as printed."""
_SMALLEST_SCALE, _SMALLEST_OF_MANY = 0.12, 0.05  # [in/m] of up to 3 panels in a row, and of more
_NARROWEST = 2.5  # [in] of a panel, so that titles do not run into each other


def arm_name(arm: str) -> str:
    """An arm as people call it."""
    return ARM_NAMES.get(arm, arm)


def label_metres(axes: Axes) -> None:
    """Equal aspect, x and y in metres."""
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.tick_params(length=2.5, width=0.6)


def draw_grid(axes: Axes, grid: OccupancyGrid) -> None:
    """Walls dark, unknown and what lies beyond the map grey, in metres of the grid's frame."""
    axes.set_facecolor(UNKNOWN)
    shade = np.full((grid.height, grid.width, 3), to_rgb(FREE))
    shade[grid.data < 0] = to_rgb(UNKNOWN)
    shade[grid.occupied_mask()] = to_rgb(WALL)
    axes.imshow(shade, origin="lower", extent=_extent(grid), interpolation="nearest", zorder=0)
    label_metres(axes)


def _extent(grid: OccupancyGrid) -> Limits:
    x, y = grid.origin
    return (x, x + grid.width * grid.resolution, y, y + grid.height * grid.resolution)


def outlines(poses: Array, footprint: Footprint) -> list[Array]:
    """Corners (4, 2) [m] of the chair at each pose (N, 3)."""
    corners = footprint.corners()
    return [Pose2(*pose).transform(corners) for pose in poses]


def draw_footprints(axes: Axes, poses: Array, footprint: Footprint, edge: str = BODY, face: str = "none") -> None:
    """Outlines of the chair at poses (N, 3)."""
    axes.add_collection(
        PolyCollection(outlines(poses, footprint), facecolors=face, edgecolors=edge, linewidths=0.5, zorder=1.5)
    )


def every(pose: Array, spacing: float) -> Array:
    """The poses (N, 3) about every `spacing` [m] along the way."""
    way = arc_length(pose[:, :2])
    at = np.searchsorted(way, np.arange(0, way[-1] + 1e-9, spacing)).clip(0, len(pose) - 1)
    return np.asarray(pose[at])


def split_plans(trace: DriveTrace) -> tuple[list[Array], list[Array]]:
    """Each plan's followed part, and the first half of what was discarded of it when the next one came (Fig. 3.13).

    The followed part ends at the path's point nearest to the axle when the plan was replaced (or the run ended).
    """
    followed, discarded = [], []
    ends = [*(plan.stamp for plan in trace.plans[1:]), trace.stamp[-1]]
    for plan, end in zip(trace.plans, ends, strict=True):
        tick = min(int(np.searchsorted(trace.stamp, end - 1e-9)), len(trace.pose) - 1)
        at = int(np.argmin(np.hypot(*(plan.path - trace.pose[tick, :2]).T)))
        rest = plan.path[at:]
        followed.append(plan.path[: at + 1])
        discarded.append(rest[: max(2, (len(rest) + 1) // 2)])
    return followed, discarded


def _spread(trace: DriveTrace, spacing: float) -> list[int]:
    """Indices of plans made about every `spacing` [m] of the way."""
    way = arc_length(trace.pose[:, :2])
    chosen: list[int] = []
    last = -np.inf
    for k, plan in enumerate(trace.plans):
        at = way[min(int(np.searchsorted(trace.stamp, plan.stamp - 1e-9)), len(way) - 1)]
        if at - last >= spacing:
            chosen.append(k)
            last = at
    return chosen


def _draw_plans(axes: Axes, trace: DriveTrace, spacing: float) -> None:
    followed, discarded = split_plans(trace)
    shown = [discarded[k] for k in _spread(trace, spacing)]
    axes.add_collection(LineCollection(shown, colors=DISCARDED, linewidths=1.0, zorder=2))
    axes.add_collection(LineCollection(followed, colors=FOLLOWED, linewidths=1.5, zorder=3))


def _draw_window_points(axes: Axes, trace: DriveTrace, spacing: float) -> None:
    """DWA: projected goals and safe control points (Fig. 3.13a)."""
    way = arc_length(trace.pose[:, :2])
    ticks = np.searchsorted(way, np.arange(0, way[-1] + 1e-9, spacing)).clip(0, len(way) - 1)
    for points, colour, size in ((trace.goal, PLANNED, 4.6), (trace.control_point, DRIVEN, 2.4)):
        axes.plot(*points[ticks].T, "o", color=colour, ms=size, mew=0, zorder=3)


def draw_run(axes: Axes, trace: DriveTrace, spacing: float = 0.7) -> None:
    """One run: footprints every `spacing` [m], the way, what its assistant had in mind, contacts (Fig. 3.13-3.15)."""
    draw_footprints(axes, every(trace.pose, spacing), trace.footprint)
    draw_footprints(axes, trace.pose[-1:], trace.footprint, WAY, translucent(WAY))
    axes.plot(*trace.pose[:, :2].T, color=WAY, lw=0.7 if trace.plans else 1.0, zorder=2.5)
    if trace.plans:
        _draw_plans(axes, trace, spacing)
    elif np.isfinite(trace.control_point).any():
        _draw_window_points(axes, trace, spacing)
    hits = trace.pose[trace.collision]
    if len(hits):
        draw_footprints(axes, hits, trace.footprint, CONTACT, translucent(CONTACT))
        axes.plot(*hits[:, :2].T, "x", color=CONTACT, ms=6, mew=1.6, zorder=4)


def _run_title(trace: DriveTrace) -> str:
    hits = int(trace.collision.sum())
    outcome = trace.outcome.replace("_", " ")
    return f"{arm_name(trace.assistant)}\n{outcome}, {trace.stamp[-1]:.0f} s, {hits} contact{'s' * (hits != 1)}"


def _dot(colour: str, label: str, marker: str = "o", size: float = 4.0) -> Line2D:
    return Line2D([], [], color=colour, ls="none", marker=marker, ms=size, mew=1.5 * (marker == "x"), label=label)


def _run_legend(traces: Sequence[DriveTrace]) -> list[Line2D]:
    handles = [_dot(BODY, "footprint", "s"), _dot(WAY, "at the end", "s"), line_handle(WAY, "way of the axle", 1.0)]
    if any(not trace.plans and np.isfinite(trace.control_point).any() for trace in traces):
        handles += [_dot(PLANNED, "DWA: projected goal"), _dot(DRIVEN, "DWA: control point")]
    if any(trace.plans for trace in traces):
        handles += [
            line_handle(FOLLOWED, "path points followed"),
            line_handle(DISCARDED, "discarded (first half)", 0.9),
        ]
    if any(trace.collision.any() for trace in traces):
        handles.append(_dot(CONTACT, "contact begins", "x", 6.0))
    return handles


def _seen(course: Course, traces: Sequence[DriveTrace], margin: float = 1.6) -> Limits:
    """What the pictures show: all ways and the route with a margin, within the map."""
    points = np.vstack([course.route, *(trace.pose[:, :2] for trace in traces)])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    x0, x1, y0, y1 = _extent(course.grid)
    return (max(low[0], x0), min(high[0], x1), max(low[1], y0), min(high[1], y1))


def _columns(panels: int, width: float) -> int:
    """How many panels of `width` [m] stand in a row: as many as stay legible, in rows of about the same length."""
    smallest = _SMALLEST_SCALE if panels <= 3 else _SMALLEST_OF_MANY
    most = max(1, min(panels, int(PAGE / _NARROWEST), int(PAGE / width / smallest)))
    return ceil(panels / ceil(panels / most))


@styled
def course_figure(course: Course, traces: Sequence[DriveTrace]) -> Figure:
    """The same course for several runs, side by side, in rows where they are many or wide (Fig. 3.13-3.15, 3.18)."""
    limits = _seen(course, traces)
    width, height = limits[1] - limits[0], limits[3] - limits[2]
    columns = _columns(len(traces), width)
    rows = ceil(len(traces) / columns)
    scale = min((PAGE / columns - 0.35) / width, 9.0 / height)
    size = (columns * (scale * width + 0.35) + 0.35, rows * (scale * height + 0.9) + 0.4)
    figure = Figure(figsize=(max(size[0], PAGE / 2), size[1]), layout="compressed")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    spacing = max(0.7, course.length / 150)
    for axes, trace in zip(panels, traces, strict=False):
        draw_grid(axes, course.grid)
        draw_run(axes, trace, spacing)
        axes.set(xlim=limits[:2], ylim=limits[2:], title=_run_title(trace))
        axes.label_outer()
    for k in range(len(traces), len(panels)):
        panels[k].remove()
        above = panels[k - columns]
        above.tick_params(labelbottom=True)
        above.set_xlabel("x [m]")
    handles = _run_legend(traces)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, handlelength=1.4)
    return figure


@styled
def demonstrations_figure(courses: Sequence[Course], logs: Sequence[DriveLog]) -> Figure:
    """What was demonstrated in a world (Fig. 3.12): the way of each log, by odometry, from its course's start.

    `courses` and `logs` belong together by position; all courses share one world, the first one's is drawn.
    """
    x0, x1, y0, y1 = _extent(courses[0].grid)
    width = 0.7 * PAGE
    figure = Figure(figsize=(width, width * (y1 - y0) / (x1 - x0) + 0.25), layout="compressed")
    axes = figure.subplots()
    draw_grid(axes, courses[0].grid)
    for course, log in zip(courses, logs, strict=True):
        way = course.start.transform(log.pose[:, :2])
        axes.plot(*way.T, color=DRIVEN, lw=1.0, alpha=0.85)
    axes.set(xlim=(x0, x1), ylim=(y0, y1))
    return figure
