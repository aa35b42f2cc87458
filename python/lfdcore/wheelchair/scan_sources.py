"""Where scans come from: a LIDAR, a recorded drive in real time, or several of these merged into one scan of the chair.

A source that has nothing new says so by the age of its stamp, never by an exception: a Watch judges it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, Pose2, wrap_angle
from lfdcore.grid import LaserScan, read_beams
from lfdcore.hardware import ScipLidar
from lfdcore.wheelchair.observation import usual_period

Stamped = tuple[LaserScan, float]
"""A scan, and when it was taken by the clock of time.monotonic() [s]"""
Array = NDArray[np.float64]

MOVED = 0.5
"""[m] that a chair may move between the scans of two scanners that are merged"""
BEAMS = 720
"""of a merged scan, half a degree apart"""
NEAR, APART = 6.0, 0.05
"""Up to so far [m] along each of its beams, it is asked at places so far apart [m] whether a scanner sees them ..."""
FAR = 25
"""... and at so many beyond, ever farther apart."""


class ScanSource(Protocol):
    """A scanner, or what stands for one."""

    @property
    def name(self) -> str:
        """As messages name it."""

    @property
    def T_base_laser(self) -> Pose2:
        """Its mounting, in base_link."""

    @property
    def scan_period(self) -> float:
        """[s] between scans"""

    def newest(self) -> Stamped | None:
        """The last scan, at once, with the stamp at which it was taken; None before the first."""

    def fault(self) -> str:
        """What is wrong and what to do; empty while all is well."""

    def close(self) -> None:
        """Ends it. The last scan stays."""


class ScipSource:
    """A LIDAR that speaks SCIP 2.0 at an address (see ScipLidar), mounted at `T_base_laser` in base_link."""

    def __init__(self, address: str, T_base_laser: Pose2, *, upside_down: bool = False) -> None:
        self._lidar = ScipLidar(address, upside_down=upside_down)
        self.name = f"scip:{address}"
        self.T_base_laser = T_base_laser
        self.scan_period = self._lidar.scan_period()

    def newest(self) -> Stamped | None:
        """See ScanSource."""
        newest = self._lidar.newest()
        return None if newest is None else (newest.scan, newest.stamp)

    def fault(self) -> str:
        """See ScanSource."""
        return self._lidar.fault()

    def close(self) -> None:
        """See ScanSource."""
        self._lidar.close()


class ReplaySource:
    """The scans of a recorded drive as fast as they were taken; the first one is taken now. After the last, none."""

    def __init__(self, path: Path) -> None:
        from lfdcore.datasets.formats import open_log

        self._log = open_log(path)
        if not len(self._log.scan_stamp):
            raise ValueError(f"{path}: the drive has no scans, at least one is needed")
        self._since_first = self._log.scan_stamp - self._log.scan_stamp[0]
        self._begin = time.monotonic()
        self.name = str(path)
        self.T_base_laser = self._log.mounting
        self.scan_period = usual_period(self._log.scan_stamp)

    def newest(self) -> Stamped | None:
        """See ScanSource."""
        index = int(np.searchsorted(self._since_first, time.monotonic() - self._begin, side="right")) - 1
        return self._log.scan(index), self._begin + float(self._since_first[index])

    def fault(self) -> str:
        """See ScanSource."""
        ended = time.monotonic() - self._begin > self._since_first[-1] + self.scan_period
        return f"{self.name}: the drive has ended" if ended else ""

    def close(self) -> None:
        """See ScanSource."""


class Merged:
    """Several scanners as one that stands at base_link and looks all around: 720 beams, half a degree apart.

    - A beam that meets what any scanner hit ends there, at the nearest of such hits: no scanner erases what another
      sees. It does so too where no scanner saw all of the way to it.
    - A beam is +inf, free up to range_max, only where all of its way outside the chair's outline was seen free.
    - All others are NaN: where no scanner looks, and what stands behind something. For a Watch they count as not
      measured, so it calls the chair blind where no scanner looks ahead.
    - range_min is 0: what is nearer to base_link is as real, and what lies inside the outline is judged by others.
      range_max is how far the farthest-seeing scanner surely sees from base_link.

    The stamp is that of the oldest of the scans, and there is none until every source has given one: a scanner that
    stops makes the whole scan stale. With `odometry` (T_odom_base at a stamp of time.monotonic(), or None where it
    does not know), scans of later stamps are moved to where the chair was at that stamp. Where it does not know, or
    says that the chair moved by more than MOVED meanwhile, the last merged scan stays, and grows old.

    ValueError without sources, for two that are mounted beyond 10 m, and for one whose range_max is below its distance
    from base_link.
    """

    def __init__(
        self,
        sources: Sequence[ScanSource],
        footprint: Footprint,
        odometry: Callable[[float], Pose2 | None] | None = None,
    ) -> None:
        if not sources:
            raise ValueError("there are no scanners to merge, at least one is needed")
        for source in sources:
            if not all(abs(value) <= 10 for value in source.T_base_laser):
                raise ValueError(f"T_base_laser of {source.name} is {source.T_base_laser}, must be within 10 m")
        self._sources, self._footprint, self._odometry = tuple(sources), footprint, odometry
        self._last: tuple[tuple[float, ...], Stamped] | None = None
        self._range_max: float | None = None
        self.name = " + ".join(source.name for source in sources)
        self.T_base_laser = Pose2()
        self.scan_period = max(source.scan_period for source in sources)

    def newest(self) -> Stamped | None:
        """See ScanSource."""
        scans = [scan for source in self._sources if (scan := source.newest()) is not None]
        if len(scans) < len(self._sources):
            return None
        stamps = tuple(stamp for _, stamp in scans)
        if self._last is None or self._last[0] != stamps:
            merged = self._merge(scans, min(stamps))
            self._last = self._last if merged is None else (stamps, merged)
        return None if self._last is None else self._last[1]

    def fault(self) -> str:
        """See ScanSource."""
        return "; ".join(fault for source in self._sources if (fault := source.fault()))

    def close(self) -> None:
        """See ScanSource."""
        for source in self._sources:
            source.close()

    def _merge(self, scans: Sequence[Stamped], stamp: float) -> Stamped | None:
        placed = []
        for source, (scan, taken) in zip(self._sources, scans, strict=True):
            moved = self._moved(stamp, taken)
            if moved is None:
                return None
            placed.append((scan, moved * source.T_base_laser))
        if self._range_max is None:
            self._range_max = self._surely_seen([scan for scan, _ in scans])
        return merge_scans(placed, self._footprint, self._range_max), stamp

    def _surely_seen(self, scans: Sequence[LaserScan]) -> float:
        """How far the farthest-seeing scanner sees from base_link [m], wherever the chair moved between two scans."""
        reach = max(
            scan.range_max - math.hypot(source.T_base_laser.x, source.T_base_laser.y)
            for source, scan in zip(self._sources, scans, strict=True)
        )
        return reach if self._odometry is None else reach - MOVED

    def _moved(self, stamp: float, taken: float) -> Pose2 | None:
        """Where the chair was at `taken`, in base_link as it stood at `stamp`; None where nobody knows."""
        if self._odometry is None or taken == stamp:
            return Pose2()
        then, now = self._odometry(stamp), self._odometry(taken)
        if then is None or now is None:
            return None
        moved = then.inverse() * now
        return moved if math.hypot(moved.x, moved.y) <= MOVED else None  # nor NaN


def merge_scans(placed: Sequence[tuple[LaserScan, Pose2]], footprint: Footprint, range_max: float) -> LaserScan:
    """Scans with the poses of their scanners in base_link as one scan from base_link up to range_max [m] (see
    Merged)."""
    views = [_View(scan, pose) for scan, pose in placed]
    if range_max <= APART:
        raise ValueError(f"no scanner reaches beyond its own distance from base_link: {range_max} m are left")
    rays = _rays(range_max)
    # What lies under the chair, no scanner need see.
    seen = (rays.x <= footprint.front) & (rays.x >= -footprint.rear) & (np.abs(rays.y) <= footprint.half_width)
    surface = np.full(BEAMS, np.inf)
    for view in views:
        sees, ends = view.look(rays)
        seen = seen | sees
        surface = np.minimum(surface, ends)
    ranges = np.where(seen.all(axis=1), np.inf, np.where(np.isfinite(surface), surface, np.nan))
    for view in views:
        nearest = view.nearest_hits(rays)
        ranges = np.where(nearest < range_max, np.fmin(ranges, nearest), ranges)
    return LaserScan(ranges.astype(np.float32).tolist(), float(rays.angles[0]), rays.step, 0.0, range_max)


class _Rays:
    """The merged scan's beams, with the places along them (BEAMS, R) [m] that are looked at."""

    def __init__(self, range_max: float) -> None:
        self.range_max = range_max
        self.step = 2 * math.pi / BEAMS
        self.angles = -math.pi + self.step * np.arange(BEAMS)
        near = np.arange(APART, min(NEAR, range_max), APART)
        self.radii = np.concatenate([near, np.geomspace(near[-1], range_max, FAR + 1)[1:]])
        self.x = np.outer(np.cos(self.angles), self.radii)
        self.y = np.outer(np.sin(self.angles), self.radii)

    def nearest_to(self, angle: Array) -> NDArray[np.intp]:
        return np.rint((angle + math.pi) / self.step).astype(np.intp) % BEAMS


