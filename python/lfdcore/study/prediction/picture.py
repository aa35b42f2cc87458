"""The picture of a prediction along a log, as Fig. 3.16: map from the scans, way with footprints, predicted paths."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Footprint, Pose2, arc_length
from lfdcore.grid import OccupancyGrid, read_beams
from lfdcore.pictures.course import draw_footprints, draw_grid, every
from lfdcore.pictures.style import BODY, DISCARDED, DRIVEN, FOLLOWED, PAGE, UNJUDGED, line_handle, styled
from lfdcore.study.prediction.path_error import REACH
from lfdcore.study.prediction.study import LogPrediction, ModelPaths

Array = NDArray[np.float64]

_SEEN = 10.0  # [m] of each beam that are drawn: far hits smear by odometry's drift
_SPACING = 0.25  # [m] or 10 degrees between two scans that are drawn
_LEAST = 2  # scans that must agree
_SIDE = 4000  # cells at most
_MARGIN = 1.5  # [m] around the way and what was near it


def scan_map(log: DriveLog, resolution: float = 0.05) -> OccupancyGrid:
    """All that a log's scans saw up to 10 m away, placed by its odometry alone: occupied where beams of at least 2
    scans and of a fifth of those that came by ended, else free where those of 2 passed, else unknown. Drift shows as
    doubled walls. Scans .25 m or 10 degrees apart count.

    Coarser than `resolution` [m] where the drive is so long that the map had more than 4000 cells on a side.
    """
    used = _spread(log)
    poses = [Pose2(*pose) * log.mounting for pose in log.pose_at(log.scan_stamp[used])]
    angle: Array = log.angle_min + log.angle_increment * np.arange(log.ranges.shape[1], dtype=np.float64)
    lengths, hits = read_beams(log.ranges[used], log.range_min, log.range_max)
    ends = np.array([_ends(pose, length, angle) for pose, length in zip(poses, lengths, strict=True)])
    origins = np.array([[pose.x, pose.y] for pose in poses])
    corner, extent = _extent(np.vstack([origins, ends.reshape(-1, 2)]))
    resolution = max(resolution, float(extent.max()) / _SIDE)
    width, height = (int(n) for n in np.ceil(extent / resolution) + 1)
    passed, hit = np.zeros((height, width), np.float32), np.zeros((height, width), np.float32)
    for origin, end, near in zip(origins, ends, hits & (lengths < _SEEN), strict=True):
        fan = np.vstack([origin, end])
        cells = np.floor((fan - corner) / resolution).astype(np.int32)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        part = np.zeros((high - low)[::-1], np.uint8)
        cv2.fillPoly(part, [cells - low], 1)
        passed[low[1] : high[1], low[0] : high[0]] += part
        hit[tuple(np.unique(cells[1:][near], axis=0).T[::-1])] += 1
    state = np.where(passed >= _LEAST, 0, -1).astype(np.int8)
    state[(hit >= _LEAST) & (hit > 0.2 * passed)] = 100
    return OccupancyGrid(state, resolution, (float(corner[0]), float(corner[1])))


def _spread(log: DriveLog) -> NDArray[np.int_]:
    """Scans that lie .25 m of way or 10 degrees apart, with odometry"""
    covered = (log.scan_stamp >= log.odometry_stamp[0]) & (log.scan_stamp <= log.odometry_stamp[-1])
    scans = np.flatnonzero(covered)
    if not len(scans):
        raise ValueError(f"log {log.name!r} has no scan while its odometry runs: no map can be drawn")
    moved = arc_length(log.pose[:, :2]) / _SPACING
    moved += np.r_[0, np.cumsum(np.abs(np.diff(log.pose[:, 2])))] / np.radians(10)
    stretch = np.floor(np.interp(log.scan_stamp[scans], log.odometry_stamp, moved))
    return scans[np.unique(stretch, return_index=True)[1]]


def _ends(pose: Pose2, lengths: Array, angle: Array) -> Array:
    reach = np.minimum(lengths, _SEEN)[:, None]
    return np.asarray(pose.transform(reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)))


def _extent(points: Array) -> tuple[Array, Array]:
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    return low, high - low


def draw_prediction(axes: Axes, prediction: LogPrediction, model: str, footprint: Footprint, spacing: float) -> None:
    """Map, footprints, way, and the paths predicted every `spacing` [m] of it: green where compliant, else orange;
    light blue for a model that knows no compliance."""
    log, paths = prediction.log, prediction.models[model]
    draw_grid(axes, scan_map(log))
    driven = log.pose[(log.odometry_stamp >= log.scan_stamp[0]) & (log.odometry_stamp <= log.scan_stamp[-1])]
    draw_footprints(axes, every(driven, 1.0), footprint)
    axes.plot(*driven[:, :2].T, color=DRIVEN, lw=1.1, zorder=3)
    shown = _shown(prediction, spacing)
    poses = log.pose_at(log.scan_stamp[prediction.samples.scan[shown]])
    judged = [(np.ones(paths.deviation.shape, bool), UNJUDGED)]
    if paths.compliant is not None:
        judged = [(~paths.compliant, DISCARDED), (paths.compliant, FOLLOWED)]
    for layer, (wanted, colour) in enumerate(judged, 4):
        pieces = []
        for k, pose in zip(shown, poses, strict=True):
            if not paths.missing[k]:
                pieces += _runs(Pose2(*pose).transform(paths.paths[k]), wanted[k])
        axes.add_collection(LineCollection(pieces, colors=colour, linewidths=0.9, alpha=0.8, zorder=layer))


def _shown(prediction: LogPrediction, spacing: float) -> NDArray[np.int_]:
    """Samples about `spacing` [m] of way apart"""
    log = prediction.log
    way = np.interp(log.scan_stamp[prediction.samples.scan], log.odometry_stamp, arc_length(log.pose[:, :2]) / spacing)
    return np.unique(np.floor(way), return_index=True)[1]


def _runs(points: Array, wanted: NDArray[np.bool_]) -> list[Array]:
    """The pieces of a polyline whose points are wanted, each drawn from the point before its first"""
    edges = np.flatnonzero(np.diff(np.r_[0, wanted.astype(int), 0]))
    return [points[max(a - 1, 0) : b] for a, b in edges.reshape(-1, 2) if b - max(a - 1, 0) > 1]


@styled
def prediction_figure(
    predictions: Sequence[LogPrediction], footprint: Footprint | None = None, spacing: float = 0.5
) -> Figure:
    """One panel a log and model. Logs without samples have none; ValueError if that leaves nothing to show."""
    panels = [(p, name) for p in predictions if not p.outcome for name in p.models]
    if not panels:
        raise ValueError("no log has a sample: there is no prediction to draw")
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    width = 0.85 * PAGE if columns == 1 else PAGE / 2
    tall = [width * min(_aspect(prediction), 1.3) + 0.6 for prediction, _ in panels]
    heights = [max(tall[k : k + columns]) for k in range(0, len(tall), columns)]
    figure = Figure(figsize=(columns * width, sum(heights) + 0.5), layout="constrained")
    grid = np.atleast_1d(figure.subplots(rows, columns, height_ratios=heights)).ravel()
    for axes, (prediction, name) in zip(grid, panels, strict=False):
        draw_prediction(axes, prediction, name, footprint or Footprint(), spacing)
        low, high = _shown_window(prediction)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        found = prediction.models[name]
        axes.set_title(f"{prediction.log.name}, {name}\n{_judgement(found)} (n = {len(found.paths)} paths)")
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    unjudged = any(p.models[name].compliant is None for p, name in panels)
    figure.legend(handles=_legend(spacing, unjudged), loc="outside lower center", ncols=2 * columns, frameon=False)
    return figure


def _judgement(found: ModelPaths) -> str:
    share = found.compliant_share
    if share is None:
        return "compliance unknown to this model"
    return f"{100 * share:.0f} % of path points compliant, RMSE of these {found.rmse:.2f} m"


def _shown_window(prediction: LogPrediction) -> tuple[Array, Array]:
    """Corners [m] of 4 m around the way: what lies farther is seldom seen"""
    driven = prediction.log.pose_at(prediction.log.scan_stamp)[:, :2]
    return driven.min(axis=0) - REACH - _MARGIN, driven.max(axis=0) + REACH + _MARGIN


def _aspect(prediction: LogPrediction) -> float:
    low, high = _shown_window(prediction)
    return float((high - low)[1] / (high - low)[0])


def _legend(spacing: float, unjudged: bool) -> list[Line2D]:
    unknown = [line_handle(UNJUDGED, "no compliance known")] if unjudged else []
    return [
        line_handle(DRIVEN, "way driven (odometry)"),
        line_handle(BODY, "footprint, every 1 m"),
        line_handle(FOLLOWED, f"predicted every {spacing:g} m: compliant"),
        line_handle(DISCARDED, "not compliant with any later input"),
        *unknown,
    ]
