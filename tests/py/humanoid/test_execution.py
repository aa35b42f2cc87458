"""The executor: no joint faster than its limit, what is asked for is followed, and an abort holds for ever after."""

import os
import signal
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets.joint_motion import JointMotion
from lfdcore.humanoid.arm import follow_gripper
from lfdcore.humanoid.baxter import baxter
from lfdcore.humanoid.execution import RATE, Executed, Execution, KinematicRobot, execute, in_real_time, stream
from lfdcore.simulated.covering import CoveredObject, demonstrate_covering

NAMES = ("a", "b")
LIMITS = np.array([[-2.0, 2.0, 1.0], [-1.0, 3.0, 0.5]])


def swing(duration: float = 2.0, size: float = 0.3, samples: int = 41) -> JointMotion:
    """From rest to rest, well inside the limits by default."""
    time = np.linspace(0, duration, samples)
    turn = 2 * np.pi / duration
    positions = size * (1 - np.cos(turn * time))[:, None] / 2 * [1.0, 0.5]
    velocities = size * turn * np.sin(turn * time)[:, None] / 2 * [1.0, 0.5]
    return JointMotion(NAMES, time, positions, velocities)


def at_start(motion: JointMotion) -> KinematicRobot:
    return KinematicRobot(motion.positions[0], LIMITS, NAMES)


def test_a_motion_inside_the_limits_is_followed_exactly_at_100_hz() -> None:
    motion = swing()
    done = execute(motion, robot := at_start(motion))
    assert len(done.ticks) == 200
    np.testing.assert_allclose([tick.time for tick in done.ticks], np.arange(1, 201) / RATE, atol=1e-12)
    for tick in done.ticks:
        np.testing.assert_array_equal(tick.target, motion.at(tick.time))
    assert done.rms_error == pytest.approx(0, abs=1e-12)
    assert not done.aborted
    np.testing.assert_allclose(robot.positions, motion.positions[-1], atol=1e-12)


@given(st.floats(0.01, 3), st.floats(0.01, 0.9), st.floats(20, 400))
@settings(max_examples=40, deadline=None)
def test_no_joint_is_ever_faster_than_its_limit_however_fast_the_motion(duration, size, rate) -> None:  # type: ignore[no-untyped-def]
    motion = swing(duration, size)
    done = execute(motion, at_start(motion), rate=rate)
    positions = np.array([motion.positions[0], *(tick.positions for tick in done.ticks)])
    assert np.all(np.abs(np.diff(positions, axis=0)) <= LIMITS[:, 2] / rate * (1 + 1e-9))
    assert done.ticks[-1].time == motion.duration
    np.testing.assert_array_equal(done.errors, [abs(tick.target - tick.positions) for tick in done.ticks])


def test_a_motion_that_is_too_fast_leaves_a_tracking_error_that_names_the_joint() -> None:
    motion = swing(0.2, 0.9)
    done = execute(motion, at_start(motion))
    worst, joint = done.largest_error
    assert (worst, joint) == (done.errors.max(), NAMES[int(done.errors.max(axis=0).argmax())])
    assert worst > 0.1
    assert done.rms_error == pytest.approx(float(np.sqrt(np.mean(done.errors**2))))


def test_a_motion_written_for_the_arm_is_tracked_though_it_was_far_too_fast() -> None:
    one, robot = demonstrate_covering(CoveredObject("chair", 0.80, 0.44, 0.40), 100), baxter()
    joints = follow_gripper(robot, one.robot_names, one.stamp / 20, one.robot).joints
    assert joints is not None
    limits = robot.limits[[robot.joint_names.index(name) for name in joints.names]]
    done = execute(joints, KinematicRobot(joints.positions[0], limits, joints.names))
    assert done.largest_error[0] < 1e-4  # between samples cubics are at most .1 % faster than the limit


@given(st.integers(1, 199))
@settings(max_examples=20, deadline=None)
def test_an_abort_holds_the_place_where_the_robot_was_for_ever_after(ticks: int) -> None:
    motion, asked = swing(), []

    def stop(now: float) -> bool:
        asked.append(now)
        return len(asked) == ticks

    robot = at_start(motion)
    run = stream(motion, robot, stop)
    before = [next(run) for _ in range(ticks - 1)]
    where = robot.positions
    held = next(run)
    np.testing.assert_array_equal(held.target, where)
    np.testing.assert_array_equal(held.positions, where)
    assert list(run) == []
    np.testing.assert_array_equal(robot.positions, where)
    if before:
        np.testing.assert_array_equal(before[-1].positions, where)
    done = execute(motion, at_start(motion), lambda now: now >= ticks / RATE - 1e-9)
    assert done.aborted
    assert len(done.ticks) == ticks
    np.testing.assert_allclose(done.ticks[-1].target, where, atol=1e-12)


