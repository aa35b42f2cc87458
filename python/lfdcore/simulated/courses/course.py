"""What a course is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Pose2, arc_length
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.drawing import Door

FloatArray = npt.NDArray[np.float64]
Split = Literal["training", "tuning", "test"]


@dataclass(frozen=True, eq=False)
class Course:
    """A world, where to start in it and the way to go.

    grid: the world, whose frame is `map`. start: T_map_base. route (N, 2) [m, map]: smooth, points about .1 m apart;
    the last point repeats the first where `loop` is true. split: what the course may be used for: demonstrations
    ('training'), choosing the assistant's numbers ('tuning') or reported results only ('test').
    """

    name: str
    grid: OccupancyGrid
    start: Pose2
    route: FloatArray
    loop: bool
    description: str
    split: Split
    doors: tuple[Door, ...] = ()

    def __post_init__(self) -> None:
        route = np.array(self.route, dtype=np.float64)
        if route.ndim != 2 or route.shape[1] != 2 or len(route) < 2 or not np.isfinite(route).all():
            raise ValueError(f"route must be a finite (N >= 2, 2) array [m], got shape {route.shape}")
        if self.split not in ("training", "tuning", "test"):
            raise ValueError(f"split must be 'training', 'tuning' or 'test', got {self.split!r}")
        route.setflags(write=False)
        object.__setattr__(self, "route", route)

    @property
    def length(self) -> float:
        """Length [m] of the route, a lap where it is a loop."""
        return float(arc_length(self.route)[-1])


def heading_of(route: FloatArray, reach: int = 3) -> float:
    """Direction [rad] in which a route (N, 2) sets out, over its first `reach` points."""
    dx, dy = route[min(reach, len(route) - 1)] - route[0]
    return float(np.arctan2(dy, dx))
