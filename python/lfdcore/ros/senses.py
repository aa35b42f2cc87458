"""What comes in on the topics: the newest of each, with the stamp at which its source said so."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from lfdcore.datasets.frame_tree import nanoseconds
from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan
from lfdcore.ros.frames import Frames
from lfdcore.ros.messages import motion_of, scan_of, stick_of
from lfdcore.ros.odometry_buffer import Motion, OdometryBuffer


class Scan(NamedTuple):
    """A scan and where it was taken."""

    stamp: int
    """[ns]"""
    scan: LaserScan
    pose: Pose2
    """T_odom_base when it was taken"""


class Stick(NamedTuple):
    """A stick and when it said where it is."""

    stamp: int
    """[ns]"""
    joystick: tuple[float, float]
    """(forward, left), NaN for an axis that is not there"""


class Senses:
    """Takes in messages from any thread; asked by the loop.

    axes: of (forward, left) in Joy. now: the node's clock [ns]. complain: takes what people must know.
    """

    def __init__(self, axes: tuple[int, int], now: Callable[[], int], complain: Callable[[str], None]) -> None:
        self._axes, self._now, self._complain = axes, now, complain
        self._lock = threading.Lock()
        self._odometry = OdometryBuffer()
        self._frames: Frames | None = None
        self._mirrored = False
        self._handed: Scan | None = None
        self._handed_message: Any = None
        self.scan_message: Any = None
        """The newest sensor_msgs/LaserScan; None: none yet"""
        self.odometry_message: Any = None
        """The newest nav_msgs/Odometry; None: none yet"""
        self.joystick_message: Any = None
        """The newest sensor_msgs/Joy; None: none yet"""
        self._stick: Stick | None = None

    def settle(self, frames: Frames, *, mirrored: bool) -> None:
        """From now on only messages of these frames are listened to."""
        with self._lock:
            self._frames, self._mirrored = frames, mirrored
            self._odometry = OdometryBuffer()

    def take_scan(self, message: Any) -> None:
        """A sensor_msgs/LaserScan came."""
        with self._lock:
            if self._frames is None or self._is_of("scan", message.header.frame_id, self._frames.scan):
                self.scan_message = message

    def take_odometry(self, message: Any) -> None:
        """A nav_msgs/Odometry came."""
        with self._lock:
            frames = self._frames
            if frames is not None and not (
                self._is_of("odometry", message.header.frame_id, frames.odometry)
                and self._is_of("odometry's child", message.child_frame_id, frames.base)
            ):
                return
            self.odometry_message = message
            self._odometry.add(Motion(nanoseconds(message.header.stamp), *motion_of(message)))

    def take_joystick(self, message: Any, info: Any) -> None:
        """A sensor_msgs/Joy came. One without a stamp is of when it was received, by rclpy's `info`."""
        stamp = nanoseconds(message.header.stamp) or self._received(info)
        with self._lock:
            self.joystick_message = message
            self._stick = Stick(stamp, stick_of(message, self._axes))

    def _received(self, info: Any) -> int:
        """When a message was received [ns], not before the one before: how long it waited is known in wall time, by
        which a simulator's clock need not go."""
        now = self._now()
        stamp = now - max(0, time.time_ns() - info["received_timestamp"])
        before = 0 if self._stick is None else self._stick.stamp
        return before if stamp < before <= now else stamp

    def stick(self) -> Stick | None:
        """The newest; None: nothing yet."""
        return self._stick

    def motion(self) -> Motion | None:
        """What odometry said last; None: nothing yet."""
        with self._lock:
            return self._odometry.newest

    def scan(self) -> Scan | None:
        """The newest scan of which odometry knows where it was taken; None: none yet. As long as it does not know that
        of a newer one, the one before stays, with its own stamp."""
        with self._lock:
            message = self.scan_message
            if message is None or message is self._handed_message:
                return self._handed
            stamp = nanoseconds(message.header.stamp)
            pose = self._odometry.pose_at(stamp)
        if pose is not None:
            self._handed_message, self._handed = message, Scan(stamp, scan_of(message, self._mirrored), pose)
        return self._handed

    def _is_of(self, what: str, frame: str, expected: str) -> bool:
        if frame != expected:
            self._complain(f"{what} is in frame {frame!r}, not in {expected!r} as at the start: not listened to")
        return frame == expected
