"""Moments of the action model against Monte Carlo, quadrature and PILCO's form; laws of the filter; the border."""

import pickle
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.estimation import (
    ActionKernel,
    ActionModel,
    ActionMoments,
    Belief,
    IntentionFilter,
    goal_likelihoods,
)

Floats = NDArray[np.float64]
KERNELS = [ActionKernel(1.2, [0.7, 0.8, 0.9], [1.5, 2.0], 0.2), ActionKernel(0.8, [0.5, 1.0, 0.9], [2.0, 1.1], 0.3)]
STATE, MEAN = np.array([0.1, 0.2, -0.3]), np.array([0.3, -0.4])
COVARIANCE = np.array([[1.0, 0.3], [0.3, 0.5]])


def data(count: int, places: int = 4, seed: int = 0) -> tuple[Floats, Floats, Floats]:
    random = np.random.default_rng(seed)
    states = random.uniform(-1, 1, (count, 3))
    goals = random.uniform(-3, 3, (places, 2))[random.integers(0, places, count)]
    actions = np.column_stack([np.sin(states[:, 0] + goals[:, 0]), np.cos(states[:, 1] * goals[:, 1])])
    return states, goals, actions + random.normal(0, 0.1, (count, 2))


def model(count: int = 60, **options: object) -> ActionModel:
    return ActionModel(*data(count), KERNELS, **options)


def conditional(samples: tuple[Floats, Floats, Floats], goals: Floats) -> tuple[Floats, Floats]:
    """Mean and variance (L, 2) of y given each goal: App. C.3 with noise (ERRATA 1, 2, 7)."""
    inputs, at = np.hstack(samples[:2]), np.hstack([np.tile(STATE, (len(goals), 1)), goals])
    mean, variance = [], []
    for kernel, y in zip(KERNELS, samples[2].T, strict=True):
        scale = np.r_[kernel.state_lengthscales, kernel.goal_lengthscales]

        def k(a: Floats, b: Floats, kernel: ActionKernel = kernel, scale: Floats = scale) -> Floats:
            return kernel.amplitude**2 * np.exp(-0.5 * (((a[:, None] - b[None]) / scale) ** 2).sum(2))

        K, across = k(inputs, inputs) + kernel.noise**2 * np.eye(len(inputs)), k(at, inputs)
        mean.append(across @ np.linalg.solve(K, y))
        explained = (across * np.linalg.solve(K, across.T).T).sum(1)
        variance.append(kernel.amplitude**2 - explained + kernel.noise**2)
    return np.array(mean).T, np.array(variance).T


def joint(mean: Floats, variance: Floats, goals: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """m, G, C of a weighted sample of goals: total expectation and covariance."""
    m, centre = weights @ mean, weights @ goals
    G = (mean - m).T * weights @ (mean - m) + np.diag(weights @ variance)
    return m, G, (goals - centre).T * weights @ (mean - m)


def apart(moments: ActionMoments, m: Floats, G: Floats, C: Floats) -> float:
    pairs = ((moments.mean, m), (moments.covariance, G), (moments.cross_covariance, C))
    return max(float(np.abs(a - b).max()) for a, b in pairs)


def quadrature(covariance: Floats, points: int = 40) -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.hermite_e.hermegauss(points)
    grid = np.stack(np.meshgrid(nodes, nodes), -1).reshape(-1, 2)
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0))
    return MEAN + grid @ root.T, np.outer(weights, weights).ravel() / (2 * np.pi)


@pytest.mark.parametrize(
    "covariance", [COVARIANCE, np.diag([0.5, 0.0]), np.zeros((2, 2))], ids=["full", "flat", "none"]
)
def test_moments_are_those_of_gauss_hermite_quadrature_even_where_the_belief_is_singular(covariance: Floats) -> None:
    goals, weights = quadrature(covariance)
    expected = joint(*conditional(data(60), goals), goals, weights)
    assert apart(model().moments(STATE, MEAN, covariance), *expected) < 1e-9


