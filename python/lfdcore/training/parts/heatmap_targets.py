"""Training pairs of the sensor heatmap (Sec. 4.3, Fig. 4.7): what a scan sees as free, and where drivers went there.

Input: the local window's cells that one scan sees free. Target: the demonstrated paths through these cells, drawn at
.5, the ends of their visible portions at 1, smoothed, divided by the maximum (F12: "squash").

What the thesis leaves open, and what is done here:
- *Which paths*: `paths="place"` takes those of every log of the same place, at whatever time (Fig. 4.7b: "all
  demonstration paths"). A place is a name in the log's metadata (`place`), and `T_place_odom` ("x y yaw") says where
  its odometry began; a log that names no place shares with no other. `paths="own"` takes the way driven after the scan
  alone: the naive CNN's target (Fig. 4.15b), and the only honest one where odometry drifts.
- *Which direction*: a driver's path leads away. Of each visible portion the beginning that comes towards the robot does
  not count; what only comes towards it, driven the other way, leaves nothing.
- *Visible*: cells that the scan sees free, gaps of one cell between beams closed. A portion ends where it leaves them
  (or the window, or the log); that end is dilated. Where it begins is not.
- *Sizes*: paths .15 m wide, ends .35 m, Gaussian sigma of .1 m.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, arc_length
from lfdcore.grid import local_grid
from lfdcore.progress import Progress
from lfdcore.wheelchair.window import CELLS, RESOLUTION, WINDOW, free_mask, squashed

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Heatmap = NDArray[np.float32]

STEP = RESOLUTION / 2
"""[m] between the points of a path: no cell is skipped by more than a corner"""
_LONGEST = 1e5  # [m] of way in one log; beyond, the odometry is no vehicle's, and the path's points fill the memory
_FARTHEST = 1e6  # [m] of an odometry's beginning in its place
_GAP = 3.0  # [s] without odometry: nobody knows the way
_ARM = 0.5  # [m] that a turn of 1 rad is worth when scans are thinned out


@dataclass(frozen=True)
class HeatmapTargetConfig:
    """What a target shows; lengths in metres. See the module."""

    paths: Literal["place", "own"] = "place"
    spacing: float = 0.5
    """of way (a turn of 1 rad counts .5) between scans that are taken; 0: all scans"""
    path_value: float = 0.5
    end_value: float = 1.0
    path_radius: float = 0.05
    """cells whose centre lies so near to that of a cell on the path are drawn"""
    end_radius: float = 0.15
    sigma: float = 0.1
    shortest: float = 0.3
    """visible portions that do not lead away by so much do not count"""

    def __post_init__(self) -> None:
        if self.paths not in ("place", "own"):
            raise ValueError(f"paths is {self.paths!r}, must be 'place' or 'own'")
        for name in ("spacing", "path_radius", "end_radius", "sigma", "shortest"):
            value = getattr(self, name)
            if not 0 <= value <= WINDOW:
                raise ValueError(f"{name} is {value} m, must lie in [0, {WINDOW} m]")
        if not 0 < self.path_value <= self.end_value <= 1:
            raise ValueError(
                f"path_value {self.path_value} and end_value {self.end_value} must satisfy 0 < path <= end <= 1"
            )


@dataclass(frozen=True)
class HeatmapPairs:
    """N training pairs, indexed [iy, ix] in base_link.

    free (N, 100, 100): seen free; target (N, 100, 100) float16 in [0, 1], maximum 1; joystick (N, 2): forward, left as
    given at the scan (0 where none was recorded); log, scan (N,): which log, and which of its scans; dropped: how
    many scans gave no pair, by cause.
    """

    free: Mask
    target: NDArray[np.float16]
    joystick: NDArray[np.float32]
    log: NDArray[np.int_]
    scan: NDArray[np.int_]
    dropped: dict[str, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.free)

    def take(self, which: NDArray[np.int_] | Mask) -> Self:
        """Some of the pairs, by index or mask."""
        return type(self)(self.free[which], self.target[which], self.joystick[which], self.log[which], self.scan[which])

    def mirrored(self) -> Self:
        """The same drives in a world with left and right exchanged. base_link lies on the border between iy 49 and 50,
        so that cells map onto cells: iy -> 99 - iy."""
        flip = np.array([1, -1], np.float32)
        return type(self)(
            self.free[:, ::-1], self.target[:, ::-1], self.joystick * flip, self.log, self.scan, self.dropped
        )


def heatmap_pairs(
    logs: Sequence[DriveLog],
    config: HeatmapTargetConfig | None = None,
    progress: Progress | None = None,
) -> HeatmapPairs:
    """Pairs of all logs, in order (about .5 ms a scan). progress(done, total) is called after every log.

    ValueError without logs, or where not one scan gives a pair: it says what was found instead. DataError for a
    `T_place_odom` that is no pose, or an odometry of more than 100 km.
    """
    config = config or HeatmapTargetConfig()
    if not logs:
        raise ValueError("no demonstration was given: at least one drive log is needed")
    places = _places(logs)
    collected, dropped = _Collected(), Counter[str]()
    for number, log in enumerate(logs):
        for index in _spaced_scans(log, config.spacing, dropped):
            _add_pair(collected, dropped, number, index, places[number], config)
        if progress:
            progress(number + 1, len(logs))
    if not collected.free:
        found = ", ".join(f"{cause}: {count}" for cause, count in sorted(dropped.items()) if count)
        raise ValueError(f"{len(logs)} logs hold no scan with a path through its free space ({found or 'no scans'})")
    return collected.pairs({cause: count for cause, count in dropped.items() if count})


class _Collected:
    """Pairs as they are found."""

    def __init__(self) -> None:
        self.free: list[Mask] = []
        self.target: list[NDArray[np.float16]] = []
        self.joystick: list[Floats] = []
        self.origin: list[tuple[int, int]] = []

    def pairs(self, dropped: dict[str, int]) -> HeatmapPairs:
        log, scan = np.array(self.origin).T
        joystick = np.array(self.joystick, np.float32)
        return HeatmapPairs(np.array(self.free), np.array(self.target), joystick, log, scan, dropped)


def _add_pair(
    to: _Collected, dropped: Counter[str], number: int, index: int, place: _Place, config: HeatmapTargetConfig
) -> None:
    log = place.logs[number]
    free = free_mask(local_grid(log.scan(index), log.mounting))
    if not free.any():
        dropped["sees nothing"] += 1
        return
    points, run = place.paths_from(number, float(log.scan_stamp[index]), config.paths)
    target = draw_target(free, points, run, config)
    if not target.any():
        dropped["no path"] += 1
        return
    to.free.append(free)
    to.target.append(target.astype(np.float16))
    to.joystick.append(log.joystick_at(log.scan_stamp[index : index + 1])[0])
    to.origin.append((number, index))


def _spaced_scans(log: DriveLog, spacing: float, dropped: Counter[str]) -> list[int]:
    """Scans during the odometry, at least `spacing` of way apart."""
    if len(log.odometry_stamp) < 2:
        dropped["no odometry"] += len(log.scan_stamp)
        return []
    stamp = log.scan_stamp
    covered = np.flatnonzero((stamp >= log.odometry_stamp[0]) & (stamp < log.odometry_stamp[-1]))
    dropped["no odometry"] += len(stamp) - len(covered)
    way = np.interp(stamp[covered], log.odometry_stamp, _way(log.pose))
    kept, last = [], -np.inf
    for index, here in zip(covered.tolist(), way, strict=True):
        if here - last >= spacing:
            kept.append(index)
            last = here
    dropped["too near to the scan before"] += len(covered) - len(kept)
    return kept


def _way(pose: Floats) -> Floats:
    turned = np.r_[0.0, np.cumsum(np.abs(np.diff(pose[:, 2])))]
    return np.asarray(arc_length(pose[:, :2]) + _ARM * turned)


@dataclass
class _Place:
    """All drives of one place: their paths as points `STEP` apart, in the place's frame."""

    logs: dict[int, DriveLog] = field(default_factory=dict)
    frames: dict[int, Pose2] = field(default_factory=dict)
    points: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    run: NDArray[np.int_] = field(default_factory=lambda: np.zeros(0, int))
    """of every point: consecutive points of one unbroken path share a number"""
    stamp: Floats = field(default_factory=lambda: np.zeros(0))
    rows: dict[int, slice] = field(default_factory=dict)
    """which points are a log's"""

    def add(self, number: int, log: DriveLog, T_place_odom: Pose2) -> None:
        self.logs[number], self.frames[number] = log, T_place_odom
        pieces = [_resampled(log.odometry_stamp[piece], log.pose[piece, :2]) for piece in _unbroken(log)]
        before, runs = len(self.points), 1 + (self.run[-1] if len(self.run) else -1)
        for k, (stamp, points) in enumerate(pieces):
            self.points = np.vstack([self.points, T_place_odom.transform(points)])
            self.stamp = np.r_[self.stamp, stamp]
            self.run = np.r_[self.run, np.full(len(points), runs + k)]
        self.rows[number] = slice(before, len(self.points))

    def paths_from(self, number: int, stamp: float, which: str) -> tuple[Floats, NDArray[np.int_]]:
        """Points in base_link (P, 2) [m] and their runs (P,): of all drives, or of the log's own way after `stamp`."""
        rows = self.rows[number] if which == "own" else slice(0, len(self.points))
        points, run = self.points[rows], self.run[rows]
        if which == "own":
            first = np.searchsorted(self.stamp[rows], stamp)
            points, run = points[first:], run[first:]
        base = self.frames[number] * Pose2(*self.logs[number].pose_at([stamp])[0])
        near = np.flatnonzero((np.abs(points - (base.x, base.y)) < np.sqrt(2) * WINDOW).all(axis=1))
        cut = np.r_[0, np.cumsum(np.diff(near) > 1)] if len(near) else near  # what left the window is another run
        local = base.inverse().transform(points[near])
        if which == "own":
            return _first_piece(local, run[near] + cut)
        return local, run[near] * (len(near) + 1) + cut


