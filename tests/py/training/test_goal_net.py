"""Training the network of Sec. 2.2, and Algorithm 6 (corrected) as its reference."""

import numpy as np
import pytest
import torch

from goal_worlds import drives, samples_of
from lfdcore.training.parts.goal_net import GoalNetConfig, train_goal_network
from lfdcore.wheelchair.goals.network import sigmoid

QUICK = GoalNetConfig(epochs=40)


def algorithm_6(weights: list[np.ndarray], x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    """Back-propagation as ERRATA 46 corrects it: the weights' changes of one sample (biases last).

    D_n = Y - A_n (cross-entropy and sigmoid); D_l = (W'_{l+1} D_{l+1}) o f'(Z_l); dW_l = D_l A'_{l-1}.
    """
    activations = [x]
    for w in weights:
        activations.append(sigmoid(w[:, :-1] @ activations[-1] + w[:, -1]))
    d = y - activations[-1]
    changes = []
    for layer in reversed(range(len(weights))):
        changes.insert(0, np.outer(d, np.r_[activations[layer], 1.0]))
        a = activations[layer]
        d = (weights[layer][:, :-1].T @ d) * a * (1 - a)
    return changes


def cross_entropy(weights: list[np.ndarray], x: np.ndarray, y: np.ndarray) -> float:
    hidden, output = weights
    z = output[:, :-1] @ sigmoid(hidden[:, :-1] @ x + hidden[:, -1]) + output[:, -1]
    return float((np.logaddexp(0, z) - y * z).sum())


def random_problem() -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return [rng.normal(size=(15, 7)), rng.normal(size=(6, 16))], rng.normal(size=6), np.eye(6)[2]


def test_algorithm_6_corrected_is_minus_the_slope_of_the_cross_entropy_by_finite_differences() -> None:
    weights, x, y = random_problem()
    changes, step = algorithm_6(weights, x, y), 1e-6
    for layer, at in ((0, (3, 2)), (0, (14, 6)), (1, (5, 0)), (1, (2, 15))):
        ends = []
        for sign in (1, -1):
            moved = [w.copy() for w in weights]
            moved[layer][at] += sign * step
            ends.append(cross_entropy(moved, x, y))
        assert changes[layer][at] == pytest.approx(-(ends[0] - ends[1]) / (2 * step), abs=1e-8)


def test_algorithm_6_corrected_is_what_torch_back_propagates() -> None:
    weights, x, y = random_problem()
    tensors = [torch.tensor(w, requires_grad=True) for w in weights]
    out = torch.tensor(x)
    for w in tensors:
        out = torch.sigmoid(w[:, :-1] @ out + w[:, -1])
    torch.nn.functional.binary_cross_entropy(out, torch.tensor(y), reduction="sum").backward()
    for change, tensor in zip(algorithm_6(weights, x, y), tensors, strict=True):
        np.testing.assert_allclose(change, -tensor.grad.numpy(), atol=1e-12)


def test_a_network_learns_where_drives_go() -> None:
    learned, unseen = samples_of(drives(3)), samples_of(drives(2, first_seed=100))
    said = train_goal_network(learned, 3, QUICK).predict(unseen.pose, unseen.joystick).argmax(axis=1)
    late = unseen.pose[:, 0] > 4
    assert (said == unseen.goal)[late].mean() > 0.95


def test_the_same_seed_gives_the_same_weights_and_leaves_torchs_threads_alone() -> None:
    samples, threads = samples_of(drives(1)), torch.get_num_threads()
    first, second = (train_goal_network(samples, 3, GoalNetConfig(epochs=3)) for _ in range(2))
    np.testing.assert_array_equal(first.output, second.output)
    assert torch.get_num_threads() == threads


def test_an_input_that_never_changes_does_no_harm() -> None:
    samples = samples_of(drives(1))
    samples.joystick[:, 0] = 0.5
    assert np.isfinite(train_goal_network(samples, 3, GoalNetConfig(epochs=2)).hidden).all()


def test_a_goal_without_a_drive_is_refused() -> None:
    samples = samples_of(drives(1))
    with pytest.raises(ValueError, match="no drive goes to goal 2 of 3"):
        train_goal_network(samples.where(samples.goal != 1), 3, QUICK)


@pytest.mark.parametrize("change", [{"neurons": 0}, {"epochs": 0}, {"learning_rate": 0.0}, {"weight_decay": np.nan}])
def test_a_config_that_cannot_train_is_refused(change: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        GoalNetConfig(**change)
