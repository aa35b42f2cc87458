"""ROS 2 bags as other robots write them, message by message: what is not said is usual."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from lfdcore.datasets import ros_messages as ros
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan

EPOCH = 1_700_000_000_000_000_000
TICK = 100_000_000
"""[ns]"""

Message = tuple[str, str, int, Any]
"""topic, type, received [ns], message"""
Messages = list[Message]


def write_ros2(path: Path, messages: Messages, plugin: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    store = ros.typestore()
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, at, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], at, store.serialize_cdr(message, kind))
    return path


def _stamp(header: Any, nanoseconds: int) -> None:
    header.stamp.sec, header.stamp.nanosec = divmod(max(nanoseconds, 0), 1_000_000_000)


def scan(
    tick: int,
    ranges: ArrayLike,
    *,
    frame: str = "laser",
    angle_min: float = -math.pi / 2,
    increment: float = math.pi / 180,
    angle_max: float | None = None,
    range_min: float = 0.05,
    range_max: float = 30.0,
    header: int = 0,
) -> Message:
    """A LaserScan at a tick, whose header is off from its receipt by so much [ns]."""
    at = EPOCH + tick * TICK
    message = ros.scan_message(at, LaserScan([1.0] * len(np.asarray(ranges)), 0.0, 1.0))
    message.ranges = np.asarray(ranges, np.float32)
    message.angle_min, message.angle_increment = angle_min, increment
    message.angle_max = angle_min + (len(message.ranges) - 1) * increment if angle_max is None else angle_max
    message.range_min, message.range_max = range_min, range_max
    message.header.frame_id = frame
    _stamp(message.header, at + header)
    return "/scan", "sensor_msgs/msg/LaserScan", at, message


def odometry(
    tick: int,
    pose: Sequence[float],
    *,
    base: str = "base_link",
    frame: str = "odom",
    turned: Sequence[float] | None = None,
    header: int = 0,
) -> Message:
    at = EPOCH + tick * TICK
    message = ros.odometry_message(at, Pose2(*pose), Twist2(0.5, 0.0))
    message.child_frame_id, message.header.frame_id = base, frame
    if turned is not None:
        rotation = message.pose.pose.orientation
        rotation.x, rotation.y, rotation.z, rotation.w = turned
    _stamp(message.header, at + header)
    return "/odom", "nav_msgs/msg/Odometry", at, message


def joy(tick: int, axes: Sequence[float], *, header: int = 0) -> Message:
    """Axes (left, forward), as joy drivers order them."""
    at = EPOCH + tick * TICK
    message = ros.joystick_message(at, 0.0, 0.0)
    message.axes = np.asarray(axes, np.float32)
    _stamp(message.header, at + header)
    return "/joy", "sensor_msgs/msg/Joy", at, message


def twist(tick: int, linear: float, topic: str = "/cmd_vel") -> Message:
    at = EPOCH + tick * TICK
    return topic, "geometry_msgs/msg/Twist", at, ros.command_message(at, Twist2(linear, 0.0)).twist


def transform(
    parent: str,
    child: str,
    place: Sequence[float],
    turns: Sequence[float],
    *,
    topic: str = "/tf_static",
    at: int = 0,
) -> Message:
    """A place (x, y, z) [m], and turns (roll, pitch, yaw) [rad]."""
    received = EPOCH + at * TICK
    message = ros.transform_message(received, parent, child, Pose2(place[0], place[1], 0.0))
    move = message.transforms[0].transform
    move.translation.z = place[2]
    half = [angle / 2 for angle in turns]
    (cr, cp, cy), (sr, sp, sy) = [math.cos(h) for h in half], [math.sin(h) for h in half]
    rotation = move.rotation
    rotation.x, rotation.y = sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy
    rotation.z, rotation.w = cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy
    return topic, "tf2_msgs/msg/TFMessage", received, message