def test_moments_are_those_of_monte_carlo() -> None:
    goals = np.random.default_rng(1).multivariate_normal(MEAN, COVARIANCE, 100_000)
    expected = joint(*conditional(data(30), goals), goals, np.full(len(goals), 1e-5))
    assert apart(model(30).moments(STATE, MEAN, COVARIANCE), *expected) < 0.01


def test_moments_are_pilcos_for_the_joint_input_with_a_certain_state() -> None:
    """Deisenroth's form: H over all inputs, input covariance diag(0, Sigma)."""
    states, goals, actions = data(40)
    inputs, at = np.hstack([states, goals]), np.r_[STATE, MEAN]
    S = np.zeros((5, 5))
    S[3:, 3:] = COVARIANCE
    H = [np.diag(np.r_[k.state_lengthscales, k.goal_lengthscales] ** 2) for k in KERNELS]
    nu = inputs - at
    beta, inverse, m, C, ks = [], [], [], [], []
    for k, h, y in zip(KERNELS, H, actions.T, strict=True):
        gaps = (inputs[:, None] - inputs[None]) / np.sqrt(np.diag(h))
        K = k.amplitude**2 * np.exp(-0.5 * (gaps**2).sum(2))
        inverse.append(np.linalg.inv(K + k.noise**2 * np.eye(len(K))))
        beta.append(inverse[-1] @ y)
        solved = np.linalg.solve(S + h, nu.T).T
        q = k.amplitude**2 / np.sqrt(np.linalg.det(S @ np.linalg.inv(h) + np.eye(5)))
        q = q * np.exp(-0.5 * (nu * solved).sum(1))
        m.append(beta[-1] @ q)
        C.append(S @ solved.T @ (beta[-1] * q))
        ks.append(2 * np.log(k.amplitude) - 0.5 * (nu @ np.linalg.inv(h) * nu).sum(1))
    G = np.zeros((2, 2))
    for a in range(2):
        for b in range(2):
            za, zb = nu @ np.linalg.inv(H[a]), nu @ np.linalg.inv(H[b])
            R = S @ (np.linalg.inv(H[a]) + np.linalg.inv(H[b])) + np.eye(5)
            z = za[:, None] + zb[None]
            exponent = ks[a][:, None] + ks[b][None] + 0.5 * np.einsum("ijk,kl,ijl->ij", z, np.linalg.solve(R, S), z)
            Q = np.exp(exponent) / np.sqrt(np.linalg.det(R))
            G[a, b] = beta[a] @ Q @ beta[b] - m[a] * m[b]
            if a == b:
                G[a, a] += KERNELS[a].amplitude ** 2 - (inverse[a] * Q).sum() + KERNELS[a].noise ** 2
    assert apart(model(40).moments(STATE, MEAN, COVARIANCE), np.array(m), G, np.array(C)[:, 3:].T) < 1e-11


@pytest.mark.parametrize("projected", [False, True])
def test_samples_ever_farther_from_the_state_are_left_out_only_where_they_do_not_matter(projected: bool) -> None:
    """Where goals are shared, blocks of 32 samples are left unread; where each sample has its own, none is."""
    states, goals, actions = data(320)
    states[:, 0] = np.linspace(0, 16, 320)[np.argsort(np.argsort(goals[:, 0], kind="stable"))]
    own = goals + np.random.default_rng(2).uniform(0, 1e-12, goals.shape)
    noisy = [ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 0.5) for k in KERNELS]
    subset = range(0, 320, 2) if projected else None
    shared, general = (ActionModel(states, g, actions, noisy, subset=subset) for g in (goals, own))
    assert (shared.shared_goals, general.shared_goals) == (4, 0)
    for x in np.linspace(0, 16, 9):
        at = [x, 0.2, -0.3]
        found, expected = (m.moments(at, MEAN, COVARIANCE) for m in (shared, general))
        assert apart(found, expected.mean, expected.covariance, expected.cross_covariance) < 1e-11


def test_G_is_the_covariance_of_the_noisy_action() -> None:
    """ERRATA 2: at a sample, f is known better than one sample's noise tells, and the noise comes on top."""
    states, goals, _ = data(200)
    G = model(200).moments(states[3], goals[3], np.zeros((2, 2))).covariance
    for variance, kernel in zip(np.diag(G), KERNELS, strict=True):
        assert kernel.noise**2 < variance < 2 * kernel.noise**2


