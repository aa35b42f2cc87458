"""The action model in torch gives the numbers of the C++ one (issue 4: to 1e-6), also along a filtered drive."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from goal_worlds import GOALS, drives, samples_of
from lfdcore.estimation import ActionKernel, ActionModel, IntentionFilter
from lfdcore.training.estimators.torch_action_model import TorchActionModel, full_action_model
from lfdcore.wheelchair.goals.model import GoalFilter, GoalFilterConfig, GoalModel, prior_belief
from lfdcore.wheelchair.goals.network import GoalNetwork

Floats = NDArray[np.float64]
KERNELS = (
    ActionKernel(0.6, [2.0, 2.0, 0.7, 0.7, 0.5, 0.5], [5.0, 6.0], 0.1),
    ActionKernel(0.5, [1.5, 2.0, 0.6, 0.8, 0.5, 0.7], [6.0, 4.0], 0.15),
)
CUDA = pytest.param(
    "cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="torch finds no CUDA device here")
)
DEVICES = ["cpu", CUDA]


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Many threads wait for each other where others use the cores too."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def goal_model(count: int = 300) -> GoalModel:
    """Of `count` samples of drives to three goals; the network is none."""
    samples = samples_of(drives(2))
    samples = samples.where(np.isin(np.arange(len(samples)), np.linspace(0, len(samples) - 1, count).astype(int)))
    network = GoalNetwork("embedded", np.zeros(6), np.ones(6), np.zeros((1, 7)), np.zeros((3, 2)))
    config = GoalFilterConfig(process_noise=0.5)
    return GoalModel(GOALS, samples, KERNELS, np.arange(count), network, config)


def beliefs(running: GoalFilter, drive: int) -> list[tuple[Floats, Floats, Floats]]:
    samples = samples_of([drives(1, first_seed=500)[drive]])
    found = []
    for pose, twist, stick in zip(samples.pose, samples.twist, samples.joystick, strict=True):
        belief = running.update(pose, twist, stick)
        found.append((belief.mean, belief.covariance, belief.likelihood))
    return found


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("share_goals", [True, False])
@pytest.mark.parametrize("shaken", [0.0, 0.3])
def test_moments_in_torch_are_those_of_cpp_at_and_far_from_the_samples(
    device: str, share_goals: bool, shaken: float
) -> None:
    """Shaken, no two samples have the same goal."""
    random = np.random.default_rng(1)
    states, goals, sticks = goal_model().action_samples()
    samples = (states, goals + shaken * random.normal(size=goals.shape), sticks)
    assert len(states) == 300
    ours, theirs = (
        ActionModel(*samples, list(KERNELS)),
        TorchActionModel(*samples, KERNELS, device, share_goals=share_goals),
    )
    assert ours.shared_goals == (0 if shaken else 3)
    for spread in (0.0, 0.1, 3.0):
        root = random.normal(0, spread, (2, 2))
        state, mean = samples[0][random.integers(300)] + random.normal(0, 0.3, 6), random.uniform(-3, 9, 2)
        one, other = ours.moments(state, mean, root @ root.T), theirs.moments(state, mean, root @ root.T)
        for name in ("mean", "covariance", "cross_covariance"):
            expected, found = getattr(one, name), getattr(other, name)
            assert found.shape == expected.shape
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max(), err_msg=name)


@pytest.mark.parametrize("device", DEVICES)
def test_beliefs_along_a_drive_are_those_of_cpp_and_reset_begins_anew(device: str) -> None:
    model = goal_model()
    ours, theirs = GoalFilter(model, "full"), GoalFilter(model, action_model=full_action_model(model, device))
    for drive in (0, 2):
        ours.reset()
        theirs.reset()
        along = list(zip(beliefs(ours, drive), beliefs(theirs, drive), strict=True))
        assert len(along) > 50
        for one, other in along:
            for expected, found in zip(one, other, strict=True):
                np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
        assert np.argmax(along[-1][1][2]) == drive


def test_a_device_that_is_not_there_is_named_in_one_line() -> None:
    missing = "nonsense" if torch.cuda.is_available() else "cuda"
    with pytest.raises(ValueError, match=f"device '{missing}' is not there.*torch") as refused:
        full_action_model(goal_model(20), missing)
    assert "\n" not in str(refused.value)


def test_samples_that_do_not_fit_or_leave_the_covariance_singular_are_refused() -> None:
    states, goals, sticks = goal_model(20).action_samples()
    with pytest.raises(ValueError, match="same N > 0"):
        TorchActionModel(states, goals[:-1], sticks, KERNELS, "cpu")
    with pytest.raises(ValueError, match="same N > 0"):
        TorchActionModel(states[:0], goals[:0], sticks[:0], KERNELS, "cpu")
    with pytest.raises(ValueError, match="must be finite"):
        TorchActionModel(states * np.nan, goals, sticks, KERNELS, "cpu")
    with pytest.raises(ValueError, match="as many kernels, not 1"):
        TorchActionModel(states, goals, sticks, KERNELS[:1], "cpu")
    with pytest.raises(ValueError, match="length-scales must fit"):
        TorchActionModel(states[:, :5], goals, sticks, KERNELS, "cpu")
    silent = [ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 0.0) for k in KERNELS]
    twice = [np.repeat(part, 2, axis=0) for part in (states, goals, sticks)]
    with pytest.raises(ValueError, match="not positive definite"):
        TorchActionModel(*twice, silent, "cpu")


def test_an_update_that_is_refused_leaves_the_belief() -> None:
    model = goal_model(50)
    mean, covariance = prior_belief(GOALS.positions)
    running = full_action_model(model, "cpu").intention_filter(mean, covariance)
    state = model.action_samples()[0][0]
    before = running.update(state, [0.5, 0.1])
    for at, action, said in (
        (state, [0.5], "one value for every kernel"),
        (state, [np.nan, 0.1], "action must be finite"),
        (state[:3], [0.5, 0.1], "finite numbers"),
        (state * np.inf, [0.5, 0.1], "finite numbers"),
    ):
        with pytest.raises(ValueError, match=said):
            running.update(at, action)
    np.testing.assert_array_equal(running.belief.mean, before.mean)
    np.testing.assert_array_equal(running.belief.covariance, before.covariance)
    with pytest.raises(ValueError, match="process_noise is -1"):
        full_action_model(model, "cpu").intention_filter(mean, covariance, -1.0)


@pytest.mark.parametrize("width", [1e-3, 30.0])
@pytest.mark.parametrize("singular", [False, True])
def test_process_noise_widens_a_belief_as_in_cpp(width: float, singular: bool) -> None:
    model, mean = goal_model(50), GOALS.positions.mean(axis=0)
    prior = np.outer([2.0, 1.0], [2.0, 1.0]) + (0 if singular else 1) * np.eye(2)
    ours = IntentionFilter(model.action_model("full"), mean, prior, process_noise=width)
    theirs = full_action_model(model, "cpu").intention_filter(mean, prior, width)
    for state, _, stick in zip(*model.action_samples(), strict=True):
        one, other = ours.update(state, stick), theirs.update(state, stick)
        np.testing.assert_allclose(other.mean, one.mean, rtol=1e-6)
        np.testing.assert_allclose(other.covariance, one.covariance, rtol=1e-6, atol=1e-6 * np.trace(one.covariance))


def test_a_belief_that_collapses_in_one_update_keeps_a_covariance() -> None:
    """Sticks that tell the goal exactly: rounding leaves no variance below 0."""
    goals = np.stack(np.meshgrid(*[np.linspace(-6, 6, 7)] * 2), -1).reshape(-1, 2)
    kernel = ActionKernel(1.0, [1.0], [8.0, 8.0], 1e-4)
    model = TorchActionModel(np.zeros((49, 1)), goals, 0.1 * goals, [kernel] * 2, "cpu")
    belief = model.intention_filter([0, 0], 4 * np.eye(2)).update([0.0], [0.1, 0.2])
    np.testing.assert_allclose(belief.mean, [1, 2], atol=1e-2)
    assert np.linalg.eigvalsh(belief.covariance)[0] >= 0
    assert np.trace(belief.covariance) < 1e-2
