import dataclasses

import numpy as np
import pytest

from lfdcore.geometry import Pose2
from lfdcore.wheelchair.primitives.local_paths import (
    LocalPathConfig,
    LocalPaths,
    extract_local_paths,
)
from lfdcore.wheelchair.window import WINDOW
from synthetic_drive import L_WALLS, T_BASE_LASER, corner_drive, drive, log_of

FAR_WALLS = np.array(
    [[[-50, -50], [50, -50]], [[50, -50], [50, 50]], [[50, 50], [-50, 50]], [[-50, 50], [-50, -50]]], float
)


def first_path(segments, walls=FAR_WALLS, config=None, **changes):
    """The local path from the first scan of a drive in the open, and why it ended."""
    stamps, poses, stick = drive(segments)
    paths = extract_local_paths(log_of(stamps, poses, stick, walls, range_max=100.0, **changes), config)
    assert paths.stamp[0] == 0.0
    return paths, paths.paths[0], paths.reason[0]


def slow_ends(log, config=None):
    """The criteria read literally, one scan and one instant after the other: -> reason and goal by scan stamp."""
    config = config or LocalPathConfig()
    grid = np.arange(log.odometry_stamp[0], log.odometry_stamp[-1] + 0.1, 0.1).clip(max=log.odometry_stamp[-1])
    instants = np.unique(np.r_[grid, log.scan_stamp[log.scan_stamp < log.odometry_stamp[-1]]])
    found = {}
    for scan, ranges in zip(log.scan_stamp, log.ranges, strict=True):
        if scan >= log.odometry_stamp[-1]:
            continue
        T_base_odom = Pose2(*log.pose_at([scan])[0]).inverse()
        turned, travelled, furthest, moved, previous, trail, before = 0.0, 0.0, (0.0, 0), scan, None, [], scan
        reason = "log"
        for now in instants[instants >= scan]:
            here = T_base_odom * Pose2(*log.pose_at([now])[0])
            if previous is not None:
                delta = previous.inverse() * here
                turned += delta.yaw
                travelled += np.hypot(delta.x, delta.y) * np.cos(np.arctan2(delta.y, delta.x) - delta.yaw / 2)
                interval = now - before
                if (
                    np.hypot(delta.x, delta.y) > config.rest_speed * interval
                    or abs(delta.yaw) > config.rest_turn * interval
                ):
                    moved, rest_at = now, len(trail)
                laser = log.T_base_laser.inverse() * here
                angle = np.arctan2(laser.y, laser.x)
                angles = log.angle_min + log.angle_increment * np.arange(len(ranges))
                hidden = abs(angle) <= np.pi / 2 + log.angle_increment / 2 and (
                    np.hypot(laser.x, laser.y) > ranges[np.argmin(np.abs(angles - angle))] + config.slack
                )
                checks = {
                    "window": here.x >= WINDOW or abs(here.y) >= WINDOW,
                    "behind": here.x < -config.behind,
                    "reverse": furthest[0] - travelled > config.reverse,
                    "turn": abs(turned) > config.turn,
                    "hidden": hidden,
                    "rest": now - moved > config.rest,
                }
                reason = next((name for name, met in checks.items() if met), "log")
                if reason == "window":
                    trail.append((here.x, here.y))
                if reason != "log":
                    break
            else:
                rest_at = 0
            trail.append((here.x, here.y))
            if travelled > furthest[0]:
                furthest = (travelled, len(trail) - 1)
            previous, before = here, now
        if reason in ("rest", "log"):
            trail = trail[: rest_at + 1]
        if reason == "reverse":
            trail = trail[: furthest[1] + 1]
        found[float(scan)] = (reason, np.array(trail))
    return found


def wiggly_log(seed):
    random = np.random.default_rng(seed)
    segments = [
        (
            random.uniform(0.5, 3),
            random.choice([0.0, 0.3, 0.6, -0.2], p=[0.15, 0.35, 0.4, 0.1]),
            random.uniform(-1.2, 1.2),
        )
        for _ in range(12)
    ]
    stamps, poses, stick = drive(segments)
    return log_of(stamps, poses, stick, np.concatenate([FAR_WALLS / 12, L_WALLS[2:3]]))


