"""Columns that a primitive can learn: orientations as three numbers near a reference (Sec. 5.6, ERRATA 44)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.primitives import continuous_quaternions, imaginary_parts, mean_orientation, quaternions_from_imaginary

Array = NDArray[np.float64]
_PARTS = ("qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class PoseColumns:
    """Recorded columns (T, r) <-> learned columns (T, r'): of a unit quaternion's four columns X.qx, X.qy, X.qz, X.qw,
    next to each other, the three imaginary parts of its rotation from a reference; others stay as they are."""

    names: tuple[str, ...]
    """(r,) as recorded"""
    references: tuple[tuple[float, float, float, float], ...]
    """x y z w of each quaternion among them, in their order"""

    def __post_init__(self) -> None:
        found = len(self.quaternions)
        if found != len(self.references):
            raise ValueError(f"{len(self.references)} references for {found} quaternions in {', '.join(self.names)}")
        for reference in self.references:
            numbers = len(reference) == 4 and all(isinstance(part, int | float) for part in reference)
            if not numbers or not abs(math.hypot(*reference) - 1) < 1e-6:
                raise ValueError(f"a reference is {reference}, must be a unit quaternion x y z w")

    @staticmethod
    def of(names: Sequence[str], motions: Sequence[ArrayLike]) -> PoseColumns:
        """With the mean orientations of recorded motions [(T_j, r)] as references. ValueError for a quaternion that
        lacks one of its columns, for no motions or another r, and as mean_orientation."""
        places = _quaternions(tuple(names))
        arrays = [np.asarray(motion, np.float64) for motion in motions]
        if not arrays or any(a.ndim != 2 or a.shape[1] != len(names) for a in arrays):
            raise ValueError(f"motions have shapes {[a.shape for a in arrays]}, must be one or more (T, {len(names)})")
        means = [mean_orientation(np.concatenate([a[:, k : k + 4] for a in arrays])) for k in places]
        return PoseColumns(tuple(names), tuple((q[0], q[1], q[2], q[3]) for q in (m.tolist() for m in means)))

    @property
    def quaternions(self) -> tuple[int, ...]:
        """Where each quaternion's four columns begin."""
        return _quaternions(self.names)

    def learned(self, recorded: ArrayLike) -> Array:
        """(T, r) -> (T, r'). ValueError for another r and as imaginary_parts."""
        given = np.asarray(recorded, np.float64)
        if given.ndim != 2 or given.shape[1] != len(self.names):
            raise ValueError(f"motion has shape {given.shape}, must be (T, {len(self.names)}): {', '.join(self.names)}")
        parts, done = [], 0
        for k, reference in zip(self.quaternions, self.references, strict=True):
            parts += [given[:, done:k], imaginary_parts(given[:, k : k + 4], reference)]
            done = k + 4
        return np.concatenate([*parts, given[:, done:]], axis=1)

    def recorded(self, learned: ArrayLike) -> Array:
        """(T, r') -> (T, r): quaternions of length 1. ValueError for another r'."""
        given, width = np.asarray(learned, np.float64), len(self.names) - len(self.references)
        if given.ndim != 2 or given.shape[1] != width:
            raise ValueError(f"motion has shape {given.shape}, must be (T, {width})")
        parts, done = [], 0
        for number, (k, reference) in enumerate(zip(self.quaternions, self.references, strict=True)):
            at = k - number
            parts += [given[:, done:at], quaternions_from_imaginary(given[:, at : at + 3], reference)]
            done = at + 3
        return np.concatenate([*parts, given[:, done:]], axis=1)

    def difference(self, recorded: ArrayLike, other: ArrayLike) -> Array:
        """(T, r), (T, r) -> (T, r') how `recorded` differs from `other`, row by row: of quaternions the imaginary parts
        of the shorter rotation between them, wherever they lie from the reference. ValueError for other shapes and for
        quaternions of length zero."""
        a, b = np.asarray(recorded, np.float64), np.asarray(other, np.float64)
        if a.ndim != 2 or a.shape != b.shape or a.shape[1] != len(self.names):
            raise ValueError(f"motions have shapes {a.shape} and {b.shape}, must both be (T, {len(self.names)})")
        parts, done = [], 0
        for k in self.quaternions:
            parts += [a[:, done:k] - b[:, done:k], _turn(b[:, k : k + 4], a[:, k : k + 4])]
            done = k + 4
        return np.concatenate([*parts, a[:, done:] - b[:, done:]], axis=1)

    def mean(self, recorded: ArrayLike) -> Array:
        """(T, r) -> (1, r) over time. ValueError as mean_orientation."""
        given = np.asarray(recorded, np.float64)
        middle: Array = given.mean(axis=0)
        for k in self.quaternions:
            middle[k : k + 4] = mean_orientation(given[:, k : k + 4])
        return middle[None]


def continuous_columns(names: Sequence[str], motion: ArrayLike) -> Array:
    """(T, r) with each quaternion of length 1 and on its predecessor's side (continuous_quaternions), so that straight
    lines between samples are short. ValueError as there."""
    made = np.array(motion, np.float64)
    for k in _quaternions(tuple(names)):
        made[:, k : k + 4] = continuous_quaternions(made[:, k : k + 4])
    return made


def _turn(begin: Array, end: Array) -> Array:
    """(T, 4), (T, 4) x y z w -> (T, 3) imaginary parts of conj(begin) end with w >= 0."""
    lengths = np.linalg.norm(begin, axis=1) * np.linalg.norm(end, axis=1)
    if not (lengths > 0).all():
        raise ValueError(f"quaternions[{int(np.argmin(lengths > 0))}] is no rotation: its length must be > 0")
    u, w = -begin[:, :3], begin[:, 3:]
    v, z = end[:, :3], end[:, 3:]
    imaginary = w * v + z * u + np.cross(u, v)
    sign = np.where((begin * end).sum(axis=1) < 0, -1.0, 1.0)
    return np.asarray(imaginary * (sign / lengths)[:, None])


def _quaternions(names: tuple[str, ...]) -> tuple[int, ...]:
    found = []
    for k, name in enumerate(names):
        prefix, _, part = name.rpartition(".")
        if part not in _PARTS:
            continue
        if part == "qx":
            found.append(k)
        begin = k - _PARTS.index(part)
        wanted = tuple(f"{prefix}.{one}" for one in _PARTS)
        if begin < 0 or names[begin : begin + 4] != wanted:
            raise ValueError(f"column {name} stands alone, {', '.join(wanted)} must follow each other")
    return tuple(found)
