"""Demonstrations: an expert drives the training courses; the assistant learns from what was recorded (Sec. 3.5)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lfdcore.datasets import open_log
from lfdcore.study.courses import Course, training_courses
from lfdcore.study.drivers import ExpertDriver
from lfdcore.study.prediction import learn_from_logs
from lfdcore.study.runner import RunConfig, run_drive
from lfdcore.study.trace import DriveTrace
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.model_file import LearningConfig

MODEL_NAME = "assistant.safetensors"
ATTEMPTS = 5
"""of an expert at a demonstration"""


def demonstrate(folder: Path, seed: int, config: RunConfig | None = None) -> list[tuple[Path, DriveTrace]]:
    """One expert run through each training course, unassisted -> drive logs in `folder` and their traces.

    An expert who touches anything or does not arrive drives again: nobody should learn from that. Raises RuntimeError
    if the last of ATTEMPTS (seeds `seed`, `seed` + 1000, ...) fails too.
    """
    return [
        _demonstrated(course, folder / f"demonstration-{course.name}.mcap", seed, config)
        for course in training_courses()
    ]


def _demonstrated(course: Course, path: Path, seed: int, config: RunConfig | None) -> tuple[Path, DriveTrace]:
    for attempt in range(ATTEMPTS):
        trace = run_drive(course, ExpertDriver(course), Unassisted(), seed + 1000 * attempt, config, path)
        if trace.completed and not trace.collision.any():
            return path, trace
    raise RuntimeError(
        f"the last of {ATTEMPTS} demonstrations in {course.name} from seed {seed} on ended '{trace.outcome}' after "
        f"{int(trace.collision.sum())} contacts"
    )


def learn_from_demonstrations(
    folder: Path,
    seed: int,
    config: LearningConfig | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Demonstrates, learns and saves the model in `folder` -> its path."""
    logs = [open_log(path) for path, _ in demonstrate(folder, seed)]
    model = learn_from_logs(logs, config=config, progress=progress)
    path = folder / MODEL_NAME
    model.save(path)
    return path
