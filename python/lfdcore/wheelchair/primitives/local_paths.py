"""Local paths from demonstrations (Sec. 3.2): what the driver did next, seen from every scan of a drive log.

The thesis names several termination criteria without listing them (Fig. 3.7); these are ours. A path starts at
base_link at the instant of a scan and ends at the first of:

- `window`: it leaves the front portion of the 5 x 5 m window (x = 2.5 m or |y| = 2.5 m); the end lies on the border;
- `hidden`: the next point lies farther from the laser than the beam that covers it: the driver could see it, the scan
  could not. Points outside the laser's field of view (beneath the chair) do not count;
- `turn`: the chair has turned by more than 135 degrees;
- `reverse`: it has gone back by more than 3 cm; the end lies where it turned back;
- `behind`: it is behind the axle of the start;
- `rest`: it stands still for more than 1 s; the end lies where it came to rest (docking);
- `gap`: no odometry for more than 3 s, or odometry that jumps; such a path has no known end and is dropped;
- `log`: the log ends: taken as coming to rest, since a demonstration often ends on arrival;
- `time`: 60 s have passed (creeping); dropped like a gap.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.motion import odometry_jumps
from lfdcore.geometry import wrap_angle
from lfdcore.grid import read_beams
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.primitives.beam_lengths import filled_lengths, measured_beams
from lfdcore.wheelchair.stick import DEAD_ZONE
from lfdcore.wheelchair.window import WINDOW

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lfdcore.datasets.drive_log import DriveLog

Floats = NDArray[np.float64]
REASONS = ("window", "hidden", "turn", "reverse", "behind", "rest", "gap", "log", "time")
_DROPPED = ("gap", "time")
_STEP = 0.1  # [s] between the instants at which a path is looked at


@dataclass(frozen=True)
class LocalPathConfig:
    """Criteria that end a local path (see the module) and what makes one worth keeping; SI units, radians."""

    turn: float = np.deg2rad(135.0)
    reverse: float = 0.03
    behind: float = 0.02
    """Behind the axle by more than this [m]: turning in place with noise is not."""
    rest: float = 1.0
    rest_speed: float = 0.02
    """Slower than this [m/s], and turning slower than `rest_turn` [rad/s], is standing still."""
    rest_turn: float = 0.05
    gap: float = 3.0
    duration: float = 60.0
    slack: float = 0.05
    """A point is hidden once it is this much [m], one cell, farther than its beam."""
    shortest: float = 0.6
    """Shorter paths [m] are dropped."""
    dead_zone: float = DEAD_ZONE
    """A start with the stick nearer to its centre than this says nothing about what is wanted: dropped."""

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{item.name} is {value}, must be finite and not negative")


@dataclass(frozen=True)
class LocalPaths:
    """N local paths. All places in base_link at the path's start.

    joystick (N, 2): forward, left at the start; beam_range (N,) [m]: what the beam towards the goal measured at the
    start, capped at the window's border; goal (N, 2) [m]: the end; end_yaw (N,) [rad]: the heading there; paths: N
    arrays (M, 2) [m], from the origin to the goal; clearance (N,) [m]: from the path to the nearest place that the
    start's scan hit, inf if it hit nothing; reason (N,): which of REASONS ended it; stamp (N,) [s]: the scan's;
    dropped: how many starts gave no path, by cause.
    """

    joystick: Floats
    beam_range: Floats
    goal: Floats
    end_yaw: Floats
    paths: list[Floats]
    clearance: Floats
    reason: NDArray[np.str_]
    stamp: Floats
    dropped: dict[str, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.goal)

    def lengths(self) -> Floats:
        """(N,) [m]"""
        return np.array([np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in self.paths])

    def taken(self, which: NDArray[np.bool_]) -> LocalPaths:
        """Those of the paths that a mask (N,) names; `dropped` stays."""
        return LocalPaths(
            self.joystick[which],
            self.beam_range[which],
            self.goal[which],
            self.end_yaw[which],
            [self.paths[i] for i in np.flatnonzero(which)],
            self.clearance[which],
            self.reason[which],
            self.stamp[which],
            self.dropped,
        )

    def mirrored(self) -> LocalPaths:
        """The same drives in a world with left and right exchanged (N paths). The goal's beam keeps its range."""
        flip = np.array([1.0, -1.0])
        return LocalPaths(
            self.joystick * flip,
            self.beam_range,
            self.goal * flip,
            -self.end_yaw,
            [path * flip for path in self.paths],
            self.clearance,
            self.reason,
            self.stamp,
        )

    @staticmethod
    def concatenate(parts: Sequence[LocalPaths]) -> LocalPaths:
        """All paths of several logs, in order."""
        if not parts:
            raise ValueError("no demonstration was given: at least one drive log is needed")
        dropped: Counter[str] = Counter()
        for part in parts:
            dropped.update(part.dropped)
        return LocalPaths(
            np.concatenate([part.joystick for part in parts]),
            np.concatenate([part.beam_range for part in parts]),
            np.concatenate([part.goal for part in parts]),
            np.concatenate([part.end_yaw for part in parts]),
            [path for part in parts for path in part.paths],
            np.concatenate([part.clearance for part in parts]),
            np.concatenate([part.reason for part in parts]),
            np.concatenate([part.stamp for part in parts]),
            dict(dropped),
        )


