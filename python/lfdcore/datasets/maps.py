"""map_server's maps: a .yaml and an image. Images are flipped here and nowhere else: their row 0 is the top."""

from __future__ import annotations

import math
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from lfdcore.datasets.map_image import MOST_CELLS, MapImage, read_map_image
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.grid import OccupancyGrid

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Values of cells [%]"""
FINEST, COARSEST = 0.001, 1.0
"""Resolutions [m] that are read: finer than a millimetre, or coarser than the chair, a cell says nothing of a room"""
FARTHEST = 1e6
"""[m] of a map's origin"""
MODES = ("trinary", "scale", "raw")
FREE_THRESHOLD, OCCUPIED_THRESHOLD = 0.196, 0.65
"""What `write_map` states; the shares of black below and above which a pixel is free and occupied"""
_SHORT = Repr()
_SHORT.maxlevel = 2  # aliases make a few lines of YAML unfold to gigabytes
_FREE_PIXEL, _UNKNOWN_PIXEL, _OCCUPIED_PIXEL = 254, 205, 0  # as map_saver


def read_map(path: str | Path) -> OccupancyGrid:
    """Reads a map by its .yaml: resolution [m], origin [x, y, yaw] [m, rad], image, negate, thresholds, mode.

    Cells are 0 free, 100 occupied, -1 unknown; with mode scale all in between too, with raw what the image says, as
    map_server has them. Where the image is transparent nothing is known. An origin that is turned by a yaw is turned
    back, cell by cell. `image` is taken relative to the .yaml. DataError naming the key for one that is missing or of
    the wrong type or value, for an image that is missing, cut, no image or of more than 100 million cells, a resolution
    outside 0.001..1 m, another mode, and an origin farther off than 1000 km. FileNotFoundError without the .yaml.
    """
    path = Path(path)
    described = _described(path)
    resolution = _number(path, described, "resolution")
    if not FINEST <= resolution <= COARSEST:
        raise DataError(f"{path}: resolution is {resolution} m, must be between {FINEST:g} and {COARSEST:g} m")
    free, occupied = (_number(path, described, key) for key in ("free_thresh", "occupied_thresh"))
    if not 0 <= free <= occupied <= 1:
        raise DataError(
            f"{path}: free_thresh is {free}, occupied_thresh {occupied}; must be 0 <= free <= occupied <= 1"
        )
    if (mode := described.get("mode", "trinary")) not in MODES:
        raise DataError(f"{path}: mode is {_SHORT.repr(mode)}, must be one of {', '.join(MODES)}")
    origin, negated = _origin(path, described), _negated(path, described)
    image = _image(path, described)
    shade = np.arange(image.top + 1) / image.top
    cells = _meanings(mode, occupied, free, shade, negated)[np.minimum(image.white[::-1], image.top)]
    if image.transparent is not None:
        cells[image.transparent[::-1]] = UNKNOWN
    if origin.yaw == 0:
        return OccupancyGrid(cells, resolution, (origin.x, origin.y))
    try:
        return _turned(cells, resolution, origin)
    except ValueError as error:
        raise DataError(f"{path}: {error}") from error


