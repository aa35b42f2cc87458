"""RollingMap against a slow list of points, and its claims."""

import math

import numpy as np
import numpy.typing as npt
import pytest

from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import LaserScan, OccupancyGrid, RayCaster, RollingMap, local_grid

LASER = Pose2(0.70, 0.0, 0.0)
Array = npt.NDArray[np.float64]


def scan_of(ranges: npt.ArrayLike, range_max: float = 30.0) -> LaserScan:
    values = np.asarray(ranges, np.float32)
    return LaserScan(values, -math.pi / 2, math.pi / max(len(values) - 1, 1), range_max=range_max)


CELL = 0.025  # [m]
NOTHING = scan_of(np.full(181, np.inf))


def one_beam(distance: float, yaw: float = 0.0) -> LaserScan:
    return LaserScan(np.array([distance], np.float32), yaw, 0.01)


class SlowMap:
    """The documented rules, on a dictionary of cells, every point against every beam."""

    def __init__(self, duration: float, half_side: int) -> None:
        self.duration, self.half_side = duration, half_side
        self.points: dict[tuple[int, int], tuple[float, float, float]] = {}

    def insert(self, stamp: float, scan: LaserScan, T_odom_base: Pose2) -> None:
        laser = T_odom_base * LASER
        ranges = scan.ranges.astype(float)
        angles = laser.yaw + scan.angles()
        hits = {}
        corner = [math.floor(v / CELL) - self.half_side for v in (T_odom_base.x, T_odom_base.y)]

        def inside(cell: tuple[int, int]) -> bool:
            return all(0 <= c - k < 2 * self.half_side for c, k in zip(cell, corner, strict=True))

        for r, a in zip(ranges, angles, strict=True):
            if r < scan.range_max:
                x, y = laser.x + r * math.cos(a), laser.y + r * math.sin(a)
                hits[math.floor(x / CELL), math.floor(y / CELL)] = (x, y, stamp)
        kept = {}
        lengths = np.where(ranges >= scan.range_max, scan.range_max, ranges)
        for cell, (x, y, seen) in self.points.items():
            dx, dy = x - laser.x, y - laser.y
            along, beside = dx * np.cos(angles) + dy * np.sin(angles), dx * np.sin(angles) - dy * np.cos(angles)
            through = ((along >= 0) & (np.abs(beside) <= 0.02) & (along + 0.3 <= lengths)).any()
            if seen >= stamp - self.duration and not through:
                kept[cell] = (x, y, seen)
        self.points = {cell: p for cell, p in {**kept, **hits}.items() if inside(cell)}

    def obstacles(self, T_odom_base: Pose2, radius: float) -> Array:
        points = T_odom_base.inverse().transform(np.array([p[:2] for p in self.points.values()]).reshape(-1, 2))
        return points[np.hypot(*points.T) <= radius]


def ordered(points: npt.ArrayLike) -> Array:
    rows = np.asarray(points).round(9)
    return rows[np.lexsort(rows.T)]


def a_world(rng: np.random.Generator) -> RayCaster:
    data = np.zeros((200, 300), np.int8)
    data[[0, -1]] = 100
    data[:, [0, -1]] = 100
    for _ in range(15):
        iy, ix = rng.integers(0, 190), rng.integers(0, 290)
        data[iy : iy + 8, ix : ix + 5] = 100
    return RayCaster(OccupancyGrid(data, 0.05, (-7.0, -5.0)), 30.0)


@pytest.mark.parametrize("seed", range(3))
def test_keeps_the_points_that_the_slow_list_of_points_keeps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = a_world(rng)
    fast, slow = RollingMap(duration=2.0, radius=4.0), SlowMap(2.0, 256)
    pose = Pose2(0.0, 0.0, 0.3)
    for step in range(60):
        if step % 20 == 10:
            world = a_world(rng)  # the furniture moves
        laser = pose * LASER
        ranges = world.cast(laser, NOTHING.angles()) + rng.normal(0, 0.01, 181).astype(np.float32)
        ranges[(rng.random(181) < 0.02) | (ranges < 0)] = np.inf
        fast.insert(0.1 * step, scan_of(ranges), LASER, pose)
        slow.insert(0.1 * step, scan_of(ranges), pose)
        assert len(fast) == len(slow.points)
        np.testing.assert_allclose(
            ordered(fast.obstacles(pose).points), ordered(slow.obstacles(pose, 4.0)), rtol=0, atol=2e-9
        )
        pose = pose * Pose2(0.05, 0.0, rng.normal(0, 0.1))


