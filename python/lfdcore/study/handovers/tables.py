"""Tables of study handovers: errors by share observed, differences to baselines, what seeing more is worth."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lfdcore.study.handovers.study import (
    LIKELIEST,
    MEAN,
    MEASURES,
    METHODS,
    NEAREST,
    SHARES,
    WARPED,
    HandoverResult,
    TaskErrors,
)
from lfdcore.study.report.cells import figure_cell
from lfdcore.study.report.statistics import block_bootstrap
from lfdcore.study.report.table import Row, Table

Array = NDArray[np.float64]
COMPARED = {WARPED: "DTW", LIKELIEST: "likeliest"}
"""IP with positions, by how the phase is found"""
BASELINES = {MEAN: "mean", NEAREST: "nearest"}
BELOW = "Below: 95 % interval by a bootstrap of whole demonstrations."


def intervals(values: Array, tested: NDArray[np.int_], seed: int) -> tuple[Array, Array, Array]:
    """Means (k,) of values (n, k) and their 95 % intervals (low, high) by a bootstrap of whole demonstrations. Row i is
    of the recording tested[i]: a recording is tested in several splits."""
    return values.mean(axis=0), *block_bootstrap(values, tested, seed)


def _cells(values: Array, result: TaskErrors, seed: int) -> list[str]:
    """values (n, shares) [m] -> a cell a share [mm]"""
    found = 1e3 * np.array(intervals(values, result.tested, seed))
    return [figure_cell(*one, digits=0) for one in found.T.tolist()]


def _header() -> Row:
    return ("", *("first sample" if share == 0 else f"{share:.0%}" for share in SHARES))


def caption(result: TaskErrors) -> str:
    """How many handovers and tests there are."""
    tests = len(result.tested)
    return f"n = {len(result.task.recordings)} handovers, {tests} tests in {len(result.splits)} splits"


def error_table(result: TaskErrors, measure: int, seed: int) -> Table:
    """A row a method, a column a share."""
    rows = [(name, *_cells(result.errors[:, k, :, measure], result, seed)) for k, name in enumerate(METHODS)]
    return Table(
        f"{result.task.name}: RMS error of the taker's hands {MEASURES[measure]} [mm] by share observed "
        f"({caption(result)}, seed {seed})",
        _header(),
        tuple(rows),
        f"{BELOW}{_spread(result, measure)}",
    )


def _spread(result: TaskErrors, measure: int) -> str:
    """What the splits' means of IP with positions scatter by; nothing of one split."""
    sd = 1e3 * result.spread[LIKELIEST, :, measure]
    if not np.isfinite(sd).any():
        return ""
    return f" Standard deviation of a split's mean, IP with positions: {np.nanmin(sd):.0f}-{np.nanmax(sd):.0f} mm."


def difference_table(result: TaskErrors, seed: int) -> Table:
    """IP less each baseline, paired: below 0 it is better."""
    rows = []
    for measure, words in enumerate(MEASURES):
        errors = result.errors[..., measure]
        for way, what in COMPARED.items():
            for other, name in BASELINES.items():
                cells = _cells(errors[:, way] - errors[:, other], result, seed)
                rows.append((f"{words}: {what} - {name}", *cells))
    return Table(
        f"{result.task.name}: error of IP with positions, phase by DTW or the likeliest, less that of a "
        f"baseline, paired [mm] ({caption(result)})",
        _header(),
        tuple(rows),
        "Below 0: IP is better; an interval that holds 0 decides nothing.",
    )


def seen_tables(results: Sequence[TaskErrors], seed: int) -> list[Table]:
    """What more that is seen is worth: tasks on the same recordings and splits, paired (Sec. 6.2.2)."""
    pairs = [(a, b) for a, b in pairwise(results) if np.array_equal(a.tested, b.tested)]
    return [_seen_table(few, more, seed) for few, more in pairs]


def _seen_table(few: TaskErrors, more: TaskErrors, seed: int) -> Table:
    apart = more.errors - few.errors
    rows = [
        (f"{words}, {METHODS[way]}", *_cells(apart[:, way, :, measure], few, seed))
        for measure, words in enumerate(MEASURES)
        for way in COMPARED
    ]
    return Table(
        f"{more.task.name} less {few.task.name}: error, paired [mm] ({caption(few)}, seed {seed})",
        _header(),
        tuple(rows),
        "Below 0: seeing more is better.",
    )


def task_tables(result: TaskErrors, seed: int) -> list[Table]:
    """All tables of a task."""
    return [*(error_table(result, k, seed) for k in range(len(MEASURES))), difference_table(result, seed)]


def handover_rows(result: HandoverResult) -> list[dict[str, object]]:
    """Every figure, for machines."""
    return [row for task in result.tasks for row in _task_rows(task, result.study.splits, result.study.seed)]


def _task_rows(result: TaskErrors, splits: int, seed: int) -> list[dict[str, object]]:
    n, tests = len(result.task.recordings), len(result.tested)
    about = {"task": result.task.name, "n": n, "tests": tests, "splits": splits, "seed": seed}
    return [
        about | {"measure": words, "method": method} | figures
        for measure, words in enumerate(MEASURES)
        for k, method in enumerate(METHODS)
        for figures in _figures(result, k, measure, seed)
    ]


def _figures(result: TaskErrors, method: int, measure: int, seed: int) -> list[dict[str, object]]:
    """A row a share."""
    found = intervals(result.errors[:, method, :, measure], result.tested, seed)
    columns = (SHARES, *(one.tolist() for one in (*found, result.spread[method, :, measure])))
    names = ("share", "error", "low", "high", "sd_of_splits")
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
