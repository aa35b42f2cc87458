"""Backwards with a scanner that sees all around (Sec. 6.2.1): reversing drivers in the hall, by assistant."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from lfdcore.simulated.courses import Course, hall
from lfdcore.simulated.drivers import AbleConfig, Driver, ImpairedConfig, able_population, population
from lfdcore.simulated.reversing_driver import ImpairedReversingDriver, ReversingConfig, ReversingDriver, facing_back
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.trace import DriveTrace
from lfdcore.simulation import LidarConfig
from lfdcore.study.arms import StudyModels, make_assistant, require_once
from lfdcore.study.jobs import run_jobs
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant

AROUND = LidarConfig(beams=361, field_of_view=2 * math.pi)
ARMS = ("none", "supervisor", "dwa_1s", "two_way")
"""two_way: the heatmaps' assistant for a stick that points behind too; the others as in the driving study."""
DRIVERS = ("able", "impaired")


@dataclass(frozen=True, kw_only=True)
class BackwardsStudy:
    """Driver k of each population drives the hall backwards in every arm with seed `seed` + k."""

    heatmaps: Path | None
    """File of the model; None where no arm needs one"""
    arms: tuple[str, ...] = ARMS
    kinds: tuple[str, ...] = DRIVERS
    drivers: int = 10
    seed: int = 1


def require_arms(arms: Sequence[str]) -> None:
    """ValueError without an arm, for one that is unknown or there twice."""
    for arm in arms:
        if arm not in ARMS:
            raise ValueError(f"assistant is '{arm}', must be one of {', '.join(ARMS)}")
    require_once("assistant", arms)


def backwards_course() -> Course:
    """What is driven."""
    return facing_back(hall())


def run_backwards_study(
    study: BackwardsStudy, progress: Callable[[int, int], None] | None = None, processes: int | None = None
) -> tuple[DriveTrace, ...]:
    """One run a kind of driver, arm and driver, in that order. ValueError for an unknown arm or kind, or without a
    model that an arm needs; ModelError for a file that holds no heatmaps."""
    models, run, course = StudyModels(heatmaps=study.heatmaps), RunConfig(lidar=AROUND), backwards_course()
    require_arms(study.arms)
    for arm in study.arms:
        _assistant(arm, models, run)  # refused before anything is driven
    jobs = [
        Job(course, driver, partial(_assistant, arm, models, run), study.seed + k, run)
        for kind in study.kinds
        for arm in study.arms
        for k, driver in enumerate(_drivers(kind, study.drivers, study.seed))
    ]
    return run_jobs(jobs, progress, processes)


def _drivers(kind: str, n: int, seed: int) -> list[Callable[[Course], Driver]]:
    if kind == "able":
        return [partial(_able, config) for config in able_population(n, seed)]
    if kind == "impaired":
        return [partial(impaired_driver, config) for config in population(n, seed)]
    raise ValueError(f"driver is '{kind}', must be one of {', '.join(DRIVERS)}")


def _able(config: AbleConfig, course: Course) -> Driver:
    """As drawn, but for the speed."""
    own = ReversingConfig(look_ahead=config.look_ahead, delay=config.delay, noise_sd=config.noise_sd)
    return ReversingDriver(course, own)


def impaired_driver(config: ImpairedConfig, course: Course) -> Driver:
    return ImpairedReversingDriver(course, config)


def _assistant(arm: str, models: StudyModels, run: RunConfig) -> Assistant:
    return TwoWayAssistant(models.of("heatmaps")) if arm == "two_way" else make_assistant(arm, models, run)
