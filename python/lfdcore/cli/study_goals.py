"""lfdcore study goals: where is the driver going, in a known map (Ch. 2)."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, Preset, PresetOption, Stages, print_json, progress_bar


def study_goals(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report, figures, drives and the model.")],
    map_file: Annotated[
        Path | None, typer.Option("--map", help="A map (.yaml) with destinations drawn by seed. Default: our building.")
    ] = None,
    full: Annotated[
        bool, typer.Option("--full/--sparse", help="Judge all data too: minutes, and 2 GB for N = 10^4.")
    ] = True,
    subset: Annotated[
        int | None, typer.Option(min=1, help="Samples that Alg. 1 keeps. Default: as the preset.")
    ] = None,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    preset: PresetOption = Preset.default,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**32 - 1, help="Of the drives. Default: that of the figures reported.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Drives to six destinations -> network, Gaussian process and filter: Tables 2.1-2.2, Fig. 2.4-2.8. Needs torch."""
    from dataclasses import replace

    from lfdcore.simulated.courses import goal_building, goals_in_map
    from lfdcore.study.goals.report import goal_headline, goal_tables, write_goal_report
    from lfdcore.study.goals.study import GoalStudy, run_goal_study
    from lfdcore.training.goals import GoalLearningConfig

    seed = GoalStudy.seed if seed is None else seed
    world = goal_building() if map_file is None else goals_in_map(map_file, seed)
    learning = GoalLearningConfig.thesis() if preset is Preset.thesis else GoalLearningConfig()
    learning = replace(learning, subset=subset or learning.subset)
    output.mkdir(parents=True, exist_ok=True)
    study = GoalStudy(
        folder=output,
        world=world,
        learning=learning,
        full=full,
        seed=seed,
        processes=processes,
    )
    with progress_bar() as bar:
        result = run_goal_study(study, Stages(bar))
    result.model.save(output / "goals.safetensors")
    words = ["lfdcore", "study", "goals", "-o", "out", "--subset", str(learning.subset), "--seed", str(seed)]
    words += ["--full" if full else "--sparse", *(["--map", str(map_file)] if map_file else [])]
    words += ["--preset", "thesis"] if preset is Preset.thesis else []
    report = write_goal_report(result, output, shlex.join(words))
    if as_json:
        rows = [{"method": a.method, "share": a.share, "low": a.low, "high": a.high} for a in result.accuracies]
        print_json({"report": str(report), "accuracies": rows})
        return
    typer.echo(goal_headline(result) + "\n")
    for table in goal_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
