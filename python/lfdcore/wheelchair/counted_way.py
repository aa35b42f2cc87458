"""The way of a chair as the encoders at its joystick's link count it, in time (App. A.1)."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque

from lfdcore.geometry import Pose2, Twist2, wrap_angle
from lfdcore.hardware import EncoderOdometry, JoystickReading, WheelEncoders

REMEMBERED = 2.0
"""[s] of poses, for scans that come late"""
FEW_LOST = 10
"""edges lost between two reports, at most"""


class CountedWay:
    """Poses in odom, by stamps of time.monotonic(). wheels: whose encoders count."""

    def __init__(self, wheels: WheelEncoders) -> None:
        self._odometry = EncoderOdometry(wheels)
        self._way: deque[tuple[float, Pose2]] = deque()
        self._last: JoystickReading | None = None

    @property
    def pose(self) -> Pose2:
        """T_odom_base"""
        return self._odometry.pose

    @property
    def twist(self) -> Twist2:
        """[m/s, rad/s]"""
        return self._odometry.twist

    def add(self, reading: JoystickReading) -> bool:
        """-> whether it was counted since the reading before: by the same run of the chip, with no more edges lost
        than a wheel's jitter at standstill makes."""
        last, self._last = self._last, reading
        whole = last is None or (reading.run == last.run and (reading.lost_edges - last.lost_edges) % 65536 <= FEW_LOST)
        if not whole:
            self._odometry.reset()
            self._way.clear()
        self._odometry.update(reading.stamp, *reading.edges)
        if not self._way or reading.stamp > self._way[-1][0]:
            self._way.append((reading.stamp, self.pose))
        while self._way[-1][0] - self._way[0][0] > REMEMBERED:
            self._way.popleft()
        return whole

    def pose_at(self, stamp: float) -> Pose2 | None:
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
