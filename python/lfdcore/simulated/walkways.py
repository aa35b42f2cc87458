"""Ground to walk on: where a person's disc is free of walls, and the way from everywhere to a few places of a map."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.routes import Point, RouteConfig, RoutePlanner

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_ROOM = 0.10
"""Clearance [m] beyond the disc's radius where people set out and turn."""


class Walkways:
    """Of discs of `radius` [m] in a map, where they get to from `origin` [m].

    places: how many are chosen to walk to, as far from each other as the map allows; the first is drawn by `rng`.
    Unknown cells and what lies beyond the map count as walls. ValueError where the map has no room at all.
    """

    def __init__(
        self, grid: OccupancyGrid, radius: float, origin: Point, places: int, rng: np.random.Generator
    ) -> None:
        config = RouteConfig(min_clearance=radius + 0.05, wanted_clearance=radius + 0.35, wall_cost=2.0)
        self._planner = RoutePlanner(grid, config)
        reached = np.isfinite(self._planner.distances_from(origin))
        roomy = reached & (self._planner.node_clearance() >= radius + _ROOM)
        if not roomy.any():
            raise ValueError(f"no place with {radius + _ROOM:.2f} m of free ground around it can be reached on foot")
        self.ground = self._planner.node_points()[roomy]
        """(M, 2) [m] where people may set out"""
        self.places = _far_apart(self.ground, places, int(rng.integers(len(self.ground))))
        """(places, 2) [m]"""
        self._ways = self._planner.ways_to([(float(x), float(y)) for x, y in self.places])
        self._ahead = _eight_on(self._ways.after)
        iy, ix = distance_transform_edt(~reached, return_distances=False, return_indices=True)
        self._nearest = self._ways.numbers[iy, ix]

    def gap(self, points: FloatArray) -> FloatArray:
        """Distance (...) [m] from points (..., 2) [m] to the nearest wall or less, by up to 1.5 cells; never more."""
        grid = self._planner.grid
        cells = (points - np.array(grid.origin)) / grid.resolution
        at = np.floor(cells).astype(np.int64)
        inside = ((at >= 0) & (at < [grid.width, grid.height])).all(axis=-1)
        ix, iy = np.where(inside, at[..., 0], 0), np.where(inside, at[..., 1], 0)
        # by the triangle inequality from the cell's centre to the centre of a wall's cell, and that to its corner
        off = cells - at - 0.5
        aside = np.hypot(off[..., 0], off[..., 1]) + np.sqrt(0.5) - 0.5
        return np.asarray(np.where(inside, self._planner.clearance[iy, ix] - aside * grid.resolution, -np.inf))

    def heading(self, place: IntArray, points: FloatArray) -> FloatArray:
        """Directions (N, 2), of length 1 or 0, in which to set out from points (N, 2) [m] for the places (N,)."""
        towards = self._ways.points[self._ahead[place, self._node(points)]] - points
        length = np.hypot(towards[:, 0], towards[:, 1])
        return np.asarray(towards / np.maximum(length, 1e-9)[:, None])

    def way_left(self, place: IntArray, points: FloatArray) -> FloatArray:
        """Cost (N,) of the way from points (N, 2) [m] to the places (N,): its length [m], more beside walls."""
        return np.asarray(self._ways.cost[place, self._node(points)])

    def _node(self, points: FloatArray) -> IntArray:
        height, width = self._nearest.shape
        ix, iy = np.clip(self._planner.nodes_at(points), 0, [width - 1, height - 1]).T
        return np.asarray(self._nearest[iy, ix])


def _far_apart(points: FloatArray, count: int, first: int) -> FloatArray:
    """Of points (M, 2) the first, then one by one that which is farthest from all chosen before."""
    chosen = [first]
    away = np.full(len(points), np.inf)
    while len(chosen) < count:
        away = np.minimum(away, np.hypot(*(points - points[chosen[-1]]).T))
        chosen.append(int(np.argmax(away)))
    return points[chosen]


def _eight_on(after: IntArray) -> IntArray:
    """From the next node (G, n) of each way to the eighth: .8 m ahead."""
    for _ in range(3):
        after = np.take_along_axis(after, after, axis=1)
    return after
