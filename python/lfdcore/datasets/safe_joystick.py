"""The "safe" joystick of Sec. 4.2: the stick that would have asked for the chair's command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.errors import DataError
from lfdcore.geometry import MotionLimits

Array = NDArray[np.float64]

_LIMITS = "full_stick"
_ROUNDING = 1e-6
"""by which float32 sticks and sums of samples overshoot full stick"""


@dataclass(frozen=True, eq=False)
class JoystickPairs:
    """What the driver gave and what came of it, N commands of a log."""

    stamp: Array
    """(N,) [s] of the commands"""
    raw: Array
    """(N, 2) (forward, left) as last given when the command went out"""
    safe: Array
    """(N, 2) (forward, left) that asks for the command"""


def twist_to_joystick(twist: ArrayLike, limits: MotionLimits) -> Array:
    """The stick (..., 2) [forward, left] that asks for twists (..., 2) [m/s, rad/s]: joystick_to_twist's inverse.

    ValueError for another shape, a twist that is not finite, and one beyond the limits, which no stick asks for.
    """
    wanted = np.asarray(twist, float)
    if wanted.ndim < 1 or wanted.shape[-1] != 2:
        raise ValueError(f"twist has shape {wanted.shape}, must be (..., 2)")
    if not np.isfinite(wanted).all():
        raise ValueError("twist must be finite")
    top = np.where(wanted[..., 0] < 0, limits.max_reverse, limits.max_linear)
    stick = np.stack([wanted[..., 0] / top, wanted[..., 1] / limits.max_angular], axis=-1)
    if (np.abs(stick) > 1 + _ROUNDING).any():
        worst = wanted.reshape(-1, 2)[np.abs(stick).reshape(-1, 2).max(axis=1).argmax()]
        raise ValueError(
            f"twist is {worst[0]} m/s, {worst[1]} rad/s, must lie within -{limits.max_reverse}..{limits.max_linear} "
            f"m/s and +-{limits.max_angular} rad/s"
        )
    return np.clip(stick, -1, 1)


def limits_note(limits: MotionLimits) -> dict[str, str]:
    """What full stick means, as metadata of a drive log."""
    return {_LIMITS: f"{limits.max_linear!r} {limits.max_reverse!r} {limits.max_angular!r}"}


def notes_limits(log: DriveLog) -> bool:
    """Whether the log says what full stick meant."""
    return _LIMITS in log.metadata


def noted_limits(log: DriveLog) -> MotionLimits:
    """What full stick meant when the log was recorded (its accelerations are not noted).

    ValueError for a log that does not say it, DataError for one that says no three speeds.
    """
    if not notes_limits(log):
        raise ValueError(f"log {log.name!r} does not say what full stick means, give its limits")
    text = log.metadata[_LIMITS]
    try:
        linear, reverse, angular = map(float, text.split())
    except ValueError:
        raise DataError(f"{_LIMITS} of log {log.name!r} is {text!r}, must be three speeds") from None
    if not (np.isfinite([linear, reverse, angular]).all() and min(linear, reverse, angular) > 0):
        raise DataError(f"{_LIMITS} of log {log.name!r} is {text!r}, must be positive and finite")
    return MotionLimits(max_linear=linear, max_reverse=reverse, max_angular=angular)


def safe_joystick(log: DriveLog, limits: MotionLimits | None = None) -> Array:
    """The stick (D, 2) [forward, left] that asks for the log's commands, at its command_stamp.

    limits: of the chair that drove; None: as the log notes them. ValueError where it does not, and for commands beyond
    the limits.
    """
    return twist_to_joystick(log.command, limits or noted_limits(log))


def joystick_pairs(log: DriveLog, limits: MotionLimits | None = None) -> JoystickPairs:
    """Raw and safe joystick side by side (Sec. 4.2), from the first joystick record on; limits as in safe_joystick.

    ValueError for a log without joystick or without commands.
    """
    for name in ("joystick", "command"):
        if not len(getattr(log, f"{name}_stamp")):
            raise ValueError(f"log {log.name!r} has no {name}, so no pairs of raw and safe input")
    known = log.command_stamp >= log.joystick_stamp[0]
    stamp = log.command_stamp[known]
    return JoystickPairs(stamp, log.joystick_at(stamp), safe_joystick(log, limits)[known])
