"""Interaction primitives against Gaussian conditioning with D x D matrices, importance sampling, and their laws."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.primitives import (
    Dmp,
    DmpConfig,
    InteractionPosterior,
    InteractionPrimitive,
    InteractionPrimitiveConfig,
    basis,
    partner_forcing,
    phases,
)

Floats = NDArray[np.float64]
STEPS, PARTNER, ROBOT, M = 201, 2, 1, 10
N = PARTNER + ROBOT
DMP = DmpConfig(basis_functions=M)
KINDS = ["forcing", "positions"]


def motions(count: int, seed: int = 0) -> tuple[list[Floats], list[Floats], Floats]:
    """Partner and robot pass over boxes of different width and height: the environment."""
    random = np.random.default_rng(seed)
    t = np.linspace(0, 1, STEPS)
    rise = t**3 * (10 - 15 * t + 6 * t**2)
    boxes = random.uniform(0.5, 2, (count, 2))
    partner, robot = [], []
    for width, height in boxes:
        style = random.normal(size=3) * 0.1
        x = width * rise + style[0] * np.sin(np.pi * rise)
        y = height * np.sin(np.pi * rise) + style[1] * rise
        partner.append(np.c_[x, y])
        robot.append((height * np.sin(np.pi * rise) ** 2 + style[2] * rise)[:, None])
    return partner, robot, boxes


def primitive(count: int = 8, scene: bool = True, **options: object) -> InteractionPrimitive:
    partner, robot, boxes = motions(count)
    config = InteractionPrimitiveConfig(dmp=DMP, **options)  # type: ignore[arg-type]
    return InteractionPrimitive.fit(partner, robot, boxes if scene else None, config)


def covariance(posterior: InteractionPosterior) -> Floats:
    return posterior.factor @ posterior.factor.T


def response(at: Floats) -> Floats:
    """Rows of positions at phases for w, g, y0, from roll-outs of unit parameters."""
    columns = []
    for k in range(M + 2):
        w, g, y0 = np.zeros((1, M)), [float(k == M)], [float(k == M + 1)]
        w[0, : k + 1] = np.arange(M)[: k + 1] == k
        unit = Dmp(y0, g, w, DMP)
        columns.append([unit.rollout(2, duration=-np.log(x) / DMP.phase_decay or 1e-12).positions[-1, 0] for x in at])
    return np.array(columns).T


def dense(
    model: InteractionPrimitive, partner: Floats, at: Floats, scene: Floats | None
) -> tuple[Floats, Floats, Floats, Floats]:
    """5.15 and 5.17 literally: theta extended by starts and standardised e, one big Gaussian, matrices of its size."""
    S, E = len(model.parameters), 0 if scene is None else len(scene)
    all_theta = [np.c_[model.parameters[:, d * (M + 1) : (d + 1) * (M + 1)], model.starts[:, d]] for d in range(N)]
    joint = np.hstack(all_theta)
    if scene is not None:
        e = model.environment
        joint = np.c_[joint, (e - e.mean(0)) / e.std(0)]
        scene = (scene - e.mean(0)) / e.std(0)
    mu, Sigma = joint.mean(0), (joint - joint.mean(0)).T @ (joint - joint.mean(0)) / S
    if model.config.observe == "forcing":
        values = partner_forcing(partner, at, DMP)
        rows = np.c_[basis(at, DMP), np.full(len(at), DMP.stiffness * DMP.damping), np.zeros(len(at))]
    else:
        values, rows = partner, response(at)
    Omega = np.zeros((PARTNER * len(at) + E, len(mu)))
    Omega[: PARTNER * len(at), : PARTNER * (M + 2)] = np.kron(np.eye(PARTNER), rows)
    Omega[PARTNER * len(at) :, N * (M + 2) :] = np.eye(E)
    F = values.T.ravel() if scene is None else np.r_[values.T.ravel(), scene]
    R = np.r_[np.full(PARTNER * len(at), model.config.noise), np.full(E, model.config.environment_noise)]
    seen = ~np.isnan(F)
    Omega, F, R = Omega[seen], F[seen], R[seen]
    A = np.diag(R) + Omega @ Sigma @ Omega.T
    gain = np.linalg.solve(A, Omega @ Sigma).T
    keep = np.concatenate([np.arange(M + 1) + d * (M + 2) for d in range(N)])
    mean, spread = mu + gain @ (F - Omega @ mu), Sigma - gain @ Omega @ Sigma
    return mean[keep], spread[np.ix_(keep, keep)], mean, spread


@pytest.mark.parametrize("observe", KINDS)
@pytest.mark.parametrize("scene", [True, False])
def test_the_posterior_is_that_of_dense_gaussian_conditioning(observe: str, scene: bool) -> None:
    model = primitive(observe=observe, noise=400.0 if observe == "forcing" else 1e-4)
    partner = motions(3, seed=9)[0][1][:60]
    at, e = phases(STEPS, DMP)[:60], np.array([1.1, 0.9]) if scene else None
    posterior = model.condition(partner, at, e)
    mean, spread, _, _ = dense(model, partner, at, e)
    assert np.allclose(posterior.mean, mean, atol=1e-6 * np.abs(mean).max())
    assert np.allclose(covariance(posterior), spread, atol=1e-6 * np.abs(spread).max())
    assert posterior.trace == pytest.approx(np.trace(spread), rel=1e-5)


def test_the_posterior_is_that_of_importance_sampling() -> None:
    model = primitive(6, noise=1e6, environment_noise=0.3)
    partner, at, e = motions(3, seed=9)[0][1][:40:10], phases(STEPS, DMP)[:40:10], np.array([1.2, 1.4])
    random, S = np.random.default_rng(0), 6
    z = random.normal(size=(400_000, S))
    centred = (model.parameters - model.parameters.mean(0)) / np.sqrt(S)
    theta = model.parameters.mean(0) + z @ centred
    rows = np.c_[basis(at, DMP), np.full(len(at), DMP.stiffness * DMP.damping)]
    F = partner_forcing(partner, at, DMP)
    boxes = model.environment
    log = np.zeros(len(z))
    for d in range(PARTNER):
        off = theta[:, d * (M + 1) : (d + 1) * (M + 1)] @ rows.T - F[:, d]
        log -= (off**2).sum(1) / (2e6)
    off_e = z @ ((boxes - boxes.mean(0)) / boxes.std(0)) / np.sqrt(S) - (e - boxes.mean(0)) / boxes.std(0)
    log -= (off_e**2).sum(1) / 0.6
    weight = np.exp(log - log.max())
    weight /= weight.sum()
    mean = weight @ theta
    posterior = model.condition(partner, at, e)
    spread = np.sqrt(np.diag(covariance(posterior)))
    error = 5 / np.sqrt(1 / (weight**2).sum())  # five standard errors of the effective sample
    assert np.all(np.abs(mean - posterior.mean) < error * spread + 1e-9)


@pytest.mark.parametrize("observe", KINDS)
def test_one_sample_after_the_other_equals_the_batch(observe: str) -> None:
    model = primitive(observe=observe)
    partner, at, e = motions(3, seed=9)[0][1][:50], phases(STEPS, DMP)[:50], np.array([1.1, 0.9])
    values = partner if observe == "positions" else partner_forcing(partner, at, DMP)
    observer = model.begin(e)
    for x, row in zip(at, values, strict=True):
        observer.observe(x, row)
    one, batch = observer.posterior(), model.condition(partner, at, e)
    assert np.abs(one.mean - batch.mean).max() < 1e-10 * np.abs(batch.mean).max()
    backwards = model.begin(e)
    for x, row in zip(at[::-1], values[::-1], strict=True):
        backwards.observe(x, row)
    assert np.allclose(backwards.posterior().mean, batch.mean, rtol=1e-7, atol=1e-7 * np.abs(batch.mean).max())


@pytest.mark.parametrize("observe", KINDS)
def test_missing_dimensions_and_rows_are_as_if_never_there(observe: str) -> None:
    model = primitive(observe=observe)
    partner, at = motions(3, seed=9)[0][1][:60].copy(), phases(STEPS, DMP)[:60]
    partner[:, 1] = np.nan
    partner[20:25, 0] = np.nan
    mean, _, _, _ = dense(model, partner, at, None)
    posterior = model.condition(partner, at)
    assert np.allclose(posterior.mean, mean, atol=1e-5 * np.abs(mean).max())
    nothing = model.condition(np.full((60, 2), np.nan), at)
    assert np.array_equal(nothing.mean, model.condition().mean)


@settings(deadline=None, max_examples=30)
@given(st.integers(1, 60), st.integers(0, 1000), st.sampled_from(KINDS))
def test_more_observation_never_increases_the_trace(count: int, seed: int, observe: str) -> None:
    model = primitive(observe=observe)
    observer, random = model.begin(), np.random.default_rng(seed)
    before = model.condition().trace
    for x in phases(STEPS, DMP)[random.integers(0, STEPS, min(count, 10))]:
        observer.observe(x, random.normal(size=PARTNER))
        posterior = observer.posterior()
        assert posterior.trace <= before * (1 + 1e-9)
        before = posterior.trace
    values = np.linalg.eigvalsh(covariance(posterior))
    assert values.min() > -1e-9 * values.max()


def test_nothing_seen_gives_the_prior() -> None:
    model = primitive()
    posterior = model.condition()
    theta = model.parameters
    assert np.allclose(posterior.mean, theta.mean(0))
    assert np.allclose(covariance(posterior), np.cov(theta.T, bias=True), atol=1e-9 * np.abs(theta).max() ** 2)


def test_an_environment_not_given_is_the_plain_interaction_primitive() -> None:
    partner, at = motions(3, seed=9)[0][1][:60], phases(STEPS, DMP)[:60]
    with_scene, without = primitive().condition(partner, at), primitive(scene=False).condition(partner, at)
    assert np.array_equal(with_scene.mean, without.mean)
    unknown = primitive().condition(partner, at, [np.nan, np.nan])
    assert np.array_equal(unknown.mean, without.mean)


def test_the_environment_alone_moves_the_robot() -> None:
    model = primitive(20)
    low, high = (model.condition(environment=[1.0, h]).robot.rollout(51).positions[25, 0] for h in (0.6, 1.9))
    assert high - low == pytest.approx(1.3, rel=0.15)


def test_units_of_the_environment_do_not_matter() -> None:
    """ERRATA 43."""
    partner, robot, boxes = motions(8)
    config = InteractionPrimitiveConfig(dmp=DMP)
    metres = InteractionPrimitive.fit(partner, robot, boxes, config).condition(environment=[1.1, 0.9])
    other = InteractionPrimitive.fit(partner, robot, boxes * 1000 + 50, config).condition(environment=[1150, 950])
    assert np.allclose(metres.mean, other.mean, rtol=1e-9, atol=1e-9 * np.abs(metres.mean).max())


def test_printed_weights_equal_the_joint_gaussian_when_demonstrations_are_few() -> None:
    """ERRATA 42: S <= D."""
    partner, at = motions(3, seed=9)[0][1][:40], phases(STEPS, DMP)[:40]
    joint = primitive().condition(partner, at, [1.1, 0.9])
    printed = primitive(printed_environment_weights=True).condition(partner, at, [1.1, 0.9])
    assert np.abs(joint.mean - printed.mean).max() < 1e-10 * np.abs(joint.mean).max()


def test_printed_weights_are_biased_when_demonstrations_are_many() -> None:
    """ERRATA 42: S > D; the environment depends on theta with an intercept that w_e lacks."""
    random = np.random.default_rng(0)
    theta = random.normal(size=(60, 6)) + 2
    e = theta[:, :1] + 5
    error = {}
    for printed in (False, True):
        config = InteractionPrimitiveConfig(
            dmp=DmpConfig(basis_functions=2), noise=1.0, printed_environment_weights=printed
        )
        model = InteractionPrimitive(theta, np.zeros((60, 2)), e, 1, config)
        error[printed] = abs(model.condition(environment=[8.0]).mean[0] - 3)
    assert error[False] < 0.01
    assert error[True] > 10 * error[False]


@pytest.mark.parametrize("observe", KINDS)
def test_the_motion_is_linear_in_the_parameters(observe: str) -> None:
    """Mean and covariance of the trajectory from theta's, by roll-outs; and from draws."""
    model = primitive(observe=observe)
    partner, at = motions(3, seed=9)[0][1][:40], phases(STEPS, DMP)[:40]
    posterior = model.condition(partner, at, [1.0, 1.5])
    made = posterior.trajectory(30)
    assert np.allclose(made.mean[:, :PARTNER], posterior.partner.rollout(30).positions, atol=1e-9)
    assert np.allclose(made.mean[:, PARTNER:], posterior.robot.rollout(30).positions, atol=1e-9)
    _, _, _, spread = dense(model, partner, at, np.array([1.0, 1.5]))
    H = np.kron(np.eye(N), response(np.exp(-DMP.phase_decay * np.array([1e-12, 0.5, 1.0]))))
    full = H @ spread[: N * (M + 2), : N * (M + 2)] @ H.T
    for row, k in ((1, None), (2, 29)):
        block = full[row::3, row::3]
        here = posterior.trajectory(3).covariance[1] if k is None else made.covariance[k]
        assert np.allclose(here, block, atol=1e-5 * np.abs(full).max())
    draws = posterior.sample_trajectories(4000, 30, seed=3)
    assert np.allclose(draws.mean(0), made.mean, atol=0.1 * np.sqrt(made.covariance.max()) + 1e-9)
    assert np.array_equal(draws, posterior.sample_trajectories(4000, 30, seed=3))
    thetas = posterior.sample(3, seed=3)
    last = Dmp(posterior.start[2:], thetas[0, -1:], thetas[0, -M - 1 : -1][None], DMP)
    assert last.rollout(30).positions[-1, 0] == pytest.approx(draws[0, -1, 2], abs=1e-4)


