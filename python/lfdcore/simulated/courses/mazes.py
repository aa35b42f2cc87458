"""Two mazes to demonstrate in (Sec. 4.2, Fig. 4.5): ways from the bottom left corner to many destinations."""

from __future__ import annotations

from functools import lru_cache

from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.drawing import Drawing
from lfdcore.simulated.courses.homes import planned
from lfdcore.simulated.courses.routes import Point

START: Point = (1.0, 1.0)
"""Where all routes through a maze start [m]: its bottom left corner."""


def _maze_1() -> Drawing:
    """Lanes of 1.9 m around three rooms."""
    d = Drawing(20.0, 10.0)
    d.walls((2, 2, 8, 2), (2, 2, 2, 6), (6, 2, 6, 6), (2, 6, 8, 6), (8, 2, 8, 4), (2, 8, 6, 8), (8, 6, 8, 8))
    d.walls((8, 4, 12, 4), (8, 8, 12, 8), (12, 4, 12, 8), (10, 2, 14, 2), (14, 0, 14, 2), (12, 8, 12, 10))
    d.walls((14, 4, 14, 8), (14, 8, 20, 8), (14, 4, 18, 4), (16, 2, 20, 2))
    d.door(2.0, 4.6, "x", 1.2)  # left lane - west room
    d.door(6.0, 3.6, "x", 0.9)  # west room - inner lane
    d.door(4.4, 6.0, "y", 1.0)  # west room - upper lane
    d.door(10.2, 4.0, "y", 1.2)  # lower lane - middle room
    d.door(12.0, 6.2, "x", 1.0)  # middle room - lane
    d.door(14.0, 1.0, "x", 1.0)  # bottom lane - south-east
    d.door(12.0, 9.0, "x", 0.9)  # in the top lane
    d.door(14.0, 5.6, "x", 1.2)  # lane - east room
    d.door(18.4, 8.0, "y", 1.4)  # east room - top lane
    d.boxes((3.6, 2.1, 4.6, 2.7), (8.1, 7.3, 9.6, 7.9), (16.2, 6.8, 17.2, 7.9), (19.4, 4.4, 19.9, 5.6))
    d.boxes((15.6, 9.4, 17.0, 9.9), (0.1, 9.3, 0.7, 9.9), (19.3, 0.1, 19.9, 0.7))
    d.discs(0.22, (5.5, 5.5), (11.5, 4.6), (14.6, 7.4), (7.5, 9.5))
    return d


_WAYS_1: tuple[tuple[Point, ...], ...] = (
    ((9.0, 1.0), (13.2, 1.0)),
    ((1.0, 5.0), (1.0, 9.0), (4.6, 9.0)),
    ((1.0, 5.0), (1.2, 7.0), (7.0, 7.2), (7.0, 9.0), (10.6, 9.0)),
    ((1.0, 4.0), (4.0, 4.6), (7.0, 3.2)),
    ((1.0, 4.0), (4.0, 4.6), (4.4, 7.0), (7.0, 7.0)),
    ((9.0, 1.0), (9.0, 3.0), (10.2, 5.6), (9.0, 6.0)),
    ((9.0, 1.0), (9.0, 3.0), (13.0, 3.2), (13.0, 8.0), (14.3, 9.0)),
    ((9.0, 1.0), (14.0, 1.0), (17.8, 1.0)),
    ((9.0, 1.0), (13.0, 3.0), (18.6, 3.0), (18.4, 6.4), (18.4, 8.8)),
    ((1.0, 5.0), (1.0, 9.0), (10.0, 9.0), (17.4, 9.0), (18.4, 6.0)),
    ((9.0, 1.0), (14.0, 1.0), (15.0, 3.0), (13.0, 3.4), (13.0, 5.6), (16.0, 5.6)),
    ((1.0, 4.0), (4.0, 4.6), (7.0, 3.2), (7.0, 5.0), (10.0, 5.6), (13.0, 6.4), (13.0, 4.0), (16.6, 3.0)),
)


