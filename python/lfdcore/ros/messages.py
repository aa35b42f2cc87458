"""What ROS messages say, in our words: what one does not say is NaN or a scan without beams, which stop a chair."""

from __future__ import annotations

import math
from typing import Any

from lfdcore.datasets.frame_tree import UNIT
from lfdcore.datasets.ros_messages import pose_values, twist_values
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan

NO_BEAMS = LaserScan([], 0.0, 1.0)
"""What a scanner says that has said nothing, or nothing that is a scan"""


def scan_of(message: Any, mirrored: bool) -> LaserScan:
    """A sensor_msgs/LaserScan. mirrored: the scanner hangs upside down, its angles grow clockwise as seen from above.

    A message that is no scan (no angle between beams, angles that are not finite) gives one without beams.
    """
    turn = -1.0 if mirrored else 1.0
    try:
        return LaserScan(
            message.ranges,
            turn * message.angle_min,
            turn * message.angle_increment,
            message.range_min,
            message.range_max,
        )
    except ValueError:
        return NO_BEAMS


def motion_of(message: Any) -> tuple[Pose2, Twist2]:
    """T_odom_base and the twist in base_link of a nav_msgs/Odometry; the heading of no rotation is NaN."""
    x, y, yaw = pose_values(message.pose.pose)
    turned = message.pose.pose.orientation
    norm = math.hypot(turned.x, turned.y, turned.z, turned.w)
    return Pose2(x, y, yaw if abs(norm - 1) < UNIT else math.nan), Twist2(*twist_values(message.twist.twist))


def stick_of(message: Any, axes: tuple[int, int]) -> tuple[float, float]:
    """(forward, left) of a sensor_msgs/Joy, NaN where it has no such axis."""
    forward, left = (float(message.axes[k]) if k < len(message.axes) else math.nan for k in axes)
    return forward, left


def fill_twist(message: Any, twist: Twist2) -> None:
    """Writes [m/s, rad/s] into a geometry_msgs/Twist."""
    message.linear.x, message.angular.z = twist.linear, twist.angular


def fill_heading(orientation: Any, yaw: float) -> None:
    """Writes a heading [rad] into a geometry_msgs/Quaternion."""
    orientation.z, orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
