"""Rewards of Sec. 3.5 against SciPy, and the cells of a polyline."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from lfdcore.grid import OccupancyGrid
from lfdcore.planning import RewardConfig, path_cells, path_reward


def window(width: int = 100, height: int = 100, resolution: float = 0.05) -> OccupancyGrid:
    origin = (-width * resolution / 2, -height * resolution / 2)
    return OccupancyGrid(np.zeros((height, width), np.int8), resolution, origin)


def slow_reward(
    occupied: NDArray[np.bool_], path: NDArray[np.int64], sigma: float, first: float, last: float
) -> NDArray[np.float64]:
    border = np.ones(occupied.shape, bool)
    border[1:-1, 1:-1] = False
    forbidden = np.where(occupied | border, -100.0, 0.0)
    reward = gaussian_filter(forbidden, sigma, mode="constant", truncate=4.0)
    reward[path[:, 1], path[:, 0]] = np.linspace(first, last, len(path))
    return np.where(occupied | border, -100.0, reward)


@pytest.mark.parametrize("shape", [(1, 1), (3, 2), (17, 40), (100, 100)])
@pytest.mark.parametrize("sigma", [0.5, 2.0, 7.3])
def test_reward_equals_scipys_blur_with_obstacles_and_border_over_the_path(
    shape: tuple[int, int], sigma: float
) -> None:
    rng = np.random.default_rng(1)
    occupied = rng.random(shape) < 0.05
    cells = np.unique(rng.integers(0, shape, (12, 2)), axis=0)[:, ::-1]
    config = RewardConfig(blur_sigma=sigma, path_first=5, path_last=50)
    found = path_reward(occupied, cells, config)
    assert found.dtype == np.float32
    if len(cells) > 1:
        # float32 sums of up to 59 taps
        np.testing.assert_allclose(found, slow_reward(occupied, cells, sigma, 5, 50), atol=2e-4)


def test_defaults_are_the_printed_numbers() -> None:
    """Sec. 3.5: -100 on obstacles and border, 10..100 along the path, sigma of 2 cells."""
    config = RewardConfig()
    printed = (config.obstacle, config.border, config.blur_sigma, config.path_first, config.path_last)
    assert printed == (-100, -100, 2, 10, 100)
    reward = path_reward(np.zeros((100, 100), bool), np.array([[50, 50], [51, 50], [52, 51]]))
    assert (reward[50, 50], reward[50, 51], reward[51, 52]) == (10, 55, 100)


def test_without_blur_only_obstacles_and_border_are_negative() -> None:
    occupied = np.zeros((9, 7), bool)
    occupied[4, 2] = True
    reward = path_reward(occupied, np.empty((0, 2), int), RewardConfig(blur_sigma=0, obstacle=-7, border=-3))
    assert reward[4, 2] == -7
    assert (reward[1:-1, 1:-1] == 0).sum() == 7 * 5 - 1
    assert (reward[0] == -3).all()
    assert (reward[:, -1] == -3).all()


def test_a_path_of_one_cell_has_the_last_reward() -> None:
    assert path_reward(np.zeros((5, 5), bool), np.array([[2, 1]]))[1, 2] == 100


@settings(max_examples=60, deadline=None)
@given(points=st.lists(st.tuples(st.floats(-2.49, 2.49), st.floats(-1.49, 1.49)), min_size=1, max_size=8))
def test_cells_of_a_polyline_touch_differ_and_keep_close_to_it(points: list[tuple[float, float]]) -> None:
    grid = window(100, 60)
    cells = path_cells(np.array(points), grid)
    assert tuple(cells[0]) == grid.cell_at(*points[0])
    assert tuple(cells[-1]) == grid.cell_at(*points[-1])
    steps = np.abs(np.diff(cells, axis=0))
    assert (steps.max(axis=1, initial=1) == 1).all()
    centres = (cells + 0.5) * grid.resolution + np.array(grid.origin)
    dense = np.concatenate([np.linspace(a, b, 200) for a, b in zip(points[:1] + points, points, strict=False)])
    distance = np.linalg.norm(centres[:, None] - dense[None], axis=2).min(axis=1)
    # Half a cell of the line between cell centres, half a diagonal from there to the points
    assert distance.max() <= grid.resolution * (0.5 + 0.5 * np.sqrt(2)) + 0.02


def test_cells_outside_the_grid_are_left_out() -> None:
    cells = path_cells(np.array([[2.4, 0.0], [4.0, 0.0], [2.4, 0.1]]), window())
    assert (cells >= 0).all()
    assert (cells < 100).all()
    np.testing.assert_array_equal(cells[0], [98, 50])
    np.testing.assert_array_equal(cells[-1], [98, 52])
    assert path_cells(np.empty((0, 2)), window()).shape == (0, 2)


def test_bad_paths_and_configs_are_refused() -> None:
    with pytest.raises(ValueError, match="path point x is nan m, must be finite"):
        path_cells(np.array([[np.nan, 0.0]]), window())
    with pytest.raises(ValueError, match=r"path point y is .* cells from the grid's corner, must be between"):
        path_cells(np.array([[0.0, 1e9]]), window())
    with pytest.raises(ValueError, match=r"path cell 0 is \(5, 0\), must lie in the grid of 5 x 5"):
        path_reward(np.zeros((5, 5), bool), np.array([[5, 0]]))
    with pytest.raises(ValueError, match="array of integers"):
        path_reward(np.zeros((5, 5), bool), np.array([[1.5, 0.0]]))
    with pytest.raises(ValueError, match="at least 1 x 1"):
        path_reward(np.zeros((0, 5), bool), np.empty((0, 2), int))
    with pytest.raises(ValueError, match="blur_sigma is -1 cells, must be between 0 and 1000"):
        RewardConfig(blur_sigma=-1)


def test_config_pickles() -> None:
    config = pickle.loads(pickle.dumps(RewardConfig(border=-5, path_last=60)))
    assert (config.border, config.path_last) == (-5, 60)
