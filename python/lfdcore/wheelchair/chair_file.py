"""A real chair in a JSON file: outline, limits, wheels, scanners. Nothing has a default that could be another's."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lfdcore.errors import DataError
from lfdcore.geometry import Footprint, MotionLimits, Pose2
from lfdcore.hardware import WheelEncoders
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry

SCANNERS = "scanners"
SCANNER = ("x", "y", "yaw_degrees", "roll_degrees", "range_noise")
"""Of each scanner, by its name: [m], [degrees], [m]"""
FIELDS: Mapping[str, tuple[str, ...]] = {
    "footprint": ("front", "rear", "half_width"),
    "limits": (
        "max_linear",
        "max_reverse",
        "max_angular",
        "linear_acceleration",
        "linear_braking",
        "angular_acceleration",
    ),
    "wheels": ("left_radius", "right_radius", "track", "edges_per_turn"),
    "errors": ("latency", "odometry_error"),
}
"""Of the file, by part; all of them are needed, and SCANNERS. [m], [m/s], [rad/s], [m/s2], [rad/s2], [s];
odometry_error: a share"""


@dataclass(frozen=True)
class ScannerPlace:
    """Where a scanner is on the chair, and how well it measures."""

    T_base_laser: Pose2
    upside_down: bool
    range_noise: float
    """[m]"""


@dataclass(frozen=True)
class ChairFile:
    """What a chair's file says."""

    footprint: Footprint
    limits: MotionLimits
    wheels: WheelEncoders
    scanners: Mapping[str, ScannerPlace]
    """by name"""
    latency: float
    odometry_error: float

    def geometry(self, T_base_laser: Pose2, scan_period: float) -> ChairGeometry:
        """The chair with scans from this place, with this period [s]: of one scanner, or of all merged. ValueError
        names what is out of range."""
        return ChairGeometry(
            footprint=self.footprint,
            limits=self.limits,
            T_base_laser=T_base_laser,
            latency=self.latency,
            scan_period=max(scan_period, PERIOD),
            range_noise=max(scanner.range_noise for scanner in self.scanners.values()),
            odometry_error=self.odometry_error,
        )


def read_chair_file(path: Path) -> ChairFile:
    """FileNotFoundError; DataError for what is no such file, naming the field; ValueError for a value out of range."""
    said = _read(path)
    _require_names(path, "it", said, (*FIELDS, SCANNERS))
    footprint, limits, wheels, errors = (_numbers(path, part, said[part], names) for part, names in FIELDS.items())
    return ChairFile(
        footprint=Footprint(**footprint),
        limits=MotionLimits(**limits),
        wheels=WheelEncoders(**wheels),
        scanners=_scanners(path, said[SCANNERS]),
        latency=errors["latency"],
        odometry_error=errors["odometry_error"],
    )


def _scanners(path: Path, said: Any) -> dict[str, ScannerPlace]:
    if not isinstance(said, dict) or not said:
        raise DataError(f"{path}: {SCANNERS} is {said!r}, must be an object with each scanner by its name")
    return {name: _scanner(path, f"{SCANNERS}.{name}", each) for name, each in said.items()}


def _scanner(path: Path, what: str, said: Any) -> ScannerPlace:
    numbers = _numbers(path, what, said, SCANNER)
    if numbers["roll_degrees"] not in (0, 180):
        raise DataError(
            f"{path}: {what}.roll_degrees is {numbers['roll_degrees']:g}, must be 0 (upright) or 180 (upside down): "
            "a tilted scanner sees no plane"
        )
    place = Pose2(numbers["x"], numbers["y"], math.radians(numbers["yaw_degrees"]))
    return ScannerPlace(place, numbers["roll_degrees"] == 180, numbers["range_noise"])


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise DataError(f"{path} is no JSON file: {error}") from error


def _numbers(path: Path, part: str, said: Any, names: tuple[str, ...]) -> dict[str, float]:
    _require_names(path, part, said, names)
    for name in names:
        value = said[name]
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise DataError(f"{path}: {part}.{name} is {value!r}, must be a finite number")
    return {name: float(said[name]) for name in names}


def _require_names(path: Path, what: str, said: Any, names: tuple[str, ...]) -> None:
    if not isinstance(said, dict):
        raise DataError(f"{path}: {what} is {type(said).__name__}, must be an object with {', '.join(names)}")
    for name in names:
        if name not in said:
            raise DataError(f"{path}: {what} lacks {name}, needs {', '.join(names)}")
    for name in said:
        if name not in names:
            raise DataError(f"{path}: {what} has {name!r}, must have {', '.join(names)} alone")
