"""Prediction a posteriori along real logs (Sec. 3.5.2, Fig. 3.16): what models predict, judged on what was driven.

The metric and the baselines are those of path_error. Where a model predicts nothing, straight on stands in. Compliance
along a log is that of Sec. 3.5.2: a path point p that was predicted at t is compliant if the model's compliance of
(p', Y), p' being p seen from where the chair was and Y the stick there, is at least .9 at any instant from t on at
which p' lies within the look-ahead that compliance is defined for (and, so that a later visit to the same place does
not count, before the robot has driven the path's reach and the look-ahead).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Pose2, arc_length
from lfdcore.progress import Progress
from lfdcore.study.prediction import path_error
from lfdcore.study.prediction.path_error import ARC, REACH, PathSamples, at_arc_lengths, path_samples
from lfdcore.training.drive_primitives import LearningConfig, first_share, learn_drive
from lfdcore.wheelchair.method import Predictor
from lfdcore.wheelchair.paths import distance_to_polyline
from lfdcore.wheelchair.planner import COMPLIANT_FROM, Judge
from lfdcore.wheelchair.primitives.prediction import PathPredictionConfig, PathPredictor
from lfdcore.wheelchair.stick import StickMeaning, with_stick

Array = NDArray[np.float64]

STRAIGHT, ARC_ON = "straight", "constant arc"
BLOCK = 2 * REACH
"""[m] of way whose samples are drawn together: paths of 2.5 m that start farther apart share nothing"""


TRAINING, SHARE = "freiburg-079-corrected.log.gz", 0.7
"""The log of docs/real-logs.md to learn from, and the first share of its scans that is learned"""
OTHERS = (
    "fhw-corrected.log.gz",
    "aces-corrected.log.gz",
    "freiburg-101-corrected.log.gz",
    "sena-wheelchair-one-loop.rawlog",
)
"""Logs never learned from; seattle-corrected.log.gz is for the final table only"""


@dataclass(frozen=True)
class ErrorRow:
    """One predictor's path error up to one reach; intervals: 95 %, of the mean, by block bootstrap."""

    predictor: str
    reach: float
    """[m]"""
    n: int
    mean: float
    """[m]"""
    low: float
    high: float
    median: float
    """[m]"""
    difference: float
    """[m] mean of the paired difference to the better baseline (the one of smaller mean), < 0: better; 0 for itself"""
    difference_low: float
    difference_high: float
    ratio: float
    """of the mean to the better baseline's"""
    ratio_low: float
    ratio_high: float
    baseline: str
    """which baseline is the better one"""


@dataclass(frozen=True)
class ModelPaths:
    """What one model predicts at the N samples of a log."""

    paths: Array
    """(N, 25, 2) [m] at ARC, in base_link at the scan"""
    missing: NDArray[np.bool_]
    """(N,) where it predicts nothing and straight on stands in"""
    compliant: NDArray[np.bool_] | None
    """(N, 25) path points that agree with a later input (Sec. 3.5.2), False where nothing was predicted; None for a
    model that knows no compliance (naive)"""
    deviation: Array
    """(N, 25) [m] of the way driven from each path point"""
    stick: str
    """what the stick was"""

    @property
    def rmse(self) -> float:
        """[m] of the way driven from the compliant path points; NaN without any"""
        if self.compliant is None or not self.compliant.any():
            return float("nan")
        return float(np.sqrt((self.deviation[self.compliant] ** 2).mean()))

    @property
    def compliant_share(self) -> float | None:
        """Of the path points; None without any, or for a model that knows no compliance"""
        return float(self.compliant.mean()) if self.compliant is not None and self.compliant.size else None


@dataclass(frozen=True)
class LogPrediction:
    """All models along one log."""

    log: DriveLog
    samples: PathSamples
    models: dict[str, ModelPaths]

    @property
    def outcome(self) -> str:
        """Empty, or in one line why nothing could be judged."""
        if len(self.samples):
            return ""
        scans, records = len(self.log.scan_stamp), len(self.log.odometry_stamp)
        return (
            f"no sample in {scans} scans and {records} odometry records: they share no clock, "
            f"or the robot never drives {REACH} m forward at {path_error.SLOWEST} m/s or more"
        )

    def predicted(self) -> dict[str, Array]:
        """Baselines and models -> (N, 25, 2) [m]"""
        velocity = self.samples.velocity
        baselines = {STRAIGHT: path_error.straight(velocity), ARC_ON: path_error.constant_arc(velocity)}
        return baselines | {name: model.paths for name, model in self.models.items()}


def predict_log(
    log: DriveLog,
    predictors: Mapping[str, Predictor],
    meaning: StickMeaning = StickMeaning.demonstrated,
    progress: Progress | None = None,
) -> LogPrediction:
    """Asks every predictor, of whatever method, at every sample of a log; progress(done, total) counts predictions.

    A log without samples (no scans, no odometry, no common clock, standing still) gives one with an `outcome`.
    ValueError for a laser that lies outside the local window.
    """
    usable = len(log.scan_stamp) and len(log.odometry_stamp) > 1
    samples = path_samples(log) if usable else _no_samples()
    tell = _Counter(progress or (lambda done, of: None), len(samples) * len(predictors))
    found = {name: _along_log(log, samples, one, meaning, tell) for name, one in predictors.items()}
    return LogPrediction(log, samples, found)


