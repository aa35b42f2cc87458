"""The LASA handwriting motions (Khansari-Zadeh and Billard 2011): one shape a file, drawn several times."""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.errors import DataError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Handwriting:
    """One shape and its demonstrations, all of which end in (0, 0)."""

    name: str
    stamps: tuple[Array, ...]
    """(1000,) [s] each, increasing from 0"""
    positions: tuple[Array, ...]
    """(1000, 2) [mm] each, as many as there are stamps"""


def read_handwriting(path: str | os.PathLike[str]) -> Handwriting:
    """Reads one .mat file. Needs SciPy (the extra `study`). DataError naming the file for anything else."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    data = BytesIO(Path(path).read_bytes())  # what the disk refuses is an OSError, what the bytes hold is not
    garbled = (MatReadError, OSError, ValueError, KeyError, IndexError, TypeError, NotImplementedError)
    try:
        demonstrations = loadmat(data)["demos"][0]
        stamps = tuple(np.asarray(one["t"][0, 0], np.float64).ravel() for one in demonstrations)
        positions = tuple(np.array(one["pos"][0, 0].T, np.float64, order="C") for one in demonstrations)
        _require(stamps, positions)
    except (*garbled, zlib.error, struct.error) as broken:
        raise DataError(f"{path}: is no handwriting of the LASA set: {broken}") from broken
    return Handwriting(Path(path).stem, stamps, positions)


def _require(stamps: tuple[Array, ...], positions: tuple[Array, ...]) -> None:
    for k, (stamp, position) in enumerate(zip(stamps, positions, strict=True)):
        if position.shape != (len(stamp), 2) or len(stamp) < 2:
            raise ValueError(f"demonstration {k} has positions {position.shape} for {len(stamp)} stamps")
        if not (np.isfinite(position).all() and np.isfinite(stamp).all() and (np.diff(stamp) > 0).all()):
            raise ValueError(f"demonstration {k} is not finite, or its stamps do not increase")


def read_all_handwriting(folder: str | os.PathLike[str]) -> list[Handwriting]:
    """Every shape of a folder of .mat files, by name. DataError if there is none."""
    paths = sorted(Path(folder).glob("*.mat"))
    if not paths:
        raise DataError(f"{folder}: holds no .mat file")
    return [read_handwriting(path) for path in paths]
