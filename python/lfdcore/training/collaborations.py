"""lfdcore learn collaboration: a model, and its observations' noise by leaving demonstrations out (ERRATA 41, F13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording, environments
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel, evenly
from lfdcore.humanoid.pose_columns import PoseColumns
from lfdcore.progress import Progress, silent


@dataclass(frozen=True, kw_only=True)
class NoiseChoice:
    """factors: of the fit's residual variance (F13: too small is ruinous, 100 times too large harmless); folds: at most
    so many sets of demonstrations are left out in turn; shares: of a left-out partner's motion that is seen."""

    factors: tuple[float, ...] = (1.0, 10.0, 100.0, 1e3, 1e4)
    folds: int = 5
    shares: tuple[float, ...] = (0.1, 0.3, 0.5, 0.7)

    def __post_init__(self) -> None:
        if not self.factors or not all(0 < factor < np.inf for factor in self.factors):
            raise ValueError(f"factors are {self.factors}, must be one or more, > 0 and finite")
        if self.folds < 2:
            raise ValueError(f"folds is {self.folds}, must be at least 2")
        if not self.shares or not all(0 <= share <= 1 for share in self.shares):
            raise ValueError(f"shares are {self.shares}, must be one or more in [0, 1]")


def learn_collaboration(
    demonstrations: Sequence[InteractionRecording],
    config: CollaborationConfig | None = None,
    choice: NoiseChoice | None = None,
    progress: Progress | None = None,
) -> CollaborationModel:
    """With the noise that predicts the robot's motion of demonstrations left out best; what `config` sets stays, and
    so does the fit's residual where fewer than 4 demonstrations are given, or where without each fold the environment
    would no longer vary. ValueError as CollaborationModel.fit."""
    config, choice = config or CollaborationConfig(), choice or NoiseChoice()
    model = CollaborationModel.fit(demonstrations, config)
    if config.noise is not None or len(demonstrations) < 4:
        return model
    residual = float(model.primitive.config.noise or 0.0)
    candidates = [replace(config, noise=factor * residual) for factor in choice.factors]
    errors = left_out_errors(demonstrations, candidates, choice, progress)
    if np.isnan(errors).any():
        return model
    best = candidates[int(np.argmin(errors))]
    chosen = CollaborationModel.fit(demonstrations, best)
    rows = [[candidate.noise, error] for candidate, error in zip(candidates, errors.tolist(), strict=True)]
    return replace(chosen, metadata={**chosen.metadata, "noise_choice": rows})


def noise_factor(model: CollaborationModel) -> float:
    """Of the noise that was chosen over the fit's residual, the first that was tried; 1 where there was no choice."""
    tried = model.metadata.get("noise_choice")
    return float(model.primitive.config.noise or 0.0) / float(tried[0][0]) if tried else 1.0


def left_out_errors(
    demonstrations: Sequence[InteractionRecording],
    candidates: Sequence[CollaborationConfig],
    choice: NoiseChoice,
    progress: Progress | None = None,
) -> NDArray[np.float64]:
    """(candidates,) RMS error of the robot's columns (PoseColumns.difference), each over its standard deviation in the
    demonstration left out, over folds and shares. A fold leaves every folds-th demonstration out; one without
    which the environment no longer varies is passed over, NaN if all are."""
    tell = progress or silent
    folds = min(choice.folds, len(demonstrations) // 2)
    squares = np.full((len(candidates), folds), np.nan)
    for fold in range(folds):
        kept = [one for k, one in enumerate(demonstrations) if k % folds != fold]
        left_out = [_LeftOut.of(one, choice.shares, candidates[0]) for one in demonstrations[fold::folds]]
        for k, config in enumerate(candidates):
            if config.environment and not _varies(kept):
                continue
            model = CollaborationModel.fit(kept, config)
            errors = [one.square_error(model, partial) for one in left_out for partial in one.partials]
            squares[k, fold] = np.mean(errors)
            tell(fold * len(candidates) + k + 1, folds * len(candidates))
    seen = np.isfinite(squares)
    folds_seen = np.where(seen.any(axis=1), seen.sum(axis=1), np.nan)
    return np.asarray(np.sqrt(np.where(seen, squares, 0).sum(axis=1) / folds_seen))


def _varies(demonstrations: Sequence[InteractionRecording]) -> bool:
    """In every value of the environment."""
    _, values = environments(demonstrations)
    return bool((np.ptp(values, axis=0) > 0).all())


@dataclass(frozen=True, eq=False)
class _LeftOut:
    """A demonstration, prepared for being predicted again and again."""

    partials: tuple[InteractionRecording, ...]
    environment: dict[str, float]
    motion: NDArray[np.float64]
    """(steps, r) the robot's recorded columns"""
    spread: NDArray[np.float64]
    """(r',) their standard deviation over time"""

    @staticmethod
    def of(one: InteractionRecording, shares: Sequence[float], config: CollaborationConfig) -> _LeftOut:
        motion, columns = evenly(one, config).robot, PoseColumns.of(one.robot_names, [one.robot])
        apart = columns.difference(motion, np.broadcast_to(columns.mean(motion), motion.shape))
        spread = np.maximum(np.sqrt(np.mean(apart**2, axis=0)), 1e-9)
        return _LeftOut(tuple(one.partial(share=share) for share in shares), one.environment, motion, spread)

    def square_error(self, model: CollaborationModel, partial: InteractionRecording) -> float:
        said = model.infer(partial, self.environment)
        return float(np.mean((model.robot.difference(said.robot_motion(), self.motion) / self.spread) ** 2))
