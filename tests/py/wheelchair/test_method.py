"""A model says how it plans and what it predicts: who asks need not know which methods there are."""

from pathlib import Path

import numpy as np
import pytest

import lfdcore
from heatmap_drives import corridor_log
from imports import imported_modules
from lfdcore.errors import ModelError
from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan
from lfdcore.training.parts.heatmap_net import HeatmapNetConfig, train_heatmap_net
from lfdcore.training.parts.heatmap_targets import heatmap_pairs
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.sensor import NaiveHeatmap
from lfdcore.wheelchair.method import MethodModel
from lfdcore.wheelchair.models import DRIVING, MODELS, load_model
from lfdcore.wheelchair.observation import ChairGeometry

WHEELCHAIR = Path(lfdcore.__file__).parent / "wheelchair"
METHODS = [model.method for model in MODELS]
CHAIR = ChairGeometry.thesis(Pose2(0.5, 0.0, 0.0))


@pytest.fixture(scope="module")
def files(home_model: Path, heatmap_model: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A model of each method."""
    naive = tmp_path_factory.mktemp("naive") / "naive.safetensors"
    logs = [corridor_log([(2.0, 1.0, 0.4)], (0.0, y, 0.0), name=str(y)) for y in (-0.2, 0.2)]
    network = train_heatmap_net(heatmap_pairs(logs), HeatmapNetConfig(kind="naive", epochs=1, width=2))
    NaiveHeatmapModel(NaiveHeatmap(network.onnx)).save(naive)
    return {"primitives": home_model, "heatmaps": heatmap_model, "naive": naive}


@pytest.fixture
def model(files: dict[str, Path], request: pytest.FixtureRequest) -> MethodModel:
    return load_model(files[request.param])


@pytest.mark.parametrize("model", METHODS, indirect=True)
def test_a_model_of_any_method_predicts_a_path(model: MethodModel) -> None:
    predictor = model.predictor()
    scan = LaserScan(np.full(181, 2.0, np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)
    path = predictor.predict(np.array([0.8, 0.0]), scan, CHAIR.T_base_laser)
    assert path is not None and path.shape[1] == 2 and np.isfinite(path).all()
    assert predictor.model is model
    assert (predictor.compliance is not None) == model.drives


@pytest.mark.parametrize("model", DRIVING, indirect=True)
def test_a_planner_is_of_the_chair_asked_for_and_new_each_time(model: MethodModel) -> None:
    planner = model.planner(CHAIR)
    assert planner.chair is CHAIR and planner.look_ahead == pytest.approx(0.8)
    assert model.planner(CHAIR) is not planner


def test_a_printed_planner_has_the_printed_values(files: dict[str, Path]) -> None:
    ours, printed = (HeatmapModel.load(files["heatmaps"]).planner(CHAIR, thesis=thesis) for thesis in (False, True))
    assert ours.config.driver_sd > 0 and printed.config.driver_sd == 0


@pytest.mark.parametrize("model", ["naive"], indirect=True)
def test_the_naive_network_says_that_it_drives_nothing(model: MethodModel) -> None:
    with pytest.raises(ModelError, match="a naive heatmap drives nothing"):
        model.planner(CHAIR)


# -- a further method touches its own folder and one line -------------------------------------------------------------


def test_no_method_knows_another_and_only_the_list_of_models_knows_all() -> None:
    folders = {f"lfdcore.wheelchair.{name}": WHEELCHAIR / name for name in ("primitives", "heatmaps", "goals")}
    for path in WHEELCHAIR.rglob("*.py"):
        known = {name for name in folders if any((one + ".").startswith(name + ".") for one in imported_modules(path))}
        own = {name for name, folder in folders.items() if folder in path.parents}
        allowed = {"models.py": set(folders), "adaptive_assistant.py": {"lfdcore.wheelchair.heatmaps"}}
        assert known <= own | allowed.get(path.name, set()), f"{path} imports {sorted(known - own)}"


@pytest.mark.parametrize("method", ["primitives", "heatmaps"])
def test_a_method_s_folder_has_a_model_a_planner_and_a_prediction(method: str) -> None:
    assert {"model", "planner", "prediction"} <= {path.stem for path in (WHEELCHAIR / method).glob("*.py")}
