"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import SeedOption

if TYPE_CHECKING:
    from lfdcore.cli.common import Stages
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.study.arms import StudyModels
    from lfdcore.study.report.page import Section
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
    from lfdcore.cli.study import DrivingPlan, drive_and_report

    plan = DrivingPlan(output, (), "standard_course", "none,dwa,primitives,heatmaps", drivers, starts, seed)
    command = f"lfdcore demo --drivers {drivers} --task-starts {starts} --seed {seed}"
    drive_and_report(plan, partial(_sections, output, seed), command).print_tables()


def _sections(output: Path, seed: int, study: StudyModels, tell: Stages) -> list[Section]:
    """Heatmaps a posteriori (Sec. 4.6.2), and a prediction along a real log."""
    return [*_a_posteriori(output, seed, study, tell), *_real_section(study)]


def _a_posteriori(output: Path, seed: int, study: StudyModels, tell: Stages) -> list[Section]:
    """Table 4.2 and the stages of heatmaps: every method learns from the same drives through the mazes."""
    from lfdcore.datasets import open_log
    from lfdcore.study.heatmaps.comparison import ModelFiles, learn_rivals
    from lfdcore.study.heatmaps.report import a_posteriori_sections

    heatmaps = study.file("heatmaps")
    if heatmaps is None:
        return []
    mazes = sorted(output.glob("maze-*.mcap"))
    told = tell.under("a posteriori")
    primitives, naive = learn_rivals(output, [open_log(path) for path in mazes], told)
    return a_posteriori_sections(output, ModelFiles(primitives, naive, heatmaps), mazes, seed, told)


def _real_section(study: StudyModels) -> list[Section]:
    """A prediction along a real log, if there is one at hand."""
    from lfdcore.pictures.style import Picture
    from lfdcore.study.driving.tables import prediction_table
    from lfdcore.study.prediction.picture import prediction_figure
    from lfdcore.study.prediction.study import predict_log
    from lfdcore.study.report.page import Section
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

    title = "Prediction along a real log"
    path = real_log()
    if path is None:
        return [Section(title, f"None at hand: neither $LFDCORE_DATA/{FREIBURG} nor {SENA} (Debian's mrpt-common).")]
    log, models = _judged(path)
    primitives = study.file("primitives")
    if primitives is not None:
        models["simulated home"] = DriveAssistantModel.load(primitives)
    prediction = predict_log(log, {name: model.predictor() for name, model in models.items()})
    caption = (
        f"As Fig. 3.16, {path.name}: map accumulated from the scans by odometry; predicted paths green where the later "
        "input complied, orange-red where not."
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
