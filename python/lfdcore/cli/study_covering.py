"""lfdcore study covering: environment-adaptive interaction primitives cover furniture with a bag (Sec. 5.6)."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, Stages, print_json, progress_bar


def study_covering(
    output: Annotated[
        Path,
        typer.Option("--output", "-o", help="Folder for the report, its figures and one repetition's demonstrations."),
    ],
    seeds: Annotated[int, typer.Option(min=1, help="Repetitions, each with demonstrations of its own.")] = 10,
    people: Annotated[int, typer.Option(min=1, help="Unseen people an object and repetition.")] = 5,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: Annotated[
        int, typer.Option(min=0, max=2**31, help="Of the first repetition. The same seed gives the same bytes.")
    ] = 6,
    as_json: JsonOption = False,
) -> None:
    """EaIP and IP cover furniture with a simulated partner: success, Fig. 5.9 and 5.13-5.17, what the partner is
    worth."""
    from lfdcore.simulated.covering import covering_data, write_demonstrations
    from lfdcore.study.covering.report import covering_headline, write_covering_report
    from lfdcore.study.covering.study import CoveringStudy, run_covering_study
    from lfdcore.study.covering.tables import aims, covering_tables

    output.mkdir(parents=True, exist_ok=True)
    study = CoveringStudy(seeds=seeds, seed=seed, held_out=people)
    write_demonstrations(output / "demonstrations", covering_data(seed=seed, held_out=1))
    with progress_bar() as bar:
        result = run_covering_study(study, partial(Stages(bar), "learn and judge"), processes)
    words = ["lfdcore", "study", "covering", "-o", "out", "--seeds", str(seeds), "--people", str(people)]
    report = write_covering_report(result, output, shlex.join([*words, "--seed", str(seed)]))
    if as_json:
        said = [{"figure": a.label, "wanted": a.wanted, "found": a.found, "reached": a.reached} for a in aims(result)]
        print_json({"report": str(report), "figures": said})
        return
    typer.echo(covering_headline(result) + "\n")
    for table in covering_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
