"""The path that a heatmap predicts."""

import numpy as np
import pytest
from scipy.optimize import minimize

from lfdcore.wheelchair.heatmaps.path import heatmap_path
from lfdcore.wheelchair.paths import geometric_median
from lfdcore.wheelchair.window import cell_centres

CENTRES = cell_centres()


def around(path, sigma=0.1):
    """Heat around a path (M, 2) [m]."""
    distance = np.linalg.norm(CENTRES[:, :, None] - path, axis=3).min(axis=2)
    return np.exp(-((distance / sigma) ** 2) / 2)


def arc(curvature):
    s = np.linspace(0.01, 2.5, 80)
    return np.stack([np.sin(curvature * s) / curvature, (1 - np.cos(curvature * s)) / curvature], 1)


@pytest.mark.parametrize("curvature", [-0.8, -0.3, 0.05, 0.5, 0.8])
def test_it_finds_the_arc_that_the_heat_lies_around(curvature):
    path = heatmap_path(around(arc(curvature)))
    assert np.linalg.norm(path[:, None] - arc(curvature), axis=2).min(axis=1).max() < 0.05  # a cell
    np.testing.assert_allclose(np.linalg.norm(np.diff(path, axis=0), axis=1), 0.1, atol=5e-3)


def test_the_median_is_the_point_of_the_least_expected_distance():
    rng = np.random.default_rng(3)
    points, weight = rng.normal(size=(60, 2)), rng.random(60)
    cost = lambda at: (weight * np.linalg.norm(points - at, axis=1)).sum()  # noqa: E731
    best = minimize(cost, points.mean(0), method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-9})
    assert cost(geometric_median(points[:, None], weight, 10)[0]) < best.fun * 1.001


def test_of_two_ways_it_follows_the_likelier():
    likely, other = around(arc(0.6)), around(arc(-0.6))
    end = heatmap_path(likely + 0.3 * other)[-1]
    assert np.linalg.norm(end - arc(0.6)[-1]) < 0.5
    assert end[1] > 0


def test_a_mirrored_heatmap_has_the_mirrored_path():
    heat = np.random.default_rng(1).random((100, 100))
    np.testing.assert_allclose(heatmap_path(heat[::-1]), heatmap_path(heat) * [1, -1], atol=1e-9)


def test_scale_does_not_matter():
    heat = around(arc(0.4))
    np.testing.assert_allclose(heatmap_path(heat * 1e-3), heatmap_path(heat), atol=1e-9)


def test_a_heatmap_without_heat_ahead_predicts_nothing():
    assert heatmap_path(np.zeros((100, 100))) is None
    behind = np.zeros((100, 100))
    behind[:, :50] = 1
    assert heatmap_path(behind) is None


@pytest.mark.parametrize("heat", [np.ones((50, 50)), np.full((100, 100), np.nan), np.full((100, 100), -1.0)])
def test_what_is_no_heatmap_is_refused(heat):
    with pytest.raises(ValueError, match="finite and not negative"):
        heatmap_path(heat)
