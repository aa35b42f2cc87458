"""User compliance (Sec. 3.4.3): does the stick still agree with where the tracked path leads?

As the intention model: one one-class RBF network (App. C.1) for every potential control point, asked with the stick
alone. What is ours:

- A control point is a direction (bins of 5 degrees) at a share of the look-ahead, not a 0.05 m cell: the shorter
  look-ahead of narrow places is learned from the same demonstrations, and few of them fill the bins. In between,
  answers are interpolated linearly, so that compliance has no steps.
- The stick enters by its direction only, as a unit vector: a rough stick (five orientations, always pushed fully)
  tells no more. Each network then lives on a circle, which some 20 Gaussians cover.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.estimation import RbfNetworkBank, RbfNetworkConfig
from lfdcore.wheelchair.planner import LOOK_AHEAD
from lfdcore.wheelchair.stick import DEAD_ZONE, checked_joystick
from lfdcore.wheelchair.window import CELLS, cell_centres, require_between

if TYPE_CHECKING:
    from lfdcore.wheelchair.primitives.local_paths import LocalPaths

Floats = NDArray[np.float64]
_DIRECTIONS = 72  # bins of 5 degrees
SIGMA = (1e-3, 1e3)
"""Bounds of every Gaussian's width: beyond, it answers 0 or 1 whatever it is asked"""
MOST_CENTRES = 1_000_000
"""of one network (as RbfNetworkConfig)"""


@dataclass(frozen=True)
class ComplianceConfig:
    """sigma: of the Gaussians on the stick's direction, a unit vector (.1 is about 6 degrees; .3, as in the intention
    model, accepts nearly everything from a stick with five orientations); look_ahead [m] of pure pursuit (.8 in Sec.
    3.4.3); shares: at which shares of it control points are learned, rising; threshold, max_centres: see
    RbfNetworkConfig; dead_zone: a stick nearer to its centre wants nothing; mirror: learn from the left-right mirrored
    paths too."""

    sigma: float = 0.1
    look_ahead: float = LOOK_AHEAD
    shares: tuple[float, ...] = (0.25, 0.5, 0.75, 1.0)
    threshold: float = 0.01
    max_centres: int = 40
    dead_zone: float = DEAD_ZONE
    mirror: bool = True

    def __post_init__(self) -> None:
        require_between("sigma", self.sigma, *SIGMA)
        require_between("look_ahead", self.look_ahead, 0.01, 100, " m")
        require_between("threshold", self.threshold, 0, 1)
        require_between("max_centres", self.max_centres, 1, MOST_CENTRES)
        require_between("dead_zone", self.dead_zone, 0, 1)
        rising = list(self.shares) == sorted(set(self.shares))
        if not self.shares or not rising or not all(0 < share <= 1 for share in self.shares):
            raise ValueError(
                f"shares is {self.shares}, must be rising shares of the look-ahead in (0, 1], at least one"
            )

    @classmethod
    def thesis(cls) -> ComplianceConfig:
        """As printed: the intention model's sigma, the one look-ahead, 20 basis functions, no mirroring."""
        return cls(sigma=0.3, shares=(1.0,), max_centres=20, mirror=False)


