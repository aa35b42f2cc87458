"""An ideal drive along a route: no noise, no delay, no inertia. It tells whether the chair fits through a course."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Footprint, Pose2, Twist2, integrate, wrap_angle
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.course import Course

FloatArray = npt.NDArray[np.float64]


class FootprintOnGrid:
    """A rectangular body on a map, as points dense enough that no occupied cell slips between them."""

    def __init__(self, grid: OccupancyGrid, footprint: Footprint) -> None:
        self._occupied = np.pad(grid.occupied_mask(), 1)
        self._origin = np.array(grid.origin)
        self._resolution = grid.resolution
        # a cell holds a disc as wide as itself, and a square lattice of .7 of that has a point in every such disc
        step = 0.7 * grid.resolution
        across = np.linspace(-footprint.half_width, footprint.half_width, _count(2 * footprint.half_width, step))
        along = np.linspace(-footprint.rear, footprint.front, _count(footprint.front + footprint.rear, step))
        self._points = np.stack(np.meshgrid(along, across), axis=-1).reshape(-1, 2)

    def touches(self, poses: FloatArray) -> npt.NDArray[np.bool_]:
        """(N,) bool: whether the body at each pose (N, 3) [x, y, yaw in the map] overlaps an occupied cell."""
        chunks = [self._touches(part) for part in np.array_split(poses, max(1, len(poses) // 500))]
        return np.concatenate(chunks)

    def _touches(self, poses: FloatArray) -> npt.NDArray[np.bool_]:
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x = poses[:, :1] + c * self._points[:, 0] - s * self._points[:, 1] - self._origin[0]
        y = poses[:, 1:2] + s * self._points[:, 0] + c * self._points[:, 1] - self._origin[1]
        height, width = self._occupied.shape
        ix = np.clip(np.floor(x / self._resolution).astype(np.int64) + 1, 0, width - 1)
        iy = np.clip(np.floor(y / self._resolution).astype(np.int64) + 1, 0, height - 1)
        return np.asarray(self._occupied[iy, ix].any(axis=1))


def _count(length: float, step: float) -> int:
    return max(2, int(np.ceil(length / step)) + 1)


@dataclass(frozen=True, eq=False)
class IdealDrive:
    """poses (T, 3) [m, rad, map], .05 m or .05 rad apart; completed: the end was reached; contacts (T,) bool."""

    poses: FloatArray
    completed: bool
    contacts: npt.NDArray[np.bool_]


def drive_ideally(
    course: Course, footprint: Footprint | None = None, margin: float = 0.0, look_ahead: float = 0.3
) -> IdealDrive:
    """Follows a course's route exactly as pure pursuit says, turning in place where the way leads elsewhere.

    margin [m] grows the footprint for the check of contacts.
    """
    follower = _Follower(course.route, look_ahead)
    pose, poses = course.start, [[*course.start]]
    budget = int(4 * course.length / _STEP) + 400
    while not follower.finished and len(poses) < budget:
        pose = integrate(pose, follower.twist(pose), _STEP)
        poses.append([*pose])
    body = FootprintOnGrid(course.grid, (footprint or Footprint()).grown(margin))
    driven = np.array(poses)
    return IdealDrive(driven, follower.finished, body.touches(driven))


_STEP = 0.05
"""A tick's length: [m] at unit speed."""


class _Follower:
    def __init__(self, route: FloatArray, look_ahead: float) -> None:
        self._route = route
        self._look_ahead = look_ahead
        self._at = 0
        self._ahead = max(1, round(look_ahead / float(np.hypot(*(route[1] - route[0])))))

    @property
    def finished(self) -> bool:
        return self._at >= len(self._route) - 1 - self._ahead // 2

    def twist(self, pose: Pose2) -> Twist2:
        here = np.array([pose.x, pose.y])
        window = self._route[self._at : self._at + 2 * self._ahead + 5]
        self._at += int(np.argmin(np.hypot(*(window - here).T)))
        target = self._route[min(self._at + self._ahead, len(self._route) - 1)] - here
        bearing = float(wrap_angle(np.arctan2(target[1], target[0]) - pose.yaw))
        if abs(bearing) > 0.9:
            return Twist2(0.0, float(np.copysign(1.0, bearing)))
        return Twist2(1.0, 2 * np.sin(bearing) / max(float(np.hypot(*target)), 0.1))
