"""CARMEN logs (.log, .log.gz) with FLASER scans and raw ODOM lines, as the Radish collection has them."""

from __future__ import annotations

import gzip
import math
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.beam_layout import as_rep_117
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import windowed_twist
from lfdcore.datasets.stamp_order import Order, in_order
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2

EXCLUSIVE, INCLUSIVE = (180, 360), (181, 361)
"""Numbers of beams over 180 degrees: without and with a beam at +90 degrees."""
OTHER_LASERS = {"RLASER", *(f"{kind}LASER{k}" for kind in ("", "ROBOT", "RAW") for k in range(1, 6))}
"""First words of lines with scans that are not read"""
LONGEST_LINE = 1 << 20
"""[bytes]"""
FRONT_OFFSET = "robot_frontlaser_offset"
FLIPPED = ("laser_flipped", "laser_frontlaser_flipped", "laser_front_laser_flipped")
_FAR, _NEAR = 81.0, 50.0


def read_carmen(path: str | Path, *, T_base_laser: Pose2 | None = None, range_max: float | None = None) -> DriveLog:
    """Reads the FLASER scans and the raw odometry of a CARMEN log, gzipped or plain.

    Angles: from -90 degrees in steps of 180 / n for n = 180 or 360 beams, to +90 degrees inclusive for 181 or 361.
    Readings from `range_max` [m] on mean no return (inf). By default it is 81 if any reading exceeds 51.2, else 50
    (a SICK LMS says 81.8 to 81.91 or 50 to 51.1). Stamps are the log's. Odometry: ODOM lines whose time is 0 repeat the
    corrected pose and are dropped, as are lines that do not go forward in time; corrected poses are not read. The
    metadata's `dropped` counts both, and the lines of other lasers, which are not read. The log holds no velocities:
    the twist is the mean over the last half second. T_base_laser is what PARAM robot_frontlaser_offset says (ahead of
    the axle, [m]) unless given, None where nothing says it; PARAM laser_flipped turns the angles round. Stamps up to a
    second late are sorted. DataError with the line for garbled, truncated or empty logs, other numbers of beams and a
    number of beams that changes.
    """
    if range_max is not None and not 0 < range_max < math.inf:
        raise ValueError(f"range_max is {range_max} m, must be positive")
    path = Path(path)
    lines = _Lines(path)
    for number, words in _numbered_lines(path):
        try:
            lines.add(words)
        except (ValueError, IndexError) as error:
            raise DataError(f"{path}, line {number}: {error}") from error
    if not lines.scans:
        raise DataError(f"{path}: holds no FLASER line, so no scan")
    try:
        return _drive_log(lines, T_base_laser, range_max)
    except ValueError as error:
        raise DataError(f"{path}: {error}") from error


def _drive_log(lines: _Lines, T_base_laser: Pose2 | None, range_max: float | None) -> DriveLog:
    readings = np.array(lines.scans)
    finite = readings[np.isfinite(readings)]
    far = _FAR if finite.size and finite.max() > 51.2 else _NEAR
    far = far if range_max is None else range_max  # CARMEN gives a number from here on where REP-117 has inf
    beams = readings.shape[1]
    odometry, scans = lines.sorted_odometry(), lines.sorted_scans()
    lines.dropped["ODOM not forward in time"] = len(lines.odometry) - len(odometry)
    mounting, origin = (T_base_laser, "as given") if T_base_laser is not None else lines.mounting()
    turn = -1.0 if lines.flipped() else 1.0
    dropped = ", ".join(f"{count} {kind}" for kind, count in sorted(lines.dropped.items()) if count)
    pose = np.c_[odometry[:, 1:3], np.unwrap(odometry[:, 3])]
    return DriveLog(
        scan_stamp=np.array(lines.scan_stamps)[scans.kept],
        ranges=as_rep_117(readings[scans.kept].astype(np.float32), 0.0, far),
        angle_min=turn * -math.pi / 2,
        angle_increment=turn * math.pi / (beams if beams in EXCLUSIVE else beams - 1),
        range_min=0.0,
        range_max=far,
        T_base_laser=mounting,
        odometry_stamp=odometry[:, 0],
        pose=pose,
        twist=windowed_twist(odometry[:, 0], pose),
        metadata={
            "source": f"CARMEN log {lines.path.name}",
            "odometry": "raw; twist over the last 0.5 s",
            "T_base_laser": origin,
        }
        | ({"scan records": scans.noted()} if scans.noted() else {})
        | ({"dropped": f"lines: {dropped}"} if dropped else {}),
        name=lines.path.name.removesuffix(".gz").removesuffix(".log"),
    )


