"""map_server's maps: a .yaml and an image. Images are flipped here and nowhere else: their row 0 is the top."""

from __future__ import annotations

import math
import os
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from reprlib import Repr
from tempfile import TemporaryFile
from threading import Lock
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from lfdcore.errors import DataError
from lfdcore.grid import OccupancyGrid

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
"""Values of cells [%]"""
FINEST, COARSEST = 0.001, 1.0
"""Resolutions [m] that are read: finer than a millimetre, or coarser than the chair, a cell says nothing of a room"""
FARTHEST = 1e6
"""[m] of a map's origin"""
MOST_CELLS = 100_000_000
"""of a map that is read: 500 x 500 m at 0.05 m"""
FREE_THRESHOLD, OCCUPIED_THRESHOLD = 0.196, 0.65
"""What `write_map` states; the shares of black below and above which a pixel is free and occupied"""
_SHORT = Repr()
_SHORT.maxlevel = 2  # aliases make a few lines of YAML unfold to gigabytes
_STDERR = Lock()  # there is one for all threads
_FREE_PIXEL, _UNKNOWN_PIXEL, _OCCUPIED_PIXEL = 254, 205, 0  # as map_saver


def read_map(path: str | Path) -> OccupancyGrid:
    """Reads a map by its .yaml: resolution [m], origin [x, y, yaw] [m, rad], image, negate, thresholds, mode.

    Cells are 0 free, 100 occupied, -1 unknown (mode trinary). `image` is taken relative to the .yaml. DataError naming
    the key for one that is missing or of the wrong type or value, for an image that is missing, cut, no image or of
    more than 100 million cells, a resolution outside 0.001..1 m, a mode other than trinary and an origin turned by a
    yaw or farther off than 1000 km. FileNotFoundError without the .yaml.
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
    if (mode := described.get("mode", "trinary")) != "trinary":
        raise DataError(f"{path}: mode is {_SHORT.repr(mode)}, only 'trinary' is read")
    origin = _origin(path, described)
    image = _image(path, described)
    black = np.arange(256) / 255.0 if _negated(path, described) else np.arange(255, -1, -1) / 255.0
    meaning = np.full(256, UNKNOWN, np.int8)  # of each grey
    meaning[black > occupied] = OCCUPIED
    meaning[black < free] = FREE
    return OccupancyGrid(meaning[image[::-1]], resolution, origin)


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
    if isinstance(value, bool) or not isinstance(value, int | float) or not _fits(value):
        raise DataError(f"{path}: {key} is {_SHORT.repr(value)}, must be a finite number")
    return float(value)


def _fits(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an int of hundreds of digits
        return False


def _origin(path: Path, described: dict[str, Any]) -> tuple[float, float]:
    origin = _entry(path, described, "origin")
    if not isinstance(origin, list) or len(origin) != 3:
        raise DataError(f"{path}: origin is {_SHORT.repr(origin)}, must be [x, y, yaw]")
    x, y, yaw = (_finite(path, "origin", value) for value in origin)
    if yaw != 0:
        raise DataError(f"{path}: origin is turned by {yaw} rad, only 0 is read")
    if max(abs(x), abs(y)) > FARTHEST:
        raise DataError(f"{path}: origin is ({x:g}, {y:g}) m, must lie within {FARTHEST:g} m")
    return x, y


def _negated(path: Path, described: dict[str, Any]) -> bool:
    negate = described.get("negate", 0)
    if negate not in (0, 1) or not isinstance(negate, int):
        raise DataError(f"{path}: negate is {_SHORT.repr(negate)}, must be 0 or 1")
    return bool(negate)


@contextmanager
def _caught_stderr() -> Iterator[list[str]]:
    """Lines written to file descriptor 2 meanwhile: OpenCV's decoders tell nobody else what is wrong with an image."""
    lines: list[str] = []
    with _STDERR, TemporaryFile() as caught:
        before = os.dup(2)
        os.dup2(caught.fileno(), 2)
        try:
            yield lines
        finally:
            os.dup2(before, 2)
            os.close(before)
        caught.seek(0)
        lines += caught.read().decode("utf-8", "replace").splitlines()


def _image(path: Path, described: dict[str, Any]) -> NDArray[np.uint8]:
    """(height, width) of grey values, row 0 at the top"""
    import cv2

    name = _entry(path, described, "image")
    if not isinstance(name, str) or not name:
        raise DataError(f"{path}: image is {_SHORT.repr(name)}, must be the name of a file")
    file = path.parent / name
    try:
        if not stat.S_ISREG(file.stat().st_mode):  # a device or a pipe may never end
            raise DataError(f"{path}: image {file} cannot be read: is no regular file")
        content = np.frombuffer(file.read_bytes(), np.uint8)
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: image {file} cannot be read: {error}") from error
    with _caught_stderr() as complaints:
        try:
            image = cv2.imdecode(content, cv2.IMREAD_GRAYSCALE) if content.size else None
        except cv2.error:
            image = None
    if image is None:
        raise DataError(f"{path}: image {file} is cut or no image")
    if complaints:
        warnings.warn(f"{path}: image {file} may be damaged: {complaints[0][:200]}", stacklevel=3)
    if image.size > MOST_CELLS:
        raise DataError(f"{path}: image {file} has {image.size} cells, must have at most {MOST_CELLS}")
    return np.asarray(image, np.uint8)