def test_a_model_restored_from_its_arrays_gives_identical_answers() -> None:
    model = primitive()
    again = InteractionPrimitive(
        model.parameters, model.starts, model.environment, model.partner_dimensions, model.config
    )
    partner, at = motions(3, seed=9)[0][1][:40], phases(STEPS, DMP)[:40]
    for copy in (again, pickle.loads(pickle.dumps(model))):
        one, other = model.condition(partner, at, [1.0, 1.5]), copy.condition(partner, at, [1.0, 1.5])
        assert np.array_equal(one.mean, other.mean)
        assert np.array_equal(one.factor, other.factor)


def test_demonstrations_of_different_length_are_compared_by_time() -> None:
    partner, robot, boxes = motions(8)
    config = InteractionPrimitiveConfig(dmp=DMP, observe="forcing")
    every = InteractionPrimitive.fit(partner, robot, boxes, config).parameters
    thinned = [[y[::2] if j % 2 else y for j, y in enumerate(side)] for side in (partner, robot)]
    some = InteractionPrimitive.fit(*thinned, boxes, config).parameters
    assert np.abs(every - some).max() < 0.03 * np.abs(every).max()


def test_the_default_noise_is_the_pooled_residual() -> None:
    """ERRATA F13, 41."""
    partner, _, _ = motions(8)
    model = primitive(observe="forcing")
    phi, rest = basis(phases(STEPS, DMP), DMP), []
    for y in partner:
        h = 1 / (STEPS - 1)
        v = np.gradient(y, h, axis=0, edge_order=2)
        f = np.gradient(v, h, axis=0, edge_order=2) - 25 * (6.25 * (y[-1] - y) - v)
        rest.append(f - phi @ np.linalg.lstsq(phi, f, rcond=None)[0])
    assert model.config.noise == pytest.approx((np.array(rest) ** 2).mean(), rel=1e-6)


