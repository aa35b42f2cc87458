"""Backwards with a scanner that sees all around (Sec. 6.2.1): reversing drivers in the hall, by assistant."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.courses import Course, hall
from lfdcore.simulated.drivers import AbleConfig, Driver, able_population, population
from lfdcore.simulated.reversing_driver import ImpairedReversingDriver, ReversingConfig, ReversingDriver, facing_back
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.trace import DriveTrace
from lfdcore.simulation import LidarConfig
from lfdcore.study.arms import StudyModels, make_assistant, require_known
from lfdcore.study.demonstrations import HeatmapsFile, heatmaps_or_learned
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Study
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant

AROUND = LidarConfig(beams=361, field_of_view=2 * math.pi)
ARMS = ("none", "supervisor", "dwa_1s", "two_way")
"""two_way: the heatmaps' assistant for a stick that points behind too; the others as in the driving study."""
DRIVERS = ("able", "impaired")


@dataclass(frozen=True, kw_only=True)
class BackwardsStudy(Study):
    """Drivers who go backwards through a hall, 360-degree scanner: collisions, time and paths by assistant."""

    name = "backwards"
    title = "backwards with a scanner that sees all around (Sec. 6.2.1)"

    model: HeatmapsFile = None
    arms: Annotated[tuple[str, ...], Option(f"Of {', '.join(ARMS)} (the heatmaps').", flag="--assistants")] = ARMS
    drivers: Annotated[int, Option("Simulated drivers of each kind.", minimum=1)] = 10
    kinds: tuple[str, ...] = DRIVERS

    def __post_init__(self) -> None:
        super().__post_init__()
        require_known("assistant", self.arms, ARMS)
        require_known("driver", self.kinds, DRIVERS)


def backwards_course() -> Course:
    """What is driven."""
    return facing_back(hall())


def run_backwards_study(study: BackwardsStudy, folder: Path, tell: StageProgress = silent) -> tuple[DriveTrace, ...]:
    """Driver k of each population drives the hall backwards in every arm with seed `seed` + k -> one run a kind of
    driver, arm and driver, in that order. A model that an arm needs and that is not given is learned in `folder`.

    ValueError for a model of another method.
    """
    models, run, course = StudyModels(heatmaps=_model(study, folder, tell)), RunConfig(lidar=AROUND), backwards_course()
    jobs = [
        Job(course, driver, partial(_assistant, arm, models, run), study.seed + k, run)
        for kind in study.kinds
        for arm in study.arms
        for k, driver in enumerate(_drivers(kind, study.drivers, study.seed))
    ]
    return run_jobs(jobs, partial(tell, "drive backwards"), study.processes)


def _model(study: BackwardsStudy, folder: Path, tell: StageProgress) -> Path | None:
    if study.model is None and "two_way" not in study.arms:
        return None
    return heatmaps_or_learned(study.model, folder, study.seed, tell, study.processes)


def _drivers(kind: str, n: int, seed: int) -> list[Callable[[Course], Driver]]:
    if kind == "able":
        return [partial(ReversingDriver, config=_faster(config)) for config in able_population(n, seed)]
    return [partial(ImpairedReversingDriver, config=config) for config in population(n, seed)]


def _faster(config: AbleConfig) -> ReversingConfig:
    """As drawn, but for the speed."""
    return ReversingConfig(look_ahead=config.look_ahead, delay=config.delay, noise_sd=config.noise_sd)


def _assistant(arm: str, models: StudyModels, run: RunConfig) -> Assistant:
    return (
        TwoWayAssistant(models.of("heatmaps"), run.geometry) if arm == "two_way" else make_assistant(arm, models, run)
    )
