"""What a simulated driver knows: how far along the route it is, and what it sees late."""

from __future__ import annotations

from collections import deque

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Footprint, Pose2, Twist2, arc_length, integrate
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.ideal import FootprintOnGrid

FloatArray = npt.NDArray[np.float64]


class RouteTracker:
    """Where along a route a driver is: the nearest point near where it was, so a driver pushed aside returns.

    The search looks `window` [m] ahead and, since a chair that has reversed lines up again, `behind` [m] back.
    """

    def __init__(self, course: Course, window: float = 2.0, behind: float = 1.0) -> None:
        self._route = course.route
        self._arc = np.asarray(arc_length(course.route))
        self._loop = course.loop
        self._window, self._behind = window, behind
        self.reset()

    def reset(self) -> None:
        """Back to the route's start."""
        self._at = 0
        self._farthest = 0

    def advance(self, x: float, y: float) -> None:
        """Takes the point nearest to (x, y) [m] within the window; of equals the one ahead."""
        here = self._arc[self._at]
        first, last = np.searchsorted(self._arc, [here - self._behind, here + self._window])
        near = self._route[first : last + 1]
        away = np.hypot(near[:, 0] - x, near[:, 1] - y)
        away[: self._at - first] += 1e-6
        self._at = int(first + np.argmin(away))
        self._farthest = max(self._farthest, self._at)

    @property
    def travelled(self) -> float:
        """Arc length [m] of the farthest point taken so far."""
        return float(self._arc[self._farthest])

    @property
    def length(self) -> float:
        """Arc length [m] of the whole route."""
        return float(self._arc[-1])

    @property
    def remaining(self) -> float:
        """Arc length [m] from the farthest point taken to the end."""
        return self.length - self.travelled

    def point(self, ahead: float) -> FloatArray:
        """The route's point (2,) `ahead` [m] of the one taken last; of a loop it goes on into the next lap."""
        at = float(self._arc[self._at]) + ahead
        at = at % self.length if self._loop else min(at, self.length)
        return np.array([np.interp(at, self._arc, self._route[:, 0]), np.interp(at, self._arc, self._route[:, 1])])


class DelayedView:
    """Poses seen `delay` [s] late."""

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._seen: deque[tuple[float, Pose2]] = deque()

    def see(self, stamp: float, pose: Pose2) -> Pose2:
        """The newest pose that is at least `delay` old, or the oldest known."""
        self._seen.append((stamp, pose))
        while len(self._seen) > 1 and self._seen[1][0] <= stamp - self._delay + 1e-9:
            self._seen.popleft()
        return self._seen[0][1]


class MapSense:
    """What a driver can tell from the room: whether a view is open and whether a movement would hit."""

    def __init__(self, grid: OccupancyGrid, footprint: Footprint) -> None:
        self._grid = grid
        self._occupied = np.pad(grid.occupied_mask(), 1)
        self._body = FootprintOnGrid(grid, footprint)

    def sees(self, x: float, y: float, target: FloatArray) -> bool:
        """Whether the straight line from (x, y) to a target (2,) [m] crosses no occupied cell."""
        count = 2 + int(np.hypot(target[0] - x, target[1] - y) / (0.5 * self._grid.resolution))
        line = np.linspace((x, y), target, count)
        cells = np.floor((line - np.array(self._grid.origin)) / self._grid.resolution).astype(np.int64) + 1
        height, width = self._occupied.shape
        ix, iy = np.clip(cells[:, 0], 0, width - 1), np.clip(cells[:, 1], 0, height - 1)
        return not self._occupied[iy, ix].any()

    def time_to_hit(self, pose: Pose2, twist: Twist2, horizon: float, step: float = 0.1) -> float:
        """Time [s] until a body that follows a twist touches an occupied cell; inf beyond the horizon."""
        times = np.arange(step, horizon + 1e-9, step)
        poses = np.array([[*integrate(pose, twist, float(t))] for t in times])
        hits = np.nonzero(self._body.touches(poses))[0]
        return float(times[hits[0]]) if len(hits) else float("inf")


class AutoregressiveNoise:
    """Stationary AR(1) noise, one sample a tick: sample k depends on the generator's seed and k only."""

    def __init__(self, sd: float, correlation: float, rng: np.random.Generator) -> None:
        self._sd, self._correlation, self._rng = sd, correlation, rng
        self._value = sd * rng.standard_normal()

    def next(self) -> float:
        """The next sample; its sd is `sd` and its correlation with the one before `correlation`."""
        now = self._value
        fresh = self._sd * np.sqrt(1 - self._correlation**2) * self._rng.standard_normal()
        self._value = self._correlation * now + fresh
        return float(now)
