"""DTW against enumeration and a plain table (ERRATA 49); phase and tempo of partners who hurry, dawdle and pause."""

import itertools
import pickle
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.primitives import (
    OpenEndDtw,
    PartnerPhase,
    PhaseEstimator,
    PhaseEstimatorConfig,
    dtw,
    dtw_distance,
    open_end_dtw,
)

Floats = NDArray[np.float64]


def table(a: Floats, b: Floats, window: int | None = None) -> Floats:
    """D of Alg. 9 with the border of ERRATA 49, (m + 1, n + 1)."""
    D = np.full((len(a) + 1, len(b) + 1), np.inf)
    D[0, 0] = 0
    for i, j in itertools.product(range(1, len(a) + 1), range(1, len(b) + 1)):
        if window is None or abs(i - j) <= window:
            cost = np.sqrt(sum((a[i - 1] - b[j - 1]) ** 2))
            D[i, j] = cost + min(D[i - 1, j - 1], D[i - 1, j], D[i, j - 1])
    return D


def cheapest(a: Floats, b: Floats, i: int, j: int) -> float:
    """The least cost of all warping paths from (i, j) to the end, one by one."""
    cost = float(np.linalg.norm(a[i] - b[j]))
    following = [(i + 1, j + 1), (i + 1, j), (i, j + 1)]
    rest = [cheapest(a, b, k, l) for k, l in following if k < len(a) and l < len(b)]
    return cost + min(rest, default=0 if (i, j) == (len(a) - 1, len(b) - 1) else np.inf)


def walk(count: int, dimensions: int, seed: int) -> Floats:
    return np.cumsum(np.random.default_rng(seed).normal(size=(count, dimensions)), axis=0)


sizes = st.tuples(st.integers(1, 150), st.integers(1, 150), st.integers(1, 9), st.integers(0, 10**6))


@pytest.mark.parametrize("seed", range(5))
def test_the_distance_is_that_of_the_cheapest_of_all_paths(seed: int) -> None:
    a, b = walk(6, 2, seed), walk(5, 2, seed + 100)
    assert np.isclose(dtw_distance(a, b), cheapest(a, b, 0, 0), rtol=1e-14)


@settings(max_examples=40, deadline=None)
@given(sizes, st.one_of(st.none(), st.integers(0, 20)))
def test_costs_are_those_of_the_plain_table(size: tuple[int, int, int, int], beyond: int | None) -> None:
    m, n, dimensions, seed = size
    a, b = walk(m, dimensions, seed), walk(n, dimensions, seed + 1)
    window = None if beyond is None else abs(m - n) + beyond
    result, D = dtw(a, b, window), table(a, b, window)
    np.testing.assert_allclose(result.costs, D[1:, 1:], rtol=1e-12)
    assert result.distance == result.costs[-1, -1] == dtw_distance(a, b, window)


@settings(max_examples=40, deadline=None)
@given(sizes)
def test_the_path_is_one_and_costs_the_distance(size: tuple[int, int, int, int]) -> None:
    a, b = walk(size[0], size[2], size[3]), walk(size[1], size[2], size[3] + 1)
    result = dtw(a, b)
    assert tuple(result.path[0]) == (0, 0)
    assert tuple(result.path[-1]) == (len(a) - 1, len(b) - 1)
    steps = {tuple(step) for step in np.diff(result.path, axis=0).tolist()}
    assert steps <= {(1, 1), (1, 0), (0, 1)}
    along = np.linalg.norm(a[result.path[:, 0]] - b[result.path[:, 1]], axis=1).sum()
    assert np.isclose(along, result.distance, rtol=1e-12)


@settings(max_examples=20, deadline=None)
@given(sizes)
def test_the_distance_is_symmetric_and_0_to_itself_played_slower(size: tuple[int, int, int, int]) -> None:
    a, b = walk(size[0], size[2], size[3]), walk(size[1], size[2], size[3] + 1)
    assert np.isclose(dtw_distance(a, b), dtw_distance(b, a), rtol=1e-13)
    assert dtw_distance(a, np.repeat(a, 3, axis=0)) == 0


def test_among_equal_predecessors_the_path_goes_diagonally_then_along_a() -> None:
    assert dtw(np.zeros(3), np.zeros(3)).path.tolist() == [[0, 0], [1, 1], [2, 2]]
    assert dtw(np.zeros(2), np.zeros(4)).path.tolist() == [[0, 0], [0, 1], [0, 2], [1, 3]]


