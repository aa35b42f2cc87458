"""Options and output that commands share."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lfdcore.study.preset import Preset

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.progress import Progress, TaskID

    from lfdcore.geometry import Footprint, Pose2


_LONGEST = 10
"""items of a list that are shown to people one by one"""


PresetOption = Annotated[Preset, typer.Option(help="'thesis' restores printed values (docs/thesis-preset.md).")]
SeedOption = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="The same seed gives the same bytes.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for machines instead of tables.")]
LogArguments = Annotated[
    list[Path], typer.Argument(help="Drive logs: .mcap, CARMEN .log(.gz), MRPT .rawlog, ROS bags.")
]


def print_json(value: Any) -> None:
    """Prints a value for machines; what is not finite becomes null, as JSON has no NaN."""
    from lfdcore.datasets.strict_json import plain_json

    typer.echo(json.dumps(plain_json(value), indent=2, allow_nan=False))


def show_facts(facts: dict[str, Any], as_json: bool) -> None:
    """For machines or for people."""
    if as_json:
        print_json(facts)
    else:
        print_facts(facts)


def print_facts(facts: dict[str, Any]) -> None:
    """Prints a line a fact, aligned; a list longer than a line by its ends and length."""
    for name, value in facts.items():
        typer.echo(f"{name:>24}  {_as_text(value)}")


def _as_text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        items = [_as_text(item) for item in value]
        ends = [*items[:2], "...", items[-1]] if len(items) > _LONGEST else items
        return ", ".join(ends) + (f" ({len(items)})" if len(items) > _LONGEST else "")
    if isinstance(value, dict):
        return ", ".join(f"{name} {_as_text(item)}" for name, item in value.items())
    return str(value)


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """A progress bar on standard error, so that standard output stays clean. It is shown from `start` on: what is
    refused before anything was done leaves no trace of it."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    bar = Progress(*columns, console=Console(stderr=True))
    try:
        yield bar
    finally:
        if bar.live.is_started:
            bar.stop()


PICTURES = (".png", ".pdf", ".svg")
"""What a picture may end in."""


def require_drawable(option: str, path: Path | None, allowed: tuple[str, ...] = PICTURES) -> None:
    """Before the work: a picture that is asked for has a suffix we can draw, and a folder."""
    if path is not None and path.suffix.lower() not in allowed:
        raise typer.BadParameter(f"{option} {path} must end in {', '.join(allowed)}")
    if path is not None and not path.parent.is_dir():
        raise ValueError(f"{path}: there is no folder {path.parent} to draw to")


def save_picture(figure: Figure, path: Path) -> None:
    """Writes a figure, as PNG the same bytes for the same figure, and says where."""
    from lfdcore.pictures.style import png

    if path.suffix.lower() == ".png":
        path.write_bytes(png(figure, dpi=150))
    else:
        figure.savefig(path, bbox_inches="tight")
    typer.echo(f"picture: {path}", err=True)


LARGEST = 100.0
"""[m] that a robot may measure in any direction"""


def footprint_of(text: str) -> Footprint:
    """What --footprint says."""
    from lfdcore.geometry import Footprint

    front, rear, half_width = _three_numbers("--footprint", text, "FRONT,REAR,HALF_WIDTH in metres")
    if not all(0 < size <= LARGEST for size in (front, rear, half_width)):
        raise typer.BadParameter(f"--footprint {text!r} must lie in (0, {LARGEST:g}] m")
    return Footprint(front, rear, half_width)


def pose_of(option: str, text: str) -> Pose2:
    """What an option says as X,Y,YAW in metres and degrees."""
    from lfdcore.geometry import Pose2

    x, y, yaw = _three_numbers(option, text, "X,Y,YAW in metres and degrees")
    if not all(map(math.isfinite, (x, y, yaw))):
        raise typer.BadParameter(f"{option} {text!r} must be finite")
    return Pose2(x, y, math.radians(yaw))


def _three_numbers(option: str, text: str, meaning: str) -> tuple[float, float, float]:
    try:
        first, second, third = (float(word) for word in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{option} {text!r} must be {meaning}") from None
    return first, second, third


def require_each_once(files: list[Path]) -> None:
    """A log taken twice would make its figures look surer than they are. Files under two names are found too."""
    taken: dict[Path, Path] = {}
    for file in files:
        before = taken.setdefault(file.resolve(), file)
        if before is not file:
            raise typer.BadParameter(f"{file} is given twice" + ("" if file == before else f", also as {before}"))


class Stages:
    """A bar for every stage of a work, made at its first report as (stage, done, total)."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage not in self._tasks:
            self._add(stage)
        self._bar.update(self._tasks[stage], completed=done, total=total)

    def step(self, title: str) -> Callable[[int, int], None]:
        """One stage's bar, shown at once; it takes reports as (done, total)."""
        self._add(title)
        return partial(self, title)

    def _add(self, stage: str) -> None:
        self._bar.start()
        self._tasks[stage] = self._bar.add_task(stage, total=None)


def require_writable(output: Path, inputs: list[Path], option: str = "--output") -> None:
    """Before minutes of work. What is made replaces what stands at `output`: never a file that it is made from, a
    folder or a device."""
    folder = output.parent
    if not folder.is_dir():
        raise ValueError(f"{output}: there is no folder {folder} to write to")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ValueError(f"{output}: the folder {folder} cannot be written to")
    if not output.exists():
        return
    if not output.is_file():
        raise ValueError(f"{output}: exists and is no regular file, so nothing is written there")
    if any(one.exists() and output.samefile(one) for one in inputs):
        raise typer.BadParameter(f"{option} {output} is read, so nothing is written there")
