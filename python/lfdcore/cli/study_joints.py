"""lfdcore study joints: primitives of joint angles beside primitives of the gripper's pose (Sec. 6.2.2)."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import JsonOption, Stages, print_json, progress_bar


def study_joints(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for report and figures.")],
    seeds: Annotated[int, typer.Option(min=1, help="Repetitions, each with people of its own.")] = 10,
    held_out: Annotated[int, typer.Option(min=1, help="People who teach nothing, at each object.")] = 3,
    processes: Annotated[int | None, typer.Option(min=1, help="Default: one a core.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Of the first repetition.")] = 6,
    as_json: JsonOption = False,
) -> None:
    """The covering task learned as joint angles and as gripper poses: paths, limits, collisions, time."""
    from lfdcore.study.joints.report import (
        better_at,
        joint_space_headline,
        joint_space_tables,
        write_joint_space_report,
    )
    from lfdcore.study.joints.study import JointSpaceStudy, run_joint_space_study

    study = JointSpaceStudy(seeds=seeds, seed=seed, held_out=held_out)
    output.mkdir(parents=True, exist_ok=True)
    with progress_bar() as bar:
        result = run_joint_space_study(study, Stages(bar).step("learn and judge, seed by seed"), processes)
    words = ["lfdcore", "study", "joints", "-o", "out", "--seeds", str(seeds), "--held-out", str(held_out)]
    report = write_joint_space_report(result, output, shlex.join([*words, "--seed", str(seed)]))
    if as_json:
        print_json({"report": str(report), "better_at": better_at(result)})
        return
    typer.echo(joint_space_headline(result) + "\n")
    for table in joint_space_tables(result):
        typer.echo(table.as_text())
    typer.echo(f"report: {report}")
