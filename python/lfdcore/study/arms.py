"""Arms of studies that drive: which assistant each name stands for, and the models they need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from lfdcore.control import DynamicWindowConfig
from lfdcore.errors import ModelError
from lfdcore.simulated.courses import Course, course_by_name
from lfdcore.simulated.drivers import Driver, ImpairedConfig, ImpairedDriver
from lfdcore.simulated.run import RunConfig
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DriveAssistantConfig,
    DynamicWindowAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.models import Model, load_model
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

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
    chair = run.geometry
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
    require_known("assistant", arms, ARMS + FOOTNOTE_ARMS)


def require_known(kind: str, names: Sequence[str], known: Sequence[str]) -> None:
    """ValueError without a name, for one that is not among `known` or there twice."""
    for name in names:
        if name not in known:
            raise ValueError(f"{kind} is '{name}', must be one of {', '.join(known)}")
    require_once(kind, names)


def require_once(kind: str, names: Sequence[str]) -> None:
    """ValueError without a name or for one that is there twice: each is compared with the others."""
    if not names:
        raise ValueError(f"there is no {kind}, must be at least one")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"{kind} '{twice[0]}' is given {names.count(twice[0])} times, must be given once")


def courses_by_name(names: Sequence[str], seed: int) -> tuple[Course, ...]:
    """The courses that a study drives, those in maps with a route drawn from `seed`. ValueError without one, for one
    that is unknown or there twice."""
    courses = tuple(course_by_name(name, seed) for name in names)
    require_once("course", [course.name for course in courses])
    return courses


def impaired_driver(config: ImpairedConfig, course: Course) -> Driver:
    return ImpairedDriver(course, config)
