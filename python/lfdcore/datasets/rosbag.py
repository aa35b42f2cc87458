"""ROS 1 and ROS 2 bags: scans, odometry and, where there are any, joystick and commands, found by their types."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.bag_clocks import Timed, on_one_clock
from lfdcore.datasets.bag_streams import (
    OdometryStream,
    ScanStream,
    Stream,
    command_stream,
    joystick_stream,
    require_few_odd,
    transform_stream,
)
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.frame_tree import FrameTree, Mounting, WatchedFrames, mounting_of
from lfdcore.datasets.motion import windowed_twist
from lfdcore.datasets.stamp_order import in_order
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2

TYPES: Mapping[str, tuple[str, ...]] = {
    "scan": ("sensor_msgs/msg/LaserScan",),
    "odometry": ("nav_msgs/msg/Odometry",),
    "joystick": ("sensor_msgs/msg/Joy",),
    "command": ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"),
}
"""Message types by role"""
OPTIONAL = ("joystick", "command")
"""Roles that a drive may lack"""
TRANSFORM = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
FROM_TF = "tf"
"""The odometry that /tf says"""
NONE = "none"
"""No stream in this role, although there may be one"""


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

    `scan` (sensor_msgs/LaserScan), `odometry` (nav_msgs/Odometry, or "tf": what /tf says), `joystick`
    (sensor_msgs/Joy) and `command` (geometry_msgs/Twist or TwistStamped) name topics; each may be left out where the
    bag has at most one of its type with messages. Of several scans or odometries ValueError names the candidates; of
    several joysticks or commands none is read, and the metadata say so. "none" reads none. `joystick_axes` are the
    indices of (forward, left) in Joy.axes, as the ROS joy drivers order them.

    T_base_laser is what the bag's transforms say from the odometry's child frame to the scans' frame, unless given:
    /tf_static, and what never changes on /tf, up and down the tree. None where nothing joins them. A scanner that hangs
    upside down has its angles turned round; one that is tilted by more than 5 degrees is an error.

    Stamps are the headers' where their clocks agree, else those of receipt on the scans' clock, sorted, since the
    first. A record that is odd is left out and counted. Scans whose number of beams wavers are put on the first one's
    angles. Ranges become REP-117's words for what lfdcore.grid.read_beams says of them: 0 and finite ones below
    range_min NaN, inf from range_max on. All of that stands in the metadata.

    DataError, naming file, topic and value, for a bag without scans or odometry, one that is broken, and one of what no
    drive can be: two publishers on a topic, clocks that were set back, angles that contradict one another, orientations
    that are no rotation, units that cannot be.
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(2, "no such bag", str(path))
    wanted = {"scan": scan, "odometry": odometry, "joystick": joystick, "command": command}
    try:
        return _drive_log(path, _read(path, wanted, joystick_axes), T_base_laser)
    except (ChoiceError, DataError):
        raise
    except Exception as error:  # rosbags raises whatever garbled bytes lead it to
        name = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
        raise DataError(f"{path}: {name}{error}") from error


class ChoiceError(ValueError):
    """More than one topic of a type, or none of the name asked for: an option chooses."""


@dataclass
class _Bag:
    """What was found."""

    streams: dict[str, Any] = field(default_factory=dict)
    """by role"""
    frames: FrameTree = field(default_factory=FrameTree)
    watched: WatchedFrames = field(default_factory=lambda: WatchedFrames(ways=False))
    notes: dict[str, str] = field(default_factory=dict)


def _read(path: Path, wanted: Mapping[str, str | None], axes: tuple[int, int]) -> _Bag:
    from rosbags.highlevel import AnyReader

    with AnyReader([path], default_typestore=ros.typestore()) as reader:
        counts: dict[str, dict[str, int]] = {}
        for connection in reader.connections:
            kinds = counts.setdefault(connection.topic, {})
            kinds[connection.msgtype] = kinds.get(connection.msgtype, 0) + connection.msgcount
        bag, by_topic = _prepared(path, counts, wanted, axes)
        moving = {topic for topic in counts if topic.rsplit("/", 1)[-1] == "tf" and _is_transform(counts[topic])}
        static = {topic for topic in counts if topic.endswith("tf_static") and _is_transform(counts[topic])}
        chosen = [one for one in reader.connections if one.topic in {*by_topic, *static, *moving}]
        for connection, received, raw in reader.messages(connections=chosen):
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic in static:
                bag.frames.add(message)
            elif connection.topic in moving:
                bag.watched.add(message, received)
            else:
                by_topic[connection.topic].add(message, received)
    bag.watched.join_fixed(bag.frames)
    return bag


def _is_transform(kinds: Mapping[str, int]) -> bool:
    return any(kind in TRANSFORM for kind in kinds)


def _prepared(
    path: Path, counts: Mapping[str, Mapping[str, int]], wanted: Mapping[str, str | None], axes: tuple[int, int]
) -> tuple[_Bag, dict[str, Stream]]:
    """A stream for each role that has a topic."""
    bag = _Bag()
    topics = {role: _choose(path, role, counts, wanted[role], bag.notes) for role in TYPES}
    makers: dict[str, Callable[[str], Stream]] = {
        "scan": lambda topic: ScanStream(topic, sum(counts[topic].values())),
        "odometry": OdometryStream,
        "joystick": lambda topic: joystick_stream(topic, axes),
        "command": command_stream,
    }
    by_topic = {}
    for role, topic in topics.items():
        if topic == FROM_TF:
            bag.watched = WatchedFrames(ways=True)
        elif topic is not None:
            bag.streams[role] = by_topic[topic] = makers[role](topic)
    return bag, by_topic


def _choose(
    path: Path, role: str, counts: Mapping[str, Mapping[str, int]], wanted: str | None, notes: dict[str, str]
) -> str | None:
    kinds = TYPES[role]
    of_type = {topic: sum(each.get(kind, 0) for kind in kinds) for topic, each in counts.items() if {*kinds} & {*each}}
    if wanted == NONE and role in OPTIONAL:
        return None
    if wanted == FROM_TF and role == "odometry":
        return FROM_TF
    if wanted is not None:
        if wanted not in of_type:
            raise ChoiceError(f"{role} is {wanted!r}, {path} has {sorted(of_type)} of {' or '.join(kinds)}")
        return wanted
    candidates = sorted(topic for topic, count in of_type.items() if count)
    if len(candidates) > 1 and role in OPTIONAL:
        notes[f"{role} left out"] = f"{', '.join(candidates)}: --{OPTION[role]} chooses one"
        return None
    if len(candidates) > 1:
        raise ChoiceError(
            f"{path} has more than one topic for {role}: {', '.join(candidates)}; say --{OPTION[role]} TOPIC (in "
            f"Python {role}=)"
        )
    if candidates or role in OPTIONAL:
        return candidates[0] if candidates else None
    if role == "odometry" and any(_is_transform(each) for each in counts.values()):
        return FROM_TF
    found = ", ".join(f"{topic} ({', '.join(sorted(each))})" for topic, each in sorted(counts.items())) or "nothing"
    raise DataError(f"{path}: no message of type {kinds[0]}, so no {role}; it holds {found}")


OPTION = {"scan": "scan", "odometry": "odometry", "joystick": "joy", "command": "command"}
"""What a command line calls the choice of a role's topic"""