class _Counter:
    """Tells how many predictions are done, of all models together"""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._done = progress, total, 0
        progress(0, total)

    def __call__(self) -> None:
        self._done += 1
        self._progress(self._done, self._total)


def predict_real_logs(
    folder: Path,
    others: Sequence[str] = OTHERS,
    thesis: bool = False,
    meaning: StickMeaning = StickMeaning.demonstrated,
) -> list[LogPrediction]:
    """The run of docs/real-logs.md on a folder of logs: learns on the first 70 % of freiburg-079 by scan, predicts on
    its rest and on `others`; `thesis`: the printed form of learning and prediction."""
    log = _opened(folder / TRAINING)
    model = learn_drive(first_share([log], SHARE), LearningConfig.thesis() if thesis else None)
    predictor = PathPredictor(model, PathPredictionConfig.thesis() if thesis else None)
    judged = [log.share(SHARE, 1.0), *(_opened(folder / name) for name in others)]
    return [predict_log(one, {"thesis" if thesis else "default": predictor}, meaning) for one in judged]


def _no_samples() -> PathSamples:
    return PathSamples(np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, len(ARC), 2)))


def _along_log(
    log: DriveLog, samples: PathSamples, predictor: Predictor, meaning: StickMeaning, tell: Callable[[], None]
) -> ModelPaths:
    driven = with_stick(log, predictor.model, meaning)
    paths, missing = predicted_paths(predictor, driven, samples, tell)
    compliant = None
    if predictor.compliance is not None:
        compliant = compliant_points(driven, samples, paths, predictor.compliance) & ~missing[:, None]
    stick = driven.metadata.get("joystick", "as recorded")
    return ModelPaths(paths, missing, compliant, _deviations(paths, samples.driven), stick)


def predicted_paths(
    predictor: Predictor, log: DriveLog, samples: PathSamples, tell: Callable[[], None] | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """At the N samples of a log with a joystick: paths (N, 25, 2) [m] at ARC, and (N,) where nothing is predicted and
    straight on stands in. `tell` is called after each."""
    sticks = log.joystick_at(log.scan_stamp)
    paths, missing = path_error.straight(samples.velocity), np.zeros(len(samples), bool)
    for k, i in enumerate(samples.scan):
        path = predictor.predict(sticks[i], log.scan(int(i)), log.mounting)
        missing[k] = path is None
        if path is not None:
            paths[k] = at_arc_lengths(path)
        if tell is not None:
            tell()
    return paths, missing


def compliant_points(log: DriveLog, samples: PathSamples, paths: Array, judge: Judge) -> NDArray[np.bool_]:
    """Which points of the paths (N, A, 2) predicted at the samples agree with an input from then on -> (N, A); see the
    module. The inputs are those at the log's scans."""
    compliant = np.zeros(paths.shape[:2], bool)
    if not len(samples):
        return compliant
    look_ahead = judge.look_ahead
    poses, sticks = log.pose_at(log.scan_stamp), log.joystick_at(log.scan_stamp)
    way = way_driven(log)
    inputs = np.flatnonzero(np.hypot(*sticks.T) > 0)
    ends = np.searchsorted(way, way[samples.scan] + REACH + look_ahead, side="right")
    points = np.array([Pose2(*poses[i]).transform(path) for i, path in zip(samples.scan, paths, strict=True)])
    for i in inputs:
        open_ = np.flatnonzero((samples.scan <= i) & (i < ends))
        seen = Pose2(*poses[i]).inverse().transform(points[open_].reshape(-1, 2))
        distance = np.hypot(*seen.T)
        near = (distance <= look_ahead) & (distance > 1e-6)
        if near.any():
            agrees = np.zeros(len(seen), bool)
            agrees[near] = judge.compliances(seen[near], sticks[i]) >= COMPLIANT_FROM
            compliant[open_] |= agrees.reshape(len(open_), -1)
    return compliant


def way_driven(log: DriveLog) -> Array:
    """(S,) [m] driven up to each scan by odometry"""
    return np.asarray(np.interp(log.scan_stamp, log.odometry_stamp, arc_length(log.pose[:, :2])))


def _deviations(paths: Array, driven: Array) -> Array:
    """(N, A) [m] from each path point to the way driven over the same reach, a polyline from base_link on."""
    ways = (np.vstack([[0.0, 0.0], way]) for way in driven)
    found = [distance_to_polyline(path, way) for path, way in zip(paths, ways, strict=True)]
    return np.array(found).reshape(paths.shape[:2])


def _opened(path: Path) -> DriveLog:
    """A log of the collection. Seattle's does not say where its scanner is; those of the others are within 4 cm of the
    axle, and so little changes no figure by more than its interval."""
    log = open_log(path)
    return log if log.T_base_laser is not None else replace(log, T_base_laser=Pose2())
