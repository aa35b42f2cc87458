"""lfdcore study learning-curve: how much demonstration is enough."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar


def study_learning_curve(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, picture, figures and models.")],
    runs: Annotated[str, typer.Option(help="Numbers of demonstrations to learn from, increasing.")] = "5,10,20,40,72",
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Both methods by the number of demonstrations: contacts, path RMSE, predicted paths. Needs torch once.

    Models stay in the folder: a second study there drives only.
    """
    from lfdcore.study.learning_curve.report import curve_table, write_learning_curve
    from lfdcore.study.learning_curve.study import LearningCurveStudy, run_learning_curve

    study = LearningCurveStudy(folder=output, runs=_numbers(runs), drivers=drivers, seed=seed)
    with progress_bar() as bar:
        curve = run_learning_curve(study, Stages(bar), processes)
    words = ["lfdcore", "study", "learning-curve", "-o", "out", "--runs", runs, "--drivers", str(drivers)]
    report = write_learning_curve(curve, output, shlex.join([*words, "--seed", str(seed)]))
    if as_json:
        print_json({"report": str(report), "rows": [*curve.rows], "errors": [*curve.errors]})
        return
    typer.echo(curve_table(curve).as_text())
    typer.echo(f"report: {report}")


def _numbers(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(word) for word in text.split(","))
    except ValueError as error:
        raise ValueError(f"runs are '{text}', must be whole numbers parted by commas") from error
