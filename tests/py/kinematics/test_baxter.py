"""urdf/baxter.urdf is the robot that Rethink published."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfdcore.humanoid.baxter import baxter, baxter_arm, baxter_urdf, neutral_posture, robotiq_tool
from lfdcore.kinematics import InverseKinematics, InverseKinematicsConfig, SelfCollision

GOLDEN = json.loads(Path(__file__).with_name("baxter_golden.json").read_text())


def test_the_frames_are_those_of_the_published_description() -> None:
    model = baxter()
    assert model.joint_names == GOLDEN["joint_names"]
    for pose in GOLDEN["poses"]:
        for link, rows in pose["links"].items():
            found = model.forward(np.array(pose["joints"]), link)
            np.testing.assert_allclose(found[:3], rows, atol=1e-9, err_msg=link)


def test_the_limits_are_those_published() -> None:
    arm = baxter().chain("base", "left_gripper")
    np.testing.assert_allclose(arm.lower, [-1.70168, -2.147, -3.05418, -0.05, -3.059, -1.5708, -3.059], atol=1e-5)
    np.testing.assert_allclose(arm.upper, [1.70168, 1.047, 3.05418, 2.618, 3.059, 2.094, 3.059], atol=1e-5)
    np.testing.assert_allclose(arm.velocity, [1.5] * 4 + [4.0] * 3)


def test_collision_shapes_are_those_of_the_urdf_a_cylinder_by_the_ends_of_its_axis() -> None:
    shapes = {link: (begin, end, radius) for link, begin, end, radius in baxter().collision_shapes}
    for link, begin, end, radius in (
        ("head", (-0.02, 0, 0.06), (-0.02, 0, 0.06), 0.2),
        ("left_lower_elbow", (-0.005, 0, 0), (0.065, 0, 0), 0.06),
        ("right_gripper_base_link", (0, 0, 0), (0, 0, 0.08), 0.045),
    ):
        found = shapes[link]
        np.testing.assert_allclose(found[0], begin, atol=1e-9)
        np.testing.assert_allclose(found[1], end, atol=1e-9)
        assert found[2] == radius
    assert len(baxter().collision_shapes) == baxter_urdf().read_text().count("<collision>")


def published() -> tuple[Any, Path]:
    """pinocchio and example-robot-data's Baxter."""
    pin = pytest.importorskip("pinocchio", reason="needs the packages pin and example-robot-data")
    prefix = next((p for p in Path(pin.__file__).parents if p.name == "cmeel.prefix"), Path())
    urdf = prefix / "share/example-robot-data/robots/baxter_description/urdf/baxter.urdf"
    if not urdf.exists():
        pytest.skip("needs the package example-robot-data")
    return pin, urdf


def frames(pin: Any, urdf: Path, names: list[str], q: np.ndarray[Any, Any]) -> tuple[dict[str, Any], Any, Any, Any]:
    model = pin.buildModelFromUrdf(str(urdf))
    data, posture = model.createData(), pin.neutral(model)
    for name, value in zip(names, q, strict=True):
        posture[model.joints[model.getJointId(name)].idx_q] = value
    pin.framesForwardKinematics(model, data, posture)
    bodies = {f.name: data.oMf[i].homogeneous for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
    return bodies, model, data, posture


def test_forward_kinematics_and_jacobian_equal_pinocchios() -> None:
    pin, _ = published()
    model, rng = baxter(), np.random.default_rng(1)
    chain = model.chain("base", "left_gripper")
    columns = [model.joint_names.index(name) for name in chain.joint_names]
    for q in rng.uniform(model.limits[:, 0], model.limits[:, 1], (20, 15)):
        theirs, pin_model, data, posture = frames(pin, baxter_urdf(), model.joint_names, q)
        for link in model.link_names:
            np.testing.assert_allclose(model.forward(q, link), theirs[link], atol=1e-9)
        frame = pin_model.getFrameId("left_gripper")
        J = pin.computeFrameJacobian(pin_model, data, posture, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        theirs_columns = [pin_model.joints[pin_model.getJointId(name)].idx_v for name in chain.joint_names]
        np.testing.assert_allclose(chain.jacobian(q[columns]), J[:, theirs_columns], atol=1e-9)


def test_all_shared_frames_equal_example_robot_datas() -> None:
    pin, urdf = published()
    model, rng = baxter(), np.random.default_rng(2)
    for q in rng.uniform(model.limits[:, 0], model.limits[:, 1], (20, 15)):
        theirs = frames(pin, urdf, model.joint_names, q)[0]
        shared = set(theirs) & set(model.link_names)
        assert len(shared) == len(model.link_names)
        for link in shared:
            np.testing.assert_allclose(model.forward(q, link), theirs[link], atol=1e-6, err_msg=link)


def test_the_grippers_length_is_a_parameter() -> None:
    model, q = baxter(), np.full(7, 0.2)
    plate = model.chain("base", "right_hand_link").forward(q)
    tool = baxter_arm(model, "right", robotiq_tool(0.2)).forward(q)
    np.testing.assert_allclose(tool[:3, 3], plate[:3, 3] + 0.2 * plate[:3, 2], atol=1e-12)
    with pytest.raises(ValueError, match="length"):
        robotiq_tool(float("nan"))


def test_the_neutral_posture_is_free_and_inside_the_limits() -> None:
    model = baxter()
    q = neutral_posture(model)
    assert np.all((q >= model.limits[:, 0]) & (q <= model.limits[:, 1]))
    assert SelfCollision(model).distance(q) > 0.05


def test_inverse_kinematics_from_the_last_joints_stays_beside_them() -> None:
    chain = baxter().chain("base", "left_gripper")
    solver = InverseKinematics(chain, config=InverseKinematicsConfig(restarts=0))
    q = np.array([-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5])
    wanted = chain.forward(q)
    wanted[:3, 3] += 0.005
    result = solver.solve(wanted, q)
    assert result.solved
    assert result.restarts == 0
    assert np.abs(result.joints - q).max() < 0.05
