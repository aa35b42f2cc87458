"""Runs: a driver in a course with an assistant, tick by tick.

The noise of tick k in the scans, the slip and the driver depends on the seed and on k only, so that every assistant
meets the same.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lfdcore.datasets.drive_log import DriveLogWriter
from lfdcore.datasets.safe_joystick import limits_note
from lfdcore.simulated.chair import ScannerFaults, SimulatedChair, Truth, geometry_of
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import Driver
from lfdcore.simulated.people import People, PeopleConfig
from lfdcore.simulated.trace import DriveTrace, TraceRecorder
from lfdcore.simulation import ChairConfig, LidarConfig
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.drive_loop import SimulatedClock, Tick, drive
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """How a run is simulated."""

    chair: ChairConfig = field(default_factory=ChairConfig)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    scanner: ScannerFaults = field(default_factory=ScannerFaults)
    period: float = PERIOD
    """[s] between two commands; a tick each"""
    slowest: float = 0.12
    """Mean speed along the route [m/s] below which a run times out."""
    stuck_after: float = 60.0
    """Time without .5 m of progress [s] after which a run counts as stuck."""
    stuck_progress: float = 0.5
    """[m]"""
    people: PeopleConfig | None = None
    """who walks in the course, from the run's seed; None: nobody"""

    @property
    def geometry(self) -> ChairGeometry:
        """What an assistant knows of this chair."""
        return geometry_of(self.chair, self.lidar, self.scanner, self.period)


class _Progress:
    """Tells a driver that no longer gets on."""

    def __init__(self, config: RunConfig, length: float) -> None:
        self.config = config
        self.limit = length / config.slowest
        self.length = length
        self.best = 0.0
        self.since = 0.0

    def outcome(self, stamp: float, driver: Driver) -> str | None:
        if driver.done:
            return "completed"
        travelled = driver.progress * self.length
        if travelled > self.best + self.config.stuck_progress:
            self.best, self.since = travelled, stamp
        if stamp - self.since > self.config.stuck_after:
            return "stuck"
        return "time_out" if stamp > self.limit else None


def run_drive(
    course: Course,
    driver: Driver,
    assistant: Assistant,
    seed: int,
    config: RunConfig | None = None,
    log_path: Path | None = None,
    destination: str | None = None,
) -> DriveTrace:
    """Lets `driver` drive `course` with `assistant` until it arrives, is stuck or runs out of time.

    With `log_path` the run is recorded as a drive log (what a real chair would have recorded, docs/drive-log.md). With
    `destination` the log says so in its metadata and holds the true pose in the map, as a localiser would.
    """
    config = config or RunConfig()
    start = (course.start.x, course.start.y)
    people = None if config.people is None else People(course.grid, config.people, start, seed)
    chair = SimulatedChair(course, driver, seed, config.chair, config.lidar, people, config.scanner, config.period)
    recorder, progress, outcome = TraceRecorder(course.start), _Progress(config, course.length), None
    about = {"driver": driver.name, "assistant": assistant.name, "seed": str(seed)}
    about |= {} if destination is None else {"destination": destination}

    with ExitStack() as stack:
        log = None if log_path is None else stack.enter_context(_opened(log_path, course, config, about))

        def ended(tick: Tick) -> bool:
            nonlocal outcome
            recorder.add(tick, chair.truth)
            if log is not None:
                _record_truth(log, tick, chair.truth, in_map=destination is not None)
            outcome = progress.outcome(tick.stamp, driver)
            chair.show(tick.assistance.mode, tick.stamp)
            return outcome is not None

        drive(chair, assistant, ended, clock=SimulatedClock(), log=log)
    names = (course.name, driver.name, assistant.name)
    footprint, met = config.chair.footprint, chair.people_met()
    return recorder.trace(*names, seed=seed, outcome=str(outcome), footprint=footprint, people_met=met)


def _opened(path: Path, course: Course, config: RunConfig, about: dict[str, str]) -> DriveLogWriter:
    about = about | limits_note(config.chair.limits) | place_note(course)
    return DriveLogWriter(path, name=course.name, T_base_laser=config.lidar.T_base_laser, metadata=about)


def _record_truth(log: DriveLogWriter, tick: Tick, truth: Truth, *, in_map: bool) -> None:
    """What a real chair could not record: what the driver meant, and the pose in the map if asked for."""
    log.desired(tick.stamp, *truth.desired.tolist())
    if in_map:
        log.map_odom(tick.stamp, truth.state.pose * tick.observation.pose.inverse())


def place_note(course: Course) -> dict[str, str]:
    """Metadata that give all runs of one world a shared frame, on any route: `place` is a hash of the world, and
    odometry began at (0, 0, 0) in the course's start (`T_place_odom`: x y [m], yaw [rad])."""
    what = hashlib.sha256(np.ascontiguousarray(course.grid.data).tobytes())
    what.update(repr((course.grid.resolution, *course.grid.origin)).encode())
    pose = " ".join(repr(float(value)) for value in course.start)
    return {"place": what.hexdigest()[:16], "T_place_odom": pose}


@dataclass(frozen=True)
class Job:
    """One run of a study, made in the process that runs it."""

    course: Course
    make_driver: Callable[[Course], Driver]
    make_assistant: Callable[[], Assistant]
    seed: int
    config: RunConfig = field(default_factory=RunConfig)
    log_path: Path | None = None
    destination: str | None = None

    def run(self) -> DriveTrace:
        """-> the trace"""
        driver, assistant = self.make_driver(self.course), self.make_assistant()
        return run_drive(self.course, driver, assistant, self.seed, self.config, self.log_path, self.destination)