def test_an_abort_of_a_robot_that_lags_holds_where_it_is_and_not_where_it_should_be() -> None:
    motion = swing(0.2, 0.9)
    robot = at_start(motion)
    done = execute(motion, robot, lambda now: now > 0.1)
    assert done.aborted
    np.testing.assert_array_equal(robot.positions, done.ticks[-2].positions)
    assert np.abs(done.ticks[-2].target - robot.positions).max() > 0.05


def test_a_single_sample_asks_for_nothing() -> None:
    one = JointMotion(NAMES, [0.5], [[0.1, 0.2]], [[0.0, 0.0]])
    done = execute(one, at_start(one))
    assert (done.ticks, done.rms_error, done.largest_error) == ((), 0.0, (0.0, "a"))


def test_the_pace_is_that_of_the_clock_and_progress_is_reported() -> None:
    motion, reported = swing(0.3), []
    begin = time.monotonic()
    done = in_real_time(motion, at_start(motion), reported.append)
    assert time.monotonic() - begin >= 0.29
    assert len(reported) == len(done.ticks) == 30
    assert reported[-1] == pytest.approx(0.3)


def test_sigint_ends_it_between_ticks_and_gives_the_signal_back() -> None:
    motion, before = swing(60), signal.getsignal(signal.SIGINT)
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    done = in_real_time(motion, robot := at_start(motion), lambda now: None, rate=0.5)  # a tick would take 2 s
    assert done.aborted
    assert done.ticks[-1].time == 2.0
    np.testing.assert_array_equal(robot.positions, motion.positions[0])
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf, 1e9])
def test_rates_that_cannot_be_are_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="must be > 0 and <= 10000 Hz"):
        execute(swing(), at_start(swing()), rate=rate)


def test_a_robot_that_is_elsewhere_is_not_moved() -> None:
    motion = swing()
    away = KinematicRobot([0.0, 0.2], LIMITS, NAMES)
    with pytest.raises(ValueError, match=r"b is at 0\.200, the motion begins at 0\.000"):
        execute(motion, away)
    np.testing.assert_array_equal(away.positions, [0.0, 0.2])
    with pytest.raises(ValueError, match="the robot has 1 joints, the motion 2"):
        execute(motion, KinematicRobot([0.0], LIMITS[:1], NAMES[:1]))


@pytest.mark.parametrize("target", [[2.1, 0], [0, -1.1], [np.nan, 0], [np.inf, 0], [0.0]])
def test_a_target_outside_is_refused_and_the_robot_stays(target: list[float]) -> None:
    robot = KinematicRobot([0.1, 0.2], LIMITS, NAMES)
    with pytest.raises(ValueError, match="must be"):
        robot.command(np.array(target), 0.1)
    np.testing.assert_array_equal(robot.positions, [0.1, 0.2])


def test_robots_that_cannot_be_are_refused() -> None:
    for positions, limits, reason in (
        ([3.0, 0], LIMITS, "a is to go to 3"),
        ([0.0], LIMITS, "of 2 joints have shapes"),
        ([0.0, 0.0], LIMITS * [1, 1, -1], "velocity limits are"),
        ([0.0, 0.0], np.full((2, 3), np.nan), "velocity limits are"),
    ):
        with pytest.raises(ValueError, match=reason):
            KinematicRobot(positions, limits, NAMES)
    robot = KinematicRobot([0.0, 0.0], LIMITS, NAMES)
    for duration in (-1, np.nan, np.inf):
        with pytest.raises(ValueError, match="must be finite and >= 0"):
            robot.command(np.zeros(2), duration)
    robot.positions[:] = 9  # a copy
    np.testing.assert_array_equal(robot.positions, [0, 0])


def test_errors_of_an_execution_have_a_row_a_tick() -> None:
    ticks = (Executed(0.1, np.array([1.0, 2.0]), np.array([0.5, 2.0])),)
    done = Execution(NAMES, ticks, False)
    assert done.errors.tolist() == [[0.5, 0.0]]
    assert done.largest_error == (0.5, "a")
