"""The picture of study adaptation: error over drive time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.pictures.style import ANOTHER, BASELINE, LEARNED, PAGE, REFERENCE, RULE, styled
from lfdcore.study.adaptation.study import AdaptationRun, by_bias
from lfdcore.study.report.statistics import summarise

Floats = NDArray[np.float64]
COLOURS = {"before": BASELINE, "then": ANOTHER, "adapting": LEARNED}
BIN = 10.0
"""[s]"""


def _over_time(runs: Sequence[AdaptationRun], stage: str) -> tuple[Floats, Floats]:
    """-> middles of bins (K,) [s], errors (runs, K), NaN where a run has none."""
    count = int(np.ceil(max(run.stamp[-1] for run in runs) / BIN)) + 1
    errors = np.full((len(runs), count), np.nan)
    for row, run in zip(errors, runs, strict=True):
        error = getattr(run, f"error_{stage}")
        there = np.isfinite(error)
        if stage == "then":
            there &= run.stamp > run.after
        index = (run.stamp[there] / BIN).astype(int)
        number = np.bincount(index, minlength=count)
        row[:] = np.bincount(index, error[there], minlength=count) / np.where(number, number, np.nan)
    middles = np.asarray((np.arange(count) + 0.5) * BIN, float)
    return middles, errors


def _draw(axes: Axes, runs: Sequence[AdaptationRun], stage: str, label: str) -> None:
    """The mean over runs with its 95 % band, while at least half of them still drive."""
    at, errors = _over_time(runs, stage)
    enough = np.isfinite(errors).sum(axis=0) >= max(1, len(runs) / 2)
    bins = [summarise(column) for column in errors[:, enough].T]
    mean, low, high = (np.array([getattr(s, name) for s in bins]) for name in ("mean", "low", "high"))
    colour = COLOURS[stage]
    axes.plot(at[enough], mean, color=colour, lw=1.4, label=label, zorder=3)
    axes.fill_between(at[enough], np.maximum(low, 0), high, color=colour, alpha=0.18, lw=0, zorder=2)


@styled
def adaptation_figure(runs: Sequence[AdaptationRun]) -> Figure:
    """Error over drive time, a panel a bias: as trained, as of `after` and kept, adapting."""
    groups, after = by_bias(runs), runs[0].after
    figure = Figure(figsize=(PAGE, 3.2), layout="constrained")
    panels = figure.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    names = {"before": "as trained", "then": f"as of {after:g} s, kept", "adapting": "adapting"}
    for axes, (bias, mine) in zip(panels, groups, strict=True):
        for stage, label in names.items():
            _draw(axes, mine, stage, label)
        axes.axvline(after, color=REFERENCE, lw=0.8, ls="--", zorder=1)
        axes.set(
            xlabel="time into the drive [s]",
            title=f"bias {bias:+.2f} rad, n = {len(mine)}" if bias else f"no bias, n = {len(mine)}",
        )
        axes.set_xlim(left=0)
        axes.grid(axis="y", lw=0.4, color=RULE)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylim(bottom=0)  # of all, once all is drawn: limits set before would cut what comes later
    panels[0].set_ylabel("error of the joystick model [rad]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure
