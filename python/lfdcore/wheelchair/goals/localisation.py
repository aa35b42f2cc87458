"""Where the chair is in a known map: scans matched to the map around what the odometry predicts (Sec. 2.2).

Correlative matching (cf. Olson 2009) over a likelihood field (cf. Thrun et al. 2005, Sec. 6.4), then Gauss-Newton on
the interpolated distance to the map's surfaces. The odometry's prediction is a Gaussian prior, so that in a corridor
without features the chair moves along it as the odometry says. docs/decisions.md says why it is ours.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import DriveLog
from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.grid import LaserScan, OccupancyGrid, distance_field, read_beams
from lfdcore.progress import Progress

Array = NDArray[np.float64]
Outcome = Literal["tracked", "lost", "blind"]


@dataclass(frozen=True)
class LocaliserConfig:
    """How scans are matched. Lengths [m], angles [rad]."""

    initial_position_sd: float = 0.2
    initial_heading_sd: float = math.radians(4.0)
    drift_along: float = 0.1  # sd of the odometry's error per metre driven ..
    drift_heading: float = 0.1  # .. and per radian turned
    drift_heading_along: float = 0.05  # of its heading per metre driven
    drift_still: float = 0.01  # a scan, in metres and radians: stamps of scans and odometry do not quite agree
    surface_sd: float = 0.05  # of a beam's end about the map's surface: scanner and map together
    farthest: float = 0.4  # a beam's end farther from all that the map knows tells nothing
    beams: int = 181  # of a scan are used at most, in the coarse search every third ..
    independent: float = 4.0  # .. and so many count as one, since their errors are alike
    search_sds: float = 2.5  # half the width of the search in sds of the prediction, but ..
    least_search: float = 0.1  # .. at least, and ..
    most_search: float = 1.0  # .. at most so wide, in position
    most_search_heading: float = math.radians(15.0)
    step: float = 0.1  # of the coarse search; the fine one has a quarter
    step_heading: float = math.radians(2.0)
    refinements: int = 8  # Gauss-Newton steps at most
    lost_below: float = 0.6  # share of the beams that the map explains; then ..
    widening: float = 1.3  # .. the prediction's sds grow by this factor a scan, as long as they are below the most
    least_beams: int = 12  # fewer that end somewhere: blind

    def __post_init__(self) -> None:
        for one in fields(self):
            value = getattr(self, one.name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{one.name} must be finite and > 0, got {value}")
        if self.lost_below >= 1:
            raise ValueError(f"lost_below must be below 1, got {self.lost_below}")


@dataclass(frozen=True, eq=False)
class LocalisedPose:
    """pose: T_map_base. score: share of the beams used whose ends lie where the map has a surface, 0..1 (0 if blind).

    outcome: 'tracked' - the scan corrected the prediction; 'lost' - the map does not explain the scan: the pose is the
    odometry's prediction, and the search widens from scan to scan; 'blind' - too few beams ended anywhere: likewise.
    covariance (3, 3): of x, y [m], yaw [rad] as the localiser believes; it knows nothing of a wrong corridor that looks
    alike.
    """

    pose: Pose2
    score: float
    outcome: Outcome
    covariance: Array


class ScanLocaliser:
    """Follows a chair in a known map from scans and odometry. Call update() with each scan.

    grid: the map; unknown cells count as solid, as in simulation. initial: T_map_base at the first scan, right to
    about .3 m and 5 degrees.
    Raises ValueError for a map without occupied cells or a pose that is not finite. Not for threads to share.
    """

    def __init__(self, grid: OccupancyGrid, initial: Pose2, config: LocaliserConfig | None = None) -> None:
        _require_pose("initial", initial)
        self.config = config or LocaliserConfig()
        self._field = _SurfaceField(grid, self.config)
        self._pose = initial
        position, heading = self.config.initial_position_sd, self.config.initial_heading_sd
        self._covariance = np.diag([position**2, position**2, heading**2])
        self._odometry: Pose2 | None = None

    @property
    def pose(self) -> Pose2:
        """T_map_base now."""
        return self._pose

    def update(self, scan: LaserScan, T_base_laser: Pose2, odometry: Pose2) -> LocalisedPose:
        """Takes a scan and T_odom_base at its time -> where the chair is.

        The first odometry counts as the initial pose's. Raises ValueError for poses that are not finite.
        """
        _require_pose("odometry", odometry)
        _require_pose("T_base_laser", T_base_laser)
        self._predict(odometry)
        beams = self._beams(scan, T_base_laser)
        if len(beams.ends) < self.config.least_beams:
            return LocalisedPose(self._pose, 0.0, "blind", self._covariance.copy())
        prior = _Prior(np.array([*self._pose]), np.linalg.inv(self._covariance))
        found, information = self._refined(beams, self._searched(beams, prior), prior)
        score = self._field.share_explained(beams, found)
        if score < self.config.lost_below:
            self._widen()
            return LocalisedPose(self._pose, score, "lost", self._covariance.copy())
        self._pose = Pose2(float(found[0]), float(found[1]), float(wrap_angle(found[2])))
        self._covariance = np.asarray(np.linalg.inv(information), float)
        return LocalisedPose(self._pose, score, "tracked", self._covariance.copy())

    def _predict(self, odometry: Pose2) -> None:
        moved = Pose2() if self._odometry is None else self._odometry.inverse() * odometry
        self._odometry = odometry
        c = self.config
        way, turn = math.hypot(moved.x, moved.y), abs(moved.yaw)
        along = c.drift_along * way + c.drift_still
        heading = c.drift_heading * turn + c.drift_heading_along * way + c.drift_still
        after = self._pose * moved
        lever = np.eye(3)  # an error of the heading before turns the way driven since
        lever[0, 2], lever[1, 2] = self._pose.y - after.y, after.x - self._pose.x
        self._pose = after
        grown = lever @ self._covariance @ lever.T + np.diag([along**2, along**2, heading**2])
        self._covariance = grown

    def _widen(self) -> None:
        c = self.config
        most = np.array([c.most_search, c.most_search, c.most_search_heading]) / c.search_sds
        factor = np.where(np.sqrt(np.diag(self._covariance)) < most, c.widening, 1.0)
        self._covariance = self._covariance * np.outer(factor, factor)

    def _beams(self, scan: LaserScan, T_base_laser: Pose2) -> _Beams:
        """At most `beams` of the beams that ended at something, evenly taken."""
        lengths, ended = read_beams(scan)
        hit = np.flatnonzero(ended)
        hit = hit[np.unique(np.linspace(0, len(hit) - 1, min(len(hit), self.config.beams)).astype(int))]
        angles = np.asarray(scan.angles())[hit]
        ends = lengths[hit, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return _Beams(np.asarray(T_base_laser.transform(ends)), angles + T_base_laser.yaw)

    # -- the search ---------------------------------------------------------------------------------------------

    def _searched(self, beams: _Beams, prior: _Prior) -> Array:
        """The best of all poses on a grid around the prediction, then on a finer one around that -> (3,)."""
        c = self.config
        most = np.array([c.most_search, c.most_search, c.most_search_heading])
        least = np.array([c.least_search, c.least_search, c.step_heading])
        reach = np.asarray(np.clip(c.search_sds * np.sqrt(np.diag(self._covariance)), least, most), float)
        step = np.array([c.step, c.step, c.step_heading])
        evidence = len(beams.ends) / c.independent
        third = _Beams(beams.ends[::3], beams.bearing[::3])
        best = _best(prior.mean, reach, step, lambda *at: evidence * self._field.coarse(third, *at), prior)
        return _best(best, step, step / 4, lambda *at: evidence * self._field.fine(beams, *at), prior)

    def _refined(self, beams: _Beams, pose: Array, prior: _Prior) -> tuple[Array, Array]:
        """Gauss-Newton from a pose (3,) -> the pose and the information (3, 3) there."""
        for _ in range(self.config.refinements):
            information, gradient = self._normal_equations(beams, pose, prior)
            change = np.linalg.solve(information, gradient)
            pose = pose - change
            if np.abs(change).max() < 1e-4:
                break
        return pose, self._normal_equations(beams, pose, prior)[0]

    def _normal_equations(self, beams: _Beams, pose: Array, prior: _Prior) -> tuple[Array, Array]:
        c, s = math.cos(pose[2]), math.sin(pose[2])
        distance, slope = self._field.distance(beams, pose)
        x, y = beams.ends.T  # how the end moves with yaw: (-s x - c y, c x - s y)
        turn = slope[:, 0] * (-s * x - c * y) + slope[:, 1] * (c * x - s * y)
        jacobian = np.column_stack([slope, turn])
        scaled = distance / self.config.surface_sd
        trust = (1 + scaled**2 / 4) ** -2 / (self.config.surface_sd**2 * self.config.independent)  # Geman-McClure
        trust = np.where(np.abs(distance) < self.config.farthest, trust, 0.0)
        weighted = trust[:, None] * jacobian
        return prior.information + weighted.T @ jacobian, prior.gradient(pose) + weighted.T @ distance


@dataclass(frozen=True, eq=False)
class _Beams:
    """Beams that ended at something: ends (N, 2) [m] and bearing (N,) [rad], in base_link."""

    ends: Array
    bearing: Array


@dataclass(frozen=True, eq=False)
class _Prior:
    """What the odometry predicts: a Gaussian over poses."""

    mean: Array
    information: Array

    def gradient(self, pose: Array) -> Array:
        return self.information @ _difference(pose, self.mean)

    def cost(self, poses: Array) -> Array:
        """Minus the log density (...) of poses (..., 3), but for a constant."""
        off = _difference(poses, self.mean)
        return np.asarray(np.einsum("...i,ij,...j->...", off, self.information, off) / 2)


Likelihood = Callable[[Array, Array, Array], Array]


def _best(centre: Array, reach: Array, step: Array, likelihood: Likelihood, prior: _Prior) -> Array:
    """The pose (3,) of the largest posterior among those within `reach` (3,) of `centre` in steps (3,).

    likelihood(yaw (W,), y (V,), x (U,)) -> (W, V, U), logarithms.
    """
    x, y, yaw = (c + s * np.arange(-k, k + 1) for c, s, k in zip(centre, step, np.ceil(reach / step), strict=True))
    poses = np.stack(np.meshgrid(yaw, y, x, indexing="ij")[::-1], axis=-1)
    posterior = likelihood(yaw, y, x) - prior.cost(poses)
    return np.asarray(poses.reshape(-1, 3)[np.argmax(posterior)])


def _difference(pose: Array, mean: Array) -> Array:
    off = pose - mean
    return np.concatenate([off[..., :2], wrap_angle(off[..., 2:])], axis=-1)


class _SurfaceField:
    """Signed distance to the surfaces of a map's solid cells, and log likelihoods of where a beam ends.

    But for the coarse search there is a field for each of the four directions in which a beam may fly, with walls
    thickened away from it: else both faces of a thin wall are the same, and the chair stays as far off as it is thick.
    """

    def __init__(self, grid: OccupancyGrid, config: LocaliserConfig) -> None:
        if not grid.occupied_mask().any():
            raise ValueError("the map has no occupied cell, so no scan can be matched to it")
        self._resolution, self._config = grid.resolution, config
        margin = 2 * math.ceil(config.farthest / grid.resolution) + 2
        self._origin = np.array(grid.origin) - margin * grid.resolution
        solid = np.pad(grid.occupied_mask() | (grid.data < 0), margin)
        self._shape = solid.shape
        self._coarse = _log_likelihood(self._signed(solid), 2 * config.surface_sd, config.farthest)
        thicker = _thickened(solid, math.ceil(config.farthest / grid.resolution))
        self._distance = np.stack([self._signed(one) for one in thicker])

    def _signed(self, solid: NDArray[np.bool_]) -> NDArray[np.float32]:
        outside, inside = distance_field(solid, self._resolution), distance_field(~solid, self._resolution)
        half = self._resolution / 2  # from a cell's centre to its edge
        signed = np.where(solid, half - inside, outside - half)
        return np.clip(signed, -self._config.farthest, self._config.farthest).astype(np.float32)

    def coarse(self, beams: _Beams, yaw: Array, y: Array, x: Array) -> Array:
        """Mean log likelihood (W, V, U) of the beams' ends from poses (x (U,), y (V,), yaw (W,))."""
        return np.asarray(self._coarse.ravel()[self._shifted(beams.ends, yaw, y, x)].mean(axis=-1), float)

    def fine(self, beams: _Beams, yaw: Array, y: Array, x: Array) -> Array:
        """The same, more sharply and by the beams' directions."""
        layer = _quadrant(beams.bearing + yaw[:, None]) * (self._shape[0] * self._shape[1])
        cells = self._shifted(beams.ends, yaw, y, x) + layer[:, None, None]
        distance = self._distance.ravel()[cells]
        likelihood = _log_likelihood(distance, self._config.surface_sd, self._config.farthest)
        return np.asarray(likelihood.mean(axis=-1), float)

    def _shifted(self, points: Array, yaw: Array, y: Array, x: Array) -> NDArray[np.int64]:
        """Flat index (W, V, U, points) of the cell in which each point [m, base_link] lies from each pose."""
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        turned = c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]
        height, width = self._shape
        ix = self._cells(turned[0][:, None] + x[:, None], 0, width)
        iy = self._cells(turned[1][:, None] + y[:, None], 1, height)
        return np.asarray(iy[:, :, None] * width + ix[:, None])

    def _cells(self, metres: Array, axis: int, count: int) -> NDArray[np.int64]:
        """Cells along an axis; points beyond the map fall into its empty margin."""
        cells = np.clip((metres - self._origin[axis]) / self._resolution, 0, count - 1)
        return np.asarray(cells.astype(np.int64))

    def distance(self, beams: _Beams, pose: Array) -> tuple[Array, Array]:
        """Signed distance (N,) [m] of the beams' ends from a pose (3,), positive before the surface, and its slope
        (N, 2) in the map, bilinear."""
        ends = Pose2(*map(float, pose)).transform(beams.ends)
        layer, (height, width) = _quadrant(beams.bearing + pose[2]), self._shape
        at = np.clip((ends - self._origin) / self._resolution - 0.5, 0, (width - 1.001, height - 1.001))
        ix, iy = at.astype(np.int64).T
        u, v = (at - np.floor(at)).T
        a, b = self._distance[layer, iy, ix], self._distance[layer, iy, ix + 1]
        c, d = self._distance[layer, iy + 1, ix], self._distance[layer, iy + 1, ix + 1]
        low, high = a + u * (b - a), c + u * (d - c)
        slope = np.stack([(1 - v) * (b - a) + v * (d - c), high - low], axis=1) / self._resolution
        return low + v * (high - low), slope

    def share_explained(self, beams: _Beams, pose: Array) -> float:
        """Share of the beams that end within half `farthest` of a surface, seen from a pose (3,)."""
        return float(np.mean(np.abs(self.distance(beams, pose)[0]) < self._config.farthest / 2))


