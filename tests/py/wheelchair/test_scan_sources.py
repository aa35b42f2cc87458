"""Scans from LIDARs and recorded drives, and what two scanners see as one scan of the chair."""

import math
import random
import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.errors import DataError, DeviceError
from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import LaserScan, read_beams
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.scan_sources import Merged, ReplaySource, ScanSource, ScipSource, merge_scans
from lfdcore.wheelchair.watch import BLIND, STALE, Watch
from observed import observed
from scip_device import UTM_30LX, PtyLink, ScipDevice, TcpLink
from synthetic_drive import cast

Array = NDArray[np.float64]
BODY = Footprint()
FRONT, REAR = Pose2(0.70, 0.0, 0.0), Pose2(-0.30, 0.0, math.pi)
RANGE_MAX = 30.0
REACH = RANGE_MAX - 0.70
"""[m] from base_link that a scanner at FRONT sees"""
HALL = np.array(
    [
        [[-6.0, -5.0], [7.0, -5.0]],
        [[7.0, -5.0], [7.0, 4.0]],
        [[7.0, 4.0], [-6.0, 4.0]],
        [[-6.0, 4.0], [-6.0, -5.0]],
    ]
)
"""(W, 2, 2) walls [m] all around, in base_link"""


def box(x: float, y: float, side: float = 0.3) -> Array:
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def view(
    walls: Array, T_base_laser: Pose2, *, beams: int = 1081, increment: float = math.radians(0.25), unseen: int = 0
) -> LaserScan:
    """What a scanner sees of walls in base_link; its first `unseen` beams measure nothing."""
    angle_min = -increment * (beams - 1) / 2
    angles = T_base_laser.yaw + angle_min + increment * np.arange(beams)
    lengths = cast((T_base_laser.x, T_base_laser.y), angles, walls)
    lengths[lengths >= RANGE_MAX] = math.inf
    lengths[:unseen] = math.nan
    return LaserScan(lengths.tolist(), angle_min, increment, 0.02, RANGE_MAX)


def hits(scan: LaserScan, pose: Pose2) -> Array:
    """(H, 2) [m] in base_link"""
    lengths, hit = read_beams(scan)
    angles = scan.angles()[hit]
    return np.asarray(pose.transform(lengths[hit, None] * np.stack([np.cos(angles), np.sin(angles)], 1)))


def random_world(seed: int) -> Array:
    draw = random.Random(seed).uniform
    boxes = []
    while len(boxes) < 8:
        x, y = draw(-5, 6), draw(-4, 3)
        if not (-1.2 < x < 1.5 and -1.2 < y < 1.0):
            boxes.append(box(x, y, draw(0.05, 0.8)))
    return np.concatenate([HALL, *boxes] if seed % 2 else boxes)


class Given:
    """A source that says what it is told to."""

    def __init__(self, T_base_laser: Pose2, name: str = "given") -> None:
        self.T_base_laser, self.name, self.scan_period = T_base_laser, name, 0.025
        self.said: tuple[LaserScan, float] | None = None
        self.closed = False

    def newest(self) -> tuple[LaserScan, float] | None:
        return self.said

    def fault(self) -> str:
        return "" if self.said else f"{self.name}: nothing yet"

    def close(self) -> None:
        self.closed = True


@pytest.mark.hazard("One of two scanners hides what the other sees", "what either hits is in the merged scan")
@pytest.mark.parametrize("seed", range(8))
def test_what_any_scanner_hits_is_hit_in_the_merged_scan_and_nothing_is_farther(seed: int) -> None:
    walls = random_world(seed)
    placed = [(view(walls, pose), pose) for pose in (FRONT, REAR)]
    merged = merge_scans(placed, BODY, REACH)
    for scan, pose in placed:
        for x, y in hits(scan, pose):
            beam = round((math.atan2(y, x) - merged.angle_min) / merged.angle_increment) % len(merged.ranges)
            assert merged.ranges[beam] <= math.hypot(x, y) + 1e-5