def _maze_2() -> Drawing:
    """Short lanes, a hall with pillars and rooms within rooms."""
    d = Drawing(20.0, 10.0)
    d.walls((2, 0, 2, 4), (2, 6, 2, 10), (2, 4, 6, 4), (6, 2, 6, 4), (2, 6, 8, 6), (8, 0, 8, 4), (8, 6, 8, 10))
    d.walls((5, 6, 5, 8.2), (9.9, 5, 13, 5), (13, 0, 13, 10), (15, 1.9, 15, 8.1), (15, 5, 18, 5))
    d.walls((15, 8.1, 18, 8.1), (15, 1.9, 17.6, 1.9), (18, 3.6, 18, 8.1))
    d.door(2.0, 1.0, "x", 1.0)  # left lane - south-west room
    d.door(2.0, 8.2, "x", 1.2)  # left lane - north-west room
    d.door(6.6, 6.0, "y", 1.2)  # middle lane - north-west room
    d.door(8.0, 1.6, "x", 0.9)  # south lane - hall
    d.door(8.0, 8.6, "x", 1.0)  # north-west room - hall
    d.door(13.0, 2.0, "x", 1.2)  # hall - east lane
    d.door(13.0, 7.4, "x", 1.2)  # hall - east lane
    d.door(15.0, 6.6, "x", 1.2)  # east lane - upper inner room
    d.door(16.4, 5.0, "y", 0.9)  # between the inner rooms
    d.boxes((2.1, 3.1, 3.3, 3.9), (3.0, 9.2, 4.4, 9.9), (12.3, 8.9, 12.9, 9.9), (12.2, 4.3, 12.9, 4.9))
    d.boxes((17.3, 7.2, 17.9, 8.0), (15.1, 2.0, 15.8, 2.9), (19.4, 4.6, 19.9, 6.0), (9.4, 0.1, 10.6, 0.6))
    d.discs(0.35, (10.6, 2.6), (10.4, 7.3))
    d.discs(0.2, (4.4, 0.5), (0.5, 9.5), (19.4, 9.5))
    return d


_WAYS_2: tuple[tuple[Point, ...], ...] = (
    ((4.0, 1.2), (6.8, 1.6), (8.0, 1.6), (9.2, 1.6)),
    ((1.0, 5.0), (5.0, 5.0), (7.0, 3.0)),
    ((1.0, 5.0), (1.0, 8.2), (3.4, 7.6)),
    ((1.0, 5.0), (6.6, 5.0), (6.6, 7.4)),
    ((1.0, 5.0), (7.0, 5.0), (9.0, 5.0), (9.2, 3.0), (11.8, 2.0)),
    ((4.0, 1.2), (6.8, 1.6), (8.0, 1.6), (9.2, 1.6), (11.8, 2.0), (14.0, 2.0), (14.0, 5.0)),
    ((1.0, 5.0), (7.0, 5.0), (9.0, 5.4), (9.2, 8.6), (11.6, 8.4)),
    ((1.0, 5.0), (1.0, 8.2), (3.6, 8.2), (6.6, 8.8), (9.6, 8.8), (11.8, 7.4), (14.0, 7.4), (14.0, 9.0), (17.0, 9.0)),
    ((4.0, 1.2), (7.0, 3.0), (7.0, 4.8), (9.0, 5.4), (9.2, 6.4), (11.6, 6.4), (14.0, 7.2), (16.4, 6.6), (16.4, 3.8)),
    ((1.0, 5.0), (7.0, 5.0), (9.0, 5.0), (9.2, 3.2), (11.8, 2.0), (14.0, 1.4), (18.8, 1.0), (18.9, 3.2)),
    ((4.0, 1.2), (6.8, 1.6), (8.0, 1.6), (9.2, 1.6), (11.8, 2.0), (14.0, 1.4), (18.6, 1.2), (18.8, 2.8), (16.6, 3.4)),
    ((1.0, 5.0), (7.0, 5.0), (9.0, 5.4), (9.2, 6.4), (11.6, 6.4), (14.0, 7.4), (14.2, 9.0), (18.8, 8.8), (18.9, 6.6)),
)

MAZE_ROUTES = len(_WAYS_1)
"""How many routes each maze has."""


@lru_cache(maxsize=MAZE_ROUTES)
def maze_1(route: int = 0) -> Course:
    """A 20 x 10 m maze of lanes around three rooms; route 0..11 leads to a destination of its own.

    Raises ValueError for another number.
    """
    return _maze("maze-1", _maze_1(), _WAYS_1, route)


@lru_cache(maxsize=MAZE_ROUTES)
def maze_2(route: int = 0) -> Course:
    """A 20 x 10 m maze of short lanes, a hall with pillars and nested rooms; route 0..11 to a destination of its own.

    Raises ValueError for another number.
    """
    return _maze("maze-2", _maze_2(), _WAYS_2, route)


def _maze(name: str, drawing: Drawing, ways: tuple[tuple[Point, ...], ...], route: int) -> Course:
    if route not in range(MAZE_ROUTES):
        raise ValueError(f"route must be 0..{MAZE_ROUTES - 1}, got {route}")
    text = "a maze of 20 x 10 m: where able drivers demonstrate with DWA"
    return planned(f"{name}-{route}", drawing, [START, *ways[route]], False, "training", text)


def mazes() -> tuple[Course, ...]:
    """All routes, of both mazes in turn."""
    return tuple(maze(route) for route in range(MAZE_ROUTES) for maze in (maze_1, maze_2))
