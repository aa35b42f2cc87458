"""What a drive's odometry says about its driver: velocities and, where none was recorded, the joystick."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.safe_joystick import noted_limits, notes_limits
from lfdcore.geometry import Pose2, Twist2, arc_length, wrap_angle

Array = NDArray[np.float64]

WINDOW = 0.5
"""[s] of odometry behind each velocity: shorter ones show the wheel encoders' and clocks' noise"""
LIMIT_PERCENTILE = 95.0
"""of the speeds above MOVING that counts as full deflection"""
MOVING = 0.05
"""[m/s] and [rad/s] below which a speed says nothing about the limits"""
JUMP, TURN = 0.3, 0.5
"""[m], [rad] by which odometry may be farther than its twists lead to"""
FASTEST, QUICKEST = 3.0, 5.0
"""[m/s], [rad/s] of any chair"""
_PUSHED = 0.2  # of full deflection, from where on a stick tells what full deflection would be


def mean_twist(before: Array, after: Array, span: ArrayLike) -> Array:
    """Of moving from poses (N, 3) to (N, 3) in `span` [s], one or (N,) -> (N, 2) [m/s, rad/s]; yaws without a jump
    between. The distance is taken along the heading in the middle of the turn."""
    step = after - before
    middle = (after[..., 2] + before[..., 2]) / 2
    ahead = step[..., 0] * np.cos(middle) + step[..., 1] * np.sin(middle)
    return np.asarray(np.stack([ahead, step[..., 2]], axis=-1) / np.asarray(span)[..., None])


def windowed_twist(stamp: Array, pose: Array, window: float = WINDOW) -> Array:
    """Mean twist over the last `window` s before each odometry record -> (T, 2) [m/s, rad/s].

    stamp (T,) [s] sorted, pose (T, 3) with continuous yaw. Nothing after a record reaches its twist; the first is 0,
    and the window is shorter near the beginning.
    """
    if not len(stamp):
        return np.zeros((0, 2))
    begin = np.maximum(stamp - window, stamp[0])
    before = np.stack([np.interp(begin, stamp, pose[:, k]) for k in range(3)], axis=1)
    span = stamp - begin
    with np.errstate(over="ignore"):  # a DriveLog refuses the infinite speed by its record
        return mean_twist(before, pose, np.where(span > 0, span, np.inf))


def odometry_jumps(log: DriveLog) -> NDArray[np.bool_]:
    """(T,) whether a record of odometry is farther from the one before than any chair comes in that time (3 m/s, 5
    rad/s), or than twice the twists of both lead to; each with JUMP and TURN to spare. So is odometry that began
    anew."""
    if len(log.odometry_stamp) < 2:
        return np.zeros(len(log.odometry_stamp), bool)
    span, step = np.diff(log.odometry_stamp), np.diff(log.pose, axis=0)
    speed = np.maximum(np.abs(log.twist[1:]), np.abs(log.twist[:-1]))
    way = JUMP + span * np.minimum(FASTEST, 2 * speed[:, 0])
    turn = TURN + span * np.minimum(QUICKEST, 2 * speed[:, 1])
    jumped = (np.hypot(step[:, 0], step[:, 1]) > way) | (np.abs(wrap_angle(step[:, 2])) > turn)
    return np.asarray(np.r_[False, jumped], np.bool_)


def motion_limits(twist: Array) -> Twist2:
    """A driver's own limits [m/s, rad/s] from twists (T, 2).

    95th percentile of the speeds above .05, either way; 1 for a motion that never happens.
    """
    linear, angular = (
        float(np.percentile(speed[speed > MOVING], LIMIT_PERCENTILE)) if (speed > MOVING).any() else 1.0
        for speed in np.abs(twist).T
    )
    return Twist2(linear, angular)


def full_deflection(log: DriveLog) -> Twist2:
    """How fast [m/s, rad/s] the vehicle moves with the stick pushed fully: as the log notes it, else the median of
    velocity (mean over the last half second) by deflection, where that is at least .2 and not cut to 1; the log's own
    limits for a direction in which the stick was never pushed so."""
    if notes_limits(log):
        noted = noted_limits(log)
        return Twist2(noted.max_linear, noted.max_angular)
    twist = windowed_twist(log.odometry_stamp, log.pose)
    own, found = motion_limits(twist), []
    newest = np.searchsorted(log.odometry_stamp, log.joystick_stamp, side="right") - 1
    known = newest >= 0
    for axis, limit in enumerate(own):
        stick, speed = log.joystick[known, axis], twist[newest[known], axis]
        pushed = (np.abs(stick) >= _PUSHED) & (np.abs(stick) < 1)
        if not pushed.any():
            pushed = np.abs(stick) >= _PUSHED
        ratio = float(np.median(speed[pushed] / stick[pushed])) if pushed.any() else limit
        found.append(ratio if ratio > 0 else limit)
    return Twist2(*found)


def joystick_from_motion(log: DriveLog, window: float = WINDOW, limits: Twist2 | None = None) -> DriveLog:
    """The log with the driver's input inferred at its scans; a log whose joystick was recorded is left alone.

    (forward, left) = (v, omega) / limits, where the velocities are the mean over the last `window` s up to the newest
    odometry record at or before the scan, never the future, and `limits` are the log's own unless given
    (`motion_limits`). Faster motion is cut to 1; the metadata count how often. Scans whose newest odometry record is
    older than `window` get no input. ValueError for a window or limits that are not positive.
    """
    if not 0 < window < np.inf:
        raise ValueError(f"window is {window} s, must be positive")
    if limits is not None and not (0 < limits.linear < np.inf and 0 < limits.angular < np.inf):
        raise ValueError(f"limits are {limits} [m/s, rad/s], must be positive")
    if len(log.joystick_stamp):
        return log
    twist = windowed_twist(log.odometry_stamp, log.pose, window)
    limits = limits or motion_limits(twist)
    newest = np.searchsorted(log.odometry_stamp, log.scan_stamp, side="right") - 1
    known = newest >= 0
    known[known] = log.scan_stamp[known] - log.odometry_stamp[newest[known]] <= window
    raw = twist[newest[known]] / np.array([*limits])
    clipped = int((np.abs(raw) > 1).any(axis=1).sum())
    origin = (
        f"inferred from the motion of the last {window:g} s, full deflection at {limits.linear:.3f} m/s and "
        f"{limits.angular:.3f} rad/s, {clipped} of {len(raw)} cut to 1"
    )
    return dataclasses.replace(
        log,
        joystick_stamp=log.scan_stamp[known],
        joystick=np.clip(raw, -1, 1),
        metadata=log.metadata | {"joystick": origin},
    )


def way_ahead(log: DriveLog, stamp: float, reach: float) -> Array:
    """(N, 2) [m]: the way driven after `stamp`, in base_link then, up to `reach` [m] or the log's end."""
    base = Pose2(*log.pose_at([stamp])[0])
    points = np.vstack([[base.x, base.y], log.pose[log.odometry_stamp > stamp, :2]])
    points = points[arc_length(points) <= reach]
    return base.inverse().transform(points)
