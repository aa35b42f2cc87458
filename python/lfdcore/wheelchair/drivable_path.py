"""From a path over cells to one that the chair's whole body can follow (ERRATA 20; not in the text).

The pursuit of the path is rolled out with the oriented footprint; where that would touch, hybrid A* goes to the same
end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import FootprintRollout, FootprintRolloutConfig, rollout_pursuit
from lfdcore.geometry import Footprint, Pose2, Twist2, arc_length
from lfdcore.grid import ObstaclePoints, OccupancyGrid, inflate
from lfdcore.planning import HybridAstar, HybridAstarConfig
from lfdcore.wheelchair.observation import ChairGeometry

START = (50, 50)
"""(ix, iy) of base_link in the local window."""


@dataclass(frozen=True, kw_only=True)
class DrivablePathConfig:
    """How cells and paths are kept clear of obstacles. The printed values are those of `thesis()`."""

    inflations: tuple[float, ...] = (0.35, 0.30, 0.25)
    """Radii [m] by which obstacles grow, tried in turn until there is a path; printed: none."""
    check_footprint: bool = True
    """Roll the pursuit out with the oriented footprint and repair by hybrid A*; printed: no."""
    footprint_margin: float = 0.05
    """Kept around the footprint in the roll-out [m]."""
    shortest: float = 0.35
    """Paths shorter than this [m] lead nowhere and are refused."""
    tight_look_ahead: float = 0.3
    """Of pure pursuit [m] on a path of hybrid A*."""
    rollout: FootprintRolloutConfig = field(default_factory=FootprintRolloutConfig)
    hybrid_astar: HybridAstarConfig = field(default_factory=HybridAstarConfig)

    @staticmethod
    def thesis() -> DrivablePathConfig:
        """No inflation, no footprint."""
        return DrivablePathConfig(inflations=(0.0,), check_footprint=False)


class DrivablePath(NamedTuple):
    """See PlannedPath for the fields."""

    path: NDArray[np.float64]
    source: str
    look_ahead: float
    rollout: FootprintRollout | None


class DrivablePathFinder:
    """For one chair; keeps hybrid A*'s memory between calls."""

    def __init__(self, config: DrivablePathConfig, chair: ChairGeometry) -> None:
        self.config = config
        self.chair = chair
        self._hybrid_astar = HybridAstar(chair.footprint, config=config.hybrid_astar)

    def blocked(self, grid: OccupancyGrid, inflation: float) -> NDArray[np.bool_]:
        """(100, 100): obstacles grown by `inflation` [m]; the chair's own cell is free."""
        grown = inflate(grid.occupied_mask(), inflation, grid.resolution)
        grown[START[1], START[0]] = False
        return grown

    def long_enough(self, cells: NDArray[Any], grid: OccupancyGrid) -> NDArray[np.float64] | None:
        """A path over int cells (N, 2) as (ix, iy) without its staircase [m], None if it leads nowhere."""
        path = smooth(np.array(grid.origin) + (cells + 0.5) * grid.resolution)
        return None if arc_length(path)[-1] < self.config.shortest else path

    def drivable(
        self, path: NDArray[np.float64], look_ahead: float, obstacles: ObstaclePoints, twist: Twist2
    ) -> DrivablePath | None:
        """The path (N, 2) if the chair's body can follow it, else hybrid A*'s to the same end, else None."""
        config = self.config
        if not config.check_footprint:
            return DrivablePath(path, "grid", look_ahead, None)
        body = self.chair.footprint.grown(config.footprint_margin)
        rollout = rollout_pursuit(path, obstacles, body, self.chair.limits, twist, config=config.rollout)
        if np.isinf(rollout.time_to_contact):
            return DrivablePath(path, "grid", look_ahead, rollout)
        end = self._last_free(path, obstacles, body)
        if end is None:
            return None
        found = self._hybrid_astar.solve(obstacles, Pose2(), path[end])
        if not found.found:
            return None
        return DrivablePath(found.path[:, :2], "hybrid_astar", config.tight_look_ahead, rollout)

    def _last_free(self, path: NDArray[np.float64], obstacles: ObstaclePoints, body: Footprint) -> int | None:
        """The path's last point on which the body, turned along the path, touches nothing."""
        heading = np.arctan2(*np.gradient(path, axis=0).T[::-1])
        shortest = int(np.searchsorted(arc_length(path), self.config.shortest))
        for i in range(len(path) - 1, shortest, -2):
            if not obstacles.collides(Pose2(path[i, 0], path[i, 1], heading[i]), body):
                return i
        return None


def smooth(path: NDArray[np.float64], half_window: int = 3) -> NDArray[np.float64]:
    """A grid path (N, 2) without its staircase: a moving average that keeps both ends."""
    padded = np.vstack([np.repeat(path[:1], half_window, 0), path, np.repeat(path[-1:], half_window, 0)])
    size = 2 * half_window + 1
    total = np.cumsum(np.vstack([[0.0, 0.0], padded]), axis=0)
    result: NDArray[np.float64] = (total[size:] - total[:-size]) / size
    result[0], result[-1] = path[0], path[-1]
    return result
