"""RollingMap against a slow list of points, and its claims."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest

from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import LaserScan, OccupancyGrid, RayCaster, RollingMap, local_grid, read_beams

LASER = Pose2(0.70, 0.0, 0.0)
Array = npt.NDArray[np.float64]


def scan_of(ranges: npt.ArrayLike, range_max: float = 30.0) -> LaserScan:
    values = np.asarray(ranges, np.float32)
    return LaserScan(values, -math.pi / 2, math.pi / max(len(values) - 1, 1), range_max=range_max)


CELL = 0.025  # [m]
FILLED = 2.15  # [m] so near, points between fused points are given too
NOTHING = scan_of(np.full(181, np.inf))


def one_beam(distance: float, yaw: float = 0.0) -> LaserScan:
    return LaserScan(np.array([distance], np.float32), yaw, 0.01)


class SlowCells:
    """Where beams have passed, by every beam's crossings of every grid line. Absolute cells, 20 m around the origin."""

    HALF = 800

    def __init__(self) -> None:
        self.last_clear = np.zeros((1600, 1600), int)
        self.crossings = np.zeros((1600, 1600), int)

    def cell(self, x: Array, y: Array) -> tuple[Array, Array]:
        return np.floor(np.asarray(x) / CELL).astype(int) + self.HALF, np.floor(np.asarray(y) / CELL).astype(
            int
        ) + self.HALF

    def forget_outside(self, corner: list[int], side: int) -> None:
        self.corner, self.side = [c + self.HALF for c in corner], side
        x, y = self.corner
        inside = np.zeros_like(self.last_clear, bool)
        inside[x : x + side, y : y + side] = True
        self.last_clear[~inside] = self.crossings[~inside] = 0

    def cross(self, laser: Pose2, angle: float, length: float, sure: float, scan: int) -> None:
        direction = np.array([math.cos(angle), math.sin(angle)])
        lines = CELL * np.arange(-self.HALF, self.HALF + 1)
        at = np.concatenate([(lines - laser.x) / direction[0], (lines - laser.y) / direction[1], [0.0, length]])
        at = np.unique(at[(at >= 0) & (at <= length)])
        middle = (at[1:] + at[:-1]) / 2
        ix, iy = self.cell(laser.x + middle * direction[0], laser.y + middle * direction[1])
        centres = (np.stack([ix, iy]) - self.HALF + 0.5) * CELL - [[laser.x], [laser.y]]
        inside = [(c >= k) & (c < k + self.side) for c, k in zip((ix, iy), self.corner, strict=True)]
        surely = (direction @ centres <= sure) & inside[0] & inside[1]
        ix, iy = ix[surely], iy[surely]
        self.crossings[ix, iy] += self.last_clear[ix, iy] != scan
        self.last_clear[ix, iy] = scan

    def clear_around(self, place: Array, since: int) -> bool:
        ix, iy = self.cell(*place)
        if self.last_clear[ix, iy] < since or self.crossings[ix, iy] < 4:
            return False
        clear = self.last_clear[ix - 5 : ix + 6, iy - 5 : iy + 6] >= since
        near = clear[1:-1, 1:-1] | clear[:-2, 1:-1] | clear[2:, 1:-1] | clear[1:-1, :-2] | clear[1:-1, 2:]
        dx, dy = np.mgrid[-4:5, -4:5]
        return bool(near[dx**2 + dy**2 <= 16].all())


@dataclass(eq=False)
class SlowPoint:
    place: Array
    direction: Array
    mean_direction: Array
    since: float
    seen: float
    scan: int
    hits: int = 1
    drift: float = 0.0
    misses: int = 0
    young: bool = False


