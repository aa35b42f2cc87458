"""Scans in a known map: the pose is right, stays right while the odometry slips, and says when it cannot be known."""

import gzip
import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import DriveLog, open_log
from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.grid import LaserScan, OccupancyGrid, RayCaster
from lfdcore.simulated.courses import Course, Drawing, goal_building, goals_in_map
from lfdcore.simulated.drivers import AbleDriver
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulation import ChairConfig, LidarConfig
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.goals.localisation import LocalisedPose, LocaliserConfig, ScanLocaliser, localise_log

SLIPPING = ChairConfig(linear_slip=0.05, angular_slip=0.05, slip_sd=0.05)
MOUNTING = LidarConfig().T_base_laser
ANGLES = -math.pi / 2 + math.radians(1) * np.arange(181)


def drive(course: Course, path: Path, goal: str) -> DriveLog:
    run = RunConfig(chair=SLIPPING)
    run_drive(course, AbleDriver(course), Unassisted(run.geometry), 3, run, path, goal)
    return open_log(path)


@pytest.fixture(scope="module")
def course() -> Course:
    return goal_building().course("G5", 3)


@pytest.fixture(scope="module")
def log(course: Course, tmp_path_factory: pytest.TempPathFactory) -> DriveLog:
    return drive(course, tmp_path_factory.mktemp("slip") / "G5.mcap", "G5")


def errors(found: list[LocalisedPose], true: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the position [m] and of the heading [degrees]."""
    off = np.array([[*one.pose] for one in found]) - true
    return np.hypot(off[:, 0], off[:, 1]), np.degrees(np.abs(wrap_angle(off[:, 2])))


def scan_from(grid: OccupancyGrid, pose: Pose2) -> LaserScan:
    """What a LIDAR without noise sees."""
    ranges = RayCaster(grid, 30.0).cast(pose * MOUNTING, ANGLES)
    return LaserScan(ranges, -math.pi / 2, math.radians(1), 0.0, 30.0)


def room() -> OccupancyGrid:
    """8 x 6 m, not symmetric, with walls .1 m thick between its parts."""
    d = Drawing(8.0, 6.0)
    d.walls((3.0, 0, 3.0, 2.5), (5.5, 3.5, 5.5, 6.0))
    d.box(6.6, 0.4, 7.4, 1.6)
    return d.grid()


# -- oracle ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("true", [Pose2(1.5, 2.0, 0.3), Pose2(4.2, 4.4, -1.2), Pose2(6.4, 3.0, 2.9)])
def test_the_pose_is_the_one_whose_exact_ray_casts_agree_best(true: Pose2) -> None:
    grid = room()
    scan, caster = scan_from(grid, true), RayCaster(grid, 30.0)
    steps = np.linspace(-0.06, 0.06, 7)

    def disagreement(off: tuple[float, ...]) -> float:
        cast = caster.cast(Pose2(true.x + off[0], true.y + off[1], true.yaw + off[2]) * MOUNTING, ANGLES)
        return float(np.minimum(np.abs(cast - scan.ranges), 0.5).sum())

    best = min(itertools.product(steps, steps, steps / 2), key=disagreement)
    found = ScanLocaliser(grid, true * Pose2(0.2, -0.15, 0.06)).update(scan, MOUNTING, Pose2()).pose
    assert abs(found.x - true.x - best[0]) < 0.02
    assert abs(found.y - true.y - best[1]) < 0.02
    assert abs(found.yaw - true.yaw - best[2]) < 0.01


@pytest.mark.parametrize("turned", [np.pi, np.pi / 2, -2.0])
def test_a_scanner_that_looks_elsewhere_sees_the_walls_faces_that_it_looks_at(turned: float) -> None:
    grid, true, mounting = room(), Pose2(4.2, 3.2, 0.4), Pose2(0.1, 0.0, turned)
    ranges = RayCaster(grid, 30.0).cast(true * mounting, ANGLES)
    scan = LaserScan(ranges, -math.pi / 2, math.radians(1), 0.0, 30.0)
    found = ScanLocaliser(grid, true * Pose2(0.1, -0.1, 0.03)).update(scan, mounting, Pose2()).pose
    assert math.hypot(found.x - true.x, found.y - true.y) < 0.03
    assert abs(found.yaw - true.yaw) < 0.01


def test_an_error_of_the_heading_turns_the_way_driven_since() -> None:
    """To first order: y is off by the way along x times the heading's error."""
    c = LocaliserConfig()
    blind = LaserScan(np.full(181, np.inf, np.float32), -math.pi / 2, math.radians(1), 0.0, 30.0)
    localiser = ScanLocaliser(room(), Pose2(1.0, 1.0, 0.0))
    localiser.update(blind, MOUNTING, Pose2())
    covariance = localiser.update(blind, MOUNTING, Pose2(5.0, 0.0, 0.0)).covariance
    heading = c.initial_heading_sd**2 + c.drift_still**2
    assert covariance[1, 2] == pytest.approx(5 * heading)
    assert covariance[0, 2] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, 0.125, -3.0, 8.0, 40.0])