@pytest.mark.hazard("One of two scanners hides what the other sees", "free is only what a scanner has seen free")
@pytest.mark.parametrize("seed", range(8))
def test_a_beam_that_says_free_meets_nothing(seed: int) -> None:
    walls = random_world(seed)
    merged = merge_scans([(view(walls, pose), pose) for pose in (FRONT, REAR)], BODY, REACH)
    free = np.isposinf(merged.ranges)
    assert free.any() == (seed % 2 == 0)
    if free.any():
        assert (cast((0, 0), merged.angles()[free], walls) >= merged.range_max).all()


@pytest.mark.parametrize("seed", range(8))
def test_what_a_merged_beam_hits_is_there(seed: int) -> None:
    walls = random_world(seed)
    merged = merge_scans([(view(walls, pose), pose) for pose in (FRONT, REAR)], BODY, REACH)
    points = hits(merged, Pose2())
    edge = walls[:, 1] - walls[:, 0]
    off = points[:, None] - walls[:, 0]
    apart = np.abs(edge[:, 0] * off[..., 1] - edge[:, 1] * off[..., 0]) / np.linalg.norm(edge, axis=1)
    assert (apart.min(axis=1) < 0.03 + 0.01 * np.hypot(*points.T)).all()


def test_two_scanners_at_opposite_ends_see_nearly_all_around() -> None:
    merged = merge_scans([(view(HALL, pose), pose) for pose in (FRONT, REAR)], BODY, REACH)
    assert np.isfinite(merged.ranges).all()
    assert len(merged.ranges) == 720
    assert merged.angle_increment * 720 == pytest.approx(2 * math.pi)


def test_where_no_scanner_looks_is_not_measured() -> None:
    open_space = np.array([[[100.0, 0.0], [101.0, 0.0]]])
    merged = merge_scans([(view(open_space, FRONT), FRONT)], BODY, REACH)
    angles = merged.angles()
    # Farther aside, a ray leaves the chair's outline where the scanner, which looks 135 degrees aside, sees nothing.
    assert np.isposinf(merged.ranges[np.abs(angles) < math.radians(44)]).all()
    assert np.isnan(merged.ranges[np.abs(angles) > math.radians(55)]).all()


def test_what_stands_behind_something_is_not_free() -> None:
    """The chest hides what lies behind it from the scanner ahead, though it is in view from the axle."""
    chest = box(1.0, 0.5, 0.6)
    merged = merge_scans([(view(chest, FRONT), FRONT)], BODY, REACH)
    angles, radii = merged.angles()[np.isposinf(merged.ranges)], np.arange(1, 10, 0.1)
    x = np.outer(radii, np.cos(angles)).ravel() - FRONT.x
    y = np.outer(radii, np.sin(angles)).ravel() - FRONT.y
    assert (cast((FRONT.x, FRONT.y), np.arctan2(y, x), chest) > np.hypot(x, y) - 0.1).all()


def test_a_coarse_scanner_leaves_no_gaps_in_a_wall() -> None:
    scan = view(HALL, FRONT, beams=181, increment=math.radians(1))
    merged = merge_scans([(scan, FRONT)], BODY, REACH)
    ahead = np.abs(merged.angles()) < math.radians(60)
    assert np.isfinite(merged.ranges[ahead]).all()


def test_a_far_hit_is_kept_though_another_scanner_reaches_less_far() -> None:
    wall = np.array([[[20.0, -5.0], [20.0, 5.0]]])
    near = LaserScan([math.inf] * 1081, -math.radians(135), math.radians(0.25), 0.02, 5.6)
    merged = merge_scans([(view(wall, FRONT), FRONT), (near, REAR)], BODY, REACH)
    assert merged.ranges[360] == pytest.approx(20.0, abs=1e-4)
    assert merged.range_max == pytest.approx(REACH)
    assert np.isnan(merged.ranges[0]), "behind, nobody has seen so far"


