"""Any learned model from its file: which kind it is stands inside."""

from __future__ import annotations

import os

from lfdcore.errors import ModelError
from lfdcore.wheelchair import heatmap_model, model_file
from lfdcore.wheelchair.heatmap_model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.model_file import DriveAssistantModel
from lfdcore.wheelchair.tensor_file import tensor_file_format

Model = DriveAssistantModel | HeatmapModel | NaiveHeatmapModel
KINDS: dict[str, type[Model]] = {
    model_file.KIND: DriveAssistantModel,
    heatmap_model.HEATMAPS: HeatmapModel,
    heatmap_model.NAIVE: NaiveHeatmapModel,
}


def load_model(path: str | os.PathLike[str]) -> Model:
    """ModelError for a file that is damaged or holds no model known here; OSError if it cannot be opened."""
    found = tensor_file_format(path)
    if found not in KINDS:
        raise ModelError(f"{path} holds '{found}', must be one of {', '.join(KINDS)}")
    return KINDS[found].load(path)
