"""How far a partner has come (Sec. 5.3.1): by time warping as printed, or where what was seen is likeliest.

Open-end time warping compares with one reference in place. It stalls where a person stops short of the reference's end,
and its t* jumps with noise. The primitive itself knows how people differ: with samples spread evenly up to a share s of
the motion, p(what was seen | s) (first block of 5.14) has its maximum nearer to the truth (docs/collaboration.md).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lfdcore.primitives import InteractionPosterior, InteractionPrimitive, PartnerPhase, PhaseEstimator

Array = NDArray[np.float64]
TEMPO_DEVIATION = 0.5
"""of the logarithm of a partner's tempo, before anything is seen: half or twice as fast is 1.4 of it"""
_COARSE, _FINE = 20, 7
"""shares that are tried: over the whole motion, then twice around the best"""
_MOST = 60
"""samples that a share is judged by"""


@dataclass(frozen=True, eq=False)
class Followed:
    """A partner's samples, those of pauses left out."""

    phase: PartnerPhase
    """after the last sample, by time warping; not determined: the partner has not left the start"""
    active: Array
    """(K,) [s] in motion until each sample, from 0"""
    samples: Array
    """(K, n)"""
    moved: float
    """[s] in motion so far"""
    warped_share: float
    """of the motion, by time warping: (t* - 1) / (n_ref - 1) (ERRATA 38)"""


def follow(reference: Array, duration: float, stamp: Array, samples: Array) -> Followed:
    """Samples (T, n) at stamps (T,) [s] along a reference (n_ref, n) of `duration` [s]; until the phase is determined,
    the last sample alone."""
    estimator = PhaseEstimator(reference, duration)
    phases = [estimator.observe(float(at), one) for at, one in zip(stamp, samples, strict=True)]
    last = phases[-1]
    moving = np.array([not one.paused for one in phases])
    moving[0] = True
    active = np.append(0.0, np.cumsum(np.diff(stamp) * moving[1:]))[moving]
    if not last.determined or last.index < 1 or not active[-1] > 0:
        return Followed(last, np.zeros(1), samples[-1:], 0.0, 0.0)
    return Followed(last, active, samples[moving], float(active[-1]), last.index / (len(reference) - 1))


def _thinned(followed: Followed) -> Followed:
    """At most _MOST of the samples, evenly chosen: of those that were wholly seen, if there are as many."""
    whole = np.flatnonzero(~np.isnan(followed.samples).any(axis=1))
    some = whole if len(whole) >= _MOST else np.arange(len(followed.active))
    kept = some[np.unique(np.linspace(0, len(some) - 1, min(len(some), _MOST)).round().astype(np.int64))]
    return replace(followed, active=followed.active[kept], samples=followed.samples[kept])


def condition_at(
    primitive: InteractionPrimitive, followed: Followed, share: float, environment: Array | None
) -> InteractionPosterior:
    """p(theta | partner, e) with the samples spread evenly over the way to `share`, as the thesis resamples them."""
    shares = share * followed.active / max(followed.moved, 1e-12)
    phases = np.exp(-float(primitive.config.dmp.phase_decay) * shares)
    return primitive.condition(followed.samples, phases, environment)


def likeliest_share(
    primitive: InteractionPrimitive, followed: Followed, duration: float, environment: Array | None
) -> float:
    """Of the motion, in (0, 1]: the maximum of p(what was seen | share) p(tempo), the demonstrations taking `duration`
    [s] on average. 0 while the partner has not left the start."""
    if not followed.warped_share > 0:
        return 0.0
    thinned = _thinned(followed)

    def score(share: float) -> float:
        tempo = share * duration / followed.moved
        seen = condition_at(primitive, thinned, share, environment).log_likelihood
        return float(seen - 0.5 * (np.log(tempo) / TEMPO_DEVIATION) ** 2)

    step = 1 / _COARSE
    best = max((np.arange(1, _COARSE + 1) * step).tolist(), key=score)
    for _ in range(2):
        fine = np.linspace(best - step, min(best + step, 1.0), _FINE)
        best = max((share for share in fine.tolist() if share > 0), key=score)
        step *= 2 / (_FINE - 1)
    return float(best)
