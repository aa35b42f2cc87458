"""Whole trajectories of the gripper become joint trajectories inside all limits, or it is said where and why not."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lfdcore.humanoid.baxter import baxter, baxter_arm, neutral_posture
from lfdcore.kinematics import FollowConfig, SelfCollision, follow_poses, joint_velocities, slow_down

MODEL = baxter()
LEFT = baxter_arm(MODEL, "left")
FORWARD = np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]])  # the gripper's z axis points forward
TIME = np.linspace(0, 5, 500)


def sweep(side: float = 1.0, steps: int = 500) -> NDArray[np.float64]:
    """An arc in front of the robot, at rest at both ends."""
    s = np.linspace(0, 1, steps)
    s = s * s * (3 - 2 * s)
    poses = np.tile(np.eye(4), (steps, 1, 1))
    poses[:, :3, :3] = FORWARD
    poses[:, :3, 3] = np.stack(
        [0.75 + 0.1 * np.sin(2 * np.pi * s), side * (0.2 + 0.4 * s), 0.1 + 0.3 * np.sin(np.pi * s)], 1
    )
    return poses


def test_a_sweep_is_followed_inside_position_velocity_and_self_collision_limits() -> None:
    robot, posture, poses = SelfCollision(MODEL), neutral_posture(MODEL), sweep()
    result = follow_poses(LEFT, TIME, poses, self_collision=robot, posture=posture)
    trajectory = result.trajectory
    assert (result.outcome, result.first_failure, result.slowdown) == ("followed", None, 1.0)
    assert np.all((trajectory.positions >= LEFT.lower) & (trajectory.positions <= LEFT.upper))
    assert np.all(np.abs(trajectory.velocities) <= LEFT.velocity + 1e-9)
    columns = [MODEL.joint_names.index(name) for name in LEFT.joint_names]
    for q, wanted in zip(trajectory.positions, poses, strict=True):
        np.testing.assert_allclose(LEFT.forward(q), wanted, atol=2e-4)
        posture[columns] = q
        assert robot.distance(posture) >= result.clearance - 1e-12
    assert result.clearance >= 0.02


def test_the_joints_move_smoothly() -> None:
    velocities = follow_poses(LEFT, TIME, sweep()).trajectory.velocities
    assert np.abs(np.diff(velocities, axis=0)).max() < 0.05  # 5 rad/s^2


def test_what_is_too_fast_takes_longer_on_the_same_path() -> None:
    slow, fast = follow_poses(LEFT, TIME, sweep()), follow_poses(LEFT, TIME / 10, sweep())
    assert fast.outcome == "followed"
    assert fast.slowdown > 2
    assert np.all(np.abs(fast.trajectory.velocities) <= LEFT.velocity * (1 + 1e-9))
    for q, wanted in zip(fast.trajectory.positions, sweep(), strict=True):
        np.testing.assert_allclose(LEFT.forward(q), wanted, atol=2e-4)
    assert slow.slowdown == 1


def test_a_path_that_leaves_the_reach_says_where() -> None:
    poses = sweep()
    poses[300:, 0, 3] += 2.0
    result = follow_poses(LEFT, TIME, poses)
    assert (result.outcome, result.first_failure) == ("out_of_reach", 300)
    assert len(result.trajectory.time) == 300


def test_a_jump_of_the_gripper_is_no_continuous_path() -> None:
    poses = sweep()
    poses[250:, 1, 3] -= 0.5
    result = follow_poses(LEFT, TIME, poses)
    assert (result.outcome, result.first_failure) == ("no_continuous_path", 250)


def test_a_path_through_the_other_arm_is_refused_and_names_the_links() -> None:
    robot, posture = SelfCollision(MODEL), neutral_posture(MODEL)
    right = MODEL.chain("base", "right_gripper")
    columns = [MODEL.joint_names.index(name) for name in right.joint_names]
    target = right.forward(posture[columns])[:3, 3]
    poses = sweep()
    poses[:, :3, 3] = np.linspace(poses[0, :3, 3], target, 500)
    result = follow_poses(LEFT, TIME, poses, self_collision=robot, posture=posture)
    assert result.outcome == "self_collision"
    assert result.nearest_links is not None
    names = {MODEL.link_names[i] for i in result.nearest_links}
    assert any(name.startswith("left") for name in names)
    assert any(name.startswith("right") for name in names)
    assert follow_poses(LEFT, TIME, poses).outcome == "followed"


def test_both_arms_move_at_once_apart_from_each_other() -> None:
    robot, posture = SelfCollision(MODEL), neutral_posture(MODEL)
    right = baxter_arm(MODEL, "right")
    first = follow_poses(LEFT, TIME, sweep(), self_collision=robot, posture=posture)
    rows = np.tile(posture, (500, 1))
    rows[:, [MODEL.joint_names.index(name) for name in LEFT.joint_names]] = first.trajectory.positions
    second = follow_poses(right, TIME, sweep(side=-1), self_collision=robot, posture=rows)
    assert second.outcome == "followed"
    both = np.hstack([first.trajectory.positions, second.trajectory.positions])
    time = slow_down(TIME / 10, both, np.r_[LEFT.velocity, right.velocity])
    assert np.all(np.abs(joint_velocities(time, both)) <= np.r_[LEFT.velocity, right.velocity] * (1 + 1e-9))


def test_a_given_start_is_kept() -> None:
    start = follow_poses(LEFT, TIME, sweep()).trajectory.positions[0]
    result = follow_poses(LEFT, TIME, sweep(), start)
    np.testing.assert_allclose(result.trajectory.positions[0], start, atol=1e-3)


@pytest.mark.parametrize(
    ("time", "poses", "words"),
    [
        (TIME[:1], sweep()[:1], "at least 2"),
        (TIME[::-1], sweep(), "must increase"),
        (TIME[:9], sweep(), "one for each"),
        (TIME, sweep()[:, :3], r"\(T, 4, 4\)"),
        (TIME, sweep() * np.nan, r"T_base_tool\[0\] is not finite"),
        (TIME * np.nan, sweep(), "not finite"),
    ],
)
def test_bad_trajectories_are_refused(time: NDArray[np.float64], poses: NDArray[np.float64], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        follow_poses(LEFT, time, poses)


def test_bad_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="velocity_share"):
        FollowConfig(velocity_share=1.5)
    with pytest.raises(ValueError, match="belong together"):
        follow_poses(LEFT, TIME, sweep(), posture=np.zeros(15))
    with pytest.raises(ValueError, match="15 joints"):
        follow_poses(LEFT, TIME, sweep(), self_collision=SelfCollision(MODEL), posture=np.zeros(7))
