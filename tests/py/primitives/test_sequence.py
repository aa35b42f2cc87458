"""The HMM over primitives (Sec. 6.2.2): the filter against all state sequences one by one, and what it recognises."""

import itertools
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.primitives import SequenceBelief, SequenceConfig, SequenceHmm, SequencePrimitive

Floats = NDArray[np.float64]


def transitions(hmm: SequenceHmm) -> Floats:
    """(P S + 1, P S + 1) of the states (p, s) row after row, then "none of them", from the config's words."""
    c, P, S = hmm.config, len(hmm), hmm.config.phase_steps
    T = np.zeros((P * S + 1, P * S + 1))
    first = [p * S for p in range(P)]
    for p, s in itertools.product(range(P), range(S - 1)):
        for k, log_p in enumerate(hmm.log_advances(p)):
            T[p * S + s, p * S + min(s + k, S - 1)] += (1 - c.abandon) * np.exp(log_p)
        T[p * S + s, -1] += c.abandon
    for p in range(P):
        last = p * S + S - 1
        T[last, last] += 1 - c.finish
        T[last, first] += c.finish * c.chain / P
        T[last, -1] += c.finish * (1 - c.chain)
    T[-1, first] += c.start / P
    T[-1, -1] += 1 - c.start
    return T


def densities(hmm: SequenceHmm, sample: Floats) -> Floats:
    seen = np.isfinite(sample)
    inside = [
        np.prod(np.exp(-((sample - m) ** 2) / v / 2)[seen] / np.sqrt(2 * np.pi * v[seen]))
        for primitive in hmm.primitives
        for m, v in zip(primitive.mean, primitive.variance, strict=True)
    ]
    return np.array([*inside, np.prod(hmm.background_density[seen])])


def tiny(seed: int) -> SequenceHmm:
    random = np.random.default_rng(seed)
    config = SequenceConfig(phase_steps=3, pause=0.2, abandon=0.05, start=0.3, finish=0.4, chain=0.3)
    primitives = [
        SequencePrimitive(random.normal(size=(3, 2)), random.uniform(0.2, 1, (3, 2)), samples) for samples in (4.0, 2.5)
    ]
    return SequenceHmm(primitives, [0.2, 0.3], config)


@pytest.mark.parametrize("seed", range(4))
def test_the_filter_is_the_sum_over_all_state_sequences(seed: int) -> None:
    hmm, random = tiny(seed), np.random.default_rng(seed + 50)
    samples = random.normal(size=(4, 2))
    samples[2, seed % 2] = np.nan
    T, B = transitions(hmm), np.array([densities(hmm, x) for x in samples])
    np.testing.assert_allclose(T.sum(1), 1, rtol=1e-12)
    prior = np.zeros(7)
    prior[[0, 3]], prior[-1] = 0.45, 0.1
    joint = np.zeros(7)
    for states in itertools.product(range(7), repeat=4):
        p = prior[states[0]] * np.prod([B[t, s] for t, s in enumerate(states)])
        joint[states[-1]] += p * np.prod([T[a, b] for a, b in itertools.pairwise(states)])
    for x in samples:
        belief = hmm.observe(x)
    posterior = joint / joint.sum()
    np.testing.assert_allclose(belief.steps.ravel(), posterior[:-1], rtol=1e-10)
    np.testing.assert_allclose(belief.probabilities, posterior[:-1].reshape(2, 3).sum(1), rtol=1e-10)
    assert np.isclose(belief.none, posterior[-1], rtol=1e-10)
    assert np.isclose(belief.log_likelihood, np.log(joint.sum()), rtol=1e-10)
    np.testing.assert_allclose(belief.progress, belief.steps @ [0, 0.5, 1] / belief.probabilities, rtol=1e-10)


def test_the_advance_has_the_stated_mean_and_pause() -> None:
    primitive = SequencePrimitive(np.arange(50.0)[:, None], np.ones((50, 1)), 99)
    for pause in (0.0, 0.1, 0.5):
        hmm = SequenceHmm([primitive], [0.01], SequenceConfig(pause=pause))
        p = np.exp(hmm.log_advances(0))
        assert np.isclose(p.sum(), 1)
        assert np.isclose(p @ np.arange(len(p)), 49 / 98, rtol=1e-3)
        assert np.isclose(p[0], pause + (1 - pause) * np.exp(-0.5 / (1 - pause)), rtol=1e-3)