@dataclass
class _Lines:
    """The lines that matter."""

    path: Path
    scan_stamps: list[float] = field(default_factory=list)
    scans: list[list[float]] = field(default_factory=list)
    odometry: list[tuple[float, float, float, float]] = field(default_factory=list)
    parameters: dict[str, str] = field(default_factory=dict)
    """PARAM by name, the last value of each"""
    dropped: Counter[str] = field(default_factory=Counter)
    """lines by kind"""

    def add(self, words: list[str]) -> None:
        """ValueError for a line that is not what its first word says."""
        if words and words[0] == "FLASER":
            self._add_scan(words)
        elif words and words[0] == "ODOM":
            self._add_odometry(words)
        elif words and words[0] == "PARAM" and len(words) > 2:
            self.parameters[words[1]] = words[2]
        elif words and words[0] in OTHER_LASERS:
            self.dropped[words[0]] += 1

    def _add_scan(self, words: list[str]) -> None:
        beams = int(words[1]) if len(words) > 1 else 0
        if beams not in EXCLUSIVE + INCLUSIVE:
            raise ValueError(f"a scan of {beams} beams: their angles are known for {EXCLUSIVE + INCLUSIVE} only")
        if len(words) != beams + 11:
            raise ValueError(f"FLASER of {beams} beams has {len(words)} words, must have {beams + 11}")
        if self.scans and beams != len(self.scans[0]):
            raise ValueError(f"a scan of {beams} beams, the first has {len(self.scans[0])}")
        self.scans.append([_range(word) for word in words[2 : 2 + beams]])
        self.scan_stamps.append(_finite(words[8 + beams], "time"))

    def _add_odometry(self, words: list[str]) -> None:
        if len(words) != 10:
            raise ValueError(f"ODOM has {len(words)} words, must have 10")
        stamp = _finite(words[7], "time")
        if stamp <= 0:
            self.dropped["ODOM without a time"] += 1
            return
        x, y, yaw = (_finite(words[k], name) for k, name in ((1, "x"), (2, "y"), (3, "theta")))
        self.odometry.append((stamp, x, y, yaw))

    def mounting(self) -> tuple[Pose2 | None, str]:
        """T_base_laser, and where it comes from. ValueError for an offset that is no number."""
        said = self.parameters.get(FRONT_OFFSET)
        if said is None:
            return None, f"unknown: no PARAM {FRONT_OFFSET}; say --mounting X,Y,YAW (in Python T_base_laser=)"
        return Pose2(_finite(said, f"PARAM {FRONT_OFFSET}"), 0.0, 0.0), f"PARAM {FRONT_OFFSET}"

    def flipped(self) -> bool:
        """Whether the scanner hangs upside down."""
        return any(self.parameters.get(name, "off") in ("on", "1", "true", "yes") for name in FLIPPED)

    def sorted_scans(self) -> Order:
        """In the order of their stamps. ValueError for a clock that was set back."""
        return in_order("FLASER", np.array(self.scan_stamps))

    def sorted_odometry(self) -> NDArray[np.float64]:
        """(T, 4) stamp, x, y, yaw: without the lines that do not go forward in time"""
        rows = np.array(self.odometry).reshape(-1, 4)
        before = np.maximum.accumulate(np.r_[-np.inf, rows[:, 0]])[:-1]
        return np.asarray(rows[rows[:, 0] > before])


def _finite(word: str, name: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(f"{name} is {word}, must be finite")
    return value


def _range(word: str) -> float:
    value = float(word)
    if value < 0:
        raise ValueError(f"a range is {word} m, must not be negative")
    return value


def _numbered_lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    with path.open("rb") as raw:
        zipped = raw.read(2) == b"\x1f\x8b"
    number = 0
    with gzip.open(path) if zipped else path.open("rb") as file:
        while True:
            number += 1
            try:
                line = file.readline(LONGEST_LINE)
            except (EOFError, OSError, zlib.error) as error:
                raise DataError(
                    f"{path}: the gzip stream is cut or garbled after line {number - 1}: {error}"
                ) from error
            if not line:
                return
            if len(line) >= LONGEST_LINE:
                raise DataError(f"{path}, line {number}: longer than {LONGEST_LINE} bytes, so no CARMEN log")
            yield number, line.decode("ascii", "replace").split()
