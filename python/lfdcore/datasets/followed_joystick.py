"""The "followed" joystick of a log without commands: the stick that asks for what the vehicle did next.

Sec. 4.2 records the chair's commands beside the driver's input. A robot's log has neither; what it did over the next
second stands in for its commands (cf. the followed input of Sec. 6.2.1). Ours, not the thesis's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import WINDOW, mean_twist
from lfdcore.datasets.safe_joystick import JoystickPairs
from lfdcore.geometry import Twist2

HORIZON = 1.0
"""[s] after a scan whose motion is what was followed"""


def followed_pairs(log: DriveLog, limits: Twist2, horizon: float = HORIZON) -> JoystickPairs:
    """Raw stick and the stick that asks for the mean motion of the next `horizon` s, at the log's scans.

    limits: the motion [m/s, rad/s] that full deflection asks for; faster motion is cut to 1. Scans before the first
    input, without odometry throughout the horizon, or where it has a gap longer than the horizon (and than .5 s) give
    no pair. ValueError for a log without joystick or odometry, and for a horizon or limits that are not positive and
    finite.
    """
    if not 0 < horizon < np.inf:
        raise ValueError(f"horizon is {horizon} s, must be positive and finite")
    if not (0 < limits.linear < np.inf and 0 < limits.angular < np.inf):
        raise ValueError(f"limits are {limits} [m/s, rad/s], must be positive and finite")
    for name in ("joystick", "odometry"):
        if not len(getattr(log, f"{name}_stamp")):
            raise ValueError(f"log {log.name!r} has no {name}, so no pairs of raw and followed input")
    stamp = log.scan_stamp[_covered(log, horizon)]
    followed = mean_twist(log.pose_at(stamp), log.pose_at(stamp + horizon), horizon) / np.array([*limits])
    return JoystickPairs(stamp, log.joystick_at(stamp), np.clip(followed, -1, 1))


def _covered(log: DriveLog, horizon: float) -> NDArray[np.bool_]:
    """(S,) which scans have input, and odometry without a gap until `horizon` s later."""
    now, known = log.scan_stamp, log.odometry_stamp
    first = np.searchsorted(known, now, side="right") - 1
    last = np.searchsorted(known, now + horizon, side="left")
    inside = (first >= 0) & (last < len(known)) & (now >= log.joystick_stamp[0])
    gaps = np.r_[0, np.cumsum(np.diff(known) > max(WINDOW, horizon))]
    return np.asarray(inside & (gaps[np.clip(first, 0, None)] == gaps[np.clip(last, None, len(known) - 1)]))
