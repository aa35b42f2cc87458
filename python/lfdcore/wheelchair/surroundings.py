"""What is around the chair, from recent scans, where the present one cannot see."""

from __future__ import annotations

import numpy as np

from lfdcore.grid import ObstaclePoints, OccupancyGrid, RollingMap
from lfdcore.wheelchair.observation import ChairGeometry, Observation

MEMORY = 600.0
"""[s] that the rolling map remembers a scan"""
RADIUS = 4.0
"""[m] around base_link within which obstacles count, at least"""
FARTHEST = 20.0
"""[m] around base_link that the rolling map reaches, at most"""
ERRORS = 1.4
"""A chair that is as wrong as a supervisor allows goes no more than so many times as far as declared until it stands:
1.05 times as fast, with .8 of the braking."""


class Surroundings:
    """What is around the chair: a rolling map of recent scans, since the LIDAR never sees beside the body.

    ValueError for a chair that sweeps over more than 20 m until it stands.
    """

    def __init__(self, chair: ChairGeometry, duration: float = MEMORY) -> None:
        self._chair = chair
        self._reach = reach_until_standstill(chair)
        swept = self._reach + chair.footprint.outer_radius()
        if swept > FARTHEST:
            raise ValueError(f"the chair sweeps over {swept:.1f} m until it stands, must be at most {FARTHEST} m")
        self._map = RollingMap(
            duration,
            radius=max(RADIUS, swept),
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
        return self._map.unseen(observation.pose, self._chair.footprint, self._reach)

    def age(self, observation: Observation) -> float:
        """-> of the newest scan [s], 10 at the most."""
        return float(np.clip(observation.stamp - self._newest_scan, 0.0, 10.0))

    def walkers(self, observation: Observation) -> ObstaclePoints:
        """-> the points of who walks about, in base_link."""
        return self._map.walkers(observation.pose)

    def grid(self, observation: Observation) -> OccupancyGrid:
        """-> local grid around base_link."""
        return self._map.local_grid(observation.pose)


def reach_until_standstill(chair: ChairGeometry) -> float:
    """[m] from its outline within which lies all that the chair can sweep over until it stands: it obeys what is under
    way, then the next command until that ends, and brakes."""
    limits, body = chair.limits, chair.footprint
    fastest = max(limits.max_linear, limits.max_reverse)
    following = chair.latency + chair.period + chair.jitter
    way = ERRORS * fastest * (following + fastest / (2 * limits.linear_braking))
    return way + body.outer_radius() - min(body.front, body.rear, body.half_width)
