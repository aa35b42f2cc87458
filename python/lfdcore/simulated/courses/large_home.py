"""A home of 20 x 19 m to judge predictions in (Sec. 4.6.2, Fig. 4.14): nothing may be tuned or learned there."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import lru_cache

from lfdcore.simulated.courses.any_map import from_map
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.drawing import Drawing


def _drawing() -> Drawing:
    d = Drawing(20.0, 19.0)
    d.walls(
        (8.6, 0, 8.6, 12),
        (10.8, 0, 10.8, 10.2),
        (0, 7, 3, 7),
        (5.4, 7, 8.6, 7),
        (0, 12, 20, 12),
        (10.8, 10.2, 20, 10.2),
    )
    d.walls((10.8, 5, 20, 5), (15.4, 0, 15.4, 5), (13.8, 5, 13.8, 10.2), (6.4, 12, 6.4, 19), (10.8, 12, 10.8, 19))
    d.wall(17, 12, 17, 19)
    _doors(d)
    _furnish(d)
    return d


def _doors(d: Drawing) -> None:
    d.door(8.6, 3.5, "x", 1.4)  # hall - living room
    d.door(8.6, 9.0, "x", 1.2)  # hall - dining room
    d.door(2.4, 12.0, "y", 1.0)  # dining room - kitchen
    d.door(6.4, 15.0, "x", 0.9)  # kitchen - utility room
    d.door(9.7, 12.0, "y", 1.0)  # hall - utility room
    d.door(10.8, 2.4, "x", 1.0)  # hall - guest room
    d.door(15.4, 3.2, "x", 0.9)  # guest room - study
    d.door(10.8, 7.6, "x", 1.2)  # hall - bathroom
    d.door(17.6, 5.0, "y", 0.9)  # study - child's room
    d.door(16.4, 10.2, "y", 1.2)  # side hall - child's room
    d.door(13.2, 12.0, "y", 1.2)  # side hall - bedroom
    d.door(17.0, 15.4, "x", 0.9)  # bedroom - second bathroom
    d.door(18.6, 12.0, "y", 1.2)  # side hall - second bathroom


def _furnish(d: Drawing) -> None:
    d.boxes((0.1, 1.6, 1.0, 4.4), (2.3, 2.6, 3.3, 3.6), (5.4, 0.1, 7.4, 0.6), (0.1, 6.2, 1.4, 6.9))  # living room
    d.boxes((5.8, 5.9, 7.8, 6.9))
    d.boxes((3.4, 9.0, 5.4, 10.2), (0.1, 7.1, 0.6, 9.2), (7.0, 11.4, 8.5, 11.9))  # dining room
    d.discs(0.22, (3.9, 8.6), (4.9, 8.6), (3.9, 10.6), (4.9, 10.6))
    d.boxes((0.1, 18.3, 6.3, 18.9), (0.1, 13.4, 0.7, 18.3), (2.8, 15.4, 4.2, 16.4))  # kitchen
    d.boxes((7.4, 18.2, 10.7, 18.9), (6.5, 12.1, 7.1, 13.6))  # utility room
    d.boxes((8.7, 0.1, 9.2, 0.9), (8.7, 11.3, 9.0, 11.9))  # hall
    d.boxes((13.0, 0.1, 15.3, 1.6), (10.9, 4.4, 12.6, 4.9))  # guest room
    d.boxes((18.2, 0.1, 19.9, 0.8), (19.4, 2.8, 19.9, 4.6), (15.5, 0.1, 16.2, 1.6))  # study
    d.disc(18.8, 1.2, 0.25)
    d.boxes((12.6, 5.1, 13.7, 6.0), (13.1, 8.6, 13.7, 9.6))  # bathroom
    d.boxes((18.2, 7.2, 19.9, 9.4), (13.9, 5.1, 15.6, 5.7))  # child's room
    d.disc(14.5, 9.5, 0.4)
    d.boxes((12.4, 16.8, 14.4, 18.9), (11.4, 18.4, 11.9, 18.9), (10.9, 12.1, 11.5, 13.6))  # bedroom
    d.boxes((17.1, 18.1, 19.9, 18.9), (19.3, 14.0, 19.9, 15.2))  # second bathroom
    d.disc(19.6, 11.7, 0.2)


_STARTS, _NEXT = 8, 1_000_003
"""How many starts are drawn for a seed, and what is added to it from one to the next."""


@lru_cache(maxsize=64)
def home_20x19(seed: int = 0, length: float = 10.0) -> Course:
    """From an arbitrary place of the 20 x 19 m home to an arbitrary other (cf. Fig. 4.14), both drawn from the seed.

    length: of the way at least [m]; where one destination is too near, the drive goes on to another, and where no way
    leads on, it starts elsewhere. Ten rooms and an L-shaped hall; doors of .9-1.4 m. Raises ValueError for a negative
    seed or a length that no way has.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    d = _drawing()
    for start in range(_STARTS - 1):
        with suppress(ValueError):
            return _drawn(d, seed, start, length)
    return _drawn(d, seed, _STARTS - 1, length)


def _drawn(d: Drawing, seed: int, start: int, length: float) -> Course:
    course = from_map(d.grid(), seed + start * _NEXT, length, doors=tuple(d.doors))
    return replace(course, name=f"home-20x19-{seed}")
