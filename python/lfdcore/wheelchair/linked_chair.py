"""A real chair: the link to its joystick, its encoders, a scanner (App. A.1). It is a Chair of the drive loop."""

from __future__ import annotations

import math
import time

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.hardware import JoystickLink, JoystickReading
from lfdcore.simulation import joystick_to_twist
from lfdcore.wheelchair.counted_way import CountedWay
from lfdcore.wheelchair.link_trouble import link_trouble
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.scan_sources import ScanSource

NOTHING_SEEN = LaserScan([math.nan], 0.0, 0.01)
"""What a scanner that has not said anything yet has seen"""
UNKNOWN = Pose2(math.nan, math.nan, math.nan)
"""Where the chair is, if nobody counted"""
ANOTHER_CLOCK = 0.02
"""[s] by which the loop's clock and time.monotonic() may differ otherwise than before, until they are compared anew"""


class LinkedChair:
    """Drives what is at the other end of a JoystickLink. Stamps are turned from time.monotonic() to the loop's time.

    link: to the joystick's chip. way: its encoders', the odometry. scans: where scans come from. geometry:
    the chair; its limits are those at full stick in the profile that is selected now. While the chip has another one
    (it forgets its profile when it is reset) the chair stands and this one is selected again.

    Where the chair got to while its edges were not counted is not known: then the pose is NaN once, which is a fault
    that ends at neutral, with nothing left in the map.

    ValueError for a scanner that is mounted elsewhere, or slower, than the geometry says; DeviceError where the chip
    does not say who it is.
    """

    def __init__(self, link: JoystickLink, way: CountedWay, scans: ScanSource, geometry: ChairGeometry) -> None:
        if scans.T_base_laser != geometry.T_base_laser:
            raise ValueError(f"{scans.name} is at {scans.T_base_laser}, the chair's scanner at {geometry.T_base_laser}")
        if scans.scan_period > geometry.scan_period:
            raise ValueError(
                f"{scans.name} has a period of {scans.scan_period:g} s, the chair declares {geometry.scan_period:g} s"
            )
        self.geometry = geometry
        self._link, self._scans = link, scans
        self._percent = link.identity().calibration.profiles
        self._way = way
        self._to_loop: float | None = None
        self._profile: int | None = None
        self._last: JoystickReading | None = None

    def observe(self, stamp: float) -> Observation:
        """What stick, encoders and scanner say, at once. What has never said anything has no stamp."""
        to_loop = self._offset(stamp)
        known = self._read()
        scan, scan_stamp = self._scans.newest() or (NOTHING_SEEN, None)
        last = self._last
        return Observation(
            stamp=stamp,
            scan=scan,
            scan_stamp=None if scan_stamp is None else scan_stamp + to_loop,
            scan_pose=None if scan_stamp is None else self._way.pose_at(scan_stamp),
            pose=self._way.pose if known else UNKNOWN,
            twist=self._way.twist,
            odometry_stamp=None if last is None else last.stamp + to_loop,
            joystick=(0.0, 0.0) if last is None else (last.forward, last.left),
            joystick_stamp=None if last is None else last.stamp + to_loop,
            command=None if last is None else self._given(last),
        )

    def command(self, twist: Twist2, duration: float) -> None:
        """Drives `twist` [m/s, rad/s], as far as the stick allows it, for `duration` [s], .25 at the longest."""
        if self._profile is not None and self._has_another_profile():
            self._link.select_profile(self._profile)
            return self.stop()
        limits = self.geometry.limits
        forward = twist.linear / (limits.max_reverse if twist.linear < 0 else limits.max_linear)
        return self._link.command(forward, twist.angular / limits.max_angular, duration)

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

    @property
    def trouble(self) -> str:
        """Why it stands as far as stick, chip and scanner know, and what to do; empty while it may drive."""
        found = [link_trouble(self._link), self._scans.fault()]
        if self._has_another_profile():
            found.append("the chip has another profile than at the start: it is being selected again")
        return "; ".join(filter(None, found))

    def _given(self, reading: JoystickReading) -> Twist2:
        """What the controller is to do, whose voltages are a profile's share of full output."""
        share = self._percent[reading.profile] / 100
        forward, left = (max(-1.0, min(given / share, 1.0)) for given in (reading.given_forward, reading.given_left))
        return joystick_to_twist(forward, left, self.geometry.limits)

    def _offset(self, stamp: float) -> float:
        """From time.monotonic() to the loop's time [s]: one and the same, so that a stamp that stands, stands still."""
        now = stamp - time.monotonic()
        if self._to_loop is None or abs(now - self._to_loop) > ANOTHER_CLOCK:
            self._to_loop = now
        return self._to_loop

    def _read(self) -> bool:
        """Takes in what the chip has said since -> whether it is known where the chair got to."""
        known = True
        for reading in self._link.take_readings():
            known = self._way.add(reading) and known
            self._last = reading
        if self._profile is None and self._last is not None:
            self._profile = self._last.profile
        return known

    def _has_another_profile(self) -> bool:
        return self._last is not None and self._last.profile != self._profile
