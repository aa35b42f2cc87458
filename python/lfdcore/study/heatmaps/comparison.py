"""The a-posteriori comparison of Sec. 4.6.2: what three methods predict along unassisted drives (Alg. 4, Table 4.2).

Primitives (Ch. 3), the naive network and heatmaps see the same scans, sticks and rolling map. Every .5 s of driving
each plans as it would on the chair, up to its coarse path (no footprint check). The landscape after optimisation
(values V(s) = max_a Q(s, a) after Q-learning, the Boltzmann mean of D.8 after DPP) is squashed alike for all methods:
less its smallest value over the cells that may be entered, divided by its largest; cells that are not seen free, on the
window's border, or nearer to an obstacle than the planner goes, are 0, and so is a whole frame without a path. Alg. 4
puts the frames together in the frame of the odometry.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import way_ahead
from lfdcore.geometry import arc_length
from lfdcore.grid import HeatmapMap, ObstaclePoints, OccupancyGrid
from lfdcore.planning import DppSolver, GridMdp, OrientationMoments, QLearningSolver
from lfdcore.progress import Progress, StageProgress, silent
from lfdcore.study.jobs import run_jobs
from lfdcore.training.drive_primitives import first_share, learn_drive
from lfdcore.wheelchair.drivable_path import DrivablePathConfig
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import MOVING, ChairGeometry, Observation, observations
from lfdcore.wheelchair.paths import along, distance_to_polyline
from lfdcore.wheelchair.planner import LOOK_AHEAD, PlannedPath, Planner
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.planner import PrimitivesPlanner, PrimitivesPlannerConfig
from lfdcore.wheelchair.surroundings import MEMORY, Surroundings
from lfdcore.wheelchair.window import RESOLUTION, WINDOW, blocked_mask, border_mask, free_mask

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Heatmap = NDArray[np.float32]

METHODS = ("primitives", "naive", "heatmaps")
"""In the order of Table 4.2."""
REACH = WINDOW
"""[m] of way that a planned path is compared over"""
STEP = 0.05
"""[m] between the points at which paths are compared and rewards are read"""
_UNCHECKED = DrivablePathConfig(check_footprint=False)


@dataclass(frozen=True, kw_only=True)
class ComparisonConfig:
    """period [s] between frames; slowest [m/s]: nothing is asked of a chair that stands; map_duration [s] of the
    rolling map. The planners are those of the assistants up to the coarse path; the drivers being able as the
    demonstrators, the stick is taken to be no more doubtful than theirs (driver_sd 0, as printed)."""

    period: float = 0.5
    slowest: float = MOVING
    map_duration: float = MEMORY
    primitives: PrimitivesPlannerConfig = field(default_factory=lambda: PrimitivesPlannerConfig(drivable=_UNCHECKED))
    heatmaps: HeatmapPlannerConfig = field(
        default_factory=lambda: HeatmapPlannerConfig(driver_sd=0.0, drivable=_UNCHECKED)
    )


@dataclass(frozen=True)
class ComparedModels:
    """The three models, best learned from the same demonstrations."""

    primitives: DriveAssistantModel
    naive: NaiveHeatmapModel
    heatmaps: HeatmapModel


@dataclass(frozen=True)
class ModelFiles:
    """Files of the three models."""

    primitives: Path
    naive: Path
    heatmaps: Path

    def load(self) -> ComparedModels:
        """ModelError for a file that is damaged or of another kind than its name here says; read once a process."""
        return _loaded(self)


@lru_cache(maxsize=2)
def _loaded(files: ModelFiles) -> ComparedModels:
    naive, heatmaps = NaiveHeatmapModel.load(files.naive), HeatmapModel.load(files.heatmaps)
    return ComparedModels(DriveAssistantModel.load(files.primitives), naive, heatmaps)


def learn_rival_primitives(folder: Path, logs: Sequence[DriveLog], progress: StageProgress | None = None) -> Path:
    """Learns primitives from the demonstrations of heatmaps -> their file in `folder` (8 s for the 72 maze runs)."""
    tell = progress or silent
    path = folder / "primitives.safetensors"
    learn_drive(first_share(logs), progress=partial(tell, "primitives")).save(path)
    return path


def learn_naive(folder: Path, logs: Sequence[DriveLog], progress: StageProgress | None = None) -> Path:
    """Learns the naive network from the demonstrations of heatmaps -> its file in `folder` (2 minutes for the 72 maze
    runs). Needs torch."""
    from lfdcore.training.drive_heatmaps import learn_naive_heatmap

    path = folder / "naive.safetensors"
    learn_naive_heatmap(logs, progress=progress).model.save(path)
    return path


class NaivePlanner(HeatmapPlanner):
    """Heatmaps' planner over the naive network's heatmap instead of the product: all else is the same."""

    def __init__(self, models: ComparedModels, config: HeatmapPlannerConfig, chair: ChairGeometry) -> None:
        super().__init__(models.heatmaps, config, chair)
        self._network = models.naive.network

    def sources(self, free: Mask, joystick: Floats, orientation: OrientationMoments) -> tuple[Heatmap, Heatmap]:
        """The first is what the network says of scan and stick, the second 1 everywhere."""
        heat = self._network.predict(free, joystick)
        return heat, np.ones_like(heat)


class _Solver(Protocol):
    def solve(self, mdp: GridMdp) -> _Values: ...


class _Values(Protocol):
    def values(self) -> Floats: ...


@dataclass(frozen=True)
class Method:
    """A planner, its optimiser, and the reward that it gives cells it does not enter."""

    planner: Planner
    solver: _Solver
    obstacle: float

    def landscape(self, planned: PlannedPath, grid: OccupancyGrid) -> Heatmap:
        """The landscape that a path was planned over, squashed: (100, 100) in [0, 1]."""
        blocked = blocked_mask(planned.reward, self.obstacle)
        values = self.solver.solve(GridMdp(planned.reward, blocked)).values()
        return squashed_values(values, free_mask(grid) & ~blocked & ~border_mask())  # the border would set the scale


def squashed_values(values: NDArray[np.floating], entered: Mask) -> Heatmap:
    """Values (100, 100) of the cells that may be entered, from their smallest (0) to their largest (1); 0 elsewhere,
    and everywhere if all are alike. ValueError if one of them is not finite."""
    result = np.zeros(values.shape, np.float32)
    inside = values[entered]
    if not np.isfinite(inside).all():
        raise ValueError("a cell that may be entered has no finite value")
    if len(inside) and inside.max() > inside.min():
        result[entered] = (inside - inside.min()) / (inside.max() - inside.min())
    return result


def methods(models: ComparedModels, config: ComparisonConfig, chair: ChairGeometry) -> dict[str, Method]:
    """By name, in the order of METHODS."""
    q_learning, heat = QLearningSolver(config.heatmaps.q_learning), config.heatmaps
    primitives = PrimitivesPlanner(models.primitives, config.primitives, chair)
    return {
        "primitives": Method(primitives, DppSolver(config.primitives.dpp), config.primitives.reward.obstacle),
        "naive": Method(NaivePlanner(models, heat, chair), q_learning, heat.reward.obstacle),
        "heatmaps": Method(HeatmapPlanner(models.heatmaps, heat, chair), q_learning, heat.reward.obstacle),
    }


@dataclass(frozen=True)
class MethodRun:
    """One method along one drive of F frames."""

    concatenated: Heatmap
    """(H, W) in [0, 1] by Alg. 4, over the run's map"""
    reward: float
    """mean of it at the positions driven, STEP apart"""
    rank: float
    """[%] mean share of the cells ever seen whose reward is lower (those equal count half)"""
    near: Floats
    """(F,) [m] RMS deviation of the path's points from the way driven, up to the look-ahead (.8 m); NaN without one"""
    whole: Floats
    """(F,) [m] the same up to 2.5 m"""
    at_equal_length: Floats
    """(F,) [m] RMS distance between path and way at equal arc length, up to 2.5 m; straight on beyond the path's end"""
    seconds: Floats
    """(F,) [s] from the observation to the end of the coarse path, the rolling map included"""
    without_path: float
    """share of frames"""


