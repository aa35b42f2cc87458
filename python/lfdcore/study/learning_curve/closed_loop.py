"""The closed loop of study learning-curve: impaired drivers in a home never seen, with every model and unassisted."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.courses import home_20x19
from lfdcore.simulated.drivers import ImpairedDriver, population
from lfdcore.simulated.run import Job
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, make_assistant, planners
from lfdcore.study.demonstrations import maze_seed
from lfdcore.study.driving.plan import metric_rows
from lfdcore.study.jobs import run_jobs
from lfdcore.study.learning_curve.models import model_files
from lfdcore.study.learning_curve.study import METHODS, NOBODY, LearningCurveStudy


def way_seed(seed: int, driver: int) -> int:
    """Of a driver's way and noise: that of no demonstration and of no other run."""
    return maze_seed(seed, 600 + driver)


def closed_loop_rows(study: LearningCurveStudy, folder: Path, tell: StageProgress = silent) -> list[dict[str, Any]]:
    """Drives with models that have been learned -> a row a run: demonstrations (0: unassisted), and what metric_rows
    has."""
    groups = [(0, NOBODY, StudyModels())]
    groups += [(n, method, model_files(study, folder, n)) for n in study.runs for method in METHODS]
    jobs = [job for _, method, models in groups for job in drives_of(study, method, models)]
    traces = run_jobs(jobs, partial(tell, "drive a home never seen"), study.processes)
    rows = []
    for g, (n, method, models) in enumerate(groups):
        of_group = traces[g * study.drivers : (g + 1) * study.drivers]
        rows += [{"demonstrations": n, **row} for row in _judged(study, method, models, of_group)]
    return rows


def drives_of(study: LearningCurveStudy, method: str, models: StudyModels) -> list[Job]:
    """A job a driver, the same ways and noise for every method and model."""
    return [
        Job(
            home_20x19(way_seed(study.seed, k)),
            partial(ImpairedDriver, config=config),
            partial(make_assistant, method, models, study.run),
            way_seed(study.seed, k),
            study.run,
        )
        for k, config in enumerate(population(study.drivers, study.seed))
    ]


def _judged(
    study: LearningCurveStudy, method: str, models: StudyModels, traces: Sequence[DriveTrace]
) -> list[dict[str, Any]]:
    return metric_rows(traces, planners([method], models, study.run))
