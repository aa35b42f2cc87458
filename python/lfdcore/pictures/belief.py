"""Pictures of beliefs over destinations: ellipses on the map (Fig. 2.6), likelihoods (Fig. 2.5, 2.7), confusions (Fig.
2.8), and the belief along a drive as an animation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from lfdcore.datasets.goals import Goals
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.course import Limits, draw_grid
from lfdcore.pictures.goals import square_around
from lfdcore.pictures.style import CONFUSION, FAINT, PAGE, STYLE, series_colour, styled
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import BeliefTrack

Floats = NDArray[np.float64]
INSTANTS = (5.0, 17.0, 25.0, 30.0)
"""[s] of the panels of Fig. 2.6"""
_SIGMAS = 1.0
"""Semi-axes of the ellipses in standard deviations"""
Track = tuple[GoalSamples, BeliefTrack]
"""one drive and the beliefs along it"""


def ellipse_of(mean: Floats, covariance: Floats, colour: str) -> Ellipse:
    """Where the belief N(mean (2,), covariance (2, 2)) has its standard deviation."""
    values, vectors = np.linalg.eigh(covariance)
    width, height = 2 * _SIGMAS * np.sqrt(np.maximum(values, 0))
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    return Ellipse((mean[0], mean[1]), width, height, angle=angle, fill=False, ec=colour, lw=1.6, zorder=4)


def _draw_goals(axes: Axes, goals: Goals) -> None:
    for k, goal in enumerate(goals.goals):
        axes.plot(goal.x, goal.y, "*", color=series_colour(k), ms=12, mec="black", mew=0.6, zorder=5)
        name = axes.annotate(goal.name, (goal.x, goal.y), (6, 5), textcoords="offset points", fontsize=8, zorder=6)
        name.set_path_effects([withStroke(linewidth=2.0, foreground="white")])


def _draw_belief(axes: Axes, track: Track, at: int, colour: str) -> None:
    samples, beliefs = track
    axes.plot(*samples.pose[: at + 1, :2].T, color=colour, lw=1.4, zorder=2)
    axes.plot(*samples.pose[at, :2], "o", color=colour, mec="black", mew=0.5, ms=4.5, zorder=3)
    axes.add_patch(ellipse_of(beliefs.mean[at], beliefs.covariance[at], colour))


def _map_axes(axes: Axes, grid: OccupancyGrid, points: Floats) -> None:
    """The map where the points (N, 2) are."""
    x0, x1, y0, y1 = square_around(points)
    draw_grid(axes, _cropped(grid, (x0, x1, y0, y1)))
    axes.set(xlim=(x0, x1), ylim=(y0, y1))


def _cropped(grid: OccupancyGrid, limits: Limits) -> OccupancyGrid:
    """What of the map lies within limits [m]: the whole of a large one is slow to draw frame by frame."""
    x, y = grid.origin
    ends = np.array(limits) - (x, x, y, y)
    cells = (ends / grid.resolution).astype(int) + np.array([0, 1, 0, 1])
    i0, i1, j0, j1 = np.clip(cells, 0, [grid.width, grid.width, grid.height, grid.height])
    if i0 == i1 or j0 == j1:
        return grid
    data = np.ascontiguousarray(grid.data[j0:j1, i0:i1])
    return OccupancyGrid(data, grid.resolution, (x + i0 * grid.resolution, y + j0 * grid.resolution))


def _points(goals: Goals, tracks: Sequence[Track]) -> Floats:
    return np.concatenate([goals.positions, *(samples.pose[:, :2] for samples, _ in tracks)])


@styled
def belief_figure(
    grid: OccupancyGrid, goals: Goals, tracks: Sequence[Track], instants: Sequence[float] = INSTANTS
) -> Figure:
    """Fig. 2.6: at each instant [s] the ways so far and the beliefs' ellipses, a colour a true destination."""
    columns = 2
    rows, points = -(-len(instants) // columns), _points(goals, tracks)
    figure = Figure(figsize=(PAGE, 0.97 * PAGE / columns * rows), layout="compressed")
    for axes, instant in zip(figure.subplots(rows, columns, squeeze=False).flat, instants, strict=False):
        _map_axes(axes, grid, points)
        _draw_goals(axes, goals)
        for track in tracks:
            at = min(int(np.searchsorted(track[0].stamp, instant)), len(track[0]) - 1)
            _draw_belief(axes, track, at, series_colour(int(track[0].goal[0])))
        axes.set_title(f"{instant:g} s")
    return figure


@styled
def drive_figure(grid: OccupancyGrid, goals: Goals, track: Track) -> Figure:
    """One drive: the belief after each quarter of it on the map, its colour that of the nearest goal, and below the
    likelihood of each goal, the nearest one's in its colour."""
    samples, beliefs = track
    figure = Figure(figsize=(PAGE, 5.2), layout="compressed")
    panels: dict[str, Axes] = figure.subplot_mosaic("0123;llll", height_ratios=[1, 1])
    for quarter in range(4):
        axes, share = panels[str(quarter)], (quarter + 1) / 4
        at = min(int(np.searchsorted(samples.stamp, share * samples.stamp[-1])), len(samples) - 1)
        _map_axes(axes, grid, _points(goals, [track]))
        _draw_goals(axes, goals)
        _draw_belief(axes, track, at, series_colour(int(beliefs.nearest[at])))
        axes.set_title(f"{samples.stamp[at]:.0f} s: {goals.names[beliefs.nearest[at]]}")
        if quarter:
            axes.set(ylabel="", yticklabels=[])
    axes = panels["l"]
    _draw_likelihoods(axes, samples.stamp, beliefs.likelihood, beliefs.nearest)
    axes.set(xlabel="time [s]", ylabel="likelihood")
    for k, name in enumerate(goals.names):
        axes.plot([], [], color=series_colour(k), lw=2.2, label=name)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    return figure


def _draw_likelihoods(axes: Axes, stamp: Floats, likelihood: Floats, likeliest: NDArray[np.int64]) -> None:
    for k in range(likelihood.shape[1]):
        axes.plot(stamp, likelihood[:, k], color=FAINT, lw=0.9, zorder=1)
        mine = likeliest == k
        if mine.any():
            shown = np.where(mine, likelihood[:, k], np.nan)
            axes.plot(stamp, shown, color=series_colour(k), lw=2.2, zorder=2)
    axes.set(ylim=(-0.03, 1.03), xlim=(0, max(float(stamp[-1]), 0.1)))
    axes.tick_params(length=2.5, width=0.6)


@styled
def likelihood_figure(
    goals: Goals, drives: Sequence[tuple[GoalSamples, Floats, NDArray[np.int64]]], what: str = "likelihood"
) -> Figure:
    """Fig. 2.5, 2.7: a panel a drive with each goal's likelihood (T, L) in grey, and in its colour that of the goal
    (T,) that was named. Marks: the instants of Fig. 2.6."""
    columns = min(3, len(drives))
    rows = -(-len(drives) // columns)
    figure = Figure(figsize=(PAGE, 2.2 * rows + 0.5), layout="compressed")
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True)
    for axes, (samples, likelihood, named) in zip(panels.flat, drives, strict=False):
        _draw_likelihoods(axes, samples.stamp, likelihood, named)
        for instant in INSTANTS:
            if instant <= samples.stamp[-1]:
                axes.plot(instant, -0.03, "|", color="black", ms=9, clip_on=False, zorder=5)
        goal = int(samples.goal[0])
        name = goals.names[goal] if goal >= 0 else "?"
        axes.set_title(f"drive to {name}", color=series_colour(goal) if goal >= 0 else "black")
        axes.set_xlabel("time [s]")
    for axes in list(panels.flat)[len(drives) :]:
        axes.set_visible(False)
    for row in panels:
        row[0].set_ylabel(what)
    handles = [figure.axes[0].plot([], [], color=series_colour(k), lw=2.2)[0] for k in range(len(goals))]
    figure.legend(handles, goals.names, loc="outside upper center", ncols=len(goals), frameon=False)
    return figure


@styled
def confusion_figure(goals: Goals, tables: Mapping[str, NDArray[np.int64]]) -> Figure:
    """Fig. 2.8: a panel a method, a row a true goal, a column a named one, shares of the row with counts below."""
    figure = Figure(figsize=(PAGE * len(tables) / 2.4, 4.4), layout="compressed")
    for axes, (method, table) in zip(figure.subplots(1, len(tables), squeeze=False).flat, tables.items(), strict=True):
        share = table / np.maximum(table.sum(axis=1, keepdims=True), 1)
        axes.imshow(share, cmap=CONFUSION, vmin=0, vmax=1)
        for (i, k), value in np.ndenumerate(share):
            ink = "white" if value > 0.55 else "black"
            axes.text(k, i, f"{100 * value:.0f} %\n{table[i, k]}", ha="center", va="center", color=ink, fontsize=7.5)
        names = goals.names
        axes.set(xticks=range(len(names)), yticks=range(len(names)), xticklabels=names, yticklabels=names)
        right = np.trace(table) / max(table.sum(), 1)
        axes.set(title=f"{method}: {100 * right:.0f} % right", xlabel="named", ylabel="true destination")
    return figure


def save_belief_animation(path: Path, grid: OccupancyGrid, goals: Goals, track: Track, fps: int = 10) -> None:
    """The belief along one drive as an animated GIF, two frames a second of the drive, `fps` of them a second."""
    samples, beliefs = track
    wanted = np.append(np.arange(0, samples.stamp[-1], 0.5), samples.stamp[-1])
    frames = np.unique(np.searchsorted(samples.stamp, wanted))
    with matplotlib.style.context(["default", STYLE]):
        figure = Figure(figsize=(PAGE, 4.8), layout="compressed")
        left, right = figure.subplots(1, 2)
        _map_axes(left, grid, _points(goals, [track]))
        _draw_goals(left, goals)
        limits = left.get_xlim(), left.get_ylim()
        fixed = set(left.get_children())

        def draw(frame: int) -> list[object]:
            for artist in [a for a in left.get_children() if a not in fixed]:
                artist.remove()
            at = int(frames[frame])
            _draw_belief(left, track, at, series_colour(int(beliefs.nearest[at])))
            left.set(xlim=limits[0], ylim=limits[1], title=f"{samples.stamp[at]:.1f} s")
            right.clear()
            _draw_likelihoods(right, samples.stamp[: at + 1], beliefs.likelihood[: at + 1], beliefs.nearest[: at + 1])
            right.set(xlim=(0, max(samples.stamp[-1], 0.1)), xlabel="time [s]", ylabel="likelihood")
            return []

        draw(0)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once: anew for each frame takes most of the time
        FuncAnimation(figure, draw, frames=len(frames)).save(path, writer=PillowWriter(fps=fps), dpi=80)  # type: ignore[arg-type]
