"""Path primitives (Sec. 3.4.1): the shape an expert's path takes, one for each orientation it ends in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import resample, wrap_angle

if TYPE_CHECKING:
    from lfdcore.wheelchair.primitives.local_paths import LocalPaths

Floats = NDArray[np.float64]

NEAREST_END = 1e-6
"""[m] from the origin: a path that ends nearer has no direction"""


@dataclass(frozen=True)
class PathPrimitiveConfig:
    """bins: orientations of the path's end, each 2 pi / bins wide (17 in Sec. 3.4.1, ERRATA 22); points: of a
    primitive; loop: a path whose end lies nearer to its start than this share of its length has no scale of its own
    and is left out; mirror: learn from the left-right mirrored paths too."""

    bins: int = 17
    points: int = 50
    loop: float = 0.2
    mirror: bool = True

    def __post_init__(self) -> None:
        if self.bins < 1 or self.points < 2:
            raise ValueError(f"bins is {self.bins} and points {self.points}, must be at least 1 and 2")
        if not 0 < self.loop < 1:
            raise ValueError(f"loop is {self.loop}, must be between 0 and 1")


class PathPrimitives:
    """K primitives, one a bin that has data: ends (K, 2) [m] the average end points, shapes (K, points, 2) [m] from the
    origin to that end point, bins (K,) which bin, counts (K,) of how many paths. In base_link at the path's start."""

    def __init__(self, ends: Floats, shapes: Floats, bins: NDArray[np.int32], counts: NDArray[np.int32]) -> None:
        """ValueError for arrays that do not fit together, are not finite, or hold a shape that is no path from the
        origin to its end, away from it."""
        ends, shapes = np.asarray(ends, dtype=np.float64), np.asarray(shapes, dtype=np.float64)
        bins, counts = np.asarray(bins, dtype=np.int32), np.asarray(counts, dtype=np.int32)
        count = len(np.atleast_1d(ends))
        if not count:
            raise ValueError("there is no path primitive: no local path has an end away from its start")
        if ends.shape != (count, 2) or shapes.ndim != 3 or shapes.shape[::2] != (count, 2) or shapes.shape[1] < 2:
            raise ValueError(f"primitives have ends of shape {ends.shape} and shapes of shape {shapes.shape}")
        if bins.shape != (count,) or counts.shape != (count,):
            raise ValueError(f"{count} primitives have {bins.shape} bins and {counts.shape} counts")
        far = 1 / NEAREST_END  # [m]
        if not ((np.abs(ends) <= far).all() and (np.abs(shapes) <= far).all()):
            raise ValueError(f"primitives must be finite, within {far:g} m of the origin")
        _require_paths_to(ends, shapes)
        if not ((bins >= 0).all() and (np.diff(bins) > 0).all() and (counts > 0).all()):
            raise ValueError(f"primitives have bins {bins} and counts {counts}, must rise from 0 and be positive")
        self.ends, self.shapes, self.bins, self.counts = ends, shapes, bins, counts
        self._unit = _complex(shapes) / _complex(ends)[:, None]  # ends at 1 + 0i

    @classmethod
    def fit(cls, local_paths: LocalPaths, config: PathPrimitiveConfig | None = None) -> PathPrimitives:
        """Every path at `points` points by arc length, turned and stretched (a similarity, ERRATA F6) so that it ends
        at its bin's average end point; their average is the least-squares shape. Bins without data have no primitive.

        ValueError without any usable path.
        """
        config = config or PathPrimitiveConfig()
        goal, end_yaw, paths = local_paths.goal, local_paths.end_yaw, local_paths.paths
        usable = np.hypot(*goal.T) > config.loop * local_paths.lengths()
        curves = np.array([resample(path, config.points) for path in paths]).reshape(-1, config.points, 2)[usable]
        goal, end_yaw = goal[usable], end_yaw[usable]
        if config.mirror:
            flip = np.array([1.0, -1.0])
            curves, goal = np.concatenate([curves, curves * flip]), np.concatenate([goal, goal * flip])
            end_yaw = np.concatenate([end_yaw, -end_yaw])
        bins = orientation_bin(end_yaw, config.bins)
        found = [b for b in np.unique(bins) if np.hypot(*goal[bins == b].mean(0)) >= NEAREST_END]
        means = [goal[bins == b].mean(0) for b in found]
        shapes = [
            _points((_complex(curves[bins == b]) / _complex(goal[bins == b])[:, None]).mean(0) * complex(*mean))
            for b, mean in zip(found, means, strict=True)
        ]
        return cls(
            np.array(means).reshape(-1, 2),
            np.array(shapes).reshape(-1, config.points, 2),
            np.array(found, dtype=np.int32),
            np.array([(bins == b).sum() for b in found], dtype=np.int32),
        )

    def __len__(self) -> int:
        return len(self.ends)

    def nearest(self, goals: Floats) -> NDArray[np.intp]:
        """Which primitive suits goals (N, 2) [m]: the one with the nearest average end point -> (N,)."""
        return np.asarray(((goals[:, None] - self.ends) ** 2).sum(2).argmin(1))

    def scaled_to(self, goal: Floats) -> Floats:
        """The nearest primitive turned and stretched to end at `goal` (2,) [m] -> (points, 2).

        ValueError for a goal that is not finite or lies at the origin: no similarity reaches it.
        """
        return np.asarray(self.scaled_to_all(np.asarray(goal, dtype=np.float64).reshape(1, 2))[0])

    def scaled_to_all(self, goals: Floats) -> Floats:
        """scaled_to for goals (N, 2) [m] -> (N, points, 2)."""
        if not (np.isfinite(goals).all() and (np.hypot(*goals.T) > NEAREST_END).all()):
            raise ValueError(
                "a goal is not finite or lies at the origin (0, 0) m: no path primitive can be scaled to it"
            )
        return _points(self._unit[self.nearest(goals)] * _complex(goals)[:, None])


def _require_paths_to(ends: Floats, shapes: Floats) -> None:
    length = np.hypot(*ends.T)
    astray = np.maximum(np.hypot(*shapes[:, 0].T), np.hypot(*(shapes[:, -1] - ends).T))
    for k in range(len(ends)):
        if not length[k] >= NEAREST_END:
            raise ValueError(f"primitive {k} ends {length[k]:g} m from the origin, must be at least {NEAREST_END:g} m")
        if not astray[k] <= 1e-6 * max(1.0, length[k]):
            raise ValueError(f"primitive {k} is a shape that misses the origin or its end by {astray[k]:g} m")


def orientation_bin(yaw: Floats, bins: int = 17) -> NDArray[np.intp]:
    """Headings [rad] -> which of `bins` equal intervals of (-pi, pi] holds them; the middle one is around 0."""
    share = (np.asarray(wrap_angle(yaw)) + np.pi) / (2 * np.pi)
    return np.clip((share * bins).astype(np.intp), 0, bins - 1)


def _complex(points: Floats) -> NDArray[np.complex128]:
    return points[..., 0] + 1j * points[..., 1]


def _points(numbers: NDArray[np.complex128]) -> Floats:
    return np.stack([numbers.real, numbers.imag], -1)
