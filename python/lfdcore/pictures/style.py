"""One style for every picture, whatever the user's matplotlibrc says, so that the same figure gives the same bytes."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec

import matplotlib.style
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

P = ParamSpec("P")


STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8.5,
    "axes.linewidth": 0.6,
}


PAGE = 10.5
"""Width of a full-page figure [in]."""


DPI = 120


def styled(make: Callable[P, Figure]) -> Callable[P, Figure]:
    """Runs a figure's function in our style alone."""

    @wraps(make)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with matplotlib.style.context(["default", STYLE]):
            return make(*args, **kwargs)

    return wrapped


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """The figure as PNG; the same figure gives the same bytes."""
    data = io.BytesIO()
    with matplotlib.style.context(["default", STYLE]):
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once: a second drawing would move what stands already
        figure.savefig(data, format="png", dpi=dpi, bbox_inches="tight", pad_inches=0.06, metadata={"Software": None})
    return data.getvalue()


def line_handle(colour: str, label: str, width: float = 1.5) -> Line2D:
    """A line for a legend."""
    return Line2D([], [], color=colour, lw=width, label=label)


@dataclass(frozen=True)
class Picture:
    """A figure and what it shows."""

    figure: Figure
    caption: str
    name: str = ""
    """of a file for it alone, beside the report; empty: none"""
