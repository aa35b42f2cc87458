"""What is around the chair, from recent scans, where the present one cannot see."""

from __future__ import annotations

import numpy as np

from lfdcore.grid import ObstaclePoints, OccupancyGrid, RollingMap
from lfdcore.wheelchair.observation import ChairGeometry, Observation

MEMORY = 120.0
"""[s] that the rolling map remembers a scan"""


class Surroundings:
    """What is around the chair: a rolling map of recent scans, since the LIDAR never sees beside the body."""

    def __init__(self, chair: ChairGeometry, duration: float = MEMORY) -> None:
        self._chair = chair
        self._map = RollingMap(duration)
        self._now = self._newest_scan = -np.inf

    def clear(self) -> None:
        """Forgets all scans."""
        self._map.clear()
        self._now = self._newest_scan = -np.inf

    def see(self, observation: Observation) -> ObstaclePoints:
        """Takes in a scan from where it was taken, unless it has it already; -> obstacle points in base_link, now.

        ValueError for a stamp, of the tick or of the scan, before the last one: reset() starts a new drive.
        """
        if observation.stamp < self._now:
            raise ValueError(f"stamp goes back from {self._now} s to {observation.stamp} s without a reset")
        if observation.scan_stamp != self._newest_scan:
            taken_at = observation.scan_pose or observation.pose
            self._map.insert(observation.scan_stamp, observation.scan, self._chair.T_base_laser, taken_at)
        self._now, self._newest_scan = observation.stamp, observation.scan_stamp
        return self._map.obstacles(observation.pose)

    def grid(self, observation: Observation) -> OccupancyGrid:
        """-> local grid around base_link."""
        return self._map.local_grid(observation.pose)