def test_a_projected_subset_is_the_dtc_predictor() -> None:
    """ERRATA 14 literally: chi_a on S in place of beta, K_SS^-1 - s2 (s2 K_SS + K_SN K_NS)^-1 under the trace."""
    samples = data(120)
    inputs, subset = np.hstack(samples[:2]), np.random.default_rng(3).permutation(120)[:25]
    goals, weights = quadrature(COVARIANCE)
    at = np.hstack([np.tile(STATE, (len(goals), 1)), goals])
    mean, variance = [], []
    for kernel, y in zip(KERNELS, samples[2].T, strict=True):
        scale = np.r_[kernel.state_lengthscales, kernel.goal_lengthscales]

        def k(a: Floats, b: Floats, kernel: ActionKernel = kernel, scale: Floats = scale) -> Floats:
            return kernel.amplitude**2 * np.exp(-0.5 * (((a[:, None] - b[None]) / scale) ** 2).sum(2))

        S, across, s2 = inputs[subset], k(at, inputs[subset]), kernel.noise**2
        A = s2 * k(S, S) + k(S, inputs) @ k(inputs, S)
        D = np.linalg.inv(k(S, S)) - s2 * np.linalg.inv(A)
        mean.append(across @ np.linalg.solve(A, k(S, inputs) @ y))
        variance.append(kernel.amplitude**2 - ((across @ D) * across).sum(1) + s2)
    expected = joint(np.array(mean).T, np.array(variance).T, goals, weights)
    moments = ActionModel(*samples, KERNELS, subset=subset).moments(STATE, MEAN, COVARIANCE)
    assert apart(moments, *expected) < 1e-8


def test_a_subset_of_data_is_the_model_of_these_samples_alone() -> None:
    samples, subset = data(90), [3, 80, 7, 41, 12, 66]
    ours = ActionModel(*samples, KERNELS, subset=subset, projected=False).moments(STATE, MEAN, COVARIANCE)
    alone = ActionModel(*(part[subset] for part in samples), KERNELS).moments(STATE, MEAN, COVARIANCE)
    assert apart(ours, alone.mean, alone.covariance, alone.cross_covariance) < 1e-12


def test_projecting_a_subset_is_closer_to_the_full_model_than_using_it_as_training_set() -> None:
    """ERRATA 14, over means at 50 states."""
    models = [model(300), *(model(300, subset=range(0, 300, 2), projected=yes) for yes in (True, False))]
    states = np.random.default_rng(6).uniform(-1, 1, (50, 3))
    full, projected, smaller = ([m.moments(x, MEAN, COVARIANCE).mean for x in states] for m in models)
    assert np.abs(np.subtract(projected, full)).mean() < np.abs(np.subtract(smaller, full)).mean() / 3


@given(
    st.lists(st.floats(-3, 3), min_size=5, max_size=5),
    st.floats(0, 2),
    st.floats(0, 2),
    st.floats(-1, 1),
)
@settings(max_examples=100, deadline=None)
def test_moments_are_a_covariance_and_updates_never_widen_the_belief(
    place: list[float], sd_x: float, sd_y: float, correlation: float
) -> None:
    off = correlation * sd_x * sd_y
    covariance, mean = np.array([[sd_x**2, off], [off, sd_y**2]]), np.array(place[3:])
    moments = MODEL.moments(place[:3], mean, covariance)
    G, C = moments.covariance, moments.cross_covariance
    assert np.array_equal(G, G.T)
    assert np.linalg.eigvalsh(G).min() > 0
    whole = np.block([[covariance, C], [C.T, G]])
    assert np.linalg.eigvalsh(whole).min() > -1e-9
    after = IntentionFilter(MODEL, mean, covariance).update(place[:3], [0.3, -0.2]).covariance
    assert np.array_equal(after, after.T)
    assert np.linalg.eigvalsh(after).min() > -1e-9
    assert np.linalg.eigvalsh(covariance - after).min() > -1e-9


MODEL = model(80)


