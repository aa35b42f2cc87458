"""Worlds with named destinations for Ch. 2: a 72 x 72 m building of ours (cf. Fig. 2.4), and any map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from lfdcore.datasets import Goal, Goals, read_map
from lfdcore.geometry import Footprint, Pose2, arc_length
from lfdcore.grid import OccupancyGrid, RayCaster
from lfdcore.simulated.courses.any_map import TURNING_ROOM
from lfdcore.simulated.courses.course import Course, FloatArray, Split, heading_of
from lfdcore.simulated.courses.drawing import Drawing
from lfdcore.simulated.courses.ideal import FootprintOnGrid, drive_ideally
from lfdcore.simulated.courses.routes import Point, RoutePlanner

SIZE = 72.0
"""Side [m] of the building: the area of Fig. 2.4a."""


@dataclass(frozen=True)
class Spread:
    """How much drives to one destination differ, drawn uniformly: the start's place along and across its heading, the
    places by way and the end [m], the start's heading [rad]."""

    along: float = 0.8
    across: float = 0.4
    heading: float = np.radians(12.0)
    by_way: float = 0.35
    end: float = 0.25


@dataclass(frozen=True, eq=False)
class GoalWorld:
    """A map with destinations, one start area and the ways between them.

    start: T_map_base in the middle of the start area. by_way: for each destination the places [m, map] that its route
    passes. Drives differ by `spread`.
    """

    name: str
    grid: OccupancyGrid
    start: Pose2
    goals: Goals
    by_way: tuple[tuple[Point, ...], ...]
    description: str
    spread: Spread = field(default_factory=Spread)
    split: Split = "test"

    @cached_property
    def planner(self) -> RoutePlanner:
        """Plans all routes of this world."""
        return RoutePlanner(self.grid)

    @cached_property
    def _body(self) -> FootprintOnGrid:
        return FootprintOnGrid(self.grid, Footprint().grown(_ROOM))

    def course(self, goal: str, seed: int) -> Course:
        """One drive to the destination of this name; the same seed gives the same start and route.

        Raises ValueError for a name that is none of the goals' and a negative seed.
        """
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed}")
        index = self.goals.index(goal)
        rng = np.random.default_rng([_DRIVES, seed, index])
        start = self._start(rng)
        s = self.spread
        by_way = [_moved(place, s.by_way, rng) for place in self.by_way[index]]
        end = _moved((self.goals.goals[index].x, self.goals.goals[index].y), s.end, rng)
        route = self.planner.route([(start.x, start.y), *by_way, end])
        text = f"to {goal}, seed {seed}, {float(arc_length(route)[-1]):.0f} m"
        return Course(f"{self.name}-{goal}-{seed}", self.grid, start, route, False, text, self.split)

    def _start(self, rng: np.random.Generator) -> Pose2:
        """A free pose of the start area."""
        s = self.spread
        for _ in range(_DRAWS):
            offset = rng.uniform(-1, 1, 3) * (s.along, s.across, s.heading)
            pose = self.start * Pose2(*map(float, offset))
            if not self._body.touches(np.array([[*pose]]))[0]:
                return pose
        raise ValueError(f"no free place for the chair in {_DRAWS} draws around the start {self.start}")


_DRIVES, _GOALS = 0x60A1, 0x60A2
"""Streams of random numbers."""
_DRAWS = 100
_ROOM = 0.05
"""[m] around the chair at its start"""


def _moved(place: Point, most: float, rng: np.random.Generator) -> Point:
    dx, dy = rng.uniform(-most, most, 2)
    return place[0] + float(dx), place[1] + float(dy)


# -- the building ---------------------------------------------------------------------------------------------------

_WIDTH = 3.2
"""[m] of the corridors: the nose keeps the 1.2 m at which able drivers do not slow down"""
_COLUMNS, _ROWS = (12.0, 24.0, 36.0, 46.0, 60.0), (10.0, 22.0, 40.0, 50.0, 62.0)
"""Middle lines [m] of the corridors from south to north (x) and from west to east (y)"""


@lru_cache(maxsize=1)
def goal_building() -> GoalWorld:
    """The 72 x 72 m building of Ch. 2: rooms along corridors, one start area, destinations G1..G6.

    All routes set out north. G3's and G6's turn off into rooms near the start; those of G1, G2, G4 and G5 part at a
    crossing 7 m on; those of G4 and G5 still share the corridor to the east. Lengths are such that an able driver takes
    about as long as the thesis prints in Table 2.1 (G1 52 s, G2 33 s, G3 16 s, G4 52 s).
    """
    d = _building()
    _open_goal_rooms(d)
    _furnish(d)
    goals = Goals(
        (
            Goal("G1", 30.6, 50.0),
            Goal("G2", 28.4, 40.1),
            Goal("G3", 39.9, 36.8),
            Goal("G4", 46.0, 46.6),
            Goal("G5", 40.2, 43.1),
            Goal("G6", 31.4, 35.6),
        )
    )
    crossing = (36.0, 40.0)
    by_way: tuple[tuple[Point, ...], ...] = (
        (crossing, (35.6, 47.4)),
        ((35.6, 38.6), (32.6, 40.0)),
        (),
        ((36.5, 38.4), (39.6, 39.9)),
        ((36.5, 38.4), (38.4, 40.0)),
        (),
    )
    start = Pose2(36.0, 32.8, np.pi / 2)
    text = "rooms along corridors with six destinations, 72 x 72 m"
    return GoalWorld("goal-building", d.grid(), start, goals, by_way, text)


