"""What a simulated run leaves for metrics and pictures: the true motion, the inputs, what the assistant thought."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint


@dataclass(frozen=True)
class Plan:
    """A path as the assistant made it."""

    stamp: float
    """[s]"""
    path: NDArray[np.float64]
    """(N, 2) [m] in map"""


@dataclass(frozen=True)
class DriveTrace:
    """One run at a fixed period, without its scans (the drive log has those). T ticks, frame map, by ground truth."""

    course: str
    driver: str
    assistant: str
    seed: int
    outcome: str
    """'completed', 'time_out' or 'stuck'"""
    footprint: Footprint
    stamp: NDArray[np.float64]
    """(T,) [s]"""
    pose: NDArray[np.float64]
    """(T, 3) x, y [m], yaw [rad]"""
    twist: NDArray[np.float64]
    """(T, 2) [m/s, rad/s]"""
    joystick: NDArray[np.float64]
    """(T, 2) forward, left as given"""
    desired: NDArray[np.float64]
    """(T, 2) forward, left as meant, before the disability"""
    command: NDArray[np.float64]
    """(T, 2) [m/s, rad/s] sent to the chair"""
    in_contact: NDArray[np.bool_]
    """(T,)"""
    collision: NDArray[np.bool_]
    """(T,) true where a contact begins"""
    mode: NDArray[np.str_]
    """(T,) who decided (Assistance.mode)"""
    supervised: NDArray[np.bool_]
    """(T,) where the supervisor changed the command"""
    compliance: NDArray[np.float64]
    """(T,) in [0, 1]; NaN without a path"""
    goal: NDArray[np.float64]
    """(T, 2) [m] the inferred intention; NaN without one"""
    control_point: NDArray[np.float64]
    """(T, 2) [m] of pure pursuit or DWA; NaN without one"""
    plans: tuple[Plan, ...] = ()

    @property
    def completed(self) -> bool:
        """True if the driver reached the end of the course."""
        return self.outcome == "completed"

    @property
    def period(self) -> float:
        """Time between ticks [s]."""
        return float(self.stamp[1] - self.stamp[0]) if len(self.stamp) > 1 else 0.0

    @property
    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        arrays = [value for value in vars(self).values() if isinstance(value, np.ndarray)]
        return sum(a.nbytes for a in arrays) + sum(plan.path.nbytes for plan in self.plans)
