"""The drive loop: observe -> assist -> command -> record, tick by tick, for any chair.

The loop owns the clock and the stamps: it gives a chair and an assistant the time, and neither asks for it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from lfdcore.geometry import Twist2
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLogWriter
    from lfdcore.wheelchair.assistants import Assistant


TOLERANCE = 1e-6
"""[s] A tick this much early counts for the one after."""
LONGEST_PERIOD = 1.0
"""[s] A chair whose driver is not listened to for longer is not driven."""
LAST_STAMP = 2.0**31
"""[s] A drive log's stamps end here."""


class Chair(Protocol):
    """What is driven, with its sensors and its driver's stick: a simulated chair, or a real one's link."""

    @property
    def geometry(self) -> ChairGeometry:
        """What its assistant must know of it."""

    def observe(self, stamp: float) -> Observation:
        """What sensors and stick say at `stamp` [s], the loop's time, each with the stamp at which it said so."""

    def command(self, twist: Twist2, duration: float) -> None:
        """Drive `twist` [m/s, rad/s] until another command comes, for `duration` [s] at the longest; then brake to a
        standstill, whatever became of the loop."""

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
    clock: Clock | None = None,
    log: DriveLogWriter | None = None,
) -> None:
    """Resets the assistant, then lets it drive: a tick every period of its chair, recorded in `log`, until `until` says
    of one that it was the last. It is asked when the tick's command was given and its records were written.

    A tick that is late is one tick, with the time that it is; those missed meanwhile are left out, not made up for. A
    command holds for the chair's period + jitter, after which the chair brakes. What a late tick's assistant does is
    said in its WatchConfig.

    clock: a WallClock unless given. However the drive ends (also by an exception or Ctrl-C), the chair is stopped.
    ValueError, before anything moves, for an assistant made for another chair, or for this one at another period, and
    for a period of more than 1 s; for a command that is not finite, which the chair is never given, and
    for a clock that says no finite time.
    """
    assistant.chair.require_fit(chair.geometry)
    period, holds = chair.geometry.period, chair.geometry.period + chair.geometry.jitter
    if period > LONGEST_PERIOD:
        raise ValueError(f"period is {period} s, must be at most {LONGEST_PERIOD} s to drive a chair")
    clock = clock or WallClock()
    recorder = None if log is None else _Recorder(log)
    number = 0
    try:
        assistant.reset()
        while True:
            stamp = clock.wait_until(number * period)
            if not math.isfinite(stamp):
                raise ValueError(f"the clock says {stamp} s, must be finite")
            observation = chair.observe(stamp)
            assistance = assistant.update(observation)
            _require_finite(assistance.command)
            chair.command(assistance.command, holds)
            if recorder is not None:
                recorder.record(observation, assistance)
            if until(Tick(stamp, observation, assistance)):
                return
            number = max(number + 1, math.floor((stamp + TOLERANCE) / period) + 1)
    finally:
        chair.stop()


def _require_finite(command: Twist2) -> None:
    if not (math.isfinite(command.linear) and math.isfinite(command.angular)):
        raise ValueError(f"the assistant commands {command.linear} m/s and {command.angular} rad/s, must be finite")


class _Recorder:
    """Writes what a chair's drive log holds of each tick (docs/drive-log.md): of every stream what is new, at its own
    stamp. What has no stamp, repeats one, goes back or is not finite is not written, nor a scan without beams: the
    log's streams are sound."""

    def __init__(self, log: DriveLogWriter) -> None:
        self._log = log
        self._newest: dict[str, float] = {}

    def record(self, seen: Observation, answer: Assistance) -> None:
        if self._is_new("odometry", seen.odometry_stamp, *seen.pose, *seen.twist):
            self._log.odometry(self._newest["odometry"], seen.pose, seen.twist)
        if len(seen.scan.ranges) and self._is_new("scan", seen.scan_stamp):
            self._log.scan(self._newest["scan"], seen.scan)
        if self._is_new("joystick", seen.joystick_stamp, *seen.joystick):
            self._log.joystick(self._newest["joystick"], *seen.joystick)
        if not self._is_new("command", seen.stamp):
            return
        self._log.command(seen.stamp, answer.command)
        if answer.planned and answer.path is not None:
            self._log.plan(seen.stamp, answer.path)
        if answer.planned and answer.goal is not None:
            self._log.intention(seen.stamp, answer.goal, answer.likelihood)

    def _is_new(self, stream: str, stamp: float | None, *values: float) -> bool:
        if stamp is None or not all(map(math.isfinite, (stamp, *values))):
            return False
        if not 0 <= stamp < LAST_STAMP or stamp <= self._newest.get(stream, -math.inf):
            return False
        self._newest[stream] = stamp
        return True
