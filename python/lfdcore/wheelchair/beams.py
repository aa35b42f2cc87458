"""Which beam of a scan covers a place, and where beams end (Sec. 3.3)."""

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.wheelchair.window import WINDOW

Floats = NDArray[np.float64]


class BeamGeometry:
    """The beams of one laser in the window of base_link.

    angle_min, angle_increment [rad] and the number of beams as in sensor_msgs/LaserScan; T_base_laser: the laser's pose
    in base_link. ValueError for no beams, an increment of 0 or a laser outside the window.
    """

    def __init__(self, beams: int, angle_min: float, angle_increment: float, T_base_laser: Pose2) -> None:
        if beams < 1 or not np.isfinite([angle_min, angle_increment]).all() or angle_increment == 0:
            raise ValueError(
                f"a laser with {beams} beams from {angle_min} rad in steps of {angle_increment} rad cannot be used"
            )
        if max(abs(T_base_laser.x), abs(T_base_laser.y)) >= WINDOW:
            raise ValueError(f"the laser at {T_base_laser} lies outside the local window of +-{WINDOW} m")
        self.beams = beams
        self.angle_min, self.angle_increment = float(angle_min), float(angle_increment)
        self.T_base_laser = T_base_laser
        self._T_laser_base = T_base_laser.inverse()
        angle = self.angle_min + self.angle_increment * np.arange(beams) + T_base_laser.yaw
        self._directions = np.stack([np.cos(angle), np.sin(angle)], 1)
        self.caps = self._border_distances()
        """(B,) [m]: from the laser along each beam to the window's border"""

    def _border_distances(self) -> Floats:
        laser = np.array([self.T_base_laser.x, self.T_base_laser.y])
        with np.errstate(divide="ignore", over="ignore"):
            to_lines = np.abs((np.copysign(WINDOW, self._directions) - laser) / self._directions)
        return np.asarray(to_lines.min(axis=1))

    def hits(self, lengths: Floats, hit: NDArray[np.bool_]) -> Floats:
        """Where the beams of one scan ended on something -> (M, 2) [m] in base_link.

        lengths (B,) [m] and hit (B,): as lfdcore.grid.read_beams reads the scan.
        """
        laser = np.array([self.T_base_laser.x, self.T_base_laser.y])
        return np.asarray(laser + lengths[hit, None] * self._directions[hit])

    def locate(self, points: Floats) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
        """Points (N, 2) [m] in base_link -> beam (N,), distance from the laser (N,) [m], inside its field of view (N,).

        The beam is argmin |theta - arctan2(y, x)| in the laser's frame, wrapped (Sec. 3.3); a point outside the field
        of view gets the beam nearest in angle.
        """
        local = self._T_laser_base.transform(points)
        angle = np.arctan2(local[:, 1], local[:, 0])
        middle = self.angle_min + self.angle_increment * (self.beams - 1) / 2
        wanted = wrap_angle(angle - middle) / self.angle_increment + (self.beams - 1) / 2
        beam = np.clip(np.rint(wanted), 0, self.beams - 1).astype(np.intp)
        inside = (wanted > -0.5 - 1e-9) & (wanted < self.beams - 0.5 + 1e-9)
        return beam, np.hypot(local[:, 0], local[:, 1]), inside
