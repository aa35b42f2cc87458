"""Opens any drive that lfdcore can read, by what the file holds rather than by its name."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lfdcore.datasets.carmen import read_carmen
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.drive_log_reader import is_drive_log, read_drive_log
from lfdcore.datasets.mrpt import read_mrpt
from lfdcore.datasets.rosbag import read_rosbag
from lfdcore.errors import DataError

KNOWN = (
    "lfdcore drive logs and ROS 2 bags (.mcap), ROS 2 bag folders and .db3, ROS 1 .bag, "
    "CARMEN logs (.log, .log.gz), MRPT rawlogs (.rawlog)"
)
_CARMEN_WORDS = (b"FLASER ", b"ODOM ", b"PARAM ", b"# message ", b"NEFF ", b"SYNC ", b"# PARAM")
_HEAD = 4096  # [bytes] looked at


def open_log(path: str | Path, **options: Any) -> DriveLog:
    """Reads a recorded drive of any known format; `options` go to its reader (`read_rosbag`, `read_carmen`, ...).

    FileNotFoundError without the file; DataError for one that is of no known format or broken; ValueError where a bag
    leaves a choice of topics (an option makes it).
    """
    path = Path(path)
    if not path.exists():
        raise FileNotFoundError(2, "no such drive log", str(path))
    return _reader(path)(path, **options)


def is_bag(path: Path) -> bool:
    """Whether a file or a folder is a ROS bag, and no drive log of lfdcore. DataError as open_log."""
    return _reader(path) is read_rosbag


def _reader(path: Path) -> Callable[..., DriveLog]:
    if path.is_dir():
        if (path / "metadata.yaml").exists():
            return read_rosbag
        raise DataError(f"{path}: a folder without metadata.yaml is no ROS 2 bag; known are {KNOWN}")
    if not path.is_file():  # a pipe would be waited for
        raise DataError(f"{path}: is no regular file; known are {KNOWN}")
    head = _head(path)
    if head.startswith(b"\x89MCAP0\r\n"):
        return read_drive_log if is_drive_log(path) else read_rosbag
    if head.startswith((b"#ROSBAG V2.0", b"SQLite format 3\0")):
        return read_rosbag
    if len(head) > 1 and head[0] > 0x80 and head[1:2] == b"C" and head[1 : 1 + (head[0] & 0x7F)].isalnum():
        return read_mrpt
    if any(line.startswith(_CARMEN_WORDS) for line in head.split(b"\n")):
        return read_carmen
    raise DataError(f"{path}: {'is empty' if not head else 'is of no known format'}; known are {KNOWN}")


def _head(path: Path) -> bytes:
    """The first bytes, unpacked where they are gzipped"""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head.startswith(b"\x1f\x8b"):
        return head
    try:
        with gzip.open(path) as unpacked:
            return unpacked.read(_HEAD)
    except (EOFError, OSError, zlib.error) as error:
        raise DataError(f"{path}: the gzip stream is cut or garbled: {error}") from error
