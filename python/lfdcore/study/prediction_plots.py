"""Predictions along a real log (Fig. 3.16): the map that its scans make, the way driven and the paths predicted."""

from __future__ import annotations

import cv2
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Pose2, arc_length
from lfdcore.grid import OccupancyGrid
from lfdcore.study.path_error import REACH, at_arc_lengths, path_errors, path_samples
from lfdcore.study.plots import PAGE, draw_grid, line_handle, styled
from lfdcore.study.report import Picture
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.local_paths import beam_geometry
from lfdcore.wheelchair.model_file import DriveAssistantModel
from lfdcore.wheelchair.path_prediction import PathPredictor

Array = NDArray[np.float64]

GOOD, FAIR = 0.2, 0.5
"""[m] mean distance over 2.5 m up to which a predicted path is drawn green, orange; red beyond."""
COLOURS = ("#1a9850", "#f39c12", "#d62828")
SPACING = 2.0
"""[m] of the way between the predictions that are drawn."""
_REACH = 12.0  # [m] of a beam that is drawn into the map
_STEP = 0.3  # [m] of the way between scans that are drawn into the map
_OCCUPIED = 0.4  # beams ended in a cell for each scan whose beams passed through it
_MARGIN = 2.0
_MOST_CELLS = 2000


def scans_to_map(log: DriveLog, resolution: float = 0.08) -> OccupancyGrid:
    """The map that a log's scans make at its own odometry: free where beams passed, occupied where enough of them
    ended, -1 unseen. One scan every .3 m, beams up to 12 m; cells are larger than `resolution` [m] where more than 2000
    of them would be needed a side."""
    beams, poses = beam_geometry(log), log.pose_at(log.scan_stamp)
    way = arc_length(poses[:, :2])
    chosen = np.unique(np.searchsorted(way, np.arange(0, way[-1] + 1e-9, _STEP)).clip(0, len(way) - 1))
    reach = _REACH + float(np.hypot(log.T_base_laser.x, log.T_base_laser.y)) + resolution
    low, high = poses[:, :2].min(axis=0) - reach, poses[:, :2].max(axis=0) + reach
    resolution = max(resolution, float((high - low).max()) / _MOST_CELLS)
    width, height = np.ceil((high - low) / resolution).astype(int)
    passed, ended = np.zeros((height, width), np.int32), np.zeros((height, width), np.int32)
    for k in chosen:
        _count_scan(log, k, beams, Pose2(*poses[k]), (low, resolution), (passed, ended))
    seen = passed + ended > 0
    data = np.where(seen, np.where(ended >= _OCCUPIED * passed, 100, 0), -1).astype(np.int8)
    return OccupancyGrid(data, resolution, (float(low[0]), float(low[1])))


def _count_scan(
    log: DriveLog,
    k: int,
    beams: BeamGeometry,
    T_odom_base: Pose2,
    frame: tuple[Array, float],
    counts: tuple[NDArray[np.int32], NDArray[np.int32]],
) -> None:
    """Adds one scan to the counts of beams that passed through cells and ended in them."""
    low, resolution = frame
    ranges = np.where(np.isnan(log.ranges[k]), 0, np.minimum(log.ranges[k], min(_REACH, log.range_max)))
    fan = np.vstack([[log.T_base_laser.x, log.T_base_laser.y], beams.hits(ranges, np.inf)])
    ends = beams.hits(np.where(log.ranges[k] < _REACH, log.ranges[k], np.inf), log.range_max)
    seen, hit = (np.floor((T_odom_base.transform(p) - low) / resolution).astype(np.int32) for p in (fan, ends))
    (x0, y0), (x1, y1) = seen.min(axis=0), seen.max(axis=0) + 1
    mask = np.zeros((y1 - y0, x1 - x0), np.uint8)
    cv2.fillPoly(mask, [seen - (x0, y0)], (1,))
    counts[0][y0:y1, x0:x1] += mask
    np.add.at(counts[1], (hit[:, 1], hit[:, 0]), 1)


def _predictions(model: DriveAssistantModel, log: DriveLog) -> tuple[list[Array], Array]:
    """Predicted paths (M, 2) [m] in odom about every 2 m of the way, and each one's error [m] over 2.5 m."""
    predictor, samples = PathPredictor(model), path_samples(log)
    sticks, poses = log.joystick_at(log.scan_stamp), log.pose_at(log.scan_stamp)
    way = arc_length(poses[:, :2])
    paths, errors, last = [], [], -np.inf
    for scan, driven in zip(samples.scan, samples.driven, strict=True):
        if way[scan] - last < SPACING:
            continue
        path = predictor.predict(sticks[scan], log.scan(scan), log.T_base_laser)
        if path is not None:
            last = way[scan]
            paths.append(Pose2(*poses[scan]).transform(path))
            errors.append(path_errors(at_arc_lengths(path)[None], driven[None], REACH)[0])
    return paths, np.array(errors)


@styled
def prediction_figure(log: DriveLog, paths: list[Array], errors: Array) -> Figure:
    """A log's map, the way driven and predicted paths (M, 2) [m] in odom, coloured by their errors (M,) [m]."""
    grid = scans_to_map(log)
    low, high = log.pose[:, :2].min(axis=0) - _MARGIN * 2, log.pose[:, :2].max(axis=0) + _MARGIN * 2
    width, height = high - low
    scale = min((PAGE - 0.6) / width, 8.0 / height)
    figure = Figure(figsize=(scale * width + 0.6, scale * height + 0.6), layout="compressed")
    axes = figure.subplots()
    draw_grid(axes, grid)
    axes.plot(*log.pose[:, :2].T, color="#111111", lw=0.9, zorder=2)
    rank = np.digitize(errors, (GOOD, FAIR))
    handles = [line_handle("#111111", "driven, by odometry", 1.0)]
    for k, text in enumerate((f"predicted, within {GOOD} m", f"within {FAIR} m", f"beyond {FAIR} m")):
        own = [path for path, r in zip(paths, rank, strict=True) if r == k]
        axes.add_collection(LineCollection(own, colors=COLOURS[k], linewidths=1.5, zorder=3))
        handles.append(line_handle(COLOURS[k], f"{text} (n {len(own)})"))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    figure.legend(handles=handles, loc="outside lower center", ncols=2 if width < height else 4, frameon=False)
    return figure


def prediction_picture(model: DriveAssistantModel, log: DriveLog, origin: str = "") -> Picture:
    """Fig. 3.16 for a log with a joystick, recorded or inferred. `origin` says in the caption what the log is."""
    paths, errors = _predictions(model, log)
    mean = f"{errors.mean():.2f} m" if len(errors) else "-"
    caption = (
        f"As Fig. 3.16: paths predicted a posteriori along a log, one about every {SPACING:g} m of the way where the "
        f"next {REACH:g} m were driven without reversing (n {len(paths)}; mean distance to the way driven {mean} over "
        f"{REACH:g} m). The map is what the log's own scans make at its odometry. {origin or f'Log {log.name}.'}"
    )
    return Picture(prediction_figure(log, paths, errors), caption)
