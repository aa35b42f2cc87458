"""What odometry said of late, to know where a scan was taken."""

from __future__ import annotations

from bisect import bisect_left
from typing import NamedTuple

from lfdcore.geometry import Pose2, Twist2, integrate, wrap_angle

KEPT = 2_000_000_000
"""[ns] No scan that is used is older."""
LONGEST_AHEAD = 100_000_000
"""[ns] by which a scan may be younger than all odometry: its pose goes on with the last twist for so long"""


class Motion(NamedTuple):
    """One record of odometry."""

    stamp: int
    """[ns]"""
    pose: Pose2
    """T_odom_base"""
    twist: Twist2
    """[m/s, rad/s]"""


class OdometryBuffer:
    """The records of the last two seconds. One that goes back in time begins anew: a clock was set back."""

    def __init__(self) -> None:
        self._motions: list[Motion] = []

    @property
    def newest(self) -> Motion | None:
        """What odometry said last; None: nothing yet."""
        return self._motions[-1] if self._motions else None

    def add(self, motion: Motion) -> None:
        """Takes in the next record; it replaces one of the same stamp."""
        newest = self.newest
        if newest is not None and motion.stamp < newest.stamp:
            self._motions = []
        elif newest is not None and motion.stamp == newest.stamp:
            self._motions.pop()
        self._motions.append(motion)
        oldest = bisect_left(self._motions, motion.stamp - KEPT, key=_stamp)
        del self._motions[:oldest]

    def pose_at(self, stamp: int) -> Pose2 | None:
        """T_odom_base at `stamp` [ns], interpolated; None where odometry does not reach."""
        after = bisect_left(self._motions, stamp, key=_stamp)
        if after == len(self._motions):
            return self._ahead(stamp)
        if self._motions[after].stamp == stamp:
            return self._motions[after].pose
        return None if after == 0 else _between(self._motions[after - 1], self._motions[after], stamp)

    def _ahead(self, stamp: int) -> Pose2 | None:
        newest = self.newest
        if newest is None or stamp - newest.stamp > LONGEST_AHEAD:
            return None
        return integrate(newest.pose, newest.twist, (stamp - newest.stamp) / 1e9)


def _stamp(motion: Motion) -> int:
    return motion.stamp


def _between(before: Motion, after: Motion, stamp: int) -> Pose2:
    share = (stamp - before.stamp) / (after.stamp - before.stamp)
    a, b = before.pose, after.pose
    turn = float(wrap_angle(b.yaw - a.yaw))
    return Pose2(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.yaw + share * turn)
