"""ROS 1 and ROS 2 bags: scans, odometry and, where there are any, joystick and commands, found by their types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2
from lfdcore.grid import read_beams

Row = tuple[float, ...]

SCAN = ("sensor_msgs/msg/LaserScan",)
ODOMETRY = ("nav_msgs/msg/Odometry",)
JOYSTICK = ("sensor_msgs/msg/Joy",)
COMMAND = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist")
TRANSFORM = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
MOST_JUMPS = 16
"""transforms between the scan's frame and the odometry's child frame"""


def read_rosbag(
    path: str | Path,
    *,
    scan: str | None = None,
    odometry: str | None = None,
    joystick: str | None = None,
    command: str | None = None,
    T_base_laser: Pose2 | None = None,
    joystick_axes: tuple[int, int] = (1, 0),
) -> DriveLog:
    """Reads a ROS 1 .bag, a ROS 2 bag folder, or a lone .mcap or .db3 of one.

    `scan` (sensor_msgs/LaserScan), `odometry` (nav_msgs/Odometry), `joystick` (sensor_msgs/Joy) and `command`
    (geometry_msgs/Twist or TwistStamped) name topics; each may be left out where the bag has at most one of its type.
    ValueError naming the candidates where it has more; DataError for a bag without scans or odometry, or one that is
    broken. `joystick_axes` are the indices of (forward, left) in Joy.axes, as the ROS joy drivers order them.
    T_base_laser is what the bag's static transforms say from the odometry's child frame to the scans' frame, unless
    given; the identity where they say nothing (the metadata say which). Stamps are the headers' where they have any,
    else the bag's, sorted, since the first; where they go back, the metadata's `sorted` says how often. Ranges stay
    as they are where the scanner measured something; else they become REP-117's words for what lfdcore.grid.read_beams
    says of them: NaN for finite ones below range_min, inf from range_max on.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(2, "no such bag", str(path))
    wanted = {"scan": scan, "odometry": odometry, "joystick": joystick, "command": command}
    try:
        bag = _read(path, wanted)
        return _drive_log(path, bag, T_base_laser, joystick_axes)
    except (_AmbiguousError, DataError):
        raise
    except Exception as error:  # rosbags raises whatever garbled bytes lead it to
        raise DataError(f"{path}: {type(error).__name__}: {error}") from error


class _AmbiguousError(ValueError):
    """More than one topic of a type, or none of the name asked for."""


@dataclass
class _Bag:
    """What was found, by role."""

    topics: dict[str, str] = field(default_factory=dict)
    messages: dict[str, list[tuple[int, Any]]] = field(default_factory=dict)
    """(stamp [ns], message), sorted"""
    transforms: dict[str, tuple[str, Pose2]] = field(default_factory=dict)
    """child frame -> (parent frame, T_parent_child) of what never moves"""
    unordered: dict[str, int] = field(default_factory=dict)
    """by role: messages whose stamp is before that of the message before"""


def _read(path: Path, wanted: dict[str, str | None]) -> _Bag:
    from rosbags.highlevel import AnyReader

    bag = _Bag()
    with AnyReader([path], default_typestore=ros.typestore()) as reader:
        types = {connection.topic: connection.msgtype for connection in reader.connections}
        for role, kinds in (("scan", SCAN), ("odometry", ODOMETRY), ("joystick", JOYSTICK), ("command", COMMAND)):
            topic = _choose(path, role, kinds, types, wanted[role])
            if topic:
                bag.topics[role] = topic
                bag.messages[role] = []
        roles = {topic: role for role, topic in bag.topics.items()}
        static = {topic for topic, kind in types.items() if kind in TRANSFORM and topic.endswith("tf_static")}
        chosen = [connection for connection in reader.connections if connection.topic in {*roles, *static}]
        for connection, nanoseconds, raw in reader.messages(connections=chosen):
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic in static:
                bag.transforms |= _transforms(message)
            else:
                bag.messages[roles[connection.topic]].append((_stamp(message, nanoseconds), message))
    for role, messages in bag.messages.items():
        bag.unordered[role] = sum(after[0] < before[0] for before, after in pairwise(messages))
        messages.sort(key=lambda one: one[0])
    return bag


def _choose(path: Path, role: str, kinds: Sequence[str], types: dict[str, str], wanted: str | None) -> str | None:
    candidates = sorted(topic for topic, kind in types.items() if kind in kinds)
    if wanted is not None:
        if wanted not in candidates:
            raise _AmbiguousError(f"{role} is {wanted!r}, {path} has {candidates} of {' or '.join(kinds)}")
        return wanted
    if len(candidates) > 1:
        raise _AmbiguousError(f"{path} has more than one topic for {role}: say {role}= one of {candidates}")
    if not candidates and role in ("scan", "odometry"):
        found = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(types.items())) or "nothing"
        raise DataError(f"{path}: no topic of type {kinds[0]}, so no {role}; it holds {found}")
    return candidates[0] if candidates else None


