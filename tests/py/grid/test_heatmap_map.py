"""Alg. 4: local heatmaps put together along a drive, against NumPy, and the hazards of ERRATA 32."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.geometry import Pose2
from lfdcore.grid import HeatmapMap, OccupancyGrid

CENTRES = (np.arange(100) + 0.5) * 0.05 - 2.5
MAP = OccupancyGrid(np.zeros((180, 220), np.int8), 0.05, (-5.0, -4.0))
SEEN = np.ones((100, 100), bool)

Frame = tuple[NDArray[np.float32], NDArray[np.bool_], Pose2]


def cells_of(pose: Pose2) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    x, y = np.meshgrid(CENTRES, CENTRES)
    c, s = np.cos(pose.yaw), np.sin(pose.yaw)
    ix = np.floor((pose.x + c * x - s * y + 5.0) / 0.05).astype(int)
    iy = np.floor((pose.y + s * x + c * y + 4.0) / 0.05).astype(int)
    return ix, iy, (ix >= 0) & (iy >= 0) & (ix < 220) & (iy < 180)


def slow(frames: list[Frame]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    total, count = np.zeros((180, 220)), np.zeros((180, 220), int)
    for heat, visible, pose in frames:
        shown = np.where(visible, heat, 0).astype(float)
        shown /= shown.max() if shown.any() else 1
        ix, iy, inside = cells_of(pose)
        use = visible & inside
        np.add.at(total, (iy[use], ix[use]), shown[use])
        np.add.at(count, (iy[use], ix[use]), 1)
    return np.where(count > 0, total / np.maximum(count, 1), 0), count


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), frames=st.integers(0, 4))
def test_the_map_is_that_of_numpy(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    drive: list[Frame] = [
        (
            rng.random((100, 100)).astype(np.float32) * rng.choice([0, 0.3, 7]).astype(np.float32),
            rng.random((100, 100)) < rng.choice([0, 0.5, 1]),
            Pose2(*rng.uniform(-6.0, 6.0, 2), rng.uniform(-3, 3)),
        )
        for _ in range(frames)
    ]
    together = HeatmapMap(MAP)
    for heat, visible, pose in drive:
        assert together.insert(heat, visible, pose) == (visible & ~cells_of(pose)[2]).sum()
    wanted, count = slow(drive)
    np.testing.assert_array_equal(together.count, count)
    np.testing.assert_allclose(together.heatmap(), wanted, atol=1e-6)
    assert together.heatmap().max() <= 1


def test_repeated_cells_of_a_frame_all_count() -> None:
    """ERRATA 32: at .785 rad one cell in six shares its cell of the map with another."""
    together = HeatmapMap(MAP)
    together.insert(np.ones((100, 100), np.float32), SEEN, Pose2(0, 0, 0.785))
    assert together.count.sum() == 10_000
    assert (together.count > 1).sum() > 1000
    assert set(np.unique(together.heatmap())) == {0.0, 1.0}


def test_only_visible_cells_enter_and_scale() -> None:
    heat = np.full((100, 100), 0.5, np.float32)
    heat[0, 0] = 1  # hidden, so not the maximum
    visible = SEEN.copy()
    visible[0] = False
    together = HeatmapMap(MAP)
    together.insert(heat, visible, Pose2(0.0, 0.0, 0.0))
    assert together.count.sum() == 9900
    assert together.heatmap().max() == 1
    assert together.heatmap().sum() == 9900


def test_a_frame_without_heat_counts_as_seen_and_cold() -> None:
    together = HeatmapMap(MAP)
    together.insert(np.ones((100, 100), np.float32), SEEN, Pose2())
    together.insert(np.zeros((100, 100), np.float32), SEEN, Pose2())
    together.insert(np.ones((100, 100), np.float32), ~SEEN, Pose2())
    assert together.count.max() == 2
    assert together.heatmap().max() == 0.5


def test_what_is_not_a_heatmap_is_refused_and_leaves_no_trace() -> None:
    together, heat = HeatmapMap(MAP), np.ones((100, 100), np.float32)
    for wrong in (np.nan, np.inf, -0.1):
        bad = heat.copy()
        bad[3, 4] = wrong
        with pytest.raises(ValueError, match="heatmap holds values that are negative or not finite"):
            together.insert(bad, SEEN, Pose2())
    with pytest.raises(ValueError, match="heatmap is 99 x 100, must be 100 x 100, the local window"):
        together.insert(heat[:99], SEEN, Pose2())
    with pytest.raises(ValueError, match="visible is 100 x 1"):
        together.insert(heat, SEEN[:, :1], Pose2())
    with pytest.raises(ValueError, match="T_map_base"):
        together.insert(heat, SEEN, Pose2(0, np.nan, 0))
    assert together.count.sum() == 0