def test_moments_do_not_depend_on_the_order_of_samples_nor_on_where_the_map_begins() -> None:
    samples, order = data(70), np.random.default_rng(4).permutation(70)
    first = ActionModel(*samples, KERNELS).moments(STATE, MEAN, COVARIANCE)
    mixed = ActionModel(*(part[order] for part in samples), KERNELS).moments(STATE, MEAN, COVARIANCE)
    shift = np.array([40.0, -25.0])
    moved = ActionModel(samples[0], samples[1] + shift, samples[2], KERNELS).moments(STATE, MEAN + shift, COVARIANCE)
    for other in (mixed, moved):
        assert apart(other, first.mean, first.covariance, first.cross_covariance) < 1e-11


def updated(mean: np.ndarray, covariance: np.ndarray, action: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """2.2 and 2.3, written down."""
    moments = MODEL.moments(STATE, mean, covariance)
    gain = moments.cross_covariance @ np.linalg.inv(moments.covariance)
    return mean + gain @ (action - moments.mean), covariance - gain @ moments.cross_covariance.T


def test_an_update_is_2_2_and_2_3_and_process_noise_comes_first() -> None:
    noise = 1e-4  # so little that the belief stays narrower than the prior
    steered = IntentionFilter(MODEL, MEAN, COVARIANCE, process_noise=noise)
    first = steered.update(STATE, [0.4, -0.1])
    mean, covariance = first.mean, first.covariance
    wider = covariance + noise * np.eye(2)
    assert np.linalg.eigvalsh(COVARIANCE - wider).min() >= 0
    expected = updated(mean, wider, [0.3, 0.1])
    belief = steered.update(STATE, [0.3, 0.1])
    assert belief.mean == pytest.approx(expected[0], abs=1e-12)
    assert belief.covariance == pytest.approx(expected[1], abs=1e-12)
    assert np.array_equal(steered.belief.mean, belief.mean)
    steered.reset()
    assert np.array_equal(steered.belief.mean, MEAN)
    assert np.array_equal(steered.belief.covariance, COVARIANCE)


def test_process_noise_makes_no_belief_wider_than_the_prior() -> None:
    steered = IntentionFilter(MODEL, MEAN, COVARIANCE, process_noise=50.0)
    expected = updated(MEAN, COVARIANCE, [0.4, -0.1])  # the noise alone would bring it far beyond
    belief = steered.update(STATE, [0.4, -0.1])
    assert belief.mean == pytest.approx(expected[0], abs=1e-9)
    assert belief.covariance == pytest.approx(expected[1], abs=1e-9)
    for _ in range(5):  # where nothing is known, the belief widens, but no farther
        belief = steered.update(STATE + 1e3, [0.0, 0.0])
    assert np.linalg.eigvalsh(COVARIANCE - belief.covariance).min() > -1e-9


def test_the_filter_finds_the_goal_that_a_driver_goes_to() -> None:
    random = np.random.default_rng(5)
    places = np.array([[5.0, 0.0], [-5.0, 0.0], [0.0, 5.0]])
    states, goals = random.uniform(-4, 4, (600, 2)), places[np.arange(600) % 3]

    def steer(at: Floats, to: Floats) -> Floats:
        return (to - at) / np.linalg.norm(to - at, axis=1, keepdims=True)

    actions = steer(states, goals) + random.normal(0, 0.1, (600, 2))
    kernels = [ActionKernel(1.0, [3.0, 3.0], [4.0, 4.0], 0.15)] * 2
    steered = IntentionFilter(ActionModel(states, goals, actions, kernels), places.mean(0), np.cov(places.T), 0.01)
    for goal in range(3):
        steered.reset()
        for at in random.uniform(-2, 2, (15, 2)):
            belief = steered.update(at, steer(at[None], places[[goal]])[0] + random.normal(0, 0.1, 2))
        assert goal_likelihoods(belief.mean, belief.covariance, places).argmax() == goal


def test_a_belief_that_collapses_stays_one() -> None:
    states, goals, actions = data(60)
    sharp = [ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 1e-5) for k in KERNELS]
    steered = IntentionFilter(ActionModel(states, goals, actions, sharp), MEAN, 100 * np.eye(2))
    for state, action in zip(np.tile(states, (5, 1)), np.tile(actions, (5, 1)), strict=True):
        belief = steered.update(state, action)
        assert np.linalg.eigvalsh(belief.covariance).min() > -1e-12 * np.trace(belief.covariance)
        assert np.array_equal(belief.covariance, belief.covariance.T)


