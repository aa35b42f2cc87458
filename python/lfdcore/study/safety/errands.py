"""What caution costs: impaired drivers who mean to arrive, through doors, on the standard course, among people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lfdcore.geometry import Pose2
from lfdcore.progress import Progress
from lfdcore.simulated.courses import Course, course_by_name, narrow_gap
from lfdcore.simulated.drivers import ImpairedConfig, ImpairedDriver, population
from lfdcore.simulated.people import PeopleConfig
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, make_assistant
from lfdcore.study.driving.tasks import driver_of, limits_of
from lfdcore.study.jobs import run_jobs

DOORS = {f"door of {width:.2f} m": width for width in (0.8, 0.9, 1.0)}
COURSE = "standard course"
AMONG_PEOPLE = "standard course, 12 people"
ERRANDS = (*DOORS, COURSE, AMONG_PEOPLE)
"""A door is a gap in a wall, met from a place beside it and turned by up to 60 degrees."""


@dataclass(frozen=True)
class Errand:
    """How one driver fared."""

    errand: str
    arm: str
    seed: int
    arrived: bool
    contacts: int
    """with what stands; with people not"""
    nose_met_seen: int
    """contacts of the moving nose with a person whom the scan had shown for a second"""
    time: float
    """[s] until the driver arrived, gave up or ran out of time"""
    progress: float
    """[m/s] along the route, up to where the driver came"""


def run_errands(
    arms: Sequence[str],
    models: StudyModels,
    drivers: int,
    seed: int,
    progress: Progress | None = None,
    processes: int | None = None,
) -> tuple[Errand, ...]:
    """Driver k of the population does every errand in every arm, from the start of `seed` + k; the result does not
    depend on the number of processes."""
    who = enumerate(population(drivers, seed))
    made = [
        (name, arm, _job(name, arm, models, config, seed + k)) for k, config in who for name in ERRANDS for arm in arms
    ]
    traces = run_jobs([job for _, _, job in made], progress, processes)
    return tuple(_errand(name, arm, job, trace) for (name, arm, job), trace in zip(made, traces, strict=True))


def _job(name: str, arm: str, models: StudyModels, config: ImpairedConfig, seed: int) -> Job:
    run = RunConfig(people=PeopleConfig()) if name == AMONG_PEOPLE else RunConfig()
    assistant = partial(make_assistant, arm, models, run)
    if name in DOORS:
        task = narrow_gap(seed, DOORS[name])
        return Job(task.course, partial(driver_of, task, config), assistant, seed, limits_of(task, run))
    return Job(course_by_name("standard_course", 1), partial(ImpairedDriver, config=config), assistant, seed, run)


def _errand(name: str, arm: str, job: Job, trace: DriveTrace) -> Errand:
    arrived = trace.completed
    if name in DOORS:
        arrived = narrow_gap(job.seed, DOORS[name]).reached(Pose2(*trace.pose[-1]), trace.footprint)
    time = float(trace.stamp[-1])
    return Errand(
        errand=name,
        arm=arm,
        seed=job.seed,
        arrived=arrived,
        contacts=int(trace.collision.sum()),
        nose_met_seen=sum(one.foreseeable for one in trace.people_met),
        time=time,
        progress=_way(job.course, trace) / time,
    )


def _way(course: Course, trace: DriveTrace) -> float:
    """[m] of the route up to the place nearest to where the chair ended; all of it for one that arrived."""
    if trace.completed:
        return course.length
    steps = np.hypot(*np.diff(course.route, axis=0).T)
    nearest = int(np.hypot(*(course.route - trace.pose[-1, :2]).T).argmin())
    return float(steps[:nearest].sum())
