"""The passing task: demonstrations pass, begin alike, differ by their rectangle; the measure is DTW as it should be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lfdcore.simulated.passing import (
    DEMONSTRATIONS,
    GROUND,
    MIDDLE,
    NOVEL,
    STEPS,
    TRAINING,
    Rectangle,
    demonstrate_passing,
    distance_to_samples,
    dtw_per_sample,
    passing_data,
    passing_verdict,
)

Array = np.ndarray
paths = st.integers(2, 9).flatmap(lambda n: arrays(np.float64, (n, 2), elements=st.floats(0, 600)))


def slow_dtw(a: Array, b: Array) -> float:
    """Alg. 9 with ERRATA 49, cell by cell."""
    table = np.full((len(a) + 1, len(b) + 1), np.inf)
    table[0, 0] = 0
    for i in range(len(a)):
        for j in range(len(b)):
            table[i + 1, j + 1] = np.hypot(*(a[i] - b[j])) + min(table[i, j], table[i, j + 1], table[i + 1, j])
    return float(table[-1, -1]) / max(len(a), len(b))


@given(paths, paths)
def test_dtw_is_that_of_the_table_filled_cell_by_cell(a: Array, b: Array) -> None:
    assert dtw_per_sample(a, b) == pytest.approx(slow_dtw(a, b))
    assert dtw_per_sample(a, b) == pytest.approx(dtw_per_sample(b, a))
    assert dtw_per_sample(a, a) == 0


@pytest.mark.parametrize("seed", range(3))
def test_every_demonstration_passes_its_rectangle(seed: int) -> None:
    data = passing_data(seed)
    training = zip(np.repeat(np.array(TRAINING, object), DEMONSTRATIONS), data.training, strict=True)
    held_out = [(r, one) for r, several in {**data.known, **data.novel}.items() for one in several]
    for rectangle, one in [*training, *held_out]:
        verdict = passing_verdict(one.partner, rectangle)
        assert verdict.passed, one.name
        assert verdict.clearance > 8
        assert one.environment == {"rectangle.width": rectangle.width, "rectangle.height": rectangle.height}
        assert len(one) == STEPS


def test_the_same_seed_gives_the_same_and_no_demonstration_comes_twice() -> None:
    first, again, other = passing_data(1), passing_data(1), passing_data(2)
    every = lambda data: [*data.training, *sum([*data.known.values(), *data.novel.values()], ())]  # noqa: E731
    for a, b in zip(every(first), every(again), strict=True):
        np.testing.assert_array_equal(a.partner, b.partner)
    seen = {one.partner.tobytes() for one in every(first) + every(other)}
    assert len(seen) == 2 * 9 * DEMONSTRATIONS


def test_it_begins_still_and_the_motion_along_x_knows_nothing_of_the_rectangle() -> None:
    small, large = Rectangle(100, 60), Rectangle(160, 160)
    for seed in range(20):
        a, b = demonstrate_passing(small, seed).partner, demonstrate_passing(large, seed).partner
        np.testing.assert_array_equal(a[:, 0], b[:, 0])
        np.testing.assert_allclose(a[:4], np.broadcast_to(a[0], (4, 2)), atol=0.02)
        np.testing.assert_allclose(a[:25, 1], b[:25, 1], atol=1e-9)  # nor does the beginning along y
        assert np.abs(a[:, 1] - b[:, 1]).max() > 90


def test_demonstrations_of_one_rectangle_are_alike_and_of_others_are_not() -> None:
    data = passing_data()
    for rectangle, several in {**data.known, **data.novel}.items():
        alike = distance_to_samples(several[0].partner, several[1:])
        strangers = [one for r, s in data.novel.items() if r != rectangle for one in s]
        assert alike < 5
        assert distance_to_samples(several[0].partner, strangers) > 10


def test_novel_rectangles_are_new_and_reach_beyond_the_known_heights() -> None:
    assert not set(TRAINING) & set(NOVEL)
    heights = [r.height for r in TRAINING]
    assert min(r.height for r in NOVEL) < min(heights)
    assert max(r.height for r in NOVEL) > max(heights)


def arch(height: float, begin: float = 50.0, end: float = 590.0) -> Array:
    """Straight up at the beginning, across at `height` above the ground, straight down at the end."""
    ys = GROUND - np.array([0, height, height, 0])
    return np.stack([[begin, begin, end, end], ys], axis=1)


@pytest.mark.parametrize(
    ("path", "passed", "touched", "clearance"),
    [
        (arch(110), True, False, 10.0),
        (arch(100), False, True, 0.0),
        (arch(60), False, True, 0.0),  # through, though no sample lies inside
        (arch(110, end=MIDDLE), False, True, 0.0),  # down on it
        (arch(110, begin=400.0), False, False, 30.0),  # never left of it
        (arch(110)[::-1], False, False, 10.0),  # from right to left
        (arch(-20), False, False, 20.0),  # underneath
    ],
)
def test_the_verdict_on_known_paths(path: Array, passed: bool, touched: bool, clearance: float) -> None:
    verdict = passing_verdict(path, Rectangle(100, 100))
    assert (verdict.passed, verdict.touched) == (passed, touched)
    assert verdict.clearance == pytest.approx(clearance)


def test_a_path_underneath_with_samples_below_the_rectangle_does_not_pass() -> None:
    dense = np.stack([np.linspace(50, 590, 100), np.full(100, GROUND + 20)], axis=1)
    assert not passing_verdict(dense, Rectangle(100, 100)).passed


@given(arrays(np.float64, (6, 2), elements=st.integers(200, 450).map(float)))
def test_a_path_passes_if_a_fine_one_along_it_stays_above(path: Array) -> None:
    rectangle, at = Rectangle(100, 100), np.linspace(0, 7, 1401)
    path = np.vstack([[100, 250], path, [500, 250]])
    fine = np.stack([np.interp(at, np.arange(8), column) for column in path.T], axis=1)
    near = np.abs(fine[:, 0] - MIDDLE) <= 50
    above = bool((fine[near, 1] < GROUND - 100).all())
    verdict = passing_verdict(path, rectangle)
    if verdict.clearance > 2 or verdict.clearance == 0:  # the fine path may step across a corner
        assert above >= verdict.passed
    if verdict.clearance > 2:
        assert above == verdict.passed


@pytest.mark.parametrize("path", [np.zeros((1, 2)), np.zeros((5, 3)), np.full((5, 2), np.nan), np.zeros(5)])
def test_what_is_no_path_is_refused(path: Array) -> None:
    for judge in (lambda: passing_verdict(path, TRAINING[0]), lambda: dtw_per_sample(path, np.zeros((5, 2)))):
        with pytest.raises(ValueError, match=r"must be \(T, 2\), T >= 2, and finite"):
            judge()


def test_settings_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match=r"width of the rectangle must be in \(0, 220\] px, got 0"):
        Rectangle(0, 10)
    with pytest.raises(ValueError, match=r"height of the rectangle .* got nan"):
        Rectangle(10, float("nan"))
    with pytest.raises(ValueError, match="seed must be >= 0 and demonstrations >= 1, got -1 and 10"):
        passing_data(-1)
    with pytest.raises(ValueError, match="there are no samples"):
        distance_to_samples(np.zeros((5, 2)), [])
