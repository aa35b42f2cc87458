"""read_beams: what each kind of range means. local_grid against brute-force geometry, and its laws."""

import math
import pickle
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan, local_grid, read_beams

ON_THE_CHAIR = Pose2(0.70, 0.003, 0.0)


NEAREST, FARTHEST = 0.25, 8.0
RANGES = np.array([np.nan, -np.inf, np.inf, 0, -3, 0.125, 0.25, 2, 8, 40], np.float32)
"""every kind that a scanner of .25 to 8 m may give"""
LENGTHS = [0, 0.25, 8, 0, 0, 0, 0.25, 2, 8, 8]
HIT = [False, True, False, False, False, False, True, True, False, False]


def scan_of(ranges: npt.ArrayLike, field_of_view: float = math.pi, range_max: float = 30.0) -> LaserScan:
    values = np.asarray(ranges, np.float32)
    increment = field_of_view / max(len(values) - 1, 1)
    return LaserScan(values, -field_of_view / 2, increment, range_min=0.1, range_max=range_max)


def random_scan(rng: np.random.Generator, beams: int = 181) -> LaserScan:
    ranges = rng.uniform(0.05, 5.0, beams)
    ranges[rng.random(beams) < 0.1] = np.inf
    ranges[rng.random(beams) < 0.1] = np.nan
    ranges[rng.random(beams) < 0.03] = -np.inf
    return scan_of(ranges, rng.uniform(0.5, 2 * math.pi))


def grid_by_dense_sampling(scan: LaserScan, pose: Pose2) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.int8]]:
    """Cells in which points 0.2 mm apart along the beams lie; and the same with each cell's rim left out."""
    loose, strict = np.full((100, 100), -1, np.int8), np.full((100, 100), -1, np.int8)
    ends = []
    for r, angle in zip(scan.ranges.astype(float), pose.yaw + scan.angles(), strict=True):
        length = scan.range_max if r >= scan.range_max else scan.range_min if r == -np.inf else r
        if not length >= scan.range_min:
            continue
        t = np.arange(0, min(length, 12.0), 2e-4)
        at = np.column_stack([pose.x + t * np.cos(angle), pose.y + t * np.sin(angle)]) / 0.05 + 50
        at = at[((at > 0) & (at < 100)).all(axis=1)]
        cells = at.astype(int)
        loose[cells[:, 1], cells[:, 0]] = 0
        inner = cells[(np.abs(at - cells - 0.5) < 0.49).all(axis=1)]
        strict[inner[:, 1], inner[:, 0]] = 0
        if r < scan.range_max:
            ends.append((pose.x + length * np.cos(angle), pose.y + length * np.sin(angle)))
    for x, y in ends:
        ix, iy = math.floor(x / 0.05 + 50), math.floor(y / 0.05 + 50)
        if 0 <= ix < 100 and 0 <= iy < 100:
            loose[iy, ix] = strict[iy, ix] = 100
    return loose, strict


def test_every_kind_of_range_has_one_meaning() -> None:
    lengths, hit = read_beams(RANGES, NEAREST, FARTHEST)
    assert (lengths.dtype, hit.dtype) == (np.float64, np.bool_)
    assert lengths.tolist() == LENGTHS
    assert hit.tolist() == HIT


def test_0_is_a_hit_where_the_scanner_measures_from_0_on() -> None:
    lengths, hit = read_beams(np.array([0.0, -0.5], np.float32), 0.0, FARTHEST)
    assert lengths.tolist() == [0, 0]
    assert hit.tolist() == [True, False]


def test_many_scans_are_read_as_each_alone_and_a_scan_by_its_own_limits() -> None:
    rolled = np.array([np.roll(RANGES, k) for k in range(6)])
    for ranges in (rolled, rolled.reshape(2, 3, -1), rolled[:, ::2], rolled[:0]):
        lengths, hit = read_beams(ranges, NEAREST, FARTHEST)
        assert lengths.shape == hit.shape == ranges.shape
        for index in np.ndindex(ranges.shape[:-1]):
            scan = LaserScan(ranges[index], 0.0, 0.1, NEAREST, FARTHEST)
            alone, alone_hit = read_beams(scan)
            np.testing.assert_array_equal(lengths[index], alone)
            np.testing.assert_array_equal(hit[index], alone_hit)


