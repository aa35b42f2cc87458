"""lfdcore study passing: interaction primitives with and without the environment over a rectangle (Sec. 5.5)."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar


def study_passing(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, pictures and figures.")],
    seeds: Annotated[int, typer.Option(min=1, help="Studies with demonstrations of their own.")] = 10,
    demonstrations: Annotated[
        int, typer.Option(min=2, help="Of each rectangle, to learn from and as many to judge by.")
    ] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 5,
    as_json: JsonOption = False,
) -> None:
    """Passing over rectangles, known and novel, after a glimpse of the partner: Fig. 5.5-5.7, IP beside EaIP."""
    from lfdcore.study.passing.report import claim_row, claims, passing_headline, passing_tables, write_passing
    from lfdcore.study.passing.study import PassingExample, PassingStudy, run_passing_study

    study = PassingStudy(seeds=seeds, seed=seed, demonstrations=demonstrations)
    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        tell = Stages(bar)
        result = run_passing_study(study, tell.step("learn and judge, by seed"), processes)
        told = tell.step("report")
        words = ["lfdcore", "study", "passing", "-o", "out", "--seeds", str(seeds), "--seed", str(seed)]
        words += [] if demonstrations == 10 else ["--demonstrations", str(demonstrations)]
        report = write_passing(result, PassingExample.of(study), output, shlex.join(words))
        told(1, 1)
    if as_json:
        print_json({"report": str(report), "claims": [claim_row(one) for one in claims(result)]})
        return
    typer.echo(passing_headline(result) + "\n")
    for table in passing_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