def test_agrees_with_a_slow_reading_of_the_criteria_scan_by_scan():
    reasons = set()
    for seed in range(4):
        log = wiggly_log(seed)
        slow = slow_ends(log)
        fast = extract_local_paths(log)
        assert len(fast) > 20
        for i, stamp in enumerate(fast.stamp):
            reason, trail = slow[float(stamp)]
            assert fast.reason[i] == reason
            assert len(fast.paths[i]) == len(trail)
            np.testing.assert_allclose(fast.paths[i][:-1], trail[:-1], atol=1e-9)
            assert np.linalg.norm(fast.goal[i] - trail[-1]) <= (0.07 if reason == "window" else 1e-9)
            reasons.add(reason)
    assert reasons >= {"window", "hidden", "reverse", "turn", "log"}


def test_a_straight_drive_ends_on_the_windows_border():
    _, path, reason = first_path([(10, 0.5, 0.0)])
    assert reason == "window"
    np.testing.assert_allclose(path[-1], [2.5, 0], atol=1e-5)
    np.testing.assert_allclose(path[0], [0, 0], atol=1e-12)


def test_a_left_turn_leaves_the_window_at_its_side_and_points_left():
    paths, path, reason = first_path([(3.2, 0.5, np.pi / 2 / 3.2), (8, 0.5, 0.0)])
    assert reason == "window"
    assert path[-1, 1] == pytest.approx(2.5, abs=1e-5)
    assert paths.end_yaw[0] == pytest.approx(np.pi / 2, abs=1e-6)
    assert (paths.joystick[0] > 0).all()


def test_a_path_ends_where_a_corner_hides_it():
    stamps, poses, stick = drive([(8, 0.5, 0.0), (3.14, 0.5, 0.5), (10, 0.5, 0)], start=(0.0, 0.0, 0.0))
    walls = np.concatenate([FAR_WALLS, [[[-9.0, 0.6], [4.4, 0.6]], [[4.4, 0.6], [4.4, 9.0]]]])
    paths = extract_local_paths(log_of(stamps, poses, stick, walls))
    hidden = paths.goal[paths.reason == "hidden"]
    assert len(hidden) > 5
    assert (hidden[:, 1] > 0).all()


def test_a_turn_of_more_than_135_degrees_ends_a_path():
    paths, _, reason = first_path([(20, 0.5, 0.6)])
    assert reason == "turn"
    assert np.deg2rad(125) < paths.end_yaw[0] <= np.deg2rad(135)


def test_a_path_ends_where_the_chair_begins_to_reverse():
    _, path, reason = first_path([(2, 0.5, 0.0), (4, -0.5, 0.0)])
    assert reason == "reverse"
    np.testing.assert_allclose(path[-1], [1.0, 0.0], atol=1e-9)


def test_a_path_ends_behind_the_axle_of_its_start():
    config = LocalPathConfig(turn=10.0)
    _, path, reason = first_path([(30, 0.5, 0.5)], config=config)
    assert reason == "behind"
    assert -0.08 < path[-1, 0] <= 0


def test_a_path_ends_where_the_chair_rests_for_a_second_but_not_at_a_short_halt():
    _, path, reason = first_path([(2, 0.5, 0.0), (5, 0.0, 0.0), (4, 0.5, 0.0)])
    assert reason == "rest"
    np.testing.assert_allclose(path[-1], [1.0, 0.0], atol=1e-9)
    assert first_path([(2, 0.5, 0.0), (0.8, 0.0, 0.0), (6, 0.5, 0.0)])[2] == "window"


def test_the_end_of_the_log_counts_as_arrival():
    _, path, reason = first_path([(2, 0.5, 0.0), (0.3, 0.0, 0.0)])
    assert reason == "log"
    np.testing.assert_allclose(path[-1], [1.0, 0.0], atol=1e-9)


