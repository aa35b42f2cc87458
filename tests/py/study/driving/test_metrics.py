"""Metrics against slow oracles and laws."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfdcore.geometry import Footprint
from lfdcore.simulated.trace import DriveTrace, Plan
from lfdcore.study.driving.metrics import (
    angular_jerk,
    distance,
    driving_metrics,
    entropy_baseline,
    framework_metrics,
    goal_errors,
    lasting_compliance,
    prediction_errors,
    reversals,
    steering_entropy,
    steering_signal,
    stuck_time,
    use_of_plan,
)


def make_trace(
    pose: np.ndarray, period: float = 0.1, plans: tuple[Plan, ...] = (), **changes: np.ndarray
) -> DriveTrace:
    n = len(pose)
    step = np.diff(pose, axis=0, prepend=pose[:1]) / period
    twist = np.stack([np.hypot(step[:, 0], step[:, 1]), step[:, 2]], axis=1)
    fields = {
        "stamp": np.arange(n) * period,
        "pose": pose,
        "twist": twist,
        "joystick": np.tile([1.0, 0.0], (n, 1)),
        "desired": np.tile([1.0, 0.0], (n, 1)),
        "command": twist,
        "in_contact": np.zeros(n, bool),
        "collision": np.zeros(n, bool),
        "mode": np.full(n, "path"),
        "supervised": np.zeros(n, bool),
        "compliance": np.ones(n),
        "goal": np.full((n, 2), np.nan),
        "control_point": np.full((n, 2), np.nan),
    }
    return DriveTrace("c", "d", "a", 1, "completed", Footprint(), plans=plans, **(fields | changes))


def straight_drive(n: int = 101) -> np.ndarray:
    return np.stack([np.linspace(0, (n - 1) * 0.05, n), np.zeros(n), np.zeros(n)], axis=1)


def test_angular_jerk_of_a_sine_is_its_mean_second_derivative() -> None:
    t = np.arange(0, 60, 0.1)
    omega = 0.5 * np.sin(1.0 * t)
    assert angular_jerk(omega, 0.1) == pytest.approx(0.5 * 2 / np.pi, rel=0.02)


def test_angular_jerk_smooths_odometry_noise_that_plain_differences_multiply() -> None:
    """ERRATA 24: .01 rad/s of noise at 10 Hz gives about 2 rad/s3 by plain second differences."""
    noise = np.random.default_rng(1).normal(0, 0.01, 5000)
    assert np.abs(np.diff(noise, 2)).mean() / 0.01 == pytest.approx(1.95, rel=0.1)
    assert angular_jerk(noise, 0.1) < 0.5


def test_angular_jerk_of_a_series_shorter_than_its_window_is_nan_and_a_tiny_window_is_refused() -> None:
    assert np.isnan(angular_jerk(np.zeros(3), 0.1))
    with pytest.raises(ValueError, match="at least 3 samples"):
        angular_jerk(np.zeros(100), 0.5)


def slow_entropy(u: list[float], alpha: float) -> float:
    errors = [
        u[t] - (u[t - 1] + (u[t - 1] - u[t - 2]) + 0.5 * ((u[t - 1] - u[t - 2]) - (u[t - 2] - u[t - 3])))
        for t in range(3, len(u))
    ]
    edges = [-5 * alpha, -2.5 * alpha, -alpha, -0.5 * alpha, 0.5 * alpha, alpha, 2.5 * alpha, 5 * alpha]
    counts = Counter(sum(e >= edge for edge in edges) for e in errors)
    shares = [count / len(errors) for count in counts.values()]
    return -sum(p * np.log(p) / np.log(9) for p in shares)


@given(st.lists(st.floats(-1, 1), min_size=20, max_size=60), st.floats(0.01, 1))
def test_steering_entropy_equals_the_formula_written_out(values: list[float], alpha: float) -> None:
    if alpha <= 1e-9 * max(map(abs, values)):
        return
    assert steering_entropy(np.array(values), alpha) == pytest.approx(slow_entropy(values, alpha), abs=1e-9)


def test_gaussian_errors_give_the_same_self_baselined_entropy_whatever_their_size() -> None:
    """ERRATA 48: .542 for white prediction errors; with a fixed baseline errors twice as large score .768."""
    rng = np.random.default_rng(0)
    errors = rng.normal(size=200_000)
    edges = np.array([-np.inf, -5, -2.5, -1, -0.5, 0.5, 1, 2.5, 5, np.inf]) * np.percentile(np.abs(errors), 90)

    def entropy(e: np.ndarray) -> float:
        p = np.histogram(e, edges)[0] / len(e)
        return float(-(p[p > 0] * np.log(p[p > 0])).sum() / np.log(9))

    assert entropy(errors) == pytest.approx(0.542, abs=0.005)
    assert entropy(2 * errors) == pytest.approx(0.768, abs=0.005)
    u = rng.normal(size=5000)
    assert steering_entropy(u) == pytest.approx(steering_entropy(10 * u), abs=1e-9)
    assert steering_entropy(2 * u, entropy_baseline(u)) > steering_entropy(u) + 0.15


@pytest.mark.parametrize("samples", range(4))
def test_a_run_too_short_for_a_prediction_has_no_baseline_and_gives_no_entropy(samples: int) -> None:
    baseline = entropy_baseline(np.arange(samples) ** 3.0)
    assert np.isnan(baseline)
    assert np.isnan(steering_entropy(np.arange(9) ** 3.0, baseline))


def test_a_perfectly_predictable_signal_has_entropy_zero_despite_rounding() -> None:
    assert steering_entropy(0.1 * np.arange(1000) / 3) == 0.0
    assert steering_entropy(np.zeros(100)) == 0.0
    assert np.isnan(steering_entropy(np.zeros(3)))


@pytest.mark.parametrize("baseline", [0.0, float("nan")])
def test_a_fixed_baseline_without_errors_gives_no_entropy_instead_of_a_perfect_one(baseline: float) -> None:
    assert np.isnan(steering_entropy(np.random.default_rng(0).normal(size=100), baseline))


def test_prediction_is_exact_for_straight_lines_only() -> None:
    """ERRATA 48: a parabola leaves an error of 1."""
    t = np.arange(50.0)
    assert np.abs(prediction_errors(3 * t + 1)).max() < 1e-12
    assert prediction_errors(t**2) == pytest.approx(np.ones(47))


def test_the_steering_signal_is_the_left_axis_at_its_period() -> None:
    stamp = np.arange(0, 3, 0.1)
    signal = steering_signal(stamp, np.stack([np.zeros(30), stamp], 1))
    assert signal == pytest.approx(np.arange(0, 2.9, 0.15))


def test_distance_reversals_and_speed_of_a_drive_forth_and_back() -> None:
    x = np.r_[np.linspace(0, 1, 21), np.linspace(0.95, 0, 20)]
    pose = np.stack([x, np.zeros(41), np.zeros(41)], 1)
    velocity = np.gradient(x, 0.1)
    trace = make_trace(pose, twist=np.stack([velocity, np.zeros(41)], 1))
    assert distance(pose) == pytest.approx(2.0)
    assert reversals(trace) == 1
    assert driving_metrics(trace).mean_free_speed == pytest.approx(0.5, rel=0.05)


def test_a_chair_that_stands_while_forward_is_asked_is_stuck_and_one_at_rest_is_not() -> None:
    pose = np.zeros((200, 3))
    assert stuck_time(make_trace(pose)) == 1.0
    assert stuck_time(make_trace(pose, desired=np.zeros((200, 2)))) == 0.0
    assert stuck_time(make_trace(straight_drive(200))) == 0.0


def test_a_plan_that_is_driven_is_compliant_up_to_a_look_ahead_beyond_the_chair_without_deviation() -> None:
    plan = Plan(0.0, np.stack([np.linspace(0, 4, 41), np.zeros(41)], 1))
    compliance = np.where(np.arange(101) <= 40, 1.0, 0.0)  # the last compliant tick is at x = 2
    use = use_of_plan(make_trace(straight_drive(), plans=(plan,), compliance=compliance), 0)
    assert use.compliant_length == pytest.approx(2.8)
    assert use.followed.max() < 1e-12
    assert (len(use.followed), len(use.ahead)) == (21, 8)


def test_a_plan_beside_the_way_deviates_by_its_distance_and_an_incompliant_one_has_no_compliant_part() -> None:
    plan = Plan(0.0, np.stack([np.linspace(0, 2, 21), np.full(21, 0.07)], 1))
    assert use_of_plan(make_trace(straight_drive(), plans=(plan,)), 0).followed == pytest.approx(np.full(21, 0.07))
    never = use_of_plan(make_trace(straight_drive(), plans=(plan,), compliance=np.zeros(101)), 0)
    assert (never.compliant_length, len(never.followed)) == (0.0, 0)


def test_a_plan_counts_only_until_the_next_one_or_until_there_is_no_path() -> None:
    path = np.stack([np.linspace(0, 4, 81), np.zeros(81)], 1)
    replaced = make_trace(straight_drive(), plans=(Plan(0.0, path), Plan(1.0, path)))
    assert use_of_plan(replaced, 0).compliant_length == pytest.approx(0.5 + 0.8, abs=0.06)
    dropped = make_trace(
        straight_drive(), plans=(Plan(0.0, path),), compliance=np.where(np.arange(101) < 20, 1.0, np.nan)
    )
    assert use_of_plan(dropped, 0).compliant_length == pytest.approx(1.0 + 0.8, abs=0.06)


class ByAngle:
    """A stand-in for the compliance model: the input's direction within 10 degrees complies."""

    def compliances(self, points: np.ndarray, joystick: np.ndarray) -> np.ndarray:
        bearing = np.arctan2(points[:, 1], points[:, 0]) - np.arctan2(joystick[1], joystick[0])
        return np.where(np.abs(bearing) < np.radians(10), 1.0, 0.0)


