"""How a figure is written in a table: mean with interval, k of n, p."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lfdcore.study.report.statistics import (
    proportion,
    summarise,
    summarise_bounded,
)


def mean_cell(values: Sequence[float], digits: int, bounded: bool = False) -> str:
    """mean+-sd, and below it the 95 % interval of the mean; '-' if there is no value."""
    s = summarise_bounded(values) if bounded else summarise(values)
    if s.n == 0:
        return "-"
    if s.n == 1:
        return f"{s.mean:.{digits}f}"
    less = f"\nn {s.n}" if s.missing else ""
    return f"{s.mean:.{digits}f}+-{s.sd:.{digits}f}\n[{max(s.low, 0.0):.{digits}f}, {s.high:.{digits}f}]{less}"


def share_cell(successes: int, n: int) -> str:
    """k of n, and below it the share with Wilson's 95 % interval."""
    share, low, high = proportion(successes, n)
    return f"{successes} of {n}\n{100 * share:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"


def p_cell(p: float) -> str:
    return "-" if np.isnan(p) else "<0.001" if p < 0.001 else f"{p:.3f}"
