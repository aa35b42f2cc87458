"""A course on any map: a start and far-apart destinations that the chair can reach, drawn from a seed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Pose2, arc_length
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.course import Course, Split, heading_of
from lfdcore.simulated.courses.drawing import Door
from lfdcore.simulated.courses.ideal import drive_ideally
from lfdcore.simulated.courses.routes import Point, RoutePlanner

Mask = npt.NDArray[np.bool_]

TURNING_ROOM = 0.95
"""Clearance [m] wanted at destinations: the chair turns on the spot within .87 m."""

_DRAWS = 40


def from_map(
    grid: OccupancyGrid,
    seed: int,
    length: float = 60.0,
    name: str = "map",
    split: Split = "test",
    doors: Sequence[Door] = (),
) -> Course:
    """A course of at least `length` [m] through a map's free space.

    Destinations are drawn at random among places with room to turn, the farthest of a few each time; a leg stays only
    if a chair without noise drives it without contact. Unknown cells count as walls. doors: openings that the route is
    to meet straight on, where they are known. Raises ValueError for a length that is not positive, a map without room
    for the chair, or one in which no such route is found.
    """
    if not (np.isfinite(length) and length > 0):
        raise ValueError(f"length must be positive and finite, got {length} m")
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    rng = np.random.default_rng([0x3A9, seed])
    planner = RoutePlanner(grid, doors=doors)
    draw = _Destinations(planner, rng)
    points: list[Point] = [draw.start]
    course: Course | None = None
    for _ in range(_DRAWS):
        longer = _course(planner, [*points, draw.next(points[-1])], name, seed, split, doors)
        drive = drive_ideally(longer, margin=0.01)
        if drive.contacts.any() or not drive.completed:
            continue
        course, points = longer, [*points, (float(longer.route[-1, 0]), float(longer.route[-1, 1]))]
        if course.length >= length:
            return course
    reached = 0.0 if course is None else course.length
    raise ValueError(f"no route of {length} m without contact found in {_DRAWS} draws (longest {reached:.1f} m)")


class _Destinations:
    """Places with room to turn, all connected with one another."""

    def __init__(self, planner: RoutePlanner, rng: np.random.Generator) -> None:
        self._planner, self._rng = planner, rng
        self._points = planner.node_points()
        roomy = planner.node_clearance() >= TURNING_ROOM
        if not roomy.any():
            raise ValueError(f"the map has no place with {TURNING_ROOM} m of free space around it")
        self._roomy = self._largest(roomy)
        self.start = self._any(self._roomy)

    def _any(self, mask: Mask) -> Point:
        rows, cols = np.nonzero(mask)
        pick = self._rng.integers(len(rows))
        x, y = self._points[rows[pick], cols[pick]]
        return float(x), float(y)

    def _largest(self, roomy: Mask) -> Mask:
        """The roomy places of the largest connected part that a few random draws meet."""
        parts = []
        for _ in range(5):
            reachable = np.isfinite(self._planner.distances_from(self._any(roomy)))
            parts.append(roomy & reachable)
        return max(parts, key=lambda part: int(part.sum()))

    def next(self, here: Point) -> Point:
        """The farthest to drive of three random places."""
        cost = self._planner.distances_from(here)
        at = [self._any(self._roomy & np.isfinite(cost)) for _ in range(3)]
        away = [float(np.hypot(p[0] - here[0], p[1] - here[1])) for p in at]
        return at[int(np.argmax(away))]


def _course(
    planner: RoutePlanner, points: list[Point], name: str, seed: int, split: Split, doors: Sequence[Door]
) -> Course:
    route = planner.route(points)
    start = Pose2(float(route[0, 0]), float(route[0, 1]), heading_of(route))
    text = f"random destinations, seed {seed}, {float(arc_length(route)[-1]):.0f} m"
    return Course(f"{name}-{seed}", planner.grid, start, route, False, text, split, tuple(doors))
