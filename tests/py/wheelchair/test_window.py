"""Images of the local window: values by place, and scaling."""

import numpy as np
import pytest

from lfdcore.planning import HeatmapRewardConfig, RewardConfig, heatmap_reward, path_reward
from lfdcore.wheelchair.window import blocked_mask, border_mask, cell_centres, squashed, values_at


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


def test_what_was_blocked_is_read_back_from_the_rewards_of_both_planners():
    rng = np.random.default_rng(2)
    blocked = rng.random((100, 100)) < 0.2
    cells = np.array([[k, 50] for k in range(50, 80)])
    inside = blocked & ~border_mask()
    reward = path_reward(blocked, cells, RewardConfig())
    np.testing.assert_array_equal(blocked_mask(reward, RewardConfig().obstacle), inside)
    reward = heatmap_reward(rng.random((100, 100)).astype(np.float32), blocked, HeatmapRewardConfig())
    np.testing.assert_array_equal(blocked_mask(reward, HeatmapRewardConfig().obstacle), inside)


def test_the_border_is_one_cell_wide_all_around():
    assert border_mask().sum() == 4 * 99 and not border_mask()[1:-1, 1:-1].any()