@dataclass(frozen=True)
class _Room:
    x0: float
    y0: float
    x1: float
    y1: float
    south: bool
    """where its door to a corridor is, else north"""

    @property
    def door(self) -> Point:
        return _on_grid(0.4 * self.x0 + 0.6 * self.x1), self.y0 if self.south else self.y1


def _building() -> Drawing:
    """Corridors that cross, blocks of rooms between them, each room with a door to a corridor, two open halls."""
    d = Drawing(SIZE, SIZE)
    for block in [(x0, y0, x1, y1) for x0, x1 in _between(_COLUMNS) for y0, y1 in _between(_ROWS)]:
        if block in _HALLS:
            _pillars(d, *block)
        for room in [] if block in _HALLS else _rooms(*block):
            x0, y0, x1, y1 = room.x0, room.y0, room.x1, room.y1
            d.walls((x0, y0, x1, y0), (x0, y1, x1, y1), (x0, y0, x0, y1), (x1, y0, x1, y1))
    for room in _all_rooms():
        d.door(*room.door, "y", 1.4)
    return d


def _between(middles: Sequence[float]) -> list[tuple[float, float]]:
    """The spans [m] that corridors with these middle lines leave."""
    edges = [0.0, *(_on_grid(edge) for m in middles for edge in (m - _WIDTH / 2, m + _WIDTH / 2)), SIZE]
    return list(zip(edges[::2], edges[1::2], strict=True))


def _on_grid(metres: float) -> float:
    return round(round(metres / 0.05) * 0.05, 2)


_HALLS = ((13.6, 51.6, 22.4, 60.4), (47.6, 11.6, 58.4, 20.4))


def _all_rooms() -> list[_Room]:
    blocks = [(x0, y0, x1, y1) for x0, x1 in _between(_COLUMNS) for y0, y1 in _between(_ROWS)]
    return [room for block in blocks if block not in _HALLS for room in _rooms(*block)]


def _rooms(x0: float, y0: float, x1: float, y1: float) -> list[_Room]:
    """A block's rooms: some 5-9 m wide side by side, back to back where the block is deep."""
    rows = np.linspace(y0, y1, 2 + (y1 - y0 > 12))
    columns = np.linspace(x0, x1, 1 + max(1, round((x1 - x0) / 6)))
    rooms = []
    for j, (south, north) in enumerate(pairwise(map(_on_grid, rows.tolist()))):
        for k, (west, east) in enumerate(pairwise(map(_on_grid, columns.tolist()))):
            alternates = (k + round(x0)) % 2 == 0
            opens_south = j == 0 if len(rows) > 2 else north == SIZE or (south > 0 and alternates)
            rooms.append(_Room(west, south, east, north, opens_south))
    return rooms


def _pillars(d: Drawing, x0: float, y0: float, x1: float, y1: float) -> None:
    for x in np.linspace(x0 + 1, x1 - 1, 3):
        for y in np.linspace(y0 + 1, y1 - 1, 3):
            d.discs(0.3, (float(x), float(y)))


def _open_goal_rooms(d: Drawing) -> None:
    """Wide openings into the rooms of G3, G5 and G6, so that no able driver touches a door post."""
    d.door(37.6, 35.8, "x", 2.4)
    d.door(34.4, 36.2, "x", 2.4)
    d.door(40.0, 41.6, "y", 2.4)


_GOAL_ROOMS = ((25.6, 31.0), (37.6, 31.0), (37.6, 41.6))
"""South-west corners [m] of the rooms of G6, G3 and G5: furnished by hand"""


def _furnish(d: Drawing) -> None:
    """What makes places differ; nothing on a route to a destination or before a door."""
    rng = np.random.default_rng(72)
    for room in _all_rooms():
        if (room.x0, room.y0) not in _GOAL_ROOMS:
            _furnish_room(d, room, rng)
    d.boxes((42.4, 32.4, 43.6, 34.4), (26.4, 32.4, 28.6, 33.2), (25.7, 36.6, 26.2, 38.2), (42.6, 37.8, 44.3, 38.3))
    d.boxes((42.6, 46.2, 44.2, 47.2), (37.7, 46.8, 38.2, 48.2))
    d.discs(0.3, (34.7, 29.4), (37.3, 29.4), (47.3, 41.3), (34.7, 51.3))
    d.boxes((26.0, 41.25, 27.6, 41.6), (45.0, 51.2, 47.2, 51.6), (30.0, 23.0, 32.0, 23.6))


