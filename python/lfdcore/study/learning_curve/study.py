"""How much demonstration is enough (Sec. 6.2.1): both methods learned from the first n of the 72 runs in the mazes.

Judged in home_20x19, a test world that is like neither maze (docs/courses.md). Its ways are short (10-30 m) and drawn
from a seed, so that each simulated driver has a way of its own and the figures are no one route's:
- *closed loop*: impaired drivers, each with the same way and noise for every n and method, and unassisted beside;
- *a posteriori*: able drivers, unassisted, to 30 destinations: the path predicted at a scan against the one driven
  (study/prediction/path_error.py), the mean over a run being one value. Primitives predict by PathPredictor, heatmaps
  by ProductPredictor: what is planned over (`driver_sd`: docs/heatmaps.md).

Networks learn for as many steps as they take on 72 runs, within `most_epochs`, and keep their best epoch: with a fixed
number of epochs few runs would mean few steps too, and the curve would show that.

Models lie in `folder`/seed-S, by n: a second study finds them. Delete the folder to learn anew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lfdcore.datasets import DriveLog, open_log
from lfdcore.simulated.courses import home_20x19
from lfdcore.simulated.drivers import population
from lfdcore.simulated.run import Job, RunConfig
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, impaired_driver, make_assistant, planners, simulated_chair
from lfdcore.study.demonstrations import (
    HOME_DRIVERS,
    MAZE_RUNS,
    RUNS_EACH,
    demonstrate_in_mazes,
    drive_to_destinations,
)
from lfdcore.study.driving.study import metric_rows
from lfdcore.study.jobs import run_jobs
from lfdcore.study.prediction.path_error import (
    REACH,
    Array,
    PathSamples,
    constant_arc,
    path_errors,
    path_samples,
    straight,
)
from lfdcore.study.prediction.study import ARC_ON, STRAIGHT, predicted_paths
from lfdcore.study.report.statistics import Summary, poisson_rate, proportion, summarise
from lfdcore.training.drive_primitives import first_share, learn_drive
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.prediction import ProductPredictor
from lfdcore.wheelchair.method import Predictor
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

if TYPE_CHECKING:
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig

Progress = Callable[[str, int, int], None]
"""Called with (stage, done, total)"""
Predict = Callable[[DriveLog, PathSamples], Array]
"""The paths (N, 25, 2) [m] predicted at samples of a log."""

METHODS = ("primitives", "heatmaps")
NOBODY = "none"
_SEEDS, _FIRST_WAY = 1000, 600
"""Way and noise of driver k are of seed 1000 `seed` + 600 + k, which no demonstration and no other run has."""


@dataclass(frozen=True, kw_only=True)
class LearningCurveStudy:
    """What is learned and how it is judged. ValueError for runs that are not increasing within 1..72 and others."""

    folder: Path
    runs: tuple[int, ...] = (5, 10, 20, 40, MAZE_RUNS)
    drivers: int = 10
    """impaired ones, in the closed loop"""
    predicted: int = HOME_DRIVERS * RUNS_EACH
    """runs of able drivers, for predictions"""
    every: int = 10
    """of so many samples of a log one is predicted"""
    epochs: int = 10
    """of the network on 72 runs"""
    most_epochs: int = 40
    seed: int = 1
    run: RunConfig = field(default_factory=RunConfig)

    def __post_init__(self) -> None:
        ends = (0, *self.runs, MAZE_RUNS + 1)
        if not self.runs or any(b <= a for a, b in pairwise(ends)):
            raise ValueError(f"runs are {self.runs}, must be increasing numbers within 1..{MAZE_RUNS}")
        for name in ("drivers", "every", "epochs", "most_epochs"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1")
        if not 1 <= self.predicted <= HOME_DRIVERS * RUNS_EACH:
            raise ValueError(f"predicted is {self.predicted} runs, must be 1..{HOME_DRIVERS * RUNS_EACH}")

    @property
    def models(self) -> Path:
        """Where models and logs lie."""
        return self.folder / f"seed-{self.seed}"

    def epochs_of(self, runs: int) -> int:
        """Epochs on so many runs: as many steps as on 72, within `most_epochs`."""
        return min(self.most_epochs, round(self.epochs * MAZE_RUNS / runs))

    def model_files(self, runs: int) -> StudyModels:
        """Of the models learned from so many runs."""
        end = f"{runs:02d}.safetensors"
        of_epochs = self.models / f"heatmaps-{self.epochs_of(runs)}-epochs-{end}"
        return StudyModels(primitives=self.models / f"primitives-{end}", heatmaps=of_epochs)


@dataclass(frozen=True)
class CurvePoint:
    """What a method is worth after so many runs (0: unassisted)."""

    demonstrations: int
    method: str
    completed: tuple[int, int]
    """runs that arrived, of how many"""
    contacts: int
    path_rmse: Summary
    """[m] over drivers: of path points that complied against the way driven (study/driving/metrics.py)"""
    jerk_ratio: Summary
    """angular jerk over the same driver's unassisted run, over drivers who completed both"""
    time_ratio: Summary
    """time taken, likewise"""
    path_error: Summary
    """[m] over runs: mean error up to 2.5 m of the predicted path"""

    @property
    def contact_rate(self) -> tuple[float, float, float]:
        """Contacts a run, with Garwood's interval."""
        return poisson_rate(self.contacts, self.completed[1])

    @property
    def completion(self) -> tuple[float, float, float]:
        """Share of runs that arrived, with Wilson's interval."""
        return proportion(*self.completed)


