"""Any learned model from its file: which kind it is stands inside."""

from __future__ import annotations

import os
import reprlib

import numpy as np

from lfdcore.datasets.tensor_file import tensor_file_format
from lfdcore.errors import DataError, ModelError
from lfdcore.geometry import Twist2
from lfdcore.wheelchair import global_goal, heatmap_model, model_file
from lfdcore.wheelchair.global_goal import GoalModel
from lfdcore.wheelchair.heatmap_model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.model_file import DriveAssistantModel

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


def full_deflection_of(model: Model) -> Twist2 | None:
    """How fast [m/s, rad/s] the demonstrations' vehicle moved with the stick pushed fully (of several demonstrations:
    the geometric mean); None for a model that does not say. DataError for one that says no positive speeds."""
    told = model.metadata.get("full_deflection", [])
    try:
        said = np.array(told, float).reshape(-1, 2)
    except (TypeError, ValueError, OverflowError) as error:
        raise DataError(f"the model's full_deflection is {reprlib.repr(told)}, must be pairs of numbers") from error
    if not len(said):
        return None
    if not (np.isfinite(said).all() and (said > 0).all()):
        raise DataError(f"the model's full_deflection is {said.tolist()} m/s and rad/s, must be positive")
    return Twist2(*np.exp(np.log(said).mean(axis=0)).tolist())