def watched(source: ScanSource, now: float) -> str | None:
    chair = ChairGeometry(
        footprint=BODY, limits=ChairGeometry.thesis().limits, T_base_laser=source.T_base_laser, scan_period=0.025
    )
    newest = source.newest()
    assert newest is not None
    return Watch(chair).judge(observed(now, newest[0], (0.0, 0.0), scan_stamp=newest[1]))


@pytest.mark.hazard("A scanner is lost while driving", "one of two that is lost stops the chair")
def test_a_watch_stops_the_chair_when_one_of_two_scanners_is_lost() -> None:
    front, rear = Given(FRONT), Given(REAR)
    merged = Merged([front, rear], BODY)
    assert merged.newest() is None
    front.said = (view(HALL, FRONT), 10.0)
    assert merged.newest() is None, "until both have said something"
    rear.said = (view(HALL, REAR), 9.98)
    newest = merged.newest()
    assert newest is not None and newest[1] == 9.98
    assert watched(merged, 10.01) is None
    front.said = (front.said[0], 10.5)
    assert watched(merged, 10.51) == STALE


@pytest.mark.hazard("A scanner is lost while driving", "a scanner ahead that measures nothing is blindness")
def test_a_watch_is_blind_where_the_front_scanner_measures_nothing() -> None:
    front, rear = Given(FRONT), Given(REAR)
    merged = Merged([front, rear], BODY)
    rear.said = (view(HALL, REAR), 10.0)
    for scan in (view(HALL, FRONT, unseen=1081), LaserScan([], -1.0, 0.01, 0.02, RANGE_MAX)):
        front.said = (scan, 10.0)
        assert watched(merged, 10.01) == BLIND


@pytest.mark.parametrize("jump", [math.nan, math.inf, 1e300, 0.6])
@pytest.mark.hazard("One of two scanners hides what the other sees", "no scan where nobody knows how the chair moved")
def test_where_odometry_does_not_tell_how_the_chair_moved_the_last_scan_grows_old(jump: float) -> None:
    front, rear = Given(FRONT), Given(REAR)
    where = {10.0: 0.0, 10.02: 0.01, 11.0: 1.0, 11.02: jump + 1.0}
    merged = Merged([front, rear], BODY, lambda stamp: Pose2(where[stamp], 0.0, 0.0))
    front.said, rear.said = (view(HALL, FRONT), 10.02), (view(HALL, REAR), 10.0)
    first = merged.newest()
    front.said, rear.said = (view(HALL, FRONT), 11.02), (view(HALL, REAR), 11.0)
    assert merged.newest() is first


def test_the_merged_scans_layout_stays_while_the_chair_moves() -> None:
    front, rear = Given(FRONT), Given(REAR)
    merged = Merged([front, rear], BODY, lambda stamp: Pose2(stamp, 0.0, 0.0))
    layouts = set()
    for k in range(5):
        front.said, rear.said = (view(HALL, FRONT), 10 + k + 0.01 * k), (view(HALL, REAR), 10.0 + k)
        newest = merged.newest()
        assert newest is not None
        layouts.add((newest[0].angle_min, newest[0].range_max, len(newest[0].ranges)))
    assert len(layouts) == 1


def test_scans_of_other_stamps_are_moved_to_the_older_one() -> None:
    speed = 1.0
    poses: list[float] = []

    def odometry(stamp: float) -> Pose2:
        poses.append(stamp)
        return Pose2(speed * (stamp - 10.0), 0.0, 0.0)

    front, rear = Given(FRONT), Given(REAR)
    merged = Merged([front, rear], BODY, odometry)
    rear.said = (view(HALL, REAR), 10.0)
    later = HALL - np.array([0.2, 0.0])  # as the chair has them 0.2 s later, ahead by 0.2 m
    front.said = (view(later, FRONT), 10.2)
    newest = merged.newest()
    assert newest is not None and newest[1] == 10.0
    assert newest[0].ranges[360] == pytest.approx(7.0, abs=1e-3)
    assert newest[0].ranges[0] == pytest.approx(6.0, abs=1e-3)


