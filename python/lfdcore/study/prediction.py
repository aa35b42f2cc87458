"""Prediction a posteriori along real logs (Sec. 3.5.2, Fig. 3.16): what the models foretell, judged on what was driven.

The metric and the baselines are those of path_error. Where a model predicts nothing, straight on stands in. Compliance
along a log is that of Sec. 3.5.2: a path point p that was predicted at t is compliant if the model's compliance of
(p', Y), p' being p seen from where the chair was and Y the stick there, is at least .9 at any instant from t on at
which p' lies within the look-ahead that compliance is defined for (and, so that a later visit to the same place does
not count, before the robot has driven the path's reach and the look-ahead).

What an inferred stick means. The same stick is not the same curve on two vehicles: fully ahead and fully left,
freiburg-079's robot turns 1.2 rad per metre, the wheelchair SENA .19. Read by its own limits, SENA's gentle curves
become a stick that asks for corners. `demonstrated` therefore divides the velocities of a log without a recorded
joystick by limits that stand in the demonstrations' proportion: a stick's direction means the curvature that it meant
when the model was learned. `own` divides them by the log's own limits.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import joystick_from_motion, open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import full_deflection, motion_limits, windowed_twist
from lfdcore.geometry import Pose2, Twist2, arc_length
from lfdcore.study import path_error
from lfdcore.study.path_error import ARC, REACH, REACHES, PathSamples, at_arc_lengths, path_errors, path_samples
from lfdcore.study.statistics import block_bootstrap, block_bootstrap_ratio
from lfdcore.wheelchair.heatmap_model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmap_prediction import HeatmapPathPredictor, NaivePathPredictor
from lfdcore.wheelchair.model_file import DriveAssistantModel, LearningConfig, learn_drive
from lfdcore.wheelchair.models import Model, full_deflection_of
from lfdcore.wheelchair.path_prediction import PathPredictionConfig, PathPredictor
from lfdcore.wheelchair.planner import Compliance

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

STRAIGHT, ARC_ON = "straight", "constant arc"
BLOCK = 2 * REACH
"""[m] of way whose samples are drawn together: paths of 2.5 m that start farther apart share nothing"""
COMPLIANT_FROM = 0.9


class StickMeaning(StrEnum):
    """By which limits the velocities of a log without a joystick become a stick."""

    demonstrated = "demonstrated"
    own = "own"


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


def learn_from_logs(
    logs: Sequence[DriveLog],
    share: float = 1.0,
    config: LearningConfig | None = None,
    progress: Progress | None = None,
) -> DriveAssistantModel:
    """learn_drive on the first `share` of each log's scans; a joystick that was not recorded is inferred from that
    share alone. The model's metadata keep what full deflection meant: `full_deflection` [m/s, rad/s], a pair a log."""
    drives = first_share(logs, share)
    model = learn_drive(drives, config or LearningConfig(), progress=progress)
    meant = [[*full_deflection(log)] for log in drives]
    return dataclasses.replace(model, metadata=model.metadata | {"full_deflection": meant})


def first_share(logs: Sequence[DriveLog], share: float) -> list[DriveLog]:
    """The first `share` of each log's scans, with a joystick: where none was recorded, inferred from that share."""
    return [joystick_from_motion(log.share(0.0, share)) for log in logs]


def with_stick(log: DriveLog, model: Model, meaning: StickMeaning = StickMeaning.demonstrated) -> DriveLog:
    """The log with the driver's input; recorded ones are left alone. See the module for what `meaning` decides; a
    model that does not say what full deflection meant leaves `own`."""
    wanted = None if meaning is StickMeaning.own else full_deflection_of(model)
    if wanted is None:
        return joystick_from_motion(log)
    own = motion_limits(windowed_twist(log.odometry_stamp, log.pose))
    scale = max(own.linear / wanted.linear, own.angular / wanted.angular)
    return joystick_from_motion(log, limits=Twist2(scale * wanted.linear, scale * wanted.angular))


def predict_log(
    log: DriveLog,
    models: Mapping[str, Model],
    config: PathPredictionConfig | None = None,
    meaning: StickMeaning = StickMeaning.demonstrated,
    progress: Progress | None = None,
) -> LogPrediction:
    """Runs every model, of whatever kind, at every sample of a log; progress(done, total) counts predictions. config:
    of models of path primitives.

    A log without samples (no scans, no odometry, no common clock, standing still) gives one with an `outcome`.
    ValueError for a laser that lies outside the local window.
    """
    usable = len(log.scan_stamp) and len(log.odometry_stamp) > 1
    samples = path_samples(log) if usable else _no_samples()
    tell = _Counter(progress or (lambda done, of: None), len(samples) * len(models))
    found = {name: _along_log(log, samples, model, config, meaning, tell) for name, model in models.items()}
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
    log = open_log(folder / TRAINING)
    model = learn_from_logs([log], SHARE, LearningConfig.thesis() if thesis else None)
    config = PathPredictionConfig.thesis() if thesis else None
    judged = [log.share(SHARE, 1.0), *(open_log(folder / name) for name in others)]
    return [predict_log(one, {"thesis" if thesis else "default": model}, config, meaning) for one in judged]