@pytest.mark.parametrize(
    ("limits", "message"),
    [((-0.1, 8), "range_min is -0.1 m"), ((8, 8), "range_max is 8"), ((0, math.inf), "range_max is inf")],
)
def test_limits_that_no_scanner_has_are_refused_by_name(limits: tuple[float, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_beams(RANGES, *limits)


@pytest.mark.parametrize("ranges", [RANGES.astype(np.complex64), ["1.0", "2.0"], [None, 1.0], np.array([b"1.0"])])
def test_ranges_that_are_no_real_numbers_are_refused(ranges: Any) -> None:
    """NumPy would cut complex numbers, parse text and take None for NaN."""
    with pytest.raises(TypeError, match=r"ranges is of dtype .*, must be of real numbers"):
        read_beams(ranges, NEAREST, FARTHEST)


@pytest.mark.parametrize("kind", [np.float64, np.float16, np.int32, np.uint8, bool, list])
def test_real_numbers_of_any_kind_are_ranges(kind: Any) -> None:
    ranges = [1, 0, 3]
    given = ranges if kind is list else np.array(ranges, kind)
    lengths, _ = read_beams(given, 0.5, FARTHEST)
    np.testing.assert_array_equal(lengths, [1, 0, 1 if kind is bool else 3])


def test_a_scan_without_beams_shows_nothing() -> None:
    empty = scan_of([])
    lengths, hit = read_beams(empty)
    assert lengths.shape == hit.shape == empty.angles().shape == empty.ranges.shape == (0,)
    assert (local_grid(empty, Pose2(0.7, 0.0, 0.0)).data == -1).all()
    assert len(pickle.loads(pickle.dumps(empty)).ranges) == 0


def test_a_number_is_no_scan() -> None:
    with pytest.raises(ValueError, match="0 dimensions"):
        read_beams(np.array(1.0, np.float32), NEAREST, FARTHEST)


@pytest.mark.parametrize("seed", range(4))
def test_equals_dense_sampling_of_the_beams(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scan = random_scan(rng, 61)
    pose = Pose2(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-3, 3))
    loose, strict = grid_by_dense_sampling(scan, pose)
    grid = local_grid(scan, pose).data
    np.testing.assert_array_equal(grid == 100, loose == 100)
    assert (grid[strict == 0] == 0).all()
    # Cells that a beam only nicks fall between the samples: few of them, and next to sampled ones.
    extra = (grid == 0) & (loose == -1)
    assert extra.sum() <= 0.005 * (grid == 0).sum() + 1


def test_the_window_is_100_by_100_cells_with_base_link_at_its_centre() -> None:
    grid = local_grid(scan_of(np.full(181, 1.0)), ON_THE_CHAIR)
    assert grid.data.shape == (100, 100)
    assert grid.resolution == 0.05
    assert grid.origin == (-2.5, -2.5)


def test_a_wall_ahead_is_occupied_free_before_it_and_unknown_behind() -> None:
    angles = np.linspace(-math.pi / 2, math.pi / 2, 181)
    with np.errstate(divide="ignore"):
        ranges = np.where(np.abs(angles) < 0.8, 1.02 / np.cos(angles), np.inf)
    data = local_grid(scan_of(ranges), ON_THE_CHAIR).data
    column = int((0.70 + 1.02 + 2.5) / 0.05)
    assert (data[35:65, column] == 100).all()
    assert (data[35:65, column - 1] == 0).all()
    assert (data[40:60, column + 1 :] == -1).all()
    assert (data[:, :60] == -1).all(), "a field of view of 180 degrees sees nothing behind the laser"


def test_a_beam_into_the_open_is_free_to_the_windows_edge() -> None:
    for reach in (np.inf, 30.0, 81.9):
        data = local_grid(scan_of([reach], range_max=30.0), Pose2(0.70, 0.003, math.pi / 2)).data
        np.testing.assert_array_equal(data[50, 64:], 0)
        assert (data == -1).sum() == 100 * 100 - 36


def test_invalid_measurements_tell_nothing() -> None:
    data = local_grid(scan_of([np.nan, -1.0, 0.0, 0.05, np.nan]), ON_THE_CHAIR).data
    assert (data == -1).all()


def test_something_too_close_is_an_obstacle_at_range_min() -> None:
    scan = LaserScan(np.array([-np.inf], np.float32), 0.0, 0.1, range_min=0.22, range_max=30.0)
    data = local_grid(scan, ON_THE_CHAIR).data
    assert np.argwhere(data == 100).tolist() == [[50, int((0.70 + 0.22 + 2.5) / 0.05)]]


def test_a_laser_outside_the_window_marks_only_what_lies_inside() -> None:
    data = local_grid(scan_of([4.02]), Pose2(-5.0, 0.003, math.pi / 2)).data
    np.testing.assert_array_equal(data[50, :30], 0)
    assert data[50, 30] == 100
    assert (data == -1).sum() == 100 * 100 - 31
    assert (local_grid(scan_of([4.02]), Pose2(-5.0, 0.003, -math.pi / 2)).data == -1).all()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_mirrored_scan_gives_the_mirrored_grid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scan = random_scan(rng)
    pose = Pose2(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-3, 3))
    mirrored = LaserScan(
        scan.ranges, -scan.angle_min, -scan.angle_increment, range_min=scan.range_min, range_max=scan.range_max
    )
    data = local_grid(scan, pose).data
    np.testing.assert_array_equal(local_grid(mirrored, Pose2(pose.x, -pose.y, -pose.yaw)).data, data[::-1])


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_beams_in_reverse_order_give_the_same_grid(seed: int) -> None:
    scan = random_scan(np.random.default_rng(seed))
    last = scan.angles()[-1]
    backwards = LaserScan(
        scan.ranges[::-1], last, -scan.angle_increment, range_min=scan.range_min, range_max=scan.range_max
    )
    pose = Pose2(0.713, 0.021, 0.377)
    np.testing.assert_array_equal(local_grid(backwards, pose).data, local_grid(scan, pose).data)


def test_scans_and_poses_that_make_no_sense_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="angle_increment"):
        LaserScan(np.ones(3, np.float32), 0.0, 0.0)
    with pytest.raises(ValueError, match="range_max"):
        LaserScan(np.ones(3, np.float32), 0.0, 0.1, range_min=2.0, range_max=1.0)
    for bad in (Pose2(math.nan, 0, 0), Pose2(0, math.inf, 0), Pose2(0, 0, math.nan), Pose2(1e300, 0, 0)):
        with pytest.raises(ValueError, match="T_base_laser"):
            local_grid(scan_of([1.0, 2.0]), bad)
