"""Moments of a drive log that are worth a picture, chosen by rule: the same log gives the same moments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.grid import ObstaclePoints, OccupancyGrid
from lfdcore.wheelchair.observation import ChairGeometry, Observation, observations
from lfdcore.wheelchair.primitives.local_paths import LocalPaths
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.planner import PrimitivePath, PrimitivesPlannerConfig
from lfdcore.wheelchair.surroundings import Surroundings

CANDIDATES = 24
"""Most moments of a log that are planned for."""
_TURNS = np.radians((35.0, 115.0))  # a path that ends turned by so much shows more than a straight one


@dataclass(frozen=True)
class Moment:
    """What an assistant saw at one scan of a log, and the path it planned. Grid and obstacles in base_link."""

    observation: Observation
    grid: OccupancyGrid
    obstacles: ObstaclePoints
    chair: ChairGeometry
    planned: PrimitivePath
    config: PrimitivesPlannerConfig

    @property
    def worth(self) -> float:
        """How much there is to see: occupied cells in the front half of the window, times how far g* is aside [m]."""
        crowd = int(self.grid.occupied_mask()[:, self.grid.width // 2 :].sum())
        return crowd * abs(self.planned.goal[1])


def telling_moments(model: DriveAssistantModel, log: DriveLog, paths: LocalPaths) -> dict[str, Moment]:
    """For each source of a path ('grid', 'hybrid_astar') the moment that is worth most (Moment.worth).

    Only scans from which the demonstrator then turned by 35-115 degrees are looked at, at most CANDIDATES of them,
    evenly spread. Empty if none of them gives a path.
    """
    chair = ChairGeometry.thesis(log.mounting)
    planner, around = model.planner(chair), Surroundings(chair)
    best: dict[str, Moment] = {}
    wanted = _candidates(paths)
    for now in observations(log):
        obstacles = around.see(now)
        if now.stamp not in wanted:
            continue
        grid = around.grid(now)
        planned = planner.plan(now, grid, obstacles)
        if planned is not None:
            moment = Moment(now, grid, obstacles, chair, planned, planner.config)
            if planned.source not in best or moment.worth > best[planned.source].worth:
                best[planned.source] = moment
    return dict(sorted(best.items()))


def _candidates(paths: LocalPaths) -> set[float]:
    """Stamps [s] of the scans to look at."""
    turned = np.abs(paths.end_yaw)
    telling = (turned >= _TURNS[0]) & (turned <= _TURNS[1]) & (paths.goal[:, 0] > 0.8) & (paths.joystick[:, 0] > 0.2)
    stamps = paths.stamp[telling]
    if not len(stamps):
        return set()
    return set(stamps[np.linspace(0, len(stamps) - 1, CANDIDATES).round().astype(np.intp)].tolist())
