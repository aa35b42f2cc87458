"""Courses for reported results only: nothing may be tuned on them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Pose2
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.drawing import Drawing
from lfdcore.simulated.courses.homes import planned
from lfdcore.simulated.courses.routes import Point


def _standard_drawing() -> Drawing:
    d = Drawing(21.0, 37.0)
    d.box(6.0, 6.0, 15.0, 30.0)  # the core that one drives around
    d.boxes((15.0, 7.0, 17.2, 21.0), (19.4, 7.0, 20.9, 21.0))  # the long corridor, 2.2 m
    d.wall(15.0, 7.0, 21.0, 7.0)
    d.door(18.3, 7.0, "y", 1.0)  # 0 start - corridor
    d.wall(15.0, 29.0, 21.0, 29.0)
    d.door(17.4, 29.0, "y", 0.9)  # 1 hall - dining room
    d.wall(13.0, 30.0, 13.0, 37.0)
    d.door(13.0, 32.6, "x", 1.0)  # 2 dining room - store
    d.wall(6.0, 30.0, 6.0, 37.0)
    d.door(6.0, 34.0, "x", 1.0)  # 3 store - slalom
    d.wall(0, 14.2, 6.0, 14.2)
    d.box(0.0, 9.6, 6.0, 10.4)
    d.door(3.4, 14.2, "y", 1.0)  # 4 slalom - lobby
    d.door(2.0, 10.0, "y", 0.9, depth=0.8)  # 5 the narrow gap, .8 m thick
    d.wall(6.6, 0, 6.6, 6.0)
    d.door(6.6, 2.8, "x", 1.0)  # 6 lower left - lower room
    d.wall(14.6, 0, 14.6, 6.0)
    d.door(14.6, 3.2, "x", 0.9)  # 7 lower room - start
    return d


def _furnish_standard(d: Drawing) -> None:
    d.boxes((15.1, 22.6, 16.4, 24.6), (19.2, 25.6, 20.9, 27.4))  # hall
    d.boxes((16.4, 35.0, 18.6, 35.9), (20.0, 30.2, 20.9, 32.0), (13.1, 35.8, 14.6, 36.9))  # the table and shelves
    d.boxes((8.8, 30.1, 10.2, 31.4), (9.0, 35.6, 11.4, 36.9))  # store
    d.discs(0.3, *((3.0, y) for y in _SLALOM))
    d.boxes((8.6, 0.1, 10.0, 2.4), (11.0, 4.0, 12.2, 5.9))  # lower room
    d.disc(4.8, 5.6, 0.4)


_SLALOM = (30.0, 27.0, 24.0, 21.0, 18.0)
"""y [m] of the slalom's posts, which stand on x = 3 m."""


def _standard_waypoints(d: Drawing) -> list[Point]:
    doors = d.doors
    up = [(18.3, 3.0), *doors[0].waypoints(1), (18.3, 20.0), (17.6, 25.0), *doors[1].waypoints(1)]
    table: list[Point] = [(17.5, 32.0), (17.5, 33.8)]  # met head-on
    slalom: list[Point] = [(3.0 + (1.3 if i % 2 else -1.3), y) for i, y in enumerate(_SLALOM)]
    top = [*doors[2].waypoints(-1), (9.5, 33.4), *doors[3].waypoints(-1), (3.6, 33.6)]
    down = [*doors[4].waypoints(-1), *doors[5].waypoints(-1, 1.1), (2.0, 6.0)]
    return [*up, *table, *top, *slalom, *down, *doors[6].waypoints(1), *doors[7].waypoints(1), (17.4, 2.2)]


@lru_cache(maxsize=1)
def standard_course() -> Course:
    """The 21 x 37 m course (cf. Fig. 3.13-3.15): anticlockwise, about 97 m a lap, from the bottom right corner.

    A 14 m corridor, doors of .90-1.00 m, a table met head-on, a slalom of five posts and a .90 m gap, .8 m thick.
    """
    d = _standard_drawing()
    _furnish_standard(d)
    return planned("standard", d, _standard_waypoints(d), True, "test", "slalom, doors, gap and table, 21 x 37 m")


