"""Which model an arm drives with, and what is refused before anything is driven."""

from pathlib import Path

import pytest

from lfdcore.errors import ModelError
from lfdcore.simulated.run import RunConfig
from lfdcore.study.arms import METHODS, StudyModels, models_by_method, planners
from lfdcore.wheelchair.models import DRIVING


def test_models_are_distinguished_by_their_files(home_model: Path, heatmap_model: Path) -> None:
    models = models_by_method([heatmap_model, home_model])
    assert models.file("primitives") == home_model and models.file("heatmaps") == heatmap_model
    assert StudyModels(heatmaps=None).file("heatmaps") is None
    with pytest.raises(ValueError, match="both models of method primitives, one is needed"):
        models_by_method([home_model, home_model])


def test_every_method_that_drives_is_an_arm_by_its_name() -> None:
    assert all(METHODS[method] == method for method in DRIVING)


def test_an_arm_without_its_model_or_with_one_of_another_method_is_refused(home_model: Path) -> None:
    with pytest.raises(ValueError, match="'heatmaps' needs a model of method heatmaps, there is none"):
        StudyModels(primitives=home_model).of("heatmaps")
    with pytest.raises(ModelError, match="holds a model of method primitives, must be one of heatmaps"):
        StudyModels(heatmaps=home_model).of("heatmaps_thesis")
    with pytest.raises(ValueError, match="method is 'naive', must be one that drives: primitives, heatmaps"):
        StudyModels(naive=home_model)


def test_only_learned_arms_judge_compliance(home_model: Path) -> None:
    judges = planners(("none", "dwa", "primitives"), StudyModels(primitives=home_model), RunConfig())
    assert list(judges) == ["primitives"]
