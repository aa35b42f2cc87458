"""Runs: a driver in a course with an assistant, tick by tick; studies run many of them over processes.

Every arm of a study sees the same seeds: the noise of tick k in the scans, the slip and the driver depends on the
seed and on k only.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLogWriter
from lfdcore.datasets.safe_joystick import limits_note
from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import Driver
from lfdcore.simulated.trace import DriveTrace, Plan
from lfdcore.simulation import ChairConfig, ChairState, DrivingWorld, LidarConfig
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.observation import PERIOD, Assistance, Observation


@dataclass(frozen=True, kw_only=True)
class RunConfig:
    """How a run is simulated."""

    chair: ChairConfig = field(default_factory=ChairConfig)
    lidar: LidarConfig = field(default_factory=LidarConfig)
    period: float = PERIOD
    """Between ticks [s]."""
    slowest: float = 0.12
    """Mean speed along the route [m/s] below which a run times out."""
    stuck_after: float = 60.0
    """Time without .5 m of progress [s] after which a run counts as stuck."""
    stuck_progress: float = 0.5
    """[m]"""


class _Recorder:
    """Collects a run's ticks."""

    def __init__(self, start: Pose2) -> None:
        self.T_map_odom = start  # odometry begins at (0, 0, 0)
        self.rows: dict[str, list[Any]] = {}
        self.plans: list[Plan] = []

    def add(self, stamp: float, state: ChairState, entry: dict[str, Any], assistance: Assistance) -> None:
        row = {
            "stamp": stamp,
            "pose": tuple(state.pose),
            "twist": tuple(state.twist),
            "in_contact": state.in_contact,
            "command": tuple(assistance.command),
            "mode": assistance.mode,
            "supervised": assistance.supervised,
            "compliance": assistance.compliance if assistance.path is not None else np.nan,
            "goal": self._in_map(assistance.goal),
            "control_point": self._ahead(state.pose, assistance.control_point),
            **entry,
        }
        for name, value in row.items():
            self.rows.setdefault(name, []).append(value)
        if assistance.planned and assistance.path is not None:
            self.plans.append(Plan(stamp, self.T_map_odom.transform(assistance.path)))

    def _in_map(self, point: tuple[float, float] | None) -> tuple[float, float]:
        return self._ahead(self.T_map_odom, point)

    @staticmethod
    def _ahead(T_map_frame: Pose2, point: tuple[float, float] | None) -> tuple[float, float]:
        if point is None:
            return (np.nan, np.nan)
        x, y = T_map_frame.transform(np.array([point]))[0]
        return (float(x), float(y))

    def arrays(self) -> dict[str, Any]:
        return {name: np.array(values) for name, values in self.rows.items()} | {"plans": tuple(self.plans)}


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
    world = DrivingWorld(course.grid, config.chair, config.lidar, seed)
    world.reset(course.start)
    driver.reset(seed)
    assistant.reset()
    recorder = _Recorder(course.start)
    progress = _Progress(config, course.length)
    log = None
    if log_path is not None:
        about = {"driver": driver.name, "assistant": assistant.name, "seed": str(seed)}
        about |= limits_note(config.chair.limits) | place_note(course)
        about |= {} if destination is None else {"destination": destination}
        log = DriveLogWriter(log_path, name=course.name, T_base_laser=config.lidar.T_base_laser, metadata=about)
    collision, odometry_twist = False, Twist2()
    outcome = None
    tick = 0
    try:
        while outcome is None:
            stamp = tick * config.period
            scan = world.scan()
            state = world.state
            given = driver.act(stamp, state.pose, state.twist, state.in_contact)
            joystick = (
                float(np.float32(given.joystick[0])),
                float(np.float32(given.joystick[1])),
            )  # as sensor_msgs/Joy
            observation = Observation(stamp, scan, stamp, world.odometry, odometry_twist, joystick)
            assistance = assistant.update(observation)
            if log is not None:
                _write(log, observation, assistance, given.desired)
                if destination is not None:
                    log.map_odom(stamp, state.pose * world.odometry.inverse())
            entry = {"joystick": joystick, "desired": tuple(given.desired), "collision": collision}
            recorder.add(stamp, state, entry, assistance)
            result = world.step(assistance.command, config.period)
            collision, odometry_twist = result.collision_started, result.odometry_twist
            outcome = progress.outcome(stamp, driver)
            tick += 1
    finally:
        if log is not None:
            log.close()
    return DriveTrace(
        course=course.name,
        driver=driver.name,
        assistant=assistant.name,
        seed=seed,
        outcome=outcome,
        footprint=config.chair.footprint,
        **recorder.arrays(),
    )


def place_note(course: Course) -> dict[str, str]:
    """Metadata by which runs of one world, on whatever route, share a frame: `place` names the world by what it is, and
    odometry began at (0, 0, 0) in the course's start (`T_place_odom`: x y [m], yaw [rad])."""
    what = hashlib.sha256(np.ascontiguousarray(course.grid.data).tobytes())
    what.update(repr((course.grid.resolution, *course.grid.origin)).encode())
    pose = " ".join(repr(float(value)) for value in course.start)
    return {"place": what.hexdigest()[:16], "T_place_odom": pose}


def _write(log: DriveLogWriter, seen: Observation, said: Assistance, desired: NDArray[np.float64]) -> None:
    log.odometry(seen.stamp, seen.pose, seen.twist)
    log.scan(seen.scan_stamp, seen.scan)
    log.joystick(seen.stamp, *seen.joystick)
    log.desired(seen.stamp, float(desired[0]), float(desired[1]))
    log.command(seen.stamp, said.command)
    if said.planned and said.path is not None:
        log.plan(seen.stamp, said.path)
    if said.planned and said.goal is not None:
        log.intention(seen.stamp, said.goal, said.likelihood)


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
