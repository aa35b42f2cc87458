"""What the messages of a bag's streams say, record by record: one that is odd costs itself, and is counted."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.bag_clocks import Times
from lfdcore.datasets.beam_layout import LONGEST, BeamLayout, Ranges, as_rep_117, require_angles
from lfdcore.datasets.frame_tree import UNIT, frame_name, nanoseconds
from lfdcore.geometry import Pose2

Row = tuple[float, ...]

EXPECTED = 1024, 1_000_000
"""scans for which room is made at first, at least and at most"""
FULL_STICK = 1e-3
"""by which an axis may be beyond 1: -32768 of 32767 is one"""
MOST_ODD = 0.05
"""share of a stream's records that may be odd; else it is not what it seems"""


class Odd:
    """Records that were left out."""

    def __init__(self) -> None:
        self.kinds = Counter[str]()
        """by what was wrong"""
        self.first = ""
        """what was wrong with the first of them, and when"""

    def add(self, kind: str, what: str) -> None:
        """Takes in one."""
        self.kinds[kind] += 1
        self.first = self.first or what

    def noted(self) -> str:
        """For people; empty without any."""
        return ", ".join(f"{count} {kind} left out" for kind, count in sorted(self.kinds.items()))


class Stream(Protocol):
    """A topic in one role."""

    times: Times
    odd: Odd

    def add(self, message: Any, received: int) -> None:
        """Takes in a message that was received at a time [ns]. ValueError for one that shows that the whole stream
        cannot be used."""


def when(message: Any) -> int:
    """[ns] of a message's header; 0 without one"""
    header = getattr(message, "header", None)
    return 0 if header is None else nanoseconds(header.stamp)