def test_far_and_repeated_samples_do_not_break_the_log_space() -> None:
    hmm = tiny(0)
    for x in [1e99, 1e3, *np.zeros(500)]:
        belief = hmm.observe([x, -x])
    assert np.isclose(belief.probabilities.sum() + belief.none, 1)
    assert np.isfinite(belief.log_likelihood)


TASKS = 3
SAMPLES = 120


def movement(task: int, random: np.random.Generator, samples: int = SAMPLES) -> Floats:
    """A partner's hand [m], (T, 3), of about `samples` samples from about the same start: 0 lifts a lid to the front, 1
    sweeps to the left, 2 reaches down and to the right; 3 is none of them, to the back. End points vary by 3 cm, the
    tempo by 15 %, tracking by 3 mm."""
    goal = np.array([[0.5, 0.1, 0.4], [0.2, 0.6, 0.1], [0.3, -0.4, -0.3], [-0.5, 0.1, 0.1]])[task]
    bow = np.array([[0, 0.1, 0.2], [0.2, 0, 0.1], [0.2, 0.1, 0], [0, 0.2, 0.1]])[task]
    count = int(samples * random.uniform(0.85, 1.15))
    u = np.linspace(0, 1, count)[:, None]
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    start, end = random.normal(0, 0.02, 3), goal + random.normal(0, 0.03, 3)
    return start + s * (end - start) + np.sin(np.pi * s) * bow + random.normal(0, 0.003, (count, 3))


def learned(seed: int = 0) -> SequenceHmm:
    random = np.random.default_rng(seed)
    return SequenceHmm.fit([[movement(task, random) for _ in range(5)] for task in range(TASKS)])


def observed(hmm: SequenceHmm, samples: Floats) -> SequenceBelief:
    hmm.reset()
    for x in samples:
        hmm.observe(x)
    return hmm.belief


