"""How fast beliefs over destinations have to be widened (ERRATA 6), found by leaving drives out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lfdcore.progress import Progress, silent
from lfdcore.wheelchair.goals.model import GoalModel, LeftOutFigures
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import BeliefTrack, track_beliefs


def leave_drives_out(
    samples: GoalSamples,
    folds: int,
    candidates: Sequence[float],
    learn: Callable[[GoalSamples], GoalModel],
    progress: Progress | None = None,
) -> list[LeftOutFigures]:
    """Each fold leaves a drive to every destination out that has two or more; `learn` makes a model of the rest.
    A row a candidate, in order; none where no destination has two drives."""
    tell = progress or silent
    found: list[list[tuple[GoalSamples, BeliefTrack, NDArray[np.float64]]]] = [[] for _ in candidates]
    number, spare = _drive_numbers(samples)
    folds = min(folds, int(number.max()) + 1) if spare.any() else 0
    for fold in range(folds):
        left_out = spare & (number == fold)
        model, unseen = learn(samples.where(~left_out)), samples.where(left_out)
        acting, truth = model.action_model(), model.goals.positions[unseen.goal]
        for k, noise in enumerate(candidates):
            noisy = replace(model, config=replace(model.config, process_noise=noise))
            found[k].append((unseen, track_beliefs(noisy, unseen, acting), truth))
            tell(fold * len(candidates) + k + 1, folds * len(candidates))
    return [_figures(noise, runs) for noise, runs in zip(candidates, found, strict=True) if runs]


def best_calibrated(figures: Sequence[LeftOutFigures]) -> float:
    """The process noise [m^2] whose NEES is nearest to its dimension, as a ratio; the smaller of two as near."""
    best = min(figures, key=lambda one: (abs(math.log(max(one.nees, 1e-300))), one.process_noise))
    return best.process_noise


def _drive_numbers(samples: GoalSamples) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """(N,) which drive to its destination a sample is of, from 0 on; (N,) whether that destination has another."""
    number, spare = np.zeros(len(samples), np.int64), np.zeros(len(samples), bool)
    for goal in np.unique(samples.goal):
        mine = samples.goal == goal
        drives = list(dict.fromkeys(samples.drive[mine].tolist()))
        number[mine] = [drives.index(drive) for drive in samples.drive[mine].tolist()]
        spare[mine] = len(drives) > 1
    return number, spare


def _figures(noise: float, runs: list[tuple[GoalSamples, BeliefTrack, NDArray[np.float64]]]) -> LeftOutFigures:
    right = np.concatenate([track.nearest == unseen.goal for unseen, track, _ in runs])
    errors = np.concatenate([track.normalised_errors(truth) for _, track, truth in runs])
    drives = sum(len(np.unique(unseen.drive)) for unseen, _, _ in runs)
    return LeftOutFigures(noise, len(right), drives, float(right.mean()), float(errors.mean()) / 2)