def test_points_are_not_rounded_to_cells() -> None:
    rolling = RollingMap()
    rolling.insert(0.0, one_beam(1.2345), LASER, Pose2(3.0, -4.0, 0.5))
    np.testing.assert_allclose(rolling.obstacles(Pose2(3.0, -4.0, 0.5)).points, [[0.70 + 1.2345, 0.0]], atol=1e-6)


def test_covers_beside_the_body_what_the_lidar_no_longer_sees() -> None:
    rolling = RollingMap()
    rolling.insert(0.0, one_beam(1.0, -0.6), LASER, Pose2())  # a post ahead, to the right
    ahead = Pose2(1.4, 0.0, 0.0)
    rolling.insert(2.0, NOTHING, LASER, ahead)
    obstacles = rolling.obstacles(ahead)
    np.testing.assert_allclose(obstacles.points, [[0.70 + math.cos(-0.6) - 1.4, math.sin(-0.6)]], atol=1e-6)
    assert obstacles.clearance(Pose2(), Footprint()) == pytest.approx(-math.sin(-0.6) - 0.35, abs=1e-6)


def test_a_point_is_forgotten_after_its_duration_and_not_before() -> None:
    rolling = RollingMap(duration=5.0)
    rolling.insert(100.0, one_beam(1.0), LASER, Pose2())
    blind = LaserScan(np.array([np.nan], np.float32), 0.0, 0.01)
    rolling.insert(105.0, blind, LASER, Pose2())
    assert len(rolling) == 1
    rolling.insert(105.01, blind, LASER, Pose2())
    assert len(rolling) == 0


@pytest.mark.parametrize(
    ("beam", "kept"),
    [
        (one_beam(1.31), False),  # goes on for 0.31 m
        (one_beam(1.29), True),  # ends 0.29 m behind: noise, or the obstacle moved away slowly
        (one_beam(math.inf), False),
        (one_beam(math.nan), True),
        (one_beam(-math.inf), True),
        (one_beam(math.inf, 0.019), False),  # passes at 0.019 m
        (one_beam(math.inf, 0.021), True),
        (one_beam(math.inf, math.pi), True),  # the other way
    ],
)
def test_a_point_is_forgotten_when_a_beam_goes_on_behind_it(beam: LaserScan, kept: bool) -> None:
    rolling = RollingMap()
    base = Pose2(0.01, 0.02, 0.0)
    rolling.insert(0.0, one_beam(1.0), LASER, base)
    rolling.insert(0.1, beam, LASER, base)
    points = rolling.obstacles(base).points
    assert np.isclose(points, [1.70, 0.0], atol=1e-6).all(axis=1).any() == kept


def test_a_cell_that_the_same_scan_hits_is_kept_although_another_beam_passes_it() -> None:
    rolling = RollingMap()
    rolling.insert(0.0, LaserScan(np.array([1.0, 1.0], np.float32), 0.0, 0.01), LASER, Pose2(0.01, 0.02, 0.0))
    rolling.insert(0.1, LaserScan(np.array([1.0, np.inf], np.float32), 0.0, 0.01), LASER, Pose2(0.01, 0.02, 0.0))
    np.testing.assert_allclose(rolling.obstacles(Pose2(0.01, 0.02, 0.0)).points, [[1.70, 0.0]], atol=1e-6)


@pytest.mark.parametrize("increment", [0.01, -0.01])
@pytest.mark.parametrize("turn", [0.0, 2 * math.pi, -4 * math.pi])
def test_beams_are_found_however_the_scan_turns(increment: float, turn: float) -> None:
    def fan(ranges: npt.ArrayLike) -> LaserScan:
        return LaserScan(np.asarray(ranges, np.float32), turn - 200 * increment, increment)

    rolling = RollingMap()
    rolling.insert(0.0, one_beam(1.0, 1.5), LASER, Pose2())
    rolling.insert(0.1, fan(np.full(401, np.inf)), LASER, Pose2())
    assert len(rolling) == 0


def test_a_standing_scene_needs_no_more_points_however_long_it_is_seen() -> None:
    world = a_world(np.random.default_rng(5))
    rolling = RollingMap(duration=1e6)
    ranges = world.cast(LASER, NOTHING.angles())
    sizes = []
    for step in range(50):
        rolling.insert(0.1 * step, scan_of(ranges), LASER, Pose2())
        sizes.append(len(rolling))
    assert set(sizes) == {sizes[0]}


@pytest.mark.parametrize("jump", [Pose2(12.7, 0, 0), Pose2(-300.0, 40.0, 1.0), Pose2(9e6, -9e6, 2.0)])
def test_a_jump_of_the_odometry_forgets_what_it_leaves_behind(jump: Pose2) -> None:
    rolling = RollingMap()
    rolling.insert(0.0, scan_of(np.full(181, 2.0)), LASER, Pose2())
    assert len(rolling) > 50
    rolling.insert(0.1, one_beam(1.0), LASER, jump)
    assert len(rolling) == 1
    assert len(rolling.obstacles(jump)) == 1
    data = rolling.local_grid(jump).data
    assert (data == 100).sum() == 1
    assert (data == 0).sum() < 60


