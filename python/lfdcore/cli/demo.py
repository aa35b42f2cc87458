"""lfdcore demo: the main job, from demonstrations to a report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import SeedOption


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the report and what led to it.")] = Path(
        "demo"
    ),
    drivers: Annotated[int, typer.Option(min=1, help="Simulated impaired drivers.")] = 10,
    starts: Annotated[int, typer.Option("--task-starts", min=0, help="Starts of each task; 0: no tasks.")] = 20,
    train: Annotated[
        bool,
        typer.Option("--train", help="Learn the models from demonstrations of this seed. Needs the extra 'train'."),
    ] = False,
    seed: SeedOption = 1,
) -> None:
    """Demonstrations in simulated places -> learned assistants -> a course never seen, with and without them.

    The models come with lfdcore, learned from demonstrations of seed 1, unless --train is given.
    """
    from lfdcore.cli.study import run_study
    from lfdcore.study.demo import demo_study, run

    run_study(demo_study(drivers, starts, seed, train=train), run, output, as_json=False)
