"""Errors of the predicted taker against the share of the giver's motion observed."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lfdcore.pictures.style import (
    PAGE,
    RULE,
    TOGETHER,
    styled,
)
from lfdcore.study.handovers.study import LIKELIEST, MEASURES, METHODS, NEAREST, SHARES, WARPED, TaskErrors
from lfdcore.study.handovers.tables import caption, intervals

COLOURS = TOGETHER["methods of handovers"]
"""of METHODS"""


@styled
def error_figure(result: TaskErrors, seed: int) -> Figure:
    """A panel a measure, a line a method; bands: 95 % intervals of the methods that the tables compare."""
    figure = Figure(figsize=(PAGE, 3.9), layout="constrained")
    panels = figure.subplots(1, len(MEASURES), sharex=True)
    for measure, axes in enumerate(panels):
        _draw_errors(axes, result, measure, seed)
    panels[0].set_ylabel("RMS error of the taker's hands [mm]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(f"{result.task.name} ({caption(result)})", fontsize=9.5)
    return figure


def _draw_errors(axes: Axes, result: TaskErrors, measure: int, seed: int) -> None:
    at = 100 * np.array(SHARES)
    for k, name in enumerate(METHODS):
        mean, low, high = 1e3 * np.array(intervals(result.errors[:, k, :, measure], result.tested, seed))
        oracle = name.startswith("oracle")
        axes.plot(at, mean, color=COLOURS[k], lw=1.1 if oracle else 1.6, ls="--" if oracle else "-", label=name)
        if k in (WARPED, LIKELIEST, NEAREST):
            axes.fill_between(at, low, high, color=COLOURS[k], alpha=0.14, lw=0)
    axes.set(title=MEASURES[measure], xlabel="of the giver's motion seen [%]", xlim=(0, 100))
    axes.set_ylim(bottom=0)
    axes.grid(color=RULE, lw=0.6)