def test_observing_positions_is_better_than_forcing_when_tracking_is_noisy() -> None:
    (partner, _, boxes), (unseen, _, others) = motions(12), motions(6, seed=9)
    t = np.linspace(0, 1, STEPS)[:, None]
    shape = np.sin(np.pi * t**3 * (10 - 15 * t + 6 * t**2)) ** 2
    robot, random, error = [height * shape for _, height in boxes], np.random.default_rng(0), {}
    noisy = [y + 0.01 * random.normal(size=y.shape) for y in partner]
    seen = [y[:80] + 0.01 * random.normal(size=(80, 2)) for y in unseen]
    for observe in KINDS:
        model = InteractionPrimitive.fit(noisy, robot, None, InteractionPrimitiveConfig(dmp=DMP, observe=observe))
        made = [model.condition(y, phases(STEPS, DMP)[:80]).robot.rollout(STEPS).positions for y in seen]
        truth = [height * shape for _, height in others]
        error[observe] = np.sqrt(np.mean((np.array(made) - np.array(truth)) ** 2))
    assert error["positions"] < 0.7 * error["forcing"], error


def refusal(**changes: object) -> InteractionPrimitive:
    partner, robot, boxes = motions(4)
    given_ = {"partner": partner, "robot": robot, "environment": boxes} | changes
    return InteractionPrimitive.fit(**given_)  # type: ignore[arg-type]


