"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import SeedOption

if TYPE_CHECKING:
    from lfdcore.study.report import Section

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
    """Demonstrations in a simulated home -> a learned assistant -> a course never seen, with and without it."""
    from lfdcore.cli.study import DrivingPlan, drive_and_report

    plan = DrivingPlan(output, None, "standard_course", "none,dwa,primitives", drivers, starts, seed)
    drive_and_report(plan, _real_section).print_tables()


def _real_section(model: Path) -> list[Section]:
    """A prediction along a real log, if there is one at hand."""
    from lfdcore.cli.common import open_with_joystick
    from lfdcore.study.prediction_plots import prediction_picture
    from lfdcore.study.report import Section
    from lfdcore.wheelchair.model_file import DriveAssistantModel

    log = real_log()
    if log is None:
        text = f"None at hand: set LFDCORE_DATA, or install Debian's mrpt-common ({SENA})."
        return [Section("Prediction along a real log", text)]
    picture = prediction_picture(DriveAssistantModel.load(model), open_with_joystick(log), origin=log.name)
    return [Section("Prediction along a real log", pictures=[picture])]


def real_log() -> Path | None:
    """A real log at hand: of LFDCORE_DATA, or the one in Debian's mrpt-common."""
    folder = os.environ.get("LFDCORE_DATA")
    if folder:
        return Path(folder) / "logs" / "freiburg-079-corrected.log.gz"
    return SENA if SENA.exists() else None