def test_a_driven_plan_complies_wholly_and_one_that_turns_away_from_the_input_up_to_its_bend() -> None:
    trace = make_trace(straight_drive())
    assert lasting_compliance(trace, Plan(0.0, np.stack([np.linspace(0, 2, 21), np.zeros(21)], 1)), ByAngle()) == 1.0
    bend = np.array([[x, 0.0] for x in np.arange(0, 1.01, 0.05)] + [[1.0, y] for y in np.arange(0.3, 1.25, 0.05)])
    assert lasting_compliance(trace, Plan(0.0, bend), ByAngle()) == pytest.approx(17 / 36, abs=0.03)


def test_goal_error_is_the_bearing_of_the_goal_at_the_last_compliant_tick() -> None:
    plan = Plan(0.0, np.array([[0.0, 0.0], [3.0, 0.0]]))
    goal = np.tile([6.0, 1.0], (101, 1))
    compliance = np.where(np.arange(101) <= 40, 1.0, 0.0)  # last compliant at x = 2
    trace = make_trace(straight_drive(), plans=(plan,), goal=goal, compliance=compliance)
    assert goal_errors(trace) == pytest.approx([np.degrees(np.arctan2(1, 4))])
    assert framework_metrics(trace, ByAngle()).obedience == pytest.approx(np.exp(-0.003 * np.degrees(np.arctan2(1, 4))))


def test_a_run_without_plans_has_no_framework_figures() -> None:
    assert np.isnan(framework_metrics(make_trace(straight_drive()), ByAngle()).path_rmse)
