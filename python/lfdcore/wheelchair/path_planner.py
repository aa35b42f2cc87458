"""From the driver's input to a path that the chair's body can follow (Sec. 3.3-3.4.2, ERRATA 19-21).

intention g* -> primitive scaled to it -> reward landscape -> dynamic policy programming -> roll-out of the pursuit
with the oriented footprint -> where that would touch: hybrid A* to the same end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import FootprintRollout, FootprintRolloutConfig, rollout_pursuit
from lfdcore.geometry import Footprint, Pose2, Twist2, arc_length
from lfdcore.grid import ObstaclePoints, OccupancyGrid, inflate
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
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.window import cell_centres

START = (50, 50)
"""(ix, iy) of base_link in the local window."""


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """How paths are planned. The printed values are those of `thesis()`."""

    reward: RewardConfig = field(default_factory=RewardConfig)
    dpp: DppConfig = field(default_factory=DppConfig)
    inflations: tuple[float, ...] = (0.35, 0.30, 0.25)
    """Radii [m] by which obstacles grow, tried in turn until there is a path; printed: none."""
    check_footprint: bool = True
    """Roll the pursuit out with the oriented footprint and repair by hybrid A*; printed: no."""
    footprint_margin: float = 0.05
    """Kept around the footprint in the roll-out [m]."""
    shortest: float = 0.35
    """Paths shorter than this [m] lead nowhere and are refused."""
    goals_comply: bool = True
    """Weigh each goal by the compliance of its primitive, so that a path is not let go at once; printed: no."""
    tight_look_ahead: float = 0.3
    """Of pure pursuit [m] on a path of hybrid A*."""
    rollout: FootprintRolloutConfig = field(default_factory=FootprintRolloutConfig)
    hybrid_astar: HybridAstarConfig = field(default_factory=HybridAstarConfig)

    @staticmethod
    def thesis() -> PlannerConfig:
        """The printed loop: soft obstacles, K - 1 = 99 sweeps, no inflation, no footprint."""
        return PlannerConfig(
            dpp=DppConfig(sweeps=99, blocked=False),
            inflations=(0.0,),
            check_footprint=False,
            goals_comply=False,
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


class _Drivable(NamedTuple):
    path: NDArray[np.float64]
    source: str
    look_ahead: float
    rollout: FootprintRollout | None


class PathPlanner:
    """Plans for one chair; keeps its solvers' memory between calls."""

    def __init__(self, model: DriveAssistantModel, config: PlannerConfig, chair: ChairGeometry) -> None:
        self.model = model
        self.config = config
        self.chair = chair
        self.look_ahead = model.compliance.config.look_ahead
        """Of pure pursuit [m], the one that compliance was learned for (Sec. 3.4.2-3.4.3)."""
        self._goal_cells, self._control_points = self._control_points_of_goals()
        self._dpp = DppSolver(config.dpp)
        self._hybrid_astar = HybridAstar(chair.footprint, config=config.hybrid_astar)

    def _control_points_of_goals(self) -> tuple[tuple[NDArray[np.intp], ...], NDArray[np.float64]]:
        """Cells that may be a goal (iy, ix), and the point a look-ahead on along the primitive to each (N, 2) [m]."""
        centres = cell_centres()
        far = np.nonzero(np.linalg.norm(centres, axis=2) >= self.config.shortest)
        paths = self.model.primitives.scaled_to_all(centres[far])
        travelled = np.cumsum(np.linalg.norm(np.diff(paths, axis=1), axis=2), axis=1)
        reached = np.minimum((travelled < self.look_ahead).sum(axis=1), paths.shape[1] - 1)
        return far, paths[np.arange(len(paths)), reached]

    def plan(self, observation: Observation, grid: OccupancyGrid, obstacles: ObstaclePoints) -> PlannedPath | None:
        """A path for the driver's input; None if nothing is intended or nothing leads there without contact.

        `grid` and `obstacles` are the rolling map's, in base_link.
        """
        joystick = np.array(observation.joystick)
        laser = observation.scan_mounting(self.chair.T_base_laser)
        intention = self.model.intention.predict(joystick, observation.scan, laser, grid.data == 0)
        if self.config.goals_comply:
            intention = self._complying(intention, joystick)
        found = self.model.intention.goal(intention)
        if found is None:
            return None
        goal, likelihood = found
        primitive = self.model.primitives.scaled_to(goal)
        drawn = self._draw_widest(grid, primitive)
        if drawn is None:
            return None
        drivable = self._drivable(drawn[0], obstacles, observation.twist)
        if drivable is None:
            return None
        return PlannedPath(
            **drivable._asdict(),
            goal=(float(goal[0]), float(goal[1])),
            likelihood=likelihood,
            primitive=primitive,
            intention=intention,
            reward=drawn[1],
        )

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
        occupied = grid.occupied_mask()
        drawings = (self._draw(occupied, grid, primitive, inflation) for inflation in self.config.inflations)
        return next((drawn for drawn in drawings if drawn is not None), None)

    def _draw(
        self, occupied: NDArray[np.bool_], grid: OccupancyGrid, primitive: NDArray[np.float64], inflation: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]] | None:
        """The DPP path (Alg. 2) over obstacles grown by `inflation` [m], and its reward; None if it leads nowhere."""
        blocked = inflate(occupied, inflation, grid.resolution)
        blocked[START[1], START[0]] = False
        cells = path_cells(primitive, grid)
        free = ~blocked[cells[:, 1], cells[:, 0]]
        if not free[1:].any():
            return None
        cells = cells[: np.flatnonzero(free)[-1] + 1]  # a blocked goal becomes the primitive's last free cell
        reward = path_reward(blocked, cells, self.config.reward)
        result = self._dpp.solve(GridMdp(reward, blocked))
        drawn = greedy_path(result, START, tuple(cells[-1]))
        path = smooth(np.array(grid.origin) + (drawn.cells + 0.5) * grid.resolution)
        if arc_length(path)[-1] < self.config.shortest:
            return None
        return path, reward

    def _drivable(self, path: NDArray[np.float64], obstacles: ObstaclePoints, twist: Twist2) -> _Drivable | None:
        """The path if the chair's body can follow it, else hybrid A*'s to the same end, else None."""
        config = self.config
        if not config.check_footprint:
            return _Drivable(path, "dpp", self.look_ahead, None)
        body = self.chair.footprint.grown(config.footprint_margin)
        rollout = rollout_pursuit(path, obstacles, body, self.chair.limits, twist, config=config.rollout)
        if np.isinf(rollout.time_to_contact):
            return _Drivable(path, "dpp", self.look_ahead, rollout)
        end = self._last_free(path, obstacles, body)
        if end is None:
            return None
        found = self._hybrid_astar.solve(obstacles, Pose2(), path[end])
        if not found.found:
            return None
        return _Drivable(found.path[:, :2], "hybrid_astar", config.tight_look_ahead, rollout)

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
