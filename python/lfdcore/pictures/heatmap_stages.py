"""Pictures of the stages from a scan and a stick to a path over heatmaps (Fig. 4.6-4.7, 4.9-4.12).

All are drawn in base_link with the chair's front up, over the whole window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import way_ahead
from lfdcore.geometry import Footprint, MotionLimits
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.style import BODY, DIRECTIONS, INK, LANDSCAPE, PAGE, UNKNOWN, Picture, styled
from lfdcore.pictures.window import (
    cover_cells,
    draw_chair,
    draw_dot,
    draw_hits,
    draw_line,
    draw_plan,
    draw_stick,
    draw_window,
    front_axes,
)
from lfdcore.planning import (
    GridMdp,
    MovementTemplate,
    OrientationMoments,
    QLearningSolver,
    UserHeatmap,
    user_heatmap,
)
from lfdcore.training.parts.heatmap_targets import HeatmapPairs, HeatmapTargetConfig, heatmap_pairs
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPath, HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import ChairGeometry, Observation, observations
from lfdcore.wheelchair.surroundings import Surroundings
from lfdcore.wheelchair.window import WINDOW, blocked_mask, border_mask

Array = NDArray[np.float64]

STICKS = (("ahead", (0.8, 0.0)), ("ahead and left", (0.57, 0.57)), ("backwards and right", (-0.4, -0.4)))
_WHOLE = -WINDOW
_SPACING = 2.0  # [m] of way between the scans that Fig. 4.6 is chosen from


def _whole_window(axes: Axes, title: str) -> None:
    front_axes(axes, _WHOLE, WINDOW)
    axes.set(xlim=(WINDOW, -WINDOW), title=title)
    axes.label_outer()


def _heat(axes: Axes, heat: NDArray[np.floating], title: str, stick: Sequence[float] | None = None) -> None:
    draw_window(axes, heat, cmap=LANDSCAPE, vmin=0, vmax=max(float(heat.max()), 1e-9))
    draw_chair(axes, Footprint(), "none", "white")
    if stick is not None:
        draw_stick(axes, stick)
    _whole_window(axes, title)


# ---- Fig. 4.6-4.7 --------------------------------------------------------------------------------------------------


@styled
def sensor_figure(model: HeatmapModel, log: DriveLog, pairs: HeatmapPairs, index: int) -> Figure:
    """A: scan; B: what it sees free, the network's input; C: its target, the demonstrated paths through it; D: what the
    network answers (Fig. 4.6-4.7). `log` is the one of pair `index`."""
    figure = Figure(figsize=(PAGE, 2.9), layout="compressed")
    a, b, c, d = figure.subplots(1, 4, sharey=True)
    draw_hits(a, log.scan(int(pairs.scan[index])), log.mounting)
    draw_chair(a, Footprint())
    _whole_window(a, "A  scan")
    free = pairs.free[index]
    draw_window(b, free.astype(float), cmap="gray", vmin=-0.15, vmax=1)
    draw_chair(b, Footprint(), "none", BODY)
    _whole_window(b, "B  seen free")
    _heat(c, pairs.target[index].astype(np.float32), "C  demonstrated paths")
    _heat(d, model.sensor.predict(free), "D  sensor heatmap")
    return figure


def widest_pair(pairs: HeatmapPairs, among: Sequence[int] = ()) -> int:
    """The pair with the most to choose from, by the sum of its target; of the logs `among`, if that leaves any."""
    total = pairs.target.astype(np.float32).sum(axis=(1, 2))
    own = np.isin(pairs.log, list(among))
    return int(np.argmax(np.where(own, total, 0) if own.any() else total))


# ---- Fig. 4.9-4.10 -------------------------------------------------------------------------------------------------


@styled
def template_figure(template: MovementTemplate) -> Figure:
    """A: the movement template, the stick's orientation that leads to each cell; B: the distance filter (Fig. 4.9)."""
    figure = Figure(figsize=(0.7 * PAGE, 3.4), layout="compressed")
    a, b = figure.subplots(1, 2, sharey=True)
    turned = draw_window(a, np.degrees(template.orientation), cmap=DIRECTIONS, vmin=-180, vmax=180)
    far = draw_window(b, template.distance_filter, cmap=LANDSCAPE, vmin=0, vmax=1)
    for axes, title in ((a, "A  movement template"), (b, "B  distance filter")):
        draw_chair(axes, Footprint(), "none", "white")
        _whole_window(axes, title)
    figure.colorbar(turned, ax=a, shrink=0.85, label="orientation of the stick [°]", ticks=range(-180, 181, 90))
    figure.colorbar(far, ax=b, shrink=0.85, label="weight")
    return figure