def _drive_log(path: Path, bag: _Bag, given: Pose2 | None) -> DriveLog:
    base = _odometry_from_tf(path, bag) if "odometry" not in bag.streams else bag.streams["odometry"].base
    for role, stream in bag.streams.items():
        require_few_odd(stream)
        if not stream.times.headers and role not in OPTIONAL:
            raise DataError(f"{path}: topic {stream.times.topic} holds no message that can be read, so no {role}")
    streams = {role: stream for role, stream in bag.streams.items() if stream.times.headers}
    timed = on_one_clock({role: stream.times for role, stream in streams.items()}, "scan")
    epoch = min(int(one.stamps.min()) for one in timed.values() if len(one.stamps))
    stamps: dict[str, Any] = {}
    order = {}
    for role, stream in streams.items():
        seconds, order[role] = _ordered(role, stream, timed[role], epoch, bag.notes)
        stamps[f"{role}_stamp"] = seconds
    _require_together(streams, stamps)
    mounting, origin = _mounting(bag, streams["scan"].frame, base)
    if given is not None:
        turned = mounting is not None and mounting.mirrored
        mounting, origin = Mounting(given, turned), "as given" + (", upside down by its transforms" if turned else "")
    fields = streams["scan"].fields(order["scan"])
    if streams["scan"].other_angles:
        bag.notes["beams"] = f"{streams['scan'].other_angles} scans were put on the angles of the first"
    return DriveLog(
        **stamps,
        **(_turned_round(fields) if mounting is not None and mounting.mirrored else fields),
        **_rows(streams, order, stamps),
        T_base_laser=None if mounting is None else mounting.T_base_laser,
        metadata={"source": f"ROS bag {path.name}", "epoch [ns]": str(epoch), "T_base_laser": origin}
        | {f"{role} topic": stream.times.topic for role, stream in streams.items()}
        | bag.notes,
        name=path.stem,
    )