PARTNERS, ROBOTS, BOXES = motions(4)
AT = phases(STEPS, DMP)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: refusal(partner=PARTNERS[:1], robot=ROBOTS[:1], environment=BOXES[:1]), "demonstrations is 1"),
        (lambda: refusal(robot=ROBOTS[:3]), "4 motions of the partner, but 3"),
        (
            lambda: refusal(robot=[*ROBOTS[:3], ROBOTS[3][:99]]),
            "demonstration 3 has 201 samples of the partner, but 99",
        ),
        (lambda: refusal(partner=[*PARTNERS[:3], PARTNERS[3][:, :1]]), r"demonstration 3 has 1 \+ 1 dimensions"),
        (lambda: refusal(partner=[*PARTNERS[:3], PARTNERS[3] * np.nan]), r"positions\[0, 0\] is nan"),
        (lambda: refusal(environment=BOXES[:3]), r"environment has shape \(3, 2\), must have \(4, 2\)"),
        (lambda: refusal(environment=np.ones((4, 2))), "column 0 is 1.0.* in all demonstrations"),
        (lambda: refusal(environment=BOXES * np.nan), "environment must be finite"),
        (lambda: primitive().condition(PARTNERS[0][:, :1], AT), "partner has 1 dimensions, must have 2"),
        (lambda: primitive().condition(PARTNERS[0], AT[:9]), "201 samples of the partner, but 9 phases"),
        (lambda: primitive().condition(PARTNERS[0][:2], [0.5, 0.5]), r"phase\[1\] is 0.5.*below"),
        (lambda: primitive().condition(PARTNERS[0][:2], [1.5, 0.5]), "phase is 1.5"),
        (lambda: primitive().condition(PARTNERS[0][:2], [1.0, 0.001]), "phase is 0.001"),
        (lambda: primitive().condition(np.full((3, 2), np.inf), AT[:3]), r"partner\[0, 0\] is inf"),
        (lambda: primitive().condition(environment=[1.0]), "environment has 1 values, must have 2"),
        (lambda: primitive().condition(environment=[1.0, np.inf]), r"environment\[1\] is inf"),
        (lambda: primitive(scene=False).condition(environment=[1.0]), "without one"),
        (lambda: primitive().begin().observe(0.5, [1.0]), "values has 1 values, must have 2"),
        (lambda: primitive().begin().observe(0.0, [1.0, 1]), "phase is 0"),
        (lambda: primitive().condition().trajectory(1), "steps is 1"),
        (lambda: primitive().condition().sample(0, 1), "count is 0"),
        (lambda: InteractionPrimitiveConfig(noise=0.0), "noise is 0"),
        (lambda: InteractionPrimitiveConfig(environment_noise=-1), "environment_noise is -1"),
        (lambda: InteractionPrimitiveConfig(observe="speed"), "observe is 'speed', must be forcing or positions"),
        (
            lambda: InteractionPrimitive(np.zeros((4, 21)), np.zeros((4, 1)), None, 1, InteractionPrimitiveConfig()),
            "noise is not set",
        ),
        (
            lambda: InteractionPrimitive(
                np.zeros((4, 20)), np.zeros((4, 1)), None, 1, InteractionPrimitiveConfig(noise=1.0)
            ),
            r"parameters has shape \(4, 20\), must have \(4, 21\)",
        ),
    ],
)
def test_wrong_input_is_refused_by_name(call: object, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()  # type: ignore[operator]


# -- what was seen is how likely --------------------------------------------------------------------------------------


def walks(seed: int, count: int = 6) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(60, 2)).cumsum(axis=0) for _ in range(count)]


