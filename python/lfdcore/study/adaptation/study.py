"""Does the assistant learn its driver's steering bias while driving (Sec. 6.2.1)?

An able driver whose stick points to one side of what is meant drives a course in the closed loop. The joystick model's
error is the angle between what it takes the stick to mean (its predicted mean) and what is meant (`desired`): of the
model as it was before the drive, as it had become after `after` seconds, and as it was at each tick, all three over the
same ticks, those later than `after` seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import wrap_angle
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.biased_driver import BiasedDriver
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import AbleConfig, able_population
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import courses_by_name
from lfdcore.study.demonstrations import HeatmapsFile, heatmaps_or_learned
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Study
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


class _Watched:
    """An adaptive assistant whose joystick model is asked at every tick, before it learns from it, and kept once."""

    def __init__(self, assistant: AdaptiveAssistant, after: float) -> None:
        self.name, self.chair = assistant.name, assistant.chair
        self._assistant, self._after = assistant, after
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
        names = ("course", "seed", "bias", "outcome", "collisions", "after", "ticks")
        return {name: getattr(self, name) for name in names} | {stage: self.mean(stage) for stage in STAGES}


@dataclass(frozen=True, kw_only=True)
class AdaptationStudy(Study):
    """Drivers with a steering bias: the joystick model's error before and while it adapts (Sec. 6.2.1)."""

    name = "adaptation"
    title = "on-line adaptation to a driver with a steering bias (Sec. 6.2.1)"

    model: HeatmapsFile = None
    courses: Annotated[
        tuple[str, ...],
        Option("Comma-separated names of courses or map .yaml files; office and flat were tuned on."),
    ] = ("standard_course",)
    drivers: Annotated[int, Option("Simulated able drivers, each unbiased and +-.3 rad beside.", minimum=1)] = 10
    biases: tuple[float, ...] = (0.0, BIAS, -BIAS)
    after: float = 60.0
    adaptation: AdaptationConfig = field(default_factory=AdaptationConfig)
    run: RunConfig = field(default_factory=RunConfig)


def run_adaptation_study(
    study: AdaptationStudy, folder: Path, tell: StageProgress = silent
) -> tuple[AdaptationRun, ...]:
    """Driver k of the able population drives every course with every bias and seed `seed` + k -> one run a course, bias
    and driver, in that order. A model that is not given is learned in `folder`.

    ValueError for courses as courses_by_name, a model of another method or a drive that ends before `after`.
    """
    courses = courses_by_name(study.courses, study.seed)
    model = heatmaps_or_learned(study.model, folder, study.seed, tell, study.processes)
    drivers = able_population(study.drivers, study.seed)
    jobs = [
        _Drive(study, model, course, bias, k, drivers[k])
        for course in courses
        for bias in study.biases
        for k in range(study.drivers)
    ]
    return run_jobs(jobs, partial(tell, "drive"), study.processes)


@dataclass(frozen=True)
class _Drive:
    study: AdaptationStudy
    model: Path
    course: Course
    bias: float
    number: int
    driver: AbleConfig

    def run(self) -> AdaptationRun:
        study, simulated = self.study, self.study.run
        model = HeatmapModel.load(self.model)
        watched = _Watched(AdaptiveAssistant(model, simulated.geometry, adaptation=study.adaptation), study.after)
        driver = BiasedDriver(self.course, self.bias, self.driver)
        trace = run_drive(self.course, driver, watched, study.seed + self.number, simulated)
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


def by_bias(runs: Sequence[AdaptationRun]) -> list[tuple[float, list[AdaptationRun]]]:
    """The runs of each bias, biases rising."""
    return [(bias, [run for run in runs if run.bias == bias]) for bias in sorted({run.bias for run in runs})]
