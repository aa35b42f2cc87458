"""Runs of drivers x courses x assistants, and their metrics (Sec. 3.5-3.6, Tables 3.1-3.3, 4.1)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

from lfdcore.progress import Progress
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import ImpairedDriver, population
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import (
    ARMS,
    StudyModels,
    make_assistant,
    planners,
    require_arms,
    require_once,
)
from lfdcore.study.driving.metrics import driving_metrics, entropy_baseline, framework_metrics, steering_signal
from lfdcore.study.jobs import run_jobs
from lfdcore.wheelchair.planner import Compliance


@dataclass(frozen=True, kw_only=True)
class DrivingPlan:
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
                partial(ImpairedDriver, config=config),
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
    """A plan's traces with their metrics, in the order of its jobs."""

    plan: DrivingPlan
    traces: tuple[DriveTrace, ...]
    rows: tuple[dict[str, Any], ...]
    """one a trace: course, assistant, seed, outcome and all metrics by name"""

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


def run_driving_plan(
    plan: DrivingPlan,
    progress: Progress | None = None,
    processes: int | None = None,
) -> DrivingResult:
    """Runs a plan over processes; its result does not depend on their number."""
    traces = run_jobs(plan.jobs(), progress, processes)
    judges = planners(plan.arms, plan.models, plan.run)
    return DrivingResult(plan, traces, tuple(metric_rows(traces, judges)))


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
        row = {"course": trace.course, "assistant": trace.assistant, "seed": trace.seed}
        row |= {"outcome": trace.outcome, **asdict(driving_metrics(trace, baseline.get((trace.course, trace.seed))))}
        if trace.plans:
            row |= asdict(framework_metrics(trace, compliance[trace.assistant]))
        rows.append(row)
    return rows
