"""How long will the partner take? The likeliest duration under an interaction primitive, instead of DTW (5.5).

DTW against the mean motion takes a small motion for an early one, and cannot tell the way back from the way there. Here
every duration D of a grid says where in the motion each sample was seen, t / D, and the demonstrations' Gaussian says
how likely the samples are there. The tempo is constant: who pauses is followed by DTW.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationModel
from lfdcore.primitives import Dmp

Array = NDArray[np.float64]
_FACTORS = np.exp(np.linspace(np.log(0.5), np.log(2.0), 31))
"""of the demonstrations' mean duration"""
_SAMPLES = 24
"""of what was seen, evenly spread: more say little that is new"""
_LEAST_MODE = 1e-4
"""of sigma^2: modes of the demonstrations whose variance is nowhere larger are left out"""


class PartnerTempo:
    """Tells durations from what was seen of a partner."""

    def __init__(self, model: CollaborationModel, spread: float = 0.3) -> None:
        """spread: standard deviation of the logarithm of durations that is expected. ValueError for one that is not > 0
        and finite, and for a model that observes the forcing function, whose noise is no position's."""
        if not 0 < spread < np.inf:
            raise ValueError(f"spread is {spread}, must be > 0 and finite")
        if model.config.observe != "positions":
            raise ValueError(f"the model observes {model.config.observe}, must observe positions")
        self._model, self._spread = model, spread
        self._noise = float(model.primitive.config.noise or 0.0)
        motions = _partner_motions(model)
        self._mean, self._modes = motions.mean(axis=0), _modes(motions, _LEAST_MODE * self._noise)

    def duration(self, partial: InteractionRecording) -> float:
        """[s] of the whole motion, likeliest after these samples in the model's columns (NaN = not seen): between half
        and twice the demonstrations' mean, at least what has passed. Of nothing seen: the mean. ValueError for other
        columns."""
        if partial.partner_names != self._model.partner_names:
            wanted = ", ".join(self._model.partner_names)
            raise ValueError(f"columns are {', '.join(partial.partner_names)}, must be {wanted}")
        few = np.unique(np.linspace(0, len(partial) - 1, min(_SAMPLES, len(partial))).round().astype(int))
        at, seen = partial.stamp[few] - partial.stamp[0], partial.partner[few]
        durations = self._model.duration * _FACTORS
        durations = durations[durations >= at[-1] * (1 - 1e-9)]
        if not len(durations):
            return float(at[-1])
        prior = -0.5 * (np.log(durations / self._model.duration) / self._spread) ** 2
        said = [self._log_evidence(np.minimum(at / one, 1.0), seen) for one in durations]
        return float(durations[int(np.argmax(prior + said))])

    def _log_evidence(self, shares: Array, seen: Array) -> float:
        """ln N(seen; mean, L L' + sigma^2 I) at shares (K,) of the motion, without constants (ERRATA 40)."""
        apart = (seen - _between(self._mean[None], shares)[0]).ravel()
        modes = _between(self._modes, shares).reshape(len(self._modes), apart.size).T
        known = np.isfinite(apart)
        apart, factor = apart[known], modes[known]
        root = np.linalg.cholesky(np.eye(factor.shape[1]) + factor.T @ factor / self._noise)
        explained = np.linalg.solve(root, factor.T @ apart / self._noise)
        return float(-0.5 * (apart @ apart / self._noise - explained @ explained) - np.log(np.diag(root)).sum())


def _partner_motions(model: CollaborationModel) -> Array:
    """(S, steps, n) of the fitted demonstrations."""
    primitive, n = model.primitive, len(model.partner_names)
    config = primitive.config.dmp
    made = []
    for theta, start in zip(primitive.parameters, primitive.starts, strict=True):
        rows = theta.reshape(len(start), -1)[:n]
        made.append(Dmp(start[:n], rows[:, -1], rows[:, :-1], config).rollout(model.config.steps).positions)
    return np.array(made)


def _modes(motions: Array, least: float) -> Array:
    """(S, steps, n) -> (modes, steps, n), the sum of whose squares is the covariance over time and columns."""
    apart = (motions - motions.mean(axis=0)).reshape(len(motions), -1) / np.sqrt(len(motions))
    _, sizes, directions = np.linalg.svd(apart, full_matrices=False)
    modes = sizes[:, None] * directions
    kept = (modes**2).max(axis=1) > least
    return np.asarray(modes[kept].reshape(-1, *motions.shape[1:]))


def _between(motions: Array, shares: Array) -> Array:
    """(S, steps, n) at shares (K,) by straight lines -> (S, K, n)."""
    at = shares * (motions.shape[1] - 1)
    before = np.minimum(at.astype(int), motions.shape[1] - 2)
    rest = (at - before)[:, None]
    return np.asarray(motions[:, before] * (1 - rest) + motions[:, before + 1] * rest)
