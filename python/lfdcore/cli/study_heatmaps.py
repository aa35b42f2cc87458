"""What the studies of heatmaps alone share: their model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import Stages

ModelOption = Annotated[
    Path | None, typer.Option("--model", help="Learned heatmaps; else learned from demonstrations, which needs torch.")
]


def heatmaps_or_learned(model: Path | None, folder: Path, seed: int, tell: Stages, processes: int | None) -> Path:
    """The file given, or that of heatmaps learned in `folder` from demonstrations. ValueError for a model of another
    method."""
    from lfdcore.study.arms import models_by_method
    from lfdcore.study.demonstrations import learn_heatmaps_from_demonstrations

    if model is None:
        folder.mkdir(parents=True, exist_ok=True)
        return learn_heatmaps_from_demonstrations(folder, seed, tell.under("heatmaps"), processes=processes)
    if models_by_method([model]).file("heatmaps") is None:
        raise ValueError(f"{model} holds primitives, must be heatmaps (lfdcore learn drive --method heatmaps)")
    folder.mkdir(parents=True, exist_ok=True)
    return model