class SlowMap:
    """The documented rules, every point against every hit and every beam."""

    def __init__(self, duration: float, half_side: int, noise: float) -> None:
        self.duration, self.half_side, self.noise = duration, half_side, noise
        self.points: list[SlowPoint] = []
        self.cells = SlowCells()
        self.stamps = [-math.inf]

    def insert(self, stamp: float, scan: LaserScan, T_odom_base: Pose2) -> None:
        self.stamps.append(stamp)
        now, laser = len(self.stamps) - 1, T_odom_base * LASER
        self.corner = [math.floor(v / CELL) - self.half_side for v in (T_odom_base.x, T_odom_base.y)]
        self.points = [p for p in self.points if self.inside(p.place)]
        self.cells.forget_outside(self.corner, 2 * self.half_side)
        angles = laser.yaw + scan.angles()
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        lengths, hit = read_beams(scan)
        ends = np.array([laser.x, laser.y]) + lengths[:, None] * directions
        since = next(k for k, s in enumerate(self.stamps) if s >= stamp - 3.0)
        for end, direction in zip(ends[hit], directions[hit], strict=True):
            if self.inside(end):
                self.fuse(end, direction, now, since)
        for angle, length, ended in zip(angles, lengths, hit, strict=True):
            self.cells.cross(laser, angle, length, length - 3 * self.noise * ended, now)
        for end in ends[hit]:
            self.cells.crossings[self.cells.cell(*end)] = 0
        away = [p.place - [laser.x, laser.y] for p in self.points]
        self.points = [
            p for p, d in zip(self.points, away, strict=True) if not self.stale(p, d, lengths, directions, hit)
        ]

    def inside(self, place: Array) -> bool:
        return all(0 <= math.floor(v / CELL) - k < 2 * self.half_side for v, k in zip(place, self.corner, strict=True))

    def innovation(self, point: SlowPoint) -> float:
        return self.noise * math.sqrt(1 + 1 / point.hits)

    def fuse(self, end: Array, direction: Array, now: int, since: int) -> None:
        stamp, best, least, behind = self.stamps[now], None, 1.0, False
        for p in self.points:
            x, y = end - p.place
            along = (x * direction[0] + y * direction[1]) / (4 * self.innovation(p))
            beside = (x * direction[1] - y * direction[0]) / 0.015
            if abs(beside) > 1 or p.direction @ direction < 0.75:
                continue
            behind |= 1 < along <= 2 and p.hits > 2
            if abs(along) <= 1 and (along**2 + beside**2) / 2 <= least:
                best, least = p, (along**2 + beside**2) / 2
        if best is None and behind:
            return
        if best is None:
            best = SlowPoint(end, direction, direction, stamp, stamp, now)
            self.points.append(best)
        elif not (stood := self.average(best, end, direction, now)):
            best.young &= stamp - best.since < 3.0
            return
        elif stood >= 1.0:
            return
        best.young = best.young or self.is_young(best, since)

    def is_young(self, point: SlowPoint, since: int) -> bool:
        near = [p for p in self.points if np.hypot(*(p.place - point.place)) <= 0.06]
        recent = [p for p in near if point.seen - p.seen <= 0.5]
        stand = [p for p in near if p.since < point.since and (p.misses == 0 or p in recent)]
        if any(not p.young and p.seen - p.since >= 1.0 for p in stand):
            return False
        if self.cells.clear_around(point.place, since):
            return True
        return bool(self.cells.last_clear[self.cells.cell(*point.place)] >= since) and any(p.young for p in recent)

    def average(self, p: SlowPoint, end: Array, direction: Array, now: int) -> float:
        """-> how long [s] it had stood, if it has moved; else 0."""
        p.drift += 0.3 * ((end - p.place) @ direction - p.drift)
        p.hits = min(p.hits + 1, 100)
        p.place = p.place + (end - p.place) / p.hits
        p.mean_direction = p.mean_direction + (direction - p.mean_direction) / p.hits
        p.direction, p.seen, p.scan, p.misses = direction, self.stamps[now], now, 0
        if p.hits <= 5 or abs(p.drift) <= 2 * self.noise:
            return 0.0
        stood = p.seen - p.since
        p.place, p.drift, p.hits, p.since = p.place + p.drift * direction, 0.0, 5, p.seen
        return stood

    def stale(self, p: SlowPoint, away: Array, lengths: Array, directions: Array, hit: npt.NDArray[np.bool_]) -> bool:
        stamp = self.stamps[-1]
        if p.scan == len(self.stamps) - 1:
            return False
        if p.seen < stamp - self.duration or (p.young and stamp - p.seen > 3.0):
            return True
        along, left = directions @ away, directions[:, 1] * away[0] - directions[:, 0] * away[1]
        beyond = np.where(along >= 0, lengths - along - 3 * self.innovation(p), -1.0)
        beside = hit & (lengths - along - 3 * self.innovation(p) <= 0)
        beside &= np.hypot(*(lengths[:, None] * directions - away).T) <= 0.25
        ends = [
            any(beside[k] and left[k] * left[i] < 0 for k in (i - 1, i + 1) if 0 <= k < len(left))
            for i in range(len(left))
        ]
        through = ((beyond > 15 * np.abs(left)) & (beyond > 0) & (np.abs(left) <= 0.004) & ~np.array(ends)).any()
        to_left, to_right = left[(beyond > 0) & (left > 0)], -left[(beyond > 0) & (left <= 0)]
        if not through and not to_left.min(initial=np.inf) + to_right.min(initial=np.inf) <= 0.03:
            return False
        near = [q for q in self.points if np.hypot(*(q.place - p.place)) <= 5 * self.noise]
        if p.hits <= 2 and any(q.hits > 2 for q in near):
            return True
        p.misses += 1
        return p.misses >= 3

    def obstacles(self, T_odom_base: Pose2, radius: float) -> Array:
        """-> (M, 3): points [m] in base_link, and their uncertainty."""
        rows = []
        for p in self.points:
            error = 3 * self.noise / math.sqrt(p.hits)
            nearer = (error - 0.01) * p.mean_direction / np.hypot(*p.mean_direction)
            if np.hypot(*(p.place - [T_odom_base.x, T_odom_base.y])) <= radius:
                for place in [p.place, p.place - nearer][: 1 + (error - 0.01 >= 0.005)]:
                    rows.append([*T_odom_base.inverse().transform(place[None])[0], min(error, 0.01)])
        return np.array(rows).reshape(-1, 3)


