"""The models that come with the package: what they are, that they can be made again, that they drive."""

import importlib.util
import tomllib
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.datasets import open_log
from lfdcore.models import HEATMAPS, NAIVE, PRIMITIVES
from lfdcore.simulated.courses import course_by_name
from lfdcore.study.arms import StudyModels
from lfdcore.study.driving.plan import DrivingPlan, run_driving_plan
from lfdcore.training.parts.heatmap_targets import HeatmapTargetConfig, heatmap_pairs
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.sensor import INPUT, OUTPUT, NaiveHeatmap, SensorHeatmap, naive_images
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_models", ROOT / "tools" / "make_models.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("path", "kind", "logs"),
    [
        (PRIMITIVES, DriveAssistantModel, ["home-0", "home-1", "home-2"]),
        (HEATMAPS, HeatmapModel, 72),
        (NAIVE, NaiveHeatmapModel, 72),
    ],
    ids=lambda value: value.stem if isinstance(value, Path) else "",
)
def test_the_package_holds_a_model_of_each_kind_that_says_what_it_was_learned_from(path, kind, logs) -> None:
    """`make test` runs on what pip installed: there it is the wheel that holds them."""
    model = load_model(path)
    assert type(model) is kind
    said = model.metadata["logs"]
    assert said == logs if isinstance(logs, list) else len(said) == logs
    assert path.stat().st_size < 200e3


def test_nothing_keeps_the_models_out_of_the_wheel() -> None:
    build = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["scikit-build"]
    assert build["wheel"]["packages"] == ["python/lfdcore"]
    assert build["wheel"]["exclude"] == ["*.so.dev"]
    assert "safetensors" not in (ROOT / ".gitignore").read_text()


def test_primitives_learned_again_are_the_same_bytes(home_model: Path) -> None:
    assert home_model.read_bytes() == PRIMITIVES.read_bytes()


def test_a_model_made_again_may_differ_as_far_as_its_tolerance_says(tool: ModuleType, tmp_path: Path) -> None:
    def with_loss(value: float) -> Path:
        model, path = NaiveHeatmapModel.load(NAIVE), tmp_path / f"{value}.safetensors"
        replace(model, metadata={**model.metadata, "validation_loss": value}).save(path)
        return path

    before, near, far = with_loss(0.05), with_loss(0.051), with_loss(0.06)
    assert tool.compare(before, before) == ("the same bytes", True)
    assert tool.compare(before, near)[1]
    assert not tool.compare(before, far)[1]
    assert "0.06000, before 0.05000: BEYOND" in tool.compare(before, far)[0]


def test_primitives_made_again_may_not_differ_at_all(tool: ModuleType, tmp_path: Path) -> None:
    model, other = DriveAssistantModel.load(PRIMITIVES), tmp_path / "other.safetensors"
    replace(model, metadata={**model.metadata, "n_paths": 1}).save(other)
    assert tool.compare(PRIMITIVES, other) == ("OTHER BYTES", False)


# ---- the networks -------------------------------------------------------------------------------------------------


def loss(network: SensorHeatmap | NaiveHeatmap, images: NDArray[Any], target: NDArray[Any]) -> float:
    """Mean binary cross-entropy a cell, of what the network says before it is divided by its maximum."""
    said = [network.session.run([OUTPUT], {INPUT: image[None, None].astype(np.float32)})[0] for image in images]
    heat = np.concatenate(said)[:, 0].astype(float).clip(1e-7, 1 - 1e-7)
    return float(-(target * np.log(heat) + (1 - target) * np.log1p(-heat)).mean())


def test_the_networks_know_four_of_the_drives_as_well_as_recorded(heatmap_model: Path, tool: ModuleType) -> None:
    """The first four: their targets hold fewer paths than those of all 72, so that the loss is another one."""
    logs = [open_log(path) for path in sorted(heatmap_model.parent.glob("maze-*.mcap"))]
    of_place, own = heatmap_pairs(logs), heatmap_pairs(logs, HeatmapTargetConfig(paths="own"))
    found = loss(HeatmapModel.load(HEATMAPS).sensor, of_place.free, of_place.target.astype(float))
    assert found == pytest.approx(0.0370, abs=tool.TOLERANCE)
    naive = NaiveHeatmapModel.load(NAIVE).network
    found = loss(naive, naive_images(own.free, own.joystick), own.target.astype(float))
    assert found == pytest.approx(0.0317, abs=tool.TOLERANCE)


def test_the_heatmaps_drive_the_standard_course_as_recorded() -> None:
    """Driver 1 of the demo, of whom figures.json says 186.2 s, .0345 m and no contact."""
    models, course = StudyModels(heatmaps=HEATMAPS), course_by_name("standard_course", 1)
    plan = DrivingPlan(courses=(course,), models=models, arms=("heatmaps",), drivers=1)
    (row,) = run_driving_plan(plan, processes=1).rows
    assert row["completed"] and row["collisions"] == 0
    assert row["time"] == pytest.approx(186.2, rel=0.1)
    assert row["path_rmse"] == pytest.approx(0.0345, abs=0.015)
