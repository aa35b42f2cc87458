"""RayCaster against a slow walk from cell to cell, and its laws."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.geometry import Pose2
from lfdcore.grid import OccupancyGrid, RayCaster

Mask = npt.NDArray[np.bool_]


def random_grid(rng: np.random.Generator, height: int, width: int, density: float, resolution: float) -> OccupancyGrid:
    data = np.where(rng.random((height, width)) < density, 100, rng.choice([0, -1], (height, width)))
    return OccupancyGrid(data.astype(np.int8), resolution, (-1.3, 0.7))


def walk(occupied: Mask, x: float, y: float, angle: float, reach: float) -> float:
    """Cells from (x, y) to the entry into the first occupied cell, one cell at a time; inf if none within reach."""
    dx, dy = math.cos(angle), math.sin(angle)
    height, width = occupied.shape
    ix, iy, t = math.floor(x), math.floor(y), 0.0
    while 0 <= ix < width and 0 <= iy < height and t <= reach:
        if occupied[iy, ix]:
            return t
        t_x = (ix + (dx > 0) - x) / dx if dx else math.inf
        t_y = (iy + (dy > 0) - y) / dy if dy else math.inf
        t = min(t_x, t_y)
        if t_x < t_y:
            ix += 1 if dx > 0 else -1
        else:
            iy += 1 if dy > 0 else -1
    return math.inf


@pytest.mark.parametrize("density", [0.0, 0.002, 0.05, 0.4])
@pytest.mark.parametrize(("height", "width"), [(1, 1), (3, 70), (70, 3), (120, 90), (300, 600)])
def test_equals_a_walk_from_cell_to_cell(density: float, height: int, width: int) -> None:
    rng = np.random.default_rng(height + int(1000 * density))
    resolution, range_max = 0.05, 12.0
    grid = random_grid(rng, height, width, density, resolution)
    caster = RayCaster(grid, range_max)
    for _ in range(10):
        x, y = rng.uniform(0, width), rng.uniform(0, height)
        pose = Pose2(grid.origin[0] + x * resolution, grid.origin[1] + y * resolution, rng.uniform(-3, 3))
        angles = rng.uniform(-7, 7, 40)
        occupied = grid.occupied_mask()
        expected = [walk(occupied, x, y, pose.yaw + a, range_max / resolution) * resolution for a in angles]
        # The walk starts from a position that was not rounded by the map's origin.
        np.testing.assert_allclose(caster.cast(pose, angles), expected, rtol=1e-6, atol=1e-6)


def box(height: int, width: int) -> OccupancyGrid:
    data = np.full((height, width), 100, np.int8)
    data[1:-1, 1:-1] = 0
    return OccupancyGrid(data, 1.0)


def test_a_beam_along_an_axis_ends_at_the_wall() -> None:
    ranges = RayCaster(box(7, 12), 50.0).cast(Pose2(2.25, 3.5), np.array([0, math.pi / 2, math.pi, -math.pi / 2]))
    np.testing.assert_allclose(ranges, [8.75, 2.5, 1.25, 2.5], rtol=1e-6)


@pytest.mark.parametrize("angle", [0, math.pi / 2, math.pi, -math.pi / 2, math.pi / 4, -3 * math.pi / 4])
def test_a_beam_along_a_cell_border_or_through_corners_ends_at_the_box(angle: float) -> None:
    ranges = RayCaster(box(11, 11), 50.0).cast(Pose2(5.0, 5.0), np.array([angle]))
    assert 4.0 - 1e-6 <= ranges[0] <= 5 * math.sqrt(2) + 1e-6


def test_beams_that_leave_the_map_or_reach_beyond_range_max_see_nothing() -> None:
    data = np.zeros((10, 10), np.int8)
    data[:, 9] = 100
    grid = OccupancyGrid(data, 1.0)
    np.testing.assert_array_equal(RayCaster(grid, 20.0).cast(Pose2(1.5, 5.5), np.array([math.pi])), [np.inf])
    np.testing.assert_array_equal(RayCaster(grid, 7.4).cast(Pose2(1.5, 5.5), np.array([0.0])), [np.inf])
    np.testing.assert_allclose(RayCaster(grid, 7.6).cast(Pose2(1.5, 5.5), np.array([0.0])), [7.5])


def test_a_laser_in_an_occupied_cell_sees_distance_zero() -> None:
    np.testing.assert_array_equal(RayCaster(box(5, 5), 9.0).cast(Pose2(0.5, 0.5), np.linspace(-3, 3, 7)), np.zeros(7))


def test_a_laser_outside_the_map_sees_what_lies_inside() -> None:
    caster = RayCaster(box(5, 5), 9.0)
    np.testing.assert_allclose(caster.cast(Pose2(-2.0, 2.5), np.array([0.0, math.pi])), [2.0, np.inf])
    assert np.isinf(caster.cast(Pose2(-1e6, 2.5), np.array([0.0]))).all()


def test_an_empty_square_wider_than_a_byte_can_say_is_crossed() -> None:
    data = np.zeros((700, 1500), np.int8)
    data[:, 1400] = 100
    caster = RayCaster(OccupancyGrid(data, 0.05), 100.0)
    np.testing.assert_allclose(caster.cast(Pose2(0.5 * 0.05, 17.0), np.array([0.0])), [1399.5 * 0.05], rtol=1e-6)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_mirrored_map_gives_mirrored_ranges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((40, 60)) < 0.05, 100, 0).astype(np.int8)
    x, y, yaw = rng.uniform(0, 60), rng.uniform(0, 40), rng.uniform(-3, 3)
    angles = rng.uniform(-3, 3, 50)
    ranges = RayCaster(OccupancyGrid(data, 1.0), 100.0).cast(Pose2(x, y, yaw), angles)
    mirrored = RayCaster(OccupancyGrid(data[::-1].copy(), 1.0), 100.0).cast(Pose2(x, 40 - y, -yaw), -angles)
    np.testing.assert_allclose(ranges, mirrored, rtol=1e-5, atol=1e-5)


def test_the_field_of_view_may_be_empty_but_not_two_dimensional() -> None:
    caster = RayCaster(box(5, 5), 9.0)
    assert caster.cast(Pose2(2, 2), np.array([])).shape == (0,)
    with pytest.raises(ValueError, match="angles has 2 dimensions"):
        caster.cast(Pose2(2, 2), np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("pose", "angles", "name"),
    [
        (Pose2(math.nan, 0, 0), [0.0], "T_map_laser.x"),
        (Pose2(0, math.inf, 0), [0.0], "T_map_laser.y"),
        (Pose2(0, 0, math.nan), [0.0], "T_map_laser.yaw"),
        (Pose2(1e30, 0, 0), [0.0], "T_map_laser.x"),
        (Pose2(0, 0, 0), [0.0, math.nan], "heading of beam 1"),
    ],
)
def test_what_is_not_finite_is_refused_by_name(pose: Pose2, angles: list[float], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        RayCaster(box(5, 5), 9.0).cast(pose, np.array(angles))


@pytest.mark.parametrize("range_max", [0.0, -1.0, math.nan, math.inf])
def test_range_max_must_be_positive_and_finite(range_max: float) -> None:
    with pytest.raises(ValueError, match="range_max"):
        RayCaster(box(5, 5), range_max)