def told(rolling: RollingMap, T_odom_base: Pose2) -> Array:
    obstacles = rolling.obstacles(T_odom_base)
    return np.column_stack([obstacles.points, obstacles.uncertainty])


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


@pytest.mark.parametrize(("seed", "noise"), [(0, 0.01), (1, 0.03)])
def test_keeps_the_points_that_the_slow_list_of_points_keeps(seed: int, noise: float) -> None:
    rng = np.random.default_rng(seed)
    world = a_world(rng)
    fast, slow = RollingMap(duration=4.0, radius=4.0, range_noise=noise), SlowMap(4.0, 256, noise)
    pose = Pose2(0.0, 0.0, 0.3)
    angles, young = np.linspace(-math.pi / 2, math.pi / 2, 91), 0
    for step in range(60):
        if step % 20 == 10:
            world = a_world(rng)  # the furniture moves
        laser = pose * LASER
        ranges = world.cast(laser, angles) + rng.normal(0, noise, 91).astype(np.float32)
        ranges[(rng.random(91) < 0.02) | (ranges < 0)] = np.inf
        fast.insert(0.1 * step, scan_of(ranges), LASER, pose)
        slow.insert(0.1 * step, scan_of(ranges), pose)
        assert len(fast) == len(slow.points)
        said, wanted = told(fast, pose), slow.obstacles(pose, 4.0)
        far = [ordered(rows[np.hypot(*rows[:, :2].T) > FILLED]) for rows in (said, wanted)]
        np.testing.assert_allclose(*far, rtol=0, atol=2e-9)
        assert {*map(tuple, wanted.round(7))} <= {*map(tuple, said.round(7))}
        young += sum(p.young for p in slow.points)
        pose = pose * Pose2(0.05, 0.0, rng.normal(0, 0.1))
    assert young > 20