class _Frames:
    """The frames that a stream's first message names, and that all others must."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self.first: tuple[str, ...] | None = None

    def require(self, *named: str, stamp: int) -> None:
        names = tuple(map(frame_name, named))
        if self.first is None:
            self.first = names
        if names != self.first:
            raise ValueError(
                f"{self._topic} is of {' and '.join(names)} at {stamp / 1e9:.6f} s, its first message of "
                f"{' and '.join(self.first)}: two publishers share the topic"
            )


class ScanStream:
    """sensor_msgs/LaserScan, on the angles of the first."""

    def __init__(self, topic: str, expected: int) -> None:
        self.times, self.odd = Times(topic), Odd()
        self._frames = _Frames(topic)
        self._layout: BeamLayout | None = None
        self._expected = min(max(expected, EXPECTED[0]), EXPECTED[1])
        self._ranges: Ranges = np.empty((0, 0), np.float32)
        self._count = 0
        self.range_min, self.range_max = 0.0, 0.0
        self.other_angles = 0
        """scans that were put on the first one's angles"""
        self._farthest = 0.0
        self._hits, self._beyond = 0, 0

    @property
    def frame(self) -> str:
        """of the scans"""
        return self._frames.first[0] if self._frames.first else ""

    def add(self, message: Any, received: int) -> None:
        """See Stream."""
        stamp = when(message) or received
        self._frames.require(message.header.frame_id, stamp=stamp)
        try:
            ranges = self._placed(message)
        except ValueError as error:
            return self.odd.add("that are no scan", f"at {stamp / 1e9:.6f} s: {error}")
        self._make_room(len(ranges))
        self._ranges[self._count] = ranges
        self._count += 1
        return self.times.add(when(message), received)

    def _make_room(self, beams: int) -> None:
        if self._count < len(self._ranges):
            return
        more = np.empty((max(self._expected, 3 * self._count // 2), beams), np.float32)
        more[: self._count] = self._ranges[: self._count].reshape(-1, beams)
        self._ranges = more

    def _placed(self, message: Any) -> Ranges:
        ranges = np.asarray(message.ranges, np.float32)
        angles = float(message.angle_min), float(message.angle_increment)
        require_angles(len(ranges), angles[0], float(message.angle_max), angles[1])
        limits = float(message.range_min), _range_max(float(message.range_max))
        if self._layout is None:
            self._layout = BeamLayout(len(ranges), *angles)
            self.range_min, self.range_max = limits
        self.other_angles += (len(ranges), *angles) != (
            self._layout.beams,
            self._layout.angle_min,
            self._layout.angle_increment,
        )
        said = as_rep_117(ranges, *limits)
        self._note(ranges, said)
        return self._layout.put(said, *angles)

    def _note(self, raw: Ranges, said: Ranges) -> None:
        hits = said[np.isfinite(said)]
        self._hits += len(hits)
        self._farthest = max(self._farthest, float(hits.max()) if len(hits) else 0.0)
        self._beyond += int((np.isfinite(raw) & (said == np.inf) & (raw > 0)).sum())

    def fields(self, order: NDArray[np.intp]) -> dict[str, Any]:
        """Of a DriveLog: the scans in this order. ValueError for units that cannot be."""
        assert self._layout is not None
        if self._hits == 0 and self._beyond > 0:
            raise ValueError(
                f"{self.times.topic}: every reading lies at range_max = {self.range_max:g} m or beyond: are the ranges "
                "in millimetres?"
            )
        range_max = self.range_max
        if range_max >= LONGEST:  # none was said
            range_max = float(np.nextafter(np.float32(self._farthest), np.float32(np.inf))) if self._hits else 30.0
        as_written = len(order) == self._count and bool((np.diff(order) == 1).all())
        return {
            "ranges": self._ranges[: self._count] if as_written else self._ranges[order],
            "angle_min": self._layout.angle_min,
            "angle_increment": self._layout.angle_increment,
            "range_min": self.range_min,
            "range_max": range_max,
        }


def _range_max(said: float) -> float:
    """[m]; LONGEST where none is said (inf)"""
    if said == math.inf:
        return LONGEST
    if not said < LONGEST:
        raise ValueError(f"range_max is {said:g} m, must be below {LONGEST:g} m: is it in millimetres?")
    return said


class OdometryStream:
    """nav_msgs/Odometry: rows of x, y [m], yaw [rad], v [m/s], w [rad/s]."""

    def __init__(self, topic: str) -> None:
        self.times, self.odd = Times(topic), Odd()
        self._frames = _Frames(topic)
        self.rows: list[Row] = []

    @property
    def base(self) -> str:
        """The child frame; empty where none is named"""
        return self._frames.first[1] if self._frames.first else ""

    def add(self, message: Any, received: int) -> None:
        """See Stream."""
        stamp = when(message) or received
        self._frames.require(message.header.frame_id, message.child_frame_id, stamp=stamp)
        at, twist = message.pose.pose.position, message.twist.twist
        try:
            yaw = _heading(message.pose.pose.orientation)
        except ValueError as error:
            return self.odd.add("without a heading", f"at {stamp / 1e9:.6f} s: {error}")
        row = (at.x, at.y, yaw, *ros.twist_values(twist))
        if not all(map(math.isfinite, row)):
            return self.odd.add("not finite", f"at {stamp / 1e9:.6f} s: pose and twist are {row}")
        self.rows.append(row)
        return self.times.add(when(message), received)


def _heading(turned: Any) -> float:
    """[rad] of a quaternion message; NaN where it is not finite. ValueError for one that is no rotation."""
    length = math.hypot(turned.x, turned.y, turned.z, turned.w)
    if math.isfinite(length) and abs(length - 1) > UNIT:
        raise ValueError(
            f"the orientation ({turned.x:g}, {turned.y:g}, {turned.z:g}, {turned.w:g}) has length {length:.4g}, must "
            f"be 1 within {UNIT:.0%}: it is no rotation"
        )
    x, y, z, w = (value / length for value in (turned.x, turned.y, turned.z, turned.w))
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class RowStream:
    """Messages of which each gives two numbers."""

    def __init__(self, topic: str, values: Callable[[Any], Row]) -> None:
        self.times, self.odd = Times(topic), Odd()
        self._values = values
        self.rows: list[Row] = []

    def add(self, message: Any, received: int) -> None:
        """See Stream."""
        try:
            row = self._values(message)
        except ValueError as error:
            return self.odd.add("odd", f"at {(when(message) or received) / 1e9:.6f} s: {error}")
        self.rows.append(row)
        return self.times.add(when(message), received)


def joystick_stream(topic: str, axes: tuple[int, int]) -> RowStream:
    """sensor_msgs/Joy: (forward, left) in [-1, 1]; an axis beyond by FULL_STICK at most is at its end."""

    def values(message: Any) -> Row:
        if max(axes) >= len(message.axes):
            raise ValueError(f"it has {len(message.axes)} axes, (forward, left) are said to be {axes}: say --axes")
        said = [float(message.axes[k]) for k in axes]
        if not all(abs(value) <= 1 + FULL_STICK for value in said):
            raise ValueError(f"the axes {axes} are {said}, must lie in [-1, 1]")
        return tuple(max(-1.0, min(value, 1.0)) for value in said)

    return RowStream(topic, values)


def command_stream(topic: str) -> RowStream:
    """geometry_msgs/Twist or TwistStamped: linear [m/s], angular [rad/s]."""

    def values(message: Any) -> Row:
        row = ros.twist_values(getattr(message, "twist", message))
        if not all(map(math.isfinite, row)):
            raise ValueError(f"the twist is {row}, must be finite")
        return row

    return RowStream(topic, values)


def transform_stream(topic: str, said: list[tuple[int, int, Pose2]]) -> RowStream:
    """Poses that /tf says: rows of x, y [m], yaw [rad]."""
    stream = RowStream(topic, lambda row: row)
    for header, received, pose in said:
        stream.rows.append((*pose,))
        stream.times.add(header, received)
    return stream


def require_few_odd(stream: Stream) -> None:
    """ValueError where so many records are odd that the stream is not what it seems."""
    odd = stream.odd.kinds.total()
    count = odd + len(stream.times.headers)
    if odd > max(1, MOST_ODD * count) or odd == count > 0:
        raise ValueError(f"{stream.times.topic} {stream.odd.first} (so it is in {odd} of {count} records)")
