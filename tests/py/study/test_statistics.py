"""Intervals and tests against scipy's or a simulation's answer."""

import numpy as np
import pytest

from lfdcore.study.statistics import paired_test, proportion, summarise


def test_the_interval_of_the_mean_covers_the_truth_in_95_percent_of_samples() -> None:
    rng = np.random.default_rng(3)
    summaries = [summarise(rng.normal(2.0, 1.0, 8)) for _ in range(2000)]
    assert np.mean([s.low <= 2.0 <= s.high for s in summaries]) == pytest.approx(0.95, abs=0.015)


def test_missing_values_are_counted_and_left_out() -> None:
    s = summarise([1.0, np.nan, 3.0])
    assert (s.n, s.missing, s.mean) == (2, 1, 2.0)
    assert summarise([]).n == 0
    assert np.isnan(summarise([5.0]).sd)


def test_wilsons_interval_of_zero_and_all_successes_does_not_collapse() -> None:
    assert proportion(0, 20)[2] == pytest.approx(0.161, abs=0.001)
    assert proportion(20, 20)[1] == pytest.approx(0.839, abs=0.001)
    with pytest.raises(ValueError, match="successes is 3 of n 2"):
        proportion(3, 2)


def test_a_paired_shift_is_found_where_an_unpaired_test_would_drown_in_spread() -> None:
    rng = np.random.default_rng(4)
    base = rng.normal(0, 10, 12)
    result = paired_test(base, base + 0.5 + rng.normal(0, 0.1, 12))
    assert result.p < 0.01
    assert result.difference == pytest.approx(0.5, abs=0.1)


def test_equal_arms_have_p_one_and_shapes_must_agree() -> None:
    assert paired_test([1, 2, 3], [1, 2, 3]).p == 1.0
    assert np.isnan(paired_test([1], [2]).p)
    with pytest.raises(ValueError, match="must be equal"):
        paired_test([1, 2], [1])
