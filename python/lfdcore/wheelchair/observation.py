"""What an assistant gets to see and what it answers: scan, odometry and joystick in; a command and its reasons out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import LaserScan

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog


PERIOD = 0.1
"""[s] between ticks, unless a chair says otherwise: the thesis logs at 10 Hz (Sec. 3.5)"""
JITTER = 0.5
"""Share of the period by which a command may come late"""
MOVING = 0.05
"""[m/s] from which the chair counts as moving"""


@dataclass(frozen=True, kw_only=True)
class ChairGeometry:
    """The chair as an assistant knows it. Nothing of it has a default that could be another chair's."""

    footprint: Footprint
    """The outline [m], in base_link"""
    limits: MotionLimits
    T_base_laser: Pose2
    """The scanner's mounting, in base_link"""
    latency: float = 0.1
    """[s] from a command to the first motion that it causes"""
    period: float = PERIOD
    """[s] between two commands. Who drives, watches or supervises this chair takes it from here. More than a second is
    for replays of logs with rare scans; no chair is driven so."""
    scan_period: float = PERIOD
    """[s] between scans"""
    range_noise: float = 0.01
    """Standard deviation of the scanner's ranges [m]"""
    odometry_error: float = 0.02
    """Share of way and turn by which odometry may be wrong"""

    def __post_init__(self) -> None:
        body = self.footprint
        for name, value in (("front", body.front), ("rear", body.rear), ("half_width", body.half_width)):
            if not 0 < value <= 100:
                raise ValueError(f"footprint's {name} is {value} m, must lie in (0, 100]")
        if not all(abs(value) <= 10 for value in self.T_base_laser):
            raise ValueError(f"T_base_laser is {self.T_base_laser}, must be within 10 m of the axle [m, m, rad]")
        if not 0 <= self.latency <= 1:
            raise ValueError(f"latency is {self.latency} s, must lie in [0, 1]")
        if not 0 < self.period <= 10:
            raise ValueError(f"period is {self.period} s, must lie in (0, 10]")
        if not 0 < self.scan_period < math.inf:
            raise ValueError(f"scan_period is {self.scan_period} s, must be finite and > 0")
        if not 0.001 <= self.range_noise <= 0.2:
            raise ValueError(f"range_noise is {self.range_noise} m, must lie in [0.001, 0.2]")
        if not 0 <= self.odometry_error <= 0.5:
            raise ValueError(f"odometry_error is {self.odometry_error}, must be a share in [0, 0.5]")

    @property
    def jitter(self) -> float:
        """[s] by which a command may come late: it holds for period + jitter, after which the chair brakes."""
        return JITTER * self.period

    def require_fit(self, chair: ChairGeometry) -> None:
        """ValueError unless an assistant made for this chair may drive `chair`: outline, limits, mounting and period
        are the same, and `chair` is no slower, noisier or more wrong than this one. A shorter period does not fit
        either: what was tested is a command that acts for just so long."""
        for name in ("footprint", "limits", "T_base_laser", "period"):
            mine, its = getattr(self, name), getattr(chair, name)
            if mine != its:
                raise ValueError(f"the assistant was made for a chair whose {name} is {mine}, but it is {its}")
        for name in ("latency", "scan_period", "range_noise", "odometry_error"):
            mine, its = getattr(self, name), getattr(chair, name)
            if its > mine:
                raise ValueError(f"the assistant was made for a chair whose {name} is {mine}, but it is more: {its}")

    def replayed(self, log: DriveLog) -> ChairGeometry:
        """The same chair in a replay of `log`, where a tick is a scan: it has the usual period of the log's scans."""
        period = usual_period(log.scan_stamp)
        return replace(self, period=period, scan_period=period)

    @staticmethod
    def thesis(T_base_laser: Pose2 | None = None) -> ChairGeometry:
        """The wheelchair of Sec. 3.2, whose scanner stands .70 m ahead of its axle, or elsewhere if given."""
        return ChairGeometry(
            footprint=Footprint(), limits=MotionLimits(), T_base_laser=T_base_laser or Pose2(0.70, 0.0, 0.0)
        )


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One tick of the chair's sensors. Nothing of the world but this reaches an assistant.

    It holds what the sensors say, also what is wrong: an assistant judges that itself (Watch), and stops. A stamp is
    when its source said so, by the clock of `stamp`; None: it has not said anything. Never hand on an old value with a
    new stamp.
    """

    stamp: float
    """Now [s]."""
    scan: LaserScan
    scan_stamp: float | None
    """When the scan was taken [s]."""
    pose: Pose2
    """T_odom_base by odometry."""
    twist: Twist2
    """By odometry [m/s, rad/s]."""
    odometry_stamp: float | None
    """Of pose and twist [s]."""
    joystick: tuple[float, float]
    """(forward, left), each in [-1, 1]."""
    joystick_stamp: float | None
    """When the stick last said where it is [s], also if it had not moved."""
    scan_pose: Pose2 | None = None
    """T_odom_base by odometry when the scan was taken; None: as now."""
    command: Twist2 | None = None
    """What the chair was last commanded [m/s, rad/s], as it says itself; None: it does not say, or is not driven by
    these commands (a replay). Odometry is judged by it."""

    def scan_mounting(self, T_base_laser: Pose2) -> Pose2:
        """Where the scan was taken, in base_link as it stands now."""
        return T_base_laser if self.scan_pose is None else self.pose.inverse() * self.scan_pose * T_base_laser


@dataclass(frozen=True)
class Assistance:
    """An assistant's answer to one observation."""

    command: Twist2
    """What the chair is to do [m/s, rad/s]."""
    mode: str
    """Who decided: 'user', 'path', 'no_path', 'reverse', 'own_turn', 'rest' or 'dwa'; or why the chair stops: 'silent',
    'stale', 'blind', 'late' or 'fault' (see Watch)."""
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


def usual_period(stamps: NDArray[np.float64]) -> float:
    """The median [s] between stamps (T,) [s]; PERIOD where there are fewer than two."""
    return float(np.median(np.diff(stamps))) if len(stamps) > 1 else PERIOD


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
            odometry_stamp=float(log.odometry_stamp[odometry]),
            joystick=(float(log.joystick[joystick, 0]), float(log.joystick[joystick, 1])),
            joystick_stamp=float(log.joystick_stamp[joystick]),
        )