def _quadrant(direction: Array) -> NDArray[np.int64]:
    """0..3: the nearest of +x, +y, -x, -y to a direction [rad]."""
    return np.asarray(np.rint(direction / (math.pi / 2)).astype(np.int64) % 4)


def _thickened(solid: NDArray[np.bool_], cells: int) -> list[NDArray[np.bool_]]:
    """Solid cells drawn out along +x, +y, -x, -y. The margin must be wider than `cells`."""
    drawn = []
    for axis, sign in ((1, 1), (0, 1), (1, -1), (0, -1)):
        drawn.append(np.logical_or.reduce([np.roll(solid, sign * k, axis) for k in range(cells + 1)]))
    return drawn


def _log_likelihood(distance: NDArray[np.float32], sd: float, farthest: float) -> NDArray[np.float32]:
    """A Gaussian about the surface with a floor: a person in the way is no proof of another pose."""
    floor = math.exp(-((farthest / sd) ** 2) / 2) + 0.02
    return np.log(np.exp(-((distance / sd) ** 2) / 2) + floor).astype(np.float32)


def _require_pose(name: str, pose: Pose2) -> None:
    if not all(math.isfinite(value) for value in pose):
        raise ValueError(f"{name} must be finite [m, rad], got {pose}")


def localise_log(
    log: DriveLog, grid: OccupancyGrid, initial: Pose2, progress: Progress | None = None
) -> list[LocalisedPose]:
    """Where the chair was at each scan of a log; initial: T_map_base at its first scan.

    Raises ValueError for a log without scans or without odometry.
    """
    if not len(log.scan_stamp):
        raise ValueError(f"log {log.name!r} holds no scans, so nothing to match to a map")
    localiser, found = ScanLocaliser(grid, initial), []
    poses = log.pose_at(log.scan_stamp).tolist()
    for k, pose in enumerate(poses):
        found.append(localiser.update(log.scan(k), log.mounting, Pose2(*pose)))
        if progress is not None:
            progress(k + 1, len(poses))
    return found


def with_map_poses(log: DriveLog, grid: OccupancyGrid, initial: Pose2, progress: Progress | None = None) -> DriveLog:
    """The log with T_map_odom at each scan as the scan matcher finds it; arguments and errors as localise_log.

    ValueError too where not one scan could be matched: then nobody knows where the chair was.
    """
    found = localise_log(log, grid, initial, progress)
    if all(one.outcome != "tracked" for one in found):
        raise ValueError(
            f"none of the {len(found)} scans of log {log.name!r} fits the map about where it is said to begin, "
            f"({initial.x:g}, {initial.y:g}) m, {math.degrees(initial.yaw):.0f} degrees"
        )
    odometry = (Pose2(*pose) for pose in log.pose_at(log.scan_stamp).tolist())
    corrections = [[*(one.pose * pose.inverse())] for one, pose in zip(found, odometry, strict=True)]
    return replace(log, map_stamp=log.scan_stamp, map_odom=np.array(corrections))
