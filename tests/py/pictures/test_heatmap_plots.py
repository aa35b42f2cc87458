"""The stages' pictures: which pair and which moment are shown, and that the captions say where they are from."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.pictures.heatmap_stages import heat_moment, heatmap_figures, widest_pair
from lfdcore.pictures.style import png
from lfdcore.study.demonstrations import demonstrate_in_mazes, drive_to_destinations
from lfdcore.study.heatmaps.report import heatmap_section, held_out_logs
from lfdcore.training.parts.heatmap_targets import HeatmapPairs
from lfdcore.wheelchair.heatmaps.model import HeatmapModel


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ...]:
    """The same four runs that the model learned from."""
    return demonstrate_in_mazes(tmp_path_factory.mktemp("mazes"), 1, runs=4, processes=1).paths


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> DriveLog:
    return open_log(drive_to_destinations(tmp_path_factory.mktemp("home"), 1, runs=1, processes=1).paths[0])


@pytest.fixture(scope="module")
def model(heatmap_model: Path) -> HeatmapModel:
    return HeatmapModel.load(heatmap_model)


def pairs(totals: list[float], logs: list[int]) -> HeatmapPairs:
    n = len(totals)
    target = np.zeros((n, 100, 100), np.float16)
    target[:, 50, 60] = totals
    number = np.arange(n)
    return HeatmapPairs(np.ones((n, 100, 100), bool), target, np.zeros((n, 2), np.float32), np.array(logs), number)


def test_the_widest_pair_is_of_the_held_out_logs_if_there_are_any() -> None:
    some = pairs([0.2, 0.9, 0.5, 0.3], [0, 0, 1, 1])
    assert widest_pair(some) == 1 and widest_pair(some, [1]) == 2 and widest_pair(some, [7]) == 1


def test_the_model_says_what_was_held_out_and_how_its_losses_fell(model: HeatmapModel, paths: tuple[Path, ...]) -> None:
    said = model.metadata
    assert len(said["held_out"]) == 1 and 0 <= said["held_out"][0] < 4
    assert len(said["train_losses"]) == len(said["validation_losses"]) == said["epochs"]
    assert min(said["validation_losses"]) == pytest.approx(said["validation_loss"], abs=1e-6)
    (held_out,) = held_out_logs(model, paths)
    assert held_out.name == said["logs"][said["held_out"][0]]
    with pytest.raises(ValueError, match="learned from 4 logs, 3 are given"):
        held_out_logs(model, paths[:3])


def test_the_moment_is_one_with_a_path_after_which_the_driver_goes_aside(model: HeatmapModel, drive: DriveLog) -> None:
    moment = heat_moment(model, drive)
    assert moment is not None and moment.planned.source == "grid"
    assert abs(moment.way[-1, 1]) > 0.5
    np.testing.assert_allclose(moment.way[0], 0, atol=1e-9)


def test_every_stage_is_drawn_and_says_where_it_is_from(
    model: HeatmapModel, paths: tuple[Path, ...], drive: DriveLog
) -> None:
    section = heatmap_section(model, [open_log(path) for path in paths], drive)
    captions = [picture.caption for picture in section.pictures]
    assert [caption.split(".")[0] for caption in captions[:5]] == ["As Fig"] * 5
    for caption, figure in zip(captions, ("4.6-4.7", "4.9", "4.10", "4.11", "4.12"), strict=False):
        assert caption.startswith(f"As Fig. {figure}")
    assert "held out of training" in captions[0] and "of 4 drives" in captions[0]
    assert "4 runs, of which 1 were held out" in captions[5]
    assert all(f"Log {drive.name}" in caption for caption in captions[3:5])
    assert png(section.pictures[0].figure)[:4] == b"\x89PNG"


def test_without_losses_in_the_file_there_are_no_learning_curves(
    model: HeatmapModel, paths: tuple[Path, ...], drive: DriveLog
) -> None:
    older = replace(model, metadata={"logs": [], "pairs": 1})
    demonstrated = [open_log(path) for path in paths[:2]]
    assert len(heatmap_section(older, demonstrated, drive).pictures) == 5
    assert "may have been trained on" in heatmap_figures(older, demonstrated, drive)[0].caption
