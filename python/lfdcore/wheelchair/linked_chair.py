"""A real chair: the link to its joystick, its encoders, a scanner (App. A.1). It is a Chair of the drive loop."""

from __future__ import annotations

import math
import time
from bisect import bisect_left
from collections import deque

from lfdcore.geometry import Pose2, Twist2, wrap_angle
from lfdcore.grid import LaserScan
from lfdcore.hardware import EncoderOdometry, JoystickLink, JoystickReading, WheelEncoders
from lfdcore.simulation import joystick_to_twist
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.scan_sources import ScanSource

NOTHING_SEEN = LaserScan([math.nan], 0.0, 0.01)
"""What a scanner that has not said anything yet has seen"""
REMEMBERED = 2.0
"""[s] of poses, for scans that come late"""


class LinkedChair:
    """Drives what is at the other end of a JoystickLink. Stamps are turned from time.monotonic() to the loop's time.

    link: to the joystick's chip. wheels: its encoders, which give the odometry. scans: where scans come from. geometry:
    the chair; its limits are those at full stick in the profile that is selected. ValueError for a scanner that is
    mounted elsewhere, or slower, than the geometry says; DeviceError where the chip does not say who it is.
    """

    def __init__(self, link: JoystickLink, wheels: WheelEncoders, scans: ScanSource, geometry: ChairGeometry) -> None:
        if scans.T_base_laser != geometry.T_base_laser:
            raise ValueError(f"{scans.name} is at {scans.T_base_laser}, the chair's scanner at {geometry.T_base_laser}")
        if scans.scan_period > geometry.scan_period:
            raise ValueError(
                f"{scans.name} has a period of {scans.scan_period:g} s, the chair declares {geometry.scan_period:g} s"
            )
        self.geometry = geometry
        self._link, self._scans = link, scans
        self._percent = link.identity().calibration.profiles
        self._odometry = EncoderOdometry(wheels)
        self._way: deque[tuple[float, Pose2]] = deque()
        self._connections = 0
        self._last: JoystickReading | None = None

    def observe(self, stamp: float) -> Observation:
        """What stick, encoders and scanner say, at once. What has never said anything has no stamp."""
        to_loop = stamp - time.monotonic()
        self._read()
        scan, scan_stamp = self._scans.newest() or (NOTHING_SEEN, None)
        last = self._last
        return Observation(
            stamp=stamp,
            scan=scan,
            scan_stamp=None if scan_stamp is None else scan_stamp + to_loop,
            scan_pose=None if scan_stamp is None else self._pose_at(scan_stamp),
            pose=self._odometry.pose,
            twist=self._odometry.twist,
            odometry_stamp=None if last is None else last.stamp + to_loop,
            joystick=(0.0, 0.0) if last is None else (last.forward, last.left),
            joystick_stamp=None if last is None else last.stamp + to_loop,
            command=None if last is None else self._given(last),
        )

    def command(self, twist: Twist2, duration: float) -> None:
        """Drives `twist` [m/s, rad/s], as far as the stick allows it, for `duration` [s], .25 at the longest."""
        limits = self.geometry.limits
        forward = twist.linear / (limits.max_reverse if twist.linear < 0 else limits.max_linear)
        self._link.command(forward, twist.angular / limits.max_angular, duration)

    def stop(self) -> None:
        """The controller gets its neutral voltage."""
        self._link.command(0.0, 0.0)

    @property
    def manual(self) -> bool:
        """Whether the manual button is pressed: the driver's own input is to go through."""
        return self._last is not None and self._last.manual

    @property
    def emergency(self) -> bool:
        """Whether the emergency input is pressed, or its wire broken."""
        return self._last is not None and self._last.emergency

    def _given(self, reading: JoystickReading) -> Twist2:
        """What the controller is to do, whose voltages are a profile's share of full output."""
        share = self._percent[reading.profile] / 100
        forward, left = (max(-1.0, min(given / share, 1.0)) for given in (reading.given_forward, reading.given_left))
        return joystick_to_twist(forward, left, self.geometry.limits)

    def _read(self) -> None:
        reading = self._link.read()
        if reading is None:
            return
        connections = self._link.statistics.connections
        if connections != self._connections:
            self._odometry.reset()
        self._connections, self._last = connections, reading
        self._odometry.update(reading.stamp, *reading.edges)
        if not self._way or reading.stamp > self._way[-1][0]:
            self._way.append((reading.stamp, self._odometry.pose))
        while self._way[-1][0] - self._way[0][0] > REMEMBERED:
            self._way.popleft()

    def _pose_at(self, stamp: float) -> Pose2 | None:
        """T_odom_base at a stamp [s, monotonic], between two that are known; the nearest end beyond them."""
        if not self._way:
            return None
        stamps = [one[0] for one in self._way]
        after = bisect_left(stamps, stamp)
        if after in (0, len(stamps)):
            return self._way[max(after - 1, 0)][1]
        (t0, p0), (t1, p1) = self._way[after - 1], self._way[after]
        share = (stamp - t0) / (t1 - t0)
        yaw = p0.yaw + share * wrap_angle(p1.yaw - p0.yaw)
        return Pose2(p0.x + share * (p1.x - p0.x), p0.y + share * (p1.y - p0.y), wrap_angle(yaw))