@pytest.mark.parametrize(("from_start", "least"), [(False, 0.9), (True, 0.98)])
def test_three_tasks_are_recognised_after_30_percent_at_any_tempo(from_start: bool, least: float) -> None:
    """As tracked, or relative to where the hand was first, which takes the spread of the starts away."""
    right = []
    for seed in range(8):
        random = np.random.default_rng(seed)

        def task_movement(task: int, tempo: float = 1.0, random: np.random.Generator = random) -> Floats:
            x = movement(task, random, int(SAMPLES / tempo))
            return x - x[0] if from_start else x

        hmm = SequenceHmm.fit([[task_movement(task) for _ in range(5)] for task in range(TASKS)])
        for task, tempo, _ in itertools.product(range(TASKS), (0.6, 1.0, 1.6), range(3)):
            samples = task_movement(task, tempo)
            right.append(observed(hmm, samples[: len(samples) * 3 // 10]).recognised == task)
    assert len(right) == 216
    assert np.mean(right) >= least


def test_another_movement_is_none_of_them() -> None:
    hmm, random = learned(), np.random.default_rng(2)
    refused = [observed(hmm, movement(3, random)).recognised == -1 for _ in range(20)]
    assert np.mean(refused) >= 0.9


def test_progress_follows_the_partner_also_through_a_pause_and_a_gap() -> None:
    hmm, random = learned(), np.random.default_rng(3)
    samples = movement(1, random)
    half = len(samples) // 2
    pausing = samples[half] + random.normal(0, 0.003, (60, 3))
    gap = np.full((8, 3), np.nan)
    assert abs(observed(hmm, samples[:half]).progress[1] - 0.5) < 0.08
    assert abs(observed(hmm, np.vstack([samples[:half], pausing])).progress[1] - 0.5) < 0.08
    after = observed(hmm, np.vstack([samples[:half], pausing, samples[half:-20], gap, samples[-12:]]))
    assert after.recognised == 1
    assert after.progress[1] > 0.93


def test_it_switches_when_one_task_ends_and_another_begins() -> None:
    first_right, second_right = [], []
    for seed in range(8):
        hmm, random = learned(seed), np.random.default_rng(seed + 100)
        for first, second in itertools.permutations(range(TASKS), 2):
            a, b = movement(first, random), movement(second, random)
            back = np.linspace(a[-1], b[0], 40)  # the hand goes back to the start, which is none of the tasks
            first_right.append(observed(hmm, a).recognised == first)
            second_right.append(observed(hmm, np.vstack([a, back, b[: len(b) // 2]])).recognised == second)
    assert len(second_right) == 48
    assert np.mean(first_right) >= 0.9
    assert np.mean(second_right) >= 0.9


@pytest.mark.realdata
def test_lasa_shapes_are_recognised_after_30_percent(data_folder: Path) -> None:
    """Three shapes a time as tasks, from a common start, learned from 5 demonstrations, tested on the other 2; samples
    are positions and their differences. 25 draws of 455 triples; shapes of a fourth kind, seen whole, are refused."""
    from scipy.io import loadmat

    random, shapes = np.random.default_rng(0), []
    for file in sorted((data_folder / "lasa").glob("*.mat")):
        paths = [one["pos"][0, 0].T[::10] for one in loadmat(file)["demos"][0]]
        shapes.append([np.hstack([p - p[0], np.diff(p, axis=0, prepend=p[:1])]) for p in paths])
    right, refused = [], []
    for _ in range(25):
        *triple, fourth = random.choice(len(shapes), TASKS + 1, replace=False)
        order = random.permutation(7)
        hmm = SequenceHmm.fit([[shapes[shape][i] for i in order[:5]] for shape in triple])
        for (task, shape), i in itertools.product(enumerate(triple), order[5:]):
            path = shapes[shape][i]
            right.append(observed(hmm, path[: len(path) * 3 // 10]).recognised == task)
        refused += [observed(hmm, shapes[fourth][i]).recognised == -1 for i in order[5:]]
    print(f"recognised {np.mean(right):.3f} of {len(right)}, refused {np.mean(refused):.3f} of {len(refused)}")
    assert len(right) == 150
    assert np.mean(right) >= 0.9
    assert np.mean(refused) >= 0.8


def test_bad_demonstrations_samples_and_configs_are_refused() -> None:
    good = np.random.default_rng(0).normal(size=(20, 2))
    gap = good.copy()
    gap[3, 1] = np.nan
    for bad, said in (
        ([], "no primitives"),
        ([[]], "primitive 0 has no demonstrations"),
        ([[good], []], "primitive 1 has no demonstrations"),
        ([[good], [good, good[:1]]], "demonstration 1 of primitive 1 has 1 sample"),
        ([[good], [good[:, :1]]], "demonstration 0 of primitive 1 has 1 dimensions, the first 2"),
        ([[good, gap]], "demonstration 1 of primitive 0 has nan in sample 3"),
        ([[good * [1, 0]]], "dimension 1 is the same in all samples"),
    ):
        with pytest.raises(ValueError, match=re.escape(said)):
            SequenceHmm.fit(bad)
    hmm = SequenceHmm.fit([[good]])
    before = hmm.observe([0.0, 0.0]).log_likelihood
    for sample in ([0.0], [np.inf, 0.0], [1e101, 0.0]):
        with pytest.raises(ValueError, match="sample"):
            hmm.observe(sample)
    assert hmm.belief.log_likelihood == before
    for name in ("phase_steps", "pause", "finish", "abandon", "none_prior", "background_width", "least_deviation"):
        with pytest.raises(ValueError, match=name):
            SequenceConfig(**{name: -1})
    config = SequenceConfig(pause=0.3, phase_steps=20)
    assert (pickle.loads(pickle.dumps(config)).pause, pickle.loads(pickle.dumps(config)).phase_steps) == (0.3, 20)


def test_primitives_that_do_not_fit_are_refused() -> None:
    mean, variance = np.zeros((50, 2)), np.ones((50, 2))
    for primitive, density, said in (
        (SequencePrimitive(mean[:40], variance[:40], 10), [1.0, 1.0], "must both be (50, 2)"),
        (SequencePrimitive(mean, 0 * variance, 10), [1.0, 1.0], "variance must be > 0"),
        (SequencePrimitive(mean, variance, 1), [1.0, 1.0], "samples"),
        (SequencePrimitive(mean, variance, 10), [1.0, 0.0], "background_density"),
    ):
        with pytest.raises(ValueError, match=re.escape(said)):
            SequenceHmm([primitive], density)
    with pytest.raises(ValueError, match="no primitives"):
        SequenceHmm([], [1.0])
