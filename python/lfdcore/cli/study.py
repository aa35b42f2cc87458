"""lfdcore study: experiments with tables, pictures and a report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, print_json, progress_bar

app = typer.Typer(help="Run a study: tables, pictures, one report.html.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """Run a study: tables, pictures, one report.html."""


@app.command("driving")
def study_driving(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report, its pictures and figures.")],
    model: Annotated[
        Path | None, typer.Option(help="A learned model; without one it is learned from demonstrations first.")
    ] = None,
    courses: Annotated[
        str, typer.Option(help="Comma-separated names of courses or map .yaml files.")
    ] = "standard_course",
    arms: Annotated[
        str, typer.Option("--assistants", help="Of none, dwa, primitives, supervisor, thesis.")
    ] = "none,dwa,primitives",
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Drivers x courses x assistants: Tables 3.1-3.3 with intervals, and pictures of every course."""
    from lfdcore.study.courses import course_by_name
    from lfdcore.study.demonstrations import learn_from_demonstrations
    from lfdcore.study.driving import DrivingStudy, run_driving_study
    from lfdcore.study.driving_report import write_driving_report
    from lfdcore.study.tables import driving_tables

    output.mkdir(parents=True, exist_ok=True)
    chosen = tuple(course_by_name(name, seed) for name in courses.split(","))
    with progress_bar() as bar:
        if model is None:
            task = bar.add_task("demonstrations and learning", total=None)
            model = learn_from_demonstrations(
                output, seed, progress=lambda done, total: bar.update(task, completed=done, total=total)
            )
        task = bar.add_task("driving", total=None)
        plan = DrivingStudy(courses=chosen, model=model, arms=tuple(arms.split(",")), drivers=drivers, seed=seed)
        result = run_driving_study(plan, lambda done, total: bar.update(task, completed=done, total=total), processes)
    report = write_driving_report(result, output)
    if as_json:
        print_json({"report": str(report), "rows": list(result.rows)})
        return
    for table in driving_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