@settings(max_examples=30, deadline=None)
@given(sizes)
def test_the_open_end_is_the_smallest_argmin_of_each_row(size: tuple[int, int, int, int]) -> None:
    m, n, dimensions, seed = size
    query, reference = walk(m, dimensions, seed).round(0), walk(n, dimensions, seed + 1).round(0)
    costs, online = dtw(query, reference).costs, OpenEndDtw(reference)
    for sample, row in zip(query, costs, strict=True):
        phase = online.observe(sample)
        assert (phase.index, phase.distance) == (int(np.argmin(row)), row.min())
    assert open_end_dtw(query, reference).index == phase.index


def test_a_dimension_that_was_not_seen_is_left_out_and_the_others_weigh_for_it() -> None:
    query, reference, online = walk(15, 3, 0), walk(20, 3, 1), OpenEndDtw(walk(20, 3, 1))
    query[np.random.default_rng(0).random(query.shape) < 0.3] = np.nan
    query[4] = np.nan
    D = np.full(len(reference) + 1, np.inf)
    D[0] = 0
    for sample in query:
        seen = np.isfinite(sample)
        if seen.any():
            costs = np.sqrt(3 / seen.sum()) * np.linalg.norm(reference[:, seen] - sample[seen], axis=1)
            before, D = D, np.full_like(D, np.inf)
            for j in range(1, len(D)):
                D[j] = costs[j - 1] + min(before[j - 1], before[j], D[j - 1])
        phase = online.observe(sample)
        assert phase.index == int(np.argmin(D)) - 1
        assert np.isclose(phase.distance, D.min(), rtol=1e-12)


def test_before_any_sample_and_after_a_reset_there_is_no_index() -> None:
    online = OpenEndDtw(walk(5, 2, 0))
    assert online.observe([np.nan, np.nan]).index == -1
    first = online.observe([1.0, 1.0]).distance
    online.reset()
    assert online.observe([1.0, 1.0]).distance == first


@pytest.mark.parametrize(
    ("a", "b", "window", "said"),
    [
        (np.zeros((0, 2)), np.zeros((3, 2)), None, "a has shape (0, 2)"),
        (np.zeros((3, 2)), np.zeros((3, 3)), None, "a has 2 dimensions and b has 3"),
        (np.zeros(3), np.array([0, np.nan, 0]), None, "b has nan in sample 1"),
        (np.zeros(3), np.array([0, 0, 1e200]), None, "in sample 2, must be finite and within 1e100"),
        (np.zeros(3), np.zeros(8), 4, "window is 4 samples, must be at least 5"),
        (np.zeros(3), np.zeros(3), -1, "window is -1 samples"),
        (np.zeros((2, 2, 2)), np.zeros(3), None, "has 3 axes"),
    ],
)
def test_bad_series_are_refused_by_name(a: Floats, b: Floats, window: int | None, said: str) -> None:
    for call in (dtw, dtw_distance):
        with pytest.raises(ValueError, match=re.escape(said)):
            call(a, b, window)


def test_bad_samples_are_refused_and_leave_the_state() -> None:
    online = OpenEndDtw(walk(5, 2, 0))
    online.observe([0.0, 0.0])
    for bad in ([0.0], [np.inf, 0.0], [1e101, 0.0]):
        with pytest.raises(ValueError, match="sample"):
            online.observe(bad)
    assert online.observe([0.0, 0.0]).distance == open_end_dtw(np.zeros((2, 2)), walk(5, 2, 0)).distance


DURATION = 2.0
HZ = 100


def reach(u: Floats) -> Floats:
    """A bowed reach of .6 m whose speed follows a minimum-jerk profile, u in [0, 1]."""
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    return np.column_stack([0.6 * s, 0.3 * np.sin(np.pi * s), 0.2 * s**2])


REFERENCE = reach(np.linspace(0, 1, 200))


def watch(
    rates: Floats, seed: int = 1, noise: float = 0.003, config: PhaseEstimatorConfig | None = None
) -> tuple[Floats, list[PartnerPhase]]:
    """True reference times [s] of a partner whose tempo at each sample is rates[t], and what is estimated of them."""
    random = np.random.default_rng(seed)
    times = np.r_[0, np.cumsum(rates)[:-1] / HZ].clip(max=DURATION)
    partner = reach(times / DURATION) + random.normal(0, noise, (len(times), 3))
    estimator = PhaseEstimator(REFERENCE, DURATION, config or PhaseEstimatorConfig())
    return times, [estimator.observe(t / HZ, sample) for t, sample in enumerate(partner)]


