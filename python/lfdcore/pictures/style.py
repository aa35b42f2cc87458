"""One style and one palette for every picture, whatever the user's matplotlibrc says: the same figure gives the same
bytes, and the same thing has the same colour in all of them."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec

import matplotlib.style
import numpy as np
from matplotlib import colormaps
from matplotlib.colors import ListedColormap, to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

P = ParamSpec("P")

# ---- palette -------------------------------------------------------------------------------------------------------

BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9"
"""Of Okabe and Ito (2008), Color Universal Design; theirs is also a yellow, too pale for lines on white."""
INK, WALL, WAY, REFERENCE, BODY, FAINT = "#1f2328", "#3b3f46", "#4a5058", "#808790", "#9aa1ab", "#b9bec6"
UNKNOWN, RULE, FREE = "#cacfd7", "#dde1e6", "#ffffff"
"""Greys, dark to light. WAY: of the axle; REFERENCE: what is compared with; BODY: footprints and objects; FAINT: many
lines or points behind others; RULE: grids behind curves; WALL, UNKNOWN, FREE: cells of a map."""

FOLLOWED, DISCARDED, CONTACT = GREEN, ORANGE, VERMILLION
"""Of a planned path what was followed and what was not (or complied with no input); where something is touched."""
PLANNED, DRIVEN, BEAM, STICK = ORANGE, BLUE, SKY, PURPLE
"""A path or point ahead; a way that was driven; scanner; joystick."""
UNJUDGED = SKY
"""Paths of a model that knows no compliance."""
SEEN = ORANGE
"""What is observed of a partner."""
LEARNED, ANOTHER, BASELINE = BLUE, ORANGE, WAY
"""What a figure is about, what else is learned, and what either has to beat."""
METHOD_COLOURS = {
    "primitives": LEARNED,
    "heatmaps": ANOTHER,
    "sensor": ANOTHER,
    "naive": PURPLE,
    "dwa": GREEN,
    "supervisor": SKY,
    "none": BASELINE,
    "EaIP": LEARNED,
    "IP": ANOTHER,
}
"""By name; sensor is the network of the heatmaps."""
SERIES = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, INK)
"""Of what has an order but no colour of its own: destinations, drivers, columns."""
ALARM = "#a84a00"
"""Vermillion as dark as small letters need: 5.8 to 1 on white."""
LANDSCAPE, DIRECTIONS, CONFUSION = "viridis", "twilight_shifted", "Blues"
"""Colour maps of heat, reward and likelihood; of orientations; of counts below their figures."""
RANKS = ListedColormap(colormaps["plasma"](np.linspace(0.05, 0.88, 256)))
"""Colour map of lines in an order, dark to light; its palest is still seen on white."""

TOGETHER = {
    "a map": (WALL, UNKNOWN, FREE),
    "a run with plans": (FOLLOWED, DISCARDED, CONTACT, WAY, BODY),
    "a run with DWA": (PLANNED, DRIVEN, CONTACT, WAY, BODY),
    "a prediction along a log": (FOLLOWED, DISCARDED, DRIVEN, UNJUDGED, BODY),
    "the local window": (PLANNED, DRIVEN, BEAM, STICK, WAY),
    "people about": (SEEN, REFERENCE, BEAM, BLUE, WAY),
    "methods": tuple(dict.fromkeys(METHOD_COLOURS.values())),
    "destinations, drivers, columns": SERIES,
    "methods of handovers": (BLUE, PURPLE, SKY, ANOTHER, BASELINE, VERMILLION, GREEN, INK),
}
"""Colours that meet in one figure: tests/py/pictures/test_palette.py says how far apart they are to whom."""


def series_colour(index: int) -> str:
    """The colour of the `index`-th of several; beyond the last they begin again."""
    return SERIES[index % len(SERIES)]


def translucent(colour: str, alpha: float = 0.25) -> str:
    """A colour of the palette that lets shine through what lies behind it."""
    return to_hex(to_rgba(colour, alpha), keep_alpha=True)


# ---- style ---------------------------------------------------------------------------------------------------------


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
