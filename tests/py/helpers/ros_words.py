"""ROS 2 messages without ROS: the classes that rosbags makes from the same definitions."""

import math
from typing import Any

import numpy as np

from lfdcore.datasets import ros_messages as ros
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan


def kind(name: str) -> Any:
    return ros.typestore().types[name]


def quaternion(roll: float, pitch: float, yaw: float) -> Any:
    """Roll, then pitch, then yaw about the fixed axes, as URDF has it."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2), math.cos(a / 2)) for a in (roll, pitch, yaw))
    return kind("geometry_msgs/msg/Quaternion")(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def static(parent: str, child: str, xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> Any:
    """A TFMessage with one transform."""
    message = ros.transform_message(0, parent, child, Pose2())
    x, y, z = xyz
    message.transforms[0].transform.translation = kind("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)
    message.transforms[0].transform.rotation = quaternion(*rpy)
    return message


def scan(seconds: float, ranges: list[float] | None = None, frame: str = "laser") -> Any:
    values = np.array([2.0] * 5 if ranges is None else ranges, np.float32)
    message = ros.scan_message(round(seconds * 1e9), LaserScan(values, -1.0, 0.5, 0.1, 30.0))
    message.header.frame_id = frame
    return message


def odometry(seconds: float, pose: Pose2, twist: Twist2 | None = None, child: str = "base_link") -> Any:
    message = ros.odometry_message(round(seconds * 1e9), pose, twist or Twist2())
    message.child_frame_id = child
    return message
