"""distance_field and inflate against SciPy and against every pair of cells."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from lfdcore.grid import distance_field, inflate


@settings(max_examples=100, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    height=st.integers(1, 60),
    width=st.integers(1, 60),
    density=st.sampled_from([0.001, 0.02, 0.3, 0.9]),
)
def test_equals_scipys_exact_transform(seed: int, height: int, width: int, density: float) -> None:
    rng = np.random.default_rng(seed)
    occupied = rng.random((height, width)) < density
    occupied[rng.integers(height), rng.integers(width)] = True
    expected = distance_transform_edt(~occupied) * 0.05
    field = distance_field(occupied, 0.05)
    assert field.dtype == np.float32
    # float32 rounds the root and the product.
    np.testing.assert_allclose(field, expected, rtol=3e-7)


def test_one_cell_gives_its_distance_everywhere() -> None:
    occupied = np.zeros((5, 9), bool)
    occupied[1, 6] = True
    iy, ix = np.mgrid[0:5, 0:9]
    np.testing.assert_allclose(distance_field(occupied, 0.5), 0.5 * np.hypot(ix - 6, iy - 1), rtol=3e-7)


def test_no_occupied_cell_is_infinitely_far() -> None:
    assert np.isinf(distance_field(np.zeros((4, 5), bool), 0.05)).all()
    assert not inflate(np.zeros((4, 5), bool), 1.0, 0.05).any()


def test_a_large_map_equals_scipys() -> None:
    occupied = np.random.default_rng(0).random((700, 1100)) < 1e-4
    np.testing.assert_allclose(distance_field(occupied, 1.0), distance_transform_edt(~occupied), rtol=3e-7)


@pytest.mark.parametrize("cells", [0, 1, 5, 7, 13])
def test_inflating_by_whole_cells_includes_the_cells_at_that_distance(cells: int) -> None:
    occupied = np.zeros((31, 31), bool)
    occupied[15, 15] = True
    iy, ix = np.mgrid[0:31, 0:31]
    expected = (ix - 15) ** 2 + (iy - 15) ** 2 <= cells**2
    np.testing.assert_array_equal(inflate(occupied, 0.05 * cells, 0.05), expected)
    np.testing.assert_array_equal(inflate(occupied, cells / 20, 0.05), expected)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), radius=st.floats(0, 20))
def test_inflating_is_the_distance_field_cut_at_the_radius(seed: int, radius: float) -> None:
    occupied = np.random.default_rng(seed).random((30, 40)) < 0.02
    if not occupied.any():
        return
    distance = distance_transform_edt(~occupied)
    unclear = np.abs(distance - radius) < 1e-6
    np.testing.assert_array_equal(inflate(occupied, radius, 1.0)[~unclear], (distance <= radius)[~unclear])


def test_sizes_and_lengths_that_make_no_sense_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="occupied is 0 x 5 cells"):
        distance_field(np.zeros((0, 5), bool), 0.05)
    for resolution in (0.0, -0.05, np.nan, np.inf):
        with pytest.raises(ValueError, match="resolution"):
            distance_field(np.zeros((3, 3), bool), resolution)
    for radius in (-0.1, np.nan, np.inf):
        with pytest.raises(ValueError, match="radius"):
            inflate(np.zeros((3, 3), bool), radius, 0.05)
