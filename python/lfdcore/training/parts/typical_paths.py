"""Which demonstrations show what their stick means, and which only that it has been held so once (not in the text).

A one-class network answers 1 wherever a demonstration lies, even one of thousands. A driver's stick is noisy, so every
added run brings a few more odd pairs: stick hard over, way straight on. With enough runs every way complies with every
stick. A pair (stick, way) is therefore learned from only if its stick is at least `ratio` times as likely for that way
as for the way that it is likeliest for; both likelihoods are Parzen estimates over the stick's direction, one for each
direction of ways. They are shares of the ways in that direction, so neither the number of runs nor how often a place
makes drivers go straight on matters. Compliance is learned from these pairs alone; the intention model weighs in how
often a cell was driven to and is asked for goals that comply, and its goals hardly change (docs/heatmaps.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.wheelchair.primitives.compliance import SIGMA
from lfdcore.wheelchair.window import require_between

if TYPE_CHECKING:
    from lfdcore.wheelchair.primitives.local_paths import LocalPaths

Floats = NDArray[np.float64]
_WAYS, _STICKS = 72, 360  # bins of a circle: 5 degrees and 1 degree
_FLIP = np.array([1.0, -1.0])


@dataclass(frozen=True)
class TypicalPathConfig:
    """ratio: of likelihoods, below it a demonstration is not learned from (0: all are); sigma: of the Gaussians on the
    stick's direction, a unit vector, as in the compliance model; rare: so many demonstrations of a way with some other
    stick are added. Otherwise a way seen once or twice is the likeliest for the stick it was seen with."""

    ratio: float = 0.05
    sigma: float = 0.1
    rare: float = 10.0

    def __post_init__(self) -> None:
        require_between("ratio", self.ratio, 0, 1)
        require_between("sigma", self.sigma, *SIGMA)
        require_between("rare", self.rare, 0, 1e6)


def typical(ways: Floats, sticks: Floats, config: TypicalPathConfig | None = None) -> NDArray[np.bool_]:
    """Which of N demonstrations are typical of their stick -> (N,); left and right count alike.

    ways (N, 2) [m]: the point in base_link that each led to, its direction counts; sticks (N, 2): forward, left,
    their direction counts. ValueError for values that are not finite.
    """
    config = config or TypicalPathConfig()
    if not (np.isfinite(ways).all() and np.isfinite(sticks).all()):
        raise ValueError("ways and sticks must be finite")
    way, stick = _bins(ways, _WAYS), _bins(sticks, _STICKS)
    counts = np.zeros((_WAYS, _STICKS))
    np.add.at(counts, (way, stick), 1.0)
    np.add.at(counts, (_bins(ways * _FLIP, _WAYS), _bins(sticks * _FLIP, _STICKS)), 1.0)
    likelihood = (counts @ _kernel(config.sigma)) / (counts.sum(axis=1) + config.rare).clip(min=1e-9)[:, None]
    return np.asarray(likelihood[way, stick] >= config.ratio * likelihood[:, stick].max(axis=0))


def typical_paths(paths: LocalPaths, look_ahead: float, config: TypicalPathConfig | None = None) -> LocalPaths:
    """The paths that are typical of their stick in where they lead within a look-ahead [m]."""
    ways = np.array([_within(path, look_ahead) for path in paths.paths]).reshape(-1, 2)
    return paths.taken(typical(ways, paths.joystick, config))


def _within(path: Floats, distance: float) -> Floats:
    """The path's first point at least `distance` [m] from the origin, or its end."""
    far = np.hypot(*path.T) >= distance
    return np.asarray(path[int(far.argmax())] if far.any() else path[-1])


def _bins(directions: Floats, count: int) -> NDArray[np.intp]:
    share = np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi) % 1.0
    return np.floor(share * count).astype(np.intp) % count


def _kernel(sigma: float) -> Floats:
    """(360, 360): of the distance between two sticks' unit vectors."""
    apart = np.arange(_STICKS)[:, None] - np.arange(_STICKS)
    chord = 2 * np.sin(np.pi * apart / _STICKS)
    return np.asarray(np.exp(-0.5 * (chord / sigma) ** 2))