@dataclass(frozen=True)
class ComparedRun:
    """One drive: its map in the odometry's frame, the way, and what the methods made of it."""

    name: str
    grid: OccupancyGrid
    """what was seen: 0 free, 100 occupied, -1 nothing"""
    driven: Floats
    """(N, 3) poses, STEP apart"""
    methods: Mapping[str, MethodRun]

    @property
    def frames(self) -> int:
        """How many each method was asked at."""
        return len(next(iter(self.methods.values())).seconds)


@dataclass(frozen=True)
class Comparison:
    """All runs."""

    runs: tuple[ComparedRun, ...]
    config: ComparisonConfig

    def column(self, method: str, figure: str) -> Floats:
        """A figure of a method, a value a run: 'reward', 'rank', 'without_path', 'seconds' (median frame), or 'near',
        'whole' and 'at_equal_length' (mean over frames)."""
        return np.array([_figure(run.methods[method], figure) for run in self.runs])

    @property
    def frames(self) -> int:
        """Of all runs."""
        return sum(run.frames for run in self.runs)


def _figure(run: MethodRun, figure: str) -> float:
    value = getattr(run, figure)
    if not isinstance(value, np.ndarray):
        return float(value)
    known = value[np.isfinite(value)]
    if not len(known):
        return float("nan")
    return float(np.median(known) if figure == "seconds" else known.mean())


