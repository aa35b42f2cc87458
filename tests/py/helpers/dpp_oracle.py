"""Dynamic policy programming and value iteration in plain NumPy, as printed, to compare with."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
MOVES = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)]


def successors(blocked: NDArray[np.bool_]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Flat successor (H*W, 9) of every state and move, and whether the move is available."""
    height, width = blocked.shape
    to = np.zeros((height * width, 9), int)
    available = np.zeros((height * width, 9), bool)
    for y in range(height):
        for x in range(width):
            for a, (dy, dx) in enumerate(MOVES):
                v, u = y + dy, x + dx
                if not (0 <= v < height and 0 <= u < width):
                    v, u = y, x
                to[y * width + x, a] = v * width + u
                between_two = blocked[y, u] and blocked[v, x]
                available[y * width + x, a] = not (blocked[y, x] or blocked[v, u] or between_two)
    return to, available


def boltzmann(psi: Array, available: NDArray[np.bool_], eta: float) -> Array:
    """D.8, max-subtracted, over the moves that are available (H*W,); 0 where there is none."""
    with np.errstate(invalid="ignore", over="ignore"):
        masked = np.where(available, psi, -np.inf)
        weights = np.where(available, np.exp(eta * (masked - masked.max(1, keepdims=True))), 0.0)
        total = weights.sum(1)
        mean = (weights * np.where(available, psi, 0.0)).sum(1) / np.where(total > 0, total, 1)
    return np.where(total > 0, mean, 0.0)


def dpp(
    reward: NDArray[np.float32],
    blocked: NDArray[np.bool_],
    discount: float,
    eta: float,
    sweeps: int,
    initial: Array | None = None,
) -> tuple[Array, Array]:
    """Psi (H, W, 9), -inf where not available, and M_eta Psi (H, W) after the sweeps of D.7."""
    height, width = blocked.shape
    to, available = successors(blocked)
    r = reward.astype(float).ravel()
    psi = np.zeros((height * width, 9)) if initial is None else initial.reshape(-1, 9).copy()
    for _ in range(sweeps):
        mean = boltzmann(psi, available, eta)
        psi += r[to] + discount * mean[to] - mean[:, None]
    mean = boltzmann(psi, available, eta)
    return np.where(available, psi, -np.inf).reshape(height, width, 9), mean.reshape(height, width)


def optimal_values(reward: NDArray[np.float32], blocked: NDArray[np.bool_], discount: float) -> Array:
    """V* (H, W) by value iteration to convergence."""
    to, available = successors(blocked)
    r = reward.astype(float).ravel()
    values = np.zeros(blocked.size)
    for _ in range(int(40 / (1 - discount))):
        best = np.where(available, r[to] + discount * values[to], -np.inf).max(1)
        values = np.where(np.isfinite(best), best, 0.0)
    return values.reshape(blocked.shape)
