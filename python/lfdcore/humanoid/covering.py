"""Covering an object with a bag (Sec. 5.6): is the object covered, and does the bag's mouth touch it on the way?

The robot's side of the bag's mouth is the straight segment between its two grippers; the right one is held still, so
the left one's motion sweeps a fan. The object is a box that is solid down to the floor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

BASE_HEIGHT = 0.92
"""[m] of Baxter's base frame above the floor (on its pedestal)"""
CLEARANCE = 0.02
"""[m] below which the mouth counts as touching"""
STEP = 0.002
"""[m] that no point of the mouth moves between two evaluations: distances are exact to half of it"""
DRAPE = 0.15
"""[m] above the object's top that the left gripper may end for the lip to have come down behind it"""
LONGEST_SWEEP = 200.0
"""[m] of a gripper's way: more is no covering, and would take long to sample"""


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


def segment_box_distance(begin: ArrayLike, end: ArrayLike, box: Box) -> tuple[Array, Array]:
    """Distance [m] of segments to a box, 0 inside, and the place (0 at begin to 1 at end) of the nearest point.

    begin, end: (N, 3) [m, base] -> (N,), (N,). Exact: the squared distance along a segment is convex and piecewise
    quadratic, its derivative piecewise linear, with breaks only where the segment crosses the planes of the faces.
    """
    a, b = (box.local(_points("segment", value)) for value in (begin, end))
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


def nearest_approach(
    begin: ArrayLike, end: ArrayLike, box: Box, clearance: float = CLEARANCE, radius: float = 0.0, step: float = STEP
) -> Contact:
    """Where and when a segment that moves from sample to sample comes nearest to a box.

    begin, end: (T, 3) [m, base]. Both ends move straight between samples, which are refined until no point moves more
    than `step` [m]. ValueError for shapes, values that are not finite, a way longer than LONGEST_SWEEP, step <= 0.
    """
    if not (math.isfinite(clearance) and clearance >= 0 and math.isfinite(step) and step > 0):
        raise ValueError(f"clearance must be >= 0 m and step > 0 m, got {clearance} m and {step} m")
    a, b = _points("begin", begin), _points("end", end)
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
        raise ValueError(f"the grippers move {moves.sum():.6g} m, must be <= {LONGEST_SWEEP:g} m")
    if moves.sum() / step > 1e6:
        raise ValueError(f"step is {step} m for a way of {moves.sum():.3g} m, must give at most 1e6 evaluations")
    parts = np.maximum(1, np.ceil(moves / step)).astype(int)
    within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(np.repeat(np.arange(len(parts)), parts) + within / np.repeat(parts, parts), float(len(parts)))


def _at(points: Array, sample: Array) -> Array:
    index = np.arange(len(points))
    return np.stack([np.interp(sample, index, column) for column in points.T], axis=1)


