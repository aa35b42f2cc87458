"""MRPT rawlogs: planar scans and odometry from a stream of serialised objects (gzipped or plain)."""

from __future__ import annotations

import gzip
import math
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import windowed_twist
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2

LARGEST = 1 << 30
"""[bytes] a rawlog may unpack to"""
_END = 0x88
_EMPTY = 0x80
_TICK = 1e-7  # [s]; MRPT counts from 1601-01-01


def read_mrpt(path: str | Path) -> DriveLog:
    """Reads a rawlog of sensory frames and actions, or of observations alone.

    Known objects: CSensoryFrame 2; CObservation2DRangeScan 6-7; CActionCollection 0 with CActionRobotMovement2D 5-6 by
    odometry; CObservationOdometry 0-2; CPose3D 1-2, CPose2D 0-1. An action's increment lasts from one scan to the
    next, so that poses are added up from the first scan on and stand at the scans' stamps. Beams marked invalid are
    inf from the sensor's maximum range on, else NaN. The mounting T_base_laser is the file's; its height is left out,
    a tilted or moving sensor is refused. Stamps count from the first record; the twist is the mean over the last half
    second. DataError with the byte for anything else.
    """
    path = Path(path)
    archive = _Archive(_unpack(path), str(path))
    gathered = _Gathered()
    while archive.left():
        try:
            gathered.add(*archive.read_object())
        except (ValueError, struct.error, OverflowError) as error:
            raise DataError(f"{path}, byte {archive.place}: {error}") from error
    try:
        return gathered.log(path)
    except (ValueError, OverflowError) as error:
        raise DataError(f"{path}: {error}") from error


def _unpack(path: Path) -> bytes:
    with path.open("rb") as raw:
        zipped = raw.read(2) == b"\x1f\x8b"
    try:
        with gzip.open(path) if zipped else path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise DataError(f"{path}: the gzip stream is cut or garbled: {error}") from error
    if len(data) > LARGEST:
        raise DataError(f"{path}: unpacks to more than {LARGEST} bytes")
    return data


@dataclass(frozen=True)
class _Scan:
    ticks: int
    ranges: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_max: float
    mounting: Pose2


@dataclass(frozen=True)
class _Odometry:
    ticks: int
    pose: Pose2
    increment: bool
    """Since the scan before, not since the drive's beginning"""


