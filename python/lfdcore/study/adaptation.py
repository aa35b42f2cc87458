"""Does the assistant learn its driver's steering bias while driving (Sec. 6.2.1)?

An able driver whose stick points to one side of what is meant drives a course in the closed loop. The joystick model's
error is the angle between what it takes the stick to mean (its predicted mean) and what is meant (`desired`): of the
model as it was before the drive, as it had become after `after` seconds, and as it was at each tick, all three over the
same ticks, those later than `after` seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2, Twist2, wrap_angle
from lfdcore.study.courses import Course
from lfdcore.study.drivers import AbleConfig, AbleDriver, DriverInput, able_population
from lfdcore.study.runner import RunConfig, run_drive
from lfdcore.study.statistics import summarise
from lfdcore.study.tables import Row, Table
from lfdcore.wheelchair.adaptive_assistant import AdaptationConfig, AdaptiveAssistant
from lfdcore.wheelchair.heatmap_model import HeatmapModel
from lfdcore.wheelchair.joystick_model import JoystickModel
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation

Floats = NDArray[np.float64]
BIAS = 0.3
"""[rad]"""
AT_REST = 0.05
"""A stick displaced less than this has no orientation to err by."""


class BiasedDriver(AbleDriver):
    """An able driver whose stick points `bias` [rad, positive = left] beside what is meant."""

    name = "biased"

    def __init__(self, course: Course, bias: float, config: AbleConfig | None = None) -> None:
        if not abs(bias) < math.pi / 2:  # NaN too
            raise ValueError(f"bias is {bias} rad, must lie within pi / 2 of 0")
        super().__init__(course, config)
        self.bias = bias

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick now, as in Driver.act: desired as meant, joystick beside it."""
        meant = super().act(stamp, pose, twist, in_contact).desired
        c, s = math.cos(self.bias), math.sin(self.bias)
        return DriverInput(np.array([c * meant[0] - s * meant[1], s * meant[0] + c * meant[1]]).clip(-1, 1), meant)


class _Watched:
    """An adaptive assistant whose joystick model is asked at every tick, before it learns from it, and kept once."""

    def __init__(self, assistant: AdaptiveAssistant, after: float) -> None:
        self.name, self._assistant, self._after = assistant.name, assistant, after
        self.wanted: list[tuple[float, float]] = []
        self.model_then: JoystickModel | None = None

    def reset(self) -> None:
        self._assistant.reset()

    def update(self, observation: Observation) -> Assistance:
        model = self._assistant.adapter.model
        self.wanted.append(model.predict(observation.joystick).mean)
        if self.model_then is None and observation.stamp >= self._after - 1e-9:
            self.model_then = model
        return self._assistant.update(observation)


@dataclass(frozen=True)
class AdaptationRun:
    """Mean absolute errors [rad] over the ticks later than `after`."""

    course: str
    driver: int
    bias: float
    outcome: str
    collisions: int
    ticks: int
    """that were judged"""
    before: float
    """of the trained model"""
    then: float
    """of the model as it was `after` seconds into the drive"""
    adapting: float
    """of the model as it was at each tick"""


@dataclass(frozen=True, kw_only=True)
class AdaptationStudy:
    """Driver k of the able population drives every course with every bias and seed `seed` + k."""

    courses: tuple[Course, ...]
    model: HeatmapModel
    biases: tuple[float, ...] = (0.0, BIAS, -BIAS)
    drivers: int = 5
    seed: int = 1
    after: float = 60.0
    adaptation: AdaptationConfig = field(default_factory=AdaptationConfig)
    run: RunConfig = field(default_factory=RunConfig)


def run_adaptation_study(
    study: AdaptationStudy, progress: Callable[[int, int], None] | None = None
) -> tuple[AdaptationRun, ...]:
    """One run a course, bias and driver, in that order. ValueError for a drive that ends before `after`."""
    drivers = able_population(study.drivers, study.seed)
    jobs = [(c, bias, k) for c in study.courses for bias in study.biases for k in range(study.drivers)]
    runs = []
    for course, bias, k in jobs:
        runs.append(_drive(study, course, BiasedDriver(course, bias, drivers[k]), k))
        if progress is not None:
            progress(len(runs), len(jobs))
    return tuple(runs)


def _drive(study: AdaptationStudy, course: Course, driver: BiasedDriver, k: int) -> AdaptationRun:
    chair = ChairGeometry(
        footprint=study.run.chair.footprint, limits=study.run.chair.limits, T_base_laser=study.run.lidar.T_base_laser
    )
    watched = _Watched(AdaptiveAssistant(study.model, chair, adaptation=study.adaptation), study.after)
    trace = run_drive(course, driver, watched, study.seed + k, study.run)
    at_rest = np.minimum(np.hypot(*trace.joystick.T), np.hypot(*trace.desired.T)) <= AT_REST
    judged = (trace.stamp > study.after) & ~at_rest
    if watched.model_then is None or not judged.any():
        raise ValueError(f"the drive of {course.name} took {trace.stamp[-1]:.0f} s, must be over {study.after} s")
    raw, meant = trace.joystick[judged], trace.desired[judged]
    return AdaptationRun(
        course.name,
        k,
        driver.bias,
        trace.outcome,
        int(trace.collision.sum()),
        int(judged.sum()),
        angle_error(study.model.joystick.predict_many(raw)[0], meant),
        angle_error(watched.model_then.predict_many(raw)[0], meant),
        angle_error(np.array(watched.wanted)[judged], meant),
    )


def angle_error(wanted: Floats, meant: Floats) -> float:
    """Mean absolute angle [rad] between sticks (N, 2) and (N, 2)."""
    angles = [np.arctan2(sticks[:, 1], sticks[:, 0]) for sticks in (wanted, meant)]
    return float(np.abs(wrap_angle(angles[0] - angles[1])).mean())


def pooled_ratio(runs: Sequence[AdaptationRun], stage: str) -> float:
    """Mean error at a stage ('then' or 'adapting') over the mean error before, of all runs."""
    return float(np.mean([getattr(run, stage) for run in runs]) / np.mean([run.before for run in runs]))


def adaptation_table(runs: Sequence[AdaptationRun], after: float = 60.0) -> Table:
    """A row a bias: errors with intervals over runs, and their ratios to the trained model's."""
    header = (
        "bias [rad]",
        "runs",
        "completed",
        "hits",
        "trained",
        "after",
        "while adapting",
        "ratio",
        "ratio adapting",
    )
    rows = [_row(bias, [run for run in runs if run.bias == bias]) for bias in sorted({run.bias for run in runs})]
    note = (
        f"Mean angle [rad] between the stick the model predicts and the one meant, over the ticks after {after:.0f} s, "
        f"with 95 % intervals over runs; of the trained model, of the model as adapted after {after:.0f} s, and of the "
        "model as it goes on adapting. Ratios are of means. Wanted: at most .7 with a bias, 1.05 without."
    )
    return Table("On-line adaptation to a driver with a steering bias (Sec. 6.2.1)", header, tuple(rows), note)


def _row(bias: float, runs: Sequence[AdaptationRun]) -> Row:
    errors = [summarise([getattr(run, stage) for run in runs]) for stage in ("before", "then", "adapting")]
    return (
        f"{bias:+.2f}",
        str(len(runs)),
        str(sum(run.outcome == "completed" for run in runs)),
        str(sum(run.collisions for run in runs)),
        *(f"{e.mean:.3f} [{e.low:.3f}, {e.high:.3f}]" for e in errors),
        *(f"{pooled_ratio(runs, stage):.2f}" for stage in ("then", "adapting")),
    )