def test_beams_that_ended_at_nothing_leave_the_localiser_blind(value: float) -> None:
    scan = LaserScan(np.full(181, value, np.float32), -math.pi / 2, math.radians(1), 0.25, 8.0)
    assert ScanLocaliser(room(), Pose2(1.0, 1.0, 0.0)).update(scan, MOUNTING, Pose2()).outcome == "blind"


def test_what_is_too_close_is_matched_where_the_scanner_begins_to_measure() -> None:
    """REP-117's -inf is no blindness: something is there, at range_min as near as anybody knows."""
    grid, true = room(), Pose2(1.5, 2.0, 0.3)
    ranges = np.array(scan_from(grid, true).ranges)
    nearest = np.sort(ranges)[20]
    near = ranges <= nearest
    found = []
    for value in (-np.inf, nearest):
        given = np.where(near, value, ranges).astype(np.float32)
        scan = LaserScan(given, -math.pi / 2, math.radians(1), float(nearest), 30.0)
        found.append(ScanLocaliser(grid, true).update(scan, MOUNTING, Pose2()))
    assert found[0].pose == found[1].pose
    assert found[0].score == found[1].score


# -- claims ---------------------------------------------------------------------------------------------------------


def test_a_drive_with_slipping_odometry_is_followed(log: DriveLog, course: Course) -> None:
    true = log.map_pose_at(log.scan_stamp)
    by_odometry = course.start * Pose2(*log.pose[-1])
    assert math.hypot(by_odometry.x - true[-1, 0], by_odometry.y - true[-1, 1]) > 0.3
    found = localise_log(log, goal_building().grid, course.start)
    position, heading = errors(found, true)
    assert (np.median(position), position.max()) < (0.03, 0.1)
    assert heading.max() < 2.0
    assert {one.outcome for one in found} == {"tracked"}


@pytest.mark.parametrize("direction", np.radians(np.arange(0, 360, 60)))
@pytest.mark.parametrize("turn", np.radians([-5.0, 5.0]))
def test_an_initial_error_of_3_dm_and_5_degrees_is_gone_within_a_second(
    log: DriveLog, course: Course, direction: float, turn: float
) -> None:
    wrong = Pose2(
        course.start.x + 0.3 * math.cos(direction),
        course.start.y + 0.3 * math.sin(direction),
        course.start.yaw + turn,
    )
    second = log.slice(0, 1)
    found = localise_log(second, goal_building().grid, wrong)
    position, heading = errors(found, second.map_pose_at(second.scan_stamp))
    assert position[-1] < 0.03 and heading[-1] < 0.5


@pytest.mark.realdata
def test_a_drive_through_real_offices_is_followed(data_folder: Path, tmp_path: Path) -> None:
    world = goals_in_map(data_folder / "maps" / "willow_full.yaml", seed=1)
    course = world.course("G2", 0)
    log = drive(course, tmp_path / "offices.mcap", "G2")
    position, heading = errors(localise_log(log, world.grid, course.start), log.map_pose_at(log.scan_stamp))
    assert position.max() < 0.1 and heading.max() < 2.0