def _no_samples() -> PathSamples:
    return PathSamples(np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, len(ARC), 2)))


def _along_log(
    log: DriveLog,
    samples: PathSamples,
    model: Model,
    config: PathPredictionConfig | None,
    meaning: StickMeaning,
    tell: _Counter,
) -> ModelPaths:
    driven = with_stick(log, model, meaning)
    sticks, predictor = driven.joystick_at(driven.scan_stamp), path_predictor(model, config)
    paths, missing = path_error.straight(samples.velocity), np.zeros(len(samples), bool)
    for k, i in enumerate(samples.scan):
        path = predictor.predict(sticks[i], driven.scan(int(i)), driven.T_base_laser)
        missing[k] = path is None
        if path is not None:
            paths[k] = at_arc_lengths(path)
        tell()
    compliant = None
    if predictor.compliance is not None:
        compliant = compliant_points(driven, samples, paths, predictor.compliance) & ~missing[:, None]
    told = driven.metadata.get("joystick", "as recorded")
    return ModelPaths(paths, missing, compliant, _deviations(paths, samples.driven), told)


def path_predictor(
    model: Model, config: PathPredictionConfig | None = None
) -> PathPredictor | HeatmapPathPredictor | NaivePathPredictor:
    """What predicts paths with a model of any kind; config: of models of path primitives."""
    if isinstance(model, HeatmapModel):
        return HeatmapPathPredictor(model)
    return NaivePathPredictor(model) if isinstance(model, NaiveHeatmapModel) else PathPredictor(model, config)


class Judge(Compliance, Protocol):
    """Judges compliance with control points up to the look-ahead that it is defined for."""

    @property
    def look_ahead(self) -> float:
        """[m]"""


def compliant_points(log: DriveLog, samples: PathSamples, paths: Array, judge: Judge) -> NDArray[np.bool_]:
    """Which points of the paths (N, A, 2) predicted at the samples agree with an input from then on -> (N, A); see the
    module. The inputs are those at the log's scans."""
    compliant = np.zeros(paths.shape[:2], bool)
    if not len(samples):
        return compliant
    look_ahead = judge.look_ahead
    poses, sticks = log.pose_at(log.scan_stamp), log.joystick_at(log.scan_stamp)
    way = _way(log)
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


def _way(log: DriveLog) -> Array:
    """(S,) [m] driven up to each scan by odometry"""
    return np.asarray(np.interp(log.scan_stamp, log.odometry_stamp, arc_length(log.pose[:, :2])))


def _deviations(paths: Array, driven: Array) -> Array:
    """(N, A) [m] from each path point to the way driven over the same reach, a polyline from base_link on"""
    found = np.zeros(paths.shape[:2])
    for k, (path, truth) in enumerate(zip(paths, driven, strict=True)):
        start = np.vstack([[0.0, 0.0], truth[:-1]])
        step, to = truth - start, path[:, None] - start
        share = np.clip((to * step).sum(2) / np.maximum((step**2).sum(1), 1e-12), 0, 1)
        found[k] = np.linalg.norm(to - share[..., None] * step, axis=2).min(axis=1)
    return found


def error_rows(prediction: LogPrediction, seed: int = 1) -> list[ErrorRow]:
    """n, mean, median, 95 % interval, paired difference and ratio to the better baseline, at 1, 2 and 2.5 m."""
    return pooled_rows([prediction], seed)


def pooled_rows(predictions: Sequence[LogPrediction], seed: int = 1) -> list[ErrorRow]:
    """error_rows of the samples of several logs together, all by the same models. ValueError if they are not."""
    judged = [p for p in predictions if len(p.samples)]
    if not judged:
        return []
    predicted = [p.predicted() for p in judged]
    if any(one.keys() != predicted[0].keys() for one in predicted):
        raise ValueError(f"logs were predicted by different models: {[list(p.models) for p in judged]}")
    paths = {name: np.concatenate([one[name] for one in predicted]) for name in predicted[0]}
    driven, blocks = np.concatenate([p.samples.driven for p in judged]), _blocks(judged)
    return [row for reach in REACHES for row in _rows(paths, driven, blocks, reach, seed)]


