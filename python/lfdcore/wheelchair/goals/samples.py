"""What a driver's action is learned from (Sec. 2.2-2.3): pose in the map, velocities, joystick and destination."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.datasets.goals import Goals

Floats = NDArray[np.float64]
Heading = Literal["embedded", "raw"]
"""How a yaw enters: as its cosine and sine (F3) or, as printed, as a number that jumps at +-pi (ERRATA 10)."""


@dataclass(frozen=True)
class GoalSamples:
    """N moments of drives to destinations."""

    pose: Floats
    """(N, 3) x, y [m], yaw [rad] in the map"""
    twist: Floats
    """(N, 2) [m/s, rad/s]"""
    joystick: Floats
    """(N, 2) forward, left in [-1, 1]"""
    goal: NDArray[np.int64]
    """(N,) which destination the drive went to"""
    drive: NDArray[np.int64]
    """(N,) which drive it was"""
    stamp: Floats
    """(N,) [s] since the drive began"""

    def __post_init__(self) -> None:
        n = len(self.stamp)
        for name, width in (("pose", 3), ("twist", 2), ("joystick", 2)):
            values = getattr(self, name)
            if values.shape != (n, width) or not np.isfinite(values).all():
                raise ValueError(f"{name} must be finite and ({n}, {width}), is {values.shape}")
        if self.stamp.shape != (n,) or not np.isfinite(self.stamp).all():
            raise ValueError(f"stamp must be finite and ({n},), is {self.stamp.shape}")
        if n and np.abs(self.joystick).max() > 1:
            raise ValueError(f"joystick is up to {np.abs(self.joystick).max():g}, must lie in [-1, 1]")
        if self.goal.shape != (n,) or self.drive.shape != (n,):
            raise ValueError(f"goal and drive must be ({n},), are {self.goal.shape} and {self.drive.shape}")
        if not all(np.issubdtype(array.dtype, np.integer) for array in (self.goal, self.drive)):
            raise ValueError(f"goal and drive must be integers, are {self.goal.dtype} and {self.drive.dtype}")

    def __len__(self) -> int:
        return len(self.stamp)

    def where(self, mask: NDArray[np.bool_] | NDArray[np.int64]) -> GoalSamples:
        """The samples chosen by a mask (N,) or by indices."""
        return GoalSamples(*(getattr(self, name)[mask] for name in self.__dataclass_fields__))

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """By name, as in a file."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def goal_state(pose: Floats, twist: Floats, heading: Heading) -> Floats:
    """Poses (N, 3) and velocities (N, 2) -> states x (N, 6), or (N, 5) with a raw heading (Sec. 2.3.1)."""
    return np.column_stack([pose_features(pose, heading), twist])


def pose_features(pose: Floats, heading: Heading) -> Floats:
    """Poses (N, 3) -> x, y, cos yaw, sin yaw (N, 4) or, raw, the poses themselves."""
    if heading == "raw":
        return np.asarray(pose)
    return np.column_stack([pose[:, :2], np.cos(pose[:, 2]), np.sin(pose[:, 2])])


def drive_samples(log: DriveLog, goal: int = -1, drive: int = 0) -> GoalSamples:
    """A drive at its odometry's moments from the first stick on. ValueError without joystick or pose in the map, or
    without odometry from then on."""
    if not len(log.joystick_stamp):
        raise ValueError(f"log {log.name!r} has no joystick, which is what destinations are inferred from")
    stamp = log.odometry_stamp[log.odometry_stamp >= log.joystick_stamp[0]]
    if not len(stamp):
        raise ValueError(f"log {log.name!r} has no odometry once its joystick begins")
    return GoalSamples(
        log.map_pose_at(stamp),
        log.twist_at(stamp),
        log.joystick_at(stamp),
        np.full(len(stamp), goal),
        np.full(len(stamp), drive),
        stamp - stamp[0],
    )


def goal_samples(logs: Sequence[DriveLog], goals: Goals) -> GoalSamples:
    """Of all drives, each to the destination that its metadata names. ValueError for a name that is none of them, or
    without any drive."""
    if not logs:
        raise ValueError("there is no drive to learn destinations from")
    parts = [drive_samples(log, goals.index(destination_of(log)), k) for k, log in enumerate(logs)]
    joined = {name: np.concatenate([getattr(p, name) for p in parts]) for name in GoalSamples.__dataclass_fields__}
    return GoalSamples(**joined)


def destination_of(log: DriveLog) -> str:
    """The destination that a log names in its metadata. ValueError without one."""
    name = log.metadata.get("destination")
    if name is None:
        raise ValueError(f"log {log.name!r} does not say its destination (metadata 'destination')")
    return name
