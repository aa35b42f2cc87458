"""Reference routes: shortest paths that keep off the walls, smoothed as an elastic band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt, gaussian_filter1d, map_coordinates
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lfdcore.geometry import arc_length, resample
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.drawing import Door

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float]
Zone = tuple[slice, int, float]
"""A stretch of a path, the axis across a door and the door's middle [m] on that axis."""


@dataclass(frozen=True)
class RouteConfig:
    """How routes are planned; distances [m] are from the axle's centre to the nearest edge of an obstacle."""

    min_clearance: float = 0.40  # the chair's half-width + .05
    wanted_clearance: float = 0.90  # no pull away from walls beyond; about the nose's reach
    wall_cost: float = 6.0  # extra cost per metre at min_clearance, falling to 0 at wanted_clearance
    planning_cell: float = 0.10  # the search skips cells finer than this
    margin: float = 5.0  # the search first stays within this box around both ends
    spacing: float = 0.10  # between the route's points
    rounds: int = 3  # of smoothing and resampling
    iterations: int = 50  # of the elastic band a round
    tension: float = 0.35  # share of the way to the neighbours' mean
    repulsion: float = 0.03  # step per metre short of wanted_clearance
    run_in: float = 1.35  # before a door the route keeps to its axis, since the nose is in before the axle
    run_out: float = 0.60  # the same behind it
    corner: float = 0.22  # standard deviation along the route of the final rounding of corners


@dataclass(frozen=True)
class Ways:
    """Cheapest ways from n passable nodes of a search to G goals."""

    numbers: npt.NDArray[np.int64]
    """(h, w) of the nodes; -1 where none is passable"""
    points: FloatArray
    """(n, 2) [m]"""
    cost: FloatArray
    """(G, n) from each node to the goal; inf where there is no way"""
    after: npt.NDArray[np.int64]
    """(G, n) the node that comes next on the way; at its end, or without a way, the node itself"""


def clearance_field(grid: OccupancyGrid) -> FloatArray:
    """Distance (H, W) [m] from each cell's centre to the nearest edge of an occupied or unknown cell, about."""
    open_cells = (grid.data >= 0) & ~grid.occupied_mask()
    padded = np.pad(open_cells, 1)  # beyond the map is not free
    away = distance_transform_edt(padded)[1:-1, 1:-1] * grid.resolution
    return np.asarray(np.maximum(away - grid.resolution / 2, 0.0))


def route_clearance(grid: OccupancyGrid, route: FloatArray) -> FloatArray:
    """Exact distance (N,) [m] from each point of a route (N, 2) to the nearest occupied cell's square; inf if none."""
    iy, ix = np.nonzero(grid.occupied_mask())
    if len(ix) == 0:
        return np.full(len(route), np.inf)
    centres = np.stack([ix + 0.5, iy + 0.5], axis=1) * grid.resolution + np.array(grid.origin)
    _, nearest = cKDTree(centres).query(route, k=min(12, len(centres)))
    nearest = np.reshape(nearest, (len(route), -1))
    gaps = np.maximum(np.abs(centres[nearest] - route[:, None]) - grid.resolution / 2, 0.0)
    return np.asarray(np.hypot(gaps[..., 0], gaps[..., 1]).min(axis=1))