def _blocks(predictions: Sequence[LogPrediction]) -> NDArray[np.int_]:
    """(N,) which 5 m of way, of which log, each sample belongs to"""
    found: list[NDArray[np.int_]] = []
    first = 0
    for p in predictions:
        found.append(first + np.floor_divide(_way(p.log)[p.samples.scan], BLOCK).astype(int))
        first = int(found[-1].max()) + 1
    return np.concatenate(found)


def _rows(
    predicted: Mapping[str, Array], driven: Array, blocks: NDArray[np.int_], reach: float, seed: int
) -> list[ErrorRow]:
    errors = {name: path_errors(paths, driven, reach) for name, paths in predicted.items()}
    best = min((STRAIGHT, ARC_ON), key=lambda name: errors[name].mean())
    columns = np.stack([*errors.values(), *(e - errors[best] for e in errors.values())], axis=1)
    low, high = block_bootstrap(columns, blocks, seed)
    with np.errstate(divide="ignore", invalid="ignore"):  # of a baseline that is never wrong: no ratio
        share = columns[:, : len(errors)].mean(axis=0) / errors[best].mean()
    share_low, share_high = block_bootstrap_ratio(columns[:, : len(errors)], errors[best], blocks, seed)
    rows = []
    for k, (name, e) in enumerate(errors.items()):
        d = k + len(errors)
        own = (float(e.mean()), float(low[k]), float(high[k]), float(np.median(e)))
        paired = (float(columns[:, d].mean()), float(low[d]), float(high[d]))
        ratio = (float(share[k]), float(share_low[k]), float(share_high[k]))
        rows.append(ErrorRow(name, reach, len(e), *own, *paired, *ratio, best))
    return rows


def as_json(prediction: LogPrediction, seed: int = 1) -> dict[str, Any]:
    """All figures of one log by name; None or NaN where there is none."""
    about = {
        name: {
            "missing": float(paths.missing.mean()) if len(paths.missing) else None,
            "compliant": paths.compliant_share,
            "rmse_compliant": paths.rmse,
            "stick": paths.stick,
        }
        for name, paths in prediction.models.items()
    }
    rows = [dataclasses.asdict(row) for row in error_rows(prediction, seed)]
    return {"log": prediction.log.name, "outcome": prediction.outcome, "models": about, "errors": rows}


def prediction_cells(prediction: LogPrediction, seed: int = 1) -> list[tuple[str, ...]]:
    """The header and a row a method and reach, as text."""
    return _table(error_rows(prediction, seed))


def as_text(prediction: LogPrediction, seed: int = 1) -> str:
    """The same for people: a table, and a line a model."""
    if prediction.outcome:
        return f"{prediction.log.name}: {prediction.outcome}\n"
    lines = [f"{prediction.log.name}: path error", *_aligned(prediction_cells(prediction, seed))]
    lines += [_about(name, paths) for name, paths in prediction.models.items()]
    return "\n".join(lines) + "\n"


def pooled_text(predictions: Sequence[LogPrediction], seed: int = 1) -> str:
    """For people: one table of all logs together."""
    judged = [p.log.name for p in predictions if not p.outcome]
    return "\n".join([f"{', '.join(judged)} together: path error", *_aligned(_table(pooled_rows(predictions, seed)))])


def _table(rows: Sequence[ErrorRow]) -> list[tuple[str, ...]]:
    header = ("", "up to [m]", "n", "mean [m]", "95 %", "median [m]", "to the better baseline", "95 %", "ratio", "95 %")
    return [header, *(tuple(_cells(row)) for row in rows)]


def _aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(line[k]) for line in rows) for k in range(len(rows[0]))]
    lines = []
    for first, *others in rows:
        cells = [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        lines.append("  ".join([first.ljust(widths[0]), *cells]).rstrip())
    return lines


def _cells(row: ErrorRow) -> tuple[str, ...]:
    def interval(low: float, high: float) -> str:
        return "-" if np.isnan(low) else f"{low:.3f} .. {high:.3f}"

    baseline = row.predictor == row.baseline
    return (
        row.predictor,
        f"{row.reach:.1f}",
        str(row.n),
        f"{row.mean:.3f}",
        interval(row.low, row.high),
        f"{row.median:.3f}",
        "is it" if baseline else f"{row.difference:+.3f}",
        "" if baseline else interval(row.difference_low, row.difference_high),
        f"{row.ratio:.3f}",
        "" if baseline else interval(row.ratio_low, row.ratio_high),
    )


def _about(name: str, paths: ModelPaths) -> str:
    share = paths.compliant_share
    judged = "compliance unknown to this model"
    if share is not None:
        judged = f"{100 * share:.0f} % of the path points compliant"
        judged += f", RMSE of these {paths.rmse:.3f} m" if np.isfinite(paths.rmse) else ""
    return (
        f"{name}: {100 * paths.missing.mean():.1f} % without a prediction (straight on stands in); {judged}; "
        f"stick {paths.stick}"
    )
