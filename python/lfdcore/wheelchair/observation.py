"""What an assistant gets to see and what it answers: scan, odometry and joystick in; a command and its reasons out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import LaserScan

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog


PERIOD = 0.1
"""[s] between ticks: the thesis logs at 10 Hz (Sec. 3.5)"""
MOVING = 0.05
"""[m/s] from which the chair counts as moving"""
STALE_AFTER = 0.5
"""A scan older than this [s] says nothing of what is around now: every assistant that needs one stops."""


@dataclass(frozen=True, kw_only=True)
class ChairGeometry:
    """The chair as an assistant knows it."""

    footprint: Footprint = field(default_factory=Footprint)
    limits: MotionLimits = field(default_factory=MotionLimits)
    T_base_laser: Pose2 = field(default_factory=lambda: Pose2(0.70, 0.0, 0.0))


@dataclass(frozen=True)
class Observation:
    """One tick of the chair's sensors. Nothing of the world but this reaches an assistant."""

    stamp: float
    """Now [s]."""
    scan: LaserScan
    scan_stamp: float
    """When the scan was taken [s], not later than `stamp`."""
    pose: Pose2
    """T_odom_base by odometry."""
    twist: Twist2
    """By odometry [m/s, rad/s]."""
    joystick: tuple[float, float]
    """(forward, left), each in [-1, 1]."""
    scan_pose: Pose2 | None = None
    """T_odom_base by odometry when the scan was taken; None: as now."""

    @property
    def stale(self) -> bool:
        """Whether the scan is too old to drive by."""
        return self.stamp - self.scan_stamp > STALE_AFTER

    def scan_mounting(self, T_base_laser: Pose2) -> Pose2:
        """Where the scan was taken, in base_link as it stands now."""
        return T_base_laser if self.scan_pose is None else self.pose.inverse() * self.scan_pose * T_base_laser

    def __post_init__(self) -> None:
        scan_pose = self.scan_pose or self.pose
        numbers = (self.stamp, self.scan_stamp, *self.pose, *self.twist, *self.joystick, *scan_pose)
        if not np.isfinite(numbers).all():
            raise ValueError(f"an observation must be finite, has {numbers}")
        if max(map(abs, self.joystick)) > 1 + 1e-6:
            raise ValueError(f"joystick is {self.joystick}, must lie in [-1, 1] on both axes")
        if self.scan_stamp > self.stamp:
            raise ValueError(f"scan_stamp is {self.scan_stamp} s, must not be later than stamp, {self.stamp} s")


@dataclass(frozen=True)
class Assistance:
    """An assistant's answer to one observation."""

    command: Twist2
    """What the chair is to do [m/s, rad/s]."""
    mode: str
    """Who decided: 'user', 'path', 'no_path', 'reverse', 'own_turn', 'rest', 'stale' or 'dwa'."""
    path: NDArray[np.float64] | None = None
    """(N, 2) [m] in odom: the path being followed, None without one."""
    planned: bool = False
    """True on the tick at which `path` was made."""
    goal: tuple[float, float] | None = None
    """The inferred intention g* [m] in odom."""
    likelihood: float = 0.0
    """Of the goal's cell, normalised over the window."""
    compliance: float = 1.0
    """Of the user's input with the control point, in [0, 1] (Sec. 3.4.3)."""
    control_point: tuple[float, float] | None = None
    """Of pure pursuit or DWA [m] in base_link."""
    supervised: bool = False
    """True if the supervisor changed the command."""


def observations(log: DriveLog) -> Iterator[Observation]:
    """The log as an assistant would have lived it: one observation a scan, with odometry and joystick as last known.

    Scans before the first joystick or odometry record are skipped.
    """
    for name in ("odometry", "joystick"):
        if not len(getattr(log, f"{name}_stamp")):
            raise ValueError(f"{log.name} has no {name}, an assistant needs at least one record of it")
    start = max(log.odometry_stamp[0], log.joystick_stamp[0])
    for index, stamp in enumerate(log.scan_stamp):
        if stamp < start:
            continue
        odometry = np.searchsorted(log.odometry_stamp, stamp, side="right") - 1
        joystick = np.searchsorted(log.joystick_stamp, stamp, side="right") - 1
        yield Observation(
            stamp=float(stamp),
            scan=log.scan(index),
            scan_stamp=float(stamp),
            pose=Pose2(*log.pose[odometry]),
            twist=Twist2(*log.twist[odometry]),
            joystick=(float(log.joystick[joystick, 0]), float(log.joystick[joystick, 1])),
        )