@dataclass(frozen=True)
class LearningCurve:
    """All runs, and what is made of them."""

    study: LearningCurveStudy
    rows: tuple[dict[str, Any], ...]
    """one a run: demonstrations (0: unassisted), and what metric_rows has"""
    errors: tuple[dict[str, Any], ...]
    """one a log and model (or baseline: of 0 demonstrations): demonstrations, method, log, samples, error [m]"""

    def points(self) -> list[CurvePoint]:
        """Unassisted, then each method by the number of runs."""
        return [self._point(0, NOBODY), *(self._point(n, m) for m in METHODS for n in self.study.runs)]

    def baseline(self) -> tuple[str, Summary]:
        """The better of straight on and a constant arc, and its error [m] over runs."""
        found = {name: self._errors_of(0, name) for name in (STRAIGHT, ARC_ON)}
        return min(found.items(), key=lambda item: item[1].mean)

    def _errors_of(self, demonstrations: int, method: str) -> Summary:
        wanted = (demonstrations, method)
        return summarise([e["error"] for e in self.errors if (e["demonstrations"], e["method"]) == wanted])

    def _of(self, demonstrations: int, method: str) -> list[dict[str, Any]]:
        wanted = (demonstrations, method)
        return [row for row in self.rows if (row["demonstrations"], row["assistant"]) == wanted]

    def _point(self, demonstrations: int, method: str) -> CurvePoint:
        rows, alone = self._of(demonstrations, method), self._of(0, NOBODY)
        both = [(a, b) for a, b in zip(alone, rows, strict=True) if a["completed"] and b["completed"]]
        return CurvePoint(
            demonstrations,
            method,
            (sum(row["completed"] for row in rows), len(rows)),
            sum(row["collisions"] for row in rows),
            summarise([row.get("path_rmse", np.nan) for row in rows]),
            summarise([b["angular_jerk"] / a["angular_jerk"] for a, b in both]),
            summarise([b["time"] / a["time"] for a, b in both]),
            self._errors_of(demonstrations, method),
        )


def run_learning_curve(
    study: LearningCurveStudy, progress: Progress | None = None, processes: int | None = None
) -> LearningCurve:
    """Learns what is not in the folder yet (needs torch), drives and predicts; the result does not depend on the
    number of processes."""
    tell = progress or (lambda stage, done, total: None)
    study.models.mkdir(parents=True, exist_ok=True)
    learn_curve_models(study, tell, processes)
    rows = _drive(study, partial(tell, "drive a home never seen"), processes)
    return LearningCurve(study, tuple(rows), tuple(_predict(study, tell, processes)))


# -- learning -------------------------------------------------------------------------------------------------------


def learn_curve_models(study: LearningCurveStudy, tell: Progress, processes: int | None = None) -> None:
    """Both models of each number of runs, where there are none yet."""
    files = {n: study.model_files(n) for n in study.runs}
    missing = [n for n in study.runs if not all(_file(files[n], method).exists() for method in METHODS)]
    if not missing:
        return
    drives = demonstrate_in_mazes(
        study.models, study.seed, missing[-1], study.run, processes, partial(tell, "demonstrate")
    )
    logs = [open_log(path) for path in drives.paths]
    for done, n in enumerate(missing):
        tell("learn", done, len(missing))
        _learn(study, logs[:n], files[n], tell)
    tell("learn", len(missing), len(missing))


