"""Posterior of an interaction primitive: 6 + 3 degrees of freedom, 30 basis functions, 100 observed samples.

The rivals are NumPy in the same S x S form (ERRATA 40): plain, as one writes it down first, and careful, with all that
does not depend on the observation computed before and no zeros multiplied. All end with mean and factor of theta. One
thread each; times are of the process, interleaved, medians.
Run: python benchmarks/bench_interaction_primitive.py [--rounds N]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lfdcore.primitives import DmpConfig, InteractionPrimitive, InteractionPrimitiveConfig, phases

Floats = NDArray[np.float64]
PARTNER, ROBOT, STEPS, OBSERVED = 6, 3, 500, 100
DMP = DmpConfig(basis_functions=30)


def demonstrations(count: int) -> tuple[list[Floats], list[Floats], Floats]:
    random = np.random.default_rng(0)
    time = np.linspace(0, 1, STEPS)[:, None]
    rise = time**3 * (10 - 15 * time + 6 * time**2)
    N = PARTNER + ROBOT
    motions = []
    heights = random.uniform(0.5, 1, (count, 2))
    for height in heights:
        bump = np.sin(np.pi * rise * random.uniform(0.9, 1.1, N)) * height[np.arange(N) % 2]
        motions.append(random.uniform(0.8, 1.2, N) * rise + bump + 1e-4 * random.normal(size=(STEPS, N)))
    return [y[:, :PARTNER] for y in motions], [y[:, PARTNER:] for y in motions], heights


class NumpyPrimitive:
    """What one would write in NumPy, with all that does not depend on the observation computed before."""

    def __init__(self, model: InteractionPrimitive) -> None:
        self.model, M = model, DMP.basis_functions
        S = len(model.parameters)
        self.mean = model.parameters.mean(0)
        self.loadings = (model.parameters - self.mean).T / np.sqrt(S)
        rows = PARTNER * (M + 1)
        self.partner_mean = self.mean[:rows].reshape(PARTNER, M + 1).T
        self.blocks = self.loadings[:rows].reshape(PARTNER, M + 1, S).transpose(1, 0, 2).reshape(M + 1, -1).copy()
        self.centres = np.exp(-DMP.phase_decay * np.arange(M) / (M - 1))
        widths = 1 / np.diff(self.centres) ** 2
        self.widths = np.append(widths, widths[-1])
        environment = model.environment
        assert environment is not None
        self.average, self.scale = environment.mean(0), environment.std(0)
        self.reactions = ((environment - self.average) / self.scale).T / np.sqrt(S)

    def condition(self, partner: Floats, phase: Floats, environment: Floats) -> tuple[Floats, Floats]:
        step = -np.log(phase[1]) / DMP.phase_decay
        velocity = np.gradient(partner, step, axis=0, edge_order=2)
        acceleration = np.gradient(velocity, step, axis=0, edge_order=2)
        F = acceleration + DMP.stiffness * (DMP.damping * partner + velocity)
        psi = np.exp(-self.widths * (phase[:, None] - self.centres) ** 2)
        phi = np.empty((len(phase), DMP.basis_functions + 1))
        phi[:, :-1] = psi * (phase / psi.sum(1))[:, None]
        phi[:, -1] = DMP.stiffness * DMP.damping
        S, noise = self.loadings.shape[1], self.model.config.noise
        rows = (phi @ self.blocks).reshape(-1, S)
        surprise = (F - phi @ self.partner_mean).ravel()
        sigma_e = self.model.config.environment_noise
        precision = np.eye(S) + rows.T @ rows / noise + self.reactions.T @ self.reactions / sigma_e
        seen = rows.T @ surprise / noise + self.reactions.T @ ((environment - self.average) / self.scale) / sigma_e
        inverse = np.linalg.inv(np.linalg.cholesky(precision))
        return self.mean + self.loadings @ (inverse.T @ (inverse @ seen)), self.loadings @ inverse.T


def plain(model: InteractionPrimitive, partner: Floats, phase: Floats, environment: Floats) -> tuple[Floats, Floats]:
    """The same form as one writes it down first: 5.13's Omega with its zeros, nothing computed before."""
    M, S = DMP.basis_functions, len(model.parameters)
    mean = model.parameters.mean(0)
    loadings = (model.parameters - mean).T / np.sqrt(S)
    times = -np.log(phase) / DMP.phase_decay
    velocity = np.gradient(partner, times, axis=0, edge_order=2)
    acceleration = np.gradient(velocity, times, axis=0, edge_order=2)
    F = (acceleration + DMP.stiffness * (DMP.damping * partner + velocity)).T.ravel()
    centres = np.exp(-DMP.phase_decay * np.arange(M) / (M - 1))
    widths = 1 / np.diff(centres) ** 2
    psi = np.exp(-np.append(widths, widths[-1]) * (phase[:, None] - centres) ** 2)
    phi = np.c_[psi * phase[:, None] / psi.sum(1, keepdims=True), np.full(len(phase), DMP.stiffness * DMP.damping)]
    omega = np.kron(np.eye(PARTNER, PARTNER + ROBOT), phi)
    e = model.environment
    assert e is not None
    scaled = (e - e.mean(0)) / e.std(0)
    rows = np.vstack([omega @ loadings, scaled.T / np.sqrt(S)])
    noise = np.r_[np.full(len(omega), model.config.noise), np.full(e.shape[1], model.config.environment_noise)]
    surprise = np.r_[F - omega @ mean, (environment - e.mean(0)) / e.std(0)]
    C = np.linalg.inv(np.eye(S) + rows.T @ (rows / noise[:, None]))
    return mean + loadings @ (C @ (rows.T @ (surprise / noise))), loadings @ np.linalg.cholesky(C)


