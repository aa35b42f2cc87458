"""ROS 2 messages of a drive log: which topic carries which type, and how our values go in and come out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan

TOPICS: Mapping[str, str] = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joy": "sensor_msgs/msg/Joy",
    "/joy_desired": "sensor_msgs/msg/Joy",
    "/cmd_vel": "geometry_msgs/msg/TwistStamped",
    "/plan": "nav_msgs/msg/Path",
    "/intention": "sensor_msgs/msg/PointCloud2",
}
"""Message type by topic."""

_INTENTION_FIELDS = ("x", "y", "z", "likelihood")
_FLOAT64 = 8  # sensor_msgs/PointField.FLOAT64


@lru_cache(maxsize=1)
def typestore() -> Any:
    """ROS 2 Jazzy's message types as rosbags knows them: definitions, classes and CDR serialisation."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


@lru_cache(maxsize=1)
def _types() -> dict[str, Any]:
    return {name.rsplit("/", 1)[1]: kind for name, kind in typestore().types.items() if "/msg/" in name}


def schema(message_type: str) -> bytes:
    """The definition of a message type with all that it uses, as MCAP's encoding ros2msg has it."""
    return str(typestore().generate_msgdef(message_type, ros_version=2)[0]).encode()


def _header(nanoseconds: int, frame: str) -> Any:
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    types = _types()
    return types["Header"](stamp=types["Time"](sec=seconds, nanosec=rest), frame_id=frame)


def _rotation(yaw: float) -> Any:
    return _types()["Quaternion"](x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def _pose(x: float, y: float, yaw: float) -> Any:
    types = _types()
    return types["Pose"](position=types["Point"](x=x, y=y, z=0.0), orientation=_rotation(yaw))


def _twist(twist: Twist2) -> Any:
    types = _types()
    vector = types["Vector3"]
    return types["Twist"](linear=vector(x=twist.linear, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=twist.angular))


def scan_message(nanoseconds: int, scan: LaserScan) -> Any:
    """sensor_msgs/LaserScan in the frame `laser`"""
    last = len(scan.ranges) - 1
    return _types()["LaserScan"](
        header=_header(nanoseconds, "laser"),
        angle_min=scan.angle_min,
        angle_max=scan.angle_min + last * scan.angle_increment,
        angle_increment=scan.angle_increment,
        time_increment=0.0,
        scan_time=0.0,
        range_min=scan.range_min,
        range_max=scan.range_max,
        ranges=scan.ranges,
        intensities=np.zeros(0, np.float32),
    )


def odometry_message(nanoseconds: int, pose: Pose2, twist: Twist2) -> Any:
    """nav_msgs/Odometry: T_odom_base and the twist in base_link; covariances are zero, that is unknown"""
    types = _types()
    return types["Odometry"](
        header=_header(nanoseconds, "odom"),
        child_frame_id="base_link",
        pose=types["PoseWithCovariance"](pose=_pose(pose.x, pose.y, pose.yaw), covariance=np.zeros(36)),
        twist=types["TwistWithCovariance"](twist=_twist(twist), covariance=np.zeros(36)),
    )


def transform_message(nanoseconds: int, parent: str, child: str, transform: Pose2) -> Any:
    """tf2_msgs/TFMessage with the one transform T_parent_child"""
    types = _types()
    stamped = types["TransformStamped"](
        header=_header(nanoseconds, parent),
        child_frame_id=child,
        transform=types["Transform"](
            translation=types["Vector3"](x=transform.x, y=transform.y, z=0.0), rotation=_rotation(transform.yaw)
        ),
    )
    return types["TFMessage"](transforms=[stamped])


def joystick_message(nanoseconds: int, forward: float, left: float) -> Any:
    """sensor_msgs/Joy with axes [forward, left] and no buttons"""
    return _types()["Joy"](
        header=_header(nanoseconds, "base_link"),
        axes=np.array([forward, left], np.float32),
        buttons=np.zeros(0, np.int32),
    )


def command_message(nanoseconds: int, twist: Twist2) -> Any:
    """geometry_msgs/TwistStamped in base_link"""
    return _types()["TwistStamped"](header=_header(nanoseconds, "base_link"), twist=_twist(twist))


def plan_message(nanoseconds: int, path: NDArray[np.float64]) -> Any:
    """nav_msgs/Path in odom; each pose looks along the path"""
    types = _types()
    header = _header(nanoseconds, "odom")
    steps = np.diff(path, axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0]) if len(steps) else np.zeros(1)
    yaws = np.r_[yaws, yaws[-1:]]
    poses = [
        types["PoseStamped"](header=header, pose=_pose(x, y, yaw))
        for (x, y), yaw in zip(path.tolist(), yaws.tolist(), strict=False)
    ]
    return types["Path"](header=header, poses=poses)


