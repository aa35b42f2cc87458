"""The stick that asks for what a vehicle did next: an oracle on known motion, laws, and what gives no pair."""

import dataclasses

import numpy as np
import pytest

from lfdcore.datasets import DriveLog, followed_pairs, joystick_from_motion
from lfdcore.geometry import Pose2, Twist2, integrate

LIMITS = Twist2(1.0, 2.0)
STEP = 0.05


def log_of_motion(twists, stick=(0.6, -0.2), gap=()) -> DriveLog:
    """A log whose odometry follows twists (T, 2), one a step; records whose index is in `gap` are missing."""
    poses = [Pose2(0, 0, 0)]
    for v, w in twists:
        poses.append(integrate(poses[-1], Twist2(v, w), STEP))
    kept = np.setdiff1d(np.arange(len(poses)), gap)
    stamp = np.arange(len(poses)) * STEP
    yaw = np.unwrap([pose.yaw for pose in poses])
    pose = np.array([[p.x, p.y, a] for p, a in zip(poses, yaw, strict=True)])
    scans = stamp[::2]
    return DriveLog(
        scan_stamp=scans,
        ranges=np.ones((len(scans), 3), np.float32),
        odometry_stamp=stamp[kept],
        pose=pose[kept],
        twist=np.zeros((len(kept), 2)),
        joystick_stamp=stamp,
        joystick=np.tile(stick, (len(stamp), 1)),
        name="motion",
    )


def test_a_constant_arc_is_the_stick_that_asks_for_it():
    pairs = followed_pairs(log_of_motion([(0.5, 0.4)] * 60), LIMITS)
    assert len(pairs.stamp) == 21  # scans of the first 2 of 3 s
    np.testing.assert_allclose(pairs.raw, np.tile([0.6, -0.2], (21, 1)))
    chord = np.sin(0.2) / 0.2  # the mean along the heading in the middle of the turn is the chord's
    np.testing.assert_allclose(pairs.safe, np.tile([0.5 * chord, 0.2], (21, 1)), atol=1e-9)


def test_more_than_half_a_turn_within_the_horizon_is_not_taken_for_the_shorter_way_round():
    pairs = followed_pairs(log_of_motion([(0.0, 1.2)] * 120), LIMITS, horizon=4.0)
    np.testing.assert_allclose(pairs.safe[:, 1], 1.2 / LIMITS.angular)


def test_what_is_followed_is_the_mean_of_the_next_second_and_nothing_before():
    twists = [(0.2, 0.0)] * 20 + [(0.4, 0.0)] * 10 + [(0.8, 0.0)] * 30
    pairs = followed_pairs(log_of_motion(twists), LIMITS)
    at = {round(float(t), 2): s for t, s in zip(pairs.stamp, pairs.safe[:, 0], strict=True)}
    assert at[0.0] == pytest.approx(0.2)
    assert at[1.0] == pytest.approx((0.4 + 0.8) / 2)
    assert at[1.5] == pytest.approx(0.8)


def test_left_and_right_exchanged_exchange_the_sticks():
    twists = np.array([(0.5, 0.3 * np.sin(k / 5)) for k in range(80)])
    one, other = (followed_pairs(log_of_motion(twists * [1, side]), LIMITS) for side in (1, -1))
    np.testing.assert_allclose(one.safe * [1, -1], other.safe, atol=1e-9)


def test_faster_motion_than_the_limits_is_full_stick():
    pairs = followed_pairs(log_of_motion([(1.5, 0.0)] * 40), LIMITS)
    assert (pairs.safe == [1, 0]).all()


def test_a_gap_and_the_end_give_no_pair():
    whole = followed_pairs(log_of_motion([(0.5, 0.0)] * 100), LIMITS)
    torn = followed_pairs(log_of_motion([(0.5, 0.0)] * 100, gap=np.arange(41, 70)), LIMITS)
    missing = np.setdiff1d(np.round(whole.stamp, 3), np.round(torn.stamp, 3))
    assert len(missing) > 0
    assert missing.min() >= 41 * STEP - 1 - 1e-9
    assert missing.max() < 70 * STEP
    assert len(followed_pairs(log_of_motion([(0.5, 0.0)] * 15), LIMITS).stamp) == 0


@pytest.mark.parametrize(
    ("change", "arguments", "said"),
    [
        ({}, (LIMITS, 0.0), "horizon is 0.0 s"),
        ({}, (LIMITS, np.nan), "horizon is nan s"),
        ({}, (Twist2(0.0, 1.0),), "limits"),
        ({}, (Twist2(1.0, np.inf),), "limits"),
        ({"joystick_stamp": np.zeros(0), "joystick": np.zeros((0, 2))}, (LIMITS,), "'motion' has no joystick"),
    ],
)
def test_what_cannot_be_paired_is_refused(change, arguments, said):
    log = dataclasses.replace(log_of_motion([(0.5, 0.0)] * 40), **change)
    with pytest.raises(ValueError, match=said):
        followed_pairs(log, *arguments)


def test_a_steady_drive_with_an_inferred_stick_follows_it():
    log = log_of_motion([(0.5, 0.4)] * 100)
    bare = dataclasses.replace(log, joystick_stamp=np.zeros(0), joystick=np.zeros((0, 2)))
    pairs = followed_pairs(joystick_from_motion(bare, limits=LIMITS), LIMITS)
    steady = pairs.stamp > 0.5
    assert steady.sum() > 20
    np.testing.assert_allclose(pairs.raw[steady], pairs.safe[steady], atol=0.01)