@pytest.mark.realdata
def test_real_scans_are_matched_to_a_map_of_other_scans(data_folder: Path) -> None:
    path = data_folder / "logs" / "freiburg-079-corrected.log.gz"
    log, count = open_log(path), 1000
    true = corrected_poses(path, count)
    grid = map_of(log, true, range(0, count, 2))
    localiser, odometry = ScanLocaliser(grid, Pose2(*true[1])), log.pose_at(log.scan_stamp)
    odd = range(1, count, 2)
    found = [localiser.update(log.scan(k), log.T_base_laser, Pose2(*odometry[k])) for k in odd]
    position, heading = errors(found, true[1::2])
    assert np.median(position) < 0.15 and position.max() < 0.4  # walls of this map are .1-.2 m thick
    assert np.median(heading) < 2.0
    assert {one.outcome for one in found} == {"tracked"}


def corrected_poses(path: Path, count: int) -> np.ndarray:
    """Of the first scans of a CARMEN log, by the SLAM that made it."""
    with gzip.open(path, "rt") as lines:
        scans = (line.split() for line in lines if line.startswith("FLASER"))
        return np.array([[float(v) for v in w[2 + int(w[1]) : 5 + int(w[1])]] for w in itertools.islice(scans, count)])


def map_of(log: DriveLog, poses: np.ndarray, which: range) -> OccupancyGrid:
    """Cells in which at least 4 beams ended."""
    ends = []
    for k in which:
        ranges, angles = np.asarray(log.scan(k).ranges, float), np.asarray(log.scan(k).angles())
        hit = ranges < 20
        points = ranges[hit, None] * np.stack([np.cos(angles[hit]), np.sin(angles[hit])], axis=1)
        ends.append((Pose2(*poses[k]) * log.T_base_laser).transform(points))
    points = np.concatenate(ends)
    origin = points.min(axis=0) - 1
    ix, iy = ((points - origin) / 0.05).astype(int).T
    hits = np.zeros((iy.max() + 20, ix.max() + 20), int)
    np.add.at(hits, (iy, ix), 1)
    return OccupancyGrid(np.where(hits >= 4, 100, 0).astype(np.int8), 0.05, (float(origin[0]), float(origin[1])))


# -- laws -----------------------------------------------------------------------------------------------------------


def test_in_a_corridor_without_features_the_chair_moves_along_it_as_the_odometry_says() -> None:
    d = Drawing(100.0, 4.0)
    grid, true = d.grid(), Pose2(45.0, 1.8, 0.0)
    localiser = ScanLocaliser(grid, true)
    for step in range(30):
        at = true * Pose2(0.1 * step, 0.0, 0.0)
        slipped = Pose2(0.11 * step, 0.0, 0.01 * step)  # the odometry turns left and goes too far
        found = localiser.update(scan_from(grid, at), MOUNTING, slipped)
    assert found.outcome == "tracked"
    assert found.pose.y == pytest.approx(1.8, abs=0.03)
    assert found.pose.yaw == pytest.approx(0.0, abs=0.02)
    assert found.pose.x == pytest.approx(at.x + 0.3, abs=0.1)  # nothing tells better
    along, across = np.sqrt(np.diag(found.covariance))[:2]
    assert along > 5 * across


def test_the_covariance_stays_positive_definite_and_the_score_a_share(log: DriveLog, course: Course) -> None:
    for one in localise_log(log.slice(0, 5), goal_building().grid, course.start):
        np.testing.assert_allclose(one.covariance, one.covariance.T, atol=1e-12)
        assert np.linalg.eigvalsh(one.covariance).min() > 0
        assert 0 <= one.score <= 1


def test_a_map_elsewhere_and_turned_beams_give_the_same_pose_moved() -> None:
    grid, true = room(), Pose2(1.5, 2.0, 0.3)
    moved = OccupancyGrid(grid.data, grid.resolution, (-20.0, 7.0))
    scan = scan_from(grid, true)
    here = ScanLocaliser(grid, Pose2(1.6, 2.1, 0.3)).update(scan, MOUNTING, Pose2()).pose
    there = ScanLocaliser(moved, Pose2(-18.4, 9.1, 0.3)).update(scan, MOUNTING, Pose2()).pose
    np.testing.assert_allclose([*there], [here.x - 20, here.y + 7, here.yaw], atol=1e-3)


