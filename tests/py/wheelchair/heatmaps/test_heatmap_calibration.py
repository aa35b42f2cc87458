"""What heat means as a probability, and how that is judged."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import isotonic_regression

from heatmap_drives import around_the_corner, corridor_log
from lfdcore.study.heatmaps.calibration import crossed_cells, reliability
from lfdcore.wheelchair.heatmaps.calibration import HeatmapCalibration, pooled


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(0.1, 9)), min_size=1, max_size=30))
def test_pooling_is_scipys_isotonic_regression(rows):
    values, weights = np.array(rows).T
    np.testing.assert_allclose(pooled(values, weights), isotonic_regression(values, weights=weights).x, atol=1e-9)


def cells(n, seed):
    rng = np.random.default_rng(seed)
    heat = rng.beta(0.4, 3, n)
    return heat, rng.random(n) < 0.7 * heat**2


def test_probabilities_come_near_the_true_law_on_cells_never_seen():
    calibration = HeatmapCalibration.fit(*cells(200_000, 1))
    at = np.linspace(0.05, 0.8, 20)
    np.testing.assert_allclose(calibration.probabilities(at), 0.7 * at**2, atol=0.04)
    heat, crossed = cells(50_000, 2)
    judged = reliability(calibration.probabilities(heat), crossed)
    assert judged.error < 0.01 and judged.top_error < 0.04
    assert judged.brier < 0.9 * judged.constant_brier
    assert reliability(heat, crossed).error > 3 * judged.error  # heat itself is no probability


def test_probability_never_falls_with_heat():
    calibration = HeatmapCalibration.fit(*cells(500, 3))
    assert (np.diff(calibration.probabilities(np.linspace(0, 1, 500))) >= 0).all()


def test_the_constant_rate_is_calibrated_and_knows_nothing():
    heat, crossed = cells(50_000, 4)
    rate = crossed.mean()
    judged = reliability(np.full(len(heat), rate), crossed, rate)
    assert judged.error == pytest.approx(0, abs=1e-9)
    assert judged.brier == judged.constant_brier == pytest.approx(rate * (1 - rate))


def test_the_error_is_the_one_counted_by_hand():
    p, y = np.array([0.05, 0.06, 0.5, 0.9, 0.95]), np.array([0, 1, 0, 1, 1], bool)
    by_hand = (2 * abs(0.055 - 0.5) + abs(0.5 - 0.0) + 2 * abs(0.925 - 1.0)) / 5
    judged = reliability(p, y, bins=5)
    assert judged.error == pytest.approx(by_hand)
    np.testing.assert_array_equal(judged.count, [2, 1, 2])


def test_the_likeliest_cells_are_those_with_half_of_all_crossings():
    p, y = np.array([0.1, 0.9, 0.3, 0.8, 0.2, 0.0]), np.array([1, 1, 0, 1, 1, 0], bool)
    judged = reliability(p, y)
    assert judged.top_error == pytest.approx((abs(0.9 - 1) + abs(0.8 - 1)) / 2)  # 2 of 4 crossings in the first two
    assert np.isnan(reliability(p, np.zeros(6, bool)).top_error)


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_cells_all_alike_have_one_probability(value):
    calibration = HeatmapCalibration.fit(np.full(10, value), np.arange(10) < 3)
    np.testing.assert_allclose(calibration.probabilities(np.array([0.0, 0.5, 1.0])), 0.3, rtol=1e-6)
    nothing = HeatmapCalibration.fit(np.linspace(0, 1, 10), np.zeros(10, bool))
    assert not nothing.probabilities(np.array([0.0, 1.0])).any()


def test_what_cannot_be_calibrated_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        HeatmapCalibration.fit(np.zeros(0), np.zeros(0, bool))
    with pytest.raises(ValueError, match=r"\[0, 1\]"):
        HeatmapCalibration.fit(np.array([0.1, np.nan]), np.array([True, False]))
    with pytest.raises(ValueError, match="rise strictly"):
        HeatmapCalibration(np.array([0.5, 0.5]), np.array([0.1, 0.2]))
    with pytest.raises(ValueError, match="not fall"):
        HeatmapCalibration(np.array([0.1, 0.5]), np.array([0.3, 0.2]))
    with pytest.raises(ValueError, match=r"\[0, 1\]"):
        reliability(np.array([1.1]), np.array([True]))


def test_crossed_cells_are_those_of_the_way_driven_next():
    log = around_the_corner()
    ahead = crossed_cells(log, 0)
    assert ahead is not None
    rows, columns = np.nonzero(ahead)
    assert set(rows) <= {49, 50} and set(columns) == set(range(50, 100))
    turn = crossed_cells(log, 60)
    assert turn is not None
    pose, way = log.pose_at([log.scan_stamp[60]])[0], 0.0
    inside, k = 0, 60
    for k in range(60, len(log.pose)):
        a, b = log.pose[k : k + 2]
        step = np.hypot(*(b - a)[:2])
        if way + step > 2.5:
            break
        way += step
        c, s = np.cos(pose[2]), np.sin(pose[2])
        x, y = np.array([[c, s], [-s, c]]) @ (b - pose)[:2]
        inside += k < 63 or turn[int((y + 2.5) // 0.05), int((x + 2.5) // 0.05)]  # at first y = 0, between two rows
    assert way > 2.3 and inside == k - 60
    assert 50 <= turn.sum() <= 90  # 2.5 m in cells of .05 m


def test_where_the_log_ends_first_nobody_knows():
    log = corridor_log([(3.0, 0.8, 0.0)])
    assert crossed_cells(log, 0, reach=2.0) is not None
    assert crossed_cells(log, 20) is None