def _campus_drawing() -> Drawing:
    d = Drawing(97.0, 58.0)
    d.boxes((0, 0, 78.0, 4.0), (0, 6.6, 50.0, 24.0), (52.6, 6.6, 78.0, 36.0))  # around the south corridor
    d.boxes((0, 24.0, 8.0, 58.0), (8.0, 44.0, 50.0, 58.0), (50.0, 54.6, 97.0, 58.0))
    d.boxes((52.6, 36.0, 78.0, 52.0), (82.0, 26.0, 97.0, 30.0), (90.0, 30.0, 97.0, 54.6), (78.0, 30.0, 86.6, 52.0))
    _campus_doors(d)
    d.boxes((84.0, 6.0, 85.6, 7.6), (90.0, 14.0, 92.4, 16.0), (80.6, 19.0, 82.2, 20.6))  # entrance hall
    d.discs(0.4, (88.0, 10.0), (83.4, 13.4), (93.0, 21.4), (57.0, 52.4), (20.0, 30.0), (20.0, 38.0), (32.0, 30.0))
    d.discs(0.4, (32.0, 38.0), (44.0, 38.0))
    d.boxes((25.0, 33.0, 28.0, 35.0), (38.0, 41.0, 42.0, 43.0), (10.0, 40.0, 13.0, 43.0))  # atrium
    return d


def _campus_doors(d: Drawing) -> None:
    for x, width in ((14.0, 1.2), (34.0, 1.0), (60.0, 1.2)):
        d.wall(x, 4.0, x, 6.6)
        d.door(x, 5.3, "x", width)  # 0-2 in the south corridor
    d.wall(78.0, 4.0, 78.0, 6.6)
    d.door(78.0, 5.3, "x", 1.0)  # 3 south corridor - entrance hall
    d.wall(78.0, 26.0, 97.0, 26.0)
    d.box(78.0, 26.0, 97.0, 30.0)
    d.door(88.3, 28.0, "y", 2.4, depth=4.0)  # 4 a passage, with a door below
    d.wall(87.0, 26.0, 89.6, 26.0)
    d.door(88.3, 26.0, "y", 1.0)  # 5
    d.wall(86.6, 42.0, 90.0, 42.0)
    d.door(88.3, 42.0, "y", 1.0)  # 6 in the east corridor
    for x in (76.0, 62.0):
        d.wall(x, 52.0, x, 54.6)
        d.door(x, 53.3, "x", 1.0)  # 7, 8 in the north corridor
    d.wall(50.0, 46.0, 52.6, 46.0)
    d.door(51.3, 46.0, "y", 1.2)  # 9 in the middle corridor
    d.wall(50.0, 24.0, 50.0, 44.0)
    d.door(50.0, 33.0, "x", 1.2)  # 10 middle corridor - atrium


@lru_cache(maxsize=1)
def campus() -> Course:
    """Long corridors, doorways and open areas on 97 x 58 m (cf. Fig. 3.18); one way, about 230 m."""
    d = _campus_drawing()
    doors = d.doors
    south: list[Point] = [(3.0, 5.3), (10.0, 5.3), *(p for i in range(4) for p in doors[i].waypoints(1, 1.2))]
    hall: list[Point] = [(86.6, 11.6), (88.3, 20.0), *doors[5].waypoints(1, 1.5), (88.3, 34.0)]
    north = [*doors[6].waypoints(1, 1.2), (88.0, 52.0), *doors[7].waypoints(-1, 1.2), *doors[8].waypoints(-1, 1.2)]
    middle = [(53.0, 53.2), *doors[9].waypoints(-1, 1.2), (51.2, 36.0), *doors[10].waypoints(-1, 1.3)]
    atrium: list[Point] = [(40.0, 36.0), (26.0, 38.0), (12.0, 31.0)]
    way = [*south, *hall, *north, *middle, *atrium]
    return planned("campus", d, way, False, "test", "long corridors and halls, 97 x 58 m")


@lru_cache(maxsize=1)
def figure_eight() -> Course:
    """The 4 x 2 m figure-8 of App. A.2 in the middle of a 10 x 8 m hall: two circles of 1 m radius, 12.6 m a lap."""
    d = Drawing(10.0, 8.0)
    left, right = _circle((4.0, 4.0), 0.0, 2 * np.pi), _circle((6.0, 4.0), np.pi, -2 * np.pi)
    route = np.concatenate([left, right[1:]])
    start = Pose2(5.0, 4.0, np.pi / 2)
    return Course("figure-eight", d.grid(), start, route, True, "4 x 2 m figure-8 in the open (App. A.2)", "test")


def _circle(centre: Point, first: float, turn: float) -> npt.NDArray[np.float64]:
    """A circle of 1 m radius as points (64, 2) [m], from angle `first` on over `turn` [rad]."""
    angle = first + np.linspace(0.0, turn, 64)
    return np.stack([centre[0] + np.cos(angle), centre[1] + np.sin(angle)], axis=1)