def test_no_path_goes_across_a_jump_of_the_odometry():
    stamps, poses, stick = drive([(8.0, 0.5, 0.0)])
    poses = np.array(poses)
    poses[40:] -= poses[40] - [0.2, -0.3, 0.0]  # it began anew
    paths = extract_local_paths(log_of(stamps, poses, stick, FAR_WALLS))
    steps = [np.linalg.norm(np.diff(path, axis=0), axis=1).max() for path in paths.paths]
    assert max(steps) < 0.2
    assert paths.dropped["gap"] >= 10


def test_a_gap_in_the_odometry_and_creeping_give_no_path_and_are_counted():
    stamps, poses, stick = drive([(6, 0.5, 0.0)])
    gap = np.where(np.arange(len(stamps)) >= 30, stamps + 5.0, stamps)
    paths = extract_local_paths(log_of(gap, poses, stick, FAR_WALLS))
    assert paths.dropped["gap"] >= 10
    assert (paths.stamp > 5).all() or not len(paths)
    stamps, poses, _ = drive([(200, 0.03, 0.0)])
    assert extract_local_paths(log_of(stamps, poses, np.ones((len(stamps), 2)), FAR_WALLS)).dropped["time"] > 1000


def test_short_paths_and_starts_without_input_are_dropped_and_counted():
    stamps, poses, stick = drive([(1.0, 0.5, 0.0), (3, 0.0, 0.0)])
    paths = extract_local_paths(log_of(stamps, poses, stick, FAR_WALLS))
    assert len(paths) == 0
    assert paths.dropped == {"too short": 10, "no input": 30, "no odometry": 1}


def test_the_goals_beam_is_the_argmin_over_all_angles_and_capped_at_the_window():
    log = corner_drive()
    paths = extract_local_paths(log)
    angles = log.angle_min + log.angle_increment * np.arange(181)
    for i in range(0, len(paths), 5):
        scan = int(np.searchsorted(log.scan_stamp, paths.stamp[i]))
        goal = T_BASE_LASER.inverse().transform(paths.goal[i][None])[0]
        off = (angles - np.arctan2(goal[1], goal[0]) + np.pi) % (2 * np.pi) - np.pi
        beam = int(np.argmin(np.abs(off)))
        to_border = min(
            (np.copysign(2.5, np.cos(angles[beam])) - 0.7) / np.cos(angles[beam]),
            abs(2.5 / np.sin(angles[beam])) if angles[beam] else np.inf,
        )
        assert paths.beam_range[i] == pytest.approx(min(log.ranges[scan, beam], to_border), abs=1e-5)


def test_clearance_is_the_distance_from_the_path_to_what_its_scan_hit():
    log = corner_drive()
    paths = extract_local_paths(log)
    angles = log.angle_min + log.angle_increment * np.arange(181)
    for i in range(0, len(paths), 9):
        ranges = log.ranges[int(np.searchsorted(log.scan_stamp, paths.stamp[i]))].astype(float)
        hits = T_BASE_LASER.transform(np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], 1))
        slow = min(np.hypot(*(hit - point)) for hit in hits for point in paths.paths[i])
        assert paths.clearance[i] == pytest.approx(slow, abs=1e-6)


def test_mirrored_paths_are_what_the_mirrored_drive_gives():
    stamps, poses, stick = drive([(3, 0.5, 0.0), (3, 0.5, 0.4), (6, 0.5, -0.1)])
    flip = np.array([1.0, -1.0])
    log = log_of(stamps, poses, stick, L_WALLS)
    other = log_of(stamps, poses * [1, -1, -1], stick * flip, L_WALLS * flip)
    a, b = extract_local_paths(log).mirrored(), extract_local_paths(other)
    np.testing.assert_allclose(a.goal, b.goal, atol=1e-6)
    np.testing.assert_allclose(a.beam_range, b.beam_range, atol=1e-4)
    np.testing.assert_allclose(a.joystick, b.joystick)
    np.testing.assert_allclose(a.end_yaw, b.end_yaw, atol=1e-9)


