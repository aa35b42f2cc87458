"""lfdcore learn collaboration: what partner and robot do together, from recordings of both (Ch. 5)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import (
    JsonOption,
    PresetOption,
    Stages,
    progress_bar,
    require_each_once,
    require_writable,
    show_facts,
)
from lfdcore.study.preset import Preset


def learn_collaboration_command(
    demonstrations: Annotated[
        list[Path], typer.Argument(metavar="DEMOS", help="Recordings of partner, robot and environment (.npz).")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Where the model goes (.safetensors).")],
    environment: Annotated[
        bool,
        typer.Option("--environment/--plain", help="--plain: an interaction primitive that does not see the scene."),
    ] = True,
    preset: PresetOption = Preset.default,
    as_json: JsonOption = False,
) -> None:
    """Learn from recorded collaborations how the robot's motion goes with its partner's and with the scene."""
    from dataclasses import replace

    from lfdcore.datasets.interaction import load_interaction
    from lfdcore.humanoid.collaboration import CollaborationConfig
    from lfdcore.training.collaborations import learn_collaboration

    require_each_once(demonstrations)
    require_writable(output, demonstrations)
    recordings = [load_interaction(path) for path in demonstrations]
    config = CollaborationConfig.thesis() if preset is Preset.thesis else CollaborationConfig()
    with progress_bar() as bar:
        report = Stages(bar).step("noise, leaving demonstrations out")
        model = learn_collaboration(recordings, replace(config, environment=environment), progress=report)
    model.save(output)
    show_facts({"model": str(output), **model.summary()}, as_json)
