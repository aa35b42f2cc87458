"""Any learned model from its file: which kind it is stands inside."""

from __future__ import annotations

import os

from lfdcore.datasets.tensor_file import tensor_file_format
from lfdcore.errors import ModelError
from lfdcore.wheelchair.goals import model as global_goal
from lfdcore.wheelchair.goals.model import GoalModel
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.method import MethodModel
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

MODELS: tuple[type[MethodModel], ...] = (DriveAssistantModel, HeatmapModel, NaiveHeatmapModel)
"""One a method; a further method is a further line here."""
DRIVING = tuple(model.method for model in MODELS if model.drives)
"""Names of the methods that drive."""
_BY_KIND = {model.kind: model for model in MODELS}


def load_any_model(path: str | os.PathLike[str]) -> MethodModel | GoalModel:
    """As load_model, or a model of destinations, which plans no path."""
    return GoalModel.load(path) if tensor_file_format(path) == global_goal.KIND else load_model(path)


def load_model(path: str | os.PathLike[str]) -> MethodModel:
    """A model that plans or predicts paths. ModelError for a file that is damaged or holds none; OSError if it cannot
    be opened."""
    found = tensor_file_format(path)
    if found == global_goal.KIND:
        raise ModelError(f"{path} is a model of destinations (lfdcore track), no model that plans paths")
    if found not in _BY_KIND:
        raise ModelError(f"{path} holds '{found}', must be one of {', '.join(_BY_KIND)}")
    return _BY_KIND[found].load(path)
