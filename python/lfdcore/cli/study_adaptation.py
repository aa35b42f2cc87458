"""lfdcore study adaptation: does the joystick model learn its driver's bias while driving."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar
from lfdcore.cli.study_heatmaps import ModelOption, heatmaps_or_learned


def study_adaptation(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, picture, figures and model.")],
    model: ModelOption = None,
    courses: Annotated[
        str,
        typer.Option(help="Comma-separated names of courses or map .yaml files; office and flat were tuned on."),
    ] = "standard_course",
    drivers: Annotated[
        int, typer.Option(min=1, help="Simulated able drivers, each unbiased and +-.3 rad beside.")
    ] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Drivers with a steering bias: the joystick model's error before and while it adapts (Sec. 6.2.1)."""
    from lfdcore.simulated.courses import course_by_name
    from lfdcore.study.adaptation.report import adaptation_table, ratio_rows, write_adaptation
    from lfdcore.study.adaptation.study import AdaptationStudy, run_adaptation_study
    from lfdcore.study.arms import require_once

    driven = tuple(course_by_name(name, seed) for name in courses.split(","))
    require_once("course", [course.name for course in driven])
    with progress_bar() as bar:
        tell = Stages(bar)
        learned = heatmaps_or_learned(model, output, seed, tell, processes)
        study = AdaptationStudy(courses=driven, model=learned, drivers=drivers, seed=seed)
        runs = run_adaptation_study(study, partial(tell, "drive"), processes)
    words = ["lfdcore", "study", "adaptation", "-o", "out", "--courses", courses, "--drivers", str(drivers)]
    words += ["--seed", str(seed), *([] if model is None else ["--model", str(model)])]
    report = write_adaptation(runs, output, shlex.join(words))
    if as_json:
        print_json({"report": str(report), "biases": ratio_rows(runs), "rows": [run.row() for run in runs]})
        return
    typer.echo(adaptation_table(runs).as_text())
    typer.echo(f"report: {report}")
