"""Dynamic movement primitives against an ODE solver, their laws, and real handwriting."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from lfdcore.primitives import Dmp, DmpConfig, basis, forcing_terms, phases

Floats = NDArray[np.float64]
EXACT = 1e-9  # of the range: what the roll-out promises


def reaching(steps: int = 500) -> Floats:
    """From rest to rest, two degrees of freedom."""
    t = np.linspace(0, 1, steps)[:, None]
    rise = t**3 * (10 - 15 * t + 6 * t**2)
    return np.hstack([rise, 0.5 - rise + 0.4 * np.sin(np.pi * rise) ** 2])


def random_dmp(seed: int, dof: int = 3, config: DmpConfig | None = None) -> Dmp:
    random, config = np.random.default_rng(seed), config or DmpConfig()
    weights = 100 * random.normal(size=(dof, config.basis_functions))
    return Dmp(random.normal(size=dof), random.normal(size=dof), weights, config)


def solved(dmp: Dmp, s: Floats, phase: float = 1.0, y: Floats | None = None, v: Floats | None = None) -> Floats:
    """5.1 in normalised time by an adaptive Runge-Kutta method: states (len(s), 2 D)."""
    c, D = dmp.config, dmp.dimensions

    def slope(time: float, state: Floats) -> Floats:
        f = (basis([phase * np.exp(-c.phase_decay * time)], c) @ dmp.weights.T)[0]
        return np.r_[state[D:], c.stiffness * (c.damping * (dmp.goal - state[:D]) - state[D:]) + f]

    begin = np.r_[dmp.start if y is None else y, np.zeros(D) if v is None else v]
    return solve_ivp(slope, (0, s[-1]), begin, t_eval=s, rtol=1e-11, atol=1e-12).y.T


def naive_basis(x: Floats, config: DmpConfig) -> Floats:
    centres = np.exp(-config.phase_decay * np.arange(config.basis_functions) / (config.basis_functions - 1))
    widths = 1 / np.diff(centres) ** 2
    psi = np.exp(-np.append(widths, widths[-1]) * (x[:, None] - centres) ** 2)
    return psi / psi.sum(1, keepdims=True) * x[:, None]


@pytest.mark.parametrize("count", [2, 8, 20, 33])
def test_the_basis_is_5_2_written_out(count: int) -> None:
    config = DmpConfig(basis_functions=count)
    x = phases(200, config)
    assert np.allclose(basis(x, config), naive_basis(x, config), atol=1e-14)


def test_the_basis_is_finite_far_below_its_last_centre() -> None:
    values = basis([1e-12, 1e-300], DmpConfig(basis_functions=500))
    assert np.allclose(values.sum(1), [1e-12, 1e-300], rtol=1e-12)


@pytest.mark.parametrize("config", [DmpConfig(), DmpConfig(damping=2), DmpConfig(damping=20, basis_functions=30)])
def test_a_roll_out_is_what_an_ode_solver_gives(config: DmpConfig) -> None:
    dmp = random_dmp(1, config=config)
    made, s = dmp.rollout(101), np.linspace(0, 1, 101)
    states = solved(dmp, s)
    assert np.allclose(made.positions, states[:, :3], atol=EXACT)
    assert np.allclose(made.velocities, states[:, 3:], atol=1e-7)
    spring = config.stiffness * (config.damping * (dmp.goal - made.positions) - made.velocities)
    f = basis(phases(101, config), config) @ dmp.weights.T
    assert np.allclose(made.accelerations, spring + f, atol=1e-8)


def test_a_roll_out_starts_anywhere() -> None:
    dmp, y, v = random_dmp(2), np.array([1.0, -2, 0.3]), np.array([0.5, 3, -1])
    s = np.linspace(0, 1 + np.log(0.4) / np.log(100), 77)
    made = dmp.rollout(77, rate=0.5, phase=0.4, position=y, velocity=v)
    states = solved(dmp, s, 0.4, y, v / 0.5)
    assert np.allclose(made.time, s / 0.5)
    assert np.allclose(made.positions, states[:, :3], atol=EXACT)
    assert np.allclose(made.velocities, states[:, 3:] * 0.5, atol=1e-7)


def test_steps_of_any_size_follow_the_roll_out() -> None:
    dmp, random = random_dmp(3), np.random.default_rng(0)
    stepper = dmp.begin(rate=0.25)
    times = np.cumsum(random.uniform(0, 0.2, 20))
    for dt in np.diff(times, prepend=0):
        stepper.step(dt)
    end = dmp.rollout(2, rate=0.25, duration=times[-1])
    assert np.allclose(stepper.position, end.positions[-1], atol=EXACT)
    assert np.allclose(stepper.velocity, end.velocities[-1], atol=1e-8)
    assert stepper.phase == pytest.approx(np.exp(-np.log(100) * times[-1] / 4))


def test_goal_and_rate_changed_on_the_run_match_dense_rk4() -> None:
    dmp = random_dmp(4, dof=1)
    stepper, c = dmp.begin(rate=1.0), dmp.config
    new_goal, h = np.array([3.0]), 1e-4
    y, v, x = dmp.start[0], 0.0, 1.0
    for k in range(10000):
        rate, goal = (1.0, dmp.goal[0]) if k < 3000 else (0.5, new_goal[0])

        def slope(z: Floats, rate: float = rate, goal: float = goal) -> Floats:
            f = float(naive_basis(np.array([z[2]]), c)[0] @ dmp.weights[0])
            pull = c.stiffness * (c.damping * (goal - z[0]) - z[1] / rate) + f
            return np.array([z[1], pull * rate**2, -c.phase_decay * z[2] * rate])

        if k % 10 == 0:
            z = np.array([y, v, x])
            a = slope(z)
            b = slope(z + 5 * h * a)
            d = slope(z + 5 * h * b)
            e = slope(z + 10 * h * d)
            y, v, x = z + 10 * h / 6 * (a + 2 * b + 2 * d + e)
    stepper.step(0.3)
    stepper.goal, stepper.rate = new_goal, 0.5
    for _ in range(7):
        stepper.step(0.1)
    assert stepper.position[0] == pytest.approx(y, abs=1e-7)  # RK4 at 1 ms
    assert stepper.velocity[0] == pytest.approx(v, abs=1e-5)
    assert stepper.phase == pytest.approx(x, rel=1e-9)


def test_a_fit_gives_the_demonstration_back() -> None:
    y = reaching()
    assert np.abs(Dmp.fit(y).rollout(500).positions - y).max() < 0.01  # of a range of 1


def test_a_fit_by_positions_stands_noise_that_spoils_derivatives() -> None:
    y = reaching(200)
    noisy = y + 0.01 * np.random.default_rng(0).normal(size=y.shape)
    error = {
        by: np.sqrt(((Dmp.fit(noisy, by=by).rollout(200).positions - y) ** 2).mean()) for by in ("forcing", "positions")
    }
    assert error["positions"] < 0.005  # 22 parameters of 200 samples: .01 sqrt(.11) = .0033
    assert error["forcing"] > 5 * error["positions"]
    assert np.abs(Dmp.fit(y, by="positions").rollout(200).positions - y).max() < 1e-3


def test_the_weights_are_least_squares() -> None:
    y = reaching(120)
    dmp = Dmp.fit(y)
    phi = naive_basis(phases(120), DmpConfig())
    h = 1 / 119
    v = np.gradient(y, h, axis=0, edge_order=2)
    f = np.gradient(v, h, axis=0, edge_order=2) - 25 * (6.25 * (y[-1] - y) - v)
    assert np.allclose(forcing_terms(y, y[-1]), f, atol=1e-8)
    assert np.allclose(dmp.weights, np.linalg.lstsq(phi, f, rcond=None)[0].T, rtol=1e-6, atol=1e-6)


def test_a_four_second_demonstration_comes_back_at_rate_a_quarter() -> None:
    """ERRATA 34: y(t; tau) = y_demo(tau t), y' = tau y'_demo."""
    dmp = Dmp.fit(reaching())
    slow, normal = dmp.rollout(401, rate=0.25), dmp.rollout(401)
    assert slow.time[-1] == pytest.approx(4)
    assert np.allclose(slow.positions, normal.positions, atol=EXACT)
    assert np.allclose(slow.velocities, 0.25 * normal.velocities, atol=EXACT)
    assert np.allclose(slow.accelerations, 0.0625 * normal.accelerations, atol=1e-8)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.floats(-100, 100), st.floats(0.05, 20))
def test_every_motion_ends_at_its_goal(seed: int, goal: float, rate: float) -> None:
    dmp = random_dmp(seed, dof=1)
    moved = Dmp(dmp.start, [goal], dmp.weights)
    # x = 1e-2^8: what is left of the forcing is below 1e-9 of it
    assert moved.rollout(50, rate=rate, duration=8 / rate).positions[-1, 0] == pytest.approx(goal, abs=1e-6)


def test_the_goal_shifts_the_end_and_does_not_scale_the_shape() -> None:
    """ERRATA 36."""
    dmp = random_dmp(5)
    motions = [Dmp(dmp.start, dmp.goal + k, dmp.weights).rollout(90).positions for k in (0, 1, 3)]
    assert np.allclose(motions[2] - motions[0], 3 * (motions[1] - motions[0]), atol=1e-9)


@pytest.mark.realdata
def test_handwriting_is_reproduced(data_folder: Path) -> None:
    from scipy.io import loadmat

    files = sorted((data_folder / "lasa").glob("*.mat"))
    assert len(files) == 15
    for path in files:
        for demo in loadmat(path)["demos"][0][:2]:
            y = np.ascontiguousarray(demo["pos"][0, 0].T, float)
            away = Dmp.fit(y).rollout(len(y)).positions - y
            assert np.sqrt((away**2).sum(1).mean()) < 0.03 * np.ptp(y, axis=0).max(), path.stem


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: Dmp.fit(np.zeros((2, 1))), "samples is 2"),
        (lambda: Dmp.fit(np.array([[0.0], [np.nan], [1]])), r"positions\[1, 0\] is nan"),
        (lambda: Dmp.fit(np.array([[0.0], [1e12], [1]])), r"positions\[1, 0\] is 1e\+12"),
        (lambda: Dmp.fit(np.zeros((5, 0))), "0 dimensions"),
        (lambda: Dmp.fit(np.array([[0.0], [np.nan], [1]]), by="positions"), r"positions\[1, 0\] is nan"),
        (lambda: Dmp.fit(np.zeros((5, 1)), by="speed"), "by is 'speed', must be forcing or positions"),
        (lambda: Dmp([0.0], [1.0, 2], np.zeros((1, 20))), "goal has 2 values, must have 1"),
        (lambda: Dmp([0.0], [1.0], np.zeros((1, 19))), "columns has 19 values, must have 20"),
        (lambda: Dmp([0.0], [np.inf], np.zeros((1, 20))), "finite"),
        (lambda: random_dmp(0).rollout(1), "steps is 1"),
        (lambda: random_dmp(0).rollout(10, rate=0.0), r"rate is 0 1/s"),
        (lambda: random_dmp(0).rollout(10, rate=-1.0), r"rate is -1 1/s"),
        (lambda: random_dmp(0).rollout(10, phase=0.0), "phase is 0"),
        (lambda: random_dmp(0).rollout(10, phase=1.5), "phase is 1.5"),
        (lambda: random_dmp(0).rollout(10, phase=0.01), "duration"),
        (lambda: random_dmp(0).rollout(10, position=[1.0]), "position has 1 values, must have 3"),
        (lambda: random_dmp(0).rollout(10, velocity=[np.nan] * 3), "velocity must be finite"),
        (lambda: random_dmp(0).rollout(10, duration=np.inf), "duration is inf"),
        (lambda: random_dmp(0).begin().step(-0.1), "dt is -0.1 s"),
        (lambda: random_dmp(0).begin().step(np.nan), "dt is nan s"),
        (lambda: setattr(random_dmp(0).begin(), "rate", 0.0), "rate is 0"),
        (lambda: setattr(random_dmp(0).begin(), "goal", [0.0]), "goal has 1"),
        (lambda: basis([0.0]), "phase is 0"),
        (lambda: basis([np.nan]), "phase is nan"),
        (lambda: DmpConfig(basis_functions=1), "basis_functions is 1"),
        (lambda: DmpConfig(stiffness=0), "stiffness is 0"),
        (lambda: DmpConfig(phase_decay=1e9), "phase_decay"),
    ],
)
def test_wrong_input_is_refused_by_name(call: object, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        call()  # type: ignore[operator]
