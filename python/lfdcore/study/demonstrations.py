"""Demonstrations that studies learn from: an expert in the training courses (Sec. 3.5); able drivers with DWA in two
mazes (Sec. 4.2), and unassisted in a home that is like neither, to judge predictions by (Sec. 4.6.2)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from lfdcore.datasets import open_log
from lfdcore.progress import Progress, StageProgress, silent
from lfdcore.simulated.courses import Course, home_20x19, mazes, training_courses
from lfdcore.simulated.drivers import AbleDriver, ExpertDriver, able_population
from lfdcore.simulated.run import Job, RunConfig, run_drive
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, make_assistant, models_by_method
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, under
from lfdcore.training.drive_primitives import first_share, learn_drive
from lfdcore.wheelchair.assistants import Unassisted

HeatmapsFile = Annotated[Path | None, Option("Learned heatmaps; else learned from demonstrations, which needs torch.")]
"""The option `model` of studies that drive with heatmaps alone"""

HEATMAPS_NAME = "heatmaps.safetensors"
MAZE_RUNS, MAZE_DRIVERS = 72, 8
"""Sec. 4.2"""
HOME_DRIVERS, RUNS_EACH = 10, 3
"""Sec. 4.6.2"""

PRIMITIVES_NAME = "assistant.safetensors"
ATTEMPTS = 5
"""of an expert at a demonstration"""


def maze_seed(seed: int, run: int) -> int:
    """Of a run in the mazes; none is of one in the home (home_seed) or on a way of study learning-curve (way_seed)."""
    return 1000 * seed + run


def home_seed(seed: int, run: int) -> int:
    """Of a run to a destination in the home."""
    return maze_seed(seed, 500 + run)


def demonstrate(folder: Path, seed: int) -> list[tuple[Path, DriveTrace]]:
    """One expert run through each training course, unassisted -> drive logs in `folder` and their traces.

    An expert who touches anything or does not arrive drives again: nobody should learn from that. Raises RuntimeError
    if the last of ATTEMPTS (seeds `seed`, `seed` + 1000, ...) fails too.
    """
    courses, paths = training_courses(), demonstration_paths(folder)
    return [_demonstrated(course, path, seed) for course, path in zip(courses, paths, strict=True)]


def demonstration_paths(folder: Path) -> tuple[Path, ...]:
    """Where `demonstrate` puts its logs."""
    return tuple(folder / f"demonstration-{course.name}.mcap" for course in training_courses())


def _demonstrated(course: Course, path: Path, seed: int) -> tuple[Path, DriveTrace]:
    unassisted = Unassisted(RunConfig().geometry)
    for attempt in range(ATTEMPTS):
        trace = run_drive(course, ExpertDriver(course), unassisted, seed + 1000 * attempt, log_path=path)
        if trace.completed and not trace.collision.any():
            return path, trace
    raise RuntimeError(
        f"the last of {ATTEMPTS} demonstrations in {course.name} from seed {seed} on ended '{trace.outcome}' after "
        f"{int(trace.collision.sum())} contacts"
    )


def learn_from_demonstrations(folder: Path, seed: int, progress: Progress | None = None) -> Path:
    """Demonstrates, learns and saves the model in `folder` -> its path."""
    logs = [open_log(path) for path, _ in demonstrate(folder, seed)]
    model = learn_drive(first_share(logs), progress=progress)
    path = folder / PRIMITIVES_NAME
    model.save(path)
    return path


# -- Ch. 4 ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RecordedDrives:
    """Drive logs and what really happened, in the order of the runs. None is left out, however it ended."""

    paths: tuple[Path, ...]
    traces: tuple[DriveTrace, ...]

    @property
    def unfinished(self) -> int:
        """How many runs did not reach their destination."""
        return sum(not trace.completed for trace in self.traces)

    @property
    def collisions(self) -> int:
        """Contacts in all runs."""
        return sum(int(trace.collision.sum()) for trace in self.traces)


def demonstrate_in_mazes(
    folder: Path,
    seed: int,
    runs: int = MAZE_RUNS,
    config: RunConfig | None = None,
    processes: int | None = None,
    progress: Progress | None = None,
) -> RecordedDrives:
    """8 able drivers with DWA (horizon 1 s) through both mazes -> their logs in `folder`, 72 as in Sec. 4.2.

    The first n of 72 runs are those that `runs` = n gives; drivers and mazes take turns. Each route is driven by three
    drivers. Raises ValueError for runs outside 1..72 or a negative seed.
    """
    if not 1 <= runs <= MAZE_RUNS:
        raise ValueError(f"runs must be 1..{MAZE_RUNS}, got {runs}")
    config = config or RunConfig()
    drivers, courses = able_population(MAZE_DRIVERS, seed), mazes()
    assistant = partial(make_assistant, "dwa_1s", StudyModels(), config)
    jobs = [
        Job(
            courses[_route_of(j, len(courses))],
            partial(AbleDriver, config=drivers[j % MAZE_DRIVERS]),
            assistant,
            maze_seed(seed, j),
            config,
            path,
        )
        for j, path in enumerate(maze_paths(folder, runs))
    ]
    return _record(jobs, processes, progress)


def maze_paths(folder: Path, runs: int = MAZE_RUNS) -> tuple[Path, ...]:
    """Where `demonstrate_in_mazes` puts its logs."""
    return tuple(folder / f"maze-{j:02d}.mcap" for j in range(runs))


def learn_heatmaps_from_demonstrations(
    folder: Path,
    seed: int,
    progress: StageProgress | None = None,
    processes: int | None = None,
) -> Path:
    """Demonstrates in the mazes, learns and saves the model in `folder` -> its path. Needs torch."""
    from lfdcore.training.drive_heatmaps import learn_heatmaps

    tell = progress or silent
    drives = demonstrate_in_mazes(folder, seed, processes=processes, progress=partial(tell, "demonstrate"))
    learned = learn_heatmaps([open_log(path) for path in drives.paths], progress=tell)
    path = folder / HEATMAPS_NAME
    learned.model.save(path)
    return path


def heatmaps_or_learned(
    model: Path | None, folder: Path, seed: int, tell: StageProgress = silent, processes: int | None = None
) -> Path:
    """The file given, or that of heatmaps learned in `folder` from demonstrations. ValueError for a model of another
    method."""
    if model is None:
        folder.mkdir(parents=True, exist_ok=True)
        return learn_heatmaps_from_demonstrations(folder, seed, under(tell, "heatmaps"), processes=processes)
    if models_by_method([model]).file("heatmaps") is None:
        raise ValueError(f"{model} holds primitives, must be heatmaps (lfdcore learn drive --method heatmaps)")
    return model


def _route_of(run: int, count: int) -> int:
    """Each round of `count` runs takes every route once; from round to round other drivers have them."""
    return (7 * run + 3 * (run // count)) % count


def drive_to_destinations(
    folder: Path,
    seed: int,
    runs: int = HOME_DRIVERS * RUNS_EACH,
    config: RunConfig | None = None,
    processes: int | None = None,
    progress: Progress | None = None,
) -> RecordedDrives:
    """10 able drivers, other than those of the mazes, unassisted to 3 arbitrary destinations each in home_20x19.

    Each run has a start and a destination of its own. Raises ValueError for runs outside 1..30 or a negative seed.
    """
    if not 1 <= runs <= HOME_DRIVERS * RUNS_EACH:
        raise ValueError(f"runs must be 1..{HOME_DRIVERS * RUNS_EACH}, got {runs}")
    config = config or RunConfig()
    drivers = able_population(HOME_DRIVERS, home_seed(seed, 0))
    assistant = partial(make_assistant, "none", StudyModels(), config)
    jobs = [
        Job(
            home_20x19(home_seed(seed, k)),
            partial(AbleDriver, config=drivers[k % HOME_DRIVERS]),
            assistant,
            home_seed(seed, k),
            config,
            folder / f"home-{k:02d}.mcap",
        )
        for k in range(runs)
    ]
    return _record(jobs, processes, progress)


def _record(jobs: list[Job], processes: int | None, progress: Progress | None) -> RecordedDrives:
    traces = run_jobs(jobs, progress, processes)
    return RecordedDrives(tuple(job.log_path for job in jobs if job.log_path is not None), traces)