def test_the_likelihood_is_that_of_the_dense_gaussian() -> None:
    partner, environment = walks(1), np.random.default_rng(2).normal(size=(6, 2))
    dmp = DmpConfig(basis_functions=5)
    config = InteractionPrimitiveConfig(dmp=dmp, observe="forcing", noise=3e4)
    primitive = InteractionPrimitive.fit(partner, [motion[:, :1] for motion in partner], environment, config)
    phase, seen = phases(60, dmp)[:20], partner[0][:20] + 0.1
    theta = primitive.parameters
    loading = ((theta - theta.mean(axis=0)) / np.sqrt(6)).T
    row = np.column_stack([basis(phase, dmp), np.full(20, dmp.stiffness * dmp.damping)])
    rows = np.zeros((40, theta.shape[1]))
    rows[:20, :6], rows[20:, 6:12] = row, row
    scaled = environment / environment.std(axis=0)
    mean = np.r_[rows @ theta.mean(axis=0), scaled.mean(axis=0)]
    spread = np.vstack([rows @ loading, ((scaled - scaled.mean(axis=0)) / np.sqrt(6)).T])
    covariance = spread @ spread.T + np.diag(np.r_[np.full(40, 3e4), np.full(2, 1e-3)])
    off = np.r_[partner_forcing(seen, phase, dmp).T.ravel(), environment[1] / environment.std(axis=0)] - mean
    expected = -0.5 * (off @ np.linalg.solve(covariance, off) + np.linalg.slogdet(2 * np.pi * covariance)[1])
    found = primitive.condition(seen, phase, environment[1]).log_likelihood
    assert found == pytest.approx(expected, rel=1e-9)


def test_nothing_seen_has_likelihood_1_and_one_by_one_is_as_at_once() -> None:
    partner = walks(3)
    config = InteractionPrimitiveConfig(dmp=DmpConfig(basis_functions=5), observe="positions", noise=0.5)
    primitive = InteractionPrimitive.fit(partner, partner, None, config)
    assert primitive.condition().log_likelihood == 0
    phase, seen = phases(60, config.dmp)[:20], partner[1][:20].copy()
    seen[4:9, 0] = np.nan
    observer = primitive.begin()
    for at, values in zip(phase, seen, strict=True):
        observer.observe(float(at), values)
    at_once = primitive.condition(seen, phase).log_likelihood
    assert observer.posterior().log_likelihood == pytest.approx(at_once, rel=1e-9)
