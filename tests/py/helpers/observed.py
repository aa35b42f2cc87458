"""Observations for tests, of a chair whose sensors and stick all speak at the same moment."""

from typing import Any

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.wheelchair.observation import Observation


def observed(stamp: float, scan: LaserScan, stick: tuple[float, float], **said: Any) -> Observation:
    """At `stamp`, at rest at the origin, unless `said` says otherwise."""
    stamps = dict.fromkeys(("scan_stamp", "odometry_stamp", "joystick_stamp"), stamp)
    seen = {"stamp": stamp, "scan": scan, "joystick": stick, "pose": Pose2(), "twist": Twist2(), **stamps}
    return Observation(**{**seen, **said})
