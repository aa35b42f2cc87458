"""lfdcore study sequences: which task has the partner begun (Sec. 6.2.2)."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar


def study_sequences(
    data: Annotated[Path, typer.Argument(help="Folder with the LASA handwriting shapes (.mat).")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, picture and figures.")],
    draws: Annotated[int, typer.Option(min=1, help="Draws of three shapes.")] = 40,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Three handwriting shapes as tasks: which has begun, foreign ones, switches, by share observed."""
    from lfdcore.datasets import read_all_handwriting
    from lfdcore.study.sequences.report import (
        aims_table,
        sequence_headline,
        sequence_rows,
        sequence_table,
        write_sequence_report,
    )
    from lfdcore.study.sequences.study import SequenceStudy, run_sequence_study

    study = SequenceStudy(shapes=tuple(read_all_handwriting(data)), draws=draws, seed=seed)
    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        results = run_sequence_study(study, partial(Stages(bar), "draws"), processes)
    command = ["lfdcore", "study", "sequences", "LASA_FOLDER", "-o", "out", "--draws", str(draws), "--seed", str(seed)]
    report = write_sequence_report(results, study, output, shlex.join(command))
    if as_json:
        print_json({"report": str(report), "rows": sequence_rows(results, study)})
        return
    typer.echo(sequence_headline(results, study) + "\n")
    for table in (aims_table(results), sequence_table(results, study)):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
