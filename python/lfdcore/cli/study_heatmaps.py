"""What the studies of heatmaps alone share: their model, and a bar for every stage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.progress import Progress

Tell = Callable[[str, int, int], None]
"""(stage, done, total)"""

ModelOption = Annotated[
    Path | None, typer.Option("--model", help="Learned heatmaps; else learned from demonstrations, which needs torch.")
]


def bars(bar: Progress) -> Tell:
    """A bar for every stage that is told of."""
    tasks = {}

    def tell(stage: str, done: int, total: int) -> None:
        if stage not in tasks:
            tasks[stage] = bar.add_task(stage, total=None)
        bar.update(tasks[stage], completed=done, total=total)

    return tell


def heatmaps_or_learned(model: Path | None, folder: Path, seed: int, tell: Tell, processes: int | None) -> Path:
    """The file given, or that of heatmaps learned in `folder` from demonstrations. ValueError for a model of another
    method."""
    from lfdcore.study.driving import models_by_method
    from lfdcore.study.heatmap_demonstrations import learn_heatmaps_from_demonstrations

    if model is None:
        folder.mkdir(parents=True, exist_ok=True)
        return learn_heatmaps_from_demonstrations(
            folder, seed, lambda stage, done, total: tell(f"heatmaps: {stage}", done, total), processes=processes
        )
    if models_by_method([model]).heatmaps is None:
        raise ValueError(f"{model} holds primitives, must be heatmaps (lfdcore learn drive --method heatmaps)")
    folder.mkdir(parents=True, exist_ok=True)
    return model
