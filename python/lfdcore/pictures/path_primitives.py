"""Path primitives over the demonstrated paths that they are of, and scaled to goals (Fig. 3.9)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, to_hex
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.geometry import Footprint
from lfdcore.pictures.style import FAINT, PAGE, RANKS, REFERENCE, UNKNOWN, styled
from lfdcore.pictures.window import draw_chair, draw_dot, draw_line, front_axes
from lfdcore.wheelchair.primitives.local_paths import LocalPaths
from lfdcore.wheelchair.primitives.path_primitives import PathPrimitives, orientation_bin

Array = NDArray[np.float64]


def bin_heading(index: int, bins: int = 17) -> float:
    """Heading [rad] in the middle of an orientation bin."""
    return float((index + 0.5) * 2 * np.pi / bins - np.pi)


def _colour(colours: ScalarMappable, index: int) -> str:
    """Of an orientation bin."""
    return to_hex(colours.cmap(colours.norm(np.degrees(bin_heading(index)))))


_FEW = 8


def _in_bin(paths: LocalPaths, index: int) -> list[Array]:
    """The paths of a bin with the mirror images of the opposite one's."""
    flip = np.array([1.0, -1.0])
    own = [paths.paths[k] for k in np.flatnonzero(orientation_bin(paths.end_yaw) == index)]
    return own + [paths.paths[k] * flip for k in np.flatnonzero(orientation_bin(-paths.end_yaw) == index)]


def _draw_bin(axes: Axes, primitives: PathPrimitives, which: int, paths: LocalPaths, colour: str) -> None:
    own = _in_bin(paths, int(primitives.bins[which]))
    shown = own[:: max(1, len(own) // 60)]
    width = 0.5 if len(own) > _FEW else 4.5  # few lie close to their mean: wide enough to be seen below it
    axes.add_collection(LineCollection([p[:, ::-1] for p in shown], colors=FAINT, linewidths=width))
    draw_line(axes, primitives.shapes[which], colour, 2.0)
    draw_dot(axes, primitives.ends[which], colour, 4.0)
    heading = np.degrees(bin_heading(int(primitives.bins[which])))
    title = f"{round(heading):+d}°".replace("+0", "0").replace("-", "−")
    axes.set_title(f"{title}, n {int(primitives.counts[which])}", fontsize=8, pad=3)
    front_axes(axes, labels=False)
    axes.set_xticks([2, 0, -2])


def goal_ring(reach: float = 2.3, count: int = 13) -> Array:
    """(count, 2) [m]: goals on a half circle before the chair."""
    angle = np.linspace(-0.5, 0.5, count) * np.pi
    return reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _draw_scaled(axes: Axes, primitives: PathPrimitives, colours: ScalarMappable) -> None:
    for reach in (0.9, 1.6, 2.3):
        goals = goal_ring(reach, 15)
        for goal, which in zip(goals, primitives.nearest(goals), strict=True):
            colour = _colour(colours, int(primitives.bins[which]))
            draw_line(axes, primitives.scaled_to(goal), colour, 1.1 if reach < 2 else 1.5, zorder=2)
            draw_dot(axes, goal, UNKNOWN, 5.0, mec=REFERENCE, mew=0.6)
    draw_chair(axes, Footprint())
    front_axes(axes)
    axes.set_title("B  the nearest primitive scaled to goals (grey)")


_TITLE: dict[str, Any] = {"ha": "center", "fontsize": 9.5}


@styled
def primitives_figure(primitives: PathPrimitives, paths: LocalPaths) -> Figure:
    """A: the primitive of each orientation over the demonstrated paths; B: scaled to goals (Fig. 3.9)."""
    colours = ScalarMappable(Normalize(-180, 180), RANKS)
    figure = Figure(figsize=(PAGE, 3.1))  # placed by hand: nested automatic layouts are not the same every time
    panels = figure.add_gridspec(3, 6, left=0.045, right=0.645, bottom=0.13, top=0.86, wspace=0.12, hspace=0.3)
    for which, axes in enumerate(np.asarray(panels.subplots(sharex=True, sharey=True)).ravel()):
        if which < len(primitives):
            colour = _colour(colours, int(primitives.bins[which]))
            _draw_bin(axes, primitives, which, paths, colour)
        else:
            axes.set_axis_off()
    figure.text(0.345, 0.96, "A  primitives by the heading of their end, over demonstrated paths (grey)", **_TITLE)
    figure.text(0.345, 0.02, "y, left [m]", ha="center", fontsize=9)
    figure.text(0.008, 0.5, "x, ahead [m]", va="center", fontsize=9, rotation=90)
    _draw_scaled(figure.add_axes((0.70, 0.30, 0.29, 0.60)), primitives, colours)
    bar = figure.add_axes((0.73, 0.11, 0.23, 0.025))
    figure.colorbar(colours, cax=bar, orientation="horizontal", label="heading of the end [°]")
    return figure
