"""Any learned model from its file: which kind it is stands inside."""

from __future__ import annotations

import os

from lfdcore.datasets.tensor_file import tensor_file_format
from lfdcore.errors import ModelError
from lfdcore.wheelchair.goals import model as global_goal
from lfdcore.wheelchair.goals.model import GoalModel
from lfdcore.wheelchair.heatmaps import model as heatmap_model
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.primitives import model as model_file
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

Model = DriveAssistantModel | HeatmapModel | NaiveHeatmapModel
KINDS: dict[str, type[Model]] = {
    model_file.KIND: DriveAssistantModel,
    heatmap_model.HEATMAPS: HeatmapModel,
    heatmap_model.NAIVE: NaiveHeatmapModel,
}


def load_any_model(path: str | os.PathLike[str]) -> Model | GoalModel:
    """As load_model, or a model of destinations, which plans no path."""
    return GoalModel.load(path) if tensor_file_format(path) == global_goal.KIND else load_model(path)


def load_model(path: str | os.PathLike[str]) -> Model:
    """A model that assists. ModelError for a file that is damaged or holds none; OSError if it cannot be opened."""
    found = tensor_file_format(path)
    if found == global_goal.KIND:
        raise ModelError(f"{path} is a model of destinations (lfdcore track), no model that plans paths")
    if found not in KINDS:
        raise ModelError(f"{path} holds '{found}', must be one of {', '.join(KINDS)}")
    return KINDS[found].load(path)
