"""Algorithm 1, 800 of 9513 samples: lfdcore against plain NumPy ones, which are incremental too.

Both rivals keep a Cholesky factor of A_SS and what it leaves of every candidate; they differ in where A comes from.
`whole` forms K and A = s2 K + K K once (two N x N matrices an action). `columns` forms K and one column of A for each
selected sample. NumPy's BLAS has one thread. One process, interleaved, medians of CPU time; the same indices.
Run: python benchmarks/bench_sparse_subset.py [--samples N] [--size S] [--rounds N]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable

import numpy as np
from bench_action_model import drives, kernels
from numpy.typing import NDArray

from lfdcore.estimation import ActionKernel, select_subset

Floats = NDArray[np.float64]
CANDIDATES = 59


class Urn:
    """lfdcore's candidates: the starts of Fisher-Yates shuffles of the samples left."""

    def __init__(self, count: int, seed: int = 1) -> None:
        self.left, self.state = list(range(count)), seed

    def draw(self) -> NDArray[np.int64]:
        for i in range(min(CANDIDATES, len(self.left))):
            self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
            other = i + (self.state >> 33) % (len(self.left) - i)
            self.left[i], self.left[other] = self.left[other], self.left[i]
        return np.array(self.left[:CANDIDATES])

    def remove(self, position: int) -> None:
        self.left[position] = self.left[-1]
        self.left.pop()


def covariance(inputs: Floats, kernel: ActionKernel) -> Floats:
    scaled = inputs / np.r_[kernel.state_lengthscales, kernel.goal_lengthscales]
    squares = (scaled**2).sum(1)
    K = scaled @ scaled.T
    K -= 0.5 * squares[:, None]
    K -= 0.5 * squares
    np.exp(np.minimum(K, 0, out=K), out=K)
    K *= kernel.amplitude**2
    return K


class Basis:
    """W = L^-1 A_S, of all samples, row after row; residual and Schur complement of each."""

    def __init__(self, inputs: Floats, y: Floats, kernel: ActionKernel, size: int, whole: bool) -> None:
        self.K, self.s2 = covariance(inputs, kernel), kernel.noise**2
        self.residual = self.K @ y
        self.A = self.s2 * self.K + self.K @ self.K if whole else None
        self.start = self.s2 * kernel.amplitude**2 + np.einsum("ij,ij->i", self.K, self.K)
        self.schur, self.W, self.count = self.start.copy(), np.empty((size, len(y))), 0
        self.weight = 1 / y.var()

    def gains(self, candidates: NDArray[np.int64]) -> Floats:
        left, residual = self.schur[candidates], self.residual[candidates]
        kept = left > 1e-10 * self.start[candidates]
        return self.weight * np.where(kept, residual**2 / (2 * np.where(kept, left, 1)), 0)

    def select(self, i: int) -> None:
        if self.schur[i] <= 1e-10 * self.start[i]:
            return
        column = self.A[i] if self.A is not None else self.s2 * self.K[i] + self.K @ self.K[i]
        done = self.W[: self.count]
        w = (column - done[:, i] @ done) / np.sqrt(self.schur[i])
        self.residual = self.residual - w * (self.residual[i] / np.sqrt(self.schur[i]))
        self.schur = self.schur - w**2
        self.W[self.count] = w
        self.count += 1


def plain(samples: tuple[Floats, Floats, Floats], kernels: list[ActionKernel], size: int, whole: bool) -> list[int]:
    inputs = np.hstack(samples[:2])
    bases = [Basis(inputs, y, kernel, size, whole) for y, kernel in zip(samples[2].T, kernels, strict=True)]
    urn, selected = Urn(len(inputs)), []
    for _ in range(size):
        candidates = urn.draw()
        gains = sum(basis.gains(candidates) for basis in bases)
        position = min(range(len(candidates)), key=lambda p: (-gains[p], candidates[p]))
        selected.append(int(candidates[position]))
        urn.remove(position)
        for basis in bases:
            basis.select(selected[-1])
    return selected


def seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=9513)
    parser.add_argument("--size", type=int, default=800)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    samples, ours = drives(arguments.samples), kernels(1.0)
    results: dict[str, list[int]] = {}

    def run(name: str, work: Callable[[], list[int]]) -> Callable[[], None]:
        return lambda: results.update({name: work()})

    works = {
        "lfdcore": run("lfdcore", lambda: select_subset(*samples, ours, arguments.size).tolist()),
        "whole": run("whole", lambda: plain(samples, ours, arguments.size, whole=True)),
        "columns": run("columns", lambda: plain(samples, ours, arguments.size, whole=False)),
    }
    took = np.median([[seconds(work) for work in works.values()] for _ in range(arguments.rounds)], axis=0)
    assert results["lfdcore"] == results["whole"] == results["columns"], "other samples"
    print(f"{arguments.size} of {arguments.samples} samples, 2 actions: lfdcore {took[0]:.2f} s")
    for name, rival in zip(("whole", "columns"), took[1:], strict=True):
        print(f"  NumPy, {name:8}{rival:7.2f} s, ratio {rival / took[0]:5.1f}")


if __name__ == "__main__":
    main()
