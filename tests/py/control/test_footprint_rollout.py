"""Footprint roll-outs: contacts against dense sampling, laws and refusals."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.control import FootprintRolloutConfig, rollout_pursuit, time_to_contact
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, integrate
from lfdcore.grid import ObstaclePoints

CHAIR = Footprint()
NOTHING = ObstaclePoints(np.zeros((0, 2)))
STRAIGHT = np.column_stack([np.linspace(0, 3, 61), np.zeros(61)])


def test_straight_towards_a_wall_contact_comes_when_the_nose_has_come_there() -> None:
    wall = ObstaclePoints([[2.3, y] for y in np.arange(-0.3, 0.31, 0.05)])
    assert time_to_contact(Twist2(0.5, 0), wall, CHAIR, 8.0) == pytest.approx(3.0, abs=0.02)
    assert time_to_contact(Twist2(0.5, 0), wall, CHAIR, 2.9) == np.inf
    assert time_to_contact(Twist2(-0.5, 0), wall, CHAIR, 8.0) == np.inf


@settings(max_examples=150, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    linear=st.floats(-0.5, 1.0),
    angular=st.floats(-1.5, 1.5),
)
def test_time_to_contact_is_never_late_and_early_only_for_near_misses(seed: int, linear: float, angular: float) -> None:
    points = ObstaclePoints(np.random.default_rng(seed).uniform(-2, 2, (6, 2)))
    twist, times = Twist2(linear, angular), np.linspace(0, 3, 3001)
    found = time_to_contact(twist, points, CHAIR, 3.0)

    def first(body: Footprint) -> float:
        hits = (t for t in times if points.collides(integrate(Pose2(), twist, t), body))
        return next(hits, np.inf)

    assert found <= first(CHAIR)
    # A reported contact has a point within twice the 5 mm at which the bisection ends (body and sweep), soon after.
    assert found >= first(CHAIR.grown(0.011)) - 0.02 - 0.011 / max(abs(linear), abs(angular), 0.01)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_pose_of_a_rollout_before_its_contact_touches_anything(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = ObstaclePoints(rng.uniform(-0.5, 3.5, (10, 2)) + np.array([0, -1.5]))
    path = np.cumsum(np.vstack([[0, 0], np.column_stack([rng.uniform(0, 0.4, 8), rng.normal(0, 0.15, 8)])]), axis=0)
    rollout = rollout_pursuit(path, points, CHAIR)
    free = [not points.collides(Pose2(*pose), CHAIR) for pose in rollout.poses]
    started_free = free[0]
    assert all(free) or not started_free
    if not started_free:
        assert rollout.time_to_contact == 0
    assert (rollout.min_clearance == 0) == np.isfinite(rollout.time_to_contact)
    assert not (rollout.reached_end and np.isfinite(rollout.time_to_contact))
    if np.isfinite(rollout.time_to_contact):
        assert (len(rollout.poses) - 1) * 0.1 <= rollout.time_to_contact + 1e-9 <= len(rollout.poses) * 0.1 + 1e-9


def test_along_a_straight_path_the_chair_speeds_up_as_its_limits_allow_and_stops_at_the_end() -> None:
    rollout = rollout_pursuit(STRAIGHT, NOTHING, CHAIR)
    assert rollout.reached_end
    assert rollout.time_to_contact == np.inf
    assert rollout.min_clearance == np.inf
    np.testing.assert_allclose(rollout.poses[:, 1:], 0, atol=1e-12)
    speed = np.diff(rollout.poses[:, 0]) / 0.1
    np.testing.assert_allclose(speed[:4], [0.08, 0.16, 0.24, 0.32])
    assert speed.max() == pytest.approx(0.5)
    assert rollout.poses[-1, 0] == pytest.approx(3.0, abs=0.05)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), linear=st.floats(0, 0.8), angular=st.floats(-1, 1))
def test_every_step_keeps_the_motion_limits(seed: int, linear: float, angular: float) -> None:
    path = np.cumsum(np.random.default_rng(seed).normal(0, 0.3, (10, 2)), axis=0)
    limits = MotionLimits()
    rollout = rollout_pursuit(path, NOTHING, CHAIR, limits, Twist2(linear, angular))
    yaw = np.unwrap(rollout.poses[:, 2])
    rate = np.concatenate([[angular], np.diff(yaw) / 0.1])
    assert np.all(np.abs(rate) <= limits.max_angular + 1e-9)
    assert np.all(np.abs(np.diff(rate)) <= limits.angular_acceleration * 0.1 + 1e-9)


def test_the_mirrored_path_gives_the_mirrored_poses() -> None:
    path = np.column_stack([np.linspace(0, 2, 41), 0.3 * np.linspace(0, 2, 41) ** 2])
    one = rollout_pursuit(path, NOTHING, CHAIR)
    other = rollout_pursuit(path * (1, -1), NOTHING, CHAIR)
    np.testing.assert_allclose(other.poses, one.poses * (1, -1, -1), atol=1e-12)


def test_a_path_that_starts_behind_is_turned_to_in_place() -> None:
    rollout = rollout_pursuit(
        STRAIGHT * (-1, 1) + (0, 0.01), NOTHING, CHAIR, config=FootprintRolloutConfig(duration=15.0)
    )
    np.testing.assert_allclose(rollout.poses[:10, :2], 0, atol=1e-12)
    assert rollout.reached_end


def test_a_post_beside_the_axle_is_hit_by_the_turning_body_only() -> None:
    post = ObstaclePoints([[0.7, 0.45]])
    assert time_to_contact(Twist2(0.5, 0), post, CHAIR, 8.0) == np.inf
    assert time_to_contact(Twist2(0, 0.5), post, CHAIR, 8.0) < 1.0


def test_the_closest_pose_sets_min_clearance() -> None:
    rollout = rollout_pursuit(STRAIGHT, ObstaclePoints([[1.5, 0.55]]), CHAIR)
    assert rollout.min_clearance == pytest.approx(0.2, abs=1e-9)


def test_a_rollout_ends_after_its_duration() -> None:
    rollout = rollout_pursuit(STRAIGHT, NOTHING, CHAIR, config=FootprintRolloutConfig(duration=2.0, step=0.1))
    assert rollout.poses.shape == (21, 3)
    assert not rollout.reached_end


@pytest.mark.parametrize("path", [np.zeros((0, 2)), [[0.0, np.nan]], [[np.inf, 0.0]]])
def test_an_empty_or_infinite_path_is_refused(path: object) -> None:
    with pytest.raises(ValueError, match="path needs at least one point, all finite"):
        rollout_pursuit(path, NOTHING, CHAIR)


@pytest.mark.parametrize(
    ("field", "value"),
    [("look_ahead", 0.0), ("linear", -1.0), ("step", np.nan), ("step", 1e-9), ("duration", 0.0), ("duration", 1e9)],
)
def test_a_bad_setting_is_refused(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{field}|duration"):
        FootprintRolloutConfig(**{field: value})


def test_bad_twists_and_horizons_are_refused() -> None:
    with pytest.raises(ValueError, match=r"twist\.linear"):
        time_to_contact(Twist2(np.nan, 0), NOTHING, CHAIR, 1.0)
    with pytest.raises(ValueError, match="horizon"):
        time_to_contact(Twist2(0.5, 0), NOTHING, CHAIR, -1.0)
    with pytest.raises(ValueError, match=r"twist\.angular"):
        rollout_pursuit(STRAIGHT, NOTHING, CHAIR, twist=Twist2(0, np.inf))


def test_a_path_of_one_point_and_one_of_equal_points_are_followed() -> None:
    assert rollout_pursuit([[1.0, 0.0]], NOTHING, CHAIR).reached_end
    assert rollout_pursuit([[1.0, 0.0]] * 3, NOTHING, CHAIR).reached_end
    assert rollout_pursuit([[0.0, 0.0]], NOTHING, CHAIR).poses.shape == (1, 3)


def test_the_config_survives_pickling() -> None:
    config = pickle.loads(pickle.dumps(FootprintRolloutConfig(look_ahead=0.3)))
    assert (config.look_ahead, config.duration) == (0.3, FootprintRolloutConfig().duration)
