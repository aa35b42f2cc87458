"""The local window's cells (Sec. 3.3): 100 x 100 of 0.05 m around base_link, data[iy, ix]."""

import numpy as np
from numpy.typing import NDArray

from lfdcore.grid import OccupancyGrid

WINDOW = 2.5
"""Half the side of the local window [m]: x and y in base_link lie within +-WINDOW (Sec. 3.2: 5 m square)."""
CELLS = 100
RESOLUTION = 2 * WINDOW / CELLS
"""[m]"""


def cell_keys(points: NDArray[np.float64]) -> NDArray[np.int32]:
    """Points (N, 2) [m] in base_link -> flat cell index iy * 100 + ix (N,); ValueError outside the window."""
    index = np.floor((points + WINDOW) / RESOLUTION)
    if not ((index >= 0) & (index < CELLS)).all():
        raise ValueError(f"a point lies outside the local window of +-{WINDOW} m")
    return (index[:, 1] * CELLS + index[:, 0]).astype(np.int32)


def key_centres(keys: NDArray[np.int32]) -> NDArray[np.float64]:
    """Flat cell indices (N,) -> centres (N, 2) [m] in base_link."""
    cells = np.stack([keys % CELLS, keys // CELLS], 1).astype(np.float64)
    return (cells + 0.5) * RESOLUTION - WINDOW


def cell_centres() -> NDArray[np.float64]:
    """(100, 100, 2) [m]: centres of all cells, indexed [iy, ix]."""
    return key_centres(np.arange(CELLS * CELLS, dtype=np.int32)).reshape(CELLS, CELLS, 2)


def values_at(image: NDArray[np.floating], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """An image (100, 100) of the window at points (N, 2) [m] in base_link -> (N,): their cells' values, 0 outside."""
    cells = np.floor((points + WINDOW) / RESOLUTION)
    inside = np.flatnonzero(((cells >= 0) & (cells < CELLS)).all(axis=1))
    ix, iy = cells[inside].astype(int).T
    values = np.zeros(len(points))
    values[inside] = image[iy, ix]
    return values


def squashed(heatmap: NDArray[np.float32]) -> NDArray[np.float32]:
    """Divided by its maximum (F12); an all-zero heatmap stays."""
    most = heatmap.max(initial=np.float32(0))
    return np.asarray(heatmap / most if most > 0 else heatmap, np.float32)


def require_between(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """ValueError naming a config's field unless low <= value <= high; NaN is not between."""
    if not low <= value <= high:
        raise ValueError(f"{name} is {value}{unit}, must be between {low:g} and {high:g}{unit}")


def free_mask(grid: OccupancyGrid) -> NDArray[np.bool_]:
    """(height, width): the cells of a grid that were seen free."""
    return np.asarray(grid.data == 0)


def border_mask() -> NDArray[np.bool_]:
    """(100, 100): the cells on the window's border, which planners are kept from."""
    border = np.ones((CELLS, CELLS), dtype=bool)
    border[1:-1, 1:-1] = False
    return border


def blocked_mask(reward: NDArray[np.floating], obstacle: float) -> NDArray[np.bool_]:
    """(100, 100): the cells that a planner did not enter, read back from the rewards (100, 100) it planned over: those
    with an `obstacle`'s reward. Those on the border have it too, but only so that no path stays on them."""
    return np.asarray((reward <= obstacle) & ~border_mask())