def _odometry_from_tf(path: Path, bag: _Bag) -> str:
    """Takes the odometry from what moves on /tf -> the base's frame."""
    moving = bag.watched.moving()
    pairs = [pair for pair in moving if pair[0].rsplit("/", 1)[-1].startswith("odom")] or list(moving)
    if len(pairs) != 1:
        found = "; ".join(f"{parent} to {child}" for parent, child in pairs) or "nothing"
        raise DataError(
            f"{path}: no nav_msgs/Odometry, and on /tf there must be one frame that moves in odom, not {found}"
        )
    parent, child = pairs[0]
    bag.streams["odometry"] = transform_stream(f"/tf of {child} in {parent}", moving[pairs[0]])
    bag.notes["odometry"] = "poses of /tf; twist over the last 0.5 s"
    return child


def _ordered(
    role: str, stream: Stream, timed: Timed, epoch: int, notes: dict[str, str]
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """A stream's stamps [s], sorted, and which of its records they are."""
    seconds = (timed.stamps - epoch) / 1e9
    order = in_order(stream.times.topic, seconds)
    noted = "; ".join(filter(None, (timed.noted, order.noted(), stream.odd.noted())))
    if noted:
        notes[f"{role} records"] = noted
    return seconds[order.kept], timed.kept[order.kept]


def _require_together(streams: Mapping[str, Stream], stamps: Mapping[str, NDArray[np.float64]]) -> None:
    """Scans and odometry must be of one time, or none of them says where a scan was taken."""
    a, b = stamps["scan_stamp"], stamps["odometry_stamp"]
    if a[0] <= b[-1] and b[0] <= a[-1]:
        return
    raise ValueError(
        f"{streams['scan'].times.topic} is from {a[0]:.3f} to {a[-1]:.3f} s, {streams['odometry'].times.topic} from "
        f"{b[0]:.3f} to {b[-1]:.3f} s: they have no time in common"
    )


def _mounting(bag: _Bag, frame: str, base: str) -> tuple[Mounting | None, str]:
    """The scanner's place on the chair, and where it comes from."""
    if not frame or not base:
        which = "the scans name no frame" if not frame else "the odometry names no child frame"
        return None, f"unknown: {which}; say --mounting X,Y,YAW (in Python T_base_laser=)"
    T = bag.frames.transform(base, frame)
    if T is None:
        return None, f"unknown: no transform joins {frame} and {base}; say --mounting X,Y,YAW (in Python T_base_laser=)"
    return mounting_of(T), f"transforms from {frame} to {base}"


def _turned_round(fields: dict[str, Any]) -> dict[str, Any]:
    """Scans of a scanner that hangs upside down: seen from above, their angles grow clockwise."""
    return fields | {name: -fields[name] for name in ("angle_min", "angle_increment")}


def _rows(
    streams: Mapping[str, Any], order: Mapping[str, NDArray[np.intp]], stamps: Mapping[str, NDArray[np.float64]]
) -> dict[str, Any]:
    """Of a DriveLog: what is not scans."""
    rows = {
        role: np.array(streams[role].rows, float)[order[role]] if role in streams else np.zeros((0, width))
        for role, width in (("odometry", 5), ("joystick", 2), ("command", 2))
    }
    pose, twist = rows["odometry"][:, :3], rows["odometry"][:, 3:]
    if not twist.shape[1]:
        pose = np.c_[pose[:, :2], np.unwrap(pose[:, 2])]
        twist = windowed_twist(stamps["odometry_stamp"], pose)
    return {"pose": pose, "twist": twist, "joystick": rows["joystick"], "command": rows["command"]}
