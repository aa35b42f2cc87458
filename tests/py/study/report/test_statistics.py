"""Intervals and tests against scipy's or a simulation's answer."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from lfdcore.study.report.statistics import (
    paired_ratio,
    paired_test,
    poisson_rate,
    proportion,
    summarise,
    summarise_bounded,
)


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


@given(st.lists(st.integers(-4, 4), min_size=2, max_size=9))
def test_the_paired_p_counts_all_signs_of_tied_ranks(differences: list[int]) -> None:
    nonzero = np.array([d for d in differences if d])
    rank = stats.rankdata(np.abs(nonzero))
    sums = np.array([np.dot(rank, signs) for signs in product((-1, 1), repeat=len(nonzero))])
    expected = float(np.mean(np.abs(sums) >= abs(np.dot(rank, np.sign(nonzero))) - 1e-9)) if len(nonzero) else 1.0
    assert paired_test(np.zeros(len(differences)), differences).p == pytest.approx(expected, abs=1e-12)


def test_the_paired_p_without_ties_is_scipys_exact_one() -> None:
    difference = np.random.default_rng(5).normal(0.3, 1.0, 40)
    exact = stats.wilcoxon(difference, method="exact").pvalue
    assert paired_test(np.zeros(40), difference).p == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("n", [10, 20, 200])
def test_pairs_without_a_difference_do_not_sharpen_the_paired_p(n: int) -> None:
    """Three contacts more, all in one direction, are 2 of 8 signs, however many pairs had none."""
    assert paired_test(np.zeros(n), [1, 1, 1] + [0] * (n - 3)).p == pytest.approx(0.25)


@given(st.lists(st.integers(0, 6), min_size=1, max_size=12))
def test_the_interval_of_a_mean_count_stays_within_the_counts_and_is_the_same_each_time(counts: list[int]) -> None:
    s = summarise_bounded(counts)
    assert s == summarise_bounded(counts) or len(counts) == 1
    assert (s.n, s.mean) == (len(counts), pytest.approx(np.mean(counts)))
    if len(counts) > 1:
        assert min(counts) <= s.low <= s.mean + 1e-12
        assert s.mean - 1e-12 <= s.high <= max(counts)


def test_the_bootstrap_of_many_counts_comes_near_the_normal_interval() -> None:
    counts = np.random.default_rng(6).poisson(3.0, 200)
    boot, student = summarise_bounded(counts), summarise(counts)
    assert (boot.low, boot.high) == (pytest.approx(student.low, abs=0.03), pytest.approx(student.high, abs=0.03))


def test_the_bootstrap_leaves_missing_values_out() -> None:
    s = summarise_bounded([1.0, np.nan, 3.0])
    assert (s.n, s.missing, s.low, s.high) == (2, 1, 1.0, 3.0)


def test_a_paired_ratio_is_over_the_pairs_that_count_alone() -> None:
    ratio, n = paired_ratio([10, 20, 30, np.nan], [5, 999, 15, 1], [True, False, True, True])
    assert (ratio, n) == (0.5, 2)
    assert np.isnan(paired_ratio([1, 2], [1, 2], [False, False])[0])
    assert np.isnan(paired_ratio([0, 0], [1, 2], [True, True])[0])
    with pytest.raises(ValueError, match="must be equal"):
        paired_ratio([1, 2], [1, 2], [True])


@pytest.mark.parametrize(("events", "n"), [(0, 10), (1, 10), (7, 3), (40, 20)])
def test_garwoods_interval_ends_where_the_count_would_be_a_tail_of_2_5_percent(events: int, n: int) -> None:
    rate, low, high = poisson_rate(events, n)
    assert rate == events / n
    assert stats.poisson.cdf(events, high * n) == pytest.approx(0.025)
    if events:
        assert stats.poisson.sf(events - 1, low * n) == pytest.approx(0.025)
    else:
        assert low == 0


def test_no_rate_is_made_of_no_run() -> None:
    for events, n in ((-1, 3), (0, 0)):
        with pytest.raises(ValueError, match=f"events is {events} in n {n} runs"):
            poisson_rate(events, n)
