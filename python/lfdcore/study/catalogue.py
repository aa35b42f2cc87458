"""All studies by the names of their commands; each is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from lfdcore.progress import StageProgress
from lfdcore.study.study import Findings, Study

Run = Callable[[Any, Path, StageProgress], Findings]
"""Runs a config with a folder of its own, reports progress -> what was found"""

STUDIES = {
    "driving": "DrivingStudy",
    "goals": "GoalStudy",
    "passing": "PassingStudy",
    "covering": "CoveringStudy",
    "joints": "JointSpaceStudy",
    "handovers": "HandoverStudy",
    "sequences": "SequenceStudy",
    "learning-curve": "LearningCurveStudy",
    "adaptation": "AdaptationStudy",
    "backwards": "BackwardsStudy",
    "safety": "SafetyStudy",
}
"""Command -> config, in lfdcore.study.COMMAND.study; lfdcore.study.COMMAND.report has `run`."""


def load_study(name: str) -> tuple[type[Study], Run]:
    """-> config and run of a study in STUDIES."""
    folder = f"lfdcore.study.{name.replace('-', '_')}"
    return getattr(import_module(f"{folder}.study"), STUDIES[name]), import_module(f"{folder}.report").run