@dataclass(frozen=True)
class _Job:
    log: Path
    models: ModelFiles
    config: ComparisonConfig

    def run(self) -> ComparedRun:
        return compare_on_log(open_log(self.log), self.models.load(), self.config)


def compare_on_logs(
    logs: Sequence[Path],
    models: ModelFiles,
    config: ComparisonConfig | None = None,
    progress: Progress | None = None,
    processes: int | None = None,
) -> Comparison:
    """Compares along drives with joystick and odometry. All figures but the seconds are the same whatever `processes`.
    ValueError without logs, or as compare_on_log; ModelError for a file of another kind than its name says."""
    if not logs:
        raise ValueError("no log was given: at least one drive is needed")
    config = config or ComparisonConfig()
    models.load()  # what is wrong is said before any process is started
    return Comparison(run_jobs([_Job(log, models, config) for log in logs], progress, processes), config)


def compare_on_log(log: DriveLog, models: ComparedModels, config: ComparisonConfig | None = None) -> ComparedRun:
    """One drive. ValueError if it holds no frame: no joystick or odometry, or a chair that never drives."""
    config = config or ComparisonConfig()
    chair = ChairGeometry.thesis(log.mounting)
    canvas, driven = run_map(log), _spaced_poses(log)
    asked = {name: _Asked(method, canvas) for name, method in methods(models, config, chair).items()}
    walls, seen = HeatmapMap(canvas), HeatmapMap(canvas)
    around, due = Surroundings(chair, config.map_duration), -np.inf
    for now in observations(log):
        started = time.perf_counter()
        obstacles, grid = around.see(now), around.grid(now)
        shared = time.perf_counter() - started
        if now.stamp < due or now.twist.linear < config.slowest or not any(now.joystick):
            continue
        due = now.stamp + config.period - 1e-9
        way = way_ahead(log, now.stamp, REACH + 0.5)
        for one in asked.values():
            one.ask(now, grid, obstacles, way, shared)
        walls.insert(grid.occupied_mask(), grid.data >= 0, now.pose)
        seen.insert(free_mask(grid), free_mask(grid), now.pose)
    if due == -np.inf:
        raise ValueError(f"log {log.name!r} holds no moment at which the chair drives forward by its joystick")
    state = np.where(walls.heatmap() > 0.3, 100, np.where(seen.count > 0, 0, -1)).astype(np.int8)
    shown = OccupancyGrid(state, canvas.resolution, canvas.origin)
    return ComparedRun(log.name, shown, driven, {name: one.result(driven) for name, one in asked.items()})


