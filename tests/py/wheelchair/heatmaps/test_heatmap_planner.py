"""Planning over heatmaps (Ch. 4): laws of the product and of the path, and what there is where nothing is meant."""

from pathlib import Path

import numpy as np
import pytest

from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan, ObstaclePoints, OccupancyGrid, local_grid
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from observed import observed
from synthetic_drive import L_WALLS, T_BASE_LASER, cast

POSE = Pose2(0.013, 0.007, 0.0)


@pytest.fixture(scope="module")
def planner(heatmap_model: Path) -> HeatmapPlanner:
    return HeatmapPlanner(HeatmapModel.load(heatmap_model), HeatmapPlannerConfig(), ChairGeometry.thesis())


def seen(stick: tuple[float, float], ranges: np.ndarray | None = None) -> Observation:
    if ranges is None:
        laser = POSE * T_BASE_LASER
        ranges = cast(np.array([laser.x, laser.y]), laser.yaw + np.radians(np.arange(181) - 90.0), L_WALLS)
        ranges = np.where(ranges < 30, ranges, np.inf)
    scan = LaserScan(ranges.astype(np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)
    return observed(0.0, scan, stick, pose=POSE)


def around(observation: Observation) -> tuple[OccupancyGrid, ObstaclePoints]:
    grid = local_grid(observation.scan, T_BASE_LASER)
    iy, ix = np.nonzero(grid.occupied_mask())
    return grid, ObstaclePoints(np.stack([ix + 0.5, iy + 0.5], axis=1) * 0.05 - 2.5)


def test_intent_is_the_product_over_free_cells_divided_by_its_maximum(planner: HeatmapPlanner) -> None:
    observation = seen((0.7, 0.2))
    grid, _ = around(observation)
    heat = planner.heat(observation, grid)
    assert heat is not None
    product = heat.sensor * heat.user * (grid.data == 0)
    np.testing.assert_allclose(heat.intent, product / product.max(), atol=1e-6)
    assert heat.intent.max() == 1 and not heat.intent[grid.data != 0].any()


@pytest.mark.parametrize("stick", [(0.8, 0.0), (0.7, 0.1), (0.6, -0.2)])
def test_a_path_keeps_clear_of_what_was_seen_and_follows_the_stick(
    planner: HeatmapPlanner, stick: tuple[float, float]
) -> None:
    observation = seen(stick)
    grid, obstacles = around(observation)
    found = planner.plan(observation, grid, obstacles)
    assert found is not None
    cells = np.floor((found.path + 2.5) / 0.05).astype(int)
    assert not grid.occupied_mask()[cells[:, 1], cells[:, 0]].any()
    assert found.likelihood > 0 and found.path[-1, 0] > 0.3
    assert found.rollout is not None


def test_the_stick_decides_the_side(planner: HeatmapPlanner) -> None:
    open_space = np.full(181, np.inf)
    ends = []
    for left in (0.5, -0.5):
        observation = seen((0.5, left), open_space)
        found = planner.plan(observation, *around(observation))
        assert found is not None
        ends.append(found.path[-1, 1])
    assert ends[0] > 0.2 and ends[1] < -0.2


def test_a_stick_at_rest_means_nothing_and_complies_with_nothing(planner: HeatmapPlanner) -> None:
    observation = seen((0.0, 0.0))
    assert planner.heat(observation, around(observation)[0]) is None
    assert planner.plan(observation, *around(observation)) is None
    assert not planner.compliances(np.array([[0.8, 0.0], [0.5, 0.5]]), np.zeros(2)).any()


def test_a_scan_that_sees_nothing_gives_no_path(planner: HeatmapPlanner) -> None:
    observation = seen((0.8, 0.0), np.full(181, np.nan))
    grid, obstacles = around(observation)
    heat = planner.heat(observation, grid)
    assert heat is not None and not heat.sensor.any() and not heat.intent.any()
    assert planner.plan(observation, grid, obstacles) is None


def test_compliance_falls_with_the_angle_from_the_stick(planner: HeatmapPlanner) -> None:
    angles = np.radians([0.0, 10, 20, 30, 40])
    points = 0.8 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    found = planner.compliances(points, np.array([0.8, 0.0]))
    assert found[0] > 0.9 and (np.diff(found) < 0).all()


def test_the_printed_compliance_is_the_user_heatmaps_value_at_the_control_point(heatmap_model: Path) -> None:
    """ERRATA 29: it holds the distance filter, so even where the stick points a look-ahead on it stays under .9."""
    printed = HeatmapPlanner(HeatmapModel.load(heatmap_model), HeatmapPlannerConfig.thesis(), ChairGeometry.thesis())
    stick, observation = np.array([0.8, 0.1]), seen((0.8, 0.1))
    heat = printed.heat(observation, around(observation)[0])
    assert heat is not None
    points = np.array([[0.83, 0.08], [0.5, -0.4], [2.4, 0.31]])
    cells = np.floor((points + 2.5) / 0.05).astype(int)
    found = printed.compliances(points, stick)
    np.testing.assert_array_equal(found, heat.user[cells[:, 1], cells[:, 0]])
    assert found.max() > 0.5
    way = heat.orientation.mean + np.linspace(-0.3, 0.3, 121)
    nearby = 0.8 * np.stack([np.cos(way), np.sin(way)], axis=1)
    assert printed.compliances(nearby, stick).max() < 0.9
    assert not printed.compliances(nearby, np.zeros(2)).any()
