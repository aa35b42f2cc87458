"""Study driving: drivers x courses x assistants, and short tasks (Sec. 3.5-3.6, Tables 3.1-3.3, 4.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated

from lfdcore.progress import StageProgress, silent
from lfdcore.study.arms import (
    ARMS,
    FOOTNOTE_ARMS,
    METHODS,
    StudyModels,
    courses_by_name,
    models_by_method,
    require_arms,
)
from lfdcore.study.demonstrations import (
    demonstration_paths,
    learn_from_demonstrations,
    learn_heatmaps_from_demonstrations,
)
from lfdcore.study.driving.plan import DrivingPlan, DrivingResult, run_driving_plan
from lfdcore.study.driving.tasks import TaskPlan, TaskResult, run_task_plan
from lfdcore.study.study import Option, Study, under


@dataclass(frozen=True, kw_only=True)
class DrivingStudy(Study):
    """Drivers x courses x assistants: Tables 3.1-3.3 and 4.1 with intervals, tasks, pictures of every course."""

    name = "driving"
    title = "driving study"

    models: Annotated[
        tuple[Path, ...],
        Option("A learned model, once a method; what is missing is learned from demonstrations.", flag="--model"),
    ] = ()
    courses: Annotated[tuple[str, ...], Option("Comma-separated names of courses or map .yaml files.")] = (
        "standard_course",
    )
    assistants: Annotated[tuple[str, ...], Option(f"Of {', '.join(ARMS)}; {', '.join(FOOTNOTE_ARMS)}.")] = ARMS
    drivers: Annotated[int, Option("Simulated impaired drivers.", minimum=1)] = 10
    starts: Annotated[int, Option("Starts of each task; 0: no tasks.", minimum=0, flag="--task-starts")] = 20

    def __post_init__(self) -> None:
        super().__post_init__()
        require_arms(self.assistants)


@dataclass(frozen=True)
class WholeResult:
    """Courses and, if asked for, tasks, driven with the same models."""

    courses: DrivingResult
    tasks: TaskResult | None
    demonstrations: tuple[Path, ...]
    """logs that the study's primitives learned from; none for a model that was given"""


def run_driving_study(study: DrivingStudy, folder: Path, tell: StageProgress = silent) -> WholeResult:
    """Learns what the assistants need and was not given, into `folder`, and drives courses and tasks.

    ValueError before anything is driven for a course or a model that cannot be used.
    """
    given = models_by_method(study.models)
    courses = courses_by_name(study.courses, study.seed)
    plan = DrivingPlan(courses=courses, models=given, arms=study.assistants, drivers=study.drivers, seed=study.seed)
    models = _learn_what_is_missing(study, folder, given, tell)
    driven = run_driving_plan(replace(plan, models=models), partial(tell, "drive courses never seen"), study.processes)
    tasks = None
    if study.starts:
        task_plan = TaskPlan(models=models, arms=study.assistants, starts=study.starts, seed=study.seed)
        tasks = run_task_plan(task_plan, partial(tell, "tasks: docking, narrow gap"), study.processes)
    demonstrations = () if given.file("primitives") else demonstration_paths(folder)
    return WholeResult(driven, tasks, demonstrations)


def _learn_what_is_missing(study: DrivingStudy, folder: Path, given: StudyModels, tell: StageProgress) -> StudyModels:
    """The models that the assistants need, learned from demonstrations where none was given."""
    needed = {METHODS[arm] for arm in study.assistants if arm in METHODS}
    models = given
    if "primitives" in needed and given.file("primitives") is None:
        learned = learn_from_demonstrations(folder, study.seed, progress=partial(tell, "learn primitives"))
        models = models.and_file("primitives", learned)
    if "heatmaps" in needed and given.file("heatmaps") is None:
        at = under(tell, "heatmaps")
        learned = learn_heatmaps_from_demonstrations(folder, study.seed, at, processes=study.processes)
        models = models.and_file("heatmaps", learned)
    return models
