"""What a driver's stick means: its range, and how fast the vehicle moves with the stick pushed fully.

The same stick is not the same curve on two vehicles: fully ahead and fully left, freiburg-079's robot turns 1.2 rad per
metre, the wheelchair SENA .19. Read by its own limits, SENA's gentle curves become a stick that asks for corners.
`demonstrated` therefore divides the velocities of a log without a recorded joystick by limits that stand in the
demonstrations' proportion: a stick's direction means the curvature that it meant when the model was learned. `own`
divides them by the log's own limits.
"""

from __future__ import annotations

import reprlib
from enum import StrEnum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import joystick_from_motion, motion_limits, windowed_twist
from lfdcore.errors import DataError
from lfdcore.geometry import Twist2

Floats = NDArray[np.float64]
DEAD_ZONE = 0.05
"""A stick displaced less than this is at rest: it says nothing of what its driver wants."""


class Learned(Protocol):
    """A model that says what it was learned from."""

    @property
    def metadata(self) -> dict[str, Any]:
        """JSON values; `full_deflection` [m/s, rad/s]: a pair a demonstration."""


class StickMeaning(StrEnum):
    """By which limits the velocities of a log without a joystick become a stick."""

    demonstrated = "demonstrated"
    own = "own"


def with_stick(log: DriveLog, model: Learned, meaning: StickMeaning = StickMeaning.demonstrated) -> DriveLog:
    """The log with the driver's input; recorded ones are left alone. See the module for what `meaning` decides; a
    model that does not say what full deflection meant leaves `own`."""
    wanted = None if meaning is StickMeaning.own else full_deflection_of(model)
    if wanted is None:
        return joystick_from_motion(log)
    own = motion_limits(windowed_twist(log.odometry_stamp, log.pose))
    scale = max(own.linear / wanted.linear, own.angular / wanted.angular)
    return joystick_from_motion(log, limits=Twist2(scale * wanted.linear, scale * wanted.angular))


def full_deflection_of(model: Learned) -> Twist2 | None:
    """How fast [m/s, rad/s] the demonstrations' vehicle moved with the stick pushed fully (of several demonstrations:
    the geometric mean); None for a model that does not say. DataError for one that says no positive speeds."""
    noted = model.metadata.get("full_deflection", [])
    try:
        said = np.array(noted, float).reshape(-1, 2)
    except (TypeError, ValueError, OverflowError) as error:
        raise DataError(f"the model's full_deflection is {reprlib.repr(noted)}, must be pairs of numbers") from error
    if not len(said):
        return None
    if not (np.isfinite(said).all() and (said > 0).all()):
        raise DataError(f"the model's full_deflection is {said.tolist()} m/s and rad/s, must be positive")
    return Twist2(*np.exp(np.log(said).mean(axis=0)).tolist())


def checked_joystick(joystick: Floats) -> Floats:
    """(2,) forward, left. ValueError unless both are finite and within [-1, 1]."""
    stick = np.asarray(joystick, dtype=np.float64)
    if stick.shape != (2,) or not (np.abs(stick) <= 1 + 1e-6).all():
        raise ValueError(f"joystick is {stick}, must be forward and left between -1 and 1")
    return stick
