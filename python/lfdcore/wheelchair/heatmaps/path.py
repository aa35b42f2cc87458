"""The path that a heatmap predicts (Sec. 4.6.2): at every distance the median of where the heat is.

Planning seeks the best place and takes one of two ways around an obstacle (Sec. 4.5); predicting a path at a small
mean error asks for the middle of all that is likely. At each distance from base_link the heat of the cells there is
taken for a density, and its geometric median (the point of the least expected distance) for the path's point.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lfdcore.wheelchair.paths import along, geometric_median
from lfdcore.wheelchair.window import CELLS, WINDOW, cell_centres

Floats = NDArray[np.float64]
RING = 0.06
"""[m] from a distance within which cells belong to it"""
_STEP = 0.1
_RINGS = np.arange(1, round(WINDOW / _STEP) + 1) * _STEP
_ITERATIONS = 10
_NEAREST = 0.02  # [m]: a cell nearer to the median counts as this far, or it would hold the median fast


def heatmap_path(heatmap: NDArray[np.floating], reach: float = WINDOW, points: int = 26) -> Floats | None:
    """(points, 2) [m] in base_link from the origin on, equally spaced up to `reach` [m], for a driver who goes forward
    (cells ahead of base_link count). heatmap (100, 100): not negative, of any scale. Distances without heat are passed
    over in a straight line, and after the last one with heat the path goes straight on; None without any heat ahead.

    ValueError for another shape, negative or infinite heat, a reach that is not positive, fewer than 2 points.
    """
    heat = np.asarray(heatmap, np.float64)
    if heat.shape != (CELLS, CELLS) or not ((heat >= 0) & np.isfinite(heat)).all():
        raise ValueError(f"a heatmap of shape {heat.shape} must be ({CELLS}, {CELLS}), finite and not negative")
    if not 0 < reach < np.inf or points < 2:
        raise ValueError(f"reach {reach} m must be positive and points {points} at least 2")
    found = [np.zeros(2)]
    for ring, centres in _rings():
        weight = heat[ring]
        if weight.max() > 1e-6 * heat.max():
            found.append(geometric_median(centres[:, None], weight, _ITERATIONS, _NEAREST)[0])
    return along(np.array(found), np.linspace(0.0, reach, points)) if len(found) > 1 else None


@lru_cache(maxsize=1)
def _rings() -> list[tuple[tuple[NDArray[np.int_], ...], Floats]]:
    centres = cell_centres()
    distance, ahead = np.hypot(centres[..., 0], centres[..., 1]), centres[..., 0] > 0
    masks = [np.nonzero((np.abs(distance - radius) < RING) & ahead) for radius in _RINGS]
    return [(mask, centres[mask]) for mask in masks]
