"""What pictures of the local window are drawn with: base_link with the chair's front up, x ahead the vertical axis, y
left the horizontal one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import LaserScan, read_beams
from lfdcore.pictures.style import BODY, INK, PLANNED, STICK, WALL, WAY, translucent
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.window import WINDOW

Array = NDArray[np.float64]

_EDGE = WINDOW + 0.12
_BACK = -0.6


def front_axes(axes: Axes, back: float = _BACK, reach: float = _EDGE, labels: bool = True) -> None:
    """Front up; y grows to the left, as base_link has it."""
    axes.set(xlim=(reach, -reach), ylim=(back, reach))
    axes.set_aspect("equal")
    axes.tick_params(length=2.5, width=0.6)
    if labels:
        axes.set_xlabel("y, left [m]")
        axes.set_ylabel("x, ahead [m]")


def draw_line(axes: Axes, points: Array, colour: str, width: float = 1.5, **more: Any) -> None:
    """A polyline (N, 2) [m]."""
    axes.plot(points[:, 1], points[:, 0], color=colour, lw=width, **more)


def draw_plan(axes: Axes, points: Array, width: float = 1.8, **more: Any) -> None:
    """A planned path (N, 2) [m], cased: seen on whatever landscape lies below it."""
    casing = [withStroke(linewidth=width + 1.4, foreground=INK)]
    draw_line(axes, points, PLANNED, width, path_effects=casing, **more)


def draw_dot(axes: Axes, point: Sequence[float] | Array, colour: str, size: float = 6.0, **more: Any) -> None:
    """A point (2,) [m]."""
    axes.plot([point[1]], [point[0]], "o", color=colour, ms=size, zorder=6, **more)


def draw_points(axes: Axes, points: Array, colour: str, size: float, zorder: float) -> None:
    """Obstacles as points (N, 2) [m]."""
    axes.plot(points[:, 1], points[:, 0], ".", color=colour, ms=size, mew=0, zorder=zorder)


def draw_hits(
    axes: Axes, scan: LaserScan, T_base_laser: Pose2, colour: str = WALL, size: float = 3.0, zorder: float = 2
) -> None:
    """What the beams of a scan hit."""
    beams = BeamGeometry(len(scan.ranges), scan.angle_min, scan.angle_increment, T_base_laser)
    draw_points(axes, beams.hits(*read_beams(scan)), colour, size, zorder)


def draw_chair(axes: Axes, footprint: Footprint, face: str = translucent(BODY), edge: str = WAY) -> None:
    """The chair in base_link."""
    axes.add_patch(Polygon(footprint.corners()[:, ::-1], facecolor=face, edgecolor=edge, lw=1.0, zorder=4))


def draw_stick(axes: Axes, joystick: Sequence[float] | Array, length: float = 0.75) -> None:
    """The joystick as an arrow from the axle, cased as a plan is."""
    tip = (joystick[1] * length, joystick[0] * length)
    arrow = {"arrowstyle": "-|>", "color": STICK, "lw": 2.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 12}
    arrow["path_effects"] = [withStroke(linewidth=3.6, foreground="white")]
    axes.annotate("", xy=tip, xytext=(0, 0), arrowprops=arrow, zorder=7)


def draw_window(axes: Axes, values: NDArray[np.floating], **more: Any) -> AxesImage:
    """A window of cells [iy, ix] behind everything else."""
    extent = (-WINDOW, WINDOW, -WINDOW, WINDOW)
    return axes.imshow(values.T, origin="lower", extent=extent, interpolation="nearest", zorder=0, **more)


def cover_cells(axes: Axes, mask: NDArray[np.bool_], grey: float) -> None:
    """Paints the cells of a mask [iy, ix] in one shade of grey, 1 = white."""
    shade = np.zeros((*mask.shape, 4))
    shade[mask] = (grey, grey, grey, 1.0)
    extent = (-WINDOW, WINDOW, -WINDOW, WINDOW)
    axes.imshow(shade.transpose(1, 0, 2), origin="lower", extent=extent, interpolation="nearest", zorder=1)