@styled
def user_figure(planner: HeatmapPlanner, template: MovementTemplate) -> Figure:
    """A row a stick: the stick, its raw heatmap, the one times the distance filter (Fig. 4.10)."""
    figure = Figure(figsize=(0.72 * PAGE, 7.4), layout="compressed")
    panels = figure.subplots(len(STICKS), 3)
    for row, (name, stick) in zip(panels, STICKS, strict=True):
        moments = planner.orientation(np.array(stick))
        if moments is None:
            raise ValueError(f"the stick {stick} has no orientation")
        _draw_stick_axes(row[0], name, stick, moments)
        user: UserHeatmap = user_heatmap(template, moments)
        _heat(row[1], user.density, "raw heatmap")
        _heat(row[2], user.heatmap, "user heatmap")
        row[1].set_ylabel("x, ahead [m]")
        row[1].tick_params(labelleft=True)  # of its own: the stick's axes beside it are in other units
    return figure


def _draw_stick_axes(axes: Axes, name: str, stick: Sequence[float], moments: OrientationMoments) -> None:
    axes.set(xlim=(1.05, -1.05), ylim=(-1.05, 1.05), xlabel="stick, left", ylabel="stick, ahead")
    axes.set_aspect("equal")
    axes.axhline(0, color=UNKNOWN, lw=0.8)
    axes.axvline(0, color=UNKNOWN, lw=0.8)
    draw_stick(axes, stick, length=1.0)
    sd = np.degrees(np.sqrt(moments.variance))
    mean = round(float(np.degrees(moments.mean)))
    axes.set_title(f"{name}\n{mean}° ± {sd:.0f}°".replace("-", "−"))
    axes.tick_params(length=2.5, width=0.6)


# ---- Fig. 4.11-4.12 ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class HeatMoment:
    """One scan of a log and the path planned there by heatmaps."""

    observation: Observation
    grid: OccupancyGrid
    planner: HeatmapPlanner
    planned: HeatmapPath
    way: Array
    """(N, 2) [m] driven afterwards, in base_link"""


def heat_moment(model: HeatmapModel, log: DriveLog, config: HeatmapPlannerConfig | None = None) -> HeatMoment | None:
    """The scan, of one a second, with a path on the grid after which the driver went farthest aside within 2.5 m; None
    without any."""
    chair = ChairGeometry.thesis(log.mounting)
    planner, around = HeatmapPlanner(model, config or HeatmapPlannerConfig(), chair), Surroundings(chair)
    best, aside, due = None, 0.0, -np.inf
    for now in observations(log):
        obstacles = around.see(now)
        if now.stamp < due or now.twist.linear < 0.1:
            continue
        due = now.stamp + 1.0
        way = way_ahead(log, now.stamp, WINDOW)
        if len(way) < 2 or np.hypot(*way[-1]) < 1.5 or abs(way[-1, 1]) <= aside:
            continue
        grid = around.grid(now)
        planned = planner.plan(now, grid, obstacles)
        if planned is not None and planned.source == "grid":
            best, aside = HeatMoment(now, grid, planner, planned, way), abs(float(way[-1, 1]))
    return best


@styled
def intent_figure(moment: HeatMoment) -> Figure:
    """Sensor heatmap, user heatmap, their product over what is free (Fig. 4.11)."""
    figure = Figure(figsize=(PAGE, 3.6), layout="compressed")
    heat, stick = moment.planned.heat, moment.observation.joystick
    named = (("A  sensor", heat.sensor), ("B  user", heat.user), ("C  product", heat.intent))
    for axes, (title, values) in zip(figure.subplots(1, 3, sharey=True), named, strict=True):
        _heat(axes, values, title, stick if values is heat.user else None)
        cover_cells(axes, moment.grid.occupied_mask(), 1.0)
    return figure


