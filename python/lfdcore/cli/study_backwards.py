"""lfdcore study backwards: the whole way in reverse, with a scanner that sees all around."""

from __future__ import annotations

import shlex
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, SeedOption, Stages, print_json, progress_bar
from lfdcore.cli.study_heatmaps import ModelOption, heatmaps_or_learned


def study_backwards(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, picture, figures and model.")],
    model: ModelOption = None,
    arms: Annotated[
        str, typer.Option("--assistants", help="Of none, supervisor, dwa_1s, two_way (the heatmaps').")
    ] = "none,supervisor,dwa_1s,two_way",
    drivers: Annotated[int, typer.Option(min=1, help="Simulated drivers of each kind.")] = 10,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: SeedOption = 1,
    as_json: JsonOption = False,
) -> None:
    """Drivers who go backwards through a hall, 360-degree scanner: collisions, time and paths by assistant."""
    from lfdcore.study.backwards.report import backwards_table, run_rows, write_backwards
    from lfdcore.study.backwards.study import BackwardsStudy, require_arms, run_backwards_study

    driven = tuple(arms.split(","))
    require_arms(driven)
    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        tell = Stages(bar)
        needed = "two_way" in driven or model is not None
        learned = heatmaps_or_learned(model, output, seed, tell, processes) if needed else None
        study = BackwardsStudy(heatmaps=learned, arms=driven, drivers=drivers, seed=seed)
        traces = run_backwards_study(study, partial(tell, "drive backwards"), processes)
    words = ["lfdcore", "study", "backwards", "-o", "out", "--assistants", arms, "--drivers", str(drivers)]
    words += ["--seed", str(seed)]
    words += [] if model is None else ["--model", str(model)]
    report = write_backwards(traces, output, shlex.join(words))
    if as_json:
        print_json({"report": str(report), "rows": run_rows(traces)})
        return
    typer.echo(backwards_table(traces).as_text())
    typer.echo(f"report: {report}")
