"""Which beam of a scan covers a place, and how far it sees inside the local window (Sec. 3.3)."""

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2

WINDOW = 2.5
"""Half the side of the local window [m]: x and y in base_link lie within +-WINDOW (Sec. 3.2: 5 m square)."""

Floats = NDArray[np.float64]


def clean_ranges(ranges: NDArray[np.floating], range_min: float, range_max: float) -> Floats | None:
    """Ranges (B,) or (S, B) [m] as numbers that can be compared; None if no beam measured anything.

    +inf or beyond range_max: range_max (nothing seen). -inf, or below range_min: range_min (REP-117: closer than the
    sensor can tell). NaN or a negative number is no measurement: the nearest beam of that scan that has one stands in
    (ties: the lower index). A row of (S, B) without any measurement becomes 0 everywhere: nothing is visible in it.
    """
    values = np.asarray(ranges, dtype=np.float64)
    if values.ndim == 0 or values.shape[-1] == 0:
        raise ValueError("a scan has 0 beams, at least 1 is needed")
    missing = np.isnan(values) | ((values < 0) & ~np.isneginf(values))
    if missing.ndim == 1 and missing.all():
        return None
    values = np.clip(np.where(missing, 0.0, values), range_min, range_max)
    return _fill(values, missing) if missing.any() else values


def _fill(values: Floats, missing: NDArray[np.bool_]) -> Floats:
    for row, gaps in zip(np.atleast_2d(values), np.atleast_2d(missing), strict=True):
        if gaps.all():
            row[:] = 0.0
        elif gaps.any():
            known = np.flatnonzero(~gaps)
            after = np.searchsorted(known, np.arange(len(row)))
            low, high = known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]
            index = np.arange(len(row))
            row[:] = row[np.where(np.abs(index - low) <= np.abs(high - index), low, high)]
    return values


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

    def hits(self, ranges: NDArray[np.floating], range_max: float) -> Floats:
        """Where the beams of one scan (B,) [m] ended on something -> (M, 2) [m] in base_link."""
        hit = (ranges > 0) & (ranges < range_max)  # neither NaN nor inf
        laser = np.array([self.T_base_laser.x, self.T_base_laser.y])
        return np.asarray(laser + ranges[hit, None].astype(np.float64) * self._directions[hit])

    def locate(self, points: Floats) -> tuple[NDArray[np.intp], Floats, NDArray[np.bool_]]:
        """Points (N, 2) [m] in base_link -> beam (N,), distance from the laser (N,) [m], inside its field of view (N,).

        The beam is argmin |theta - arctan2(y, x)| in the laser's frame, wrapped (Sec. 3.3); a point outside the field
        of view gets the beam nearest in angle.
        """
        local = self._T_laser_base.transform(points)
        angle = np.arctan2(local[:, 1], local[:, 0])
        middle = self.angle_min + self.angle_increment * (self.beams - 1) / 2
        off = (angle - middle + np.pi) % (2 * np.pi) - np.pi
        wanted = off / self.angle_increment + (self.beams - 1) / 2
        beam = np.clip(np.rint(wanted), 0, self.beams - 1).astype(np.intp)
        inside = (wanted > -0.5 - 1e-9) & (wanted < self.beams - 0.5 + 1e-9)
        return beam, np.hypot(local[:, 0], local[:, 1]), inside
