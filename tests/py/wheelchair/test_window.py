"""Images of the local window: values by place, and scaling."""

import numpy as np
import pytest

from lfdcore.wheelchair.window import cell_centres, squashed, values_at


def test_values_at_the_centres_are_the_image_and_0_beyond_it():
    image = np.random.default_rng(1).random((100, 100)).astype(np.float32)
    np.testing.assert_array_equal(values_at(image, cell_centres().reshape(-1, 2)), image.ravel())
    beyond = np.array([[2.51, 0.0], [-2.51, 0.0], [0.0, 2.5], [0.0, -40.0], [np.inf, 0.0], [0.0, np.nan]])
    assert not values_at(image + 1, beyond).any()


def test_a_point_in_the_left_front_is_of_high_row_and_column():
    image = np.zeros((100, 100), np.float32)
    image[90, 70] = 0.5  # y = 2.0 .. 2.05, x = 1.0 .. 1.05
    assert values_at(image, np.array([[1.02, 2.02], [2.02, 1.02]])) == pytest.approx([0.5, 0.0])


def test_squashing_divides_by_the_maximum_and_leaves_zeros():
    heat = np.array([[0.0, 0.5], [2.0, 1.0]], np.float32)
    np.testing.assert_array_equal(squashed(heat), heat / 2)
    assert not squashed(np.zeros((3, 3), np.float32)).any()