def test_the_same_scans_are_merged_once() -> None:
    front = Given(FRONT)
    front.said = (view(HALL, FRONT), 10.0)
    merged = Merged([front], BODY, REACH)
    assert merged.newest() is merged.newest()


def test_faults_and_names_are_those_of_all_and_all_are_closed() -> None:
    front, rear = Given(FRONT, "front"), Given(REAR, "rear")
    merged = Merged([front, rear], BODY)
    assert merged.name == "front + rear"
    assert merged.fault() == "front: nothing yet; rear: nothing yet"
    merged.close()
    assert front.closed and rear.closed


@pytest.mark.parametrize(
    ("sources", "message"),
    [([], "no scanners to merge"), ([Given(Pose2(11, 0, 0), "far")], "T_base_laser of far is .* within 10 m")],
)
def test_scanners_that_cannot_be_merged_are_refused(sources: list[Given], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Merged(sources, BODY)


def test_a_scanner_that_does_not_reach_beyond_its_mounting_is_refused() -> None:
    with pytest.raises(ValueError, match="no scanner reaches"):
        merge_scans([(LaserScan([0.1], 0.0, 0.1, 0.02, 0.5), FRONT)], BODY, -0.2)


@pytest.mark.parametrize("make_link", [PtyLink, lambda _: TcpLink()])
def test_a_lidar_is_a_source(make_link: Callable[[Path], PtyLink | TcpLink], tmp_path: Path) -> None:
    with ScipDevice(make_link(tmp_path), lambda _: [1234] * UTM_30LX.beams) as device:
        source = ScipSource(device.address, FRONT)
        while (newest := source.newest()) is None:
            time.sleep(0.002)
        assert newest[0].ranges[0] == np.float32(1.234)
        assert 0 <= time.monotonic() - newest[1] < 10
        assert (source.T_base_laser, source.scan_period, source.fault()) == (FRONT, 0.025, "")
        assert source.name == f"scip:{device.address}"
        source.close()


def last_of(source: ScanSource) -> float:
    """The stamp of the tenth scan, which must be the newest."""
    newest = source.newest()
    assert newest is not None and newest[0].ranges[0] == 9
    return newest[1]


def test_a_recorded_drive_is_replayed_as_fast_as_it_was_driven(tmp_path: Path) -> None:
    stamps = 5 + 0.02 * np.arange(10)
    ranges = np.arange(10, dtype=np.float32)[:, None] * np.ones((1, 20), np.float32)
    path = tmp_path / "drive.mcap"
    DriveLog(scan_stamp=stamps, ranges=ranges, T_base_laser=FRONT).save(path)
    begin = time.monotonic()
    source = ReplaySource(path)
    assert source.T_base_laser == FRONT
    assert source.scan_period == pytest.approx(0.02)
    seen: dict[float, float] = {}
    while not source.fault():
        newest = source.newest()
        assert newest is not None
        seen[float(newest[0].ranges[0])] = newest[1]
        assert time.monotonic() - newest[1] >= 0
    seen[9.0] = last_of(source)
    first = seen[9.0] - 0.18
    assert begin <= first
    for value, stamp in seen.items():
        assert stamp == pytest.approx(first + 0.02 * value)
    assert source.fault() == f"{path}: the drive has ended"
    assert last_of(source) == seen[9.0], "and grows old"
    source.close()


def test_what_is_named_wrongly_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        ReplaySource(tmp_path / "no_such_drive.mcap")
    with pytest.raises(DeviceError, match=re.escape(f"{tmp_path}/ttyACM0: there is no such device")):
        ScipSource(f"{tmp_path}/ttyACM0", FRONT)
    (tmp_path / "notes.txt").write_text("no drive")
    with pytest.raises(DataError):
        ReplaySource(tmp_path / "notes.txt")
