"""The driver's input inferred from motion: never from the future, in the log's own limits."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import DriveLog, joystick_from_motion, open_log
from lfdcore.datasets.motion import motion_limits, windowed_twist
from lfdcore.geometry import Pose2, Twist2, integrate


def driven(twists: list[Twist2], duration: float = 0.1, scan_delay: float = 0.03) -> DriveLog:
    """A drive of exact arcs with one odometry record and one scan a step."""
    poses = [Pose2(1, 2, 3)]
    for twist in twists:
        poses.append(integrate(poses[-1], twist, duration))
    stamp = duration * np.arange(len(poses))
    return DriveLog(
        scan_stamp=stamp + scan_delay,
        ranges=np.ones((len(poses), 2)),
        odometry_stamp=stamp,
        pose=[[*pose] for pose in poses],
        twist=np.zeros((len(poses), 2)),
    )


def test_the_twist_of_an_even_drive_is_its_own() -> None:
    log = driven([Twist2(0.6, 0.3)] * 30)
    twist = windowed_twist(log.odometry_stamp, log.pose)
    np.testing.assert_allclose(twist[1:], np.tile([0.6, 0.3], (30, 1)), rtol=2e-3)  # the chord of an arc is shorter
    np.testing.assert_array_equal(twist[0], [0, 0])
    assert windowed_twist(np.zeros(0), np.zeros((0, 3))).shape == (0, 2)


def test_the_window_is_the_references_between_two_records() -> None:
    log = driven([Twist2(0.1 * (k % 7), 0.2 * (k % 5) - 0.4) for k in range(40)])
    twist = windowed_twist(log.odometry_stamp, log.pose)
    for k in range(6, 41):
        now = log.odometry_stamp[k]
        here, before = log.pose_at([now, now - 0.5])
        middle = (here[2] + before[2]) / 2
        v = (here - before)[:2] @ [np.cos(middle), np.sin(middle)] / 0.5
        np.testing.assert_allclose(twist[k], [v, (here[2] - before[2]) / 0.5], atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=10, max_size=40), st.data())
def test_what_follows_a_scan_never_changes_its_input(twists: list[tuple[float, float]], data: st.DataObject) -> None:
    log = driven([Twist2(*twist) for twist in twists])
    scan = data.draw(st.integers(0, len(log.scan_stamp) - 2))
    pose = log.pose.copy()
    pose[log.odometry_stamp > log.scan_stamp[scan]] += data.draw(st.floats(-5, 5))
    limits = Twist2(0.5, 0.5)
    before = joystick_from_motion(log, limits=limits)
    after = joystick_from_motion(dataclasses.replace(log, pose=pose), limits=limits)
    np.testing.assert_array_equal(before.joystick[: scan + 1], after.joystick[: scan + 1])


def test_full_deflection_is_the_95th_percentile_of_the_moving_speeds_either_way() -> None:
    linear = np.r_[np.zeros(50), np.linspace(0.1, 1.0, 100), -np.linspace(0.1, 1.0, 100)]
    limits = motion_limits(np.c_[linear, np.zeros(250)])
    assert limits.linear == pytest.approx(np.percentile(np.abs(linear[50:]), 95))
    assert limits.angular == 1.0


def test_faster_motion_is_cut_to_one_and_counted() -> None:
    log = joystick_from_motion(driven([Twist2(0.8, -0.3)] * 20), limits=Twist2(0.4, 0.6))
    np.testing.assert_allclose(log.joystick[5:], np.tile([1, -0.5], (16, 1)), rtol=2e-3)
    assert "full deflection at 0.400 m/s and 0.600 rad/s, 20 of 21 cut to 1" in log.metadata["joystick"]


def test_backwards_and_to_the_right_are_negative() -> None:
    log = joystick_from_motion(driven([Twist2(-0.3, -0.2)] * 20))
    assert (log.joystick[1:] < 0).all()


def test_a_recorded_joystick_is_left_alone() -> None:
    log = dataclasses.replace(driven([Twist2(1, 0)] * 3), joystick_stamp=[0.1], joystick=[[0.2, 0.3]])
    assert joystick_from_motion(log) is log


def test_scans_whose_odometry_is_old_or_yet_to_come_get_no_input() -> None:
    log = driven([Twist2(0.5, 0)] * 10)
    log = dataclasses.replace(log, scan_stamp=log.scan_stamp - 0.2 + 0.1 * np.arange(11))
    known = joystick_from_motion(log).joystick_stamp
    assert known[0] >= 0
    assert known[-1] <= log.odometry_stamp[-1] + 0.5
    assert 0 < len(known) < 11
    still = DriveLog(scan_stamp=[1.0], ranges=[[1.0]])
    assert len(joystick_from_motion(still).joystick) == 0


@pytest.mark.parametrize("window", [0.0, -1.0, np.nan, np.inf])
def test_a_window_that_is_none_is_refused(window: float) -> None:
    with pytest.raises(ValueError, match=r"window is .* s, must be positive"):
        joystick_from_motion(driven([Twist2(1, 0)]), window)
    with pytest.raises(ValueError, match="limits are"):
        joystick_from_motion(driven([Twist2(1, 0)]), limits=Twist2(window, 1))


@pytest.mark.realdata
@pytest.mark.parametrize("name", ["freiburg-079-corrected.log.gz", "sena-wheelchair-one-loop.rawlog"])
def test_real_drives_give_an_input_at_nearly_every_scan_and_few_are_cut(data_folder: Path, name: str) -> None:
    log = joystick_from_motion(open_log(data_folder / "logs" / name))
    assert len(log.joystick_stamp) >= 0.99 * len(log.scan_stamp)
    assert np.isin(log.joystick_stamp, log.scan_stamp).all()
    assert (np.abs(log.joystick) == 1).any(axis=1).mean() < 0.12