def write_map(grid: OccupancyGrid, path: str | Path) -> None:
    """Writes `path` (.yaml) and a .pgm beside it, as map_saver does.

    Cells from 65 % on become occupied, from 0 up to 19.6 % free, all others unknown.
    ValueError for another suffix.
    """
    import cv2

    path = Path(path)
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(f"path is {path}, must end in .yaml")
    image = path.with_suffix(".pgm")
    pixels = np.full(grid.data.shape, _UNKNOWN_PIXEL, np.uint8)
    pixels[(grid.data >= 0) & (grid.data <= 100 * FREE_THRESHOLD)] = _FREE_PIXEL
    pixels[grid.occupied_mask()] = _OCCUPIED_PIXEL
    done, encoded = cv2.imencode(".pgm", pixels[::-1])
    if not done:
        raise ValueError(f"a map of {grid.width} x {grid.height} cells cannot be made an image")
    image.write_bytes(encoded.tobytes())
    described = {
        "image": image.name,
        "mode": "trinary",
        "resolution": grid.resolution,
        "origin": [*map(float, grid.origin), 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESHOLD,
        "free_thresh": FREE_THRESHOLD,
    }
    path.write_text(yaml.safe_dump(described, sort_keys=False))


def _described(path: Path) -> dict[str, Any]:
    if path.exists() and not path.is_file():  # a pipe would be waited for
        raise DataError(f"{path}: is no regular file, so no map")
    try:
        described = yaml.safe_load(path.read_bytes())
    except (
        yaml.YAMLError,
        ValueError,
        RecursionError,
        LookupError,
        AttributeError,
    ) as error:  # the last two: mistyped tags
        raise DataError(f"{path}: is no YAML: {' '.join(str(error).split())}") from error
    if not isinstance(described, dict):
        raise DataError(f"{path}: must hold keys and values, holds {type(described).__name__}")
    return described


def _entry(path: Path, described: dict[str, Any], key: str) -> Any:
    if key not in described:
        raise DataError(f"{path}: key {key} is missing")
    return described[key]


def _number(path: Path, described: dict[str, Any], key: str) -> float:
    return _finite(path, key, _entry(path, described, key))


def _finite(path: Path, key: str, value: Any) -> float:
    if isinstance(value, str):  # 5e-2 is a text in YAML 1.1, and a number for map_server
        value = _told_number(value)
    if isinstance(value, bool) or not isinstance(value, int | float) or not _fits(value):
        raise DataError(f"{path}: {key} is {_SHORT.repr(value)}, must be a finite number")
    return float(value)


def _told_number(text: str) -> Any:
    """The number that a text is; else the text."""
    try:
        return float(text)
    except ValueError:
        return text


def _fits(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an int of hundreds of digits
        return False


def _origin(path: Path, described: dict[str, Any]) -> Pose2:
    origin = _entry(path, described, "origin")
    if not isinstance(origin, list) or len(origin) != 3:
        raise DataError(f"{path}: origin is {_SHORT.repr(origin)}, must be [x, y, yaw]")
    x, y, yaw = (_finite(path, "origin", value) for value in origin)
    if max(abs(x), abs(y)) > FARTHEST:
        raise DataError(f"{path}: origin is ({x:g}, {y:g}) m, must lie within {FARTHEST:g} m")
    return Pose2(x, y, float(wrap_angle(yaw)))


def _negated(path: Path, described: dict[str, Any]) -> bool:
    negate = described.get("negate", 0)
    if negate not in (0, 1) or not isinstance(negate, int):
        raise DataError(f"{path}: negate is {_SHORT.repr(negate)}, must be 0 or 1")
    return bool(negate)


def _image(path: Path, described: dict[str, Any]) -> MapImage:
    name = _entry(path, described, "image")
    if not isinstance(name, str) or not name:
        raise DataError(f"{path}: image is {_SHORT.repr(name)}, must be the name of a file")
    file = path.parent / name
    try:
        return read_map_image(file)
    except ValueError as error:
        raise DataError(f"{path}: image {file} {error}") from error


def _meanings(mode: str, occupied: float, free: float, shade: NDArray[np.float64], negated: bool) -> NDArray[np.int8]:
    """(N,) what cells of shades (N,) are, 0 black to 1 white, as map_server has it."""
    black = shade if negated else 1 - shade
    meaning = np.full(shade.shape, UNKNOWN, np.int8)
    if mode == "raw":
        level = np.rint(255 * shade)
        return np.where(level <= OCCUPIED, level, UNKNOWN).astype(np.int8)
    if mode == "scale" and occupied > free:
        between = (black >= free) & (black <= occupied)
        meaning[between] = np.rint((black[between] - free) / (occupied - free) * OCCUPIED).astype(np.int8)
    meaning[black > occupied] = OCCUPIED
    meaning[black < free] = FREE
    return meaning


def _turned(cells: NDArray[np.int8], resolution: float, origin: Pose2) -> OccupancyGrid:
    """A grid whose corner is turned by origin.yaw, as one that is not: each cell is what lies at its middle."""
    height, width = cells.shape
    ends = origin.transform(resolution * np.array([[0, 0], [width, 0], [0, height], [width, height]], float))
    low = np.floor((ends.min(axis=0) - [origin.x, origin.y]) / resolution) * resolution + [origin.x, origin.y]
    count = np.ceil((ends.max(axis=0) - low) / resolution - 1e-9).astype(int)
    if int(count[0]) * int(count[1]) > MOST_CELLS:
        raise ValueError(
            f"turned by {origin.yaw} rad it has {count[0] * count[1]} cells, must have {MOST_CELLS} at most"
        )
    turned = np.full((count[1], count[0]), UNKNOWN, np.int8)
    x = low[0] + resolution * (np.arange(count[0]) + 0.5)
    for row in range(count[1]):  # a row at a time: a map may have a hundred million cells
        y = np.full(count[0], low[1] + resolution * (row + 0.5))
        place = np.floor(origin.inverse().transform(np.stack([x, y], axis=1)) / resolution).astype(int)
        inside = (place >= 0).all(axis=1) & (place < [width, height]).all(axis=1)
        turned[row, inside] = cells[place[inside, 1], place[inside, 0]]
    return OccupancyGrid(turned, resolution, (float(low[0]), float(low[1])))
