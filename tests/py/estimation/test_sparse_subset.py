"""Algorithm 1: the incremental selection against Q_a and chi_a taken literally."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.estimation import ActionKernel, ActionModel, select_subset

Floats = NDArray[np.float64]
KERNELS = [ActionKernel(1.2, [0.7, 0.8, 0.9], [1.5, 2.0], 0.2), ActionKernel(0.8, [0.5, 1.0, 0.9], [2.0, 1.1], 0.3)]


def data(count: int, seed: int = 0) -> tuple[Floats, Floats, Floats]:
    random = np.random.default_rng(seed)
    states, goals = random.uniform(-1, 1, (count, 3)), random.uniform(-3, 3, (4, 2))[random.integers(0, 4, count)]
    actions = np.column_stack([np.sin(states[:, 0] + goals[:, 0]), 3 * np.cos(states[:, 1] * goals[:, 1])])
    return states, goals, actions + random.normal(0, 0.1, (count, 2))


class Draws:
    """The candidates of each round: starts of Fisher-Yates shuffles of those left, with MMIX's generator."""

    def __init__(self, count: int, candidates: int, seed: int) -> None:
        self.left, self.candidates, self.state = list(range(count)), candidates, seed

    def next(self) -> list[int]:
        count = min(self.candidates, len(self.left))
        for i in range(count):
            self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
            other = i + (self.state >> 33) % (len(self.left) - i)
            self.left[i], self.left[other] = self.left[other], self.left[i]
        return self.left[:count]

    def remove(self, sample: int) -> None:
        position = self.left.index(sample)
        self.left[position] = self.left[-1]
        self.left.pop()


def naive(samples: tuple[Floats, Floats, Floats], size: int, candidates: int, seed: int) -> list[int]:
    """ERRATA 11: sum_a Q_a([P e_i] chi_a([P e_i])) of every candidate from nothing, outputs standardised (F2)."""
    inputs, problems = np.hstack(samples[:2]), []
    for kernel, y in zip(KERNELS, samples[2].T, strict=True):
        Z, sd = inputs / np.r_[kernel.state_lengthscales, kernel.goal_lengthscales], y.std()
        K = (kernel.amplitude / sd) ** 2 * np.exp(-0.5 * ((Z[:, None] - Z[None]) ** 2).sum(2))
        problems.append((K, (kernel.noise / sd) ** 2, y / sd))

    def Q(S: list[int]) -> float:
        total = 0.0
        for K, s2, y in problems:
            A = s2 * K + K.T @ K
            P = np.eye(len(K))[:, S]
            alpha = P @ np.linalg.lstsq(P.T @ A @ P, P.T @ K.T @ y, rcond=1e-13)[0]
            total += float(-y @ K @ alpha + 0.5 * alpha @ A @ alpha)
        return total

    urn, selected = Draws(len(inputs), candidates, seed), list[int]()
    for _ in range(size):
        best = min(urn.next(), key=lambda i: (Q([*selected, i]), i))
        selected.append(best)
        urn.remove(best)
    return selected


@pytest.mark.parametrize(
    ("count", "size", "candidates", "seed"), [(40, 15, 40, 1), (60, 12, 7, 2), (50, 10, 59, 3), (35, 35, 1, 4)]
)
def test_selection_is_the_naive_one(count: int, size: int, candidates: int, seed: int) -> None:
    samples = data(count, seed)
    ours = select_subset(*samples, KERNELS, size, candidates, seed)
    assert ours.tolist() == naive(samples, size, candidates, seed)


def test_selection_is_the_naive_one_where_samples_are_too_far_apart_to_matter() -> None:
    states, goals, actions = data(150, 11)
    states[:, 0] = np.linspace(0, 60, 150)  # blocks of 32 samples leave most others unread
    samples = states, goals, actions
    assert select_subset(*samples, KERNELS, 12, 20).tolist() == naive(samples, 12, 20, 1)


def test_duplicates_are_taken_last() -> None:
    """ERRATA 13: one that the selected span gains nothing."""
    samples = tuple(np.vstack([part, part]) for part in data(12, 5))
    selected = select_subset(*samples, KERNELS, 24, 24)
    assert sorted(selected.tolist()) == list(range(24))
    assert sorted(selected[:12] % 12) == list(range(12))
    assert selected[:12].max() < 12  # of two equal ones the smaller index
    assert selected[12:].tolist() == list(range(12, 24))  # all gain nothing


def test_a_greedy_subset_predicts_better_than_a_random_one() -> None:
    samples = data(400, 6)
    full = ActionModel(*samples, KERNELS)
    random = np.random.default_rng(0)
    places = random.uniform(-1, 1, (40, 3))

    def error(subset: NDArray[np.int64]) -> float:
        sparse = ActionModel(*samples, KERNELS, subset=subset)
        ask = [(m.moments(x, [0.5, 0.5], np.eye(2)).mean) for x in places for m in (full, sparse)]
        return float(np.abs(np.subtract(ask[::2], ask[1::2])).mean())

    chosen = error(select_subset(*samples, KERNELS, 60))
    assert chosen < 0.8 * np.mean([error(random.permutation(400)[:60]) for _ in range(5)])


def test_the_seed_decides_and_more_rounds_go_on_where_fewer_ended() -> None:
    samples = data(300, 7)
    first = select_subset(*samples, KERNELS, 130)
    assert np.array_equal(first, select_subset(*samples, KERNELS, 130))
    assert np.array_equal(first[:40], select_subset(*samples, KERNELS, 40))
    assert not np.array_equal(first, select_subset(*samples, KERNELS, 130, seed=2))
    assert first.dtype == np.int64
    assert len(set(first.tolist())) == 130


def test_outputs_count_by_their_own_variance() -> None:
    states, goals, actions = data(80, 8)
    scaled = [KERNELS[0], ActionKernel(80.0, KERNELS[1].state_lengthscales, KERNELS[1].goal_lengthscales, 30.0)]
    ours = select_subset(states, goals, actions, KERNELS, 20)
    assert np.array_equal(ours, select_subset(states, goals, actions * [1, 100], scaled, 20))


def test_a_driver_that_stands_still_is_no_error() -> None:
    states, goals, actions = data(30, 9)
    selected = select_subset(states, goals, np.zeros_like(actions), KERNELS, 5, 30)
    assert selected.tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize(
    ("size", "candidates", "message"),
    [
        (31, 59, r"size is 31, must be in \[1, 30\], the number of samples"),
        (0, 59, "size is 0"),
        (5, 0, "candidates is 0, must be at least 1"),
    ],
)
def test_what_cannot_be_selected_is_refused(size: int, candidates: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        select_subset(*data(30), KERNELS, size, candidates)


def test_samples_with_nan_are_refused() -> None:
    states, goals, actions = data(30)
    goals[4, 1] = np.nan
    with pytest.raises(ValueError, match="drop samples with NaN"):
        select_subset(states, goals, actions, KERNELS, 5)
