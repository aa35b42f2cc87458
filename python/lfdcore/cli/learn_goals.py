"""lfdcore learn goals: destinations in a known map, from drives to them (Ch. 2)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import (
    JsonOption,
    LogArguments,
    PresetOption,
    SeedOption,
    Stages,
    progress_bar,
    require_each_once,
    require_writable,
    show_facts,
)
from lfdcore.cli.log_options import (
    AxesOption,
    CommandOption,
    JoyOption,
    LogOptions,
    MountingOption,
    OdometryOption,
    ScanOption,
)
from lfdcore.study.preset import Preset


def learn_goals_command(
    logs: LogArguments,
    goals: Annotated[Path, typer.Option(help="Destinations by name in the map (.yaml): name, x, y in metres.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Where the model goes (.safetensors).")],
    subset: Annotated[
        int | None, typer.Option(min=1, help="Samples that Alg. 1 keeps for real time. Default: as the preset.")
    ] = None,
    processes: Annotated[int, typer.Option(min=1, help="That search hyper-parameters side by side.")] = 1,
    preset: PresetOption = Preset.default,
    seed: SeedOption = 1,
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    as_json: JsonOption = False,
) -> None:
    """Learn from drives, each of which names its destination, how a driver steers towards each. Needs torch."""
    from dataclasses import replace

    from lfdcore.datasets import read_goals

    require_each_once(logs)
    require_writable(output, [*logs, goals])
    import torch  # noqa: F401 - where it is missing, before any log is read

    from lfdcore.training.goals import GoalLearningConfig, learn_goals

    options = LogOptions(scan, odometry, joy, axes, command, mounting)
    places, drives = read_goals(goals), [options.open(path) for path in logs]
    config = GoalLearningConfig.thesis() if preset is Preset.thesis else GoalLearningConfig()
    config = replace(config, subset=subset or config.subset, seed=seed)
    with progress_bar() as bar:
        model = learn_goals(drives, places, config, Stages(bar), processes)
    model.save(output)
    show_facts({"model": str(output), **model.summary()}, as_json)
