"""Belief updates over a goal (2.2-2.3): lfdcore against torch, on the same equations and samples.

The rival is batched torch in float64 on one thread: no loop over samples, Q_ab by outer sums of precomputed terms, in
place, the symmetric half of the pairs (a, b) only. N = 800 is a subset as training set, N = 9153 the full model, whose
matrices torch makes and drops in turn (some 2 GB). `far` leaves the samples in their 72 x 72 m, so that most are far
from any one state; `near` has length-scales so long that every sample counts and all of D is read. One process,
interleaved, medians of its CPU time. Run: python benchmarks/bench_action_model.py [--rounds N] [--sizes N ...]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray

from lfdcore.estimation import ActionKernel, ActionModel, IntentionFilter

Floats = NDArray[np.float64]
GOALS = np.array([[8, 8], [64, 8], [64, 40], [60, 66], [10, 62], [12, 36.0]])


def drives(count: int, runs: int = 30) -> tuple[Floats, Floats, Floats]:
    """Drives from one entrance to six goals, along corridors: (x, y, cos, sin, v, w), goals, stick."""
    random, parts, each = np.random.default_rng(0), [], -(-count // runs)
    for run in range(runs):
        goal = GOALS[run % len(GOALS)]
        way = np.vstack([[36, 4], np.array([36, goal[1]]) + random.normal(0, 0.4, 2), goal])
        along = np.r_[0, np.linalg.norm(np.diff(way, axis=0), axis=1).cumsum()]
        at = np.linspace(0, along[-1], each)
        place = np.column_stack([np.interp(at, along, column) for column in way.T])
        place += random.normal(0, 0.01, place.shape).cumsum(0)
        heading = np.convolve(np.unwrap(np.arctan2(*np.gradient(place, axis=0).T[::-1])), np.ones(15) / 15, "same")
        v, w = 0.8 + random.normal(0, 0.05, each), np.gradient(heading) * 10 + random.normal(0, 0.03, each)
        state = np.column_stack([place, np.cos(heading), np.sin(heading), v, w])
        stick = np.column_stack([v, np.clip(w, -1, 1)]) + random.normal(0, 0.1, (each, 2))
        parts.append((state, np.tile(goal, (each, 1)), stick))
    states, goals, sticks = (np.vstack(part)[:count] for part in zip(*parts, strict=True))
    return states, goals, sticks


def kernels(scale: float) -> list[ActionKernel]:
    lengths = scale * np.array([4, 4, 0.7, 0.7, 0.4, 0.4])
    return [ActionKernel(0.6, lengths, [15, 15], 0.1), ActionKernel(0.5, lengths * 1.2, [18, 14], 0.12)]


class Torch:
    """The same filter, everything that does not depend on state and belief computed once."""

    def __init__(self, states: Floats, goals: Floats, sticks: Floats, kernels: list[ActionKernel]) -> None:
        self.states, self.goals, y = (torch.from_numpy(part.copy()) for part in (states, goals, sticks))
        self.state_scales = [torch.tensor(k.state_lengthscales) for k in kernels]
        self.H = [torch.tensor(k.goal_lengthscales) ** 2 for k in kernels]
        self.variance, self.noise = [k.amplitude**2 for k in kernels], [k.noise**2 for k in kernels]
        self.inverse, self.beta = [], []
        for a in range(len(kernels)):
            joint = torch.cat([self.states / self.state_scales[a], self.goals / self.H[a].sqrt()], 1)
            K = torch.cdist(joint, joint, compute_mode="donot_use_mm_for_euclid_dist").square_().mul_(-0.5).exp_()
            K.mul_(self.variance[a]).diagonal().add_(self.noise[a])
            factor = torch.linalg.cholesky(K)
            del K
            self.inverse.append(torch.cholesky_inverse(factor))
            self.beta.append(torch.cholesky_solve(y[:, [a]], factor)[:, 0])

    def moments(self, x: torch.Tensor, mu: torch.Tensor, S: torch.Tensor) -> tuple[torch.Tensor, ...]:
        count, u = len(self.beta), self.goals - mu
        near = [torch.exp(-0.5 * ((self.states - x) / scale).square().sum(1)) for scale in self.state_scales]
        m, G, C = torch.zeros(count), torch.zeros(count, count), torch.zeros(len(mu), count)
        for a in range(count):
            wide = S + torch.diag(self.H[a])
            solved = torch.linalg.solve(wide, u.T).T
            scale = self.variance[a] * torch.sqrt(self.H[a].prod() / torch.det(wide))
            q = scale * torch.exp(-0.5 * (u * solved).sum(1)) * near[a] * self.beta[a]
            m[a], C[:, a] = q.sum(), S @ (solved.T @ q)
        for a in range(count):
            for b in range(a + 1):
                Ha, Hb = self.H[a], self.H[b]
                harmonic, total = Ha * Hb / (Ha + Hb), Ha + Hb
                R = S + torch.diag(harmonic)
                left, right = u * Hb / total, u * Ha / total
                inverse = torch.linalg.inv(R)
                own = -0.5 * (u.square() / total).sum(1)
                Q = (u / total) @ u.T  # the exponent expanded: one product of (N, 2) matrices
                Q.addmm_(left @ inverse, right.T, alpha=-1.0)
                Q += (own - 0.5 * (left @ inverse * left).sum(1))[:, None]
                Q += own - 0.5 * (right @ inverse * right).sum(1)
                Q.exp_()
                scale = self.variance[a] * self.variance[b] * torch.sqrt(harmonic.prod() / torch.det(R))
                G[a, b] = scale * torch.dot(near[a] * self.beta[a], Q @ (near[b] * self.beta[b])) - m[a] * m[b]
                if a == b:
                    trace = scale * torch.dot(near[a], Q.mul_(self.inverse[a]) @ near[a])
                    G[a, a] += self.variance[a] - trace + self.noise[a]
                G[b, a] = G[a, b]
        return m, G, C

    def update(self, x: Floats, y: Floats, mu: Floats, S: Floats) -> tuple[Floats, Floats]:
        mean, covariance = torch.from_numpy(mu), torch.from_numpy(S)
        m, G, C = self.moments(torch.from_numpy(x), mean, covariance)
        gain = torch.linalg.solve(G, C.T).T
        return (mean + gain @ (torch.from_numpy(y) - m)).numpy(), (covariance - gain @ C.T).numpy()


def seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def compare(name: str, count: int, scale: float, rounds: int) -> None:
    states, goals, sticks = drives(9153)
    chosen = np.arange(9153) if count == 9153 else np.random.default_rng(1).permutation(9153)[:count]
    samples = states[chosen], goals[chosen], sticks[chosen]
    begin = time.process_time()
    model = ActionModel(*samples, kernels(scale))
    built = time.process_time() - begin
    rival = Torch(*samples, kernels(scale))
    mean, covariance = GOALS.mean(0), np.cov(GOALS.T)
    ours = IntentionFilter(model, mean, covariance)
    took: list[tuple[float, float]] = []
    for i in np.linspace(0, 9152, rounds).astype(int):
        ours.reset()
        theirs = rival.update(states[i], sticks[i], mean, covariance)
        belief = ours.update(states[i], sticks[i])
        assert np.allclose(belief.mean, theirs[0], rtol=0, atol=1e-8)
        assert np.allclose(belief.covariance, theirs[1], rtol=0, atol=1e-8 * np.trace(covariance))
        ours.reset()
        state, stick = states[i], sticks[i]
        mine = seconds(lambda state=state, stick=stick: ours.update(state, stick))
        took.append((mine, seconds(lambda s=state, y=stick: rival.update(s, y, mean, covariance))))
    mine, torchs = np.median(took, axis=0)
    print(
        f"N = {count}, {name}: lfdcore {mine * 1e3:.3f} ms, torch {torchs * 1e3:.1f} ms, ratio {torchs / mine:.1f} "
        f"(built in {built:.1f} s, holds {model.nbytes / 1e6:.0f} MB)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--sizes", type=int, nargs="+", default=[800, 9153])
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    for count in arguments.sizes:
        for name, scale in (("far", 1.0), ("near", 5.0)):
            compare(name, count, scale, arguments.rounds if count > 2000 else 5 * arguments.rounds)


if __name__ == "__main__":
    main()
