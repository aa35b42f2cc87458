"""Courses by name, and what each may be used for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lfdcore.datasets import read_map
from lfdcore.simulated.courses.any_map import from_map
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.held_out import campus, figure_eight, standard_course
from lfdcore.simulated.courses.homes import HOME_ROUTES, flat, home, office
from lfdcore.simulated.courses.large_home import home_20x19
from lfdcore.simulated.courses.mazes import maze_1, maze_2
from lfdcore.simulated.courses.roomy import hall

_DRAWN: dict[str, Callable[[], Course]] = {
    "campus": campus,
    "figure_eight": figure_eight,
    "flat": flat,
    "hall": hall,
    "home": home,
    "home_20x19": home_20x19,
    "maze_1": maze_1,
    "maze_2": maze_2,
    "office": office,
    "standard_course": standard_course,
}


def course_names() -> tuple[str, ...]:
    """The courses drawn by us."""
    return tuple(_DRAWN)


def course_by_name(name: str, seed: int) -> Course:
    """A course drawn by us, or one with a random route in a map_server .yaml. ValueError names the known ones."""
    if name in _DRAWN:
        return _DRAWN[name]()
    if name.endswith((".yaml", ".yml")):
        return from_map(read_map(Path(name)), seed, name=Path(name).stem)
    raise ValueError(f"course is '{name}', must be one of {', '.join(_DRAWN)} or a map's .yaml")


def training_courses() -> tuple[Course, ...]:
    """Where the expert demonstrates: three routes through the furnished home."""
    return tuple(home(route) for route in range(HOME_ROUTES))


def tuning_courses() -> tuple[Course, ...]:
    """Where the assistant's numbers were chosen; never reported as results."""
    return office(), flat()
