"""The a-posteriori comparison: Alg. 4's law, every figure against a count by hand, three methods side by side."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import percentileofscore

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import way_ahead
from lfdcore.errors import ModelError
from lfdcore.geometry import Pose2
from lfdcore.grid import HeatmapMap, OccupancyGrid
from lfdcore.study.demonstrations import drive_to_destinations
from lfdcore.study.heatmaps.comparison import (
    METHODS,
    REACH,
    Comparison,
    ComparisonConfig,
    ModelFiles,
    compare_on_log,
    compare_on_logs,
    path_deviations,
    reward_at,
    run_map,
    squashed_values,
)
from lfdcore.wheelchair.heatmaps.model import NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.sensor import NaiveHeatmap

STRAIGHT = np.stack([np.arange(0, 3.01, 0.05), np.zeros(61)], axis=1)


def canvas(width: int = 120, height: int = 110) -> OccupancyGrid:
    return OccupancyGrid(np.full((height, width), -1, np.int8), 0.05, (-3.0, -2.75))


# ---- squashing and Alg. 4 ------------------------------------------------------------------------------------------


@settings(max_examples=50, deadline=None)
@given(st.floats(0.01, 1e4), st.floats(-1e4, 1e4), st.integers(0, 100))
def test_squashing_takes_away_scale_and_offset_and_keeps_the_order(scale: float, offset: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    values, entered = rng.random((100, 100)), rng.random((100, 100)) < 0.6
    plain, moved = squashed_values(values, entered), squashed_values(scale * values + offset, entered)
    np.testing.assert_allclose(moved, plain, atol=1e-4)
    assert plain[entered].min() == 0 and plain[entered].max() == 1 and not plain[~entered].any()
    assert (np.diff(plain[entered][np.argsort(values[entered])]) >= 0).all()


def test_a_frame_without_differences_or_cells_is_all_zero_and_what_is_not_entered_may_be_nan() -> None:
    every, none = np.ones((100, 100), bool), np.zeros((100, 100), bool)
    assert not squashed_values(np.full((100, 100), -7.0), every).any()
    assert not squashed_values(np.full((100, 100), np.nan), none).any()
    with pytest.raises(ValueError, match="no finite value"):
        squashed_values(np.full((100, 100), np.nan), every)


@settings(max_examples=10, deadline=None)
@given(st.lists(st.tuples(st.floats(-0.4, 0.4), st.floats(-3.1, 3.1)), min_size=1, max_size=3), st.integers(0, 99))
def test_concatenation_is_algorithm_4_cell_by_cell_with_repeated_cells_and_zero_frames(
    poses: list[tuple[float, float]], seed: int
) -> None:
    rng, grid = np.random.default_rng(seed), canvas()
    built, total, count = HeatmapMap(grid), np.zeros((110, 120)), np.zeros((110, 120), int)
    for k, (x, yaw) in enumerate(poses):
        visible = rng.random((100, 100)) < 0.5
        heat = np.zeros((100, 100), np.float32) if k == 1 else rng.random((100, 100)).astype(np.float32)
        built.insert(heat, visible, Pose2(x, 0.1, yaw))
        most = heat[visible].max(initial=0.0) or 1.0
        iy, ix = np.nonzero(visible)
        centres = Pose2(x, 0.1, yaw).transform(np.stack([ix * 0.05 - 2.475, iy * 0.05 - 2.475], axis=1))
        cells = np.floor((centres - np.array(grid.origin)) / 0.05).astype(int)
        inside = ((cells >= 0) & (cells < (120, 110))).all(axis=1)
        np.add.at(total, tuple(cells[inside, ::-1].T), heat[visible][inside] / most)
        np.add.at(count, tuple(cells[inside, ::-1].T), 1)
    np.testing.assert_array_equal(built.count, count)
    np.testing.assert_allclose(built.heatmap(), np.where(count > 0, total / np.maximum(count, 1), 0), atol=1e-5)


# ---- metrics -------------------------------------------------------------------------------------------------------


def test_reward_and_rank_are_those_counted_by_hand() -> None:
    heat, seen, grid = np.zeros((110, 120), np.float32), np.zeros((110, 120), bool), canvas()
    seen[50, 60:70] = True
    heat[50, 60:70] = np.arange(10) / 10
    positions = np.array(grid.origin) + (np.array([[69, 50], [60, 50]]) + 0.5) * 0.05
    reward, rank = reward_at(heat, seen, grid, positions)
    assert reward == pytest.approx((0.9 + 0.0) / 2)
    assert rank == pytest.approx((95 + 5) / 2)  # 9 of 10 lie lower and it equals itself, which counts half
    by_scipy = np.mean([percentileofscore(heat[seen], value, "mean") for value in heat[50, [69, 60]]])
    assert rank == pytest.approx(by_scipy)


def test_rank_does_not_depend_on_the_scale_and_is_50_for_a_map_without_differences() -> None:
    rng, grid = np.random.default_rng(1), canvas()
    heat, seen = rng.random((110, 120)).astype(np.float32), np.ones((110, 120), bool)
    positions = rng.uniform(-2, 2, (30, 2))
    assert reward_at(heat**3, seen, grid, positions)[1] == pytest.approx(reward_at(heat, seen, grid, positions)[1])
    assert reward_at(np.ones_like(heat), seen, grid, positions) == pytest.approx((1.0, 50.0))
    assert np.isnan(reward_at(heat, ~seen, grid, positions)[1])
    with pytest.raises(ValueError, match="outside the map"):
        reward_at(heat, seen, grid, np.array([[9.0, 0.0]]))


def test_a_path_beside_a_straight_way_is_off_by_its_distance_at_every_reach() -> None:
    assert path_deviations(STRAIGHT + np.array([0, 0.1]), STRAIGHT) == pytest.approx((0.1, 0.1, 0.1))
    assert path_deviations(STRAIGHT, STRAIGHT) == pytest.approx((0, 0, 0), abs=1e-9)


def test_a_short_path_is_judged_as_far_as_it_goes_and_at_equal_arc_length_straight_on() -> None:
    short = np.array([[0.0, 0.0], [1.0, 0.0]])
    assert path_deviations(short, STRAIGHT) == pytest.approx((0, 0, 0), abs=1e-6)
    aside = np.array([[0.0, 0.0], [0.8, 0.0], [0.8, 1.0]])
    near, whole, equal = path_deviations(aside, STRAIGHT)
    s = np.arange(0.05, REACH + 1e-9, 0.05)
    assert near == pytest.approx(0, abs=1e-9)
    assert whole == pytest.approx(np.sqrt((np.maximum(s[s <= 1.8 + 1e-9] - 0.8, 0) ** 2).mean()))
    assert equal == pytest.approx(np.sqrt((2 * np.maximum(s - 0.8, 0) ** 2).mean()))


def test_nothing_is_compared_with_a_way_that_ends_within_the_look_ahead() -> None:
    assert np.isnan(path_deviations(STRAIGHT, STRAIGHT[:10])).all()
    assert np.isnan(path_deviations(STRAIGHT, STRAIGHT[:1])).all()


# ---- the methods side by side --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def home_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drive_to_destinations(tmp_path_factory.mktemp("home"), 1, runs=1, processes=1).paths[0]


@pytest.fixture(scope="module")
def files(home_model: Path, heatmap_model: Path, tmp_path_factory: pytest.TempPathFactory) -> ModelFiles:
    """Of the naive network only its file is real: it was never trained."""
    import torch

    from lfdcore.training.parts.heatmap_net import HeatmapNet, export_onnx

    torch.manual_seed(1)
    naive = tmp_path_factory.mktemp("naive") / "naive.safetensors"
    NaiveHeatmapModel(NaiveHeatmap(export_onnx(HeatmapNet(4), "naive", {}))).save(naive)
    return ModelFiles(home_model, naive, heatmap_model)


@pytest.fixture(scope="module")
def comparison(files: ModelFiles, home_log: Path) -> Comparison:
    return compare_on_logs([home_log], files, ComparisonConfig(period=2.0), processes=1)


def test_all_methods_are_asked_at_the_same_frames_and_answer_within_bounds(comparison: Comparison) -> None:
    run = comparison.runs[0]
    assert tuple(run.methods) == METHODS and comparison.frames == run.frames >= 5
    for found in run.methods.values():
        assert found.concatenated.shape == run.grid.data.shape
        assert found.concatenated.min() >= 0 and found.concatenated.max() <= 1
        assert 0 < found.reward < 1 and 0 <= found.rank <= 100 and 0 <= found.without_path <= 1
        assert len(found.near) == len(found.whole) == len(found.seconds) == run.frames
        assert (found.seconds > 0).all()


def test_learned_methods_give_the_driven_cells_more_than_most_others(comparison: Comparison) -> None:
    for method in ("primitives", "heatmaps"):
        assert comparison.column(method, "rank")[0] > 60


def test_a_comparison_is_the_same_every_time(comparison: Comparison, files: ModelFiles, home_log: Path) -> None:
    again = compare_on_log(open_log(home_log), files.load(), ComparisonConfig(period=2.0))
    for method in METHODS:
        np.testing.assert_array_equal(
            again.methods[method].concatenated, comparison.runs[0].methods[method].concatenated
        )
        assert again.methods[method].rank == comparison.runs[0].methods[method].rank


def test_the_map_holds_the_window_wherever_the_chair_went(comparison: Comparison, home_log: Path) -> None:
    log, grid = open_log(home_log), comparison.runs[0].grid
    assert run_map(log).origin == grid.origin
    low = np.array(grid.origin)
    high = low + np.array([grid.width, grid.height]) * grid.resolution
    assert (log.pose[:, :2].min(axis=0) - 3.5 > low - 0.1).all() and (
        log.pose[:, :2].max(axis=0) + 3.5 < high + 0.1
    ).all()
    assert (grid.data == 100).any() and (grid.data == 0).any()


def test_the_way_ahead_starts_at_the_chair_and_is_as_long_as_asked(home_log: Path) -> None:
    log = open_log(home_log)
    way = way_ahead(log, float(log.scan_stamp[60]), 2.0)
    np.testing.assert_allclose(way[0], 0, atol=1e-9)
    assert np.hypot(*np.diff(way, axis=0).T).sum() == pytest.approx(2.0, abs=0.15)
    assert way[-1, 0] > 0.5


def test_what_cannot_be_compared_is_said(files: ModelFiles, home_log: Path) -> None:
    with pytest.raises(ValueError, match="at least one drive"):
        compare_on_logs([], files)
    with pytest.raises(ModelError):
        compare_on_logs([home_log], ModelFiles(files.primitives, files.heatmaps, files.naive))
    log = open_log(home_log)
    standing = DriveLog(**{**vars(log), "twist": np.zeros_like(log.twist)})
    with pytest.raises(ValueError, match="no moment at which the chair drives forward"):
        compare_on_log(standing, files.load())