class _Archive:
    """Reads MRPT's objects: a byte 0x80 | length, the class's name, a version byte, the fields, the byte 0x88."""

    def __init__(self, data: bytes, source: str) -> None:
        self._data, self.source, self.place = data, source, 0
        self._readers: dict[str, Callable[[int], Any]] = {
            "CSensoryFrame": self._sensory_frame,
            "CActionCollection": self._action_collection,
            "CActionRobotMovement2D": self._movement,
            "CObservation2DRangeScan": self._scan,
            "CObservationOdometry": self._odometry,
            "CPose3D": self._pose_3d,
            "CPose2D": self._pose_2d,
            "CMatrixD": self._matrix,
        }

    def left(self) -> int:
        """Bytes not read yet"""
        return len(self._data) - self.place

    def _take(self, count: int) -> bytes:
        if count > self.left():
            raise ValueError(f"needs {count} more bytes, the file ends after {self.left()}")
        part = self._data[self.place : self.place + count]
        self.place += count
        return part

    def _values(self, layout: str) -> tuple[Any, ...]:
        return struct.unpack("<" + layout, self._take(struct.calcsize("<" + layout)))

    def _count(self, bytes_each: int) -> int:
        (count,) = self._values("I")
        if count * bytes_each > self.left():
            raise ValueError(f"announces {count} entries, the file ends after {self.left()} bytes")
        return int(count)

    def read_object(self, *wanted: str) -> tuple[str, Any]:
        """(class, content) of the next object; ValueError if it is unknown or none of `wanted`"""
        place = self.place
        (flag,) = self._values("B")
        name = self._take(flag & 0x7F).decode("ascii", "replace")
        if flag <= _EMPTY or name not in self._readers or (wanted and name not in wanted):
            self.place = place
            raise ValueError(f"expected {' or '.join(wanted or self._readers)}, found {name!r}")
        (version,) = self._values("B")
        content = self._readers[name](version)
        (end,) = self._values("B")
        if end != _END:
            raise ValueError(f"{name} version {version} ends with byte {end:#x}, must end with {_END:#x}")
        return name, content

    def _text(self) -> str:
        return self._take(self._count(1)).decode("utf-8", "replace")

    def _sensory_frame(self, version: int) -> list[Any]:
        _require_version("CSensoryFrame", version, 2, 2)
        return [self.read_object("CObservation2DRangeScan", "CObservationOdometry")[1] for _ in range(self._count(2))]

    def _action_collection(self, version: int) -> list[Any]:
        _require_version("CActionCollection", version, 0, 0)
        return [self.read_object("CActionRobotMovement2D")[1] for _ in range(self._count(2))]

    def _movement(self, version: int) -> _Odometry:
        _require_version("CActionRobotMovement2D", version, 5, 6)
        (method,) = self._values("I")
        if method != 0:
            raise ValueError(f"a movement estimated by method {method}: only 0, odometry, is known")
        _, increment = self.read_object("CPose2D")
        self._values("I6fi6f")  # motion models
        self._values("BffBii")  # velocities, encoders
        ticks = self._values("Q")[0] if version >= 6 else 0  # not of use: some tools write the middle between two scans
        return _Odometry(ticks, increment, increment=True)

    def _odometry(self, version: int) -> _Odometry:
        _require_version("CObservationOdometry", version, 0, 2)
        _, pose = self.read_object("CPose2D")
        self._text()
        (ticks,) = self._values("Q")
        if version >= 1:
            (has_encoders,) = self._values("B")
            if has_encoders or version == 1:
                self._values("ii")
            (has_velocities,) = self._values("B")
            if version == 1:
                self._values("ff")
            elif has_velocities:
                self._values("ddd")
        return _Odometry(ticks, pose, increment=False)

    def _scan(self, version: int) -> _Scan:
        _require_version("CObservation2DRangeScan", version, 6, 7)
        aperture, right_to_left, range_max = self._values("fBf")
        _, mounting = self.read_object("CPose3D")
        beams = self._count(5)
        ranges = np.frombuffer(self._take(4 * beams), "<f4").astype(np.float32)
        valid = np.frombuffer(self._take(beams), np.uint8) != 0
        _, ticks, _ = self._values("fQf")
        self._text()
        (pitch,) = self._values("d")
        if pitch != 0:
            raise ValueError(f"the sensor pitched by {pitch} rad during the scan, must stand still")
        if version >= 7 and self._values("B")[0]:
            self._take(4 * beams)  # intensities
        if beams < 2:
            raise ValueError(f"a scan of {beams} beams, must have at least 2")
        side = 1 if right_to_left else -1
        # MRPT has a flag where REP-117 has words. A beam without the flag says nothing, unless it reached range_max.
        missing = np.where(ranges >= range_max, np.inf, np.nan).astype(np.float32)
        ranges = np.where(valid & (ranges < range_max), ranges, missing)
        return _Scan(ticks, ranges, -side * aperture / 2, side * aperture / (beams - 1), range_max, mounting)

    def _pose_3d(self, version: int) -> Pose2:
        _require_version("CPose3D", version, 1, 2)
        if version == 2:
            x, y, _, w, a, b, c = self._values("7d")
            yaw = math.atan2(2 * (w * c + a * b), 1 - 2 * (b * b + c * c))
            return _level(Pose2(x, y, yaw), 1 - 2 * (a * a + b * b))
        _, matrix = self.read_object("CMatrixD")
        if matrix.shape != (4, 4):
            raise ValueError(f"a pose is a matrix of {matrix.shape}, must be (4, 4)")
        yaw = math.atan2(matrix[1, 0], matrix[0, 0])
        return _level(Pose2(matrix[0, 3], matrix[1, 3], yaw), matrix[2, 2])

    def _pose_2d(self, version: int) -> Pose2:
        _require_version("CPose2D", version, 0, 1)
        return _finite(Pose2(*self._values("fff" if version == 0 else "ddd")))

    def _matrix(self, version: int) -> NDArray[np.float64]:
        _require_version("CMatrixD", version, 0, 0)
        rows, columns = self._values("II")
        if rows * columns * 8 > self.left():
            raise ValueError(f"a matrix of {rows} x {columns}, the file ends after {self.left()} bytes")
        return np.frombuffer(self._take(8 * rows * columns), "<f8").reshape(rows, columns)


