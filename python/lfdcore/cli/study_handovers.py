"""lfdcore study handovers: the taker's motion foretold from the giver's, on real data (Sec. 5.3, 6.2.2)."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar, require_each_once


def study_handovers(
    data: Annotated[list[Path], typer.Argument(help="kth_handover_6d.npz, dynamic_handover_120.npz or both.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, pictures and figures.")],
    splits: Annotated[int, typer.Option(min=1, help="Random splits by demonstration.")] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Real handovers: error of the foretold taker by share observed, for IP and baselines, with intervals."""
    from lfdcore.study.handovers.report import (
        handover_headline,
        handover_rows,
        seen_tables,
        task_tables,
        write_handover_report,
    )
    from lfdcore.study.handovers.study import HandoverStudy, handover_tasks, run_handover_study

    require_each_once(data)
    study = HandoverStudy(tasks=handover_tasks(data), splits=splits, seed=seed)
    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        results = run_handover_study(study, Stages(bar), processes)
    names = [path.name for path in data]  # the folders are left to who repeats it
    command = ["lfdcore", "study", "handovers", *names, "-o", "out", "--splits", str(splits), "--seed", str(seed)]
    report = write_handover_report(results, study, output, shlex.join(command))
    if as_json:
        print_json({"report": str(report), "rows": handover_rows(results, study)})
        return
    typer.echo(handover_headline(results, study) + "\n")
    for table in [*(table for one in results for table in task_tables(one, seed)), *seen_tables(results, seed)]:
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