@pytest.mark.parametrize("rate", [0.5, 0.8, 1.0, 1.5, 2.0])
def test_a_slower_or_faster_partner_is_followed(rate: float) -> None:
    times, phases = watch(np.full(int(1.7 / rate * HZ), rate))
    late = [(t, p) for t, p in zip(times, phases, strict=True) if t > 0.3 * rate + 0.35]
    assert len(late) > 10
    assert all(p.determined and not p.paused for _, p in late)
    assert all(abs(p.reference_time - t) < 0.05 for t, p in late)
    assert np.isclose(np.mean([p.rate for _, p in late]), rate, rtol=0.05)
    assert all(abs(p.mean_rate - rate) < 0.05 * rate for _, p in late)


@pytest.mark.parametrize("seed", range(3))
def test_a_pausing_partner_stands_still_and_goes_on(seed: int) -> None:
    rates = np.r_[np.ones(90), np.zeros(100), np.full(100, 0.8)]
    times, phases = watch(rates, seed)
    still = phases[150:190]
    assert all(p.paused and p.rate < 0.15 for p in still)
    assert all(abs(p.reference_time - 0.9) < 0.05 for p in still)
    assert not any(p.paused for p in phases[75:100] + phases[230:])
    assert np.isclose(phases[-1].rate, 0.8, atol=0.1)
    assert abs(phases[-1].reference_time - times[-1]) < 0.05


@pytest.mark.parametrize("seed", range(3))
def test_both_resting_at_the_start_is_undetermined(seed: int) -> None:
    rates = np.r_[np.zeros(100), np.ones(150)]
    times, phases = watch(rates, seed)
    moving = int(np.argmax([np.linalg.norm(x) > 0.1 for x in reach(times / DURATION)]))
    assert not any(p.determined for p in phases[:110])
    assert all(p.rate == p.mean_rate == 1 and not p.paused for p in phases[:110])
    assert all(p.determined for p in phases[moving:])
    assert np.isclose(phases[200].rate, 1, atol=0.1)


def test_the_phase_is_5_5_on_the_grid_of_the_fit() -> None:
    for p in watch(np.ones(150))[1]:
        assert np.isclose(p.phase, np.exp(-np.log(100) * p.index / 199), rtol=1e-14)
    assert np.isclose(watch(np.ones(400), noise=0)[1][-1].phase, 0.01, rtol=1e-12)


def test_gaps_in_tracking_do_not_stop_the_estimate() -> None:
    estimator, random = PhaseEstimator(REFERENCE, DURATION), np.random.default_rng(3)
    for t in range(150):
        sample = reach(np.array([t / HZ / DURATION]))[0] + random.normal(0, 0.003, 3)
        if 60 <= t < 75:
            sample[:] = np.nan
        sample[random.random(3) < 0.2] = np.nan
        phase = estimator.observe(t / HZ, sample)
    assert abs(phase.reference_time - 1.49) < 0.05
    assert np.isclose(phase.rate, 1, atol=0.1)


def test_bad_references_stamps_and_configs_are_refused() -> None:
    estimator = PhaseEstimator(REFERENCE, DURATION)
    estimator.observe(1.0, REFERENCE[0])
    for stamp in (1.0, 0.5, np.nan, np.inf):
        with pytest.raises(ValueError, match="must be later than 1"):
            estimator.observe(stamp, REFERENCE[0])
    with pytest.raises(ValueError, match="never leaves its start"):
        PhaseEstimator(np.ones((10, 3)), 1.0)
    with pytest.raises(ValueError, match="has 1 sample"):
        PhaseEstimator(np.ones((1, 3)), 1.0)
    with pytest.raises(ValueError, match="duration"):
        PhaseEstimator(REFERENCE, 0.0)
    for name, value in {"phase_decay": 0.0, "tempo_window": -1.0, "rest_share": 1.0, "pause_rate": 1.5}.items():
        with pytest.raises(ValueError, match=name):
            PhaseEstimatorConfig(**{name: value})
    assert pickle.loads(pickle.dumps(PhaseEstimatorConfig(rest_share=0.1))).rest_share == 0.1