def test_only_points_within_the_radius_are_given() -> None:
    rolling = RollingMap(radius=2.0)
    rolling.insert(0.0, LaserScan(np.array([1.29, 1.31], np.float32), 0.0, 1e-4), LASER, Pose2())
    np.testing.assert_allclose(rolling.obstacles(Pose2()).points, [[1.99, 0.0]], atol=1e-6)


def test_the_local_grid_of_one_scan_has_the_hits_of_local_grid_and_about_its_free_cells() -> None:
    world = a_world(np.random.default_rng(8))
    scan = scan_of(world.cast(LASER, NOTHING.angles()))
    rolling = RollingMap()
    rolling.insert(0.0, scan, LASER, Pose2())
    ours, one = rolling.local_grid(Pose2()).data, local_grid(scan, LASER).data
    np.testing.assert_array_equal(ours == 100, one == 100)
    assert ((ours == 0) != (one == 0)).mean() < 0.002  # beams along cell borders


def test_the_local_grid_remembers_free_cells_for_the_duration_and_turns_with_the_robot() -> None:
    rolling = RollingMap(duration=5.0)
    assert (rolling.local_grid(Pose2()).data == -1).all()
    rolling.insert(0.0, NOTHING, LASER, Pose2())
    behind = Pose2(0.7, 0.0, math.pi)
    free = rolling.local_grid(behind).data == 0
    assert free[:, :40].mean() > 0.95
    assert not free[:, 52:].any()
    rolling.insert(5.1, LaserScan(np.array([np.nan], np.float32), 0.0, 0.01), LASER, behind)
    assert (rolling.local_grid(behind).data == -1).all()


def test_clear_forgets_points_free_cells_and_stamps() -> None:
    rolling = RollingMap()
    rolling.insert(50.0, scan_of(np.full(181, 2.0)), LASER, Pose2())
    rolling.clear()
    assert len(rolling) == 0
    assert (rolling.local_grid(Pose2()).data == -1).all()
    rolling.insert(1.0, one_beam(1.0), LASER, Pose2())
    assert len(rolling) == 1


def test_a_stamp_before_the_last_is_refused_and_changes_nothing_an_equal_one_is_accepted() -> None:
    rolling = RollingMap()
    rolling.insert(2.0, one_beam(1.0), LASER, Pose2())
    with pytest.raises(ValueError, match=r"stamp is 1.9.* s, must not precede"):
        rolling.insert(1.9, one_beam(math.inf), LASER, Pose2())
    assert len(rolling) == 1
    rolling.insert(2.0, one_beam(1.0, 0.5), LASER, Pose2())
    assert len(rolling) == 2


def test_what_makes_no_sense_is_refused_by_name() -> None:
    rolling = RollingMap()
    for bad in (math.nan, math.inf):
        with pytest.raises(ValueError, match="stamp"):
            rolling.insert(bad, NOTHING, LASER, Pose2())
        with pytest.raises(ValueError, match=r"T_odom_base\.x"):
            rolling.insert(0.0, NOTHING, LASER, Pose2(bad, 0, 0))
        with pytest.raises(ValueError, match=r"T_base_laser\.yaw"):
            rolling.insert(0.0, NOTHING, Pose2(0, 0, bad), Pose2())
        with pytest.raises(ValueError, match="T_odom_base"):
            rolling.obstacles(Pose2(0, bad, 0))
        with pytest.raises(ValueError, match="T_odom_base"):
            rolling.local_grid(Pose2(0, 0, bad))
    with pytest.raises(ValueError, match=r"T_odom_base\.y"):
        rolling.insert(0.0, NOTHING, LASER, Pose2(0, 1e12, 0))
    for duration in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match="duration"):
            RollingMap(duration=duration)
    for radius in (0.0, 21.0, math.nan):
        with pytest.raises(ValueError, match="radius"):
            RollingMap(radius=radius)


def test_absurd_but_valid_scans_neither_hang_nor_crash() -> None:
    rolling = RollingMap()
    for increment in (1e-300, 1e9, -1e300):
        scan = LaserScan(np.array([1.0, np.inf, 1e38, 3e38], np.float32), 1e9, increment, range_max=1e300)
        for stamp in (0.0, 0.1):
            rolling.insert(stamp, scan, LASER, Pose2())
        local_grid(scan, LASER)
        rolling.clear()
