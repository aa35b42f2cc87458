"""The drives of Ch. 2: able drivers, unassisted, six times to each destination; the sixth of each is held out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets import DriveLog, open_log
from lfdcore.geometry import wrap_angle
from lfdcore.progress import Progress
from lfdcore.simulated.courses import GoalWorld, goal_building
from lfdcore.simulated.drivers import AbleDriver, able_population
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.study.demonstrations import RecordedDrives
from lfdcore.study.jobs import run_jobs
from lfdcore.wheelchair.assistants import Unassisted

Array = NDArray[np.float64]

RUNS_EACH = 6
"""drives to each destination (Sec. 2.2)"""
SEED = 2
"""of all drives that are reported, and of their study; chosen before any model was learned from them"""
MOST_NOISE = 100.0
"""[%] of full scale"""


@dataclass(frozen=True)
class GoalDrives(RecordedDrives):
    """Recorded drives to a world's destinations, in the order of destinations and runs.

    destinations, runs: of each drive, the goal's name and which of the RUNS_EACH it is.
    """

    world: GoalWorld
    destinations: tuple[str, ...]
    runs: tuple[int, ...]

    @property
    def training(self) -> tuple[int, ...]:
        """Indices of the drives to learn from: all but the last to each destination."""
        return tuple(k for k, run in enumerate(self.runs) if run < RUNS_EACH - 1)

    @property
    def held_out(self) -> tuple[int, ...]:
        """Indices of the last drive to each destination."""
        return tuple(k for k, run in enumerate(self.runs) if run == RUNS_EACH - 1)

    @property
    def drivers(self) -> tuple[int, ...]:
        """Which of the RUNS_EACH drivers sits in each drive."""
        index = self.world.goals.index
        return tuple(_driver_of(index(name), run) for name, run in zip(self.destinations, self.runs, strict=True))

    def samples(self, indices: Sequence[int]) -> int:
        """Ticks at 10 Hz in these drives."""
        return sum(len(self.traces[k].stamp) for k in indices)

    def logs(self, indices: Sequence[int]) -> list[DriveLog]:
        """Opens these drives' logs."""
        return [open_log(self.paths[k]) for k in indices]


def record_goal_drives(
    folder: Path,
    world: GoalWorld | None = None,
    seed: int = SEED,
    config: RunConfig | None = None,
    processes: int | None = None,
    progress: Progress | None = None,
) -> GoalDrives:
    """Six able drivers, unassisted, once each to every destination of a world (default: the building of Ch. 2).

    Logs in `folder` hold the destination's name (metadata `destination`) and the true pose in the map. In run r to the
    g-th destination sits driver (r + g) mod 6: each drives to all, and the held-out drives are of different drivers.
    The same seed gives the same drives. Raises ValueError for a negative seed.
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    world, config = world or goal_building(), config or RunConfig()
    drivers = able_population(RUNS_EACH, seed)
    which = [(g, run) for g in range(len(world.goals)) for run in range(RUNS_EACH)]
    unassisted = partial(Unassisted, config.geometry)
    jobs = []
    for g, run in which:
        name, number = world.goals.names[g], 1000 * seed + RUNS_EACH * g + run
        make_driver = partial(AbleDriver, config=drivers[_driver_of(g, run)])
        path = folder / f"goal-{g + 1}-{run + 1}.mcap"
        jobs.append(Job(world.course(name, number), make_driver, unassisted, number, config, path, name))
    traces = run_jobs(jobs, progress, processes)
    paths = tuple(job.log_path for job in jobs if job.log_path is not None)
    names = tuple(world.goals.names[g] for g, _ in which)
    return GoalDrives(paths, traces, world, names, tuple(run for _, run in which))


def _driver_of(goal: int, run: int) -> int:
    return (run + goal) % RUNS_EACH


# -- what goes wrong at run time ------------------------------------------------------------------------------------


def noisy_joystick(joystick: ArrayLike, sigma: float, seed: int) -> Array:
    """Joystick (N, 2) with zero-mean Gaussian noise of `sigma` [% of full scale] on both axes (Table 2.1) -> (N, 2).

    Each axis ends at full scale, as a stick does: beyond -1 and 1 the noise is cut off, so that near full deflection
    its mean is not zero. The samples depend on the seed alone, so a larger sigma is the same noise, louder. Raises
    ValueError for another shape, values outside [-1, 1] or that are not finite, a sigma outside [0, 100] %, a negative
    seed.
    """
    given = np.asarray(joystick, float)
    if given.ndim != 2 or given.shape[1] != 2:
        raise ValueError(f"joystick has shape {given.shape}, must be (N, 2)")
    if not (np.abs(given) <= 1 + 1e-6).all():
        raise ValueError("joystick must be finite and lie in [-1, 1]")
    if not 0 <= sigma <= MOST_NOISE:
        raise ValueError(f"sigma must lie in [0, {MOST_NOISE:g}] % of full scale, got {sigma} %")
    noise = np.random.default_rng([_NOISE, _checked(seed)]).standard_normal(given.shape)
    return np.asarray(np.clip(given + sigma / 100 * noise, -1.0, 1.0))


def perturbed_poses(poses: ArrayLike, position: float, heading: float, seed: int) -> Array:
    """Poses (N, 3) of one drive as a localiser that is off would give them -> (N, 3).

    The error is of exactly this size, `position` [m] and `heading` [rad], and the same all along the drive: errors of
    a localiser last. Its direction and the side of the heading come from the seed. Raises ValueError for another shape,
    poses that are not finite, sizes that are negative or not finite, a negative seed.
    """
    given = np.asarray(poses, float)
    if given.ndim != 2 or given.shape[1] != 3:
        raise ValueError(f"poses has shape {given.shape}, must be (N, 3)")
    if not np.isfinite(given).all():
        raise ValueError("poses must be finite")
    for name, size, unit in (("position", position, "m"), ("heading", heading, "rad")):
        if not (math.isfinite(size) and size >= 0):
            raise ValueError(f"{name} must be finite and >= 0 {unit}, got {size} {unit}")
    rng = np.random.default_rng([_OFF, _checked(seed)])
    direction, side = rng.uniform(-np.pi, np.pi), rng.choice((-1.0, 1.0))
    off = given + np.array([position * np.cos(direction), position * np.sin(direction), side * heading])
    return np.column_stack([off[:, :2], wrap_angle(off[:, 2])])


_NOISE, _OFF = 0x60A3, 0x60A4
"""Streams of random numbers."""


def _checked(seed: int) -> int:
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    return seed
