"""Q-learning on a grid in plain NumPy, over states and moves as printed, and the exact optimum's path."""

import numpy as np
from numpy.typing import NDArray

from dpp_oracle import optimal_values, successors
from lfdcore.planning import GridMdp, QLearningConfig

Array = NDArray[np.float64]


def q_learning(mdp: GridMdp, config: QLearningConfig) -> Array:
    """Q (H, W, 9) after the synchronous sweeps of D.1; -inf where a move is not available."""
    to, available = successors(mdp.blocked)
    reward = mdp.reward.astype(float).ravel()
    q = np.full((reward.size, 9), config.initial_value)
    for _ in range(config.sweeps):
        best = np.where(available, q, -np.inf).max(1)
        target = reward[to] + config.discount * np.where(available, best[to], 0.0)
        q += config.learning_rate * (target - q)
    return np.where(available, q, -np.inf).reshape(*mdp.reward.shape, 9)


def optimal_path(mdp: GridMdp, discount: float, start: tuple[int, int]) -> list[tuple[int, int]]:
    """The cells [ix, iy] of the greedy path over V*, until it stays."""
    to, available = successors(mdp.blocked)
    values = optimal_values(mdp.reward, mdp.blocked, discount).ravel()
    scores = np.where(available, (mdp.reward.ravel() + discount * values)[to], -np.inf)
    width = mdp.reward.shape[1]
    state, path = start[1] * width + start[0], [start]
    while (following := int(to[state, scores[state].argmax()])) != state and len(path) <= values.size:
        state = following
        path.append((state % width, state // width))
    return path
