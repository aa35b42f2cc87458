"""Pure pursuit, the dynamic window and the supervisor through their Python faces: laws, refusals, borders."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.control import (
    CommandTiming,
    DynamicWindowConfig,
    Supervisor,
    SupervisorConfig,
    pure_pursuit,
    solve_dynamic_window,
)
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, approach, integrate
from lfdcore.grid import ObstaclePoints

speeds = st.floats(-2, 2)
angles = st.floats(-math.pi, math.pi)


def random_walls(seed: int) -> np.ndarray:
    """Points (M, 2) [m] of ten walls, none within 1 m of the origin."""
    rng = np.random.default_rng(seed)
    walls = []
    for _ in range(10):
        start, yaw = rng.uniform(-3, 3, 2), rng.uniform(-math.pi, math.pi)
        walls.append(start + np.arange(0, rng.uniform(0.3, 2), 0.04)[:, None] * [math.cos(yaw), math.sin(yaw)])
    points = np.vstack(walls)
    return points[np.hypot(*points.T) > 1]


def inside(points: np.ndarray, footprint: Footprint) -> np.ndarray:
    x, y = points.T
    return (x < footprint.front) & (x > -footprint.rear) & (np.abs(y) < footprint.half_width)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), commands=st.lists(st.tuples(speeds, speeds), min_size=1, max_size=25))
def test_no_sequence_of_commands_brings_a_point_into_the_footprint(
    seed: int, commands: list[tuple[float, float]]
) -> None:
    world, limits, foot = random_walls(seed), MotionLimits(), Footprint()
    supervisor = Supervisor(foot, limits)
    pose, twist = Pose2(), Twist2()
    for linear, angular in commands:
        for _ in range(4):
            seen = ObstaclePoints(pose.inverse().transform(world))
            result = supervisor.filter(Twist2(linear, angular), twist, seen)
            assert abs(result.twist.linear) <= abs(linear)
            assert abs(result.twist.angular) <= limits.max_angular
            assert -limits.max_reverse <= result.twist.linear <= limits.max_linear
            for _ in range(10):
                after = approach(twist, result.twist, limits, 0.01)
                mean = Twist2((twist.linear + after.linear) / 2, (twist.angular + after.angular) / 2)
                pose, twist = integrate(pose, mean, 0.01), after
                assert not inside(pose.inverse().transform(world), foot).any()


@settings(max_examples=200, deadline=None, derandomize=True)
@given(linear=speeds, angular=speeds, seed=st.integers(0, 10**6))
def test_supervised_twist_is_nearer_to_the_wanted_one_than_standing_still_or_is_standing_still(
    linear: float, angular: float, seed: int
) -> None:
    limits = MotionLimits()
    world = random_walls(seed) * [0.9, 0.5]  # some points inside the footprint
    result = Supervisor(limits=limits).filter(Twist2(linear, angular), Twist2(), ObstaclePoints(world))
    aim = np.clip(
        [linear, angular], [-limits.max_reverse, -limits.max_angular], [limits.max_linear, limits.max_angular]
    )
    sent = np.array([*result.twist])
    weights = np.array([limits.max_reverse if linear < 0 else limits.max_linear, limits.max_angular])
    distance, rest = math.hypot(*(sent - aim) / weights), math.hypot(*aim / weights)
    assert distance < rest or not sent.any()
    assert result.changed == ((*result.twist,) != (linear, angular))
    assert result.stopped == (not sent.any() and (linear != 0 or angular != 0))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(goal_angle=angles, distance=st.floats(0.05, 3), linear=st.floats(0.01, 1), limit=st.floats(0.1, 3))
def test_pursuit_keeps_its_limits_and_turns_to_the_side_of_the_control_point(
    goal_angle: float, distance: float, linear: float, limit: float
) -> None:
    end = distance * np.array([math.cos(goal_angle), math.sin(goal_angle)])
    result = pure_pursuit(np.array([[0.0, 0.0], end]), 0.8, linear, limit)
    assert 0 <= result.twist.linear <= linear
    assert abs(result.twist.angular) <= limit
    assert result.twist.angular * result.control_point[1] >= 0
    assert np.linalg.norm(result.control_point) == pytest.approx(min(distance, 0.8))
    assert result.at_end == (distance < 0.8) or distance == pytest.approx(0.8)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(x=st.floats(-5, 5), y=st.floats(-5, 5), yaw=angles)
def test_pursuit_does_not_depend_on_the_frame_of_the_path(x: float, y: float, yaw: float) -> None:
    path = np.array([[0.0, 0.1], [0.5, 0.2], [1.0, 0.6], [1.2, 1.4]])
    here, there = pure_pursuit(path, 0.8, 0.5), Pose2(x, y, yaw)
    moved = pure_pursuit(there.transform(path), 0.8, 0.5, pose=there)
    assert np.allclose(here.control_point, moved.control_point, atol=1e-9)
    assert [*here.twist] == pytest.approx([*moved.twist], abs=1e-9)
    assert here.arc_length == pytest.approx(moved.arc_length)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), linear=st.floats(-0.4, 1), angular=st.floats(-1, 1), goal=st.tuples(speeds, speeds))
def test_dynamic_window_keeps_the_window_and_collides_with_nothing(
    seed: int, linear: float, angular: float, goal: tuple[float, float]
) -> None:
    limits, foot, obstacles = MotionLimits(), Footprint(), ObstaclePoints(random_walls(seed))
    result = solve_dynamic_window(Twist2(linear, angular), np.array(goal), obstacles, foot, limits)
    low = approach(Twist2(linear, angular), Twist2(-9, -9), limits, 0.1)
    high = approach(Twist2(linear, angular), Twist2(9, 9), limits, 0.1)
    assert low.linear - 1e-12 <= result.twist.linear <= high.linear + 1e-12
    assert low.angular - 1e-12 <= result.twist.angular <= high.angular + 1e-12
    poses = [integrate(Pose2(), result.twist, 0.1 * k) for k in range(1, 21)]
    assert not (result.feasible and any(obstacles.collides(pose, foot) for pose in poses))
    assert result.end_point == pytest.approx([poses[-1].x, poses[-1].y])


def test_dynamic_window_of_one_twist_is_the_middle_of_the_window() -> None:
    config = DynamicWindowConfig(linear_samples=1, angular_samples=1)
    result = solve_dynamic_window(
        Twist2(0.5, 0.0), np.array([1.0, 0.0]), ObstaclePoints(np.empty((0, 2))), config=config
    )
    assert result.twist.linear == pytest.approx((0.58 + 0.35) / 2)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"margin": -0.01}, r"margin is -0.01 m, must be between 0 and 1"),
        ({"least_margin": math.nan}, r"least_margin is nan m"),
        ({"least_margin": 0.05}, r"least_margin is 0.05 m, must be between 0 and 0.04"),
        ({"dynamics_error": 1.0}, r"dynamics_error is 1, must be between 0 and 0.9"),
        ({"least_scale": 0.0}, r"least_scale is 0"),
        ({"angular_samples": 1}, r"angular_samples is 1"),
    ],
)
def test_supervisor_config_names_what_is_wrong(config: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SupervisorConfig(**config)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("timing", "message"),
    [
        ({"jitter": -0.05}, r"jitter is -0.05 s, must be between 0 and 10"),
        ({"period": 0.0}, r"period is 0 s, must be positive"),
        ({"period": 11.0}, r"period is 11 s, must be between 0 and 10"),
        ({"period": math.nan}, r"period is nan s"),
    ],
)
def test_command_timing_names_what_is_wrong(timing: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CommandTiming(**timing)


def test_commands_that_are_not_numbers_are_refused_by_name() -> None:
    nothing = ObstaclePoints(np.empty((0, 2)))
    with pytest.raises(ValueError, match=r"wanted angular is nan rad/s, must be finite"):
        Supervisor().filter(Twist2(0.1, math.nan), Twist2(), nothing)
    with pytest.raises(ValueError, match=r"current linear is inf m/s"):
        Supervisor().filter(Twist2(0.1, 0.0), Twist2(math.inf, 0.0), nothing)
    with pytest.raises(ValueError, match=r"goal x is nan m"):
        solve_dynamic_window(Twist2(), np.array([math.nan, 0.0]), nothing)
    with pytest.raises(ValueError, match=r"look_ahead is 0 m, must be positive"):
        pure_pursuit(np.zeros((2, 2)), 0.0, 0.5)
    with pytest.raises(ValueError, match=r"the path has 0 points"):
        pure_pursuit(np.empty((0, 2)), 0.8, 0.5)
    with pytest.raises(TypeError):
        pure_pursuit(np.zeros((2, 3)), 0.8, 0.5)


def test_what_is_pending_unseen_or_old_is_told_by_keyword() -> None:
    wall = np.stack([np.full(61, 1.2), np.linspace(-1.5, 1.5, 61)], axis=1)
    ahead, nothing, now = ObstaclePoints(wall), ObstaclePoints(np.empty((0, 2))), Twist2(0.5, 0.0)
    walking = Supervisor(config=SupervisorConfig(obstacle_speed=0.5))
    assert not Supervisor().filter(now, now, ahead).changed
    assert Supervisor().filter(now, now, ahead, pending=[(now, 0.2), (now, 0.2)]).scale < 1
    assert not Supervisor().filter(now, now, ahead, age=2.0).changed
    assert walking.filter(now, now, ahead).scale > walking.filter(now, now, ahead, age=0.3).scale
    assert not Supervisor().filter(now, Twist2(), nothing, unseen=None).changed
    assert Supervisor().filter(now, Twist2(), nothing, unseen=ObstaclePoints(wall - [0.5, 0.0])).twist.linear <= 0.1
    with pytest.raises(ValueError, match=r"pending duration is -1 s, must be between 0 and 10"):
        Supervisor().filter(now, now, ahead, pending=[(now, -1.0)])
    with pytest.raises(ValueError, match=r"age is nan s, must be between 0 and 10"):
        Supervisor().filter(now, now, ahead, age=math.nan)


def test_a_wall_beside_the_chair_is_held_until_a_reset_or_a_stick_let_go() -> None:
    x = np.linspace(-2, 3, 200)
    near, nearer = (ObstaclePoints(np.stack([x, np.full(200, 0.35 + beside)], axis=1)) for beside in (0.003, -0.004))
    supervisor, ahead = Supervisor(), Twist2(0.1, 0.0)
    for let_go in (supervisor.reset, lambda: supervisor.filter(Twist2(), Twist2(), nearer)):
        supervisor.reset()
        assert not supervisor.filter(ahead, Twist2(), near).changed
        assert supervisor.filter(ahead, Twist2(), nearer).stopped
        let_go()
        assert not supervisor.filter(ahead, Twist2(), nearer).changed


def test_configs_and_supervisors_cross_process_borders() -> None:
    config, timing = SupervisorConfig(margin=0.05, angular_samples=9), CommandTiming(period=0.2, jitter=0.4)
    supervisor = pickle.loads(pickle.dumps(Supervisor(Footprint(0.9), MotionLimits(max_linear=0.7), config, timing)))
    assert (supervisor.config, supervisor.timing) == (config, timing)
    assert (supervisor.footprint.front, supervisor.limits.max_linear) == (0.9, 0.7)
    window = pickle.loads(pickle.dumps(DynamicWindowConfig(horizon=1.0, linear_samples=5)))
    assert (window.horizon, window.linear_samples, window.angular_samples) == (1.0, 5, 21)