@styled
def q_learning_figure(moment: HeatMoment) -> Figure:
    """A: obstacles, grown; B: reward; C: values after Q-learning with the path, and the way driven (Fig. 4.12)."""
    planned = moment.planned
    blocked = blocked_mask(planned.reward, moment.planner.config.reward.obstacle)
    solver = QLearningSolver(moment.planner.config.q_learning)
    values = np.asarray(solver.solve(GridMdp(planned.reward, blocked)).values())
    figure = Figure(figsize=(PAGE, 3.6), layout="compressed")
    a, b, c = figure.subplots(1, 3, sharey=True)
    draw_window(a, np.where(blocked, 0.45, 1.0), cmap="gray", vmin=0, vmax=1)
    draw_hits(a, moment.observation.scan, moment.planner.chair.T_base_laser)
    draw_chair(a, Footprint())
    _whole_window(a, "A  obstacles, grown")
    inner = ~blocked & ~border_mask()
    for axes, shown, title in ((b, planned.reward, "B  reward"), (c, values, "C  value and path")):
        inside = shown[inner]
        colours = colormaps[LANDSCAPE].with_extremes(bad=INK)
        draw_window(axes, np.where(inner, shown, np.nan), cmap=colours, vmin=0, vmax=float(inside.max()))
        draw_chair(axes, Footprint(), "none", "white")
        cover_cells(axes, moment.grid.occupied_mask(), 1.0)
        _whole_window(axes, title)
    draw_line(c, moment.way, "white", 1.1, ls="--", zorder=4.5)
    draw_plan(c, planned.path, zorder=5)
    draw_dot(c, planned.goal, "white", 5.0, mec="black")
    return figure


# ---- all of them ---------------------------------------------------------------------------------------------------


def heatmap_figures(
    model: HeatmapModel,
    demonstrations: Sequence[DriveLog],
    drive: DriveLog,
    config: HeatmapPlannerConfig | None = None,
    origin: str = "",
) -> list[Picture]:
    """Fig. 4.6-4.12. demonstrations: what the model learned from, or some of it; drive: the log whose moment Fig.
    4.11-4.12 show; `origin` says in the captions where that is from. ValueError as heatmap_pairs."""
    planner = HeatmapPlanner(model, config or HeatmapPlannerConfig(), ChairGeometry.thesis())
    template = MovementTemplate(MotionLimits())
    pictures = [_sensor_picture(model, demonstrations)]
    pictures.append(
        Picture(
            template_figure(template),
            "As Fig. 4.9. A: movement template: the orientation of the stick (0° ahead, positive to the left) whose "
            "arc leads through a cell; ahead by arcs driven forward, behind by arcs driven backwards. B: distance "
            "filter: the farther along an arc, the more. White: the chair.",
        )
    )
    pictures.append(
        Picture(
            user_figure(planner, template),
            "As Fig. 4.10. Left: three sticks, with mean and standard deviation of the orientation that is meant, by "
            f"the Gaussian processes and a driver's own {np.degrees(planner.config.driver_sd):.0f}°. Centre: raw "
            "heatmap from the movement template. Right: times the distance filter. Yellow: the maximum of each.",
        )
    )
    moment = heat_moment(model, drive, config)
    if moment is not None:
        at = f"{origin} Log {drive.name}, scan at {moment.observation.stamp:.1f} s, from which the driver then went "
        at += "farthest aside."
        pictures += _moment_pictures(moment, at.strip())
    return pictures


def _sensor_picture(model: HeatmapModel, demonstrations: Sequence[DriveLog]) -> Picture:
    pairs = heatmap_pairs(demonstrations, HeatmapTargetConfig(spacing=_SPACING))
    names = [log.name for log in demonstrations]
    held_out = model.metadata.get("held_out", []) if model.metadata.get("logs") == names else []
    index = widest_pair(pairs, held_out)
    log = demonstrations[int(pairs.log[index])]
    known = "held out of training" if int(pairs.log[index]) in held_out else "one that may have been trained on"
    return Picture(
        sensor_figure(model, log, pairs, index),
        "As Fig. 4.6-4.7. A: scan. B: the cells that it sees free (white), the network's input. C: all demonstrated "
        "paths through them that lead away, ends twice as hot, smoothed: its target. D: the network's answer. Yellow: "
        f"1. Of {len(pairs)} scans of {len(demonstrations)} drives the one with most heat in its target; log "
        f"{log.name}, {known}.",
    )


def _moment_pictures(moment: HeatMoment, at: str) -> list[Picture]:
    discount = moment.planner.config.q_learning.discount
    return [
        Picture(
            intent_figure(moment),
            "As Fig. 4.11. A: sensor heatmap; B: user heatmap of the stick (arrow); C: their product over the cells "
            f"known to be free. Obstacles in white. {at}",
        ),
        Picture(
            q_learning_figure(moment),
            "As Fig. 4.12. A: what was hit (dots) and the obstacles of the rolling map, grown (grey). B: reward, "
            f"blocked cells and the penalised border dark. C: values after Q-learning (discount {discount:g}) with "
            f"the path (orange) to the local maximum (dot), and the way that was then driven (dashed). {at}",
        ),
    ]