def _first_piece(points: Floats, run: NDArray[np.int_]) -> tuple[Floats, NDArray[np.int_]]:
    inside = (np.abs(points) < WINDOW).all(axis=1) & (run == run[:1])
    end = len(inside) if inside.all() else int(np.argmin(inside))
    return points[:end], np.zeros(end, int)


def _places(logs: Sequence[DriveLog]) -> list[_Place]:
    """The place of each log."""
    named: dict[str, _Place] = {}
    found = []
    for number, log in enumerate(logs):
        name = log.metadata.get("place")
        place = _Place() if name is None else named.setdefault(name, _Place())
        if len(log.odometry_stamp) >= 2:
            _require_plausible(log)
            place.add(number, log, _frame(log))
        found.append(place)
    return found


def _require_plausible(log: DriveLog) -> None:
    way = float(arc_length(log.pose[:, :2])[-1])
    if way > _LONGEST:
        raise DataError(f"the odometry of log {log.name!r} is {way:g} m long, must be at most {_LONGEST:g} m")


def _frame(log: DriveLog) -> Pose2:
    said = log.metadata.get("T_place_odom", "0 0 0").split()
    try:
        x, y, yaw = (float(word) for word in said)
    except ValueError as wrong:
        raise DataError(f"log {log.name!r} says T_place_odom is {' '.join(said)!r}, must be x y yaw") from wrong
    if not (np.isfinite((x, y, yaw)).all() and max(abs(x), abs(y)) <= _FARTHEST):
        raise DataError(
            f"log {log.name!r} says T_place_odom is {' '.join(said)!r}, must be finite and within {_FARTHEST:g} m"
        )
    return Pose2(x, y, yaw)


