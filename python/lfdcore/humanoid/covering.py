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

from lfdcore.humanoid.contact import (
    CLEARANCE,
    STEP,
    Capsule,
    Contact,
    nearest_approach,
    require_points,
    segment_distance,
)
from lfdcore.humanoid.scene import Box

Array = NDArray[np.float64]

DRAPE = 0.15
"""[m] above the object's top that the left gripper may end for the lip to have come down behind it"""


@dataclass(frozen=True)
class CoveringVerdict:
    """Whether an object was covered, and safely."""

    covered: bool
    """the mouth ends over the object, and the left gripper past it and low enough behind it"""
    mouth: Contact
    """of the bag's mouth"""
    links: tuple[Contact, ...]
    """of the arm's links, as given"""
    past: float
    """[m] by which the left gripper ends beyond the object and its clearance; negative: short of it"""
    reason: str
    """why it is not covered, empty where it is"""

    @property
    def contact(self) -> Contact:
        """Of what came nearest: the mouth or a link."""
        return min((self.mouth, *self.links), key=lambda contact: contact.distance)

    @property
    def part(self) -> str:
        """What came nearest: mouth or link 1, 2, ..."""
        nearest = (self.mouth, *self.links).index(self.contact)
        return f"link {nearest}" if nearest else "mouth"

    @property
    def collided(self) -> bool:
        """Mouth or link came nearer than the clearance."""
        return self.mouth.touches or any(link.touches for link in self.links)

    @property
    def success(self) -> bool:
        """Covered without a collision."""
        return self.covered and not self.collided

    @property
    def success_of_mouth(self) -> bool:
        """The same, the links left out of account."""
        return self.covered and not self.mouth.touches


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
    left = require_points("trajectory", given[:, :3])
    right = require_points("right_gripper", np.atleast_2d(np.asarray(right_gripper, np.float64)))
    if len(right) != 1:
        raise ValueError(f"right_gripper has shape {np.shape(right_gripper)}, must be (3,)")
    mouth = nearest_approach(np.broadcast_to(right, left.shape), left, box, clearance, step=step)
    contacts = [_link_contact(k, link, len(left), box, clearance, step) for k, link in enumerate(links, 1)]
    past, reason = _coverage(left, right[0], box, clearance)
    return CoveringVerdict(not reason, mouth, tuple(contacts), past, reason)


def _link_contact(number: int, link: Capsule, samples: int, box: Box, clearance: float, step: float) -> Contact:
    if len(link.begin) != samples:
        raise ValueError(f"link {number} has {len(link.begin)} samples, must be {samples} as the trajectory")
    return nearest_approach(link.begin, link.end, box, clearance, link.radius, step)


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