def _require_version(name: str, version: int, lowest: int, highest: int) -> None:
    if not lowest <= version <= highest:
        raise ValueError(f"{name} has version {version}, versions {lowest} to {highest} are read")


def _level(pose: Pose2, cosine_of_tilt: float) -> Pose2:
    if not cosine_of_tilt > 1 - 1e-6:
        raise ValueError(f"the sensor is tilted (cosine {cosine_of_tilt}), must lie level")
    return _finite(pose)


def _finite(pose: Pose2) -> Pose2:
    if not np.isfinite([*pose]).all():
        raise ValueError(f"a pose is {pose}, must be finite")
    return pose


@dataclass
class _Gathered:
    scans: list[_Scan] = field(default_factory=list)
    absolute: list[_Odometry] = field(default_factory=list)
    at_scans: list[_Odometry] = field(default_factory=list)
    pose: Pose2 = field(default_factory=Pose2)
    """The increments since the first scan"""

    def add(self, name: str, content: Any) -> None:
        for one in content if isinstance(content, list) else [content]:
            if isinstance(one, _Scan):
                self._add_scan(one)
            elif isinstance(one, _Odometry):
                self._add_odometry(one)
            else:
                raise ValueError(f"a {name} stands outside any record")

    def _add_scan(self, scan: _Scan) -> None:
        first = self.scans[0] if self.scans else scan
        if len(scan.ranges) != len(first.ranges):
            raise ValueError(f"a scan of {len(scan.ranges)} beams, the first has {len(first.ranges)}")
        if (scan.angle_min, scan.range_max, scan.mounting) != (first.angle_min, first.range_max, first.mounting):
            raise ValueError("the scans come from more than one sensor, must come from one")
        self.scans.append(scan)
        self.at_scans.append(_Odometry(scan.ticks, self.pose, increment=True))

    def _add_odometry(self, odometry: _Odometry) -> None:
        if not odometry.increment:
            self.absolute.append(odometry)
        elif self.scans:
            self.pose = self.pose * odometry.pose

    def log(self, path: Path) -> DriveLog:
        """ValueError for what a DriveLog refuses"""
        if not self.scans:
            raise ValueError("holds no planar scan")
        odometry = self.absolute or self.at_scans
        epoch = min([scan.ticks for scan in self.scans] + [one.ticks for one in odometry])
        stamp = np.array([(one.ticks - epoch) * _TICK for one in odometry])
        pose = np.array([[*one.pose] for one in odometry])
        pose[:, 2] = np.unwrap(pose[:, 2])
        first = self.scans[0]
        began = datetime(1601, 1, 1, tzinfo=UTC) + timedelta(microseconds=epoch // 10)
        return DriveLog(
            scan_stamp=np.array([(scan.ticks - epoch) * _TICK for scan in self.scans]),
            ranges=np.stack([scan.ranges for scan in self.scans]),
            angle_min=first.angle_min,
            angle_increment=first.angle_increment,
            range_min=0.0,
            range_max=first.range_max,
            T_base_laser=first.mounting,
            odometry_stamp=stamp,
            pose=pose,
            twist=windowed_twist(stamp, pose),
            metadata={"source": f"MRPT rawlog {path.name}", "epoch": began.isoformat()},
            name=path.name.removesuffix(".gz").removesuffix(".rawlog"),
        )
