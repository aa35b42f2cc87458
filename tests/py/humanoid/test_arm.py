"""A gripper's motion as joints: the joints' own forward kinematics says whether it is the same motion."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from lfdcore.datasets.joint_motion import JointMotion
from lfdcore.humanoid.arm import (
    GripperMount,
    follow_gripper,
    follow_joints,
    gripper_poses,
    resting_posture,
    rotations,
    self_clearance,
)
from lfdcore.humanoid.baxter import (
    ARM_PARTS,
    Side,
    arm_capsules,
    baxter,
    baxter_arm,
    baxter_urdf,
    holding_posture,
    neutral_posture,
    robotiq_tool,
)
from lfdcore.kinematics import RobotModel, SelfCollision
from lfdcore.simulated.covering import RIGHT_GRIPPER, ROBOT_NAMES, CoveredObject, demonstrate_covering
from robots import joint, robot, ur5_forward, ur5_urdf

ROBOT = baxter()
LEFT = baxter_arm(ROBOT, "left")
CHAIR = CoveredObject("chair", 0.80, 0.44, 0.40)


@given(arrays(np.float64, (5, 4), elements=st.floats(-2, 2)))
@settings(max_examples=50)
def test_rotations_are_scipys(quaternions: np.ndarray) -> None:
    if np.linalg.norm(quaternions, axis=1).min() < 1e-3:
        return
    np.testing.assert_allclose(rotations(quaternions), Rotation.from_quat(quaternions).as_matrix(), atol=1e-12)


def test_a_quaternion_of_length_zero_or_nan_is_refused_by_its_sample() -> None:
    for bad, said in ((np.zeros(4), "sample 2 has length 0"), (np.full(4, np.nan), "sample 2 has length nan")):
        quaternions = np.tile([0, 0, 0, 1.0], (4, 1))
        quaternions[2] = bad
        with pytest.raises(ValueError, match=said):
            rotations(quaternions)


def test_columns_are_found_by_name_in_any_order() -> None:
    motion = np.random.default_rng(1).normal(size=(3, 7))
    order = [3, 6, 0, 5, 1, 4, 2]
    shuffled = gripper_poses([ROBOT_NAMES[k] for k in order], motion[:, order])
    np.testing.assert_array_equal(shuffled, gripper_poses(ROBOT_NAMES, motion))
    np.testing.assert_array_equal(shuffled[:, :3, 3], motion[:, :3])
    np.testing.assert_array_equal(shuffled[:, 3], np.tile([0, 0, 0, 1], (3, 1)))


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (ROBOT_NAMES[:3], r"motion has shape \(3, 7\)"),
        (("g.x", "g.y", "g.z", "g.u", "g.v", "g.w", "g.t"), "needs one column each of x, y, z, qx, qy, qz, qw"),
        ((*ROBOT_NAMES[:6], "right_gripper.qx"), "needs one column each"),
    ],
)
def test_columns_that_are_no_pose_are_refused(names: tuple[str, ...], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        gripper_poses(names, np.ones((3, 7)))


def test_forward_kinematics_of_the_joints_are_the_poses_inside_all_limits() -> None:
    one = demonstrate_covering(CHAIR, 100)
    posture = holding_posture(ROBOT, "right", RIGHT_GRIPPER)
    arm = follow_gripper(ROBOT, one.robot_names, one.stamp, one.robot, posture=posture)
    assert arm.followed and arm.joints is not None
    assert arm.joints.names == tuple(LEFT.joint_names)
    made = np.array([LEFT.forward(q) for q in arm.joints.positions])
    np.testing.assert_allclose(made, gripper_poses(one.robot_names, one.robot), atol=2e-4)
    assert np.all((arm.joints.positions >= LEFT.lower) & (arm.joints.positions <= LEFT.upper))
    chords = np.diff(arm.joints.positions, axis=0) / np.diff(arm.joints.time)[:, None]
    assert np.all(np.abs(chords) <= LEFT.velocity * (1 + 1e-9))
    apart, _ = self_clearance(ROBOT, arm.joints, posture)
    assert apart == pytest.approx(arm.result.clearance, abs=1e-12)
    assert apart >= 0.02


def test_a_motion_ten_times_too_fast_takes_longer_and_keeps_to_the_velocity_limits() -> None:
    one = demonstrate_covering(CHAIR, 100)
    arm = follow_gripper(ROBOT, one.robot_names, one.stamp / 20, one.robot)
    assert arm.followed and arm.joints is not None
    assert arm.result.slowdown > 1.2
    chords = np.diff(arm.joints.positions, axis=0) / np.diff(arm.joints.time)[:, None]
    assert np.all(np.abs(chords) <= LEFT.velocity * (1 + 1e-9))
    assert np.all(np.abs(arm.joints.velocities) <= LEFT.velocity * (1 + 1e-9))


def test_a_start_keeps_demonstrations_on_one_branch() -> None:
    ones = [demonstrate_covering(CHAIR, 100 + k) for k in range(3)]
    first = follow_gripper(ROBOT, ones[0].robot_names, ones[0].stamp, ones[0].robot).joints
    assert first is not None
    for one in ones:
        joints = follow_gripper(ROBOT, one.robot_names, one.stamp, one.robot, start=first.positions[0]).joints
        assert joints is not None
        assert np.abs(joints.positions[0] - first.positions[0]).max() < 0.3


def test_what_is_out_of_reach_is_said_with_its_sample_and_nothing_after_it_is_given() -> None:
    one = demonstrate_covering(CHAIR, 100)
    far = one.robot.copy()
    far[40:, 0] += 3.0
    arm = follow_gripper(ROBOT, one.robot_names, one.stamp, far)
    assert not arm.followed
    assert (arm.result.outcome, arm.result.first_failure) == ("out_of_reach", 40)
    assert arm.joints is not None and len(arm.joints.time) == 40
    far[:, 0] = 3.0
    assert follow_gripper(ROBOT, one.robot_names, one.stamp, far).joints is None


def test_the_columns_say_which_hand_it_is_and_another_must_be_named() -> None:
    one = demonstrate_covering(CHAIR, 100)
    right = [name.replace("left", "right") for name in one.robot_names]
    mirrored = one.robot * [1, -1, 1, -1, 1, -1, 1]
    arm = follow_gripper(ROBOT, right, one.stamp, mirrored)
    assert arm.joints is not None and arm.joints.names[0] == "right_s0"
    with pytest.raises(ValueError, match="which hand moves"):
        follow_gripper(ROBOT, [name.split("_")[1] for name in one.robot_names], one.stamp, one.robot)
    with pytest.raises(ValueError, match="nowhere"):
        follow_gripper(ROBOT, one.robot_names, one.stamp, one.robot, GripperMount(tip="nowhere"))
    with pytest.raises(ValueError, match="nan m, must be finite"):
        follow_gripper(ROBOT, one.robot_names, one.stamp, one.robot, GripperMount(tool=np.nan))


def test_another_robots_arm_follows_by_its_own_geometry() -> None:
    ur5 = RobotModel.from_urdf(ur5_urdf())
    begin, end = np.array([0.3, -1.2, 1.4, -0.6, 0.9, 0.2]), np.array([0.9, -1.0, 1.1, -0.4, 1.1, 0.5])
    s = np.linspace(0, 1, 60)[:, None]
    poses = np.array([ur5_forward(q) @ robotiq_tool() for q in begin + s * s * (3 - 2 * s) * (end - begin)])
    columns = np.hstack([poses[:, :3, 3], Rotation.from_matrix(poses[:, :3, :3]).as_quat()])
    names = [f"tool.{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    arm = follow_gripper(ur5, names, np.linspace(0, 3, 60), columns, GripperMount("l0", "tool0"))
    assert arm.followed and arm.joints is not None
    made = np.array([ur5_forward(q) @ robotiq_tool() for q in arm.joints.positions])
    np.testing.assert_allclose(made, poses, atol=2e-4)
    assert self_clearance(ur5, arm.joints) == (np.inf, 0)


def test_learned_joints_are_slowed_down_where_they_are_too_fast_and_otherwise_kept() -> None:
    names = LEFT.joint_names
    middle = (LEFT.lower + LEFT.upper) / 2
    motion = middle + 0.4 * np.sin(np.linspace(0, np.pi, 50))[:, None]
    slow = follow_joints(ROBOT, names, np.linspace(5, 15, 50), motion)
    np.testing.assert_allclose(slow.time, np.linspace(0, 10, 50), atol=1e-9)
    np.testing.assert_array_equal(slow.positions, motion)
    fast = follow_joints(ROBOT, names, np.linspace(0, 0.1, 50), motion)
    np.testing.assert_array_equal(fast.positions, motion)
    assert fast.duration > 0.2
    assert np.all(np.abs(fast.velocities) <= LEFT.velocity * (1 + 1e-9))


def test_learned_joints_outside_the_limits_are_refused_with_joint_value_and_bounds() -> None:
    names, time = LEFT.joint_names, np.linspace(0, 1, 4)
    motion = np.tile((LEFT.lower + LEFT.upper) / 2, (4, 1))
    motion[2, 3] = 9.0
    with pytest.raises(ValueError, match=r"left_e1 is to go to 9\.000 at sample 2, must be in \[-0\.05, 2\.618\]"):
        follow_joints(ROBOT, names, time, motion)
    motion[2, 3] = np.nan
    with pytest.raises(ValueError, match="must be finite"):
        follow_joints(ROBOT, names, time, motion)
    with pytest.raises(ValueError, match="elbow is none of the robot's joints"):
        follow_joints(ROBOT, ["elbow"], time, motion[:, :1])
    with pytest.raises(ValueError, match=r"motion has shape \(4, 7\), must be \(T, 2\)"):
        follow_joints(ROBOT, names[:2], time, motion)


def test_robots_rest_at_baxters_neutral_posture_or_mid_range() -> None:
    np.testing.assert_array_equal(resting_posture(ROBOT), neutral_posture(ROBOT))
    limit = '<limit lower="-1" upper="2" velocity="1" effort="1"/>'
    endless = '<limit velocity="1" effort="1"/>'
    xml = robot(
        joint("a", "l0", "l1", limit=limit),
        joint("b", "l1", "l2", kind="continuous", limit=endless),
        links=("l0", "l1", "l2"),
    )
    np.testing.assert_array_equal(resting_posture(RobotModel.from_urdf(xml)), [0.5, 0.0])


def test_self_clearance_is_the_smallest_of_all_samples() -> None:
    posture = neutral_posture(ROBOT)
    middle = np.array([posture[ROBOT.joint_names.index(name)] for name in LEFT.joint_names])
    positions = np.linspace(middle, middle + 1.2 * np.eye(7)[0], 9)
    motion = JointMotion(tuple(LEFT.joint_names), np.arange(9.0), positions, np.zeros_like(positions))
    slow, surroundings = [], SelfCollision(ROBOT)
    for q in positions:
        posture[[ROBOT.joint_names.index(name) for name in LEFT.joint_names]] = q
        slow.append(surroundings.distance(posture))
    assert self_clearance(ROBOT, motion) == (min(slow), int(np.argmin(slow)))


# -- the arm that holds ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("side", "y"), [("right", -0.32), ("left", 0.32)])
def test_the_holding_arm_is_at_its_place_and_touches_nothing(side, y) -> None:
    q = holding_posture(ROBOT, side, (0.72, y, 0.32))
    chain = baxter_arm(ROBOT, side)
    columns = [ROBOT.joint_names.index(name) for name in chain.joint_names]
    tool = chain.forward(q[columns])
    np.testing.assert_allclose(tool[:3, 3], [0.72, y, 0.32], atol=1e-4)
    assert tool[0, 2] > 0.9 and -0.5 < tool[2, 2] < 0  # forward, and a little down
    assert SelfCollision(ROBOT).distance(q) >= 0.05
    others = [k for k in range(len(q)) if k not in columns]
    np.testing.assert_array_equal(q[others], neutral_posture(ROBOT)[others])
    np.testing.assert_array_equal(q, holding_posture(ROBOT, side, (0.72, y, 0.32)))


def test_a_place_that_cannot_be_held_is_refused() -> None:
    with pytest.raises(ValueError, match="right gripper cannot hold at"):
        holding_posture(ROBOT, "right", (3.0, 0.0, 0.0))


def test_the_arm_is_a_chain_of_capsules_from_shoulder_to_gripper() -> None:
    positions = np.random.default_rng(2).uniform(LEFT.lower, LEFT.upper, (20, 7))
    upper, fore, hand = arm_capsules(ROBOT, "left", positions)
    assert len(ARM_PARTS) == 3
    np.testing.assert_array_equal(upper.end, fore.begin)
    np.testing.assert_array_equal(fore.end, hand.begin)
    for part in (upper, fore, hand):  # links are rigid
        assert np.ptp(np.linalg.norm(part.end - part.begin, axis=1)) < 1e-9
    tool = np.array([LEFT.forward(q) for q in positions])
    np.testing.assert_allclose(hand.end, tool[:, :3, 3] - 0.08 * tool[:, :3, 2], atol=1e-9)
    q = neutral_posture(ROBOT)
    np.testing.assert_allclose(upper.begin[0, 2] - ROBOT.forward(q, "left_upper_shoulder")[2, 3], 0.27, atol=0.02)


@pytest.mark.parametrize("side", ["left", "right"])
def test_each_part_is_as_thick_as_the_thickest_of_its_links_in_the_urdf(side: Side) -> None:
    parts = {
        "upper arm": {"lower_shoulder", "upper_elbow"},
        "forearm": {"lower_elbow", "upper_forearm", "lower_forearm"},
        "hand": {"wrist", "gripper_base_link"},
    }
    shapes = [
        (link.get("name", ""), float(shape.attrib["radius"]))
        for link in ElementTree.parse(baxter_urdf()).iter("link")
        for shape in (*link.iter("cylinder"), *link.iter("sphere"))
    ]
    capsules = arm_capsules(ROBOT, side, np.zeros((1, 7)))
    for part, capsule in zip(ARM_PARTS, capsules, strict=True):
        assert capsule.radius == max(radius for name, radius in shapes if name.removeprefix(f"{side}_") in parts[part])


def test_a_thicker_forearm_in_the_urdf_makes_a_thicker_capsule() -> None:
    text = baxter_urdf().read_text()
    thicker = RobotModel.from_urdf(text.replace('radius="0.055"', 'radius="0.075"'))
    assert [c.radius for c in arm_capsules(thicker, "left", np.zeros((1, 7)))] == [0.06, 0.075, 0.045]
    bare = RobotModel.from_urdf(re.sub(r"<collision>.*?</collision>", "", text, flags=re.DOTALL))
    with pytest.raises(ValueError, match="the robot's left upper arm has no collision shapes"):
        arm_capsules(bare, "left", np.zeros((1, 7)))