def _file(models: StudyModels, method: str) -> Path:
    path = models.file(method)
    assert path is not None
    return path


def _learn(study: LearningCurveStudy, logs: Sequence[DriveLog], files: StudyModels, tell: Progress) -> None:
    from lfdcore.training.drive_heatmaps import learn_heatmaps

    if not _file(files, "primitives").exists():
        learn_drive(first_share(logs)).save(_file(files, "primitives"))
    if not _file(files, "heatmaps").exists():
        stages = {"targets": f"targets of {len(logs)} runs", "network": f"network of {len(logs)} runs"}
        config = _heatmap_config(study.epochs_of(len(logs)))
        learned = learn_heatmaps(logs, config, lambda stage, done, total: tell(stages[stage], done, total))
        learned.model.save(_file(files, "heatmaps"))


def _heatmap_config(epochs: int) -> HeatmapLearningConfig:
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig
    from lfdcore.training.parts.heatmap_net import HeatmapNetConfig

    return HeatmapLearningConfig(network=HeatmapNetConfig(epochs=epochs, patience=epochs))


# -- closed loop ----------------------------------------------------------------------------------------------------


def _drive(
    study: LearningCurveStudy, progress: Callable[[int, int], None], processes: int | None
) -> list[dict[str, Any]]:
    groups = [(0, NOBODY, StudyModels())]
    groups += [(n, method, study.model_files(n)) for n in study.runs for method in METHODS]
    jobs = [job for _, method, models in groups for job in _jobs(study, method, models)]
    traces = run_jobs(jobs, progress, processes)
    rows = []
    for g, (n, method, models) in enumerate(groups):
        of_group = traces[g * study.drivers : (g + 1) * study.drivers]
        rows += [{"demonstrations": n, **row} for row in _judged(study, method, models, of_group)]
    return rows


def _jobs(study: LearningCurveStudy, method: str, models: StudyModels) -> list[Job]:
    first = _SEEDS * study.seed + _FIRST_WAY
    return [
        Job(
            home_20x19(first + k),
            partial(impaired_driver, config),
            partial(make_assistant, method, models, study.run),
            first + k,
            study.run,
        )
        for k, config in enumerate(population(study.drivers, study.seed))
    ]


def _judged(
    study: LearningCurveStudy, method: str, models: StudyModels, traces: Sequence[DriveTrace]
) -> list[dict[str, Any]]:
    return metric_rows(traces, planners([method], models, study.run))


# -- a posteriori ---------------------------------------------------------------------------------------------------


def _predict(study: LearningCurveStudy, tell: Progress, processes: int | None) -> list[dict[str, Any]]:
    drives = drive_to_destinations(
        study.models, study.seed, study.predicted, study.run, processes, partial(tell, "drive to destinations")
    )
    judged = [(log, _thinned(path_samples(log), study.every)) for log in map(open_log, drives.paths)]
    judged = [(log, samples) for log, samples in judged if len(samples)]
    rows: list[dict[str, Any]] = []
    found = [(0, STRAIGHT), (0, ARC_ON), *((n, method) for n in study.runs for method in METHODS)]
    for done, (n, method) in enumerate(found):
        tell("predict paths", done, len(found))
        predict = _baselines()[method] if n == 0 else _with_model(study, n, method)
        for log, samples in judged:
            error = float(path_errors(predict(log, samples), samples.driven, REACH).mean())
            what = {"demonstrations": n, "method": method, "log": log.name, "samples": len(samples)}
            rows.append({**what, "error": error})
    tell("predict paths", len(found), len(found))
    return rows


def _thinned(samples: PathSamples, every: int) -> PathSamples:
    return PathSamples(samples.scan[::every], samples.velocity[::every], samples.driven[::every])


def _baselines() -> dict[str, Predict]:
    return {
        STRAIGHT: lambda log, samples: straight(samples.velocity),
        ARC_ON: lambda log, samples: constant_arc(samples.velocity),
    }


def _with_model(study: LearningCurveStudy, runs: int, method: str) -> Predict:
    predictor = _predictor(study, runs, method)
    return lambda log, samples: predicted_paths(predictor, log, samples)[0]


def _predictor(study: LearningCurveStudy, runs: int, method: str) -> Predictor:
    file = _file(study.model_files(runs), method)
    if method == "primitives":
        return DriveAssistantModel.load(file).predictor()
    return ProductPredictor(HeatmapModel.load(file).planner(simulated_chair(study.run)))
