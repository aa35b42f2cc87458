"""A real chair in a JSON file: outline, limits, wheels, scanner. Nothing has a default that could be another's."""

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
    "scanner": ("x", "y", "yaw_degrees", "range_noise"),
    "errors": ("latency", "odometry_error"),
}
"""Of the file, by part; all of them are needed. [m], [m/s], [rad/s], [m/s2], [rad/s2], [s]; odometry_error: a share"""


@dataclass(frozen=True)
class ChairFile:
    """What a chair's file says."""

    footprint: Footprint
    limits: MotionLimits
    wheels: WheelEncoders
    T_base_laser: Pose2
    range_noise: float
    latency: float
    odometry_error: float

    def geometry(self, scan_period: float) -> ChairGeometry:
        """The chair with a scanner of this period [s]. ValueError names what is out of range."""
        return ChairGeometry(
            footprint=self.footprint,
            limits=self.limits,
            T_base_laser=self.T_base_laser,
            latency=self.latency,
            scan_period=max(scan_period, PERIOD),
            range_noise=self.range_noise,
            odometry_error=self.odometry_error,
        )


def read_chair_file(path: Path) -> ChairFile:
    """FileNotFoundError; DataError for what is no such file, naming the field; ValueError for a value out of range."""
    parts = _parts(path)
    scanner, errors = parts["scanner"], parts["errors"]
    return ChairFile(
        footprint=Footprint(**parts["footprint"]),
        limits=MotionLimits(**parts["limits"]),
        wheels=WheelEncoders(**parts["wheels"]),
        T_base_laser=Pose2(scanner["x"], scanner["y"], math.radians(scanner["yaw_degrees"])),
        range_noise=scanner["range_noise"],
        latency=errors["latency"],
        odometry_error=errors["odometry_error"],
    )


def _parts(path: Path) -> dict[str, dict[str, float]]:
    try:
        said = json.loads(path.read_text())
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise DataError(f"{path} is no JSON file: {error}") from error
    _require_names(path, "it", said, tuple(FIELDS))
    for part, names in FIELDS.items():
        _require_names(path, part, said[part], names)
        for name in names:
            value = said[part][name]
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise DataError(f"{path}: {part}.{name} is {value!r}, must be a finite number")
    return {part: {name: float(said[part][name]) for name in names} for part, names in FIELDS.items()}


def _require_names(path: Path, what: str, said: Any, names: tuple[str, ...]) -> None:
    if not isinstance(said, dict):
        raise DataError(f"{path}: {what} is {type(said).__name__}, must be an object with {', '.join(names)}")
    for name in names:
        if name not in said:
            raise DataError(f"{path}: {what} lacks {name}, needs {', '.join(names)}")
    for name in said:
        if name not in names:
            raise DataError(f"{path}: {what} has {name!r}, must have {', '.join(names)} alone")
