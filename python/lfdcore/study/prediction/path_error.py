"""Path error on a real drive log: what a prediction is worth against the path that was driven, and two baselines.

A sample is a scan at which the robot drives forward (at least .1 m/s over the last half second) and then covers 2.5 m
without reversing (more than 3 cm backwards within three odometry steps) or a gap of 3 s in its odometry. Truth is that
path by raw odometry, in base_link at the scan. Predicted and driven path are compared at equal arc length, every .1 m;
a sample's error is the mean distance over these points. Velocities come from the past only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import mean_twist
from lfdcore.geometry import Pose2, arc_length
from lfdcore.wheelchair.paths import along

Array = NDArray[np.float64]

REACH = 2.5
"""[m]"""
ARC = np.asarray(np.arange(1, 26) * 0.1, np.float64)
"""(25,) arc lengths [m] at which paths are compared"""
REACHES = (1.0, 2.0, 2.5)
"""[m] reported"""
WINDOW = 0.5
"""[s] of odometry before a scan from which its velocity is taken: of this metric, whatever a stick is inferred from"""
SLOWEST = 0.1
"""[m/s]"""
LONGEST_DRIVE = 60.0
"""[s] after a scan within which the path must be covered"""
LONGEST_GAP = 3.0
"""[s] between odometry records"""
REVERSE = 0.03
"""[m]"""


@dataclass(frozen=True)
class PathSamples:
    """N samples of a log."""

    scan: NDArray[np.int_]
    """(N,) index of the scan"""
    velocity: Array
    """(N, 2) [m/s, rad/s] over the last half second"""
    driven: Array
    """(N, 25, 2) [m] the truth at ARC, in base_link at the scan"""

    def __len__(self) -> int:
        return len(self.scan)


def path_samples(log: DriveLog) -> PathSamples:
    """All samples of a log with odometry; none if scans and odometry share no clock or the robot never drives far."""
    stamp, pose = log.odometry_stamp, log.pose.copy()
    pose[:, 2] = np.unwrap(pose[:, 2])
    scans, velocities, paths = [], [], []
    for i, now in enumerate(log.scan_stamp):
        if not stamp[0] + WINDOW <= now < stamp[-1]:
            continue
        here, before = (_pose_at(stamp, pose, t) for t in (now, now - WINDOW))
        velocity = mean_twist(before, here, WINDOW)
        path = _driven_path(stamp, pose, now, here) if velocity[0] >= SLOWEST else None
        if path is not None:
            scans.append(i)
            velocities.append(velocity)
            paths.append(path)
    return PathSamples(
        np.array(scans, int), np.array(velocities).reshape(-1, 2), np.array(paths).reshape(-1, len(ARC), 2)
    )


def _pose_at(stamp: Array, pose: Array, time: float) -> Array:
    return np.array([np.interp(time, stamp, pose[:, k]) for k in range(3)])


def _driven_path(stamp: Array, pose: Array, now: float, here: Array) -> Array | None:
    """(25, 2) [m] at ARC, or None if the drive after `now` is no sample."""
    first = np.searchsorted(stamp, now, side="right")
    last = first + np.searchsorted(stamp[first:], now + LONGEST_DRIVE)
    times = np.r_[now, stamp[first:last]]
    poses = np.vstack([here, pose[first:last]])
    travelled = arc_length(poses[:, :2])
    reached = np.flatnonzero(travelled >= REACH)
    if not len(reached):
        return None
    stop = reached[0] + 1
    if _reverses(poses[:stop]) or np.diff(times[:stop]).max() > LONGEST_GAP:
        return None
    local = Pose2(*here).inverse().transform(poses[:stop, :2])
    grow = travelled[:stop] + np.arange(stop) * 1e-9  # a standing robot must not repeat an abscissa
    return np.stack([np.interp(ARC, grow, local[:, k]) for k in (0, 1)], axis=1)


def _reverses(poses: Array) -> bool:
    step = np.diff(poses[:, :2], axis=0)
    ahead = step[:, 0] * np.cos(poses[:-1, 2]) + step[:, 1] * np.sin(poses[:-1, 2])
    back = [ahead[max(0, k - 3) : k + 1].sum() for k in range(len(ahead))]
    return min(back, default=0.0) < -REVERSE


def straight(velocity: Array) -> Array:
    """Baseline: straight on. velocity (N, 2) -> paths (N, 25, 2) [m]"""
    return np.stack([np.tile(ARC, (len(velocity), 1)), np.zeros((len(velocity), len(ARC)))], axis=2)


def constant_arc(velocity: Array) -> Array:
    """Baseline: the present curvature for ever, cut to 3 1/m. velocity (N, 2) [m/s, rad/s] -> paths (N, 25, 2) [m]"""
    curvature = np.clip(velocity[:, 1] / np.maximum(velocity[:, 0], SLOWEST), -3, 3)[:, None]
    curvature = np.where(np.abs(curvature) < 1e-6, 1e-6, curvature)
    turn = curvature * ARC
    return np.stack([np.sin(turn) / curvature, (1 - np.cos(turn)) / curvature], axis=2)


def at_arc_lengths(path: Array) -> Array:
    """A path (M, 2) from base_link on at ARC -> (25, 2) [m]; one that ends before goes on along its last direction."""
    points = np.vstack([[0.0, 0.0], path]) if np.hypot(*path[0]) > 1e-9 else path
    return along(points, ARC, tail=0.0)


def path_errors(predicted: Array, driven: Array, reach: float) -> Array:
    """Mean distance [m] over the points up to `reach` [m]: paths (N, 25, 2) -> (N,)"""
    if predicted.shape != driven.shape:
        raise ValueError(f"predicted paths have shape {predicted.shape}, must be {driven.shape}")
    return np.asarray(np.linalg.norm(predicted - driven, axis=2)[:, reach + 1e-9 >= ARC].mean(axis=1))
