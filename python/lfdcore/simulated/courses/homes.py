"""Indoor worlds to learn in (home) and to tune the assistant in (office, flat)."""

from __future__ import annotations

from functools import lru_cache

from lfdcore.geometry import Pose2
from lfdcore.simulated.courses.course import Course, Split, heading_of
from lfdcore.simulated.courses.drawing import Drawing
from lfdcore.simulated.courses.routes import Point, RoutePlanner

HOME_ROUTES = 3
"""How many different routes the training home has."""


def planned(name: str, drawing: Drawing, waypoints: list[Point], loop: bool, split: Split, description: str) -> Course:
    """A course whose route is planned by way of the waypoints [m] and that starts along it."""
    grid = drawing.grid()
    route = RoutePlanner(grid, doors=drawing.doors).route(waypoints, loop)
    start = Pose2(float(route[0, 0]), float(route[0, 1]), heading_of(route))
    return Course(name, grid, start, route, loop, description, split, tuple(drawing.doors))


def _furnished_home() -> Drawing:
    d = Drawing(20.0, 10.0)
    d.walls((5.5, 0, 5.5, 10), (14.5, 0, 14.5, 10), (5.5, 3.9, 20, 3.9), (5.5, 6.1, 14.5, 6.1))
    d.walls((10.0, 0, 10.0, 3.9), (10.0, 6.1, 10.0, 10))
    d.door(5.5, 5.0, "x", 1.4)  # 0 living room - corridor
    d.door(5.5, 8.0, "x", 1.0)  # 1 living room - kitchen
    d.door(10.0, 7.6, "x", 1.1)  # 2 kitchen - dining room
    d.door(12.2, 6.1, "y", 1.2)  # 3 dining room - corridor
    d.door(7.0, 3.9, "y", 1.2)  # 4 corridor - second bedroom
    d.door(10.0, 2.0, "x", 0.9)  # 5 second bedroom - bathroom
    d.door(12.3, 3.9, "y", 1.1)  # 6 bathroom - corridor
    d.door(14.5, 5.0, "x", 1.2)  # 7 corridor - bedroom
    d.door(17.2, 3.9, "y", 0.9)  # 8 bedroom - study
    d.door(14.5, 1.9, "x", 0.9)  # 9 study - bathroom
    d.boxes((0.1, 2.6, 1.0, 4.8), (2.4, 3.0, 3.0, 4.2), (0.1, 6.4, 0.5, 7.8), (1.6, 9.4, 3.6, 9.9))  # living room
    d.boxes((2.4, 0.1, 4.0, 0.6), (2.6, 6.3, 3.4, 7.1))
    d.discs(0.2, (4.9, 0.6), (0.6, 9.4))
    d.boxes((5.9, 9.3, 9.9, 9.9), (6.6, 6.2, 8.0, 6.6))  # kitchen
    d.boxes((12.4, 8.0, 13.6, 8.9), (10.1, 9.4, 11.6, 9.9))  # dining room
    d.discs(0.22, (12.7, 9.2), (13.3, 9.2))
    d.boxes((5.6, 0.1, 6.2, 2.0), (7.6, 0.1, 9.9, 0.6), (8.6, 3.3, 9.9, 3.8))  # second bedroom
    d.boxes((10.8, 0.1, 12.4, 0.8), (13.6, 3.2, 14.4, 3.8))  # bathroom
    d.boxes((17.4, 7.3, 19.4, 9.3), (14.6, 9.2, 16.2, 9.9), (19.4, 4.6, 19.9, 6.2))  # bedroom
    d.boxes((18.4, 0.1, 19.9, 0.8), (14.6, 3.3, 15.8, 3.8))  # study
    d.disc(18.9, 1.1, 0.22)
    return d


def _home_waypoints(doors: Drawing, route: int) -> list[Point]:
    d = doors.doors
    living = [(1.5, 8.4), (1.3, 5.8), (1.7, 3.6), (2.0, 1.6), (3.4, 1.5), (4.3, 2.8)]
    bedroom = [(15.7, 6.4), (15.7, 7.9), (16.6, 8.2), (16.9, 6.6)]
    rounds = [*living, *d[0].waypoints(1), *d[7].waypoints(1), *bedroom, *d[8].waypoints(-1), (17.0, 1.8)]
    rounds += [*d[9].waypoints(-1), *d[5].waypoints(-1), *d[4].waypoints(1), (9.0, 5.0), *d[3].waypoints(1)]
    rounds += [*d[2].waypoints(-1), *d[1].waypoints(-1), (3.0, 8.4)]
    if route == 0:
        return rounds
    if route == 1:
        return rounds[::-1]
    south = [(4.2, 4.8), *d[0].waypoints(1), *d[4].waypoints(-1), *d[5].waypoints(1), *d[6].waypoints(1)]
    turn = [(16.2, 4.9), (17.3, 5.4), (17.3, 6.4), (16.3, 6.6)]
    north = [(13.3, 5.0), *d[7].waypoints(1), *turn, *d[7].waypoints(-1), *d[3].waypoints(1), (11.6, 7.8)]
    west = [
        *d[2].waypoints(-1),
        *d[1].waypoints(-1),
        (4.0, 8.6),
        (1.6, 8.4),
        (1.3, 5.8),
        (1.7, 3.6),
        (2.0, 1.6),
        (3.4, 1.6),
    ]
    return [*south, *north, *west]


