"""The models of study learning-curve, by the number of runs. They and the logs that they learn from lie in
FOLDER/seed-S, where a second study finds them. Delete that folder to learn anew."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lfdcore.datasets import DriveLog, open_log
from lfdcore.progress import StageProgress, silent
from lfdcore.study.arms import StudyModels
from lfdcore.study.demonstrations import demonstrate_in_mazes
from lfdcore.study.learning_curve.study import METHODS, LearningCurveStudy
from lfdcore.training.drive_primitives import first_share, learn_drive

if TYPE_CHECKING:
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig


def models_folder(study: LearningCurveStudy, folder: Path) -> Path:
    """Of a study's models and logs."""
    return folder / f"seed-{study.seed}"


def model_files(study: LearningCurveStudy, folder: Path, runs: int) -> StudyModels:
    """Of the models that are learned from so many runs."""
    models, end = models_folder(study, folder), f"{runs:02d}.safetensors"
    return StudyModels(
        primitives=models / f"primitives-{end}",
        heatmaps=models / f"heatmaps-{study.epochs_of(runs)}-epochs-{end}",
    )


def learn_curve_models(study: LearningCurveStudy, folder: Path, tell: StageProgress = silent) -> None:
    """Both models of each number of runs, where there are none yet. Needs torch then."""
    models = models_folder(study, folder)
    models.mkdir(parents=True, exist_ok=True)
    files = {n: model_files(study, folder, n) for n in study.runs}
    missing = [n for n in study.runs if not all(_path(files[n], method).exists() for method in METHODS)]
    if not missing:
        return
    import torch  # noqa: F401 - where it is missing, before anything is driven

    drives = demonstrate_in_mazes(
        models, study.seed, missing[-1], study.run, study.processes, partial(tell, "demonstrate")
    )
    logs = [open_log(path) for path in drives.paths]
    for done, n in enumerate(missing):
        tell("learn", done, len(missing))
        _learn(study, logs[:n], files[n], tell)
    tell("learn", len(missing), len(missing))


def _path(models: StudyModels, method: str) -> Path:
    path = models.file(method)
    assert path is not None
    return path


def _learn(study: LearningCurveStudy, logs: Sequence[DriveLog], files: StudyModels, tell: StageProgress) -> None:
    from lfdcore.training.drive_heatmaps import learn_heatmaps

    if not _path(files, "primitives").exists():
        learn_drive(first_share(logs)).save(_path(files, "primitives"))
    if not _path(files, "heatmaps").exists():
        stages = {"targets": f"targets of {len(logs)} runs", "network": f"network of {len(logs)} runs"}
        config = _heatmap_config(study.epochs_of(len(logs)))
        learned = learn_heatmaps(logs, config, lambda stage, done, total: tell(stages[stage], done, total))
        learned.model.save(_path(files, "heatmaps"))


def _heatmap_config(epochs: int) -> HeatmapLearningConfig:
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig
    from lfdcore.training.parts.heatmap_net import HeatmapNetConfig

    return HeatmapLearningConfig(network=HeatmapNetConfig(epochs=epochs, patience=epochs))