def test_likelihoods_are_the_softmax_of_mahalanobis_distances() -> None:
    goals = np.array([[0.0, 0.0], [1.0, 2.0], [-1.0, 0.3]])
    gaps = goals - MEAN
    odds = np.exp(-0.5 * (gaps @ np.linalg.inv(COVARIANCE) * gaps).sum(1))
    assert goal_likelihoods(MEAN, COVARIANCE, goals) == pytest.approx(odds / odds.sum(), rel=1e-12)


def test_likelihoods_of_a_belief_without_spread_all_go_to_the_nearest_goal() -> None:
    goals = np.array([[0.0, 0.0], [1.0, 2.0], [0.0, 0.3]])
    assert goal_likelihoods([0.9, 1.9], np.zeros((2, 2)), goals) == pytest.approx([0, 1, 0], abs=1e-300)
    flat = goal_likelihoods([0.5, 0.0], np.diag([4.0, 0.0]), goals)
    assert flat == pytest.approx([1, 0, 0], abs=1e-300)
    assert goal_likelihoods([1e6, 0], 1e-12 * np.eye(2), goals[:1]).tolist() == [1]


def test_a_belief_narrow_in_one_direction_is_taken_as_narrow_as_it_is() -> None:
    """Down to 1e-6 of the wide one's standard deviation, or 1 nm; narrower ones count as that."""
    for wide, narrow, taken in ((4.0, 4e-10, 4e-10), (4.0, 4e-14, 4e-12), (1e-14, 1e-14, 1e-14), (0.0, 0.0, 1e-18)):
        step = np.sqrt(taken)
        found = goal_likelihoods([0.0, 0.0], np.diag([wide, narrow]), [[0.0, step], [0.0, 2 * step]])
        assert found[1] / found[0] == pytest.approx(np.exp(-1.5), rel=1e-6)


def test_one_goal_only_is_a_model_and_leaves_a_certain_belief_as_it_is() -> None:
    states, goals, actions = data(50, places=1)
    one = ActionModel(states, goals, actions, KERNELS)
    assert one.shared_goals == 1
    belief = IntentionFilter(one, goals[0], np.zeros((2, 2))).update(STATE, [0.1, 0.1])
    assert np.array_equal(belief.mean, goals[0])
    assert np.array_equal(belief.covariance, np.zeros((2, 2)))


def test_duplicate_samples_need_noise_and_are_left_out_of_a_projection() -> None:
    states, goals, actions = (np.vstack([part, part[:10]]) for part in data(40))
    quiet = [ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 0.0) for k in KERNELS]
    with pytest.raises(ValueError, match="not positive definite: raise a kernel's noise"):
        ActionModel(states, goals, actions, quiet)
    full = ActionModel(states, goals, actions, KERNELS).moments(STATE, MEAN, COVARIANCE)
    projected = ActionModel(states, goals, actions, KERNELS, subset=range(50)).moments(STATE, MEAN, COVARIANCE)
    assert apart(projected, full.mean, full.covariance, full.cross_covariance) < 1e-7


def test_without_noise_the_samples_are_interpolated_and_their_action_tells_nothing_of_a_certain_goal() -> None:
    states, goals, actions = data(20)
    quiet = [ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 0.0) for k in KERNELS]
    exact = ActionModel(states, goals, actions, quiet)
    moments = exact.moments(states[3], goals[3], np.zeros((2, 2)))
    assert moments.mean == pytest.approx(actions[3], abs=1e-8)
    assert np.abs(moments.covariance).max() < 1e-8
    with pytest.raises(ValueError, match="larger noise"):
        filter_ = IntentionFilter(
            ActionModel(states[:1], goals[:1], np.zeros((1, 2)), quiet), goals[0], np.zeros((2, 2))
        )
        filter_.update(states[0], [0.0, 0.0])


