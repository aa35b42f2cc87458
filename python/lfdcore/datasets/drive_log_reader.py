"""Reads the file of a drive log, also one that was cut or never closed."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.drive_log import FORMAT, SCAN_LAYOUT, DriveLog, Intention, Plan
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2

_MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA, _DATA_END = 3, 4, 5, 6, 12, 15


def read_drive_log(path: str | Path) -> DriveLog:
    """Reads a drive log. One that was never closed, or was cut, gives all its whole records.

    Its metadata then says so under `incomplete`. DataError, with file and place, for a file that is no drive log, ends
    before its first record, or holds what no drive log can hold. A whole file's checksum is checked.
    """
    path = Path(path)
    with path.open("rb") as file:
        return _read(file, path.stat().st_size, str(path))


def is_drive_log(path: str | Path) -> bool:
    """True for an .mcap that lfdcore wrote, whole or cut."""
    with Path(path).open("rb") as file:
        head = file.read(256)
    return head.startswith(_MAGIC) and b"lfdcore" in head


def _read(file: BinaryIO, size: int, source: str) -> DriveLog:
    if file.read(len(_MAGIC)) != _MAGIC:
        raise DataError(f"{source}: is no .mcap file (its first 8 bytes are not MCAP's)")
    gathered = _Gathered()
    place, opcode = len(_MAGIC), 0
    try:
        for place, opcode, body in _records(file, size):  # noqa: B007 the last of both is used below
            gathered.add(opcode, body)
    except Exception as error:  # mcap, rosbags and numpy raise whatever garbled bytes lead them to
        raise DataError(f"{source}: record at byte {place} is garbled: {error}") from error
    if opcode != _DATA_END:
        _refuse_inner_damage(file, size, source, place)
        gathered.metadata["incomplete"] = f"never closed; read up to the record at byte {place} of {size}"
    try:
        return gathered.log(Path(source).stem)
    except (ValueError, KeyError) as error:
        raise DataError(f"{source}: {error}") from error


def _refuse_inner_damage(file: BinaryIO, size: int, source: str, place: int) -> None:
    """A file that was closed yet has no data end was damaged inside, not cut at its end."""
    file.seek(max(0, size - len(_MAGIC)))
    if size > 2 * len(_MAGIC) and file.read() == _MAGIC:
        raise DataError(f"{source}: the file is complete, but the length of the record after byte {place} is garbled")


def _records(file: BinaryIO, size: int) -> Iterator[tuple[int, int, bytes]]:
    """(place, opcode, body) of each whole record up to the end of the data; ValueError for a wrong checksum."""
    checksum = zlib.crc32(_MAGIC)
    while len(head := file.read(9)) == 9:
        place = file.tell() - 9
        opcode, length = struct.unpack("<BQ", head)
        if length > size - place - 9:
            return  # cut
        body = file.read(length)
        if opcode == _DATA_END and (expected := struct.unpack("<I", body)[0]) not in (0, checksum):
            raise ValueError(f"the data's checksum is {checksum:08x}, the file says {expected:08x}")
        checksum = zlib.crc32(body, zlib.crc32(head, checksum))
        yield place, opcode, body
        if opcode == _DATA_END:
            return


@dataclass
class _Gathered:
    """What the records read so far amount to."""

    about: dict[str, str] | None = None
    layout: dict[str, str] | None = None
    metadata: dict[str, str] = field(default_factory=dict)
    schemas: dict[int, str] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)
    scans: list[tuple[float, Any]] = field(default_factory=list)
    rows: dict[str, list[tuple[float, ...]]] = field(
        default_factory=lambda: {topic: [] for topic in ("/odom", "/joy", "/joy_desired", "/cmd_vel", "/tf")}
    )
    plans: list[Plan] = field(default_factory=list)
    intentions: list[Intention] = field(default_factory=list)

    def add(self, opcode: int, body: bytes) -> None:
        if opcode == _MESSAGE:
            self._add_message(body)
        elif opcode == _CHUNK:
            self._add_chunk(body)
        elif opcode in (_SCHEMA, _CHANNEL, _METADATA):
            self._add_definition(opcode, body)

    def _add_definition(self, opcode: int, body: bytes) -> None:
        from mcap import records
        from mcap.data_stream import ReadDataStream

        stream = ReadDataStream(io.BytesIO(body))
        if opcode == _SCHEMA:
            schema = records.Schema.read(stream)
            self.schemas[schema.id] = schema.name
        elif opcode == _CHANNEL:
            channel = records.Channel.read(stream)
            self._add_channel(channel.id, channel.topic, self.schemas.get(channel.schema_id, "no type"))
        else:
            record = records.Metadata.read(stream)
            self._add_metadata(record.name, record.metadata)

    def _add_channel(self, channel: int, topic: str, kind: str) -> None:
        if topic in ros.TOPICS and kind != ros.TOPICS[topic]:
            raise ValueError(f"topic {topic} carries {kind}, must carry {ros.TOPICS[topic]}")
        self.topics[channel] = topic

    def _add_metadata(self, name: str, values: dict[str, str]) -> None:
        if name == "lfdcore":
            self.about = values
        elif name == "scan":
            self.layout = values
        elif name == "drive":
            self.metadata |= values

    def _add_chunk(self, body: bytes) -> None:  # we write none, but mcap's own tools do when they copy a log
        from mcap.data_stream import ReadDataStream
        from mcap.records import Chunk
        from mcap.stream_reader import get_chunk_data_stream

        stream, length = get_chunk_data_stream(Chunk.read(ReadDataStream(io.BytesIO(body))), validate_crc=True)
        inside = io.BytesIO(stream.read(length))
        for _, opcode, part in _records(inside, length):
            self.add(opcode, part)

    def _add_message(self, body: bytes) -> None:
        channel, _, nanoseconds, _ = struct.unpack_from("<HIQQ", body)
        topic = self.topics[channel]
        if topic == "/tf":
            self._add_transform(body[22:], nanoseconds)
        elif topic in self.rows or topic in ("/scan", "/plan", "/intention"):
            message = ros.deserialize(body[22:], ros.TOPICS[topic])
            self._add_decoded(topic, nanoseconds / 1e9, message)

    def _add_transform(self, message: bytes, nanoseconds: int) -> None:
        """Takes T_map_odom; the other transforms on /tf repeat the odometry, and decoding them all would take long."""
        if b"map\0" not in message:
            return
        for one in ros.deserialize(message, ros.TOPICS["/tf"]).transforms:
            if (one.header.frame_id, one.child_frame_id) == ("map", "odom"):
                self.rows["/tf"].append((nanoseconds / 1e9, *ros.transform_values(one.transform)))

    def _add_decoded(self, topic: str, stamp: float, message: Any) -> None:
        if topic == "/scan":
            self.scans.append((stamp, message))
        elif topic == "/odom":
            self.rows[topic].append(
                (stamp, *ros.pose_values(message.pose.pose), *ros.twist_values(message.twist.twist))
            )
        elif topic == "/cmd_vel":
            self.rows[topic].append((stamp, *ros.twist_values(message.twist)))
        elif topic == "/plan":
            points = [(p.pose.position.x, p.pose.position.y) for p in message.poses]
            self.plans.append(Plan(stamp, np.array(points, float).reshape(-1, 2)))
        elif topic == "/intention":
            x, y, likelihood = ros.intention_values(message)
            self.intentions.append(Intention(stamp, (x, y), likelihood))
        else:
            forward, left = message.axes.tolist()
            self.rows[topic].append((stamp, forward, left))

    def log(self, name: str) -> DriveLog:
        """ValueError for what a DriveLog refuses, KeyError for a note that lacks a key."""
        if self.about is None:
            raise ValueError("is no drive log of lfdcore, or is cut before its first record")
        if self.about["format"] != FORMAT:
            raise ValueError(f"its format is {self.about['format']!r}, this version reads {FORMAT!r}")
        odometry = np.array(self.rows["/odom"], float).reshape(-1, 6)
        joystick, desired, command = (
            np.array(self.rows[topic], float).reshape(-1, 3) for topic in ("/joy", "/joy_desired", "/cmd_vel")
        )
        map_odom = np.array(self.rows["/tf"], float).reshape(-1, 4)
        return DriveLog(
            **self._scans(),
            T_base_laser=_mounting(self.about["T_base_laser"]),
            odometry_stamp=odometry[:, 0],
            pose=odometry[:, 1:4],
            twist=odometry[:, 4:],
            joystick_stamp=joystick[:, 0],
            joystick=joystick[:, 1:],
            desired_stamp=desired[:, 0],
            desired=desired[:, 1:],
            command_stamp=command[:, 0],
            command=command[:, 1:],
            map_stamp=map_odom[:, 0],
            map_odom=map_odom[:, 1:],
            plans=self.plans,
            intentions=self.intentions,
            metadata=self.metadata,
            name=self.about["name"] or name,
        )

    def _scans(self) -> dict[str, Any]:
        if not self.scans:
            return {"scan_stamp": np.zeros(0), "ranges": np.zeros((0, 0), np.float32)}
        if self.layout is None:
            raise ValueError("the note on the scans' layout is missing")
        beams = len(self.scans[0][1].ranges)
        for stamp, scan in self.scans:
            if len(scan.ranges) != beams:
                raise ValueError(f"the scan at {stamp} s has {len(scan.ranges)} beams, the first has {beams}")
        ranges = np.stack([scan.ranges for _, scan in self.scans])
        layout = {key: float(self.layout[key]) for key in SCAN_LAYOUT}
        return {"scan_stamp": np.array([stamp for stamp, _ in self.scans]), "ranges": ranges} | layout


def _mounting(text: str) -> Pose2 | None:
    return None if text == "unknown" else Pose2(*map(float, text.split()))
