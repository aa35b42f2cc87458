"""How near a moving segment or arm comes to a box, between its samples too: capsules, sweeps, distances."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.humanoid.scene import Box

Array = NDArray[np.float64]

CLEARANCE = 0.02
"""[m] below which a segment counts as touching"""
STEP = 0.002
"""[m] that no point of a segment moves between two evaluations: distances are exact to half of it"""
LONGEST_SWEEP = 200.0
"""[m] of a segment's way: more is no motion of an arm, and would take long to sample"""


def segment_box_distance(begin: ArrayLike, end: ArrayLike, box: Box) -> tuple[Array, Array]:
    """Distance [m] of segments to a box, 0 inside, and the place (0 at begin to 1 at end) of the nearest point.

    begin, end: (N, 3) [m, base] -> (N,), (N,). Exact: the squared distance along a segment is convex and piecewise
    quadratic, its derivative piecewise linear, with breaks only where the segment crosses the planes of the faces.
    """
    a, b = (box.local(require_points("segment", value)) for value in (begin, end))
    return segment_distance(a, b, np.asarray(box.size) / 2)


def segment_distance(begin: Array, end: Array, half: Array) -> tuple[Array, Array]:
    """`segment_box_distance` in any dimension D for a box from -half to half: (N, D), (N, D), (D,) -> (N,), (N,)."""
    along = end - begin
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        crossings = np.concatenate([(half - begin) / along, (-half - begin) / along], axis=1)
    ends = np.broadcast_to([0.0, 1.0], (len(begin), 2))
    inner = np.clip(np.nan_to_num(crossings, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    breaks = np.sort(np.concatenate([ends, inner], axis=1), axis=1)  # (N, 2 D + 2)
    slope = _slope(begin, along, half, breaks)
    last = np.clip((slope < 0).sum(axis=1) - 1, 0, breaks.shape[1] - 2)  # the slope never falls
    rows = np.arange(len(begin))
    t0, t1, s0, s1 = breaks[rows, last], breaks[rows, last + 1], slope[rows, last], slope[rows, last + 1]
    rise = np.where(s1 > s0, s1 - s0, 1.0)
    at = np.clip(t0 + (t1 - t0) * np.clip(-s0 / rise, 0.0, 1.0), 0.0, 1.0)
    return np.linalg.norm(_outside(begin + at[:, None] * along, half), axis=1), at


def _slope(begin: Array, along: Array, half: Array, at: Array) -> Array:
    """Half the derivative of the squared distance at places (N, B) of the segments."""
    points = begin[:, None] + at[..., None] * along[:, None]
    slope: Array = (_outside(points, half) * along[:, None]).sum(axis=-1)
    return slope


def _outside(points: Array, half: Array) -> Array:
    """How far points (..., D) lie outside the box, axis by axis and signed."""
    return points - np.clip(points, -half, half)


@dataclass(frozen=True)
class Capsule:
    """A link that moves: its two ends at each of T samples and its radius [m]. ValueError for a negative radius."""

    begin: Array
    """(T, 3) [m, base]"""
    end: Array
    """(T, 3) [m, base]"""
    radius: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.radius) and self.radius >= 0):
            raise ValueError(f"radius must be finite and >= 0 m, got {self.radius} m")


@dataclass(frozen=True)
class Contact:
    """The nearest approach of a moving segment to a box."""

    distance: float
    """[m], less a capsule's radius; exact to STEP / 2; 0 inside"""
    sample: float
    """when: a fraction between samples counts"""
    point: tuple[float, float, float]
    """where on the segment [m, base]"""
    first: float | None
    """the sample at which it is first nearer than the clearance, None if never"""

    @property
    def touches(self) -> bool:
        """It comes nearer than the clearance."""
        return self.first is not None


def nearest_approach(
    begin: ArrayLike, end: ArrayLike, box: Box, clearance: float = CLEARANCE, radius: float = 0.0, step: float = STEP
) -> Contact:
    """Where and when a segment that moves from sample to sample comes nearest to a box.

    begin, end: (T, 3) [m, base]. Both ends move straight between samples, which are refined until no point moves more
    than `step` [m]. ValueError for shapes, values that are not finite, a way longer than LONGEST_SWEEP, step <= 0.
    """
    if not (math.isfinite(clearance) and clearance >= 0 and math.isfinite(step) and step > 0):
        raise ValueError(f"clearance must be >= 0 m and step > 0 m, got {clearance} m and {step} m")
    a, b = require_points("begin", begin), require_points("end", end)
    if len(a) != len(b):
        raise ValueError(f"begin has {len(a)} samples and end {len(b)}, must be as many")
    sample = _refined(a, b, step)
    a, b = _at(a, sample), _at(b, sample)
    distance, at = segment_box_distance(a, b, box)
    distance = distance - radius
    worst, near = int(np.argmin(distance)), np.flatnonzero(distance < clearance)
    x, y, z = (float(v) for v in a[worst] + at[worst] * (b[worst] - a[worst]))
    first = float(sample[near[0]]) if len(near) else None
    return Contact(max(float(distance[worst]), 0.0), float(sample[worst]), (x, y, z), first)


def _refined(a: Array, b: Array, step: float) -> Array:
    """(K,) fractional samples between which no point of the segments moves more than `step`."""
    moves = np.maximum(*(np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (a, b)))
    if moves.sum() > LONGEST_SWEEP:
        raise ValueError(f"the segment moves {moves.sum():.6g} m, must be <= {LONGEST_SWEEP:g} m")
    if moves.sum() / step > 1e6:
        raise ValueError(f"step is {step} m for a way of {moves.sum():.3g} m, must give at most 1e6 evaluations")
    parts = np.maximum(1, np.ceil(moves / step)).astype(int)
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(np.repeat(np.arange(len(parts)), parts) + within / np.repeat(parts, parts), float(len(parts)))


def _at(points: Array, sample: Array) -> Array:
    index = np.arange(len(points))
    return np.stack([np.interp(sample, index, column) for column in points.T], axis=1)


def require_points(what: str, values: ArrayLike) -> Array:
    """(T, 3), T >= 1, finite; ValueError naming what, sample and value for anything else."""
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ValueError(f"{what} has shape {points.shape}, must be (T, 3) with T >= 1")
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise ValueError(f"{what} at sample {bad} is {points[bad].tolist()} m, must be finite")
    return points
