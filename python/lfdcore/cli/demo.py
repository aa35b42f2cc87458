"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import SeedOption

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.study.arms import StudyModels
    from lfdcore.study.driving.study import DrivingStudy
    from lfdcore.study.report.page import Section
    from lfdcore.study.study import Findings, Progress
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

FREIBURG = Path("logs/freiburg-079-corrected.log.gz")
"""The log in the folder that LFDCORE_DATA names."""

SENA = Path("/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog")
"""The robotic wheelchair's log in Debian's package mrpt-common."""


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report and what led to it.")] = Path(
        "demo"
    ),
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    starts: Annotated[int, typer.Option("--task-starts", min=0, help="Starts of each task; 0: no tasks.")] = 20,
    seed: SeedOption = 1,
) -> None:
    """Demonstrations in simulated places -> learned assistants -> a course never seen, with and without them."""
    from lfdcore.cli.study import run_study
    from lfdcore.study.driving.study import DrivingStudy

    study = DrivingStudy(drivers=drivers, starts=starts, seed=seed)
    command = f"lfdcore demo --drivers {drivers} --task-starts {starts} --seed {seed}"
    run_study(study, _run, output, as_json=False, command=command)


def _run(study: DrivingStudy, folder: Path, tell: Progress) -> Findings:
    """The driving study, then heatmaps a posteriori (Sec. 4.6.2) and a prediction along a real log."""
    from lfdcore.study.driving.report import findings
    from lfdcore.study.driving.study import run_driving_study

    result = run_driving_study(study, folder, tell)
    models = result.courses.plan.models
    more = [*_a_posteriori(folder, study.seed, models, tell), *_real_section(models)]
    found = findings(result)
    return replace(found, sections=[*found.sections, *more])


def _a_posteriori(output: Path, seed: int, study: StudyModels, tell: Progress) -> list[Section]:
    """Table 4.2 and the stages of heatmaps: every method learns from the same drives through the mazes."""
    from lfdcore.datasets import open_log
    from lfdcore.study.heatmaps.comparison import ModelFiles, learn_rivals
    from lfdcore.study.heatmaps.report import a_posteriori_sections
    from lfdcore.study.study import under

    if study.heatmaps is None:
        return []
    mazes = sorted(output.glob("maze-*.mcap"))
    told = under("a posteriori", tell)
    primitives, naive = learn_rivals(output, [open_log(path) for path in mazes], told)
    return a_posteriori_sections(output, ModelFiles(primitives, naive, study.heatmaps), mazes, seed, told)


def _real_section(study: StudyModels) -> list[Section]:
    """A prediction along a real log, if there is one at hand."""
    from lfdcore.pictures.style import Picture
    from lfdcore.study.prediction.picture import prediction_figure
    from lfdcore.study.prediction.study import predict_log
    from lfdcore.study.prediction.tables import prediction_table
    from lfdcore.study.report.page import Section
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

    title = "Prediction along a real log"
    path = real_log()
    if path is None:
        return [Section(title, f"None at hand: neither $LFDCORE_DATA/{FREIBURG} nor {SENA} (Debian's mrpt-common).")]
    log, models = _judged(path)
    if study.primitives is not None:
        models["simulated home"] = DriveAssistantModel.load(study.primitives)
    prediction = predict_log(log, models)
    caption = (
        f"As Fig. 3.16, {path.name}: map accumulated from the scans by odometry; predicted paths green where the later "
        "input complied, orange where not."
    )
    picture = Picture(prediction_figure([prediction]), caption)
    return [Section(title, "A real robot's log, not simulated.", [prediction_table(prediction)], [picture])]


def _judged(path: Path) -> tuple[DriveLog, dict[str, DriveAssistantModel]]:
    """What to predict on: the rest of a log long enough to learn from its first 70 %, else all of it."""
    from lfdcore.datasets import open_log
    from lfdcore.study.prediction.study import SHARE
    from lfdcore.training.drive_primitives import first_share, learn_drive

    log = open_log(path)
    if path == SENA:
        return log, {}
    return log.share(SHARE, 1.0), {f"its first {100 * SHARE:.0f} %": learn_drive(first_share([log], SHARE))}


def real_log() -> Path | None:
    """A real log at hand: of LFDCORE_DATA, or the one in Debian's mrpt-common."""
    folder = os.environ.get("LFDCORE_DATA")
    places = ([Path(folder) / FREIBURG] if folder else []) + [SENA]
    return next((place for place in places if place.exists()), None)
