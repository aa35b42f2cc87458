"""All cells' RBF networks at once against NumPy over the same flat arrays; fitting against NumPy's lstsq; one thread.

Run: python benchmarks/bench_rbf_network.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lfdcore.estimation import RbfNetworkBank, RbfNetworkConfig

Floats = NDArray[np.float64]
CELLS, SAMPLES = 3300, 19200


def seconds(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def interleaved(rounds: int, *works: Callable[[], object]) -> list[float]:
    """Median seconds of each, run in turn."""
    return np.median([[seconds(work) for work in works] for _ in range(rounds)], axis=0).tolist()


def numpy_fit(inputs: Floats, keys: NDArray[np.int32], sigma: float) -> tuple[list[Floats], list[Floats]]:
    """Alg. 5 with ERRATA 45, every fit by lstsq."""
    all_centres, all_weights = [], []
    for key in np.unique(keys):
        x = inputs[keys == key]
        error, taken, weights = np.ones(len(x)), [], np.zeros(0)
        while len(taken) < 20 and error.max() >= 0.01:
            error[taken] = -1
            if error.max() <= 0:
                break
            taken.append(int(error.argmax()))
            a = np.exp(-((x[:, None] - x[taken]) ** 2).sum(2) / (2 * sigma**2))
            weights = np.linalg.lstsq(a, np.ones(len(x)), rcond=None)[0]
            error = (a @ weights - 1) ** 2
        all_centres.append(x[taken])
        all_weights.append(weights)
    return all_centres, all_weights


def main() -> None:
    random = np.random.default_rng(0)
    keys = np.sort(random.integers(0, CELLS, SAMPLES)).astype(np.int32)
    angle = random.normal(0, 0.6, SAMPLES)
    inputs = np.column_stack([np.cos(angle), np.sin(angle), random.uniform(0, 1, SAMPLES)])
    config = RbfNetworkConfig()
    bank = RbfNetworkBank.fit(inputs, keys, config)
    centres, weights = numpy_fit(inputs, keys, config.sigma)
    assert np.array_equal(bank.centres, np.concatenate(centres))
    assert np.allclose(bank.weights, np.concatenate(weights), atol=1e-6)

    stick, own = np.array([0.9, 0.3]), random.uniform(0, 1, (len(bank), 1))
    network = np.repeat(np.arange(len(bank)), np.diff(bank.offsets))
    flat, w, starts = np.array(bank.centres), np.array(bank.weights), np.array(bank.offsets[:-1])

    def with_numpy() -> Floats:
        squared = ((flat[:, :2] - stick) ** 2).sum(1) + (flat[:, 2] - own[network, 0]) ** 2
        return np.clip(np.add.reduceat(w * np.exp(squared * (-0.5 / 0.3**2)), starts), 0, 1)

    assert np.allclose(bank.predict(stick, own), with_numpy(), atol=1e-12)
    ours, rival = interleaved(301, lambda: bank.predict(stick, own), with_numpy)
    print(f"{len(bank)} cells, {len(w)} basis functions, threads 1")
    print(f"predict  lfdcore {ours * 1e6:7.1f} us   numpy {rival * 1e6:7.1f} us   ratio {rival / ours:5.1f}")
    fit, slow = interleaved(
        5, lambda: RbfNetworkBank.fit(inputs, keys, config), lambda: numpy_fit(inputs, keys, config.sigma)
    )
    print(f"fit      lfdcore {fit * 1e3:7.1f} ms   numpy {slow * 1e3:7.1f} ms   ratio {slow / fit:5.1f}")


if __name__ == "__main__":
    main()
