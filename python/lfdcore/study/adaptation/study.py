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
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2, Twist2, wrap_angle
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import AbleConfig, AbleDriver, DriverInput, able_population
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, simulated_chair
from lfdcore.study.jobs import run_jobs
from lfdcore.wheelchair.adaptive_assistant import AdaptationConfig, AdaptiveAssistant
from lfdcore.wheelchair.heatmaps.joystick import JoystickModel
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.observation import Assistance, Observation
from lfdcore.wheelchair.stick import DEAD_ZONE

Floats = NDArray[np.float64]
BIAS = 0.3
"""[rad]"""
STAGES = ("before", "then", "adapting")
"""The trained model, the one of `after` seconds, the one of each tick."""


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


@dataclass(frozen=True, eq=False)
class AdaptationRun:
    """Errors [rad] of the joystick model at each of the drive's T ticks, NaN where the stick is at rest."""

    course: str
    driver: int
    seed: int
    bias: float
    outcome: str
    collisions: int
    after: float
    """[s]: later ticks are judged"""
    stamp: Floats
    """(T,) [s]"""
    error_before: Floats
    """(T,) of the trained model"""
    error_then: Floats
    """(T,) of the model as it was `after` seconds into the drive"""
    error_adapting: Floats
    """(T,) of the model as it was at the tick"""

    def mean(self, stage: str) -> float:
        """Error at a stage of STAGES over the ticks that are judged."""
        errors = getattr(self, f"error_{stage}")
        return float(np.nanmean(errors[self.stamp > self.after]))

    @property
    def ticks(self) -> int:
        """How many are judged."""
        return int(np.isfinite(self.error_before[self.stamp > self.after]).sum())

    def row(self) -> dict[str, Any]:
        """For machines."""
        names = ("course", "driver", "seed", "bias", "outcome", "collisions", "after", "ticks")
        return {name: getattr(self, name) for name in names} | {stage: self.mean(stage) for stage in STAGES}


@dataclass(frozen=True, kw_only=True)
class AdaptationStudy:
    """Driver k of the able population drives every course with every bias and seed `seed` + k."""

    courses: tuple[Course, ...]
    model: Path
    """File of heatmaps"""
    biases: tuple[float, ...] = (0.0, BIAS, -BIAS)
    drivers: int = 5
    seed: int = 1
    after: float = 60.0
    adaptation: AdaptationConfig = field(default_factory=AdaptationConfig)
    run: RunConfig = field(default_factory=RunConfig)


def run_adaptation_study(
    study: AdaptationStudy, progress: Callable[[int, int], None] | None = None, processes: int | None = None
) -> tuple[AdaptationRun, ...]:
    """One run a course, bias and driver, in that order. ValueError for a drive that ends before `after`; ModelError for
    a file that holds no heatmaps."""
    StudyModels(heatmaps=study.model).of("heatmaps")  # refused before anything is driven
    drivers = able_population(study.drivers, study.seed)
    jobs = [
        _Drive(study, course, bias, k, drivers[k])
        for course in study.courses
        for bias in study.biases
        for k in range(study.drivers)
    ]
    return run_jobs(jobs, progress, processes)


@dataclass(frozen=True)
class _Drive:
    study: AdaptationStudy
    course: Course
    bias: float
    number: int
    driver: AbleConfig

    def run(self) -> AdaptationRun:
        study, model = self.study, HeatmapModel.load(self.study.model)
        assistant = AdaptiveAssistant(model, simulated_chair(study.run), adaptation=study.adaptation)
        watched = _Watched(assistant, study.after)
        driver = BiasedDriver(self.course, self.bias, self.driver)
        trace = run_drive(self.course, driver, watched, study.seed + self.number, study.run)
        return self._judged(trace, model.joystick, watched)

    def _judged(self, trace: DriveTrace, trained: JoystickModel, watched: _Watched) -> AdaptationRun:
        raw, meant, after = trace.joystick, trace.desired, self.study.after
        at_rest = np.minimum(np.hypot(*raw.T), np.hypot(*meant.T)) <= DEAD_ZONE  # it has no orientation to err by
        then = watched.model_then
        if then is None or not (~at_rest & (trace.stamp > after)).any():
            raise ValueError(f"the drive of {trace.course} took {trace.stamp[-1]:.0f} s, must be over {after} s")
        models = (trained.predict_many(raw)[0], then.predict_many(raw)[0], np.array(watched.wanted))
        return AdaptationRun(
            trace.course,
            self.number,
            trace.seed,
            self.bias,
            trace.outcome,
            int(trace.collision.sum()),
            after,
            trace.stamp,
            *(np.where(at_rest, np.nan, angle_errors(wanted, meant)) for wanted in models),
        )


def angle_errors(wanted: Floats, meant: Floats) -> Floats:
    """Absolute angles (N,) [rad] between sticks (N, 2) and (N, 2)."""
    angles = [np.arctan2(sticks[:, 1], sticks[:, 0]) for sticks in (wanted, meant)]
    errors: Floats = np.abs(np.asarray(wrap_angle(angles[0] - angles[1])))
    return errors


def pooled_ratio(runs: Sequence[AdaptationRun], stage: str) -> float:
    """Mean error at a stage ('then' or 'adapting') over the mean error before, of all runs."""
    return float(np.mean([run.mean(stage) for run in runs]) / np.mean([run.mean("before") for run in runs]))
