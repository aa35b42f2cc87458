"""A drive log in memory: what it refuses, how it is cut, what it says between its records."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfdcore.datasets import DriveLog, Intention, Plan
from lfdcore.geometry import Pose2


def line_log(count: int = 20) -> DriveLog:
    """Straight on at 1 m/s: one scan, odometry and joystick record every 0.5 s from 10 s on."""
    stamp = 10 + 0.5 * np.arange(count)
    zero = np.zeros(count)
    return DriveLog(
        scan_stamp=stamp,
        ranges=np.tile(np.arange(count, dtype=np.float32)[:, None], (1, 3)),
        odometry_stamp=stamp,
        pose=np.c_[stamp - 10, zero, zero],
        twist=np.c_[np.arange(count), zero],
        joystick_stamp=stamp,
        joystick=np.c_[np.linspace(0, 1, count), zero],
    )


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"scan_stamp": [1.0, 0.9, 1.2, 1.3]}, r"scan_stamp goes back from 1.0 s to 0.9 s at record 1"),
        ({"scan_stamp": [1.0, np.nan, 1.2, 1.3]}, "scan_stamp is nan at record 1"),
        ({"odometry_stamp": [[1.0]]}, r"odometry_stamp has shape \(1, 1\)"),
        ({"pose": np.zeros((4, 2))}, r"pose has shape \(4, 2\), must be \(4, 3\)"),
        ({"pose": np.full((4, 3), 1e300)}, "pose is 1e.300 m at record 0, must lie within .-1e.07 m"),
        ({"twist": np.full((4, 2), np.inf)}, "twist is inf at record 0, must be finite"),
        ({"command": np.zeros((3, 2))}, r"command has shape \(3, 2\), must be \(4, 2\)"),
        ({"joystick": np.full((4, 2), 1.1)}, r"joystick is 1.1 at record 0, must lie in \[-1, 1\]"),
        ({"desired": np.full((2, 2), -2.0)}, r"desired is -2.0 at record 0, must lie in \[-1, 1\]"),
        ({"ranges": np.zeros((3, 5))}, r"ranges has shape \(3, 5\), must be \(4, beams\)"),
        ({"ranges": np.zeros((4, 0))}, "ranges has 0 beams"),
        ({"ranges": np.full((4, 5), -1.0)}, "ranges is -1.0 m in scan 0"),
        ({"angle_increment": 0.0}, "angle_increment is 0 rad"),
        ({"range_max": 0.01}, r"range_min is 0.05 m, must lie in \[0, range_max = 0.01 m\)"),
        ({"T_base_laser": Pose2(np.nan, 0, 0)}, "T_base_laser are .* must be finite"),
        ({"plans": [Plan(1.0, np.zeros((2, 3)))]}, r"the plan at 1.0 s has shape \(2, 3\)"),
        ({"plans": [Plan(2.0, np.zeros((2, 2))), Plan(1.0, np.zeros((2, 2)))]}, "plans goes back"),
        ({"intentions": [Intention(1.0, (0.0, np.nan), 0.1)]}, "the intention at 1.0 s is nan"),
    ],
)
def test_a_log_that_cannot_be_is_refused_with_the_value(
    small_log: DriveLog, changes: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        dataclasses.replace(small_log, **changes)


def test_headings_are_made_continuous_and_stay_as_they_are_when_they_are() -> None:
    yaw = np.array([3.0, -3.0, -2.5])
    log = DriveLog(
        scan_stamp=[],
        ranges=np.zeros((0, 0)),
        odometry_stamp=[0, 1, 2],
        pose=np.c_[0 * yaw, 0 * yaw, yaw],
        twist=np.zeros((3, 2)),
    )
    np.testing.assert_allclose(log.pose[:, 2], [3.0, 2 * np.pi - 3.0, 2 * np.pi - 2.5])
    again = dataclasses.replace(log)
    assert np.array_equal(again.pose, log.pose)


def test_a_scan_comes_back_as_it_was_recorded(small_log: DriveLog) -> None:
    scan = small_log.scan(2)
    assert np.array_equal(scan.ranges, small_log.ranges[2])
    assert (scan.angle_min, scan.angle_increment) == (small_log.angle_min, small_log.angle_increment)
    assert (scan.range_min, scan.range_max) == (small_log.range_min, small_log.range_max)
    with pytest.raises(IndexError):
        small_log.scan(4)


def test_poses_are_interpolated_and_twist_and_joystick_are_held_from_the_record_before() -> None:
    log = line_log()
    np.testing.assert_allclose(log.pose_at([10.25, 11.0])[:, 0], [0.25, 1.0])
    np.testing.assert_array_equal(log.twist_at([9.9, 10.0, 10.49, 10.5])[:, 0], [0, 0, 0, 1])
    held = log.joystick_at([9.9, 10.7, 99.0])[:, 0]
    np.testing.assert_array_equal(held, [0, log.joystick[1, 0], log.joystick[-1, 0]])
    with pytest.raises(ValueError, match="t is nan at record 0"):
        log.pose_at([np.nan])
    with pytest.raises(ValueError, match="holds no odometry"):
        DriveLog(scan_stamp=[], ranges=np.zeros((0, 0))).pose_at([0.0])


def test_a_slice_holds_the_records_of_its_time_and_those_of_its_lead() -> None:
    cut = line_log().slice(11, 13, lead=0.5)
    np.testing.assert_array_equal(cut.scan_stamp, [11, 11.5, 12, 12.5])
    np.testing.assert_array_equal(cut.ranges[:, 0], [2, 3, 4, 5])
    np.testing.assert_array_equal(cut.odometry_stamp, [10.5, 11, 11.5, 12, 12.5])
    assert cut.duration == 2.0
    with pytest.raises(ValueError, match=r"t0 is 2 s, must not lie after t1 = 1 s"):
        line_log().slice(2, 1)


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_shares_part_the_scans_and_none_holds_anything_of_the_next(a: float, b: float, c: float) -> None:
    log = line_log()
    a, b, c = sorted((a, b, c))
    left, right, both = log.share(a, b), log.share(b, c), log.share(a, c)
    np.testing.assert_array_equal(np.r_[left.scan_stamp, right.scan_stamp], both.scan_stamp)
    if len(right.scan_stamp):
        for stamps in (left.odometry_stamp, left.joystick_stamp):
            assert (stamps < right.scan_stamp[0]).all()


def test_a_share_knows_the_motion_before_its_first_scan() -> None:
    late = line_log().share(0.5, 1)
    assert late.scan_stamp[0] == 15
    assert late.odometry_stamp[0] == 13
    assert line_log().share(0, 1).duration == line_log().duration
    with pytest.raises(ValueError, match=r"is 0\.6 to 0\.5"):
        line_log().share(0.6, 0.5)


def localised_log() -> DriveLog:
    """Odometry along x at 1 m/s; at 0 s its frame lies at (10, 0) turned left by 90 degrees, from 5 s on at (0, 20)."""
    stamp = np.arange(0.0, 10.0)
    return DriveLog(
        scan_stamp=stamp,
        ranges=np.ones((10, 3)),
        odometry_stamp=stamp,
        pose=np.c_[stamp, np.zeros((10, 2))],
        twist=np.zeros((10, 2)),
        map_stamp=[0.0, 5.0],
        map_odom=[[10, 0, np.pi / 2], [0, 20, 0]],
    )


def test_a_pose_in_the_map_is_the_odometrys_by_the_localisers_last_word() -> None:
    poses = localised_log().map_pose_at([-1, 2.5, 4.999, 5, 7])
    expected = [[10, 0, np.pi / 2], [10, 2.5, np.pi / 2], [10, 4.999, np.pi / 2], [5, 20, 0], [7, 20, 0]]
    np.testing.assert_allclose(poses, expected, atol=1e-12)


@given(st.floats(0, 9), st.floats(0, 9))
def test_a_slice_lies_in_the_map_where_the_whole_log_does(a: float, b: float) -> None:
    a, b = sorted((a, b))
    log = localised_log()
    cut = log.slice(a, b)
    assert (cut.map_stamp < b).all() or not len(cut.map_stamp)
    if len(cut.odometry_stamp):
        at = cut.odometry_stamp
        np.testing.assert_array_equal(cut.map_pose_at(at), log.map_pose_at(at))


def test_a_log_that_was_never_localised_says_so() -> None:
    with pytest.raises(ValueError, match="holds no pose in a map"):
        line_log().map_pose_at([1.0])
    with pytest.raises(ValueError, match=r"map_odom is nan at record 0, must be finite"):
        dataclasses.replace(localised_log(), map_odom=[[np.nan, 0, 0], [0, 0, 0]])
    with pytest.raises(ValueError, match=r"map_odom has shape \(1, 3\), must be \(2, 3\)"):
        dataclasses.replace(localised_log(), map_odom=[[0, 0, 0]])