def exact_map(**config: float) -> RollingMap:
    """Of a scanner with so little noise that every point is given once."""
    return RollingMap(range_noise=0.001, **config)


def test_points_are_not_rounded_to_cells() -> None:
    rolling = exact_map()
    rolling.insert(0.0, one_beam(1.2345), LASER, Pose2(3.0, -4.0, 0.5))
    np.testing.assert_allclose(rolling.obstacles(Pose2(3.0, -4.0, 0.5)).points, [[0.70 + 1.2345, 0.0]], atol=1e-6)


@pytest.mark.parametrize(
    ("hits", "expected"), [(1, [[1.7, 0.01], [1.68, 0.01]]), (9, [[1.7, 0.01]]), (36, [[1.7, 0.005]])]
)
def test_a_point_is_given_with_three_standard_errors_beyond_a_centimetre_along_its_beams(
    hits: int, expected: list[list[float]]
) -> None:
    rolling = RollingMap(range_noise=0.01)
    for step in range(hits):
        rolling.insert(0.1 * step, one_beam(1.0), LASER, Pose2())
    np.testing.assert_allclose(told(rolling, Pose2())[:, [0, 2]], expected, atol=1e-6)


def test_covers_beside_the_body_what_the_lidar_no_longer_sees() -> None:
    rolling = exact_map()
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


def test_a_scan_without_beams_is_as_one_that_measured_nothing() -> None:
    maps = [RollingMap(duration=2.0, own_body=Footprint()) for _ in range(2)]
    poses = [Pose2(0.05 * k, 0.0, 0.02 * k) for k in range(60)]
    for rolling, blind in zip(maps, (np.zeros(0), np.full(181, np.nan)), strict=True):
        for k, pose in enumerate(poses):
            scan = scan_of(np.full(181, 2.0)) if k % 7 == 0 and k < 30 else scan_of(blind)
            rolling.insert(0.1 * k, scan, LASER, pose)
    for empty, measured_nothing in zip(*(views(one, poses) for one in maps), strict=True):
        np.testing.assert_array_equal(empty, measured_nothing)


def views(rolling: RollingMap, poses: list[Pose2]) -> list[Array]:
    """All that it says at some poses."""
    unseen = [rolling.unseen(pose, Footprint(), 1.5).points for pose in poses[::10]]
    return [*(rolling.obstacles(pose).points for pose in poses[::10]), *unseen, rolling.local_grid(poses[-1]).data]


@pytest.mark.parametrize(
    ("beam", "kept"),
    [
        (one_beam(1.05), False),  # goes on by more than 3 sqrt(2) standard deviations
        (one_beam(math.inf), False),
        (one_beam(math.nan), True),
        (one_beam(-math.inf), True),
        (one_beam(math.inf, 0.0038), False),  # passes at 0.0038 m
        (one_beam(1.09, 0.0038), True),  # and goes on by less than 15 times that and the noise
        (one_beam(1.11, 0.0038), False),
        (one_beam(math.inf, 0.0042), True),
        (one_beam(math.inf, math.pi), True),  # the other way
        (LaserScan(np.full(2, np.inf, np.float32), -0.014, 0.029), False),  # on both sides
        (LaserScan(np.full(2, np.inf, np.float32), -0.014, 0.031), True),
        (LaserScan(np.full(2, np.inf, np.float32), 0.012, 0.01), True),  # both on one side
        (LaserScan(np.array([np.inf, 0.9], np.float32), 0.002, -0.03), True),  # the next one ends beside it
        (LaserScan(np.array([np.inf, 0.7], np.float32), 0.002, -0.03), False),  # and this one elsewhere
    ],
)
def test_a_lone_point_is_forgotten_when_beams_go_on_behind_it_three_times(beam: LaserScan, kept: bool) -> None:
    rolling = RollingMap(range_noise=0.01)
    base = Pose2(0.01, 0.02, 0.0)
    rolling.insert(0.0, one_beam(1.0), LASER, base)
    for step in range(1, 4):
        assert len(rolling) >= 1
        rolling.insert(0.1 * step, beam, LASER, base)
    points = rolling.obstacles(base).points
    assert np.isclose(points, [1.70, 0.0], atol=1e-6).all(axis=1).any() == kept


