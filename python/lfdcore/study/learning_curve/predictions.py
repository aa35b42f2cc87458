"""Predicted paths of study learning-curve: what each model predicts along drives of able drivers, beside baselines.

The path predicted at a scan is judged against the one driven (study/prediction/path_error.py), the mean over a run
being one value. Primitives predict by PathPredictor, heatmaps by ProductPredictor: what is planned over (`driver_sd`:
docs/heatmaps.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from lfdcore.datasets import DriveLog, open_log
from lfdcore.progress import StageProgress, silent
from lfdcore.study.demonstrations import drive_to_destinations
from lfdcore.study.learning_curve.models import model_files, models_folder
from lfdcore.study.learning_curve.study import METHODS, LearningCurveStudy
from lfdcore.study.prediction.path_error import (
    REACH,
    Array,
    PathSamples,
    constant_arc,
    path_errors,
    path_samples,
    straight,
)
from lfdcore.study.prediction.study import ARC_ON, STRAIGHT, predicted_paths
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.prediction import ProductPredictor
from lfdcore.wheelchair.method import Predictor

PredictAll = Callable[[DriveLog, PathSamples], Array]
"""The paths (N, 25, 2) [m] predicted at samples of a log."""
BASELINES: dict[str, PredictAll] = {
    STRAIGHT: lambda log, samples: straight(samples.velocity),
    ARC_ON: lambda log, samples: constant_arc(samples.velocity),
}


def prediction_rows(study: LearningCurveStudy, folder: Path, tell: StageProgress = silent) -> list[dict[str, Any]]:
    """Drives unassisted and predicts with models that have been learned -> a row a log and model (or baseline: of 0
    demonstrations): demonstrations, method, log, samples, error [m]."""
    judged = _driven(study, folder, tell)
    models = [(n, method) for n in study.runs for method in METHODS]
    tell("predict paths", 0, len(models))
    rows = [row for name, predict in BASELINES.items() for row in _errors(0, name, predict, judged)]
    for done, (n, method) in enumerate(models, 1):
        rows += _errors(n, method, _with_model(_predictor(study, folder, n, method)), judged)
        tell("predict paths", done, len(models))
    return rows


def _driven(study: LearningCurveStudy, folder: Path, tell: StageProgress) -> list[tuple[DriveLog, PathSamples]]:
    """Logs with samples to be judged."""
    drives = drive_to_destinations(
        models_folder(study, folder),
        study.seed,
        study.predicted,
        study.run,
        study.processes,
        partial(tell, "drive to destinations"),
    )
    found = [(log, _thinned(path_samples(log), study.every)) for log in map(open_log, drives.paths)]
    return [(log, samples) for log, samples in found if len(samples)]


def _thinned(samples: PathSamples, every: int) -> PathSamples:
    return PathSamples(samples.scan[::every], samples.velocity[::every], samples.driven[::every])


def _errors(
    n: int, method: str, predict: PredictAll, judged: Sequence[tuple[DriveLog, PathSamples]]
) -> list[dict[str, Any]]:
    return [
        {
            "demonstrations": n,
            "method": method,
            "log": log.name,
            "samples": len(samples),
            "error": float(path_errors(predict(log, samples), samples.driven, REACH).mean()),
        }
        for log, samples in judged
    ]


def _predictor(study: LearningCurveStudy, folder: Path, runs: int, method: str) -> Predictor:
    """Primitives predict with their method's predictor, heatmaps with what is planned over."""
    models = model_files(study, folder, runs)
    if method == "primitives":
        return models.of(method).predictor()
    heatmaps = models.file(method)
    assert heatmaps is not None
    return ProductPredictor(HeatmapModel.load(heatmaps).planner(study.run.geometry))


def _with_model(predictor: Predictor) -> PredictAll:
    return lambda log, samples: predicted_paths(predictor, log, samples)[0]
