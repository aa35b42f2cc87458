"""What is driven: every assistant under every condition, with sticks that no driver should move so."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from lfdcore.progress import StageProgress, silent
from lfdcore.study.arms import models_by_method, require_arms, require_known
from lfdcore.study.jobs import run_jobs
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.study.safety.errands import Errand, run_errands
from lfdcore.study.safety.hostile_run import STICKS, HostileCounts, HostileRun
from lfdcore.study.study import Option, Study

COURSES = ("standard_course", "home", "office", "campus")
"""A row of doors, furniture, desks and wide ways"""


@dataclass(frozen=True, kw_only=True)
class SafetyStudy(Study):
    """Hostile sticks (random, adversarial, held) at chairs that are worse than they should be: collisions per 100 km.

    Runs that are there already in the output folder are not driven again.
    """

    name = "safety"
    title = "hostile sticks, and chairs that are not as they should be"

    arms: Annotated[tuple[str, ...], Option("As of study driving; none is the rival.", flag="--assistants")] = (
        "none",
        "supervisor",
    )
    conditions: Annotated[tuple[str, ...], Option(f"Of {', '.join(CONDITIONS)}.")] = tuple(CONDITIONS)
    sticks: Annotated[tuple[str, ...], Option(f"Of {', '.join(STICKS)}.")] = STICKS
    models: Annotated[tuple[Path, ...], Option("A learned model, once a method.", flag="--model")] = ()
    courses: Annotated[tuple[str, ...], Option("Comma-separated names of courses or map .yaml files.")] = COURSES
    runs: Annotated[int, Option("Of each stick in each course, each from another place.", minimum=1, maximum=10000)] = 2
    seconds: Annotated[int, Option("Of each run, or until something is touched.", minimum=10, maximum=100000)] = 300

    errands: Annotated[
        int,
        Option("Drivers of each errand (doors, the standard course, people): what caution costs; 0: none.", minimum=0),
    ] = 10

    def __post_init__(self) -> None:
        super().__post_init__()
        require_arms(self.arms)
        require_known("condition", self.conditions, tuple(CONDITIONS))
        require_known("stick", self.sticks, STICKS)


@dataclass(frozen=True, eq=False)
class SafetyResult:
    """Each run with its counts, in the order of the study."""

    study: SafetyStudy
    runs: tuple[HostileRun, ...]
    counts: tuple[HostileCounts, ...]
    errands: tuple[Errand, ...] = ()

    def errands_of(self, errand: str, arm: str) -> list[Errand]:
        """In the order of the drivers."""
        return [one for one in self.errands if (one.errand, one.arm) == (errand, arm)]

    def of(self, **about: str) -> list[HostileCounts]:
        """Of the runs that are about this: arm, condition, stick or course."""
        pairs = zip(self.runs, self.counts, strict=True)
        return [counts for run, counts in pairs if about.items() <= run.about().items()]


def run_safety_study(study: SafetyStudy, folder: Path, tell: StageProgress = silent) -> SafetyResult:
    """Drives all, keeping each run's counts in `folder`. ValueError and ModelError as models_by_method; ValueError for
    an arm without its model."""
    models = models_by_method(study.models)
    runs = tuple(
        HostileRun(
            arm=arm,
            condition=condition,
            stick=stick,
            course=course,
            seed=study.seed + k,
            seconds=float(study.seconds),
            models=models,
            folder=folder / "runs",
        )
        for condition in study.conditions
        for arm in study.arms
        for course in study.courses
        for stick in study.sticks
        for k in range(study.runs)
    )
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    counts = run_jobs(runs, partial(tell, "drive"), study.processes)
    if study.errands == 0:
        return SafetyResult(study, runs, counts)
    errand = partial(tell, "errands")
    errands = run_errands(study.arms, models, study.errands, study.seed, errand, study.processes)
    return SafetyResult(study, runs, counts, errands)
