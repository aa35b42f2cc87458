"""Pictures of the stages from a demonstration to a path (Fig. 3.7-3.11).

All are drawn in base_link with the chair's front up: x ahead is the vertical axis, y left the horizontal one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import read_beams
from lfdcore.pictures.course import every, outlines
from lfdcore.pictures.moments import Moment, telling_moments
from lfdcore.pictures.path_primitives import primitives_figure
from lfdcore.pictures.style import (
    BEAM,
    BODY,
    CONTACT,
    DRIVEN,
    FAINT,
    FOLLOWED,
    LANDSCAPE,
    PAGE,
    PLANNED,
    REFERENCE,
    UNKNOWN,
    WALL,
    WAY,
    Picture,
    styled,
    translucent,
)
from lfdcore.pictures.window import (
    cover_cells,
    draw_chair,
    draw_dot,
    draw_hits,
    draw_line,
    draw_plan,
    draw_points,
    draw_stick,
    draw_window,
    front_axes,
)
from lfdcore.planning import DppSolver, GreedyPath, GridMdp, greedy_path
from lfdcore.wheelchair.assistants import DriveAssistantConfig
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.drivable_path import START
from lfdcore.wheelchair.primitives.compliance import ComplianceModel
from lfdcore.wheelchair.primitives.local_paths import REASONS, LocalPaths, beam_geometry, extract_local_paths
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.window import WINDOW, blocked_mask

Array = NDArray[np.float64]

REASON_NAMES = {
    "window": "leaves the window",
    "hidden": "hidden behind its beam",
    "turn": "turned by more than 135°",
    "reverse": "reverses",
    "behind": "behind the axle",
    "rest": "comes to rest",
    "log": "the log ends",
}
# ---- Fig. 3.7 ------------------------------------------------------------------------------------------------------


def example_paths(paths: LocalPaths, most: int = 4) -> list[int]:
    """For each of the first `most` reasons that occur a path that bends more than four of five others."""
    sideways = np.abs(paths.goal[:, 1])
    chosen = []
    for reason in REASONS:
        own = np.flatnonzero(paths.reason == reason)
        if len(own):
            chosen.append(int(own[np.argsort(sideways[own], kind="stable")[len(own) * 4 // 5]]))
    return chosen[:most]


def _drive_around(log: DriveLog, stamp: float, before: float = 8.0, after: float = 25.0) -> Array:
    """(N, 2) [m]: the drive around an instant, in base_link at that instant."""
    times = np.arange(max(stamp - before, log.odometry_stamp[0]), min(stamp + after, log.odometry_stamp[-1]), 0.1)
    return Pose2(*log.pose_at(np.array([stamp]))[0]).inverse().transform(log.pose_at(times)[:, :2])


def _draw_local_path(axes: Axes, log: DriveLog, paths: LocalPaths, index: int, beams: BeamGeometry) -> None:
    scan = int(np.searchsorted(log.scan_stamp, paths.stamp[index]))
    goal, laser = paths.goal[index], log.mounting
    beam = int(beams.locate(goal[None])[0][0])
    angle = laser.yaw + log.angle_min + beam * log.angle_increment
    end = np.array([laser.x, laser.y]) + paths.beam_range[index] * np.array([np.cos(angle), np.sin(angle)])
    draw_hits(axes, log.scan(scan), laser, colour=FAINT, zorder=1)
    border = np.array([[0, -WINDOW], [WINDOW, -WINDOW], [WINDOW, WINDOW], [0, WINDOW], [0, -WINDOW]])
    draw_line(axes, border, REFERENCE, 1.0, ls="--", zorder=2)
    draw_line(axes, _drive_around(log, paths.stamp[index]), DRIVEN, 1.0, zorder=3)
    draw_chair(axes, Footprint())
    draw_line(axes, np.array([[laser.x, laser.y], end]), BEAM, 1.1, zorder=5)
    draw_dot(axes, end, "none", 8.0, mec=BEAM, mew=1.5)
    draw_line(axes, paths.paths[index], PLANNED, 2.4, zorder=5)
    draw_dot(axes, goal, PLANNED, 7.0, mec="black", mew=0.6)
    draw_stick(axes, paths.joystick[index])


@styled
def local_paths_figure(log: DriveLog, paths: LocalPaths) -> Figure:
    """Local paths cut from a demonstration, one for each reason to end it (Fig. 3.7)."""
    chosen = example_paths(paths)
    beams = beam_geometry(log)
    figure = Figure(figsize=(max(4.0, PAGE * len(chosen) / 4), 2.55), layout="compressed")
    for axes, index in zip(figure.subplots(1, len(chosen), sharey=True, squeeze=False)[0], chosen, strict=True):
        _draw_local_path(axes, log, paths, index, beams)
        front_axes(axes)
        axes.label_outer()
        reason = str(paths.reason[index])
        axes.set_title(f"{REASON_NAMES.get(reason, reason)} (n {int((paths.reason == reason).sum())})")
    return figure


# ---- Fig. 3.8 ------------------------------------------------------------------------------------------------------


def _draw_scan(axes: Axes, moment: Moment) -> None:
    scan, laser = moment.observation.scan, moment.chair.T_base_laser
    angle = laser.yaw + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    lengths, _ = read_beams(scan)
    start = np.array([laser.x, laser.y])
    ends = start + np.minimum(lengths, 12.0)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    rays = [np.array([start[::-1], end[::-1]]) for end in ends[::2]]
    axes.add_collection(LineCollection(rays, colors=BEAM, linewidths=0.5, alpha=0.6, zorder=1))
    draw_hits(axes, scan, laser, size=3.5)
    draw_points(axes, moment.obstacles.points, FAINT, size=2.5, zorder=1.5)
    draw_chair(axes, moment.chair.footprint)


@styled
def intention_figure(moment: Moment) -> Figure:
    """A: the scan; B: how likely each cell is where the driver wants to go (Fig. 3.8)."""
    figure = Figure(figsize=(0.82 * PAGE, 3.5), layout="compressed")
    left, right = figure.subplots(1, 2)
    _draw_scan(left, moment)
    draw_stick(left, moment.observation.joystick)
    image = draw_window(right, 1e3 * moment.planned.intention, cmap=LANDSCAPE)
    cover_cells(right, moment.grid.occupied_mask(), 1.0)
    draw_chair(right, moment.chair.footprint, "none", "white")
    draw_stick(right, moment.observation.joystick)
    draw_dot(right, moment.planned.goal, "white", 7.0, mec="black")
    figure.colorbar(image, ax=right, shrink=0.75, label="likelihood of a cell [1/1000]")
    for axes, title in ((left, "A  scan"), (right, "B  intention")):
        front_axes(axes)
        axes.set_title(title)
    return figure


# ---- Fig. 3.10 -----------------------------------------------------------------------------------------------------


def _landscape(moment: Moment) -> tuple[NDArray[np.floating], NDArray[np.bool_], Array]:
    """Values (100, 100) after DPP, the cells it may not enter, and its greedy path (N, 2) [m]."""
    reward, dpp = moment.planned.reward, moment.config.dpp
    blocked = blocked_mask(reward, moment.config.reward.obstacle)
    result = DppSolver(dpp).solve(GridMdp(reward, blocked & dpp.blocked))
    iy, ix = np.unravel_index(int(np.argmax(reward)), reward.shape)
    drawn: GreedyPath = greedy_path(result, START, (int(ix), int(iy)))
    centres = np.array(moment.grid.origin) + (drawn.cells + 0.5) * moment.grid.resolution
    return np.asarray(result.values()), blocked, centres


def _draw_rollout(axes: Axes, moment: Moment) -> None:
    rollout = moment.planned.rollout
    draw_points(axes, moment.obstacles.points, WALL, size=3.5, zorder=3)
    if rollout is not None:
        bodies = [corners[:, ::-1] for corners in outlines(every(rollout.poses, 0.3), moment.chair.footprint)]
        axes.add_collection(PolyCollection(bodies, facecolors="none", edgecolors=BODY, linewidths=0.7, zorder=1))
        if np.isfinite(rollout.time_to_contact):
            touching = outlines(rollout.poses[-1:], moment.chair.footprint)[0][:, ::-1]
            axes.add_patch(Polygon(touching, facecolor=translucent(CONTACT), edgecolor=CONTACT, lw=1.2, zorder=2))
        draw_line(axes, rollout.poses, WAY, 0.9, zorder=2)
    draw_chair(axes, moment.chair.footprint)


@styled
def planning_figure(moment: Moment) -> Figure:
    """A: reward with the scaled primitive; B: values after DPP with its path; C: the pursuit rolled out (Fig. 3.10)."""
    planned = moment.planned
    values, blocked, drawn = _landscape(moment)
    figure = Figure(figsize=(PAGE, 3.2), layout="compressed")
    a, b, c = figure.subplots(1, 3)
    reward = draw_window(a, planned.reward, cmap=LANDSCAPE)
    draw_line(a, planned.primitive, "white", 0.9, ls=(0, (4, 2)), zorder=2)
    free = np.where(blocked, np.nan, values)
    low = float(np.nanpercentile(free, 10))
    value = draw_window(b, np.where(blocked, low, values), cmap=LANDSCAPE, vmin=low)
    draw_plan(b, drawn, zorder=3)
    for axes in (a, b):
        cover_cells(axes, moment.grid.occupied_mask(), 1.0)
        draw_chair(axes, moment.chair.footprint, "none", "white")
        draw_dot(axes, planned.goal, "white", 6.0, mec="black")
    _draw_rollout(c, moment)
    if planned.source == "hybrid_astar":
        draw_line(c, planned.path, FOLLOWED, 1.8, zorder=4.5)
    draw_line(c, drawn, PLANNED, 1.0, zorder=4)
    for image, axes, label, extend in ((reward, a, "reward", "neither"), (value, b, "value", "min")):
        bar = figure.colorbar(image, ax=axes, location="bottom", shrink=0.7, aspect=30, pad=0.03, extend=extend)
        bar.set_label(label)
    for axes, title in ((a, "A  reward and primitive"), (b, "B  value and DPP path"), (c, "C  pursuit rolled out")):
        front_axes(axes)
        axes.set_title(title)
        axes.set_anchor("N")
    return figure


# ---- Fig. 3.11 -----------------------------------------------------------------------------------------------------

STICKS = (("forward", (0.8, 0.0)), ("forward-left", (0.57, 0.57)), ("72° left", (0.25, 0.76)))
"""The last is one of the five orientations of the impaired drivers."""


@styled
def compliance_figure(compliance: ComplianceModel, threshold: float = 0.9) -> Figure:
    """Compliance of control points within the look-ahead for three inputs; the threshold as a line (Fig. 3.11)."""
    figure = Figure(figsize=(0.84 * PAGE, 2.9), layout="compressed")
    panels = figure.subplots(1, 3, sharey=True)
    angle = np.linspace(-np.pi, np.pi, 181)
    reach = compliance.config.look_ahead
    ring = reach * np.stack([np.cos(angle), np.sin(angle)], 1)
    centre = np.linspace(-WINDOW, WINDOW, 101)[:-1] + WINDOW / 100
    for axes, (name, stick) in zip(panels, STICKS, strict=True):
        values = compliance.map(np.array(stick))
        image = draw_window(axes, values, cmap=LANDSCAPE, vmin=0, vmax=1)
        axes.contour(centre, centre, values.T, levels=[threshold], colors="white", linewidths=1.2)
        draw_line(axes, ring, UNKNOWN, 0.8, ls="--")
        draw_chair(axes, Footprint(), "none", "white")
        draw_stick(axes, stick, length=0.6)
        front_axes(axes, -0.95, 0.95)
        axes.label_outer()
        axes.set_title(f"input {name}")
    figure.colorbar(image, ax=panels, shrink=0.85, label="compliance")
    return figure


# ---- all of them ---------------------------------------------------------------------------------------------------


def _planning_caption(moment: Moment) -> str:
    planned = moment.planned
    text = (
        "As Fig. 3.10. A: reward with the primitive scaled to g* (dashed); obstacles as perceived in white, grown in "
        "dark blue. B: values after dynamic policy programming and its greedy path (orange). C: pure pursuit of the "
        "path rolled out with the oriented footprint (grey)"
    )
    if planned.source == "hybrid_astar":
        return f"{text}; it would touch (red), so hybrid A* takes the path's end (green)."
    return f"{text}; it keeps clear of every obstacle point of the rolling map (dark)."


def _end_counts(paths: LocalPaths) -> str:
    counts = {reason: int((paths.reason == reason).sum()) for reason in REASONS}
    return ", ".join(f"{REASON_NAMES.get(reason, reason)} {n}" for reason, n in counts.items() if n)


def stage_figures(
    model: DriveAssistantModel,
    log: DriveLog,
    origin: str = "",
    others: Sequence[DriveLog] = (),
) -> list[Picture]:
    """Fig. 3.7-3.11 from a demonstration log: the moments are chosen by rule (telling_moments).

    `origin` says in the captions where the log is from; `others` are the further logs that the model learned from, for
    the paths behind its primitives. ValueError if the log holds no local path.
    """
    paths = extract_local_paths(log)
    if not len(paths):
        raise ValueError(f"log {log.name!r} holds no local path: there is no stage to draw")
    source = origin or f"Log {log.name}."
    demonstrated = f"All {1 + len(others)} logs." if others else source
    pictures = [
        Picture(
            local_paths_figure(log, paths),
            f"As Fig. 3.7: local paths (orange) cut from the demonstrator's drive (blue), from the chair to where a "
            f"criterion ends them; the stick then (purple), the beam that covers the end (light blue), capped at the "
            f"window (dashed), and what the scan hit (grey). {len(paths)} paths end so: {_end_counts(paths)}. {source}",
        )
    ]
    moments = telling_moments(model, log, paths)
    first = moments.get("grid") or next(iter(moments.values()), None)
    if first is not None:
        at = f"{source} Scan at {first.observation.stamp:.1f} s."
        pictures.append(
            Picture(
                intention_figure(first),
                "As Fig. 3.8. A: the chair, its scan (light blue, hits dark; obstacles remembered from recent scans "
                "grey) and the stick (purple). B: likelihood that the driver wants to get to a cell; the likeliest is "
                f"g* (white dot); obstacles in white. {at}",
            )
        )
    pictures.append(
        Picture(
            primitives_figure(model.primitives, LocalPaths.concatenate([paths, *map(extract_local_paths, others)])),
            f"As Fig. 3.9: the {len(model.primitives)} path primitives that were learned; n counts the paths behind "
            "each, mirror images included. Grey: those paths before they are scaled to their average end, wider where "
            f"they are few, thinned out where they are many. {demonstrated}",
        )
    )
    for moment in moments.values():
        caption = f"{_planning_caption(moment)} {source} Scan at {moment.observation.stamp:.1f} s."
        pictures.append(Picture(planning_figure(moment), caption))
    threshold = DriveAssistantConfig.compliance_threshold
    pictures.append(
        Picture(
            compliance_figure(model.compliance, threshold),
            "As Fig. 3.11: how well control points of pure pursuit comply with an input (arrow). Within the white line "
            f"compliance is at least {threshold:g} and a path is kept; dashed: the look-ahead.",
        )
    )
    return pictures
