"""From the driver's input to a path by learned intention and path primitives (Sec. 3.3-3.4.2, ERRATA 19-21).

intention g* -> primitive scaled to it -> reward landscape -> dynamic policy programming -> a drivable path.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.grid import ObstaclePoints, OccupancyGrid
from lfdcore.planning import DppConfig, DppSolver, GridMdp, RewardConfig, greedy_path, path_cells, path_reward
from lfdcore.wheelchair.drivable_path import START, DrivablePathConfig, DrivablePathFinder
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.planner import PlannedPath
from lfdcore.wheelchair.window import cell_centres, free_mask

if TYPE_CHECKING:
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel


@dataclass(frozen=True, kw_only=True)
class PrimitivesPlannerConfig:
    """How paths are planned. The printed values are those of `thesis()`."""

    reward: RewardConfig = field(default_factory=RewardConfig)
    dpp: DppConfig = field(default_factory=DppConfig)
    goals_comply: bool = True
    """Weigh each goal by the compliance of its primitive, so that a path is not let go at once; printed: no."""
    drivable: DrivablePathConfig = field(default_factory=DrivablePathConfig)

    @staticmethod
    def thesis() -> PrimitivesPlannerConfig:
        """The printed loop: soft obstacles, K - 1 = 99 sweeps, no inflation, no footprint."""
        return PrimitivesPlannerConfig(
            dpp=DppConfig(sweeps=99, blocked=False), goals_comply=False, drivable=DrivablePathConfig.thesis()
        )


@dataclass(frozen=True, kw_only=True)
class PrimitivePath(PlannedPath):
    """A path with the stages of Fig. 3.8-3.10."""

    primitive: NDArray[np.float64]
    """(50, 2) [m]"""
    intention: NDArray[np.float32]
    """(100, 100) likelihood of each cell"""


class PrimitivesPlanner:
    """Plans for one chair; keeps its solvers' memory between calls."""

    def __init__(self, model: DriveAssistantModel, config: PrimitivesPlannerConfig, chair: ChairGeometry) -> None:
        self.model = model
        self.config = config
        self.chair = chair
        self.look_ahead = model.compliance.config.look_ahead
        self._goal_cells, self._control_points = self._control_points_of_goals()
        self._dpp = DppSolver(config.dpp)
        self._finder = DrivablePathFinder(config.drivable, chair)

    def _control_points_of_goals(self) -> tuple[tuple[NDArray[np.intp], ...], NDArray[np.float64]]:
        """Cells that may be a goal (iy, ix), and the point a look-ahead on along the primitive to each (N, 2) [m]."""
        centres = cell_centres()
        far = np.nonzero(np.linalg.norm(centres, axis=2) >= self.config.drivable.shortest)
        paths = self.model.primitives.scaled_to_all(centres[far])
        travelled = np.cumsum(np.linalg.norm(np.diff(paths, axis=1), axis=2), axis=1)
        reached = np.minimum((travelled < self.look_ahead).sum(axis=1), paths.shape[1] - 1)
        return far, paths[np.arange(len(paths)), reached]

    def compliances(self, control_points: NDArray[np.float64], joystick: NDArray[np.float64]) -> NDArray[np.float64]:
        """By the learned compliance model (Sec. 3.4.3)."""
        return self.model.compliance.compliances(control_points, joystick)

    def plan(self, observation: Observation, grid: OccupancyGrid, obstacles: ObstaclePoints) -> PrimitivePath | None:
        """See Planner."""
        intention = self._intention(observation, grid)
        found = self.model.intention.goal(intention)
        if found is None:
            return None
        goal, likelihood = found
        primitive = self.model.primitives.scaled_to(goal)
        drawn = self._draw_widest(grid, primitive)
        if drawn is None:
            return None
        drivable = self._finder.drivable(drawn[0], self.look_ahead, obstacles, observation.twist)
        if drivable is None:
            return None
        return PrimitivePath(
            **drivable._asdict(),
            goal=(float(goal[0]), float(goal[1])),
            likelihood=likelihood,
            primitive=primitive,
            intention=intention,
            reward=drawn[1],
        )

    def _intention(self, observation: Observation, grid: OccupancyGrid) -> NDArray[np.float32]:
        joystick = np.array(observation.joystick)
        laser = observation.scan_mounting(self.chair.T_base_laser)
        intention = self.model.intention.predict(joystick, observation.scan, laser, free_mask(grid))
        return self._complying(intention, joystick) if self.config.goals_comply else intention

    def _complying(self, intention: NDArray[np.float32], joystick: NDArray[np.float64]) -> NDArray[np.float32]:
        weight = np.zeros_like(intention)
        weight[self._goal_cells] = self.model.compliance.compliances(self._control_points, joystick)
        weighed = intention * weight
        total = float(weighed.sum(dtype=np.float64))
        return weighed / np.float32(total) if total > 0 else weighed

    def _draw_widest(
        self, grid: OccupancyGrid, primitive: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]] | None:
        """The path that keeps the widest of the inflations free."""
        drawings = (self._draw(grid, primitive, inflation) for inflation in self.config.drivable.inflations)
        return next((drawn for drawn in drawings if drawn is not None), None)

    def _draw(
        self, grid: OccupancyGrid, primitive: NDArray[np.float64], inflation: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]] | None:
        """The DPP path (Alg. 2) over obstacles grown by `inflation` [m], and its reward; None if it leads nowhere."""
        blocked = self._finder.blocked(grid, inflation)
        cells = path_cells(primitive, grid)
        free = ~blocked[cells[:, 1], cells[:, 0]]
        if not free[1:].any():
            return None
        cells = cells[: np.flatnonzero(free)[-1] + 1]  # a blocked goal becomes the primitive's last free cell
        reward = path_reward(blocked, cells, self.config.reward)
        drawn = greedy_path(self._dpp.solve(GridMdp(reward, blocked)), START, tuple(cells[-1]))
        path = self._finder.long_enough(drawn.cells, grid)
        return None if path is None else (path, reward)
