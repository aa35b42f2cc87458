"""Short tasks from many starts: through a doorway and dock at a table; a narrow gap from the side (Fig. 3.13, 3.15)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from lfdcore.geometry import Pose2
from lfdcore.progress import Progress
from lfdcore.simulated.courses import Course, Task, doorway_and_docking, narrow_gap
from lfdcore.simulated.courses.tasks import DOCKING_DISTANCE
from lfdcore.simulated.drivers import ImpairedConfig, population
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.task_driver import DOCKING_SPEED, TaskDriver
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import ARMS, StudyModels, make_assistant, require_arms, require_known
from lfdcore.study.driving.metrics import reversals, stuck_time
from lfdcore.study.jobs import run_jobs

TASKS: dict[str, Callable[[int], Task]] = {"doorway_and_docking": doorway_and_docking, "narrow_gap": narrow_gap}
TASK_NAMES = {"doorway_and_docking": "doorway, then docking", "narrow_gap": "narrow gap (.90 m)"}
TASK_GOALS = {
    "doorway_and_docking": (
        f"Reached means docked: at the end of the run the chair's outline is within {DOCKING_DISTANCE:g} m of the "
        f"table; the run ends once that is so at no more than {DOCKING_SPEED:g} m/s, or when its time is over."
    ),
    "narrow_gap": (
        "Reached: the whole chair is behind the wall with the gap; the run ends then, or when its time is over."
    ),
}
"""What counts as reached, for readers of a table."""


def driver_of(task: Task, config: ImpairedConfig, course: Course) -> TaskDriver:
    """Who does the task, which knows its course."""
    return TaskDriver(task, config)


@dataclass(frozen=True, kw_only=True)
class TaskPlan:
    """Start k of each task is drawn from `seed` + k and driven by driver k of the population in every arm."""

    models: StudyModels
    tasks: tuple[str, ...] = tuple(TASKS)
    arms: tuple[str, ...] = ARMS
    starts: int = 20
    seed: int = 1
    run: RunConfig = field(default_factory=RunConfig)

    def __post_init__(self) -> None:
        require_arms(self.arms)
        require_known("task", self.tasks, tuple(TASKS))

    def made(self, name: str) -> list[Task]:
        """The task's starts."""
        return [TASKS[name](self.seed + k) for k in range(self.starts)]


@dataclass(frozen=True)
class TaskResult:
    """Rows and traces in a fixed order: task, start, arm."""

    plan: TaskPlan
    rows: tuple[dict[str, Any], ...]
    """one a run: task, assistant, seed, reached, success (reached, no contact), contacts, stuck, reversals, time [s]"""
    traces: tuple[DriveTrace, ...]
    courses: tuple[Course, ...]
    """of each trace"""

    def column(self, task: str, arm: str, name: str) -> list[Any]:
        """One figure of an arm in the order of starts."""
        return [row[name] for row in self.rows if (row["task"], row["assistant"]) == (task, arm)]


def limits_of(task: Task, run: RunConfig) -> RunConfig:
    """A task has its own time, and being stuck does not end it: its driver may get free."""
    return replace(run, slowest=task.course.length / task.time_limit, stuck_after=float("inf"))


def task_row(name: str, task: Task, trace: DriveTrace) -> dict[str, Any]:
    """What is counted of one run. Stuck: less than .1 m in some 10 s while forward is asked."""
    reached = task.reached(Pose2(*trace.pose[-1]), trace.footprint)
    contacts = int(trace.collision.sum())
    return {
        "task": name,
        "assistant": trace.assistant,
        "seed": trace.seed,
        "reached": reached,
        "contacts": contacts,
        "success": reached and contacts == 0,
        "stuck": stuck_time(trace) > 0,
        "reversals": reversals(trace),
        "time": float(trace.stamp[-1]),
    }


def run_task_plan(plan: TaskPlan, progress: Progress | None = None, processes: int | None = None) -> TaskResult:
    """Runs all tasks over processes; the result does not depend on their number."""
    drivers = population(plan.starts, plan.seed)
    runs = [
        (name, task, arm, config)
        for name in plan.tasks
        for task, config in zip(plan.made(name), drivers, strict=True)
        for arm in plan.arms
    ]
    jobs = [
        Job(
            task.course,
            partial(driver_of, task, config),
            partial(make_assistant, arm, plan.models, plan.run),
            task.seed,
            limits_of(task, plan.run),
        )
        for _, task, arm, config in runs
    ]
    traces = run_jobs(jobs, progress, processes)
    rows = tuple(task_row(name, task, trace) for (name, task, _, _), trace in zip(runs, traces, strict=True))
    return TaskResult(plan, rows, traces, tuple(job.course for job in jobs))