def test_a_refused_update_leaves_the_belief_as_it_was() -> None:
    steered = IntentionFilter(MODEL, MEAN, COVARIANCE)
    for state, action, message in (
        ([np.nan, 0, 0], [0, 0], "state must be finite"),
        (STATE, [np.nan, 0], "action must be finite"),
        (STATE, [0, np.inf], "action must be finite"),
        (STATE, [0, 1e200], "action must lie within 1e20"),
        ([1e200, 0, 0], [0, 0], "state must be finite and within 1e20"),
        (STATE[:2], [0, 0], "one value for every state length-scale"),
        (STATE, [0], "one value for every kernel"),
    ):
        with pytest.raises(ValueError, match=message):
            steered.update(state, action)
        assert np.array_equal(steered.belief.mean, MEAN)
        assert np.array_equal(steered.belief.covariance, COVARIANCE)


@pytest.mark.parametrize(
    ("mean", "covariance", "message"),
    [
        ([0.0, np.nan], np.eye(2), "finite"),
        ([0.0, 0.0], np.full((2, 2), np.inf), "finite"),
        ([0.0, 0.0], np.array([[1, 0.5], [0, 1]]), "symmetric"),
        ([0.0, 0.0], -np.eye(2), "negative variance"),
        ([0.0, 0.0], np.array([[1.0, 2.0], [2.0, 1.0]]), "positive semidefinite"),
        ([0.0, 0.0], np.array([[0.0, 1.0], [1.0, 0.0]]), "positive semidefinite"),
        ([0.0, 0.0], np.array([[1.0, 1.0001], [1.0001, 1.0]]), "positive semidefinite"),
        ([0.0, 1e21], np.eye(2), "must lie within 1e20 m"),
        ([0.0, 0.0], 1e41 * np.eye(2), "its covariance within 1e40"),
        ([0.0, 0.0, 0.0], np.eye(2), "as many dimensions"),
        ([0.0], np.eye(1), "as many dimensions"),
        (np.zeros(5), np.eye(5), "at most 4"),
    ],
)
def test_what_is_no_belief_is_refused(mean: Floats, covariance: Floats, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        MODEL.moments(STATE, mean, covariance)
    with pytest.raises(ValueError, match=message):
        IntentionFilter(MODEL, mean, covariance)


def test_data_that_do_not_fit_are_refused_by_name() -> None:
    states, goals, actions = data(20)
    bad = states.copy()
    bad[3, 1] = np.nan
    for arguments, message in (
        ((bad, goals, actions, KERNELS), "must be finite"),
        ((states[:0], goals[:0], actions[:0], KERNELS), "at least one sample"),
        ((states[:5], goals, actions, KERNELS), "5 states but 20 goals"),
        ((states, goals, actions, KERNELS[:1]), "1 kernels for 2 actions"),
        ((states[:, :2], goals, actions, KERNELS), "have 2 and 2 columns"),
        ((states, goals, actions, KERNELS, [20]), r"names sample 20, must be in \[0, 19\]"),
        ((states, goals, actions, KERNELS, [-1]), "names sample -1"),
        ((states, goals, actions, KERNELS, [3, 3]), "names sample 3 twice"),
        ((states, goals, actions, KERNELS, []), "subset is empty"),
        ((states, goals, actions, KERNELS, [1.5, 2]), "names sample 1.500000, must be integers"),
        ((states, goals, actions, KERNELS, [np.nan]), "names sample nan, must be integers"),
        ((states, goals, actions, KERNELS, [[1, 2]]), "the subset has 2 dimensions"),
        ((1e200 * states, goals, actions, KERNELS), "a state is .* must be between 0 and 1e[+]20"),
        ((states, 1e200 * goals, actions, KERNELS), "a goal is .* must be between 0 and 1e[+]20"),
        ((states, goals, 1e200 * actions, KERNELS), "an action is .* must be between 0 and 1e[+]20"),
    ):
        with pytest.raises(ValueError, match=message):
            ActionModel(*arguments)
    for values, message in (
        ((0.0, [1], [1], 0.1), "amplitude is 0"),
        ((1.0, [1], [1], -0.1), "noise is -0.1"),
        ((1.0, [np.nan], [1], 0.1), "state length-scale"),
        ((1.0, [1], [0], 0.1), "goal length-scale is 0"),
        ((1e21, [1], [1], 0.1), "amplitude is 1e[+]21, must be between 1e-20 and 1e[+]20"),
        ((1.0, [1e-21], [1], 0.1), "a state length-scale is 1e-21"),
        ((1.0, [1], [1e100], 0.1), "a goal length-scale is 1e[+]100 m"),
        ((1.0, [1], [1], 1e21), "noise is 1e[+]21"),
        ((1.0, [1], [1] * 5, 0.1), "5 goal length-scales, must have 1 to 4"),
    ):
        with pytest.raises(ValueError, match=message):
            ActionKernel(*values)
    with pytest.raises(ValueError, match=r"process_noise is -1.* m\^2"):
        IntentionFilter(MODEL, MEAN, COVARIANCE, process_noise=-1)
    with pytest.raises(ValueError, match="no goals"):
        goal_likelihoods(MEAN, COVARIANCE, np.zeros((0, 2)))
    with pytest.raises(ValueError, match="goals must lie within 1e20 m"):
        goal_likelihoods(MEAN, COVARIANCE, [[1e200, 0.0], [-1e200, 0.0]])
    with pytest.raises(ValueError, match="goals must be finite"):
        goal_likelihoods(MEAN, COVARIANCE, [[np.nan, 0.0]])


def test_the_largest_numbers_that_are_taken_give_numbers() -> None:
    states, goals, actions = data(20)
    for amplitude, length, noise in ((1e20, 1e-20, 1e20), (1e20, 1e20, 1e20), (1e-20, 1e-20, 0.0), (1, 1e20, 1)):
        kernels = [ActionKernel(amplitude, [length] * 3, [length] * 2, noise)] * 2
        for scale in (1e-20, 1.0, 1e19):
            big = ActionModel(states * scale, goals * scale, actions * scale, kernels)
            for mean, covariance in ((MEAN, COVARIANCE), (1e20 * np.ones(2), 1e40 * np.eye(2))):
                found = big.moments(STATE, mean, covariance)
                assert all(np.isfinite(part).all() for part in (found.mean, found.covariance, found.cross_covariance))


def test_far_states_and_goals_give_the_prior_and_teach_nothing() -> None:
    moments = MODEL.moments([1e9, 0, 0], MEAN, COVARIANCE)
    assert moments.mean == pytest.approx([0, 0], abs=1e-100)
    assert moments.covariance == pytest.approx(np.diag([1.2**2 + 0.2**2, 0.8**2 + 0.3**2]))
    outside = IntentionFilter(MODEL, [1e7, 1e7], COVARIANCE).update(STATE, [1, 1])
    assert outside.mean == pytest.approx([1e7, 1e7])


def test_memory_is_a_triangle_an_action() -> None:
    full, sparse = model(640), model(640, subset=range(0, 640, 4))
    assert full.nbytes < 2 * 8 * 640 * 641 / 2 * 1.15
    assert sparse.nbytes < 2 * 8 * 160 * 161 / 2 * 1.4
    assert (len(full), len(sparse), sparse.size) == (640, 160, 160)


def test_kernels_and_beliefs_survive_pickling() -> None:
    kernel = pickle.loads(pickle.dumps(KERNELS[1]))
    assert (kernel.amplitude, kernel.noise) == (0.8, 0.3)
    assert kernel.goal_lengthscales.tolist() == [2.0, 1.1]
    assert pickle.loads(pickle.dumps(Belief(MEAN, COVARIANCE))).covariance.tolist() == COVARIANCE.tolist()


def test_threads_may_share_a_filter() -> None:
    steered = IntentionFilter(MODEL, MEAN, COVARIANCE)
    threads = [
        threading.Thread(target=lambda: [steered.update(STATE, [0.1, 0.2]) for _ in range(50)]) for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = IntentionFilter(MODEL, MEAN, COVARIANCE)
    for _ in range(200):
        belief = alone.update(STATE, [0.1, 0.2])
    assert np.array_equal(steered.belief.mean, belief.mean)
