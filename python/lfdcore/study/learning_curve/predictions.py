"""Predicted paths of study learning-curve: what each model predicts along drives of able drivers, beside baselines.

The path predicted at a scan is judged against the one driven (study/prediction/path_error.py), the mean over a run
being one value. The product of the heatmaps predicts by heatmap_path, primitives by PathPredictor; both as they are for
driving (`driver_sd`: docs/heatmaps.md).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lfdcore.datasets import DriveLog, open_log
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import local_grid
from lfdcore.study.demonstrations import drive_to_destinations
from lfdcore.study.learning_curve.models import model_files, models_folder
from lfdcore.study.learning_curve.study import METHODS, LearningCurveStudy
from lfdcore.study.prediction.path_error import (
    REACH,
    Array,
    PathSamples,
    at_arc_lengths,
    constant_arc,
    path_errors,
    path_samples,
    straight,
)
from lfdcore.study.prediction.study import ARC_ON, STRAIGHT
from lfdcore.study.study import Progress, silent
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.path import heatmap_path
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import Observation
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.prediction import PathPredictor

PredictAll = Callable[[DriveLog, PathSamples], Array]
"""The paths (N, 25, 2) [m] predicted at samples of a log."""
Predict = Callable[[DriveLog, int], Array | None]
"""The path (M, 2) [m] predicted at a scan of a log."""
BASELINES: dict[str, PredictAll] = {
    STRAIGHT: lambda log, samples: straight(samples.velocity),
    ARC_ON: lambda log, samples: constant_arc(samples.velocity),
}


def prediction_rows(study: LearningCurveStudy, folder: Path, tell: Progress = silent) -> list[dict[str, Any]]:
    """Drives unassisted and predicts with models that have been learned -> a row a log and model (or baseline: of 0
    demonstrations): demonstrations, method, log, samples, error [m]."""
    judged = _driven(study, folder, tell)
    models = [(n, method) for n in study.runs for method in METHODS]
    tell("predict paths", 0, len(models))
    rows = [row for name, predict in BASELINES.items() for row in _errors(0, name, predict, judged)]
    for done, (n, method) in enumerate(models, 1):
        model = model_files(study, folder, n).of(method)
        rows += _errors(n, method, partial(_paths_of, _predictor(study, model)), judged)
        tell("predict paths", done, len(models))
    return rows


def _driven(study: LearningCurveStudy, folder: Path, tell: Progress) -> list[tuple[DriveLog, PathSamples]]:
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


def _paths_of(predict: Predict, log: DriveLog, samples: PathSamples) -> Array:
    """Straight on where nothing is predicted."""
    paths = straight(samples.velocity)
    for k, scan in enumerate(samples.scan):
        path = predict(log, int(scan))
        if path is not None:
            paths[k] = at_arc_lengths(path)
    return paths


def _predictor(study: LearningCurveStudy, model: DriveAssistantModel | HeatmapModel) -> Predict:
    if isinstance(model, HeatmapModel):
        return partial(_path_by_heatmaps, HeatmapPlanner(model, HeatmapPlannerConfig(), study.run.geometry))
    return partial(_path_by_primitives, PathPredictor(model))


def _stick(log: DriveLog, scan: int) -> Array:
    return np.asarray(log.joystick_at(log.scan_stamp[scan : scan + 1])[0])


def _path_by_primitives(predictor: PathPredictor, log: DriveLog, scan: int) -> Array | None:
    return predictor.predict(_stick(log, scan), log.scan(scan), log.T_base_laser)


def _path_by_heatmaps(planner: HeatmapPlanner, log: DriveLog, scan: int) -> Array | None:
    stamp, (forward, left) = float(log.scan_stamp[scan]), _stick(log, scan)
    pose, twist = Pose2(*log.pose_at([stamp])[0]), Twist2(*log.twist_at([stamp])[0])
    seen = Observation(stamp, log.scan(scan), stamp, pose, twist, (float(forward), float(left)))
    heat = planner.heat(seen, local_grid(seen.scan, log.T_base_laser))
    return None if heat is None else heatmap_path(heat.intent)
