"""Hyper-parameters by differential evolution: our search on the C++ likelihood against SciPy's on NumPy ones, N = 500.

Two rivals: the plain likelihood, as one writes it down, and a careful one (distances kept, a triangular solve, SciPy's
in-place Cholesky). All end in L-BFGS, ours with the exact gradient, SciPy's as `polish` has it. Then predictions
against scikit-learn's. One thread each; times are of the process, interleaved, medians.
Run: python benchmarks/bench_gaussian_process.py [--rounds N]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, solve_triangular
from scipy.optimize import differential_evolution as scipy_evolution
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel

from lfdcore.estimation import GaussianProcess, GaussianProcessLikelihood, Kernel
from lfdcore.training.parts.gp_hyperparameters import HyperParameterConfig, fit_hyper_parameters, search_bounds

Floats = NDArray[np.float64]
N = 500


def seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def interleaved(rounds: int, *works: Callable[[], object]) -> list[float]:
    """Median seconds of each, run in turn."""
    return np.median([[seconds(work) for work in works] for _ in range(rounds)], axis=0).tolist()


def data() -> tuple[Floats, Floats, Floats]:
    random = np.random.default_rng(0)
    X = random.uniform(-1, 1, (N, 2))
    variances = random.uniform(0.001, 0.01, N)
    K = Kernel(0.8, [0.5, 0.9]).covariance(X, X) + np.diag(variances + 0.05**2)
    return X, np.linalg.cholesky(K) @ random.normal(size=N), variances


def plain(X: Floats, y: Floats, variances: Floats) -> Callable[[Floats], float]:
    """C.3 as one writes it down."""

    def negative(at: Floats) -> float:
        a, l1, l2, noise = np.exp(at)
        squared = (((X[:, None] - X[None]) / np.array([l1, l2])) ** 2).sum(2)
        K = a**2 * np.exp(-0.5 * squared) + np.diag(variances + noise**2)
        L = np.linalg.cholesky(K)
        z = np.linalg.solve(L, y)
        return float(0.5 * z @ z + np.log(np.diag(L)).sum() + len(y) / 2 * np.log(2 * np.pi))

    return negative


def careful(X: Floats, y: Floats, variances: Floats) -> Callable[[Floats], float]:
    """The same as fast as NumPy and SciPy go."""
    first, second = (np.subtract.outer(column, column) ** 2 for column in X.T)
    diagonal = np.diag_indices(len(y))

    def negative(at: Floats) -> float:
        a, l1, l2, noise = np.exp(at)
        K = a**2 * np.exp(first * (-0.5 / l1**2) + second * (-0.5 / l2**2))
        K[diagonal] += variances + noise**2
        L = cho_factor(K.T, lower=True, overwrite_a=True, check_finite=False)[0]
        z = solve_triangular(L, y, lower=True, check_finite=False)
        return float(0.5 * z @ z + np.log(np.diag(L)).sum() + len(y) / 2 * np.log(2 * np.pi))

    return negative


def searches(rounds: int) -> None:
    X, y, variances = data()
    config = HyperParameterConfig()
    bounds = search_bounds(X, y, config)
    likelihood = GaussianProcessLikelihood(X, y, variances)
    middle = np.log([0.8, 0.5, 0.9, 0.05])
    rivals = [plain(X, y, variances), careful(X, y, variances)]
    for rival in rivals:
        assert np.isclose(rival(middle), -likelihood.evaluate(middle), rtol=1e-10)
    one = interleaved(31, lambda: likelihood.evaluate(middle), *(lambda f=f: f(middle) for f in rivals))
    print(f"likelihood, N = {N}: lfdcore {one[0] * 1e3:.2f} ms")
    for name, took in zip(("plain", "careful"), one[1:], strict=True):
        print(f"  {name:8}{took * 1e3:8.2f} ms, ratio {took / one[0]:5.1f}")

    tolerance = {"tol": config.evolution.tolerance, "atol": config.evolution.absolute_tolerance, "seed": 0}
    ours = fit_hyper_parameters(X, y, variances, config)
    theirs = scipy_evolution(rivals[1], bounds, **tolerance)
    assert abs(ours.log_likelihood + theirs.fun) < 1e-2, "another optimum"
    found = np.log([ours.kernel.amplitude, *ours.kernel.lengthscales, ours.noise])
    assert np.allclose(found, theirs.x, atol=0.02), "another optimum"
    whole = interleaved(
        rounds,
        lambda: fit_hyper_parameters(X, y, variances, config),
        *(lambda f=f: scipy_evolution(f, bounds, **tolerance) for f in rivals),
    )
    print(f"search: lfdcore {whole[0]:.2f} s, {ours.evaluations} evaluations")
    for name, took in zip(("plain", "careful"), whole[1:], strict=True):
        print(f"  SciPy, {name:8}{took:6.2f} s, {theirs.nfev} evaluations, ratio {took / whole[0]:5.1f}")
    print(f"same optimum: log likelihood {ours.log_likelihood:.4f} and {-theirs.fun:.4f}")


def predictions() -> None:
    X, y, variances = data()
    for samples, queries in ((100, 1), (100, 1000), (N, 1), (N, 1000)):
        kernel = Kernel(0.8, [0.5, 0.9])
        ours = GaussianProcess(X[:samples], y[:samples], variances[:samples], kernel, 0.05)
        alpha = variances[:samples] + 0.05**2
        shape = ConstantKernel(0.64) * RBF([0.5, 0.9])
        theirs = GaussianProcessRegressor(shape, alpha=alpha, optimizer=None).fit(X[:samples], y[:samples])
        at = np.random.default_rng(1).uniform(-1, 1, (queries, 2))
        mean, sd = theirs.predict(at, return_std=True)
        moments = ours.predict(at)
        assert np.allclose(moments.mean, mean, atol=1e-9)
        assert np.allclose(moments.variance, sd**2, atol=1e-9)
        repeats = 200 if queries == 1 else 5

        def ask(times: int = repeats, at: Floats = at, ours: GaussianProcess = ours) -> None:
            for _ in range(times):
                _ = ours.predict_one(at[0]) if len(at) == 1 else ours.predict(at)

        def rival(at: Floats = at, theirs: GaussianProcessRegressor = theirs, times: int = repeats) -> None:
            for _ in range(times):
                theirs.predict(at, return_std=True)

        fast, slow = (took / repeats for took in interleaved(7, ask, rival))
        print(
            f"predict, {samples} samples, {queries:4d} queries: lfdcore {fast * 1e6:8.1f} us   "
            f"scikit-learn {slow * 1e6:9.1f} us   ratio {slow / fast:5.1f}"
        )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=5)
    searches(options.parse_args().rounds)
    predictions()


if __name__ == "__main__":
    main()