def beam_geometry(log: DriveLog) -> BeamGeometry:
    """The log's laser. ValueError for a log whose scans have no beams."""
    return BeamGeometry(log.ranges.shape[1], log.angle_min, log.angle_increment, log.mounting)


def extract_local_paths(log: DriveLog, config: LocalPathConfig | None = None) -> LocalPaths:
    """Sec. 3.2: one local path from every scan of a log, where there is one.

    ValueError if the log has no scan, no beam, no joystick (lfdcore.datasets.joystick_from_motion infers one), or fewer
    than two odometry samples.
    """
    config = config or LocalPathConfig()
    _check(log)
    track = _Track(log, config)
    walk = _Walk(log, track, config)
    walk.run()
    return _collect(log, walk, config)


def _check(log: DriveLog) -> None:
    ranges, stamps = np.shape(log.ranges), len(log.scan_stamp)
    if stamps == 0 or len(log.odometry_stamp) < 2:
        raise ValueError(
            f"log {log.name!r} has {stamps} scans and {len(log.odometry_stamp)} odometry samples; "
            "at least 1 and 2 are needed to find a local path"
        )
    if len(log.joystick_stamp) == 0:
        raise ValueError(f"log {log.name!r} has no joystick; lfdcore.datasets.joystick_from_motion can infer one")
    if len(ranges) != 2 or ranges[0] != stamps or ranges[1] == 0:
        raise ValueError(f"log {log.name!r} has {stamps} scan stamps but ranges of shape {ranges}, must be (S, B)")


class _Track:
    """The whole drive at scan instants and every 0.1 s: what each path is cut from."""

    def __init__(self, log: DriveLog, config: LocalPathConfig) -> None:
        first, last = float(log.odometry_stamp[0]), float(log.odometry_stamp[-1])
        scans = np.asarray(log.scan_stamp, dtype=np.float64)
        covered = (scans >= first) & (scans < last)
        self.scan = np.flatnonzero(covered & np.isfinite(scans))
        grid = np.arange(first, last + _STEP, _STEP).clip(max=last)
        self.stamp = np.unique(np.concatenate([grid, scans[self.scan]]))
        pose = log.pose_at(self.stamp)
        self.position, self.yaw = pose[:, :2], np.unwrap(pose[:, 2])
        self.start = np.searchsorted(self.stamp, scans[self.scan])
        step, interval = np.diff(self.position, axis=0), np.diff(self.stamp)
        middle = (self.yaw[1:] + self.yaw[:-1]) / 2
        ahead = (step * np.stack([np.cos(middle), np.sin(middle)], 1)).sum(1)
        self.travel = np.r_[0.0, np.cumsum(ahead)]
        moving = (np.hypot(*step.T) > config.rest_speed * interval) | (
            np.abs(np.diff(self.yaw)) > config.rest_turn * interval
        )
        # last_moved[j]: the newest instant up to j at which the chair moved on the step before it
        self.last_moved = np.maximum.accumulate(np.r_[0, np.where(moving, np.arange(1, len(self.stamp)), 0)])
        self.gap = np.r_[False, _in_gap(log, self.stamp[1:], config.gap)]

    def local(self, start: NDArray[np.intp], at: NDArray[np.intp]) -> Floats:
        """Positions (N, 2) at instants `at`, in base_link at instants `start`."""
        off = self.position[at] - self.position[start]
        c, s = np.cos(self.yaw[start]), np.sin(self.yaw[start])
        return np.stack([c * off[:, 0] + s * off[:, 1], -s * off[:, 0] + c * off[:, 1]], 1)


def _in_gap(log: DriveLog, stamps: Floats, longest: float) -> NDArray[np.bool_]:
    odometry = np.asarray(log.odometry_stamp)
    after = np.clip(np.searchsorted(odometry, stamps), 1, len(odometry) - 1)
    return (odometry[after] - odometry[after - 1] > longest) | odometry_jumps(log)[after]


