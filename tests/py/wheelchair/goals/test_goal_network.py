"""Samples of drives to destinations, and the network of Sec. 2.2."""

import dataclasses

import numpy as np
import pytest

from goal_worlds import GOALS, drive_to, drives, samples_of
from lfdcore.wheelchair.goals.network import GoalNetwork, sigmoid, smoothed_over_time
from lfdcore.wheelchair.goals.samples import drive_samples, goal_samples, goal_state

RNG = np.random.default_rng(1)


def network(heading: str = "embedded", goals: int = 3, neurons: int = 4) -> GoalNetwork:
    width = 5 if heading == "raw" else 6
    return GoalNetwork(
        heading,
        RNG.normal(size=width),
        RNG.uniform(0.5, 2, width),
        RNG.normal(size=(neurons, width + 1)),
        RNG.normal(size=(goals, neurons + 1)),
    )


def test_a_likelihood_is_the_weighted_sums_passed_through_c_1_one_sample_at_a_time() -> None:
    net, pose, stick = network(), np.array([1.0, -2.0, 0.7]), np.array([0.3, -0.4])
    inputs = np.array([1.0, -2.0, np.cos(0.7), np.sin(0.7), 0.3, -0.4])
    hidden = [1 / (1 + np.exp(-(w[:-1] @ ((inputs - net.centre) / net.scale) + w[-1]))) for w in net.hidden]
    expected = [1 / (1 + np.exp(-(w[:-1] @ np.array(hidden) + w[-1]))) for w in net.output]
    np.testing.assert_allclose(net.predict(pose[None], stick[None])[0], expected, rtol=1e-12)


def test_a_full_turn_changes_nothing_unless_the_heading_is_raw() -> None:
    pose, stick = RNG.normal(size=(5, 3)), RNG.uniform(-1, 1, (5, 2))
    turned = pose + np.array([0, 0, 2 * np.pi])
    net = network()
    np.testing.assert_allclose(net.predict(turned, stick), net.predict(pose, stick), atol=1e-12)
    raw = network("raw")
    assert np.abs(raw.predict(turned, stick) - raw.predict(pose, stick)).max() > 1e-3


def test_sigmoid_does_not_overflow() -> None:
    np.testing.assert_array_equal(sigmoid(np.array([-1e4, 0.0, 1e4])), [0.0, 0.5, 1.0])


def test_smoothing_over_time_is_a_first_order_low_pass() -> None:
    steps = np.r_[np.zeros((1, 1)), np.ones((30, 1))]
    filtered = smoothed_over_time(steps, 0.1, 1.0)[:, 0]
    np.testing.assert_allclose(filtered[1:], 1 - np.exp(-0.1 * np.arange(1, 31)), rtol=1e-12)
    np.testing.assert_array_equal(smoothed_over_time(steps, 0.1, 0.0), steps)


@pytest.mark.parametrize(("period", "constant"), [(0.0, 1.0), (0.1, -1.0), (np.nan, 1.0), (0.1, np.inf)])
def test_smoothing_refuses_what_is_no_time(period: float, constant: float) -> None:
    with pytest.raises(ValueError, match="time_constant"):
        smoothed_over_time(np.zeros((2, 2)), period, constant)


def test_a_network_refuses_weights_that_do_not_fit_and_inputs_that_are_not_finite() -> None:
    net = network()
    with pytest.raises(ValueError, match=r"hidden must be finite and \(4, 7\)"):
        dataclasses.replace(net, hidden=np.zeros((4, 6)))
    with pytest.raises(ValueError, match="scale must be positive"):
        dataclasses.replace(net, scale=np.zeros(6))
    with pytest.raises(ValueError, match="poses and joysticks must be finite"):
        net.predict([[0, np.nan, 0]], [[0, 0]])
    with pytest.raises(ValueError, match=r"poses must be \(N, 3\)"):
        net.predict([[0, 0]], [[0, 0]])


def test_the_state_holds_the_heading_as_cosine_and_sine_or_raw() -> None:
    pose, twist = np.array([[1.0, 2.0, np.pi / 2]]), np.array([[0.3, -0.1]])
    np.testing.assert_allclose(goal_state(pose, twist, "embedded"), [[1, 2, 0, 1, 0.3, -0.1]], atol=1e-15)
    np.testing.assert_allclose(goal_state(pose, twist, "raw"), [[1, 2, np.pi / 2, 0.3, -0.1]])


def test_samples_are_the_drives_moments_in_the_map_with_their_destination() -> None:
    log = dataclasses.replace(drive_to(2, 5), map_odom=np.array([[10.0, 0.0, np.pi / 2]]))
    samples = drive_samples(log, goal=2, drive=7)
    assert len(samples) == len(log.odometry_stamp)
    np.testing.assert_allclose(samples.pose[:, 0], 10 - log.pose[:, 1], atol=1e-12)
    np.testing.assert_allclose(samples.pose[:, 1], log.pose[:, 0], atol=1e-12)
    np.testing.assert_array_equal(samples.joystick, log.joystick)
    np.testing.assert_array_equal(samples.twist, log.twist)
    assert set(samples.goal) == {2}
    assert set(samples.drive) == {7}


def test_samples_before_the_first_stick_are_left_out() -> None:
    log = drive_to(0, 3)
    later = dataclasses.replace(log, joystick_stamp=log.joystick_stamp[5:], joystick=log.joystick[5:])
    samples = drive_samples(later)
    np.testing.assert_allclose(samples.stamp, log.odometry_stamp[5:] - log.odometry_stamp[5], atol=1e-12)


def test_all_drives_joined_know_which_drive_they_are_of() -> None:
    logs = drives(2)
    samples = samples_of(logs)
    assert len(samples) == sum(len(log.odometry_stamp) for log in logs)
    assert [int(samples.goal[samples.drive == k][0]) for k in range(6)] == [0, 1, 2, 0, 1, 2]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"metadata": {}}, "does not say its destination"),
        ({"metadata": {"destination": "moon"}}, "goal is 'moon', must be one of left, ahead, right"),
        ({"joystick_stamp": np.zeros(0), "joystick": np.zeros((0, 2))}, "has no joystick"),
        ({"map_stamp": np.zeros(0), "map_odom": np.zeros((0, 3))}, "no pose in a map"),
    ],
)
def test_a_drive_that_cannot_teach_says_why(change: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        goal_samples([dataclasses.replace(drive_to(0, 1), **change)], GOALS)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"joystick": lambda stick: stick * 100}, r"joystick is up to .*, must lie in \[-1, 1\]"),
        ({"stamp": lambda stamp: stamp * np.nan}, "stamp must be finite"),
        ({"stamp": lambda stamp: stamp[:, None]}, r"stamp must be finite and \(\d+,\), is \(\d+, 1\)"),
        ({"pose": lambda pose: pose * np.inf}, "pose must be finite"),
    ],
)
def test_samples_in_other_units_or_that_are_not_finite_are_refused(change: dict, said: str) -> None:
    samples = samples_of(drives(1))
    with pytest.raises(ValueError, match=said), np.errstate(invalid="ignore"):
        dataclasses.replace(samples, **{name: made(getattr(samples, name)) for name, made in change.items()})


def test_no_drive_teaches_nothing() -> None:
    with pytest.raises(ValueError, match="no drive"):
        goal_samples([], GOALS)
