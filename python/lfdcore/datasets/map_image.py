"""The image of a map_server map, in whatever a map is drawn with: greys of any depth, colours, transparency."""

from __future__ import annotations

import os
import re
import stat
import struct
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_CELLS = 100_000_000
"""of a map that is read: 500 x 500 m at 0.05 m"""
_STDERR = Lock()  # there is one for all threads
_PNM = re.compile(rb"P([1-6])(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)(?:\s|#[^\n]*\n)+(\d+)?")


@dataclass(frozen=True)
class MapImage:
    """Pixels, row 0 at the top."""

    white: NDArray[Any]
    """(H, W) unsigned: 0 is black ..."""
    top: int
    """... and this is white"""
    transparent: NDArray[np.bool_] | None
    """(H, W) where anything shines through; None without an alpha channel"""


def read_map_image(file: Path) -> MapImage:
    """Colours count by the mean of their channels. ValueError for what is no image that can be read, is cut, or has
    more than 100 million cells: said before memory is taken for them."""
    try:
        if not stat.S_ISREG(file.stat().st_mode):  # a device or a pipe may never end
            raise ValueError("cannot be read: is no regular file")
        content = file.read_bytes()
    except OSError as error:
        raise ValueError(f"cannot be read: {error}") from error
    _require_size(_told_size(content))
    pixels = _decoded(file, content)
    _require_size(pixels.shape[:2])
    depth = int(np.iinfo(pixels.dtype).max)
    if pixels.ndim == 2:
        return MapImage(pixels, _grey_top(content, depth), None)
    colours, alpha = pixels[..., : 3 if pixels.shape[2] >= 3 else 1], pixels[..., -1]
    white = colours.sum(axis=2, dtype=np.uint32)
    return MapImage(white, depth * colours.shape[2], alpha < depth if pixels.shape[2] in (2, 4) else None)


def _require_size(size: tuple[int, ...] | None) -> None:
    if size is not None and size[0] * size[1] > MOST_CELLS:
        raise ValueError(f"has {size[0] * size[1]} cells, must have at most {MOST_CELLS}")


def _told_size(content: bytes) -> tuple[int, int] | None:
    """(height, width) by the file's head; None where it is not known how to read that"""
    if content.startswith(b"\x89PNG\r\n\x1a\n") and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return height, width
    if content.startswith(b"BM") and len(content) >= 26:
        width, height = struct.unpack("<ii", content[18:26])
        return abs(height), abs(width)
    head = _PNM.match(content[:4096])
    return (int(head[3]), int(head[2])) if head else None


def _grey_top(content: bytes, depth: int) -> int:
    """What white is: OpenCV scales a text PGM of up to 8 bits by its maxval, and leaves all others as they are."""
    head = _PNM.match(content[:4096])
    if head is None or not head[4] or not 0 < int(head[4]) <= depth:
        return depth
    return int(head[4]) if head[1] == b"5" or int(head[4]) > 255 else depth


def _decoded(file: Path, content: bytes) -> NDArray[Any]:
    import cv2

    with _caught_stderr() as complaints:
        try:
            pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED) if content else None
        except cv2.error:
            pixels = None
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        raise ValueError("is cut or no image")
    if complaints:
        warnings.warn(f"image {file} may be damaged: {complaints[0][:200]}", stacklevel=4)
    return np.asarray(pixels)


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
