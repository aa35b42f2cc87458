"""Pictures of Ch. 2: drives to destinations over their map (Fig. 2.4a)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from lfdcore.geometry import Pose2
from lfdcore.pictures.course import Array, Limits, draw_grid
from lfdcore.pictures.style import PAGE, REFERENCE, WAY, series_colour, styled
from lfdcore.simulated.courses import GoalWorld


@styled
def plot_goal_drives(world: GoalWorld, drives: Sequence[tuple[str, Array]], held_out: Sequence[int] = ()) -> Figure:
    """Drives over the whole map and, larger, where they are (Fig. 2.4a).

    drives: (destination, poses (T, 3) or points (T, 2) [m, map]); held_out: indices of drives to draw dashed. Raises
    ValueError without drives or for a destination that the world does not have.
    """
    if not drives:
        raise ValueError("drives is empty, must hold at least one")
    figure = Figure(figsize=(PAGE, 0.54 * PAGE), layout="constrained")
    whole, near = figure.subplots(1, 2)
    limits = square_around(np.concatenate([*(path[:, :2] for _, path in drives), world.goals.positions]))
    for axes in (whole, near):
        draw_grid(axes, world.grid)
        _draw_drives(axes, world, drives, set(held_out), 0.6 if axes is whole else 1.1)
    x0, x1, y0, y1 = limits
    whole.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=REFERENCE, linewidth=0.8, zorder=4))
    whole.set_title(f"{world.description}: {len(drives)} drives", loc="left")
    near.set(xlim=(x0, x1), ylim=(y0, y1))
    near.set_title("where they are", loc="left")
    _draw_goals(near, world)
    _draw_start(near, world.start)
    near.legend(handles=_legend(bool(held_out)), loc="lower left", framealpha=0.9)
    return figure


def _draw_drives(
    axes: Axes, world: GoalWorld, drives: Sequence[tuple[str, Array]], dashed: set[int], width: float
) -> None:
    for k, (goal, path) in enumerate(drives):
        colour, dashes = series_colour(world.goals.index(goal)), "--" if k in dashed else "-"
        lines = LineCollection([path[:, :2]], colors=colour, linewidths=width, linestyles=dashes, zorder=2)
        axes.add_collection(lines)


def _draw_goals(axes: Axes, world: GoalWorld) -> None:
    for k, goal in enumerate(world.goals.goals):
        right = goal.x >= world.start.x  # the name stands beyond the goal, not on the way to it
        axes.plot(goal.x, goal.y, "o", color=series_colour(k), markeredgecolor="white", markersize=8, zorder=5)
        axes.annotate(
            goal.name,
            (goal.x, goal.y),
            xytext=(7 if right else -7, 5),
            textcoords="offset points",
            horizontalalignment="left" if right else "right",
            color=series_colour(k),
            fontweight="bold",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1},
            zorder=5,
        )


def _draw_start(axes: Axes, start: Pose2) -> None:
    tip = start.transform(np.array([[1.6, 0.0]]))[0]
    arrow = {"arrowstyle": "-|>", "color": "black", "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", tip, (start.x, start.y), arrowprops=arrow, zorder=6)
    axes.plot(start.x, start.y, "s", color="black", markersize=5, zorder=6)


def _legend(held_out: bool) -> list[Line2D]:
    handles = [
        Line2D([], [], color="black", marker="s", markersize=5, linestyle="none", label="start area and heading"),
        Line2D([], [], color=WAY, label="drive to learn from" if held_out else "drive"),
    ]
    return [*handles, Line2D([], [], color=WAY, linestyle="--", label="held out")] if held_out else handles


def square_around(points: Array, margin: float = 3.0) -> Limits:
    """A square around points (N, 2) and `margin` [m] more."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    middle, half = (low + high) / 2, float((high - low).max()) / 2
    return (middle[0] - half, middle[0] + half, middle[1] - half, middle[1] + half)
