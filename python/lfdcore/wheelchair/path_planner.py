"""From the driver's input to a path that the chair's body can follow (Sec. 3.3-3.4.2, ERRATA 19-21).

intention g* -> primitive scaled to it -> reward landscape -> dynamic policy programming -> roll-out of the pursuit
with the oriented footprint -> where that would touch: hybrid A* to the same end.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import FootprintRollout, RolloutConfig, rollout_pursuit
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, arc_length
from lfdcore.grid import LaserScan, ObstaclePoints, OccupancyGrid, inflate
from lfdcore.planning import (
    DppConfig,
    DppSolver,
    GridMdp,
    HybridAstar,
    HybridAstarConfig,
    RewardConfig,
    greedy_path,
    path_cells,
    path_reward,
)
from lfdcore.wheelchair.model_file import DriveAssistantModel

START = (50, 50)
"""(ix, iy) of base_link in the local window."""


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """How paths are planned. The printed values are those of `thesis()`."""

    reward: RewardConfig = field(default_factory=RewardConfig)
    dpp: DppConfig = field(default_factory=DppConfig)
    block_obstacles: bool = True
    """Forbid moves into obstacle cells (ERRATA 20); printed: obstacles only cost."""
    inflations: tuple[float, ...] = (0.35, 0.30, 0.25)
    """Radii [m] by which obstacles grow, tried in turn until there is a path; printed: none."""
    check_footprint: bool = True
    """Roll the pursuit out with the oriented footprint and repair by hybrid A*; printed: no."""
    footprint_margin: float = 0.03
    """Kept around the footprint in the roll-out [m]."""
    start_clear: float = 0.40
    """Radius [m] around base_link that is never blocked by inflation, so that a chair beside a wall can plan."""
    shortest: float = 0.35
    """Paths shorter than this [m] lead nowhere and are refused."""
    look_ahead: float = 0.8
    """Of pure pursuit [m] (Sec. 3.4.2)."""
    tight_look_ahead: float = 0.3
    """Of pure pursuit [m] on a path of hybrid A*."""
    rollout: RolloutConfig = field(default_factory=RolloutConfig)
    hybrid_astar: HybridAstarConfig = field(default_factory=HybridAstarConfig)

    @staticmethod
    def thesis() -> PlannerConfig:
        """The printed loop: soft obstacles, K - 1 = 99 sweeps, no inflation, no footprint."""
        return PlannerConfig(
            dpp=DppConfig(sweeps=99), block_obstacles=False, inflations=(0.0,), check_footprint=False, start_clear=0.0
        )


@dataclass(frozen=True)
class PlannedPath:
    """A path with all that led to it (Fig. 3.8-3.10); frame base_link at the time of planning."""

    path: NDArray[np.float64]
    """(N, 2) [m]"""
    source: str
    """'dpp' or 'hybrid_astar'"""
    look_ahead: float
    """For pure pursuit [m]."""
    goal: tuple[float, float]
    """g* [m]"""
    likelihood: float
    """Of the goal's cell."""
    primitive: NDArray[np.float64]
    """(50, 2) [m]"""
    intention: NDArray[np.float32]
    """(100, 100) likelihood of each cell"""
    reward: NDArray[np.float32]
    """(100, 100)"""
    rollout: FootprintRollout | None
    """None if the footprint is not checked."""


class PathPlanner:
    """Plans for one chair; keeps its solvers' memory between calls."""

    def __init__(
        self, model: DriveAssistantModel, config: PlannerConfig, footprint: Footprint, limits: MotionLimits
    ) -> None:
        self.model = model
        self.config = config
        self.footprint = footprint
        self.limits = limits
        self._dpp = DppSolver(config.dpp)
        self._hybrid_astar = HybridAstar(config.hybrid_astar)

    def plan(
        self,
        joystick: tuple[float, float],
        scan: LaserScan,
        T_base_laser: Pose2,
        grid: OccupancyGrid,
        obstacles: ObstaclePoints,
        twist: Twist2,
    ) -> PlannedPath | None:
        """A path for the driver's input; None if nothing is intended or nothing leads there without contact."""
        intention = self.model.intention.predict(np.array(joystick), scan, T_base_laser, grid.data == 0)
        found = self.model.intention.goal(intention)
        if found is None:
            return None
        goal, likelihood = found
        primitive = self.model.primitives.scaled_to(goal)
        occupied = grid.occupied_mask()
        for inflation in self.config.inflations:
            grid_path, reward = self._grid_path(occupied, grid, primitive, inflation)
            if grid_path is None:
                continue
            drivable = self._drivable(grid_path, obstacles, twist)
            if drivable is not None:
                path, source, look_ahead, rollout = drivable
                return PlannedPath(
                    path,
                    source,
                    look_ahead,
                    (float(goal[0]), float(goal[1])),
                    likelihood,
                    primitive,
                    intention,
                    reward,
                    rollout,
                )
        return None