def _points(what: str, values: ArrayLike) -> Array:
    points = np.asarray(values, np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ValueError(f"{what} has shape {points.shape}, must be (T, 3) with T >= 1")
    if not np.isfinite(points).all():
        bad = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise ValueError(f"{what} at sample {bad} is {points[bad].tolist()} m, must be finite")
    return points


@dataclass(frozen=True)
class CoveringVerdict:
    """Whether an object was covered, and safely."""

    covered: bool
    """the mouth ends over the object, and the left gripper past it and low enough behind it"""
    collided: bool
    """mouth or arm came nearer than the clearance"""
    contact: Contact
    """of the mouth, or of the link that came nearest"""
    part: str
    """which came nearest: mouth or link 1, 2, ..."""
    past: float
    """[m] by which the left gripper ends beyond the object and its clearance; negative: short of it"""
    reason: str
    """why it is not covered, empty where it is"""

    @property
    def success(self) -> bool:
        """Covered without a collision."""
        return self.covered and not self.collided


def covering_verdict(
    trajectory: ArrayLike,
    right_gripper: ArrayLike,
    box: Box,
    clearance: float = CLEARANCE,
    links: Sequence[Capsule] = (),
    step: float = STEP,
) -> CoveringVerdict:
    """Judges a covering motion.

    trajectory: (T, 3 or more), the left gripper's x, y, z [m, base] first, T >= 1; right_gripper: (3,) [m, base], held
    still. Collided: the swept mouth, or a capsule of `links` (each with T samples), comes nearer to the box than
    `clearance` [m]. Covered, as seen from above along the mouth as it ends: (1) the left gripper began short of the
    object; (2) it ends past the object by at least the clearance; (3) the mouth lies across the object, above
    its top; (4) the left gripper is at most DRAPE above the top. ValueError for shapes and values that are not finite.
    """
    given = np.asarray(trajectory, np.float64)
    if given.ndim != 2 or given.shape[1] < 3:
        raise ValueError(f"trajectory has shape {given.shape}, must be (T, 3 or more)")
    left = _points("trajectory", given[:, :3])
    right = _points("right_gripper", np.atleast_2d(np.asarray(right_gripper, np.float64)))
    if len(right) != 1:
        raise ValueError(f"right_gripper has shape {np.shape(right_gripper)}, must be (3,)")
    still = np.broadcast_to(right, left.shape)
    contacts = [("mouth", nearest_approach(still, left, box, clearance, step=step))]
    for k, link in enumerate(links):
        if len(link.begin) != len(left):
            raise ValueError(f"link {k + 1} has {len(link.begin)} samples, must be {len(left)} as the trajectory")
        touched = nearest_approach(link.begin, link.end, box, clearance, link.radius, step)
        contacts.append((f"link {k + 1}", touched))
    part, contact = min(contacts, key=lambda named: named[1].distance)
    past, reason = _coverage(left, right[0], box, clearance)
    return CoveringVerdict(not reason, contact.distance < clearance, contact, part, past, reason)


def _coverage(left: Array, right: Array, box: Box, clearance: float) -> tuple[float, str]:
    """How far past the object the left gripper ends [m], and why the object is not covered."""
    mouth = left[-1] - right
    length = float(np.hypot(mouth[0], mouth[1]))
    if length < 1e-9:
        return -math.inf, "the mouth ends upright: the grippers are above each other"
    direction = mouth[:2] / length
    centre = float((np.asarray(box.centre[:2]) - right[:2]) @ direction)
    half = _half_extent(box, direction)
    past = length - centre - half - clearance
    if float((left[0, :2] - right[:2]) @ direction) > centre - half:
        return past, "the left gripper does not begin short of the object"
    if past < 0:
        return past, f"the left gripper ends {-past:.3f} m short of the object's far side and clearance"
    return past, _hanging(left[-1], right, box)


def _hanging(left: Array, right: Array, box: Box) -> str:
    """Why a mouth that reaches past the object does not cover it, empty if it does."""
    across = _across(right, left, box)
    if across is None:
        return "the mouth does not lie across the object"
    if across <= box.top:
        return "the mouth ends below the object's top"
    if left[2] > box.top + DRAPE:
        return f"the left gripper ends {left[2] - box.top:.3f} m above the top, must be <= {DRAPE} m"
    return ""


def _half_extent(box: Box, direction: Array) -> float:
    """Half of the box's extent along a horizontal unit vector."""
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    along = np.array([cos * direction[0] + sin * direction[1], cos * direction[1] - sin * direction[0]])
    return float(np.abs(along) @ np.asarray(box.size[:2]) / 2)


def _across(begin: Array, end: Array, box: Box) -> float | None:
    """The mouth's height [m] where it is nearest to the middle of the object as seen from above; None if it passes by.

    It lies across if it passes within half of the object's half sizes of the middle: not over a corner only.
    """
    a, b = box.local(begin[None])[0], box.local(end[None])[0]
    quarter = np.asarray(box.size[:2]) / 4
    distance, at = segment_distance(a[None, :2], b[None, :2], quarter)
    if distance[0] > 0:
        return None
    return float(begin[2] + at[0] * (end[2] - begin[2]))