class ComplianceModel:
    """Networks over the stick's direction (2); bank.keys are share index * 72 + direction bin."""

    def __init__(self, bank: RbfNetworkBank, config: ComplianceConfig) -> None:
        keys, most = np.asarray(bank.keys), len(config.shares) * _DIRECTIONS
        if bank.dimensions != 2 or len(keys) == 0 or keys[0] < 0 or keys[-1] >= most:
            raise ValueError(f"a compliance model needs networks of 2 inputs with keys 0..{most - 1}")
        self.bank, self.config = bank, config

    @classmethod
    def fit(cls, local_paths: LocalPaths, config: ComplianceConfig | None = None) -> ComplianceModel:
        """Learns from the control points along the demonstrated paths. ValueError without a path as long as a share of
        the look-ahead, or without any stick outside its dead zone."""
        config = config or ComplianceConfig()
        parts = [local_paths, local_paths.mirrored()] if config.mirror else [local_paths]
        shares = np.array(config.shares)
        points = np.array([control_points(path, shares * config.look_ahead) for p in parts for path in p.paths])
        sticks = np.concatenate([p.joystick for p in parts])
        pushed = np.hypot(*sticks.T) >= max(config.dead_zone, 1e-9)
        path, share = np.nonzero(np.isfinite(points.reshape(-1, len(shares), 2)).all(2) & pushed[:, None])
        if len(path) == 0:
            raise ValueError(
                f"none of {len(local_paths)} local paths reaches {shares[0] * config.look_ahead:g} m "
                "with the stick pushed: there is nothing to learn compliance from"
            )
        keys = share * _DIRECTIONS + np.floor(_direction(points[path, share])).astype(np.intp) % _DIRECTIONS
        network = RbfNetworkConfig(sigma=config.sigma, threshold=config.threshold, max_centres=config.max_centres)
        return cls(RbfNetworkBank.fit(_unit(sticks[path]), keys, network), config)

    @property
    def look_ahead(self) -> float:
        """[m] that it is defined for"""
        return self.config.look_ahead

    def compliance(self, control_point: Floats, joystick: Floats) -> float:
        """How likely a control point (2,) [m] in base_link is what a stick (2,) (forward, left) wants, in [0, 1].

        A path is kept while this is at least .9 (Sec. 3.4.3). A stick within the dead zone complies with nothing: 0.
        Points beyond the look-ahead count as at it, points nearer than its first share as at that. ValueError for
        values that are not finite, a stick outside [-1, 1] or a control point at the origin.
        """
        point = np.asarray(control_point, dtype=np.float64).reshape(1, 2)
        if not np.hypot(*point[0]) > 1e-9:
            raise ValueError(f"control_point is {point[0]} m, must be finite and away from the origin")
        return float(self.compliances(point, joystick)[0])

    def compliances(self, control_points: Floats, joystick: Floats) -> Floats:
        """compliance for control points (N, 2) [m] and one stick (2,) -> (N,)."""
        stick = checked_joystick(joystick)
        if not np.isfinite(control_points).all():
            raise ValueError("control points must be finite")
        if np.hypot(*stick) < max(self.config.dead_zone, 1e-9):
            return np.zeros(len(control_points))
        table = np.zeros((len(self.config.shares), _DIRECTIONS))
        table.flat[self.bank.keys] = self.bank.predict(_unit(stick), np.zeros((len(self.bank), 0)))
        return self._interpolated(table, control_points)

    def _interpolated(self, table: Floats, points: Floats) -> Floats:
        at = _direction(points) - 0.5  # in bins, between their middles
        low = np.floor(at).astype(np.intp)
        across = at - low
        shares = np.array(self.config.shares)
        share = np.clip(np.hypot(*points.T) / self.config.look_ahead, shares[0], shares[-1])
        outer = np.clip(np.searchsorted(shares, share), min(1, len(shares) - 1), len(shares) - 1)
        inner = np.maximum(outer - 1, 0)
        along = (share - shares[inner]) / np.maximum(shares[outer] - shares[inner], 1e-12)
        left, right = low % _DIRECTIONS, (low + 1) % _DIRECTIONS
        near = (1 - across) * table[inner, left] + across * table[inner, right]
        far = (1 - across) * table[outer, left] + across * table[outer, right]
        return np.asarray((1 - along) * near + along * far)

    def map(self, joystick: Floats) -> NDArray[np.float32]:
        """(100, 100) over the local window: compliance of every cell's centre within the look-ahead, 0 elsewhere
        (Fig. 3.11)."""
        centres = cell_centres().reshape(-1, 2)
        values = self.compliances(centres, joystick)
        values[np.hypot(*centres.T) > self.config.look_ahead] = 0.0
        return values.reshape(CELLS, CELLS).astype(np.float32)


def control_points(path: Floats, distances: Floats) -> Floats:
    """Where a path (M, 2) [m] from the origin first lies at each of `distances` (D,) [m] from it -> (D, 2).

    What pure pursuit steers to (App. E.1); NaN where the path never gets as far.
    """
    reach = np.maximum.accumulate(np.hypot(*path.T))
    after = np.searchsorted(reach, distances)
    reached = (after < len(path)) & (after > 0)
    after = np.where(reached, after, min(1, len(path) - 1))
    start, step = path[after - 1], path[after] - path[after - 1]
    # |start + share step| = distance
    a, b = (step**2).sum(1), (start * step).sum(1)
    c = (start**2).sum(1) - distances**2
    share = (np.sqrt(np.maximum(b**2 - a * c, 0.0)) - b) / np.maximum(a, 1e-18)
    points = start + np.clip(share, 0.0, 1.0)[:, None] * step
    return np.where(reached[:, None], points, np.nan)


def _direction(points: Floats) -> Floats:
    """Directions of points (N, 2) in bins of 5 degrees from straight back, in [0, 72]."""
    return (np.arctan2(points[:, 1], points[:, 0]) + np.pi) / (2 * np.pi) * _DIRECTIONS


def _unit(sticks: Floats) -> Floats:
    return np.asarray(sticks / np.linalg.norm(sticks, axis=-1, keepdims=True))