class _Asked:
    """A method's answers along a run."""

    def __init__(self, method: Method, canvas: OccupancyGrid) -> None:
        self.method, self.canvas, self.map = method, canvas, HeatmapMap(canvas)
        self.errors: list[tuple[float, float, float]] = []
        self.seconds: list[float] = []
        self.without_path = 0

    def ask(self, now: Observation, grid: OccupancyGrid, obstacles: ObstaclePoints, way: Floats, shared: float) -> None:
        started = time.perf_counter()
        planned = self.method.planner.plan(now, grid, obstacles)
        self.seconds.append(shared + time.perf_counter() - started)
        heat = np.zeros(grid.data.shape, np.float32) if planned is None else self.method.landscape(planned, grid)
        self.map.insert(heat, free_mask(grid), now.pose)
        self.without_path += planned is None
        self.errors.append((np.nan,) * 3 if planned is None else path_deviations(planned.path, way))

    def result(self, driven: Floats) -> MethodRun:
        heat = self.map.heatmap()
        reward, rank = reward_at(heat, self.map.count > 0, self.canvas, driven[:, :2])
        near, whole, equal = np.array(self.errors).T
        share = self.without_path / len(self.seconds)
        return MethodRun(heat, reward, rank, near, whole, equal, np.array(self.seconds), share)


def run_map(log: DriveLog) -> OccupancyGrid:
    """An empty map in the odometry's frame that holds the local window everywhere along a drive."""
    reach = np.sqrt(2) * WINDOW
    low, high = log.pose[:, :2].min(axis=0) - reach, log.pose[:, :2].max(axis=0) + reach
    width, height = (int(n) for n in np.ceil((high - low) / RESOLUTION))
    return OccupancyGrid(np.full((height, width), -1, np.int8), RESOLUTION, (float(low[0]), float(low[1])))


def _spaced_poses(log: DriveLog) -> Floats:
    way = arc_length(log.pose[:, :2])
    way = way + np.arange(len(way)) * 1e-9  # a standing chair must not repeat an abscissa
    return log.pose_at(np.interp(np.arange(0.0, way[-1], STEP), way, log.odometry_stamp))


def path_deviations(path: Floats, way: Floats) -> tuple[float, float, float]:
    """RMS [m] of a planned path (M, 2) against the way driven (N, 2), both from base_link on: deviation of its points
    from the way up to the look-ahead, up to 2.5 m, and the distance at equal arc length up to 2.5 m. Nothing is
    compared beyond the length of either but for the last, which goes on straight beyond the path's end. NaN for a way
    shorter than the look-ahead."""
    length = float(arc_length(way)[-1]) if len(way) > 1 else 0.0
    if length < LOOK_AHEAD:
        return (np.nan,) * 3
    equal = np.arange(STEP, min(REACH, length) + 1e-9, STEP)
    points = along(path, equal)
    apart = np.linalg.norm(points - along(way, equal), axis=1)
    off = distance_to_polyline(points, way)[: int((equal <= arc_length(path)[-1] + 1e-9).sum())]
    near, whole = _rms(off[: round(LOOK_AHEAD / STEP)]), _rms(off)
    return near, whole, _rms(apart)


def _rms(values: Floats) -> float:
    return float(np.sqrt((values**2).mean())) if len(values) else float("nan")


def reward_at(heat: Heatmap, seen: Mask, canvas: OccupancyGrid, positions: Floats) -> tuple[float, float]:
    """Mean reward at positions (N, 2) [m], and the mean of its percentile rank [%] among the cells seen (those equal
    count half). Positions over cells never seen count as reward 0. ValueError for a position outside the map."""
    cells = np.floor((positions - np.array(canvas.origin)) / canvas.resolution).astype(int)
    if (cells < 0).any() or (cells >= (canvas.width, canvas.height)).any():
        raise ValueError("a position lies outside the map")
    rewards, every = heat[cells[:, 1], cells[:, 0]], np.sort(heat[seen])
    if not len(every):
        return 0.0, float("nan")
    below, upto = (np.searchsorted(every, rewards, side) for side in ("left", "right"))
    return float(rewards.mean()), float(100 * ((below + upto) / 2 / len(every)).mean())
