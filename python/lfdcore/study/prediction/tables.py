"""Path errors of predictions as rows, text and JSON."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.study.prediction.path_error import REACHES, path_errors
from lfdcore.study.prediction.study import (
    ARC_ON,
    BLOCK,
    STRAIGHT,
    Array,
    ErrorRow,
    LogPrediction,
    ModelPaths,
    way_driven,
)
from lfdcore.study.report.cells import figure_cell
from lfdcore.study.report.statistics import (
    block_bootstrap,
    block_bootstrap_ratio,
)
from lfdcore.study.report.table import Table


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
    """(N,) which log's 5 m of way each sample belongs to"""
    found: list[NDArray[np.int_]] = []
    first = 0
    for p in predictions:
        found.append(first + np.floor_divide(way_driven(p.log)[p.samples.scan], BLOCK).astype(int))
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


def as_text(prediction: LogPrediction, seed: int = 1) -> str:
    """The same for people: a table with 95 % intervals, and a line a model."""
    if prediction.outcome:
        return f"{prediction.log.name}: {prediction.outcome}\n"
    lines = [_about(name, paths) for name, paths in prediction.models.items()]
    return "\n".join([_table(f"{prediction.log.name}: path error", error_rows(prediction, seed)).as_text(), *lines, ""])


def pooled_text(predictions: Sequence[LogPrediction], seed: int = 1) -> str:
    """For people: one table of all logs together."""
    judged = [p.log.name for p in predictions if not p.outcome]
    return _table(f"{', '.join(judged)} together: path error", pooled_rows(predictions, seed)).as_text()


def prediction_table(prediction: LogPrediction, seed: int = 1) -> Table:
    """Path error along a real log beside both baselines."""
    note = f"Mean path error at equal arc length; 95 % intervals by block bootstrap over 5 m of way, seed {seed}."
    return _table(f"Path error along {prediction.log.name} (real log)", error_rows(prediction, seed), note)


def _table(title: str, rows: Sequence[ErrorRow], note: str = "") -> Table:
    header = ("", "up to [m]", "n", "mean [m]", "median [m]", "to the better baseline", "ratio")
    return Table(title, header, tuple(map(_cells, rows)), note)


def _cells(row: ErrorRow) -> tuple[str, ...]:
    difference = figure_cell(row.difference, row.difference_low, row.difference_high, digits=3, sign="+")
    ratio = figure_cell(row.ratio, row.ratio_low, row.ratio_high, digits=3)
    is_baseline = row.predictor == row.baseline
    return (
        row.predictor,
        f"{row.reach:.1f}",
        str(row.n),
        figure_cell(row.mean, row.low, row.high, digits=3),
        f"{row.median:.3f}",
        "is it" if is_baseline else difference,
        ratio.split("\n")[0] if is_baseline else ratio,
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
