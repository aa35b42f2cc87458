"""Runs a joint trajectory on a robot: targets at a fixed rate, a kinematic robot that lags, an abort that holds."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.joint_motion import JointMotion

Array = NDArray[np.float64]
RATE = 100.0
"""[Hz] of targets"""
START_TOLERANCE = 0.05
"""[rad or m] within which a robot must be where a motion begins"""
FASTEST = 10_000.0
"""[Hz] of targets at most"""
_SLACK = 1e-9


class Robot(Protocol):
    """What takes targets: a real arm's driver, or KinematicRobot."""

    @property
    def positions(self) -> Array:
        """(N,) [rad or m] where its joints are."""

    def command(self, targets: Array, duration: float) -> None:
        """Go to targets (N,) for the next `duration` [s]."""


class KinematicRobot:
    """Joints that go to their targets at once, but no faster than their velocity limits and not beyond their position
    limits: a target outside is refused, not clipped. Without dynamics."""

    def __init__(self, positions: ArrayLike, limits: ArrayLike, names: Sequence[str]) -> None:
        """positions (N,), limits (N, 3): lower, upper [rad or m], velocity [rad/s or m/s] as RobotModel.limits.
        ValueError for other shapes, a velocity limit that is not >= 0 and a position outside."""
        self._positions = np.array(positions, np.float64)
        self._limits, self._names = np.array(limits, np.float64), tuple(names)
        if self._positions.shape != (len(self._names),) or self._limits.shape != (len(self._names), 3):
            shapes = f"{self._positions.shape} and {self._limits.shape}"
            raise ValueError(f"positions and limits of {len(self._names)} joints have shapes {shapes}")
        if not (self._limits[:, 2] >= 0).all():
            raise ValueError(f"velocity limits are {self._limits[:, 2].tolist()}, must be >= 0 rad/s or m/s")
        self._require_inside(self._positions)

    @property
    def positions(self) -> Array:
        """(N,) [rad or m]"""
        return self._positions.copy()

    def command(self, targets: Array, duration: float) -> None:
        """Moves for `duration` [s]. ValueError, and it stays, for targets that are not finite or outside the limits and
        a duration that is not finite and >= 0."""
        if not 0 <= duration < np.inf:
            raise ValueError(f"duration is {duration} s, must be finite and >= 0")
        wanted = np.asarray(targets, np.float64)
        self._require_inside(wanted)
        farthest = self._limits[:, 2] * duration
        self._positions += np.clip(wanted - self._positions, -farthest, farthest)

    def _require_inside(self, wanted: Array) -> None:
        if wanted.shape != self._positions.shape:
            raise ValueError(f"targets have shape {wanted.shape}, must be {self._positions.shape}")
        inside = (wanted >= self._limits[:, 0] - _SLACK) & (wanted <= self._limits[:, 1] + _SLACK)
        if not inside.all():
            k = int(np.argmin(inside))
            low, high = self._limits[k, :2].tolist()
            raise ValueError(f"{self._names[k]} is to go to {wanted[k]:g}, must be in [{low:g}, {high:g}] rad or m")


@dataclass(frozen=True)
class Executed:
    """One tick of an execution."""

    time: float
    """[s] since it was begun"""
    target: Array
    """(N,)"""
    positions: Array
    """(N,) afterwards"""


@dataclass(frozen=True, eq=False)
class Execution:
    """What became of a trajectory."""

    names: tuple[str, ...]
    ticks: tuple[Executed, ...] = field(repr=False)
    aborted: bool
    """then the last target is where the robot was when it was stopped"""

    @property
    def errors(self) -> Array:
        """(ticks, N) |target - positions| [rad or m]"""
        return np.array([np.abs(tick.target - tick.positions) for tick in self.ticks]).reshape(-1, len(self.names))

    @property
    def rms_error(self) -> float:
        """over ticks and joints [rad or m]"""
        return float(np.sqrt(np.mean(self.errors**2))) if len(self.ticks) else 0.0

    @property
    def largest_error(self) -> tuple[float, str]:
        """[rad or m], and the joint's name"""
        if not len(self.ticks):
            return 0.0, self.names[0]
        _, joint = np.unravel_index(int(self.errors.argmax()), self.errors.shape)
        return float(self.errors.max()), self.names[int(joint)]


def stream(
    motion: JointMotion, robot: Robot, stop: Callable[[float], bool] | None = None, rate: float = RATE
) -> Iterator[Executed]:
    """Commands a target every 1 / rate [s] until the motion's end, yielding each tick as it is done. The caller's
    iteration sets the pace. `stop` is asked before each tick, with the time [s]. If it says yes, that aborts: the robot
    is commanded to stay where it is.

    ValueError for a rate that is not > 0 and <= FASTEST, and, before anything moves, for a robot that is not where the
    motion begins (within START_TOLERANCE).
    """
    if not 0 < rate <= FASTEST:
        raise ValueError(f"rate is {rate} Hz, must be > 0 and <= {FASTEST:g} Hz")
    _require_at_start(motion, robot)
    period = 1 / rate
    for tick in range(1, int(np.ceil(motion.duration * rate - 1e-9)) + 1):
        now = min(tick * period, motion.duration)
        if stop is not None and stop(now):
            held = robot.positions
            robot.command(held, period)
            yield Executed(now, held, robot.positions)
            return
        target = motion.at(float(motion.time[0]) + now)
        robot.command(target, period)
        yield Executed(now, target, robot.positions)


def execute(
    motion: JointMotion, robot: Robot, stop: Callable[[float], bool] | None = None, rate: float = RATE
) -> Execution:
    """All ticks of `stream`, as fast as the robot takes them."""
    aborted = False

    def asked(time: float) -> bool:
        nonlocal aborted
        aborted = stop is not None and stop(time)
        return aborted

    ticks = tuple(stream(motion, robot, asked, rate))
    return Execution(motion.names, ticks, aborted)


def in_real_time(motion: JointMotion, robot: Robot, progress: Callable[[float], None], rate: float = RATE) -> Execution:
    """As execute, each tick at its time; `progress` is called with the time [s] of each. Ctrl-C (SIGINT) aborts at
    once, without waiting for a tick. Only in a program's main thread, which alone may listen to signals."""
    interrupted = threading.Event()
    before = signal.signal(signal.SIGINT, lambda number, frame: interrupted.set())
    begin = monotonic()

    def stop(time: float) -> bool:
        progress(time)
        return interrupted.wait(max(0.0, begin + time - monotonic()))

    try:
        return execute(motion, robot, stop, rate)
    finally:
        signal.signal(signal.SIGINT, before)


def _require_at_start(motion: JointMotion, robot: Robot) -> None:
    if robot.positions.shape != motion.positions[0].shape:
        raise ValueError(f"the robot has {len(robot.positions)} joints, the motion {len(motion.names)}")
    off = np.abs(robot.positions - motion.positions[0])
    if off.max() > START_TOLERANCE:
        k = int(off.argmax())
        raise ValueError(
            f"{motion.names[k]} is at {robot.positions[k]:.3f}, the motion begins at {motion.positions[0, k]:.3f}: "
            f"they must be within {START_TOLERANCE} rad or m"
        )
