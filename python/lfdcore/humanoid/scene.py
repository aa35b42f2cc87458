"""What stands between partner and robot: e, the environment's parameters, and the box that they describe (Sec. 5.6).

e is names and finite numbers in SI. Of an upright object it may hold object.height, object.width, object.depth [m],
object.x and object.y [m, base]. Base frame: Baxter's, x forward, y left, z up, BASE_HEIGHT above the floor.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.interaction import InteractionRecording, require_environment
from lfdcore.datasets.strict_json import parse_json
from lfdcore.errors import DataError

Array = NDArray[np.float64]

BASE_HEIGHT = 0.92
"""[m] of Baxter's base frame above the floor (on its pedestal)"""
_BOX = "box"
"""key of a recording's metadata: JSON of centre, size and yaw"""
_LARGEST_JSON = 2**20
"""[bytes]"""


@dataclass(frozen=True)
class Box:
    """An upright box: centre (x, y, z) [m, base], size (depth, width, height) [m] along its own axes, yaw [rad].

    ValueError for values that are not finite or a size that is not positive.
    """

    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    yaw: float = 0.0

    def __post_init__(self) -> None:
        values = [*self.centre, *self.size, self.yaw]
        if len(values) != 7 or not all(math.isfinite(value) for value in values):
            raise ValueError(f"box must have 3 coordinates, 3 sizes and a yaw that are finite, got {values}")
        if min(self.size) <= 0:
            raise ValueError(f"box size must be > 0 m, got {min(self.size)} m")

    @property
    def top(self) -> float:
        """[m] of its upper face."""
        return self.centre[2] + self.size[2] / 2

    def moved(self, by: ArrayLike) -> Box:
        """The same box shifted by (3,) [m]."""
        x, y, z = (float(value) for value in np.asarray(self.centre) + np.asarray(by, np.float64))
        return Box((x, y, z), self.size, self.yaw)

    def local(self, points: Array) -> Array:
        """Points (..., 3) [m, base] in the box's own frame, its centre at 0."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        x, y, z = np.moveaxis(points - np.asarray(self.centre), -1, 0)
        return np.stack([cos * x + sin * y, cos * y - sin * x, z], axis=-1)


def standing_box(
    height: float, width: float, depth: float, place: tuple[float, float], yaw: float = 0.0, floor: float = -BASE_HEIGHT
) -> Box:
    """A box on the floor: its height, width (along y at yaw 0), depth (along x) and place of its centre (x, y) [m]."""
    return Box((place[0], place[1], floor + height / 2), (depth, width, height), yaw)


# -- the environment ------------------------------------------------------------------------------------------------


def read_environment(path: str | os.PathLike[str]) -> dict[str, float]:
    """Reads what is known of the scene: a JSON object of names and finite numbers (SI), at least one.

    DataError naming file and key for anything else, also for a name that comes twice; OSError without the file.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is no regular file, so no environment")
    try:
        if path.stat().st_size > _LARGEST_JSON:
            raise ValueError(f"has {path.stat().st_size} bytes, must be <= {_LARGEST_JSON}")
        text = path.read_bytes().decode()
        values = require_environment(parse_json(text))
        if not values:
            raise ValueError("names nothing, must hold at least one number")
    except (ValueError, RecursionError) as broken:
        raise DataError(f"{path}: is no environment: {' '.join(str(broken).split())}") from broken
    return values


def environment_of(box: Box) -> dict[str, float]:
    """All that e may hold of a box that stands on the floor."""
    depth, width, _ = box.size
    x, y, _ = box.centre
    values = {"height": box.top + BASE_HEIGHT, "width": width, "depth": depth, "x": x, "y": y}
    return {f"object.{name}": value for name, value in values.items()}


def box_from_environment(environment: Mapping[str, float], like: Box) -> Box:
    """The object that an environment describes; what it leaves open is as in `like`."""
    e = {**environment_of(like), **environment}
    place = (e["object.x"], e["object.y"])
    return standing_box(e["object.height"], e["object.width"], e["object.depth"], place, like.yaw)


# -- the box of a recording -----------------------------------------------------------------------------------------


def box_metadata(box: Box) -> dict[str, str]:
    """What a recording's metadata holds of the object that stood there, for `box_of`."""
    return {_BOX: json.dumps([*box.centre, *box.size, box.yaw])}


def box_of(recording: InteractionRecording) -> Box:
    """The object that stood there. DataError where the recording's metadata has none."""
    try:
        values = [float(value) for value in json.loads(recording.metadata[_BOX])]
        return Box((values[0], values[1], values[2]), (values[3], values[4], values[5]), values[6])
    except (KeyError, ValueError, IndexError, TypeError) as broken:
        raise DataError(f"{recording.name}: its metadata holds no box: {broken}") from broken
