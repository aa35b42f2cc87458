"""How a figure is written in a table: one way each for a figure with its interval, a mean, a share, a count and p."""

from __future__ import annotations

from math import isnan, nan

from numpy.typing import ArrayLike

from lfdcore.study.report.statistics import Summary, poisson_rate, proportion, summarise, summarise_bounded

NONE = "-"
"""a figure that there is none of"""


def figure_cell(
    value: float,
    low: float = nan,
    high: float = nan,
    *,
    digits: int,
    sd: float = nan,
    sign: str = "",
    unit: str = "",
) -> str:
    """The figure (+-sd, if there is one), and below it its interval [low, high], if there is one; '-' for NaN. sign:
    '+' shows it always, as of a difference."""
    if isnan(value):
        return NONE
    spread = "" if isnan(sd) else f"+-{sd:.{digits}f}"
    interval = "" if isnan(low) else f"\n[{low:.{digits}f}, {high:.{digits}f}]"
    return f"{value:{sign}.{digits}f}{spread}{unit}{interval}"


def percent_cell(share: float, low: float = nan, high: float = nan) -> str:
    """A share of 1 in percent, and below it its interval, if there is one; '-' for NaN."""
    return figure_cell(100 * share, 100 * low, 100 * high, digits=0, unit=" %")


def in_a_line(cell: str) -> str:
    """A cell as part of a sentence."""
    return cell.replace("\n", " ")


def summary_cell(s: Summary, digits: int, *, with_sd: bool = True, least: float = -float("inf")) -> str:
    """A mean with its sd and the 95 % interval, cut at `least`; how many values there were, where some are missing."""
    low = nan if isnan(s.low) else max(s.low, least)
    cell = figure_cell(s.mean, low, s.high, digits=digits, sd=s.sd if with_sd else nan)
    return cell + (f"\nn {s.n}" if s.missing and s.n > 1 else "")


def mean_cell(values: ArrayLike, digits: int, bounded: bool = False, *, with_sd: bool = True) -> str:
    """mean+-sd of what cannot be negative, and below it the 95 % interval of the mean; bounded: a count or a share,
    whose interval is a bootstrap's."""
    return summary_cell(summarise_bounded(values) if bounded else summarise(values), digits, with_sd=with_sd, least=0.0)


def share_cell(successes: int, n: int) -> str:
    """k of n, and below it the share with Wilson's 95 % interval."""
    share, low, high = proportion(successes, n)
    return f"{successes} of {n}\n{100 * share:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"


def count_cell(events: int, n: int) -> str:
    """Events in n runs, and below it Garwood's 95 % interval of events a run (Poisson)."""
    _, low, high = poisson_rate(events, n)
    return f"{events} in {n}\n[{low:.2f}, {high:.2f}]"


def p_cell(p: float) -> str:
    """A p value; '-' for NaN."""
    return NONE if isnan(p) else "<0.001" if p < 0.001 else f"{p:.3f}"