def test_one_stray_beam_does_not_drop_a_point_three_in_a_row_do() -> None:
    rolling = RollingMap()
    for step in range(22):
        missed = step > 4 and step % 4 > 1
        rolling.insert(0.1 * step, one_beam(math.inf if missed else 1.0), LASER, Pose2())
        assert len(rolling) == 1
    for step in range(22, 25):
        assert len(rolling) == 1
        rolling.insert(0.1 * step, one_beam(math.inf), LASER, Pose2())
    assert len(rolling) == 0


def test_hits_of_one_scan_that_agree_are_one_point() -> None:
    rolling = exact_map()
    rolling.insert(0.0, LaserScan(np.array([1.0, 1.0], np.float32), 0.0, 0.01), LASER, Pose2())
    np.testing.assert_allclose(rolling.obstacles(Pose2()).points, [[1.70, 0.005]], atol=1e-4)


@pytest.mark.parametrize("increment", [0.01, -0.01])
@pytest.mark.parametrize("turn", [0.0, 2 * math.pi, -4 * math.pi])
def test_beams_are_found_however_the_scan_turns(increment: float, turn: float) -> None:
    def fan(ranges: npt.ArrayLike) -> LaserScan:
        return LaserScan(np.asarray(ranges, np.float32), turn - 200 * increment, increment)

    rolling = RollingMap()
    rolling.insert(0.0, one_beam(1.0, 1.5), LASER, Pose2())
    for step in range(1, 4):
        assert len(rolling) == 1
        rolling.insert(0.1 * step, fan(np.full(401, np.inf)), LASER, Pose2())
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
    rolling = exact_map()
    rolling.insert(0.0, scan_of(np.full(181, 2.0)), LASER, Pose2())
    assert len(rolling) > 50
    rolling.insert(0.1, one_beam(1.0), LASER, jump)
    assert len(rolling) == 1
    assert len(rolling.obstacles(jump)) == 1
    data = rolling.local_grid(jump).data
    assert (data == 100).sum() == 1
    assert (data == 0).sum() < 60


def test_only_points_within_the_radius_are_given() -> None:
    rolling = exact_map(radius=2.0)
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
    for noise in (0.0, 0.0009, 0.21, math.nan):
        with pytest.raises(ValueError, match=r"range_noise is .* m"):
            RollingMap(range_noise=noise)
    for share in (-0.01, 0.51, math.nan):
        with pytest.raises(ValueError, match="odometry_error"):
            RollingMap(odometry_error=share)
    with pytest.raises(ValueError, match="footprint"):
        RollingMap(own_body=Footprint(math.inf, 0.3, 0.3))
    for reach in (-0.1, 20.1, math.nan):
        with pytest.raises(ValueError, match="reach"):
            rolling.unseen(Pose2(), Footprint(), reach)
    with pytest.raises(ValueError, match="T_odom_base"):
        rolling.unseen(Pose2(math.nan, 0, 0), Footprint(), 1.0)


def test_absurd_but_valid_scans_neither_hang_nor_crash() -> None:
    rolling = RollingMap()
    for increment in (1e-300, 1e9, -1e300):
        scan = LaserScan(np.array([1.0, np.inf, 1e38, 3e38], np.float32), 1e9, increment, range_max=1e300)
        for stamp in (0.0, 0.1):
            rolling.insert(stamp, scan, LASER, Pose2())
        local_grid(scan, LASER)
        rolling.clear()
