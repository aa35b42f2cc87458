"""lfdcore learn: models from demonstrations."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import (
    JsonOption,
    LogArguments,
    Preset,
    PresetOption,
    print_json,
    progress_bar,
)

app = typer.Typer(help="Learn a model from demonstrations.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    """Learn a model from demonstrations."""


@app.command("drive")
def learn_drive_command(
    logs: LogArguments,
    output: Annotated[Path, typer.Option("--output", "-o", help="Where the model goes (.safetensors).")],
    share: Annotated[float, typer.Option(min=0, max=1, help="Learn from this first share of each log's scans.")] = 1.0,
    preset: PresetOption = Preset.default,
    as_json: JsonOption = False,
) -> None:
    """Learn local intention, path primitives and compliance from drives (Ch. 3)."""
    from lfdcore.datasets import open_log
    from lfdcore.study.prediction import learn_from_logs
    from lfdcore.wheelchair.model_file import LearningConfig

    _require_writable(output, logs)
    drives = [open_log(path) for path in logs]
    config = LearningConfig.thesis() if preset is Preset.thesis else LearningConfig()
    with progress_bar() as bar:
        task = bar.add_task("learning", total=None)
        model = learn_from_logs(
            drives, share, config, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )
    model.save(output)
    facts = {"model": str(output), **model.summary()}
    if as_json:
        print_json(facts)
        return
    for name, value in facts.items():
        typer.echo(f"{name:>24}  {value}")


def _require_writable(output: Path, logs: list[Path]) -> None:
    """The model replaces what stands at `output`: never a log that it learns from, a folder or a device."""
    if not output.exists():
        return
    if not output.is_file():
        raise ValueError(f"{output}: exists and is no regular file, so no model is written there")
    if any(log.exists() and output.samefile(log) for log in logs):
        raise typer.BadParameter(f"--output {output} is one of the logs to learn from")
