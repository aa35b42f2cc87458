"""Study driving: drivers x courses x assistants x seeds (Sec. 3.5-3.6, Tables 3.1-3.3, 4.1)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from lfdcore.control import DynamicWindowConfig
from lfdcore.errors import ModelError
from lfdcore.study.courses import Course
from lfdcore.study.drivers import Driver, ImpairedConfig, ImpairedDriver, population
from lfdcore.study.metrics import driving_metrics, entropy_baseline, framework_metrics, steering_signal
from lfdcore.study.runner import Job, RunConfig, run_jobs
from lfdcore.study.trace import DriveTrace
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DriveAssistantConfig,
    DynamicWindowAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.heatmap_model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.model_file import DriveAssistantModel
from lfdcore.wheelchair.models import Model, load_model
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.planner import Compliance

ARMS = ("none", "dwa", "primitives", "heatmaps")
"""Assistants of the study, the unassisted arm first."""
FOOTNOTE_ARMS = ("dwa_1s", "thesis", "heatmaps_thesis", "supervisor")
"""On request: DWA that looks no farther than its goal, the printed loops of Ch. 3 and Ch. 4, and the bare supervisor on
the driver's own input."""
METHODS = {"primitives": "primitives", "thesis": "primitives", "heatmaps": "heatmaps", "heatmaps_thesis": "heatmaps"}
"""By what the learned arms were taught."""


@dataclass(frozen=True)
class StudyModels:
    """Files of learned models; None where no arm needs one."""

    primitives: Path | None = None
    heatmaps: Path | None = None

    def of(self, arm: str) -> DriveAssistantModel | HeatmapModel:
        """The model that drives in an arm. ValueError without one."""
        path = getattr(self, METHODS[arm])
        if path is None:
            raise ValueError(f"assistant '{arm}' needs a model of method {METHODS[arm]}, there is none")
        model = _model(path)
        if isinstance(model, NaiveHeatmapModel):
            raise ModelError(f"{path} holds a naive heatmap, which drives nothing")
        return model


def models_by_method(paths: Sequence[Path]) -> StudyModels:
    """Files of models, in any order. ValueError for two of one method or one that drives nothing; ModelError as
    load_model."""
    found: dict[str, Path] = {}
    for path in paths:
        model = _model(path)
        if isinstance(model, NaiveHeatmapModel):
            raise ValueError(f"{path} holds a naive heatmap, which drives nothing")
        method = "heatmaps" if isinstance(model, HeatmapModel) else "primitives"
        if method in found:
            raise ValueError(f"{found[method]} and {path} are both models of method {method}, one is needed")
        found[method] = path
    return StudyModels(**found)


@lru_cache(maxsize=4)
def _model(path: Path) -> Model:
    return load_model(path)


def make_assistant(arm: str, models: StudyModels, run: RunConfig) -> Assistant:
    """The assistant of a study's arm for the chair that `run` simulates."""
    chair = ChairGeometry(footprint=run.chair.footprint, limits=run.chair.limits, T_base_laser=run.lidar.T_base_laser)
    if arm == "none":
        return Unassisted(chair)
    if arm == "dwa":
        return DynamicWindowAssistant(chair)
    if arm == "dwa_1s":
        return DynamicWindowAssistant(chair, DynamicWindowConfig(horizon=1.0), name=arm)
    if arm == "supervisor":
        return Supervised(chair)
    if arm in ("primitives", "heatmaps"):
        return DriveAssistant(models.of(arm), chair, name=arm)
    if arm in ("thesis", "heatmaps_thesis"):
        return DriveAssistant(models.of(arm), chair, DriveAssistantConfig.thesis(), name=arm)
    raise ValueError(f"assistant is '{arm}', must be one of {', '.join(ARMS + FOOTNOTE_ARMS)}")


def require_arms(arms: Sequence[str]) -> None:
    """ValueError without an arm, for one that is unknown, empty or there twice."""
    for arm in arms:
        if arm not in ARMS + FOOTNOTE_ARMS:
            raise ValueError(f"assistant is '{arm}', must be one of {', '.join(ARMS + FOOTNOTE_ARMS)}")
    require_once("assistant", arms)


def require_once(kind: str, names: Sequence[str]) -> None:
    """ValueError without a name or for one that is there twice: each is compared with the others."""
    if not names:
        raise ValueError(f"there is no {kind}, must be at least one")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"{kind} '{twice[0]}' is given {names.count(twice[0])} times, must be given once")


def _impaired(config: ImpairedConfig, course: Course) -> Driver:
    return ImpairedDriver(course, config)


@dataclass(frozen=True, kw_only=True)
class DrivingStudy:
    """What is compared. Driver k of the population drives every course in every arm with seed `seed` + k."""

    courses: tuple[Course, ...]
    models: StudyModels
    arms: tuple[str, ...] = ARMS
    drivers: int = 10
    seed: int = 1
    run: RunConfig = field(default_factory=RunConfig)

    def __post_init__(self) -> None:
        require_arms(self.arms)
        require_once("course", [course.name for course in self.courses])

    def jobs(self) -> list[Job]:
        """One job a run, in a fixed order: course, driver, arm."""
        drivers = population(self.drivers, self.seed)
        return [
            Job(
                course,
                partial(_impaired, config),
                partial(make_assistant, arm, self.models, self.run),
                self.seed + k,
                self.run,
            )
            for course in self.courses
            for k, config in enumerate(drivers)
            for arm in self.arms
        ]


@dataclass(frozen=True)
class DrivingResult:
    """A study's traces with their metrics, in the order of its jobs."""

    study: DrivingStudy
    traces: tuple[DriveTrace, ...]
    rows: tuple[dict[str, Any], ...]
    """one a trace: course, driver (its number), assistant, seed, outcome and all metrics by name"""

    @property
    def nbytes(self) -> int:
        """Memory of the traces [bytes]: they hold no scans."""
        return sum(trace.nbytes for trace in self.traces)

    def column(self, course: str | None, arm: str, metric: str) -> list[float]:
        """A metric of an arm in the order of drivers, on one course or (None) on all."""
        return [
            float(row[metric])
            for row in self.rows
            if row["assistant"] == arm and (course is None or row["course"] == course)
        ]


def run_driving_study(
    study: DrivingStudy,
    progress: Callable[[int, int], None] | None = None,
    processes: int | None = None,
) -> DrivingResult:
    """Runs a study over processes; its result does not depend on their number."""
    traces = run_jobs(study.jobs(), progress, processes)
    planners = {arm: make_assistant(arm, study.models, study.run) for arm in study.arms if arm in METHODS}
    judges = {arm: one.planner for arm, one in planners.items() if isinstance(one, DriveAssistant)}
    return DrivingResult(study, traces, tuple(metric_rows(traces, judges)))


def metric_rows(traces: Iterable[DriveTrace], compliance: Mapping[str, Compliance]) -> list[dict[str, Any]]:
    """All metrics of all traces; `compliance` of each arm that plans. Steering entropy's fixed baseline is that of the
    same seed's unassisted run."""
    traces = list(traces)
    baseline = {
        (t.course, t.seed): entropy_baseline(steering_signal(t.stamp, t.desired))
        for t in traces
        if t.assistant == "none"
    }
    rows = []
    for trace in traces:
        row = {"course": trace.course, "driver": trace.seed, "assistant": trace.assistant, "seed": trace.seed}
        row |= {"outcome": trace.outcome, **asdict(driving_metrics(trace, baseline.get((trace.course, trace.seed))))}
        if trace.plans:
            row |= asdict(framework_metrics(trace, compliance[trace.assistant]))
        rows.append(row)
    return rows