# -- what cannot be known -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("nothing", [math.inf, math.nan, 30.0])
def test_a_scan_that_sees_nothing_leaves_the_odometrys_prediction(nothing: float) -> None:
    localiser = ScanLocaliser(room(), Pose2(1.5, 2.0, math.pi / 2))
    scan = LaserScan(np.full(181, nothing, np.float32), -math.pi / 2, math.radians(1), 0.0, 30.0)
    first = localiser.update(scan, MOUNTING, Pose2(5, 5, 1))
    after = localiser.update(scan, MOUNTING, Pose2(5, 5, 1) * Pose2(0.5, 0, 0))
    assert (first.outcome, first.score, after.outcome) == ("blind", 0.0, "blind")
    np.testing.assert_allclose([*after.pose], [1.5, 2.5, math.pi / 2], atol=1e-12)
    assert np.linalg.det(after.covariance) > np.linalg.det(first.covariance)


def test_a_scan_that_the_map_does_not_explain_is_lost_and_does_not_move_the_chair() -> None:
    d = Drawing(12.0, 10.0)
    d.box(9.0, 7.0, 10.0, 9.0)
    hall, true = d.grid(), Pose2(5.0, 5.0, 0.0)
    localiser = ScanLocaliser(hall, true)
    ring = LaserScan(np.full(181, 1.0, np.float32), -math.pi / 2, math.radians(1), 0.0, 30.0)
    lost = [localiser.update(ring, MOUNTING, Pose2()) for _ in range(3)]
    assert {one.outcome for one in lost} == {"lost"}
    assert all(one.score < LocaliserConfig().lost_below for one in lost)
    np.testing.assert_allclose([*lost[-1].pose], [*true], atol=1e-12)
    assert np.linalg.det(lost[-1].covariance) > np.linalg.det(lost[0].covariance)
    found = localiser.update(scan_from(hall, Pose2(5.3, 4.8, 0.1)), MOUNTING, Pose2())
    assert found.outcome == "tracked"
    np.testing.assert_allclose([*found.pose], [5.3, 4.8, 0.1], atol=0.02)


def test_people_in_the_way_do_not_pull_the_pose_off() -> None:
    true = Pose2(1.5, 2.0, 0.3)
    scan = scan_from(room(), true)
    ranges = np.array(scan.ranges)
    ranges[110:150] /= 2
    crowded = LaserScan(ranges, scan.angle_min, scan.angle_increment, 0.0, 30.0)
    found = ScanLocaliser(room(), Pose2(1.6, 1.9, 0.25)).update(crowded, MOUNTING, Pose2())
    assert found.outcome == "tracked" and found.score < 0.9
    np.testing.assert_allclose([*found.pose], [*true], atol=0.02)


def test_bad_input_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no occupied cell"):
        ScanLocaliser(OccupancyGrid(np.zeros((20, 20), np.int8), 0.05), Pose2())
    with pytest.raises(ValueError, match="initial must be finite"):
        ScanLocaliser(room(), Pose2(math.nan, 0, 0))
    localiser = ScanLocaliser(room(), Pose2(1.5, 2.0, 0.3))
    with pytest.raises(ValueError, match="odometry must be finite"):
        localiser.update(scan_from(room(), Pose2(1.5, 2.0, 0.3)), MOUNTING, Pose2(0, math.inf, 0))
    for wrong in ({"surface_sd": 0.0}, {"step": math.nan}, {"lost_below": 1.0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            LocaliserConfig(**wrong)
    empty = DriveLog(scan_stamp=[], ranges=np.zeros((0, 3)))
    with pytest.raises(ValueError, match="holds no scans"):
        localise_log(empty, room(), Pose2())


def test_a_pose_far_outside_the_map_is_lost_and_not_an_error() -> None:
    localiser = ScanLocaliser(room(), Pose2(500.0, -300.0, 0.0))
    found = localiser.update(scan_from(room(), Pose2(1.5, 2.0, 0.3)), MOUNTING, Pose2())
    assert (found.outcome, found.score) == ("lost", 0.0)