def _unbroken(log: DriveLog) -> list[slice]:
    breaks = np.flatnonzero(np.diff(log.odometry_stamp) > _GAP) + 1
    edges = [0, *breaks.tolist(), len(log.odometry_stamp)]
    return [slice(a, b) for a, b in pairwise(edges)]


def _resampled(stamp: Floats, points: Floats) -> tuple[Floats, Floats]:
    """A path at points STEP apart -> stamps (M,), points (M, 2)."""
    way = arc_length(points)
    way = way + np.arange(len(way)) * 1e-9  # a standing robot must not repeat an abscissa
    at = np.arange(0.0, way[-1] + STEP / 2, STEP)
    return np.interp(at, way, stamp), np.stack([np.interp(at, way, points[:, k]) for k in (0, 1)], axis=1)


def draw_target(free: Mask, points: Floats, run: NDArray[np.int_], config: HeatmapTargetConfig) -> Heatmap:
    """The target (100, 100) of one scan. free (100, 100): seen free; points (P, 2) [m] in base_link, STEP apart along
    each path; run (P,): a number a path, equal numbers stand together. All 0 if no path is visible."""
    if free.shape != (CELLS, CELLS):
        raise ValueError(f"free has shape {free.shape}, must be ({CELLS}, {CELLS})")
    paths, ends = np.zeros((2, CELLS, CELLS), np.uint8)
    visible = cv2.morphologyEx(free.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    for portion in _portions(visible, points, run, config):
        cells = np.floor((portion + WINDOW) / RESOLUTION).astype(int)
        paths[cells[:, 1], cells[:, 0]] = 1
        ends[cells[-1, 1], cells[-1, 0]] = 1
    paths, ends = (_dilated(m, r) for m, r in ((paths, config.path_radius), (ends, config.end_radius)))
    image = np.where(ends > 0, config.end_value, config.path_value * paths).astype(np.float32)
    return squashed(_smoothed(image, config.sigma))


def _portions(
    visible: NDArray[np.uint8], points: Floats, run: NDArray[np.int_], config: HeatmapTargetConfig
) -> list[Floats]:
    """The visible portions of the paths, as far as they lead away."""
    cells = np.floor((points + WINDOW) / RESOLUTION).astype(int)
    inside = ((cells >= 0) & (cells < CELLS)).all(axis=1)
    seen = np.flatnonzero(inside)
    seen = seen[visible[cells[seen, 1], cells[seen, 0]] > 0]
    parts = np.split(seen, np.flatnonzero((np.diff(seen) > 1) | (np.diff(run[seen]) != 0)) + 1)
    if config.paths == "own":
        parts = parts[:1]
    found = []
    for part in parts:
        away = _leading_away(points[part], config.shortest) if len(part) else part
        if len(away):
            found.append(away)
    return found


def _leading_away(portion: Floats, least: float) -> Floats:
    """A portion (M, 2) without its beginning that comes towards base_link: from the nearest point before the first rise
    by `least` [m] on; empty if it never leads away."""
    distance = np.hypot(*portion.T)
    risen = distance - np.minimum.accumulate(distance) >= least
    if not risen.any():
        return portion[:0]
    return portion[int(np.argmin(distance[: int(np.argmax(risen)) + 1])) :]


def _dilated(mask: NDArray[np.uint8], radius: float) -> NDArray[np.uint8]:
    reach = int(radius / RESOLUTION + 1e-9)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = (np.hypot(x, y) * RESOLUTION <= radius + 1e-9).astype(np.uint8)
    return np.asarray(cv2.dilate(mask, disc, borderType=cv2.BORDER_CONSTANT, borderValue=0))


def _smoothed(image: Heatmap, sigma: float) -> Heatmap:
    if sigma == 0:
        return image
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma / RESOLUTION, borderType=cv2.BORDER_CONSTANT), np.float32)
