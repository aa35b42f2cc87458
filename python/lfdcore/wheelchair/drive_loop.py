"""The drive loop: observe -> assist -> command -> record, tick by tick, for any chair.

The loop owns the clock and the stamps: it gives a chair and an assistant the time, and neither asks for it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING, Protocol

from lfdcore.geometry import Twist2
from lfdcore.wheelchair.observation import PERIOD, Assistance, Observation

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLogWriter
    from lfdcore.wheelchair.assistants import Assistant


class Chair(Protocol):
    """What is driven, with its sensors and its driver's stick: a simulated chair, or a real one's link."""

    def observe(self, stamp: float) -> Observation:
        """What sensors and stick say at `stamp` [s], the loop's time."""

    def command(self, twist: Twist2, duration: float) -> None:
        """Drive `twist` [m/s, rad/s] for the next `duration` [s], until another command comes."""

    def stop(self) -> None:
        """Stand still: the loop has ended, for whatever reason."""


class Clock(Protocol):
    """The time of a drive [s], 0 when it begins."""

    def wait_until(self, due: float) -> float:
        """Returns at `due` [s], or at once where that has passed -> the time then [s]."""


class SimulatedClock:
    """Time passes as fast as the ticks do."""

    def wait_until(self, due: float) -> float:
        """-> `due` [s], at once."""
        return due


class WallClock:
    """Time passes as it does for people. It begins when the clock is made."""

    def __init__(self) -> None:
        self._begin = time.monotonic()

    def wait_until(self, due: float) -> float:
        """Sleeps until `due` [s] after the beginning -> the time then [s]."""
        time.sleep(max(0.0, self._begin + due - time.monotonic()))
        return time.monotonic() - self._begin


@dataclass(frozen=True)
class Tick:
    """One turn of the loop; the command of `assistance` was given to the chair."""

    stamp: float
    """[s] since the drive began"""
    observation: Observation
    assistance: Assistance


def drive(
    chair: Chair,
    assistant: Assistant,
    until: Callable[[Tick], bool],
    *,
    period: float = PERIOD,
    clock: Clock | None = None,
    log: DriveLogWriter | None = None,
) -> None:
    """Resets the assistant, then lets it drive: a tick every `period` [s], recorded in `log`, until `until` says of one
    that it was the last. It is asked when the tick's command was given and its records were written.

    clock: a WallClock unless given. However the drive ends (also by an exception or Ctrl-C), the chair is stopped.
    ValueError, before anything moves, for a period that is not finite and > 0; for a command that is not finite, which
    the chair is never given.
    """
    if not 0 < period < math.inf:
        raise ValueError(f"period is {period} s, must be finite and > 0")
    clock = clock or WallClock()
    try:
        assistant.reset()
        scan_stamp = -math.inf
        for number in count():
            stamp = clock.wait_until(number * period)
            observation = chair.observe(stamp)
            assistance = assistant.update(observation)
            _require_finite(assistance.command)
            chair.command(assistance.command, period)
            if log is not None:
                record(log, observation, assistance, with_scan=observation.scan_stamp > scan_stamp)
                scan_stamp = observation.scan_stamp
            if until(Tick(stamp, observation, assistance)):
                return
    finally:
        chair.stop()


def _require_finite(command: Twist2) -> None:
    if not (math.isfinite(command.linear) and math.isfinite(command.angular)):
        raise ValueError(f"the assistant commands {command.linear} m/s and {command.angular} rad/s, must be finite")


def record(log: DriveLogWriter, seen: Observation, answer: Assistance, *, with_scan: bool = True) -> None:
    """Writes what a chair's drive log holds of one tick (docs/drive-log.md). with_scan: False for a scan that an
    earlier tick saw, and wrote, already."""
    log.odometry(seen.stamp, seen.pose, seen.twist)
    if with_scan:
        log.scan(seen.scan_stamp, seen.scan)
    log.joystick(seen.stamp, *seen.joystick)
    log.command(seen.stamp, answer.command)
    if answer.planned and answer.path is not None:
        log.plan(seen.stamp, answer.path)
    if answer.planned and answer.goal is not None:
        log.intention(seen.stamp, answer.goal, answer.likelihood)
