"""Scans of one scanner whose number of beams or angles waver, on the angles of one (RPLIDAR, YDLIDAR, LD19)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lfdcore.grid import read_beams

MOST_BEAMS = 100_000
LONGEST = 1000.0
"""[m] No scanner's range_max is beyond."""
APART = 0.1
"""by which share an increment may differ from the first scan's: then it is the same scanner"""
ALL_ROUND = 2 * math.pi * 1.01

Ranges = NDArray[np.float32]


class BeamLayout:
    """The angles of a first scan, on which all others are put: a beam goes to the nearest of them, half an increment
    away at most; an angle without a beam is NaN (no measurement)."""

    def __init__(self, beams: int, angle_min: float, angle_increment: float) -> None:
        self.beams, self.angle_min, self.angle_increment = beams, angle_min, angle_increment
        self._last: tuple[int, float, float] = (beams, angle_min, angle_increment)
        self._place: NDArray[np.intp] | None = None

    def put(self, ranges: Ranges, angle_min: float, angle_increment: float) -> Ranges:
        """(B,) on the first scan's angles. ValueError where the angles cannot be the same scanner's."""
        noted = (len(ranges), angle_min, angle_increment)
        if noted == (self.beams, self.angle_min, self.angle_increment):
            return ranges
        if noted != self._last or self._place is None:
            self._place, self._last = self._places(*noted), noted
        placed = np.full(self.beams, np.nan, np.float32)
        inside = (self._place >= 0) & (self._place < self.beams)
        order = np.argsort(-np.where(np.isnan(ranges[inside]), np.inf, ranges[inside]), kind="stable")
        placed[self._place[inside][order]] = ranges[inside][order]  # of two on one angle the nearer one
        return placed

    def _places(self, beams: int, angle_min: float, angle_increment: float) -> NDArray[np.intp]:
        if abs(angle_increment - self.angle_increment) > APART * abs(self.angle_increment):
            raise ValueError(
                f"has an increment of {angle_increment:.6g} rad, the first {self.angle_increment:.6g} rad: they are of "
                "two scanners, or one that was set anew"
            )
        angles = angle_min + angle_increment * np.arange(beams)
        turns = 2 * math.pi / self.angle_increment
        place = np.rint((angles - self.angle_min) / self.angle_increment)
        outside = (place < 0) | (place >= self.beams)
        return np.asarray(np.where(outside, np.rint(place % abs(turns)), place), np.intp)


def require_angles(beams: int, angle_min: float, angle_max: float, angle_increment: float) -> None:
    """ValueError, with the numbers, for angles that contradict one another or that no scanner has."""
    noted = f"angle_min {angle_min:.6g}, angle_max {angle_max:.6g}, angle_increment {angle_increment:.6g} rad"
    noted += f", {beams} ranges"
    if not all(map(math.isfinite, (angle_min, angle_max, angle_increment))) or angle_increment == 0:
        raise ValueError(f"{noted}: must be finite, and the increment not 0")
    if not 0 < beams <= MOST_BEAMS:
        raise ValueError(f"{noted}: must be 1 to {MOST_BEAMS}")
    if abs(angle_increment) * (beams - 1) > ALL_ROUND:
        raise ValueError(f"{noted}: sweeps more than a turn; are the angles in degrees?")
    last = angle_min + (beams - 1) * angle_increment
    if abs(angle_max - last) > 1.5 * abs(angle_increment) + 1e-4 * beams * abs(angle_increment):
        raise ValueError(f"{noted}: the last beam is at {last:.6g} rad, so they contradict each other")


def as_rep_117(ranges: Ranges, range_min: float, range_max: float) -> Ranges:
    """Ranges (B,) [m] in the words of REP-117, whatever their driver's are: exactly 0 is no measurement, and so is what
    is finite and below range_min (NaN); from range_max on is nothing there (inf). What hit something stays bit by bit,
    -inf (too close) included."""
    said = np.where(ranges == 0, np.float32(np.nan), ranges)
    lengths, hit = read_beams(said, range_min, range_max)
    return np.where(hit, said, np.where(lengths > 0, np.float32(np.inf), np.float32(np.nan)))
