"""Beliefs along whole drives, and whether they are as sure as they may be (Sec. 2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfdcore.estimation import ActionModel
from lfdcore.progress import Progress
from lfdcore.wheelchair.goals.model import GoalFilter, GoalModel, OtherActionModel
from lfdcore.wheelchair.goals.samples import GoalSamples

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BeliefTrack:
    """A filter's beliefs along N samples of whole drives, each begun with the prior."""

    mean: Floats
    """(N, 2) [m, map]"""
    covariance: Floats
    """(N, 2, 2) [m^2]"""
    likelihood: Floats
    """(N, L)"""
    nearest: NDArray[np.int64]
    """(N,)"""

    def where(self, mask: NDArray[np.bool_]) -> BeliefTrack:
        """The beliefs at the samples of a mask (N,)."""
        return BeliefTrack(self.mean[mask], self.covariance[mask], self.likelihood[mask], self.nearest[mask])

    def normalised_errors(self, truth: Floats) -> Floats:
        """(N,) squared Mahalanobis distances of the true destinations (N, 2) to the beliefs; 2 on average where the
        covariances are right (NEES)."""
        off = truth - self.mean
        solved = np.linalg.solve(self.covariance, off[..., None])[..., 0]
        return np.asarray((off * solved).sum(axis=1))


def track_beliefs(
    model: GoalModel,
    samples: GoalSamples,
    action_model: ActionModel | OtherActionModel,
    progress: Progress | None = None,
) -> BeliefTrack:
    """Filters drive after drive."""
    running = GoalFilter(model, action_model=action_model)
    found, drive = [], None
    for k in range(len(samples)):
        if samples.drive[k] != drive:
            running.reset()
            drive = samples.drive[k]
        found.append(running.update(samples.pose[k], samples.twist[k], samples.joystick[k]))
        if progress is not None:
            progress(k + 1, len(samples))
    return BeliefTrack(
        np.array([b.mean for b in found]),
        np.array([b.covariance for b in found]),
        np.array([b.likelihood for b in found]),
        np.array([b.nearest for b in found]),
    )
