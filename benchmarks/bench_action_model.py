"""Belief updates over a goal (2.2-2.3): lfdcore against torch, on the same equations and samples.

The rival is lfdcore.training.estimators.torch_action_model on one thread: batched float64, no loop over samples, the
equations as printed, which sum over pairs of samples. Beside it stands the same with the sums over pairs of goals that
lfdcore has, for those who found them. N = 800 is a subset as training set, N = 9153 the full model, whose matrices
torch makes and drops in turn (some 5 GB). `far` leaves the samples in their 72 x 72 m, so that most are far from any
one state; `near` has length-scales so long that every sample counts and all of D is read. One process, interleaved,
medians of its CPU time. Run: python benchmarks/bench_action_model.py [--rounds N] [--sizes N ...]
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
from lfdcore.training.estimators.torch_action_model import TorchActionModel, TorchIntentionFilter

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
    mean, covariance = GOALS.mean(0), np.cov(GOALS.T)
    ours = IntentionFilter(model, mean, covariance)
    rivals = []
    for share in (False, True):
        plain = TorchActionModel(*samples, kernels(scale), device="cpu", share_goals=share)
        rivals.append(TorchIntentionFilter(plain, mean, covariance))
    took: list[list[float]] = []
    for i in np.linspace(0, 9152, rounds).astype(int):
        state, stick = states[i], sticks[i]
        took.append([])
        beliefs = []
        for one in (ours, *rivals):
            beliefs.append(one.update(state, stick))
            one.reset()
            took[-1].append(seconds(lambda one=one, state=state, stick=stick: one.update(state, stick)))
            one.reset()
        for theirs in beliefs[1:]:
            assert np.allclose(beliefs[0].mean, theirs.mean, rtol=0, atol=1e-8)
            assert np.allclose(beliefs[0].covariance, theirs.covariance, rtol=0, atol=1e-8 * np.trace(covariance))
    mine, torchs, shared = np.median(took, axis=0)
    print(
        f"N = {count}, {name}: lfdcore {mine * 1e3:.3f} ms, torch {torchs * 1e3:.1f} ms, ratio {torchs / mine:.1f}; "
        f"torch over pairs of goals {shared * 1e3:.1f} ms, ratio {shared / mine:.1f} "
        f"(built in {built:.1f} s, holds {model.nbytes / 1e6:.0f} MB)"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--sizes", type=int, nargs="+", default=[800, 9153])
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.set_flush_denormal(True)  # as lfdcore does: similarities far away are subnormal
    for count in arguments.sizes:
        for name, scale in (("far", 1.0), ("near", 5.0)):
            compare(name, count, scale, arguments.rounds if count > 2000 else 5 * arguments.rounds)


if __name__ == "__main__":
    main()
