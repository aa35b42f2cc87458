"""What came in last, with its own stamp: no old value ever gets a new one."""

import math
import time

import numpy as np
import pytest

from lfdcore.datasets import ros_messages as ros
from lfdcore.geometry import Pose2, Twist2, integrate
from lfdcore.ros.frames import Frames
from lfdcore.ros.messages import NO_BEAMS, motion_of, scan_of, stick_of
from lfdcore.ros.odometry_buffer import Motion, OdometryBuffer
from lfdcore.ros.senses import Senses
from ros_words import odometry, quaternion, scan

SECOND = 1_000_000_000


def senses(said: list[str] | None = None, now: int = 50 * SECOND) -> Senses:
    return Senses((1, 0), lambda: now, (said if said is not None else []).append)


def received(seconds_ago: float) -> dict[str, int]:
    return {"received_timestamp": time.time_ns() - round(seconds_ago * 1e9)}


def joy(seconds: float, *axes: float) -> object:
    message = ros.joystick_message(round(seconds * 1e9), 0, 0)
    message.axes = np.array(axes, np.float32)
    return message


def buffer(*stamps: float, twist: Twist2 | None = None) -> OdometryBuffer:
    kept = OdometryBuffer()
    for stamp in stamps:
        kept.add(Motion(round(stamp * SECOND), Pose2(stamp, 0.0, stamp), twist or Twist2()))
    return kept


def test_a_scans_pose_is_interpolated_also_across_a_half_turn() -> None:
    pose = buffer(1.0, 2.0, 3.0).pose_at(round(2.25 * SECOND))
    assert pose is not None
    assert [*pose] == pytest.approx([2.25, 0, 2.25])
    turning = OdometryBuffer()
    turning.add(Motion(0, Pose2(0, 0, 3.1), Twist2()))
    turning.add(Motion(SECOND, Pose2(0, 0, -3.1), Twist2()))
    pose = turning.pose_at(SECOND // 2)
    assert pose is not None
    assert abs(math.remainder(pose.yaw - math.pi, 2 * math.pi)) < 1e-9


def test_a_scan_a_little_younger_than_odometry_goes_on_with_its_twist_and_no_farther() -> None:
    twist = Twist2(0.5, 0.4)
    kept = buffer(1.0, twist=twist)
    assert kept.pose_at(round(1.05 * SECOND)) is not None
    assert [*(kept.pose_at(round(1.05 * SECOND)) or ())] == pytest.approx([*integrate(Pose2(1, 0, 1), twist, 0.05)])
    assert kept.pose_at(round(1.11 * SECOND)) is None
    assert kept.pose_at(round(0.99 * SECOND)) is None
    assert OdometryBuffer().pose_at(0) is None


def test_odometry_keeps_two_seconds_and_begins_anew_when_a_clock_is_set_back() -> None:
    kept = buffer(*np.arange(0, 10, 0.1))
    assert kept.pose_at(round(7.8 * SECOND)) is None
    assert kept.pose_at(round(8.0 * SECOND)) is not None
    kept.add(Motion(3 * SECOND, Pose2(), Twist2()))
    assert kept.newest == Motion(3 * SECOND, Pose2(), Twist2())
    assert kept.pose_at(2 * SECOND) is None
    kept.add(Motion(3 * SECOND, Pose2(7, 0, 0), Twist2()))  # the same stamp again
    assert kept.pose_at(3 * SECOND) == Pose2(7, 0, 0)


def test_a_scan_stays_with_its_own_stamp_until_it_is_known_where_the_next_was_taken() -> None:
    one = senses()
    one.take_odometry(odometry(1.0, Pose2(1, 0, 0)))
    one.take_scan(scan(1.0))
    first = one.scan()
    assert first is not None
    assert (first.stamp, first.pose) == (SECOND, Pose2(1, 0, 0))
    one.take_scan(scan(1.5))
    assert one.scan() == first
    one.take_odometry(odometry(1.5, Pose2(2, 0, 0)))
    second = one.scan()
    assert second is not None
    assert (second.stamp, second.pose) == (3 * SECOND // 2, Pose2(2, 0, 0))
    assert one.scan() is second


def test_messages_of_other_frames_are_not_listened_to_and_it_is_said() -> None:
    said: list[str] = []
    one = senses(said)
    one.settle(Frames("laser", "odom", "base_link"), mirrored=False)
    one.take_odometry(odometry(1.0, Pose2(1, 0, 0)))
    one.take_odometry(odometry(1.1, Pose2(9, 0, 0), child="camera"))
    one.take_scan(scan(1.0, frame="rear_laser"))
    motion = one.motion()
    assert motion is not None
    assert motion.stamp == SECOND
    assert one.scan() is None
    assert len(said) == 2
    assert "'rear_laser', not in 'laser'" in said[1]


def test_a_stick_without_stamps_is_of_when_it_was_received_not_of_when_it_was_taken_in() -> None:
    one = senses(now=50 * SECOND)
    one.take_joystick(joy(7.0, 0.1, 0.2), received(0.0))
    stick = one.stick()
    assert stick is not None
    assert stick.stamp == 7 * SECOND
    assert stick.joystick == pytest.approx((0.2, 0.1))
    one.take_joystick(joy(0.0, 0.1, 0.2), received(1.5))
    stick = one.stick()
    assert stick is not None
    assert stick.stamp / SECOND == pytest.approx(48.5, abs=0.2)


def test_a_stick_without_stamps_does_not_go_back_while_a_simulators_clock_stands_still() -> None:
    one = senses(now=50 * SECOND)
    stamps = []
    for waited in (0.001, 0.01, 0.0, 0.02):
        one.take_joystick(joy(0.0, 0.1, 0.2), received(waited))
        stick = one.stick()
        assert stick is not None
        stamps.append(stick.stamp)
    assert stamps == sorted(stamps)
    assert stamps[-1] <= 50 * SECOND


def test_what_is_not_said_is_no_number() -> None:
    assert math.isnan(stick_of(joy(1.0, 0.3), (1, 0))[0])
    assert stick_of(joy(1.0, 0.25), (1, 0))[1] == 0.25
    unturned = odometry(1.0, Pose2(1, 2, 0))
    unturned.pose.pose.orientation = quaternion(0, 0, 0)
    unturned.pose.pose.orientation.w = 0.0
    pose, _ = motion_of(unturned)
    assert (pose.x, pose.y) == (1, 2)
    assert math.isnan(pose.yaw)
    flat = scan(1.0)
    flat.angle_increment = 0.0
    assert scan_of(flat, mirrored=False) is NO_BEAMS
    assert not len(scan_of(scan(1.0, []), mirrored=False).ranges)