class _Walk:
    """All paths grow together, one instant of the track a turn, until each has met a criterion."""

    def __init__(self, log: DriveLog, track: _Track, config: LocalPathConfig) -> None:
        self.track, self.config, self.beams = track, config, beam_geometry(log)
        self.lengths, self.hit = read_beams(log.ranges, log.range_min, log.range_max)
        self.seen = filled_lengths(self.lengths, self.hit)
        self.end = track.start.copy()
        self.furthest = track.start.copy()  # where a path had come farthest ahead
        self.reason = np.full(len(track.start), "log", dtype="U8")

    def run(self) -> None:
        active = np.arange(len(self.end))
        while len(active):
            active = active[self.end[active] + 1 < len(self.track.stamp)]
            met = self._criteria(active, self.end[active] + 1)
            which = np.select(list(met.values()), np.arange(1, len(met) + 1), 0)
            reason = np.array(["", *met])[which]
            self._finish(active[which > 0], reason[which > 0])
            active = active[which == 0]
            self.end[active] += 1
            ahead = self.track.travel[self.end[active]] > self.track.travel[self.furthest[active]]
            self.furthest[active[ahead]] = self.end[active[ahead]]
        rest = np.isin(self.reason, ["rest", "log"])  # the end lies where the chair came to rest
        moved = np.minimum(self.end[rest], self.track.last_moved[self.end[rest]])
        self.end[rest] = np.maximum(moved, self.track.start[rest])

    def hits(self, scan: np.intp) -> Floats:
        """Where the beams of a scan ended on something -> (M, 2) [m] in base_link."""
        return self.beams.hits(self.lengths[scan], self.hit[scan])

    def _criteria(self, active: NDArray[np.intp], at: NDArray[np.intp]) -> dict[str, NDArray[np.bool_]]:
        """Which paths would meet which criterion at instants `at`; the first that holds counts."""
        track, config, start = self.track, self.config, self.track.start[active]
        local = track.local(start, at)
        beam, distance, covered = self.beams.locate(local)
        seen = self.seen[track.scan[active], beam]
        return {
            "gap": track.gap[at],
            "window": (local[:, 0] >= WINDOW) | (np.abs(local[:, 1]) >= WINDOW),
            "behind": local[:, 0] < -config.behind,
            "reverse": track.travel[self.furthest[active]] - track.travel[at] > config.reverse,
            "turn": np.abs(track.yaw[at] - track.yaw[start]) > config.turn,
            "hidden": covered & (distance > seen + config.slack),
            "rest": track.stamp[at] - track.stamp[np.maximum(track.last_moved[at], start)] > config.rest,
            "time": track.stamp[at] - track.stamp[start] > config.duration,
        }

    def _finish(self, paths: NDArray[np.intp], reason: NDArray[np.str_]) -> None:
        self.reason[paths] = reason
        self.end[paths[reason == "window"]] += 1  # the border lies between this instant and the one before
        turned_back = paths[reason == "reverse"]
        self.end[turned_back] = self.furthest[turned_back]


def _collect(log: DriveLog, walk: _Walk, config: LocalPathConfig) -> LocalPaths:
    track = walk.track
    joystick = np.asarray(log.joystick_at(log.scan_stamp[track.scan]), dtype=np.float64)
    paths = [_cut(track, *piece) for piece in zip(track.start, walk.end, walk.reason, strict=True)]
    cause = _causes(walk, joystick, paths, config)
    kept = np.flatnonzero(cause == "")
    dropped = Counter(str(name) for name in cause if name)
    dropped["no odometry"] = len(log.scan_stamp) - len(track.scan)
    goal = np.array([paths[i][-1] for i in kept]).reshape(-1, 2)
    beam = walk.beams.locate(goal)[0]
    return LocalPaths(
        joystick[kept],
        np.minimum(walk.seen[track.scan[kept], beam], walk.beams.caps[beam]),
        goal,
        wrap_angle(track.yaw[walk.end[kept]] - track.yaw[track.start[kept]]),
        [paths[i] for i in kept],
        np.array([_clearance(paths[i], walk.hits(track.scan[i])) for i in kept]),
        walk.reason[kept],
        track.stamp[track.start[kept]],
        {name: count for name, count in dropped.items() if count},
    )


def _causes(walk: _Walk, joystick: Floats, paths: list[Floats], config: LocalPathConfig) -> NDArray[np.str_]:
    """Why each start gives no path; empty where it gives one."""
    measured = measured_beams(walk.lengths, walk.hit)[walk.track.scan].any(axis=1)
    pushed = np.hypot(*joystick.T) >= config.dead_zone  # NaN is not
    long = np.array([np.hypot(*np.diff(path, axis=0).T).sum() >= config.shortest for path in paths], dtype=bool)
    lost = [walk.reason == name for name in _DROPPED]
    return np.select([~measured, ~pushed, *lost, ~long], ["no scan", "no input", *_DROPPED, "too short"], "")


def _clearance(path: Floats, hits: Floats) -> float:
    if not len(hits):
        return float("inf")
    squared = (path**2).sum(1)[:, None] + (hits**2).sum(1) - 2 * path @ hits.T
    return float(np.sqrt(max(squared.min(), 0.0)))


def _cut(track: _Track, start: np.intp, end: np.intp, reason: str) -> Floats:
    at = np.arange(start, end + 1)
    path = track.local(np.full(len(at), start), at)
    if reason == "window":
        path[-1] = _on_border(path[-2], path[-1])
    return path


def _on_border(inside: Floats, outside: Floats) -> Floats:
    limit = WINDOW - 1e-6  # still in the last cell
    step = outside - inside
    over = np.abs(outside) > limit
    if not over.any():
        return outside
    shares = (np.copysign(limit, outside[over]) - inside[over]) / step[over]
    return np.asarray(np.clip(inside + np.clip(shares, 0.0, 1.0).min() * step, -limit, limit))
