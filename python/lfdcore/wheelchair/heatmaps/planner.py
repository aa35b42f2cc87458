"""From the driver's input to a path over heatmaps (Ch. 4, Alg. 3; ERRATA 25-31).

free space of the scan -> sensor heatmap; stick -> user heatmap; their product -> rewards -> Q-learning -> a drivable
path.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.grid import ObstaclePoints, OccupancyGrid, local_grid
from lfdcore.planning import (
    GridMdp,
    HeatmapRewardConfig,
    MovementTemplate,
    OrientationMoments,
    QLearningConfig,
    QLearningResult,
    QLearningSolver,
    compliances,
    greedy_path,
    heatmap_reward,
    joystick_orientation,
    user_heatmap,
)
from lfdcore.wheelchair.drivable_path import START, DrivablePathConfig, DrivablePathFinder
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.planner import LOOK_AHEAD, PlannedPath
from lfdcore.wheelchair.window import free_mask, squashed, values_at

if TYPE_CHECKING:
    from lfdcore.wheelchair.heatmaps.model import HeatmapModel

Heatmap = NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class HeatmapPlannerConfig:
    """How paths are planned. The printed values are those of `thesis()`."""

    look_ahead: float = LOOK_AHEAD
    """Of pure pursuit [m], and of the compliance with it (Sec. 3.4.2, 4.5)."""
    driver_sd: float = 0.6
    """How far a driver's stick points beside what is meant [rad], beyond what able demonstrators' did; printed: 0."""
    filtered_compliance: bool = False
    """Compliance is the user heatmap's value in the control point's cell, distance filter included (printed, Sec. 4.5);
    else the unfiltered density at the point's exact orientation (ERRATA 29)."""
    reward: HeatmapRewardConfig = field(default_factory=HeatmapRewardConfig)
    q_learning: QLearningConfig = field(default_factory=QLearningConfig)
    drivable: DrivablePathConfig = field(default_factory=DrivablePathConfig)

    @staticmethod
    def thesis() -> HeatmapPlannerConfig:
        """The printed loop: gamma .9, K - 1 = 99 sweeps, soft obstacles, inflated, compliance by the user heatmap
        (Sec. 4.5), no footprint."""
        return HeatmapPlannerConfig(
            driver_sd=0.0,
            filtered_compliance=True,
            q_learning=QLearningConfig(discount=0.9, sweeps=99, blocked=False),
            drivable=DrivablePathConfig(inflations=(0.35,), check_footprint=False),
        )


@dataclass(frozen=True)
class Heat:
    """The heatmaps of one moment (Fig. 4.11), each (100, 100) in [0, 1]."""

    sensor: Heatmap
    """I_sensor: where demonstrators went in such a place"""
    user: Heatmap
    """I_user: where the stick points"""
    intent: Heatmap
    """I_intent: their product over the cells seen free, divided by its maximum; all 0 where nothing is left of it"""
    orientation: OrientationMoments
    """of the stick that the driver is thought to mean"""


@dataclass(frozen=True, kw_only=True)
class HeatmapPath(PlannedPath):
    """A path with the stages of Fig. 4.11-4.12."""

    heat: Heat


class HeatmapPlanner:
    """Plans for one chair; keeps its solvers' memory between calls."""

    def __init__(self, model: HeatmapModel, config: HeatmapPlannerConfig, chair: ChairGeometry) -> None:
        self.model = model
        self.joystick = model.joystick
        """What is asked for the wanted stick; to be replaced by one that has adapted to the driver (Sec. 6.2.1)."""
        self.config = config
        self.chair = chair
        self.look_ahead = config.look_ahead
        self._template = MovementTemplate(chair.limits)
        self._q_learning = QLearningSolver(config.q_learning)
        self._finder = DrivablePathFinder(config.drivable, chair)

    def compliances(self, control_points: NDArray[np.float64], joystick: NDArray[np.float64]) -> NDArray[np.float64]:
        """As the config says (Sec. 4.5, ERRATA 29); 0 for a stick at rest."""
        orientation = self.orientation(joystick)
        if orientation is None:
            return np.zeros(len(control_points))
        if self.config.filtered_compliance:
            return values_at(user_heatmap(self._template, orientation).heatmap, control_points)
        return compliances(control_points, orientation, self.chair.limits)

    def orientation(self, joystick: NDArray[np.float64]) -> OrientationMoments | None:
        """Of the stick that the driver is thought to mean by this one (Eq. 4.1-4.2); None at rest."""
        if not joystick.any():
            return None
        wanted = joystick_orientation(*self.joystick.predict(joystick))
        if wanted is None:
            return None
        return OrientationMoments(wanted.mean, wanted.variance + self.config.driver_sd**2)

    def heat(self, observation: Observation, grid: OccupancyGrid) -> Heat | None:
        """The heatmaps (Sec. 4.3-4.5) over `grid`'s free cells; None for a stick at rest."""
        joystick = np.array(observation.joystick)
        orientation = self.orientation(joystick)
        if orientation is None:
            return None
        seen = local_grid(observation.scan, observation.scan_mounting(self.chair.T_base_laser))
        sensor, user = self.sources(free_mask(seen), joystick, orientation)
        return Heat(sensor, user, squashed(sensor * user * free_mask(grid)), orientation)

    def sources(
        self, free: NDArray[np.bool_], joystick: NDArray[np.float64], orientation: OrientationMoments
    ) -> tuple[Heatmap, Heatmap]:
        """Sensor and user heatmap (100, 100), of what the scan sees free (100, 100), the stick (2,) and what is meant
        by it."""
        return self.model.sensor.predict(free), user_heatmap(self._template, orientation).heatmap

    def plan(self, observation: Observation, grid: OccupancyGrid, obstacles: ObstaclePoints) -> HeatmapPath | None:
        """See Planner."""
        heat = self.heat(observation, grid)
        if heat is None or not heat.intent.any():
            return None
        drawings = (self._draw(grid, heat, inflation) for inflation in self.config.drivable.inflations)
        drawn = next((found for found in drawings if found is not None), None)
        if drawn is None:
            return None
        path, goal, reward = drawn
        drivable = self._finder.drivable(path, self.look_ahead, obstacles, observation.twist)
        if drivable is None:
            return None
        return HeatmapPath(
            **drivable._asdict(),
            goal=(float(path[-1, 0]), float(path[-1, 1])),
            likelihood=float(heat.intent[goal[1], goal[0]]),
            reward=reward,
            heat=heat,
        )

    def solve(self, grid: OccupancyGrid, heat: Heat, inflation: float) -> QLearningResult:
        """Q after learning (Alg. 3) over obstacles grown by `inflation` [m]."""
        blocked = self._finder.blocked(grid, inflation)
        return self._q_learning.solve(GridMdp(heatmap_reward(heat.intent, blocked, self.config.reward), blocked))

    def _draw(
        self, grid: OccupancyGrid, heat: Heat, inflation: float
    ) -> tuple[NDArray[np.float64], tuple[int, int], Heatmap] | None:
        """The path (N, 2) [m] by Q-learning, its last cell (ix, iy) and the rewards; None if it leads nowhere."""
        result = self.solve(grid, heat, inflation)
        cells = greedy_path(result, START).cells
        path = self._finder.long_enough(cells, grid)
        return None if path is None else (path, (int(cells[-1, 0]), int(cells[-1, 1])), result.mdp.reward)