def intention_message(nanoseconds: int, goal: ArrayLike, likelihood: float) -> Any:
    """sensor_msgs/PointCloud2 in odom: one point with the float64 fields x, y, z and likelihood"""
    types = _types()
    x, y = np.asarray(goal, float)
    fields = [
        types["PointField"](name=name, offset=8 * k, datatype=_FLOAT64, count=1)
        for k, name in enumerate(_INTENTION_FIELDS)
    ]
    return types["PointCloud2"](
        header=_header(nanoseconds, "odom"),
        height=1,
        width=1,
        fields=fields,
        is_bigendian=False,
        point_step=32,
        row_step=32,
        data=np.array([x, y, 0.0, likelihood], "<f8").view(np.uint8),
        is_dense=True,
    )


def joint_trajectory_message(
    names: Sequence[str], time: NDArray[np.float64], positions: NDArray[np.float64], velocities: NDArray[np.float64]
) -> Any:
    """trajectory_msgs/JointTrajectory of N joints in `base`: times (T,) [s], positions and velocities (T, N)."""
    types = _types()
    points = []
    for at, where, fast in zip(time.tolist(), positions, velocities, strict=True):
        seconds, rest = divmod(round(at * 1e9), 1_000_000_000)
        points.append(
            types["JointTrajectoryPoint"](
                positions=where,
                velocities=fast,
                accelerations=np.zeros(0),
                effort=np.zeros(0),
                time_from_start=types["Duration"](sec=seconds, nanosec=rest),
            )
        )
    return types["JointTrajectory"](header=_header(0, "base"), joint_names=list(names), points=points)


def serialize(message: Any, message_type: str) -> bytes:
    """The message as little-endian CDR."""
    return bytes(typestore().serialize_cdr(message, message_type))


def deserialize(data: bytes, message_type: str) -> Any:
    """The message that CDR bytes hold; raises whatever rosbags raises for bytes that hold none."""
    return typestore().deserialize_cdr(data, message_type)


def yaw_of(rotation: Any) -> float:
    """Heading [rad] of a quaternion message."""
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def pose_values(pose: Any) -> tuple[float, float, float]:
    """x, y [m], yaw [rad] of a geometry_msgs/Pose"""
    return pose.position.x, pose.position.y, yaw_of(pose.orientation)


def transform_values(transform: Any) -> Pose2:
    """The planar part of a geometry_msgs/Transform"""
    return Pose2(transform.translation.x, transform.translation.y, yaw_of(transform.rotation))


def twist_values(twist: Any) -> tuple[float, float]:
    """Linear [m/s] and angular [rad/s] velocity of a geometry_msgs/Twist"""
    return twist.linear.x, twist.angular.z


def intention_values(cloud: Any) -> tuple[float, float, float]:
    """x, y [m] in odom and the likelihood of what `intention_message` made; ValueError for another layout"""
    names = tuple(field.name for field in cloud.fields)
    if names != _INTENTION_FIELDS or len(cloud.data) != 8 * len(names):
        raise ValueError(f"an intention is one point with fields {_INTENTION_FIELDS}, this has {names}")
    x, y, _, likelihood = cloud.data.view("<f8").tolist()
    return x, y, likelihood
