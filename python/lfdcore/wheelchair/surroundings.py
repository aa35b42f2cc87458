"""What is around the chair, from recent scans, where the present one cannot see."""

from __future__ import annotations

import numpy as np

from lfdcore.grid import ObstaclePoints, OccupancyGrid, RollingMap
from lfdcore.wheelchair.observation import ChairGeometry, Observation

MEMORY = 600.0
"""[s] that the rolling map remembers a scan"""
REACH = 1.5
"""[m] from the outline within which never-seen space matters: what the chair can sweep over before it stands"""


class Surroundings:
    """What is around the chair: a rolling map of recent scans, since the LIDAR never sees beside the body."""

    def __init__(self, chair: ChairGeometry, duration: float = MEMORY) -> None:
        self._chair = chair
        self._map = RollingMap(
            duration,
            range_noise=chair.range_noise,
            odometry_error=chair.odometry_error,
            own_body=chair.footprint,
        )
        self._newest_scan = -np.inf

    def clear(self) -> None:
        """Forgets all scans."""
        self._map.clear()
        self._newest_scan = -np.inf

    def see(self, observation: Observation) -> ObstaclePoints:
        """Takes in a scan from where it was taken, unless it has it already or it has no stamp; -> obstacle points in
        base_link, now.

        ValueError for a scan stamped before the last one: clear() starts a new drive.
        """
        stamp = observation.scan_stamp
        if stamp is not None and stamp != self._newest_scan:
            taken_at = observation.scan_pose or observation.pose
            self._map.insert(stamp, observation.scan, self._chair.T_base_laser, taken_at)
            self._newest_scan = stamp
        return self._map.obstacles(observation.pose)

    def unseen(self, observation: Observation) -> ObstaclePoints:
        """-> the border of the space that no beam has seen, as points in base_link."""
        return self._map.unseen(observation.pose, self._chair.footprint, REACH)

    def grid(self, observation: Observation) -> OccupancyGrid:
        """-> local grid around base_link."""
        return self._map.local_grid(observation.pose)
