"""URDFs good and bad: what is read, and what is refused with which words."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lfdcore.errors import DataError
from lfdcore.kinematics import InverseKinematics, RobotModel, SelfCollision, follow_poses
from robots import joint, robot, ur5_forward, ur5_urdf

GOOD = robot(joint("a", "base", "tip"), links=("base", "tip"))


def test_another_arm_moves_as_its_published_parameters_say() -> None:
    chain = RobotModel.from_urdf(ur5_urdf()).chain("l0", "tool0")
    rng = np.random.default_rng(1)
    for q in rng.uniform(-3, 3, (50, 6)):
        np.testing.assert_allclose(chain.forward(q), ur5_forward(q), atol=1e-12)


def test_another_arm_with_six_joints_is_brought_to_reachable_poses() -> None:
    solver = InverseKinematics(RobotModel.from_urdf(ur5_urdf()).chain("l0", "tool0"))
    rng = np.random.default_rng(2)
    for q in rng.uniform(-3, 3, (200, 6)):
        result = solver.solve(ur5_forward(q))
        assert result.solved
        np.testing.assert_allclose(ur5_forward(result.joints), ur5_forward(q), atol=3e-5)
        assert np.all(np.abs(result.joints) <= 3)


def test_a_sliding_and_an_endless_joint_move_as_they_should() -> None:
    xml = robot(
        joint("turn", "base", "arm", kind="continuous", limit=""),
        joint("slide", "arm", "tip", kind="prismatic", origin='xyz="1 0 0" rpy="0 1.5707963267948966 0"'),
        links=("base", "arm", "tip"),
    )
    model = RobotModel.from_urdf(xml)
    assert np.array_equal(model.limits[0, :2], [-np.inf, np.inf])
    chain = model.chain("base", "tip")
    T = chain.forward(np.array([np.pi / 2, 0.5]))
    np.testing.assert_allclose(T[:3, 3], [0, 1.5, 0], atol=1e-12)
    np.testing.assert_allclose(chain.jacobian(np.array([np.pi / 2, 0.5]))[:, 1], [0, 1, 0, 0, 0, 0], atol=1e-12)
    assert InverseKinematics(chain).solve(T).solved


@pytest.mark.parametrize("axis", ["0 0 1", "0 1 0", "0.6 0 0.8", "1 0 0", "0 0 -1"])
@pytest.mark.parametrize("rpy", [f"{np.pi - 10.0**-k!r} 0 0" for k in range(1, 10)] + ["3.14159 0 0", "0 3.1416 0"])
def test_chain_and_model_agree_to_rounding_for_any_rotation_near_half_a_turn(axis: str, rpy: str) -> None:
    xml = robot(
        joint("a", "base", "arm", origin=f'xyz="0 0 1" rpy="{rpy}"').replace('xyz="0 0 1"/>', f'xyz="{axis}"/>'),
        joint("b", "arm", "tip", origin=f'xyz="0.3 0 0" rpy="{rpy}"').replace('xyz="0 0 1"/>', f'xyz="{axis}"/>'),
        links=("base", "arm", "tip"),
    )
    model = RobotModel.from_urdf(xml)
    chain = model.chain("base", "tip")
    solver = InverseKinematics(chain)
    for q in np.random.default_rng(3).uniform(-1, 1, (20, 2)):
        T = chain.forward(q)
        np.testing.assert_allclose(T, model.forward(q, "tip"), rtol=0, atol=1e-12)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), rtol=0, atol=1e-12)
        assert solver.solve(T).solved


def test_a_joint_without_a_limit_of_speed_has_none_and_one_of_0_is_named() -> None:
    endless = robot(joint("turn", "base", "tip", kind="continuous", limit=""), links=("base", "tip"))
    model = RobotModel.from_urdf(endless)
    assert model.limits[0].tolist() == [-np.inf, np.inf, np.inf]
    still = robot(
        joint("stuck", "base", "tip", limit='<limit lower="-1" upper="1" velocity="0" effort="1"/>'),
        links=("base", "tip"),
    )
    chain = RobotModel.from_urdf(still).chain("base", "tip")
    poses = np.stack([chain.forward(np.array([q])) for q in (0.0, 0.1)])
    with pytest.raises(ValueError, match="joint 'stuck' has a velocity limit of 0"):
        follow_poses(chain, np.array([0.0, 1.0]), poses)


def test_a_chain_with_a_joint_that_follows_another_is_refused_by_name() -> None:
    xml = robot(
        joint("j5", "base", "arm"),
        joint("j5b", "arm", "tip").replace("</joint>", '<mimic joint="j5" multiplier="-1"/></joint>'),
        links=("base", "arm", "tip"),
    )
    model = RobotModel.from_urdf(xml)
    assert model.joint_names == ["j5", "j5b"]
    with pytest.raises(ValueError, match="joint 'j5b' between 'base' and 'tip' mimics 'j5'"):
        model.chain("base", "tip")
    assert model.chain("base", "arm").joint_names == ["j5"]


def test_the_tool_is_placed_in_the_frame_of_the_tip() -> None:
    model, tool = RobotModel.from_urdf(ur5_urdf()), np.eye(4)
    tool[:3, 3] = 0.1, 0.2, 0.3
    q = np.full(6, 0.4)
    np.testing.assert_allclose(model.chain("l0", "tool0", tool).forward(q), ur5_forward(q) @ tool, atol=1e-12)
    np.testing.assert_allclose(model.forward(q, "tool0"), ur5_forward(q), atol=1e-12)


ENTITIES = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
EXTERNAL = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
BAD = {
    "empty": ("", "no XML elements"),
    "no XML": ("hello", "no XML elements"),
    "zero bytes": ("<robot>\0</robot>", "zero bytes"),
    "another document": ("<svg/>", "robot"),
    "truncated between tags": (GOOD[: GOOD.index("<joint")], "truncated"),
    "truncated in a tag": (GOOD[: GOOD.index("type=") + 3], "truncated"),
    "truncated comment": ("<robot name='r'><!-- " + GOOD, "truncated"),
    "billion laughs": (ENTITIES + GOOD, "document type or entities"),
    "external entity": (EXTERNAL + GOOD.replace('"tip"', '"&x;"'), "document type or entities"),
    "too deep": ("<a>" * 10000 + "</a>" * 10000, "deeper than 64"),
    "closed before it opens": ("</>" * 40000 + "<a>" * 40000, "closes more elements than it opens"),
    "opened inside a processing instruction": ("<?x " + "<a>" * 40000 + "?>" + GOOD, "processing instruction"),
    "a hundred thousand attributes": (
        "<robot " + " ".join(f'a{i}="x"' for i in range(300_000)) + "/>",
        "64 attributes",
    ),
    "a million elements": ("<robot name='r'>" + "<a/>" * 300_000 + "</robot>", "200000 elements"),
    "too many links": (
        robot(
            *(joint(f"j{i}", f"l{i}", f"l{i + 1}", kind="fixed") for i in range(30000)),
            links=tuple(f"l{i}" for i in range(30001)),
        ),
        "2000 links",
    ),
    "too large": ("<!--" + "x" * (17 << 20) + "-->", "16 MiB"),
    "no limits": (robot(joint("a", "base", "tip", limit=""), links=("base", "tip")), "limits"),
    "limits without numbers": (
        robot(
            joint("a", "base", "tip", limit='<limit lower="x" upper="1" velocity="1" effort="1"/>'),
            links=("base", "tip"),
        ),
        "cannot be used",
    ),
    "limits upside down": (
        robot(
            joint("a", "base", "tip", limit='<limit lower="1" upper="-1" velocity="1" effort="1"/>'),
            links=("base", "tip"),
        ),
        "no range",
    ),
    "two parents": (
        robot(joint("a", "base", "tip"), joint("b", "base", "tip"), links=("base", "tip")),
        "two parents",
    ),
    "loop": (robot(joint("a", "p", "q"), joint("b", "q", "p"), links=("p", "q")), "root"),
    "loop beside the tree": (
        robot(joint("a", "base", "tip"), joint("b", "p", "q"), joint("c", "q", "p"), links=("base", "tip", "p", "q")),
        "loop",
    ),
    "joint to itself": (robot(joint("a", "base", "base"), links=("base",)), "itself|root"),
    "link without name": (robot("<link/>", joint("a", "base", "tip"), links=("base", "tip")), "name"),
    "joint to a link that is not there": (robot(joint("a", "base", "tip"), links=("base",)), "tip"),
    "no axis": (GOOD.replace('xyz="0 0 1"', 'xyz="0 0 0"'), "axis"),
    "axis not a number": (GOOD.replace('xyz="0 0 1"', 'xyz="nan 0 1"'), "cannot be used|axis"),
    "floating joint": (robot(joint("a", "base", "tip", kind="floating"), links=("base", "tip")), "floating"),
    "two roots": (robot(links=("p", "q")), "root"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_urdf_is_refused_and_the_message_says_why(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    xml, words = BAD[name]
    with pytest.raises(DataError, match=words):
        RobotModel.from_urdf(xml)
    assert capfd.readouterr().err == ""


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "missing.urdf", tmp_path):
        with pytest.raises(DataError, match="no file"):
            RobotModel.from_urdf_file(path)
    (tmp_path / "bad.urdf").write_text("<robot")
    with pytest.raises(DataError, match=r"bad\.urdf.*truncated"):
        RobotModel.from_urdf_file(tmp_path / "bad.urdf")


def test_bytes_cut_anywhere_never_crash_the_reader() -> None:
    code = (
        "from lfdcore.kinematics import RobotModel; from lfdcore.errors import DataError; import sys, random\n"
        "xml = sys.stdin.read(); rng = random.Random(1)\n"
        "for _ in range(2000):\n"
        "    a, b = sorted(rng.randrange(len(xml)) for _ in range(2))\n"
        "    put = rng.choice(['', '<', '>', '\"', '&#0;', '</link>', 'nan'])\n"
        "    try: RobotModel.from_urdf(xml[:a] + put + xml[b:][:400])\n"
        "    except DataError: pass\n"
        "    try: RobotModel.from_urdf(xml[:a] + rng.choice('<>\"/=x0-') + xml[a + 1:])\n"
        "    except DataError: pass\n"
    )
    result = subprocess.run([sys.executable, "-c", code], input=ur5_urdf(), text=True, capture_output=True, check=False)
    assert result.returncode == 0, result.stderr


def test_a_chain_of_joints_beyond_the_number_supported_is_refused_not_cut() -> None:
    count = 40
    links = tuple(f"l{i}" for i in range(count + 1))
    model = RobotModel.from_urdf(robot(*(joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(count)), links=links))
    assert len(model.joint_names) == count
    with pytest.raises(ValueError, match="at most 32"):
        model.chain("l0", "l40")


def test_names_lengths_and_poses_that_do_not_fit_are_refused() -> None:
    model = RobotModel.from_urdf(ur5_urdf())
    with pytest.raises(ValueError, match="no link 'x'"):
        model.chain("l0", "x")
    with pytest.raises(ValueError, match="at least one movable"):
        model.chain("l6", "tool0")
    with pytest.raises(ValueError, match="T_tip_tool is no rigid transform"):
        model.chain("l0", "tool0", 2 * np.eye(4))
    chain = model.chain("l0", "tool0")
    with pytest.raises(ValueError, match="q has 5 values"):
        chain.forward(np.zeros(5))
    with pytest.raises(ValueError, match="not finite"):
        chain.jacobian(np.full(6, np.nan))
    solver = InverseKinematics(chain)
    with pytest.raises(ValueError, match="T_base_tool"):
        solver.solve(np.full((4, 4), np.nan))
    with pytest.raises(ValueError, match="seed has 7"):
        solver.solve(np.eye(4), np.zeros(7))
    with pytest.raises(ValueError, match="no collision shapes"):
        SelfCollision(model)
