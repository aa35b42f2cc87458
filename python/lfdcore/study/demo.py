"""The demo: the driving study in one course, heatmaps a posteriori (Sec. 4.6.2), a prediction along a real log."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.models import HEATMAPS, NAIVE, PRIMITIVES, SEED
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study import demonstrations
from lfdcore.study.arms import StudyModels
from lfdcore.study.driving.report import findings, stage_section
from lfdcore.study.driving.study import DrivingStudy, run_driving_study
from lfdcore.study.heatmaps.comparison import ModelFiles, learn_naive, learn_rival_primitives
from lfdcore.study.heatmaps.report import a_posteriori_sections
from lfdcore.study.prediction.picture import prediction_figure
from lfdcore.study.prediction.study import SHARE, predict_log
from lfdcore.study.prediction.tables import prediction_table
from lfdcore.study.report.page import Section
from lfdcore.study.study import Findings, under
from lfdcore.training.drive_primitives import first_share, learn_drive
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

FREIBURG = Path("logs/freiburg-079-corrected.log.gz")
"""The log in the folder that LFDCORE_DATA names."""

SENA = Path("/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog")
"""The robotic wheelchair's log in Debian's package mrpt-common."""

SHIPPED = (
    f"The models were not learned in this run. They come with lfdcore, learned from demonstrations of seed {SEED} "
    "(docs/models.md). These demonstrations were driven again, for the pictures and the comparison below. lfdcore demo "
    "--train learns the models from demonstrations of the run's own seed instead."
)


@dataclass(frozen=True, kw_only=True)
class DemoStudy(DrivingStudy):
    """A driving study that another command makes."""

    def command(self) -> str:
        """What repeats the demo."""
        size = f"--drivers {self.drivers} --task-starts {self.starts} --seed {self.seed}"
        return f"lfdcore demo {size}" if self.models else f"lfdcore demo {size} --train"


def demo_study(drivers: int, starts: int, seed: int, *, train: bool) -> DemoStudy:
    """The demo's models are those of the package unless they are to be trained."""
    models = () if train else (PRIMITIVES, HEATMAPS)
    return DemoStudy(models=models, drivers=drivers, starts=starts, seed=seed)


def run(study: DemoStudy, folder: Path, tell: StageProgress) -> Findings:
    """Everything that the demo shows. Needs the extra 'train' where the study has no models."""
    result = run_driving_study(study, folder, tell)
    models = result.courses.plan.models
    more = _of_shipped_models if study.models else _of_trained_models
    found = findings(result)
    return replace(found, sections=[*found.sections, *more(study.seed, folder, models, tell), *_real_section(models)])


def _of_trained_models(seed: int, folder: Path, models: StudyModels, tell: StageProgress) -> list[Section]:
    """The naive network learns from the demonstrations that the heatmaps were learned from."""
    mazes = demonstrations.maze_paths(folder)
    naive = learn_naive(folder, [open_log(path) for path in mazes], under(tell, "a posteriori"))
    return _a_posteriori(seed, folder, models, naive, mazes, tell)


def _of_shipped_models(seed: int, folder: Path, models: StudyModels, tell: StageProgress) -> list[Section]:
    """What the models were learned from is driven again, for the pictures and for the comparison."""
    logs = [open_log(path) for path, _ in demonstrations.demonstrate(folder, SEED)]
    report = partial(tell, "demonstrations of heatmaps")
    mazes = demonstrations.demonstrate_in_mazes(folder, SEED, progress=report).paths
    stages = stage_section(DriveAssistantModel.load(PRIMITIVES), logs)
    origin = Section("Where the models come from", SHIPPED)
    return [origin, stages, *_a_posteriori(seed, folder, models, NAIVE, mazes, tell)]


def _a_posteriori(
    seed: int, folder: Path, models: StudyModels, naive: Path, mazes: Sequence[Path], tell: StageProgress
) -> list[Section]:
    """Table 4.2 and the stages of heatmaps: every method learned from the same drives through the mazes."""
    heatmaps = models.file("heatmaps")
    if heatmaps is None:
        return []
    progress = under(tell, "a posteriori")
    primitives = learn_rival_primitives(folder, [open_log(path) for path in mazes], progress)
    return a_posteriori_sections(folder, ModelFiles(primitives, naive, heatmaps), mazes, seed, progress)


def _real_section(models: StudyModels) -> list[Section]:
    """A prediction along a real log, if there is one at hand."""
    title, path = "Prediction along a real log", real_log()
    if path is None:
        return [Section(title, f"None at hand: neither $LFDCORE_DATA/{FREIBURG} nor {SENA} (Debian's mrpt-common).")]
    log, predicting = _judged(path)
    primitives = models.file("primitives")
    if primitives is not None:
        predicting["simulated home"] = DriveAssistantModel.load(primitives)
    prediction = predict_log(log, {name: model.predictor() for name, model in predicting.items()})
    caption = (
        f"As Fig. 3.16, {path.name}: map accumulated from the scans by odometry; predicted paths green where the later "
        "input complied, orange where not."
    )
    picture = Picture(prediction_figure([prediction]), caption)
    return [Section(title, "A real robot's log, not simulated.", [prediction_table(prediction)], [picture])]


def _judged(path: Path) -> tuple[DriveLog, dict[str, DriveAssistantModel]]:
    """What to predict on: the rest of a log long enough to learn from its first 70 %, else all of it."""
    log = open_log(path)
    if path == SENA:
        return log, {}
    return log.share(SHARE, 1.0), {f"its first {100 * SHARE:.0f} %": learn_drive(first_share([log], SHARE))}


def real_log() -> Path | None:
    """A real log at hand: of LFDCORE_DATA, or the one in Debian's mrpt-common."""
    folder = os.environ.get("LFDCORE_DATA")
    places = ([Path(folder) / FREIBURG] if folder else []) + [SENA]
    return next((place for place in places if place.exists()), None)
