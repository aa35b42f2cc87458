"""Destinations by name in a map (goals.yaml): what a driver may want to go to (Sec. 2.2)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from lfdcore.datasets.maps import read_map
from lfdcore.errors import DataError
from lfdcore.grid import OccupancyGrid

FARTHEST = 1e6
"""[m] of a destination's coordinates"""
MOST_BYTES = 200_000
"""of a file: thousands of destinations; YAML is read slowly"""
_KEYS, _GOAL_KEYS = ("map", "goals"), ("name", "x", "y")
_SHORT = Repr()
_SHORT.maxlevel = 2


@dataclass(frozen=True)
class Goal:
    """A destination: its name and its place x, y [m] in the map."""

    name: str
    x: float
    y: float


@dataclass(frozen=True)
class Goals:
    """Destinations in their order, and the map's .yaml where it is known.

    ValueError for fewer than two, an empty name, a name or a place that two share, a place that is not finite.
    """

    goals: tuple[Goal, ...]
    map: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "goals", tuple(self.goals))
        for goal in self.goals:
            _require_goal(goal)
        if len(self.goals) < 2:
            raise ValueError(
                f"there are {len(self.goals)} goals, must be at least 2: one alone leaves nothing to infer"
            )
        _require_distinct("named", self.names)
        _require_distinct("at", [(goal.x, goal.y) for goal in self.goals])

    def __len__(self) -> int:
        return len(self.goals)

    @property
    def names(self) -> tuple[str, ...]:
        """(L,)"""
        return tuple(goal.name for goal in self.goals)

    @property
    def positions(self) -> NDArray[np.float64]:
        """(L, 2) [m, map]"""
        return np.array([(goal.x, goal.y) for goal in self.goals])

    def index(self, name: str) -> int:
        """Which goal has this name; ValueError that lists the names where none has."""
        if name not in self.names:
            raise ValueError(f"goal is {name!r}, must be one of {', '.join(self.names)}")
        return self.names.index(name)

    def require_inside(self, grid: OccupancyGrid) -> None:
        """ValueError that names the first goal outside the map's rectangle."""
        x0, y0 = grid.origin
        x1, y1 = x0 + grid.width * grid.resolution, y0 + grid.height * grid.resolution
        for goal in self.goals:
            if not (x0 <= goal.x < x1 and y0 <= goal.y < y1):
                raise ValueError(
                    f"goal {goal.name!r} is at ({goal.x:g}, {goal.y:g}) m, outside the map: "
                    f"x {x0:g} to {x1:g} m, y {y0:g} to {y1:g} m"
                )


def _require_goal(goal: Goal) -> None:
    if not (isinstance(goal.name, str) and goal.name.strip() and goal.name.isprintable()):
        raise ValueError(f"a goal's name is {goal.name!r}, must be a text that is not empty, in one line")
    for axis, value in (("x", goal.x), ("y", goal.y)):
        if not (math.isfinite(value) and abs(value) <= FARTHEST):
            raise ValueError(f"{axis} of goal {goal.name!r} is {value} m, must be finite and within {FARTHEST:g} m")


def _require_distinct(what: str, values: Sequence[object]) -> None:
    for value, times in Counter(values).items():
        if times > 1:
            raise ValueError(f"{times} goals are {what} {value!r}, each must have its own")


class _NoDuplicates(yaml.SafeLoader):
    """YAML in which a key that comes twice is an error: the later one would win silently."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
        for key, times in keys.items():
            if times > 1:
                raise ValueError(f"key {key} comes {times} times, line {node.start_mark.line + 1} on")
        return super().construct_mapping(node, deep)


def read_goals(path: str | Path) -> Goals:
    """Reads destinations: `goals`, a list of `name`, `x`, `y` [m, map], and optionally `map`, a map_server .yaml.

    `map` is taken relative to the file; the goals must lie in it. DataError naming file and key for what is missing,
    unknown, given twice or of the wrong type, and for what `Goals` and `read_map` refuse. FileNotFoundError without
    the file or the map.
    """
    path = Path(path)
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is no regular file, so no goals")
    if path.exists() and path.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: has {path.stat().st_size} bytes, goals have at most {MOST_BYTES}")
    try:
        described = yaml.load(path.read_bytes(), Loader=_NoDuplicates)
    except (yaml.YAMLError, ValueError, RecursionError, LookupError, AttributeError, TypeError) as error:
        # the last three: a mistyped tag
        raise DataError(f"{path}: is no YAML of goals: {' '.join(str(error).split())}") from error
    described = _mapping(path, "the file", described, _KEYS)
    listed = described.get("goals")
    if not isinstance(listed, list):
        raise DataError(f"{path}: goals is {_SHORT.repr(listed)}, must be a list of name, x, y")
    try:
        goals = Goals(tuple(_goal(path, k, one) for k, one in enumerate(listed)), _map(path, described))
        if goals.map is not None:
            goals.require_inside(read_map(goals.map))
    except ValueError as error:
        raise error if isinstance(error, DataError) else DataError(f"{path}: {error}") from error
    return goals


def _mapping(path: Path, what: str, value: Any, keys: Sequence[str]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise DataError(f"{path}: {what} must hold {', '.join(keys)}, is {_SHORT.repr(value)}")
    unknown = [key for key in value if key not in keys]
    if unknown:
        raise DataError(f"{path}: {what} has the unknown key {_SHORT.repr(unknown[0])}, known are {', '.join(keys)}")
    return value


def _goal(path: Path, index: int, value: Any) -> Goal:
    what = f"goal {index + 1}"
    one = _mapping(path, what, value, _GOAL_KEYS)
    for key in _GOAL_KEYS:
        if key not in one:
            raise DataError(f"{path}: {what} has no {key}")
    if not isinstance(one["name"], str):
        raise DataError(f"{path}: name of {what} is {_SHORT.repr(one['name'])}, must be a text (in quotes)")
    for key in ("x", "y"):
        number = one[key]
        if isinstance(number, bool) or not isinstance(number, int | float) or abs(number) > 1e300:
            raise DataError(f"{path}: {key} of {what} is {_SHORT.repr(number)}, must be a number [m]")
    return Goal(one["name"], float(one["x"]), float(one["y"]))


def _map(path: Path, described: dict[str, Any]) -> Path | None:
    name = described.get("map")
    if name is None:
        return None
    if not isinstance(name, str) or not name:
        raise DataError(f"{path}: map is {_SHORT.repr(name)}, must be the path of a map's .yaml")
    return path.parent / name


def write_goals(goals: Goals, path: str | Path) -> None:
    """Writes what `read_goals` reads; the map's path relative to the file where it lies beside or below it.

    ValueError for a suffix other than .yaml or .yml.
    """
    path = Path(path)
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(f"path is {path}, must end in .yaml")
    described: dict[str, Any] = {}
    if goals.map is not None:
        there, here = goals.map.absolute(), path.parent.absolute()
        described["map"] = str(there.relative_to(here) if there.is_relative_to(here) else there)
    described["goals"] = [{"name": goal.name, "x": float(goal.x), "y": float(goal.y)} for goal in goals.goals]
    path.write_text(yaml.safe_dump(described, sort_keys=False, allow_unicode=True), encoding="utf-8")