@lru_cache(maxsize=HOME_ROUTES)
def home(route: int = 0) -> Course:
    """The 20 x 10 m furnished home for demonstrations (cf. Fig. 3.12); loops through every room.

    route: 0 all rooms, anticlockwise; 1 the same the other way round; 2 another order, by way of the corridor.
    Raises ValueError for another number.
    """
    if route not in range(HOME_ROUTES):
        raise ValueError(f"route must be 0..{HOME_ROUTES - 1}, got {route}")
    drawing = _furnished_home()
    waypoints = _home_waypoints(drawing, route)
    text = "furnished home of seven rooms, 20 x 10 m: where the assistant learns"
    return planned(f"home-{route}", drawing, waypoints, True, "training", text)


@lru_cache(maxsize=1)
def office() -> Course:
    """A 24 x 14 m office floor to tune the assistant in: a corridor, four rooms and an open plan with desks."""
    d = Drawing(24.0, 14.0)
    d.walls((0, 5.0, 16.0, 5.0), (0, 7.2, 16.0, 7.2), (5.4, 0, 5.4, 5.0), (10.8, 0, 10.8, 5.0), (16.0, 0, 16.0, 14.0))
    d.wall(8.0, 7.2, 8.0, 14.0)
    west, south = d.door(2.6, 5.0, "y", 1.2), d.door(13.4, 5.0, "y", 1.0)
    inner = d.door(5.4, 2.6, "x", 0.9)
    next_door = d.door(10.8, 2.6, "x", 1.0)
    plan, meeting = d.door(16.0, 6.1, "x", 1.2), d.door(16.0, 10.6, "x", 1.2)
    wall, out = d.door(8.0, 10.6, "x", 0.9), d.door(6.2, 7.2, "y", 1.0)
    d.boxes(
        (0.1, 0.1, 1.5, 0.8), (4.2, 0.1, 5.3, 0.6), (7.0, 0.1, 9.4, 0.8), (7.2, 4.2, 9.0, 4.9), (14.4, 0.1, 15.9, 1.0)
    )
    d.boxes((18.4, 8.6, 20.0, 12.2), (22.6, 8.0, 23.9, 11.4), (18.4, 2.0, 20.0, 4.8), (22.6, 1.6, 23.9, 5.0))
    d.boxes((10.4, 12.2, 13.6, 13.2), (0.1, 12.6, 3.2, 13.9), (9.6, 7.3, 11.2, 7.9))
    d.discs(0.22, (18.1, 3.4), (20.4, 10.2), (1.7, 0.7), (2.4, 9.4))
    route = [(13.4, 6.1), *plan.waypoints(1), (17.6, 1.5), (21.3, 1.5), (21.3, 6.5), (21.3, 12.6), (18.0, 13.0)]
    route += [
        *meeting.waypoints(-1),
        *wall.waypoints(-1),
        (4.6, 11.3),
        (2.4, 11.0),
        (1.0, 9.4),
        (2.4, 8.2),
        (4.8, 8.9),
        (6.2, 9.0),
        *out.waypoints(-1),
        (4.6, 6.1),
        *west.waypoints(-1),
        (2.6, 3.0),
    ]
    route += [*inner.waypoints(1), *next_door.waypoints(1), *south.waypoints(1)]
    return planned("office", d, [*route[1:], (14.0, 6.1)], True, "tuning", "office floor, 24 x 14 m")


@lru_cache(maxsize=1)
def flat() -> Course:
    """A 13 x 10 m flat to tune the assistant in: tighter than the home."""
    d = Drawing(13.0, 10.0)
    d.walls((7.0, 0, 7.0, 10.0), (0, 5.2, 13.0, 5.2))
    low, right = d.door(7.0, 2.4, "x", 0.9), d.door(10.4, 5.2, "y", 1.0)
    high, left = d.door(7.0, 7.4, "x", 1.0), d.door(3.2, 5.2, "y", 0.9)
    d.boxes((0.1, 0.1, 0.8, 3.0), (3.0, 0.1, 5.0, 0.7), (3.4, 2.3, 4.4, 2.9), (5.4, 4.4, 6.9, 5.1))
    d.boxes((11.9, 0.1, 12.9, 2.6), (8.4, 4.4, 9.2, 5.1), (9.0, 0.1, 10.6, 0.6))
    d.boxes((11.0, 8.6, 12.9, 9.9), (7.1, 9.3, 9.0, 9.9), (0.1, 8.4, 1.6, 9.9), (4.2, 9.2, 6.4, 9.9))
    d.discs(0.2, (3.6, 7.7), (12.4, 5.8), (1.0, 5.9))
    route = [(2.0, 3.6), (2.0, 1.4), (4.4, 1.5), *low.waypoints(1), *right.waypoints(1), (11.6, 7.2), (9.6, 8.2)]
    route += [*high.waypoints(-1), (4.8, 8.2), (3.4, 8.7), (2.2, 8.0), (2.4, 7.0), *left.waypoints(-1)]
    return planned("flat", d, route, True, "tuning", "small flat, 13 x 10 m")
