"""Right answers against the share of a motion observed."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lfdcore.pictures.style import PAGE, REFERENCE, RULE, SERIES, styled
from lfdcore.study.sequences.study import QUESTIONS, SHARES, SequenceResult

COLOURS = dict(zip(QUESTIONS, SERIES, strict=False))


@styled
def sequence_figure(result: SequenceResult) -> Figure:
    """A line a question with its 95 % band over draws."""
    figure = Figure(figsize=(0.6 * PAGE, 3.8), layout="constrained")
    axes = figure.subplots()
    at = 100 * np.array(SHARES)
    for what, words in QUESTIONS.items():
        right, low, high = result.right(what)
        axes.plot(at, 100 * right, "o-", color=COLOURS[what], ms=3.5, lw=1.6, label=words)
        axes.fill_between(at, 100 * low, 100 * high, color=COLOURS[what], alpha=0.14, lw=0)
    axes.axhline(90, color=REFERENCE, lw=0.8, ls=":")
    axes.set(xlabel="of the motion seen [%]", ylabel="right answers [%]", xlim=(0, 100), ylim=(0, 102))
    axes.grid(color=RULE, lw=0.6)
    axes.legend(loc="lower right")
    return figure
