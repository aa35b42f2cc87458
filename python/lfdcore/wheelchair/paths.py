"""Paths as polylines: points at arc lengths and beyond the end, distances, the median of many.

All are (N, 2) [m] in one frame, mostly base_link when the path was made.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import arc_length

Floats = NDArray[np.float64]
TAIL = 0.25
"""[m] of a path's end that says in which direction it goes on"""
_SHORTEST = 1e-9  # [m] of a step that has a direction


def along(path: Floats, at: Floats, tail: float = TAIL) -> Floats:
    """Points (K, 2) of a path (M, 2) at arc lengths `at` (K,) [m]; beyond its end straight on, as its last `tail` [m]
    point. ValueError for a path without length."""
    length = arc_length(path)
    kept = np.r_[True, np.diff(length) > _SHORTEST]
    path, length = path[kept], length[kept]
    if len(path) < 2:
        raise ValueError(f"a path of length {length[-1]} m has no direction to go on in, must be longer than 0 m")
    back = min(int(np.searchsorted(length, length[-1] - tail)), len(path) - 2)
    ahead = (path[-1] - path[back]) / np.linalg.norm(path[-1] - path[back]).clip(min=_SHORTEST)
    inside = np.stack([np.interp(at, length, path[:, axis]) for axis in (0, 1)], 1)
    return np.asarray(inside + np.maximum(at - length[-1], 0.0)[:, None] * ahead)


def distance_to_polyline(points: Floats, line: Floats) -> Floats:
    """(K,) [m] from points (K, 2) to the nearest place of a line (M, 2), M >= 2."""
    start, step = line[:-1], np.diff(line, axis=0)
    to = points[:, None] - start
    share = np.clip((to * step).sum(2) / np.maximum((step**2).sum(1), 1e-12), 0, 1)
    return np.asarray(np.linalg.norm(to - share[..., None] * step, axis=2).min(axis=1))


def geometric_median(paths: Floats, weights: Floats, iterations: int, nearest: float = 0.01) -> Floats:
    """Paths (N, A, 2) with weights (N,), none negative and not all 0 -> (A, 2): at each of the A places the point of
    the least weighted sum of distances (Weiszfeld's algorithm from the mean; distances below `nearest` [m] count as
    that)."""
    points, weight = np.ascontiguousarray(paths.transpose(2, 1, 0)), weights / weights.sum()  # (2, A, N)
    median = points @ weight
    for _ in range(iterations):
        pull = weight / np.maximum(np.hypot(*(points - median[:, :, None])), nearest)
        median = (points * pull).sum(axis=2) / pull.sum(axis=1)
    return np.asarray(median.T)
