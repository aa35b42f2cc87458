"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import SeedOption, progress_bar

SENA = Path("/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog")
"""The robotic wheelchair's log in Debian's package mrpt-common."""


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report and what led to it.")] = Path(
        "demo"
    ),
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    seed: SeedOption = 1,
) -> None:
    """Demonstrations in a simulated home -> a learned assistant -> a course never seen, with and without it."""
    from lfdcore.study.courses import standard_course
    from lfdcore.study.demonstrations import learn_from_demonstrations
    from lfdcore.study.driving import DrivingStudy, run_driving_study
    from lfdcore.study.driving_report import write_driving_report
    from lfdcore.study.tables import driving_tables

    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        task = bar.add_task("demonstrations and learning", total=None)
        model = learn_from_demonstrations(
            output, seed, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
        task = bar.add_task("driving a course never seen", total=None)
        result = run_driving_study(
            DrivingStudy(courses=(standard_course(),), model=model, drivers=drivers, seed=seed),
            lambda done, total: bar.update(task, completed=done, total=total),
        )
        task = bar.add_task("report", total=1)
        report = write_driving_report(result, output)
        bar.update(task, completed=1)
    for table in driving_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")


def real_log() -> Path | None:
    """A real log at hand: of LFDCORE_DATA, or the one in Debian's mrpt-common."""
    folder = os.environ.get("LFDCORE_DATA")
    if folder:
        return Path(folder) / "logs" / "freiburg-079-corrected.log.gz"
    return SENA if SENA.exists() else None
