"""Draws occupancy grids from walls, boxes and discs in metres."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lfdcore.grid import OccupancyGrid

WALL_THICKNESS = 0.10
"""Thickness [m] of a drawn wall: two cells."""


@dataclass(frozen=True)
class Door:
    """An opening in a wall that a route may use.

    x, y: its centre [m, map]; along: the axis along which one drives through it ('x' or 'y'); width: clear [m];
    depth: the wall's thickness [m].
    """

    x: float
    y: float
    along: str
    width: float
    depth: float = WALL_THICKNESS

    def waypoints(self, direction: int, reach: float = 0.9) -> list[tuple[float, float]]:
        """Before, in and behind the door, `reach` [m] from its middle; direction: +1 or -1 along its axis."""
        dx, dy = (direction * reach, 0.0) if self.along == "x" else (0.0, direction * reach)
        return [(self.x - dx, self.y - dy), (self.x, self.y), (self.x + dx, self.y + dy)]


class Drawing:
    """A rectangular world of `width` x `height` [m] with walls all around; its corner is the map's origin."""

    def __init__(self, width: float, height: float, resolution: float = 0.05) -> None:
        self.resolution = resolution
        self.cells: npt.NDArray[np.int8] = np.zeros((self._index(height), self._index(width)), dtype=np.int8)
        self.doors: list[Door] = []
        self._frame()

    def _index(self, metres: float) -> int:
        return round(metres / self.resolution)

    def _frame(self) -> None:
        thick = self._index(WALL_THICKNESS)
        for edge in (np.s_[:thick, :], np.s_[-thick:, :], np.s_[:, :thick], np.s_[:, -thick:]):
            self.cells[edge] = 100

    def _fill(self, x0: float, y0: float, x1: float, y1: float, value: int) -> None:
        ix, iy = sorted((self._index(x0), self._index(x1))), sorted((self._index(y0), self._index(y1)))
        self.cells[max(iy[0], 0) : iy[1], max(ix[0], 0) : ix[1]] = value

    def box(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """A solid axis-aligned rectangle between two corners [m]."""
        self._fill(x0, y0, x1, y1, 100)

    def boxes(self, *corners: tuple[float, float, float, float]) -> None:
        """Several solid rectangles (x0, y0, x1, y1) [m]."""
        for box in corners:
            self.box(*box)

    def wall(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """A horizontal or vertical wall around the line between two points [m]."""
        half = WALL_THICKNESS / 2
        self.box(min(x0, x1) - half, min(y0, y1) - half, max(x0, x1) + half, max(y0, y1) + half)

    def walls(self, *lines: tuple[float, float, float, float]) -> None:
        """Several walls (x0, y0, x1, y1) [m]."""
        for line in lines:
            self.wall(*line)

    def disc(self, x: float, y: float, radius: float) -> None:
        """A solid disc [m]."""
        iy, ix = np.indices(self.cells.shape)
        away = np.hypot((ix + 0.5) * self.resolution - x, (iy + 0.5) * self.resolution - y)
        self.cells[away <= radius] = 100

    def discs(self, radius: float, *centres: tuple[float, float]) -> None:
        """Several solid discs of one radius [m]."""
        for x, y in centres:
            self.disc(x, y, radius)

    def door(self, x: float, y: float, along: str, width: float, depth: float = WALL_THICKNESS) -> Door:
        """Cuts an opening through `depth` [m] of wall. Its width must be an even number of cells, so that it is exact.

        Raises ValueError for another width or an axis that is not 'x' or 'y'.
        """
        if along not in ("x", "y"):
            raise ValueError(f"along must be 'x' or 'y', got {along!r}")
        if not math.isclose(width / (2 * self.resolution), round(width / (2 * self.resolution)), abs_tol=1e-6):
            raise ValueError(f"width must be a multiple of {2 * self.resolution} m, got {width} m")
        half_x, half_y = (depth / 2, width / 2) if along == "x" else (width / 2, depth / 2)
        self._fill(x - half_x, y - half_y, x + half_x, y + half_y, 0)
        door = Door(x, y, along, width, depth)
        self.doors.append(door)
        return door

    def grid(self) -> OccupancyGrid:
        """The drawn world; the map's origin is the lower left corner."""
        return OccupancyGrid(self.cells.copy(), self.resolution, (0.0, 0.0))