def _stamp(message: Any, received: int) -> int:
    header = getattr(message, "header", None)
    stamp = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec if header is not None else 0
    return stamp or received


def _transforms(message: Any) -> dict[str, tuple[str, Pose2]]:
    return {
        one.child_frame_id.lstrip("/"): (one.header.frame_id.lstrip("/"), ros.transform_values(one.transform))
        for one in message.transforms
    }


def _mounting(bag: _Bag) -> tuple[Pose2, str]:
    """T_base_laser and where it comes from"""
    frame = bag.messages["scan"][0][1].header.frame_id.lstrip("/")
    base = bag.messages["odometry"][0][1].child_frame_id.lstrip("/")
    mounting, at = Pose2(), frame
    for _ in range(MOST_JUMPS):
        if at == base:
            return mounting, f"static transforms from {frame} to {base}"
        if at not in bag.transforms:
            break
        at, step = bag.transforms[at]
        mounting = step * mounting
    return Pose2(), f"identity: no static transforms from {frame} to {base or 'an unnamed frame'}"


def _drive_log(path: Path, bag: _Bag, given: Pose2 | None, axes: tuple[int, int]) -> DriveLog:
    for role in ("scan", "odometry"):
        if not bag.messages[role]:
            raise DataError(f"{path}: topic {bag.topics[role]} holds no message, so no {role}")
    epoch = min(messages[0][0] for messages in bag.messages.values() if messages)
    back = [f"{count} times in {role}" for role, count in bag.unordered.items() if count]
    mounting, origin = _mounting(bag) if given is None else (given, "as given")
    odometry = _rows(bag, "odometry", epoch, 5, _odometry_values)
    joystick = _rows(bag, "joystick", epoch, 2, lambda message: _axes(message, axes))
    command = _rows(bag, "command", epoch, 2, lambda message: ros.twist_values(getattr(message, "twist", message)))
    return DriveLog(
        **_scans(bag.messages["scan"], epoch),
        T_base_laser=mounting,
        odometry_stamp=odometry[:, 0],
        pose=odometry[:, 1:4],
        twist=odometry[:, 4:],
        joystick_stamp=joystick[:, 0],
        joystick=joystick[:, 1:],
        command_stamp=command[:, 0],
        command=command[:, 1:],
        metadata={"source": f"ROS bag {path.name}", "epoch [ns]": str(epoch), "T_base_laser": origin}
        | {f"{role} topic": topic for role, topic in bag.topics.items()}
        | ({"sorted": f"stamps went back {', '.join(back)}"} if back else {}),
        name=path.stem,
    )


def _rows(bag: _Bag, role: str, epoch: int, width: int, values: Callable[[Any], Row]) -> NDArray[np.float64]:
    rows = [((stamp - epoch) / 1e9, *values(message)) for stamp, message in bag.messages.get(role, [])]
    return np.array(rows, float).reshape(-1, 1 + width)


def _odometry_values(message: Any) -> Row:
    return *ros.pose_values(message.pose.pose), *ros.twist_values(message.twist.twist)


def _axes(message: Any, axes: tuple[int, int]) -> Row:
    if max(axes) >= len(message.axes):
        raise ValueError(f"a Joy message has {len(message.axes)} axes, joystick_axes is {axes}")
    return tuple(float(message.axes[k]) for k in axes)


def _scans(messages: list[tuple[int, Any]], epoch: int) -> dict[str, Any]:
    first = messages[0][1]
    ranges = []
    for stamp, scan in messages:
        at = f"the scan at {(stamp - epoch) / 1e9} s"
        if len(scan.ranges) != len(first.ranges):
            raise ValueError(f"{at} has {len(scan.ranges)} beams, the first has {len(first.ranges)}")
        try:
            ranges.append(_ranges(scan))
        except ValueError as error:
            raise ValueError(f"{at}: {error}") from error
    return {
        "scan_stamp": np.array([(stamp - epoch) / 1e9 for stamp, _ in messages]),
        "ranges": np.stack(ranges),
        "angle_min": float(first.angle_min),
        "angle_increment": float(first.angle_increment),
        "range_min": float(first.range_min),
        "range_max": float(first.range_max),
    }


def _ranges(scan: Any) -> NDArray[np.float32]:
    """A message's ranges (B,) [m] in the words of REP-117.

    Drivers from before REP-117 give a number below range_min for no measurement, and one from range_max on for nothing
    there. Only the message's limits show that, and the log keeps those of its first message alone. So these numbers
    become NaN and inf here, which mean the same under any limits. What hit something stays bit by bit, -inf (too close)
    included.
    """
    ranges = np.array(scan.ranges, np.float32)
    lengths, hit = read_beams(ranges, scan.range_min, scan.range_max)
    return np.where(hit, ranges, np.where(lengths > 0, np.float32(np.inf), np.float32(np.nan)))
