"""A real chair in a JSON file: outline, limits, wheels, scanners. Nothing has a default that could be another's."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from reprlib import Repr
from typing import Any, TypeVar

from lfdcore.datasets.strict_json import parse_json
from lfdcore.errors import DataError
from lfdcore.geometry import Footprint, MotionLimits, Pose2, wrap_angle
from lfdcore.hardware import WheelEncoders
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry

Thing = TypeVar("Thing")
SHORT = Repr()
LARGEST = 1e6
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
    chair = ChairFile(
        footprint=_made(path, "footprint", Footprint, footprint),
        limits=_made(path, "limits", MotionLimits, limits),
        wheels=_made(path, "wheels", WheelEncoders, wheels),
        scanners=_scanners(path, said[SCANNERS]),
        latency=errors["latency"],
        odometry_error=errors["odometry_error"],
    )
    for name, scanner in chair.scanners.items():
        place = {"T_base_laser": scanner.T_base_laser, "scan_period": PERIOD}
        _made(path, f"footprint, {SCANNERS}.{name} or errors", chair.geometry, place)
    return chair


def _made(path: Path, part: str, make: Callable[..., Thing], values: Mapping[str, Any]) -> Thing:
    """What the values make. DataError names file and part where one is out of range."""
    try:
        return make(**values)
    except ValueError as error:
        raise DataError(f"{path}: {part}: {error}") from error


def _scanners(path: Path, said: Any) -> dict[str, ScannerPlace]:
    if not isinstance(said, dict) or not said:
        raise DataError(f"{path}: {SCANNERS} is {SHORT.repr(said)}, must be an object with each scanner by its name")
    return {name: _scanner(path, f"{SCANNERS}.{name}", each) for name, each in said.items()}


def _scanner(path: Path, what: str, said: Any) -> ScannerPlace:
    numbers = _numbers(path, what, said, SCANNER)
    if numbers["roll_degrees"] not in (0, 180):
        raise DataError(
            f"{path}: {what}.roll_degrees is {numbers['roll_degrees']:g}, must be 0 (upright) or 180 (upside down): "
            "a tilted scanner sees no plane"
        )
    if not 0 <= numbers["range_noise"] <= 1:
        raise DataError(f"{path}: {what}.range_noise is {numbers['range_noise']:g} m, must lie in [0, 1] m")
    yaw = float(wrap_angle(math.radians(numbers["yaw_degrees"])))
    place = Pose2(numbers["x"], numbers["y"], yaw)
    return ScannerPlace(place, numbers["roll_degrees"] == 180, numbers["range_noise"])


def _read(path: Path) -> Any:
    if path.exists() and not path.is_file():
        raise DataError(f"{path} is no regular file, so no chair's")
    try:
        return parse_json(path.read_text())
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path} is no JSON file: {error}") from error


def _numbers(path: Path, part: str, said: Any, names: tuple[str, ...]) -> dict[str, float]:
    _require_names(path, part, said, names)
    for name in names:
        value = said[name]
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST:
            raise DataError(f"{path}: {part}.{name} is {SHORT.repr(value)}, must be a number within {LARGEST:g}")
    return {name: float(said[name]) for name in names}


def _require_names(path: Path, what: str, said: Any, names: tuple[str, ...]) -> None:
    if not isinstance(said, dict):
        raise DataError(f"{path}: {what} is {type(said).__name__}, must be an object with {', '.join(names)}")
    for name in names:
        if name not in said:
            raise DataError(f"{path}: {what} lacks {name}, needs {', '.join(names)}")
    for name in said:
        if name not in names:
            raise DataError(f"{path}: {what} has {SHORT.repr(name)}, must have {', '.join(names)} alone")
