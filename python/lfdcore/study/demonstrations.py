"""Demonstrations: an expert drives the training courses; the assistant learns from what was recorded (Sec. 3.5)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lfdcore.datasets import open_log
from lfdcore.study.courses import training_courses
from lfdcore.study.drivers import ExpertDriver
from lfdcore.study.runner import RunConfig, run_drive
from lfdcore.study.trace import DriveTrace
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.model_file import LearningConfig, learn_drive

MODEL_NAME = "assistant.safetensors"


def demonstrate(folder: Path, seed: int, config: RunConfig | None = None) -> list[tuple[Path, DriveTrace]]:
    """One expert run through each training course, unassisted -> drive logs in `folder` and their traces.

    Raises RuntimeError if the expert fails or touches anything: nobody should learn from that.
    """
    done = []
    for course in training_courses():
        path = folder / f"demonstration-{course.name}.mcap"
        trace = run_drive(course, ExpertDriver(course), Unassisted(), seed, config, path)
        if not trace.completed or trace.collision.any():
            raise RuntimeError(
                f"the demonstration in {course.name} with seed {seed} ended '{trace.outcome}' after "
                f"{int(trace.collision.sum())} contacts"
            )
        done.append((path, trace))
    return done


def learn_from_demonstrations(
    folder: Path,
    seed: int,
    config: LearningConfig | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Demonstrates, learns and saves the model in `folder` -> its path."""
    logs = [open_log(path) for path, _ in demonstrate(folder, seed)]
    model = learn_drive(logs, config or LearningConfig(), progress=progress)
    path = folder / MODEL_NAME
    model.save(path)
    return path
