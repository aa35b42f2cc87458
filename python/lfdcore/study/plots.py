"""Pictures: courses with footprints, and the stages from input to path (Fig. 3.7-3.16)."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import OccupancyGrid
from lfdcore.study.courses import Course
from lfdcore.study.trace import DriveTrace

mpl.use("Agg")

Array = NDArray[np.float64]
WALL, UNKNOWN = "#3b3f46", "#d9dce1"
GIVEN, FOLLOWED, DISCARDED, CONTACT = "#1f6fb2", "#2a9d4e", "#d9822b", "#d62828"


def draw_grid(axes: Axes, grid: OccupancyGrid) -> None:
    """Walls dark, unknown grey, in metres of the grid's frame."""
    shade = np.ones((grid.height, grid.width, 3))
    shade[grid.data < 0] = mpl.colors.to_rgb(UNKNOWN)
    shade[grid.occupied_mask()] = mpl.colors.to_rgb(WALL)
    x, y = grid.origin
    extent = (x, x + grid.width * grid.resolution, y, y + grid.height * grid.resolution)
    axes.imshow(shade, origin="lower", extent=extent, interpolation="nearest", zorder=0)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")


def footprint_outlines(poses: Array, footprint: Footprint) -> list[Array]:
    """Corners (4, 2) [m] of the chair at each pose (N, 3)."""
    corners = footprint.corners()
    return [Pose2(*pose).transform(corners) for pose in poses]


def draw_footprints(axes: Axes, poses: Array, footprint: Footprint, colour: str = "#8a9099") -> None:
    """Outlines of the chair at poses (N, 3)."""
    axes.add_collection(
        PolyCollection(footprint_outlines(poses, footprint), facecolors="none", edgecolors=colour, linewidths=0.4)
    )


def every(pose: Array, spacing: float) -> Array:
    """The poses (N, 3) about every `spacing` [m] along the way."""
    way = np.r_[0, np.cumsum(np.hypot(*np.diff(pose[:, :2], axis=0).T))]
    return np.asarray(pose[np.searchsorted(way, np.arange(0, way[-1] + 1e-9, spacing)).clip(0, len(pose) - 1)])


def draw_run(axes: Axes, trace: DriveTrace) -> None:
    """One run as Fig. 3.14: footprints, the way, paths as followed (green) and discarded (orange), contacts (red)."""
    draw_footprints(axes, every(trace.pose, 0.7), trace.footprint)
    for k, plan in enumerate(trace.plans[:: max(1, len(trace.plans) // 150)]):
        half = max(2, len(plan.path) // 2)
        axes.plot(
            *plan.path[:half].T, color=DISCARDED, lw=0.5, alpha=0.7, zorder=2, label="paths (first half)" * (k == 0)
        )
    axes.plot(
        trace.pose[:, 0], trace.pose[:, 1], color=FOLLOWED if trace.plans else GIVEN, lw=1.3, zorder=3, label="way"
    )
    hits = trace.pose[trace.collision]
    if len(hits):
        axes.plot(hits[:, 0], hits[:, 1], "x", color=CONTACT, ms=8, mew=2, zorder=4, label="contact begins")


def course_figure(course: Course, traces: Sequence[DriveTrace]) -> Figure:
    """The same course side by side for several runs (Fig. 3.13-3.15, 3.18)."""
    width, height = course.grid.width * course.grid.resolution, course.grid.height * course.grid.resolution
    scale = min(5.2 / width, 8.5 / height)
    columns = len(traces)
    figure = Figure(figsize=(columns * max(scale * width + 0.5, 3.2), scale * height + 1.1), layout="constrained")
    for axes, trace in zip(np.atleast_1d(figure.subplots(1, columns, sharey=True)), traces, strict=True):
        draw_grid(axes, course.grid)
        draw_run(axes, trace)
        hits = int(trace.collision.sum())
        axes.set_title(
            f"{trace.assistant}: {trace.outcome.replace('_', ' ')}, {trace.stamp[-1]:.0f} s, "
            f"{hits} contact{'s' * (hits != 1)}",
            fontsize=10,
        )
        axes.label_outer()
    figure.suptitle(f"{course.name}, driver {traces[0].seed} (simulated, impaired)", fontsize=11)
    return figure
