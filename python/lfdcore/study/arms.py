"""Arms of studies that drive: which assistant each name stands for, and the models they need."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from lfdcore.control import DynamicWindowConfig
from lfdcore.errors import ModelError
from lfdcore.simulated.courses import Course, course_by_name
from lfdcore.simulated.run import RunConfig
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DriveAssistantConfig,
    DynamicWindowAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.method import MethodModel
from lfdcore.wheelchair.models import DRIVING, load_model
from lfdcore.wheelchair.planner import Planner

ARMS = ("none", "dwa", "primitives", "heatmaps")
"""Assistants of the study, the unassisted arm first."""


FOOTNOTE_ARMS = ("dwa_1s", "thesis", "heatmaps_thesis", "supervisor")
"""On request: DWA that looks no farther than its goal, primitives and heatmaps learned by default and driven as printed
(the loops of Ch. 3 and Ch. 4), and the bare supervisor on the driver's own input."""


PRINTED = {"thesis": "primitives", "heatmaps_thesis": "heatmaps"}
"""Arms that plan and drive as printed, by their method. Their models are learned by default."""
METHODS = {method: method for method in DRIVING} | PRINTED
"""Learned arms by the method whose model they need: one that is named as any method drives with that method."""
KNOWN_ARMS = tuple(dict.fromkeys((*ARMS, *FOOTNOTE_ARMS, *METHODS)))


class StudyModels:
    """Files of learned models by method, as in StudyModels(primitives=path); None where no arm needs one."""

    def __init__(self, **files: Path | None) -> None:
        for method in files:
            if method not in DRIVING:
                raise ValueError(f"method is '{method}', must be one that drives: {', '.join(DRIVING)}")
        self._files = {method: path for method, path in files.items() if path is not None}

    def file(self, method: str) -> Path | None:
        """Of a method's model; None without one."""
        return self._files.get(method)

    def and_file(self, method: str, path: Path) -> StudyModels:
        """These, and a method's model."""
        return StudyModels(**{**self._files, method: path})

    def of(self, arm: str) -> MethodModel:
        """The model that drives in an arm. ValueError without one; ModelError as load_model, and for a file that holds
        a model of another method."""
        method = METHODS[arm]
        path = self.file(method)
        if path is None:
            raise ValueError(f"assistant '{arm}' needs a model of method {method}, there is none")
        model = _model(path)
        if model.method != method:
            raise ModelError(f"{path} holds a model of method {model.method}, must be one of {method}")
        return model


def models_by_method(paths: Sequence[Path]) -> StudyModels:
    """Files of models, in any order. ValueError for two of one method or one that drives nothing; ModelError as
    load_model."""
    found: dict[str, Path] = {}
    for path in paths:
        model = _model(path)
        if not model.drives:
            raise ValueError(f"{path} holds a {model.kind.removeprefix('lfdcore ')}, which drives nothing")
        method = model.method
        if method in found:
            raise ValueError(f"{found[method]} and {path} are both models of method {method}, one is needed")
        found[method] = path
    return StudyModels(**found)


@lru_cache(maxsize=4)
def _model(path: Path) -> MethodModel:
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
    require_arms([arm])
    config = DriveAssistantConfig.thesis() if arm in PRINTED else DriveAssistantConfig()
    return DriveAssistant(_planner(arm, models, run), config, arm)


def planners(arms: Sequence[str], models: StudyModels, run: RunConfig) -> dict[str, Planner]:
    """Of each learned arm among `arms`: what says whether a driver's input complied with a path."""
    return {arm: _planner(arm, models, run) for arm in arms if arm in METHODS}


def _planner(arm: str, models: StudyModels, run: RunConfig) -> Planner:
    return models.of(arm).planner(run.geometry, thesis=arm in PRINTED)


def require_arms(arms: Sequence[str]) -> None:
    """ValueError without an arm, for one that is unknown, empty or there twice."""
    require_known("assistant", arms, KNOWN_ARMS)


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