class RoutePlanner:
    """Plans and smooths routes through waypoints on one map."""

    def __init__(self, grid: OccupancyGrid, config: RouteConfig | None = None, doors: Sequence[Door] = ()) -> None:
        self.config = config or RouteConfig()
        self._doors = doors
        self.grid = grid
        self.clearance = clearance_field(grid)
        self._slope = np.gradient(self.clearance, grid.resolution)
        self._stride = max(1, round(self.config.planning_cell / grid.resolution))
        self._cell = self._stride * grid.resolution
        self._coarse = self.clearance[:: self._stride, :: self._stride]
        short = np.clip(self.config.wanted_clearance - self._coarse, 0.0, None)
        self._cost = 1 + self.config.wall_cost * short / (self.config.wanted_clearance - self.config.min_clearance)
        self._passable = self._coarse >= self.config.min_clearance - 1e-9

    # -- cells of the search ------------------------------------------------------------------------------------

    def nodes_at(self, points: FloatArray) -> npt.NDArray[np.int64]:
        """Index (N, 2) ix, iy of the node of the search that is nearest to each point (N, 2) [m]; may lie outside."""
        offset = np.array(self.grid.origin) + self.grid.resolution / 2
        return np.rint((points - offset) / self._cell).astype(np.int64)

    def _points_at(self, nodes: npt.NDArray[np.int64]) -> FloatArray:
        return np.asarray(nodes * self._cell + np.array(self.grid.origin) + self.grid.resolution / 2)

    def _snap(self, point: Point) -> tuple[int, int]:
        """The nearest passable node within 1 m of a point."""
        ix, iy = self.nodes_at(np.array([point]))[0]
        reach = int(1.0 / self._cell)
        y0, x0 = max(iy - reach, 0), max(ix - reach, 0)
        rows, cols = np.nonzero(self._passable[y0 : iy + reach + 1, x0 : ix + reach + 1])
        if len(rows) == 0:
            raise ValueError(f"waypoint {point} m lies more than 1 m from any place that the chair can reach")
        best = np.argmin((rows + y0 - iy) ** 2 + (cols + x0 - ix) ** 2)
        return int(cols[best] + x0), int(rows[best] + y0)

    # -- search -------------------------------------------------------------------------------------------------

    def leg(self, start: Point, goal: Point) -> FloatArray | None:
        """The cheapest path (N, 2) [m] between two points on the inflated map, or None if there is none."""
        first, last = self._snap(start), self._snap(goal)
        height, width = self._passable.shape
        reach = int(self.config.margin / self._cell)
        near = (
            max(min(first[0], last[0]) - reach, 0),
            max(min(first[1], last[1]) - reach, 0),
            min(max(first[0], last[0]) + reach + 1, width),
            min(max(first[1], last[1]) + reach + 1, height),
        )
        for window in (near, (0, 0, width, height)):
            path = self._search(window, first, last)
            if path is not None:
                return path
        return None

    def _search(
        self, window: tuple[int, int, int, int], first: tuple[int, int], last: tuple[int, int]
    ) -> FloatArray | None:
        x0, y0, _, _ = window
        numbers, graph = self._graph(window)
        source, target = numbers[first[1] - y0, first[0] - x0], numbers[last[1] - y0, last[0] - x0]
        distance, before = dijkstra(graph, directed=False, indices=source, return_predecessors=True)
        if not np.isfinite(distance[target]):
            return None
        chain = [int(target)]
        while chain[-1] != source:
            chain.append(int(before[chain[-1]]))
        rows, cols = np.nonzero(numbers >= 0)
        order = np.array(chain[::-1])
        return self._points_at(np.stack([cols[order] + x0, rows[order] + y0], axis=1))

    def _graph(self, window: tuple[int, int, int, int]) -> tuple[npt.NDArray[np.int64], coo_matrix]:
        """Numbers (h, w) of the passable nodes (-1 elsewhere) and the weights [m x cost] of their 8-neighbourhood."""
        x0, y0, x1, y1 = window
        passable, cost = self._passable[y0:y1, x0:x1], self._cost[y0:y1, x0:x1]
        numbers = np.where(passable, np.cumsum(passable).reshape(passable.shape) - 1, -1)
        tails, heads, weights = [], [], []
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here, there = _shifted(dy, dx)
            both = passable[here] & passable[there]
            tails.append(numbers[here][both])
            heads.append(numbers[there][both])
            weights.append(np.hypot(dx, dy) * self._cell * (cost[here][both] + cost[there][both]) / 2)
        count = int(passable.sum())
        data = (np.concatenate(weights), (np.concatenate(tails), np.concatenate(heads)))
        return numbers, coo_matrix(data, shape=(count, count)).tocsr()

    def distances_from(self, start: Point) -> FloatArray:
        """Cost (h, w) of the cheapest way from a point to every node of the search; inf where there is none."""
        height, width = self._passable.shape
        numbers, graph = self._graph((0, 0, width, height))
        ix, iy = self._snap(start)
        found = dijkstra(graph, directed=False, indices=numbers[iy, ix])
        result = np.full(self._passable.shape, np.inf)
        result[numbers >= 0] = found
        return result

    def ways_to(self, goals: Sequence[Point]) -> Ways:
        """The cheapest ways from every passable node of the search to each of G goals."""
        height, width = self._passable.shape
        numbers, graph = self._graph((0, 0, width, height))
        ends = [numbers[iy, ix] for ix, iy in map(self._snap, goals)]
        cost, after = dijkstra(graph, directed=False, indices=ends, return_predecessors=True)
        after = np.where(after < 0, np.arange(after.shape[1]), after)
        iy, ix = np.nonzero(numbers >= 0)
        return Ways(numbers, self._points_at(np.stack([ix, iy], axis=1)), cost, after)

    def node_points(self) -> FloatArray:
        """Position (h, w, 2) [m] of every node of the search."""
        iy, ix = np.indices(self._passable.shape)
        return self._points_at(np.stack([ix, iy], axis=-1))

    def node_clearance(self) -> FloatArray:
        """Clearance (h, w) [m] of every node of the search."""
        return self._coarse

    # -- the whole route ----------------------------------------------------------------------------------------

    def route(self, waypoints: Sequence[Point], loop: bool = False) -> FloatArray:
        """A smooth route (N, 2) [m] by way of the waypoints, in turn; of a loop the last point repeats the first.

        Raises ValueError, naming the leg, if two waypoints are not connected.
        """
        if len(waypoints) < 2:
            raise ValueError(f"a route needs at least 2 waypoints, got {len(waypoints)}")
        stops = [*waypoints, waypoints[0]] if loop else list(waypoints)
        legs: list[FloatArray] = []
        for start, goal in pairwise(stops):
            leg = self.leg(start, goal)
            if leg is None:
                raise ValueError(f"no way for the chair from {start} to {goal} m")
            legs.append(leg if not legs else leg[1:])
        return self.smooth(np.concatenate(legs), loop)

    def smooth(self, path: FloatArray, loop: bool = False) -> FloatArray:
        """An elastic band from a path (N, 2) [m]: pulled straight by its neighbours, pushed off the walls."""
        for _ in range(self.config.rounds):
            path = self._evenly(path)
            zones = self._door_zones(path)
            for _ in range(self.config.iterations):
                path = self._relax(path, loop, zones)
        return self._evenly(self._round_corners(self._evenly(path), loop))

    def _round_corners(self, path: FloatArray, loop: bool) -> FloatArray:
        sigma = self.config.corner / self.config.spacing
        if loop:
            ring = gaussian_filter1d(path[:-1], sigma, axis=0, mode="wrap")
            return self._kept_clear(path, np.concatenate([ring, ring[:1]]))
        # reflected through its ends, so that they stay and do not shrink
        reach = min(len(path) - 1, int(4 * sigma) + 1)
        head, tail = 2 * path[0] - path[reach:0:-1], 2 * path[-1] - path[-2 : -2 - reach : -1]
        rounded = gaussian_filter1d(np.concatenate([head, path, tail]), sigma, axis=0)[reach:-reach]
        return self._kept_clear(path, rounded)

    def _kept_clear(self, path: FloatArray, moved: FloatArray) -> FloatArray:
        """The moved points, but not those that would come too near to something."""
        near = self._sample(self.clearance, moved) < self.config.min_clearance
        return np.where(near[:, None], path, moved)

    def _evenly(self, path: FloatArray) -> FloatArray:
        steps = max(2, round(float(arc_length(path)[-1]) / self.config.spacing))
        return np.asarray(resample(path, steps + 1))

    def _relax(self, path: FloatArray, loop: bool, zones: list[Zone]) -> FloatArray:
        ring = np.concatenate([path[-2:-1], path, path[1:2]])
        pull = self.config.tension * ((ring[:-2] + ring[2:]) / 2 - path)
        short = np.clip(self.config.wanted_clearance - self._sample(self.clearance, path), 0.0, None)
        slope = np.stack([self._sample(self._slope[1], path), self._sample(self._slope[0], path)], axis=1)
        moved = path + pull + self.config.repulsion * short[:, None] * slope
        for part, axis, middle in zones:
            moved[part, axis] += (middle - moved[part, axis]) / 2
        if not loop:
            moved[[0, -1]] = path[[0, -1]]
        return self._kept_clear(path, moved)

    def _door_zones(self, path: FloatArray) -> list[Zone]:
        """Where along a path it passes the doors: from run_in before to run_out behind each."""
        zones = []
        for door in self._doors:
            ahead, across = (0, 1) if door.along == "x" else (1, 0)
            middle = (door.x, door.y)
            before = round((self.config.run_in + door.depth / 2) / self.config.spacing)
            behind = round((self.config.run_out + door.depth / 2) / self.config.spacing)
            passed = np.diff(np.sign(path[:, ahead] - middle[ahead])) != 0
            inside = np.abs(path[1:, across] - middle[across]) < door.width / 2
            for at in np.nonzero(passed & inside)[0]:
                zones.append((slice(max(at - before, 1), at + behind), across, middle[across]))
        return zones

    def _sample(self, field: FloatArray, points: FloatArray) -> FloatArray:
        at = (points - np.array(self.grid.origin)) / self.grid.resolution - 0.5
        return np.asarray(map_coordinates(field, [at[:, 1], at[:, 0]], order=1, mode="nearest"))


def _shifted(dy: int, dx: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Slices of the nodes that have a neighbour at (dy, dx), dy >= 0, and of those neighbours."""
    rows = (slice(None, -dy), slice(dy, None)) if dy else (slice(None), slice(None))
    left, right = slice(None, -1), slice(1, None)
    cols = {0: (slice(None), slice(None)), 1: (left, right), -1: (right, left)}[dx]
    return (rows[0], cols[0]), (rows[1], cols[1])