def seconds(work: Callable[[], object], times: int = 200) -> float:
    begin = time.process_time()
    for _ in range(times):
        work()
    return (time.process_time() - begin) / times


def compare(count: int, rounds: int) -> None:
    partner, robot, environment = demonstrations(count + 1)
    config = InteractionPrimitiveConfig(dmp=DMP, observe="forcing")
    model = InteractionPrimitive.fit(partner[:-1], robot[:-1], environment[:-1], config)
    rival = NumpyPrimitive(model)
    seen, phase, e = partner[-1][:OBSERVED].copy(), phases(STEPS, DMP)[:OBSERVED].copy(), environment[-1].copy()

    def ours() -> tuple[Floats, Floats]:
        posterior = model.condition(seen, phase, e)
        return posterior.mean, posterior.factor

    rivals = {"careful": lambda: rival.condition(seen, phase, e), "plain": lambda: plain(model, seen, phase, e)}
    took = np.median([[seconds(work) for work in (ours, *rivals.values())] for _ in range(rounds)], axis=0)
    mean, factor = ours()
    print(f"S = {count:3d}, D = {len(mean)}: lfdcore {took[0] * 1e6:6.1f} us")
    for (name, work), slow in zip(rivals.items(), took[1:], strict=True):
        its_mean, its_factor = work()
        covariance, its_covariance = factor @ factor.T, its_factor @ its_factor.T
        off = np.abs(mean - its_mean).max() / np.abs(its_mean).max()
        spread_off = np.abs(covariance - its_covariance).max() / np.abs(its_covariance).max()
        assert off < 1e-8 and spread_off < 1e-8, "another posterior"
        print(
            f"  NumPy, {name:8}{slow * 1e6:8.1f} us   ratio {slow / took[0]:5.1f}   difference: mean {off:.1e}, "
            f"covariance {spread_off:.1e} of the largest"
        )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=11)
    rounds = options.parse_args().rounds
    for count in (15, 40):
        compare(count, rounds)


if __name__ == "__main__":
    main()
