"""lfdcore learn: models from demonstrations."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import (
    JsonOption,
    LogArguments,
    PresetOption,
    Stages,
    print_facts,
    print_json,
    progress_bar,
    require_each_once,
    require_writable,
)
from lfdcore.cli.learn_collaboration import learn_collaboration_command
from lfdcore.cli.learn_goals import learn_goals_command
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

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.training.parts.heatmap_net import TrainedHeatmapNet
    from lfdcore.wheelchair.method import MethodModel

app = typer.Typer(help="Learn a model from demonstrations.", no_args_is_help=True)


class Method(StrEnum):
    """What is learned."""

    primitives = "primitives"
    heatmaps = "heatmaps"
    naive = "naive"


@app.callback()
def _group() -> None:
    """Learn a model from demonstrations."""


app.command("goals")(learn_goals_command)
app.command("collaboration")(learn_collaboration_command)


@app.command("drive")
def learn_drive_command(
    logs: LogArguments,
    output: Annotated[Path, typer.Option("--output", "-o", help="Where the model goes (.safetensors).")],
    method: Annotated[
        Method,
        typer.Option(
            help="primitives: intention, path primitives, compliance (Ch. 3); heatmaps: of scan and joystick (Ch. 4); "
            "naive: one network for both (Sec. 4.6.2). The latter two need the extra 'train'."
        ),
    ] = Method.primitives,
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    share: Annotated[float, typer.Option(min=0, max=1, help="Learn from this first share of each log's scans.")] = 1.0,
    preset: PresetOption = Preset.default,
    as_json: JsonOption = False,
) -> None:
    """Learn from drives what a driver wants. A joystick that was not recorded is inferred from the motion."""
    from lfdcore.training.drive_primitives import first_share

    require_each_once(logs)
    require_writable(output, logs)
    if method is not Method.primitives:
        import lfdcore.training.drive_heatmaps  # noqa: F401 - what is missing, before any log is read
    options = LogOptions(scan, odometry, joy, axes, command, mounting)
    drives = [options.open(path) for path in logs]
    with progress_bar() as bar:
        model, network = _learn(method, first_share(drives, share), preset, Stages(bar))
    model.save(output)
    facts = {"model": str(output), **model.summary()}
    if as_json:
        print_json(facts | ({} if network is None else {"curve": [dataclasses.asdict(e) for e in network.curve]}))
        return
    losses = {"train_losses", "validation_losses"} if network is not None else set()  # in the table below
    print_facts({name: value for name, value in facts.items() if name not in losses})
    if network is not None:
        typer.echo(_curve(network))


def _learn(
    method: Method, drives: list[DriveLog], preset: Preset, tell: Stages
) -> tuple[MethodModel, TrainedHeatmapNet | None]:
    if method is Method.primitives:
        from lfdcore.training.drive_primitives import LearningConfig, learn_drive

        settings = LearningConfig.thesis() if preset is Preset.thesis else LearningConfig()
        return learn_drive(drives, settings, partial(tell, "learning")), None
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig, learn_heatmaps, learn_naive_heatmap

    config = HeatmapLearningConfig.thesis() if preset is Preset.thesis else HeatmapLearningConfig()
    learn = learn_naive_heatmap if method is Method.naive else learn_heatmaps
    learned = learn(drives, config.for_logs(drives), tell)
    return learned.model, learned.network


def _curve(network: TrainedHeatmapNet) -> str:
    """The learning curves: mean binary cross-entropy a cell"""
    rows = ["loss: mean binary cross-entropy of a cell", f"{'epoch':>5}  {'train':>6}  {'validation':>10}"]
    for epoch in network.curve:
        kept = "  kept" if epoch == network.best else ""
        rows.append(f"{epoch.epoch:>5}  {epoch.train:>6.4f}  {epoch.validation:>10.4f}{kept}")
    return "\n".join(["", *rows])