def test_scans_with_nan_everywhere_are_dropped_and_single_nan_beams_are_bridged():
    log = corner_drive()
    whole = extract_local_paths(log)
    log.ranges = log.ranges.copy()
    log.ranges[::2, ::10] = np.nan
    log.ranges[7] = np.nan
    paths = extract_local_paths(log)
    assert paths.dropped["no scan"] == 1
    assert len(paths) == pytest.approx(len(whole), abs=15)
    assert np.isfinite(paths.beam_range).all()


def straight_on(ranges):
    """A drive of 3 m ahead in the open, all of its scans (181,) alike, by a scanner of .25 to 100 m."""
    stamps, poses, stick = drive([(6, 0.5, 0.0)])
    scans = np.tile(np.asarray(ranges, np.float32), (len(stamps), 1))
    return extract_local_paths(log_of(stamps, poses, stick, ranges=scans, range_min=0.25, range_max=100.0))


def ahead(value):
    """Nothing is seen but by the 21 beams about ahead."""
    ranges = np.full(181, np.inf)
    ranges[80:101] = value
    return ranges


def test_what_is_too_close_hides_the_way_and_lies_on_it():
    paths = straight_on(ahead(-np.inf))
    assert paths.reason[0] == "hidden"
    assert paths.goal[0, 0] == pytest.approx(0.7 + 0.25, abs=0.11)
    assert paths.beam_range[0] == pytest.approx(0.25)
    assert paths.clearance[0] < 0.05


@pytest.mark.parametrize("value", [0.0, 0.125, np.nan])
def test_a_beam_below_range_min_measured_nothing_and_hides_nothing(value):
    paths = straight_on(ahead(value))
    assert paths.reason[0] == "window"
    assert paths.clearance[0] == np.inf
    assert paths.beam_range[0] == pytest.approx(2.5 - 0.7)


@pytest.mark.parametrize("value", [0.0, 0.125, np.nan])
def test_a_scan_of_nothing_but_ranges_below_range_min_is_no_scan(value):
    assert set(straight_on(np.full(181, value)).dropped) == {"no scan", "no odometry"}


@pytest.mark.parametrize("value", [100.0, 120.0, np.inf])
def test_beams_from_range_max_on_hit_nothing(value):
    assert straight_on(ahead(value)).clearance[0] == np.inf


def test_a_heading_turned_right_round_at_the_end_is_plus_pi():
    """The convention's interval is (-pi, pi]."""
    poses = np.linspace([0, 0, 0], [2, 0, np.pi], 41)
    log = log_of(np.arange(41) * 0.1, poses, np.tile([1.0, 0.0], (41, 1)), FAR_WALLS, range_max=100.0)
    paths = extract_local_paths(log, LocalPathConfig(turn=4.0, reverse=9.0))
    assert paths.end_yaw[0] == np.pi


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scan_stamp": np.zeros(0), "ranges": np.zeros((0, 181), np.float32)}, "0 scans"),
        ({"odometry_stamp": np.zeros(1), "pose": np.zeros((1, 3))}, "1 odometry samples"),
        ({"joystick_stamp": np.zeros(0), "joystick": np.zeros((0, 2))}, "no joystick; .*joystick_from_motion"),
        ({"ranges": np.zeros((5, 181), np.float32)}, r"ranges of shape \(5, 181\)"),
        ({"ranges": np.zeros((101, 0), np.float32)}, r"ranges of shape \(101, 0\)"),
    ],
)
def test_logs_without_the_needed_parts_are_refused_by_name(change, message):
    stamps, poses, stick = drive([(10, 0.5, 0.0)])
    log = dataclasses.replace(log_of(stamps, poses, stick, FAR_WALLS), **change)
    with pytest.raises(ValueError, match=message):
        extract_local_paths(log)


def test_no_demonstration_at_all_is_refused():
    with pytest.raises(ValueError, match="no demonstration was given"):
        LocalPaths.concatenate([])


def test_criteria_that_are_not_numbers_are_refused_by_name():
    with pytest.raises(ValueError, match="shortest is nan"):
        LocalPathConfig(shortest=float("nan"))