def _furnish_room(d: Drawing, room: _Room, rng: np.random.Generator) -> None:
    """A cupboard at each side wall and a table, some way from the door."""
    far = room.y1 if room.south else room.y0
    towards = -1.0 if room.south else 1.0
    for wall, inwards in ((room.x0, 1.0), (room.x1, -1.0)):
        depth, width, at = rng.uniform((0.35, 0.8, 0.3), (0.6, 2.0, 2.0))
        d.box(wall, far + towards * at, wall + inwards * depth, far + towards * (at + width))
    x = rng.uniform(room.x0 + 1.6, room.x1 - 2.6)
    y = far + towards * rng.uniform(1.4, 2.4)
    width, depth = rng.uniform((0.6, 0.5), (1.6, 1.0))
    d.box(x, y, x + width, y + towards * depth)


# -- any map --------------------------------------------------------------------------------------------------------

_SPREAD_IN_MAP = Spread(along=0.3, across=0.2, by_way=0.0, end=0.2)
_LEAST_APART = 4.0
"""[m] between two destinations, and from the start"""
_INDOORS = 25.0
"""[m] within which beams indoors end"""


def goals_in_map(path: str | Path, seed: int, count: int = 6, farthest: float = 25.0) -> GoalWorld:
    """A start and `count` destinations, named G1.., in a map_server .yaml, drawn by the seed.

    All are indoors (nine of ten beams around them end within 25 m: many maps do not say what is unknown), have .95 m of
    free space around them and lie 4 m or more apart; the way to each is at most `farthest` [m] long
    (the cost of the cheapest path, which counts metres near walls more), and an ideal chair drives it without contact.
    The same seed gives the same. Raises ValueError for a negative seed, fewer than two destinations, a distance that
    is not positive, or where the map has no such start in 100 draws.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    if count < 2:
        raise ValueError(f"count must be at least 2 goals, got {count}")
    if not (np.isfinite(farthest) and farthest > _LEAST_APART):
        raise ValueError(f"farthest must be finite and above {_LEAST_APART} m, got {farthest} m")
    path = Path(path)
    grid = read_map(path)
    draw = _GoalDraw(RoutePlanner(grid), np.random.default_rng([_GOALS, seed]), farthest)
    for _ in range(_DRAWS):
        world = draw.world(f"{path.stem}-{seed}", path, count)
        if world is not None:
            return world
    raise ValueError(f"no start from which {count} goals can be reached within {farthest} m in {_DRAWS} draws")


class _GoalDraw:
    """Draws a start and what can be reached from it."""

    def __init__(self, planner: RoutePlanner, rng: np.random.Generator, farthest: float) -> None:
        self._planner, self._rng, self._farthest = planner, rng, farthest
        self._roomy = planner.node_clearance() >= TURNING_ROOM
        if not self._roomy.any():
            raise ValueError(f"the map has no place with {TURNING_ROOM} m of free space around it")
        self._places = planner.node_points()
        self._caster = RayCaster(planner.grid, _INDOORS)

    def _indoors(self, place: Point) -> bool:
        around = np.arange(36) * np.radians(10.0)
        return float(np.isfinite(self._caster.cast(Pose2(*place, 0.0), around)).mean()) >= 0.9

    def world(self, name: str, path: Path, count: int) -> GoalWorld | None:
        """None where the start that was drawn has too few destinations around it."""
        starts = self._places[self._roomy]
        start: Point = tuple(map(float, starts[self._rng.integers(len(starts))]))  # type: ignore[assignment]
        if not self._indoors(start):
            return None
        near = self._roomy & (self._planner.distances_from(start) <= self._farthest)
        places = self._rng.permutation(self._places[near])
        chosen: list[Point] = [start]
        for x, y in places[: 10 * count].tolist():
            apart = min(np.hypot(x - other[0], y - other[1]) for other in chosen)
            if apart >= _LEAST_APART and self._indoors((x, y)) and self._drivable(start, (x, y)):
                chosen.append((x, y))
            if len(chosen) == count + 1:
                return self._made(name, path, chosen)
        return None

    def _drivable(self, start: Point, goal: Point) -> bool:
        route = self._planner.route([start, goal])
        course = Course("draw", self._planner.grid, _set_out(route), route, False, "", "test")
        drive = drive_ideally(course, margin=0.05)
        return drive.completed and not drive.contacts.any()

    def _made(self, name: str, path: Path, chosen: list[Point]) -> GoalWorld:
        goals = Goals(tuple(Goal(f"G{k + 1}", *place) for k, place in enumerate(chosen[1:])), path)
        routes = [self._planner.route([chosen[0], place]) for place in chosen[1:]]
        yaws = [heading_of(route) for route in routes]
        yaw = float(np.arctan2(np.sin(yaws).mean(), np.cos(yaws).mean()))
        text = f"{len(goals)} destinations in {path.name}"
        grid = self._planner.grid
        none = ((),) * len(goals)
        return GoalWorld(name, grid, Pose2(*chosen[0], yaw), goals, none, text, _SPREAD_IN_MAP)


def _set_out(route: FloatArray) -> Pose2:
    return Pose2(float(route[0, 0]), float(route[0, 1]), heading_of(route))
