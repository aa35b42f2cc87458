"""A course with room to spare, for drivers who go backwards."""

from __future__ import annotations

from functools import lru_cache

from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.drawing import Drawing
from lfdcore.simulated.courses.homes import planned
from lfdcore.simulated.courses.routes import Point


@lru_cache(maxsize=1)
def hall() -> Course:
    """A 14 x 10 m hall with pillars, screens and a 2 m passage; one way, about 25 m, nothing within .8 m of it."""
    d = Drawing(14.0, 10.0)
    d.walls((7.0, 0, 7.0, 3.4), (7.0, 5.4, 7.0, 10.0), (10.2, 6.6, 14.0, 6.6))
    d.discs(0.35, (3.4, 5.4), (10.4, 3.4))
    d.boxes((0.1, 9.0, 1.6, 9.9), (4.8, 0.1, 6.9, 0.8), (12.6, 0.1, 13.9, 1.0))
    way: list[Point] = [(1.6, 1.6), (1.6, 5.4), (3.4, 7.4), (5.2, 5.6), (7.0, 4.4), (8.6, 3.0), (10.4, 1.6)]
    way += [(12.2, 3.4), (10.6, 5.1), (8.6, 6.6), (9.4, 8.3), (12.0, 8.3)]
    return planned("hall", d, way, False, "test", "a hall with pillars, 14 x 10 m, to drive backwards in")
