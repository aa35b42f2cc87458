"""Is a heatmap's probability that "the driver's path crosses this cell within 2.5 m" worth what it says?

Truth: the cells that the way driven after a scan passes through, up to 2.5 m of way. Only cells that the scan sees free
are judged. A predictor that always says the same share is calibrated too and knows nothing: it stands beside, and the
Brier score tells the two apart. Since nearly all cells are crossed in nearly no run, the error over all cells is small
for anybody; the error over the likeliest cells that hold half of all crossings (`top_error`) is the harder figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Pose2, arc_length
from lfdcore.grid import local_grid
from lfdcore.wheelchair.heatmaps.calibration import HeatmapCalibration
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import MOVING, ChairGeometry, observations
from lfdcore.wheelchair.window import CELLS, RESOLUTION, WINDOW, free_mask

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
REACH = 2.5
"""[m] of way"""
_STEP = RESOLUTION / 10


def crossed_cells(log: DriveLog, scan: int, reach: float = REACH) -> Mask | None:
    """(100, 100): the local window's cells at a scan that the way driven afterwards passes through within `reach` [m];
    None if the log ends, or its odometry has a gap, before. ValueError without odometry."""
    now = float(log.scan_stamp[scan])
    base = Pose2(*log.pose_at([now])[0])
    later = log.odometry_stamp > now
    stamp = np.r_[now, log.odometry_stamp[later]]
    points = np.vstack([[base.x, base.y], log.pose[later, :2]])
    way = arc_length(points)
    end = int(np.searchsorted(way, reach))
    if end >= len(way) or np.diff(stamp[: end + 1]).max(initial=0) > 3.0:
        return None
    at = np.arange(0.0, reach, _STEP)
    way = way + np.arange(len(way)) * 1e-9  # a standing robot must not repeat an abscissa
    local = base.inverse().transform(np.stack([np.interp(at, way, points[:, k]) for k in (0, 1)], axis=1))
    cells = np.floor((local + WINDOW) / RESOLUTION).astype(int)
    cells = cells[((cells >= 0) & (cells < CELLS)).all(axis=1)]
    crossed = np.zeros((CELLS, CELLS), bool)
    crossed[cells[:, 1], cells[:, 0]] = True
    return crossed


@dataclass(frozen=True)
class JudgedCells:
    """Cells that scans saw free: heat (N,) in [0, 1] of the product of sensor and user heatmap; crossed (N,): by the
    way then driven; run (N,): which log, by position."""

    heat: NDArray[np.float32]
    crossed: Mask
    run: NDArray[np.int_]


def judged_cells(
    logs: Sequence[DriveLog], model: HeatmapModel, config: HeatmapPlannerConfig | None = None, period: float = 1.0
) -> JudgedCells:
    """The free cells of a scan every `period` [s] of driving forward after which `REACH` of way follows. ValueError if
    no log holds such a scan."""
    heats, crossings, runs = [], [], []
    for run, log in enumerate(logs):
        chair = ChairGeometry.thesis(log.mounting)
        planner = HeatmapPlanner(model, config or HeatmapPlannerConfig(), chair)
        due = -np.inf
        for now in observations(log):
            if now.stamp < due or now.twist.linear < MOVING:
                continue
            seen = local_grid(now.scan, log.mounting)
            crossed = crossed_cells(log, int(np.searchsorted(log.scan_stamp, now.stamp)))
            heat = planner.heat(now, seen)
            if crossed is None or heat is None:
                continue
            due = now.stamp + period - 1e-9
            free = free_mask(seen)
            heats.append(heat.intent[free])
            crossings.append(crossed[free])
            runs.append(np.full(int(free.sum()), run))
    if not heats:
        raise ValueError(f"{len(logs)} logs hold no scan after which {REACH} m are driven by the joystick")
    return JudgedCells(*(np.concatenate(parts) for parts in (heats, crossings, runs)))


@dataclass(frozen=True)
class CalibrationCheck:
    """A calibration fitted on some runs, judged on others."""

    calibration: HeatmapCalibration
    judged: Reliability
    """of all cells of all judged runs"""
    raw: Reliability
    """of heat itself, taken for a probability"""
    errors: Floats
    """(R,) expected calibration error of each judged run"""
    tenths: tuple[Floats, Floats]
    """mean probability and share crossed of ten parts of equally many cells, from the least likely on"""
    happened: float
    """share of judged cells that were crossed"""
    fitted_runs: int
    fitted_cells: int


def check_calibration(fitted: JudgedCells, judged: JudgedCells) -> CalibrationCheck:
    """Fits on `fitted` and judges on `judged`; the constant-rate predictor has the rate of `fitted`."""
    calibration, rate = HeatmapCalibration.fit(fitted.heat, fitted.crossed), float(fitted.crossed.mean())
    probability = calibration.probabilities(judged.heat)
    each = [reliability(probability[own], judged.crossed[own]).error for own in _runs(judged)]
    return CalibrationCheck(
        calibration,
        reliability(probability, judged.crossed, rate),
        reliability(judged.heat, judged.crossed, rate),
        np.array(each),
        _parts(probability, judged.crossed),
        float(judged.crossed.mean()),
        len(np.unique(fitted.run)),
        len(fitted.heat),
    )


def _parts(probability: NDArray[np.floating], crossed: Mask, count: int = 10) -> tuple[Floats, Floats]:
    order = np.argsort(probability, kind="stable")
    parts = np.array_split(order, min(count, len(order)))
    said, happened = (np.array([np.mean(of[part]) for part in parts]) for of in (probability, crossed))
    return said, happened


def _runs(cells: JudgedCells) -> list[Mask]:
    return [cells.run == run for run in np.unique(cells.run)]


@dataclass(frozen=True)
class Reliability:
    """How predicted shares and what happened go together.

    predicted, happened, count (B,): per bin of equal width in probability; empty bins are left out.
    """

    predicted: Floats
    happened: Floats
    count: NDArray[np.int_]
    error: float
    """expected calibration error: mean over cells of |predicted - happened| of their bin"""
    top_error: float
    """the same over the likeliest cells, which hold half of all crossings; NaN without any"""
    brier: float
    """mean squared error of the probabilities"""
    constant_rate: float
    """what the constant-rate predictor says"""
    constant_error: float
    """its calibration error"""
    constant_brier: float


def reliability(
    probability: NDArray[np.floating], crossed: Mask, rate: float | None = None, bins: int = 20
) -> Reliability:
    """Judges cells (N,): probability in [0, 1], whether they were crossed. rate: what the constant-rate predictor says,
    measured elsewhere (on the runs that the calibration saw); by default these cells' own. ValueError without cells."""
    p, y = np.ravel(probability).astype(np.float64), np.ravel(crossed).astype(np.float64)
    if p.shape != y.shape or not len(p):
        raise ValueError(f"{len(p)} probabilities and {len(y)} crossings: needs as many, at least 1")
    if not ((p >= 0) & (p <= 1)).all():
        raise ValueError("probabilities must lie in [0, 1]")
    constant = float(y.mean()) if rate is None else rate
    said, happened, count = _binned(p, y, bins)
    return Reliability(
        said,
        happened,
        count,
        _error(said, happened, count),
        _top_error(p, y),
        float(((p - y) ** 2).mean()),
        constant,
        abs(constant - float(y.mean())),
        float(((constant - y) ** 2).mean()),
    )


def _binned(p: Floats, y: Floats, bins: int) -> tuple[Floats, Floats, NDArray[np.int_]]:
    which = np.minimum((p * bins).astype(int), bins - 1)
    count = np.bincount(which, minlength=bins)
    kept = count > 0
    said, happened = (np.bincount(which, v, bins)[kept] / count[kept] for v in (p, y))
    return said, happened, count[kept]


def _error(said: Floats, happened: Floats, count: NDArray[np.int_]) -> float:
    return float((np.abs(said - happened) * count).sum() / count.sum())


def _top_error(p: Floats, y: Floats) -> float:
    if not y.any():
        return float("nan")
    order = np.argsort(-p, kind="stable")
    last = int(np.searchsorted(np.cumsum(y[order]), y.sum() / 2)) + 1
    top = order[:last]
    parts = np.array_split(top, min(10, len(top)))  # tenths of equally many cells
    said, happened = (np.array([v[part].mean() for part in parts]) for v in (p, y))
    return _error(said, happened, np.array([len(part) for part in parts]))
