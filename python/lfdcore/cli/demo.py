"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import SeedOption

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lfdcore.cli.common import Stages
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.study.arms import StudyModels
    from lfdcore.study.report.page import Section
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

FREIBURG = Path("logs/freiburg-079-corrected.log.gz")
"""The log in the folder that LFDCORE_DATA names."""

SENA = Path("/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog")
"""The robotic wheelchair's log in Debian's package mrpt-common."""

SHIPPED = (
    "The models were not learned in this run. They come with lfdcore, learned from demonstrations of seed {seed} "
    "(docs/models.md). These demonstrations were driven again, for the pictures and the comparison below. lfdcore demo "
    "--train learns the models from demonstrations of the run's own seed instead."
)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report and what led to it.")] = Path(
        "demo"
    ),
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    starts: Annotated[int, typer.Option("--task-starts", min=0, help="Starts of each task; 0: no tasks.")] = 20,
    train: Annotated[
        bool,
        typer.Option("--train", help="Learn the models from demonstrations of this seed. Needs the extra 'train'."),
    ] = False,
    seed: SeedOption = 1,
) -> None:
    """Demonstrations in simulated places -> learned assistants -> a course never seen, with and without them.

    The models come with lfdcore, learned from demonstrations of seed 1, unless --train is given.
    """
    from lfdcore.cli.study import DrivingPlan, drive_and_report
    from lfdcore.models import HEATMAPS, PRIMITIVES

    models = () if train else (PRIMITIVES, HEATMAPS)
    plan = DrivingPlan(output, models, "standard_course", "none,dwa,primitives,heatmaps", drivers, starts, seed)
    command = f"lfdcore demo --drivers {drivers} --task-starts {starts} --seed {seed}" + (" --train" if train else "")
    more = _of_trained_models if train else _of_shipped_models
    drive_and_report(plan, partial(more, output, seed), command).print_tables()


def _of_trained_models(output: Path, seed: int, study: StudyModels, tell: Stages) -> list[Section]:
    """The naive network learns from the demonstrations that the heatmaps were learned from."""
    from lfdcore.datasets import open_log
    from lfdcore.study.heatmaps.comparison import learn_naive

    mazes = sorted(output.glob("maze-*.mcap"))
    naive = learn_naive(output, [open_log(path) for path in mazes], tell.under("a posteriori"))
    return _sections(output, seed, study, naive, mazes, tell)


def _of_shipped_models(output: Path, seed: int, study: StudyModels, tell: Stages) -> list[Section]:
    """What the models were learned from is driven again, for the pictures and for the comparison."""
    from lfdcore.datasets import open_log
    from lfdcore.models import NAIVE, PRIMITIVES, SEED
    from lfdcore.study.demonstrations import demonstrate, demonstrate_in_mazes
    from lfdcore.study.driving.report import stage_section
    from lfdcore.study.report.page import Section
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

    demonstrations = [open_log(path) for path, _ in demonstrate(output, SEED)]
    mazes = demonstrate_in_mazes(output, SEED, progress=tell.step("demonstrations of heatmaps")).paths
    origin = Section("Where the models come from", SHIPPED.format(seed=SEED))
    stages = stage_section(DriveAssistantModel.load(PRIMITIVES), demonstrations)
    return [origin, stages, *_sections(output, seed, study, NAIVE, mazes, tell)]


def _sections(
    output: Path, seed: int, study: StudyModels, naive: Path, mazes: Sequence[Path], tell: Stages
) -> list[Section]:
    """Heatmaps a posteriori (Sec. 4.6.2), and a prediction along a real log."""
    return [*_a_posteriori(output, seed, study, naive, mazes, tell), *_real_section(study)]


def _a_posteriori(
    output: Path, seed: int, study: StudyModels, naive: Path, mazes: Sequence[Path], tell: Stages
) -> list[Section]:
    """Table 4.2 and the stages of heatmaps: every method learned from the same drives through the mazes."""
    from lfdcore.datasets import open_log
    from lfdcore.study.heatmaps.comparison import ModelFiles, learn_rival_primitives
    from lfdcore.study.heatmaps.report import a_posteriori_sections

    if study.heatmaps is None:
        return []
    progress = tell.under("a posteriori")
    primitives = learn_rival_primitives(output, [open_log(path) for path in mazes], progress)
    return a_posteriori_sections(output, ModelFiles(primitives, naive, study.heatmaps), mazes, seed, progress)


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
    if study.primitives is not None:
        models["simulated home"] = DriveAssistantModel.load(study.primitives)
    prediction = predict_log(log, models)
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