_rays = lru_cache(maxsize=4)(_Rays)


@dataclass(frozen=True)
class _Sight:
    """How a scanner stands to the places along the rays: each (BEAMS, R)."""

    distance: Array
    """[m]"""
    beam: NDArray[np.intp]
    """The nearest of its beams"""
    looks: NDArray[np.bool_]
    """Whether it looks there at all"""


@lru_cache(maxsize=8)
def _sight(range_max: float, pose: tuple[float, ...], beams: int, angle_min: float, increment: float) -> _Sight:
    rays, (x, y, yaw) = _rays(range_max), pose
    to_x, to_y = rays.x - x, rays.y - y
    middle = (beams - 1) / 2
    off = wrap_angle(np.arctan2(to_y, to_x) - yaw - angle_min - increment * middle) / increment
    beam = np.rint(off + middle).astype(np.intp)
    return _Sight(np.hypot(to_x, to_y), np.clip(beam, 0, beams - 1), (beam >= 0) & (beam < beams))


class _View:
    """What one scan shows from where its scanner stands. Each beam stands for half the way to its neighbours."""

    def __init__(self, scan: LaserScan, pose: Pose2) -> None:
        self._scan, self._pose = scan, pose
        self._lengths, self._hit = read_beams(scan)
        self._angles = scan.angles()
        if not len(self._lengths):  # a broken scanner: as one beam that measured nothing
            self._lengths, self._hit, self._angles = np.zeros(1), np.zeros(1, np.bool_), np.zeros(1)

    def look(self, rays: _Rays) -> tuple[NDArray[np.bool_], Array]:
        """-> (BEAMS, R) whether it sees each place, and (BEAMS,) how far it is [m] to the surface that a ray goes
        into: between two beams that hit it, there is no hit, but no way through either."""
        layout = (len(self._lengths), self._scan.angle_min, self._scan.angle_increment)
        sight = _sight(rays.range_max, tuple(self._pose), *layout)
        behind = sight.distance - self._lengths[sight.beam]
        seen = sight.looks & (behind <= 1e-9)
        hit = sight.looks[:, 1:] & self._hit[sight.beam[:, 1:]]
        entered = seen[:, :-1] & ~seen[:, 1:] & hit & (behind[:, 1:] < np.diff(rays.radii))
        ends = np.where(entered, rays.radii[1:] - behind[:, 1:], np.inf)
        return seen, ends.min(axis=1)

    def nearest_hits(self, rays: _Rays) -> Array:
        """(BEAMS,) [m] from base_link to the nearest hit nearest to each ray; inf without one"""
        nearest = np.full(BEAMS, np.inf)
        angles, lengths = self._angles[self._hit], self._lengths[self._hit]
        points = self._pose.transform(lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1))
        ray = rays.nearest_to(np.arctan2(points[:, 1], points[:, 0]))
        np.minimum.at(nearest, ray, np.hypot(points[:, 0], points[:, 1]))
        return nearest
