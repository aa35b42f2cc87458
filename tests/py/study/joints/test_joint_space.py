"""A small study of joint-space primitives: what is judged is what the joints do, by independent geometry."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lfdcore.datasets.joint_motion import JointMotion
from lfdcore.humanoid.baxter import ARM_PARTS
from lfdcore.humanoid.contact import CLEARANCE, Capsule
from lfdcore.humanoid.scene import box_of
from lfdcore.kinematics import SelfCollision
from lfdcore.pictures.style import png
from lfdcore.simulated.covering import BOUNDING_BOX, RIGHT_GRIPPER, covering_data
from lfdcore.study.joints.pictures import joint_space_figure
from lfdcore.study.joints.report import (
    QUANTITIES,
    better_at,
    comparison_table,
    few_table,
    findings,
    joint_space_headline,
    joint_space_tables,
    nearest_table,
)
from lfdcore.study.joints.study import (
    FOLLOWED,
    GRIPPER,
    JOINTS,
    OUTSIDE,
    SPACES,
    ArmSetting,
    ArmTrial,
    JointSpaceResult,
    JointSpaceStudy,
    _judged,
    rotation_angles,
    run_joint_space_study,
)
from lfdcore.study.study import write_study
from lfdcore.training.collaborations import NoiseChoice

PROTOCOL = dataclasses.replace(BOUNDING_BOX, demonstrations=3, novel=BOUNDING_BOX.novel[-1:])
CHOICE = NoiseChoice(factors=(1.0, 100.0), folds=2, shares=(0.1,))
STUDY = JointSpaceStudy(protocol=PROTOCOL, seeds=2, seed=100, held_out=1, few=2, choice=CHOICE, processes=1)


@pytest.fixture(scope="module")
def result() -> JointSpaceResult:
    return run_joint_space_study(STUDY)


@pytest.fixture(scope="module")
def setting() -> ArmSetting:
    return ArmSetting.of(covering_data(PROTOCOL, 100, held_out=1))


def test_both_spaces_are_judged_on_the_same_people(result: JointSpaceResult) -> None:
    assert [run.seed for run in result.runs] == [100, 101]
    who = {
        space: [(one.seed, one.covered_object, one.person) for one in result.trials if one.space == space]
        for space in SPACES
    }
    assert who[JOINTS] == who[GRIPPER]
    assert len(who[JOINTS]) == 2 * 5
    assert sum(one.novel for one in result.trials) == 2 * 2
    assert all(run.demonstrations + run.left_out == 12 for run in result.runs)


def test_both_spaces_infer_about_the_same_motion(result: JointSpaceResult) -> None:
    for one in result.trials:
        assert one.position_error < 0.1
        assert one.rotation_error < 0.15
    assert np.corrcoef(*([one.position_error for one in result.trials if one.space == s] for s in SPACES))[0, 1] > 0.5


def test_what_is_sent_is_inside_all_limits_and_clear_of_the_robot(result: JointSpaceResult) -> None:
    for one in result.trials:
        assert one.outcome == FOLLOWED
        assert one.margin >= 0
        assert one.speed <= 1 + 1e-9
        assert one.clearance >= 0.02
        assert one.covered == (one.covered_by_mouth and min(one.arm) >= CLEARANCE)


def test_the_same_seed_gives_the_same_figures_and_another_others(result: JointSpaceResult) -> None:
    again = run_joint_space_study(dataclasses.replace(STUDY, seeds=1))
    assert [one.row() for one in again.trials] == [one.row() for one in result.runs[0].trials]
    assert result.runs[0].trials[0].position_error != result.runs[1].trials[0].position_error


def test_joint_columns_are_the_demonstrated_motion(setting: ArmSetting) -> None:
    one = covering_data(PROTOCOL, 100, held_out=1).training[5]
    made = setting.in_joints(one)
    assert made is not None
    assert made.robot_names == tuple(setting.chain.joint_names)
    np.testing.assert_array_equal(made.partner, one.partner)
    np.testing.assert_allclose(setting.poses(made.robot)[:, :3, 3], one.robot[:, :3], atol=2e-4)
    far = dataclasses.replace(one, robot=one.robot + 3 * np.eye(7)[0])
    assert setting.in_joints(far) is None
    hasty = dataclasses.replace(one, stamp=one.stamp / 30)
    assert setting.in_joints(hasty) is None


def test_joints_outside_their_limits_or_in_the_body_are_not_sent(setting: ArmSetting) -> None:
    time, motion = np.linspace(0, 5, 20), np.tile(setting.start, (20, 1))
    motion[10, 5] = setting.chain.upper[5] + 0.1
    joints, outcome, _ = setting.sent(JOINTS, time, motion)
    assert (joints, outcome) == (None, OUTSIDE)
    assert setting.beyond(motion) == pytest.approx(0.1)
    judged = _judged(setting, None, covering_data(PROTOCOL, 100).protocol.novel[0].box())
    assert not judged["covered"]
    assert np.isnan(judged["mouth"])
    folded = np.tile([0.9, 0.9, 0, 2.5, 0, 0, 0], (20, 1))
    joints, outcome, _ = setting.sent(JOINTS, time, folded)
    assert outcome == FOLLOWED
    q = setting.posture.copy()
    q[[setting.robot.joint_names.index(name) for name in setting.chain.joint_names]] = folded[0]
    assert SelfCollision(setting.robot).distance(q) < 0.02
    assert setting.checked(JOINTS, joints, outcome) == (None, "self_collision")


def test_an_arm_in_the_object_does_not_cover_it_though_the_mouth_does(
    setting: ArmSetting, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = covering_data(PROTOCOL, 100, held_out=1).training[0]
    followed = setting.in_joints(one)
    assert followed is not None
    joints = JointMotion(followed.robot_names, followed.stamp, followed.robot, np.zeros_like(followed.robot))
    assert _judged(setting, joints, box_of(one))["covered"]
    middle = np.tile(box_of(one).centre, (len(joints.time), 1))
    monkeypatch.setattr("lfdcore.study.joints.study.arm_capsules", lambda *given: [Capsule(middle, middle, 0.05)])
    judged = _judged(setting, joints, box_of(one))
    assert judged["covered_by_mouth"]
    assert not judged["covered"]


def test_joints_that_are_too_fast_take_longer(setting: ArmSetting) -> None:
    motion = setting.start + 0.3 * np.linspace(0, 1, 30)[:, None]
    assert setting.sent(JOINTS, np.linspace(0, 10, 30), motion)[2] == pytest.approx(1)
    joints, _, slowdown = setting.sent(JOINTS, np.linspace(0, 0.05, 30), motion)
    assert joints is not None
    assert slowdown > 2
    assert np.all(np.abs(joints.velocities) <= setting.chain.velocity * (1 + 1e-9))


def test_angles_between_orientations_are_scipys() -> None:
    a, b = (Rotation.random(30, random_state=k) for k in (1, 2))
    poses = np.tile(np.eye(4), (2, 30, 1, 1))
    poses[0, :, :3, :3], poses[1, :, :3, :3] = a.as_matrix(), b.as_matrix()
    np.testing.assert_allclose(rotation_angles(*poses), (a.inv() * b).magnitude(), atol=1e-7)


def test_bounds_of_the_study_are_kept() -> None:
    for bad in ({"seeds": 0}, {"seed": -1}, {"held_out": 0}, {"few": 0}):
        with pytest.raises(ValueError, match="must be at least"):
            JointSpaceStudy(**bad)


# -- the report --------------------------------------------------------------------------------------------------------


def changed(result: JointSpaceResult, space: str, **values: object) -> JointSpaceResult:
    def change(one: ArmTrial) -> ArmTrial:
        return dataclasses.replace(one, **values) if one.space == space else one

    runs = [dataclasses.replace(run, trials=tuple(map(change, run.trials))) for run in result.runs]
    return JointSpaceResult(result.study, tuple(runs), result.few)


def test_who_is_better_is_said_only_where_it_shows_over_seeds(result: JointSpaceResult) -> None:
    many = JointSpaceResult(result.study, result.runs * 4, result.few)  # 8 seeds
    for space in SPACES:
        worse = changed(many, space, position_error=0.5, covered=False, covered_by_mouth=False)
        other = GRIPPER if space == JOINTS else JOINTS
        assert "gripper off, RMS (novel objects)" in better_at(worse)[other]
        assert "covered, no contact (known objects)" in better_at(worse)[other]
        assert "gripper off, RMS (novel objects)" not in better_at(worse)[space]
    assert better_at(result) == {JOINTS: [], GRIPPER: []}  # two seeds show nothing


def test_what_cannot_be_sent_is_counted_by_its_reason(result: JointSpaceResult) -> None:
    lost = changed(result, JOINTS, outcome=OUTSIDE, beyond=np.radians(5), covered=False)
    rows = few_table(lost).rows
    assert [row[0] for row in rows] == [f"{n} of each object, {space}" for n in (3, 2) for space in SPACES]
    assert rows[0][3:] == ("0.0+-0.0", "100.0+-0.0", "10 outside limits", "5.0 degrees")
    assert rows[1][4:] == ("0.0+-0.0", "-", "0.0 degrees")
    assert all(run.demonstrations + run.left_out == 8 for run in result.few)


def test_what_comes_nearest_is_counted(result: JointSpaceResult) -> None:
    arm_first = changed(result, JOINTS, mouth=0.5, arm=(0.4, 0.3, 0.1))
    row = nearest_table(arm_first).rows[0]
    assert row == ("known objects, joint space", "8", "0 %\n500", "0 %\n400", "0 %\n300", "100 %\n100")
    nothing = changed(result, JOINTS, outcome=OUTSIDE, mouth=np.nan, arm=(np.nan,) * 3)
    assert nearest_table(nothing).rows[0][1] == "0"


def test_a_table_has_a_row_a_quantity_with_n_and_seeds(result: JointSpaceResult) -> None:
    table = comparison_table(result, "novel objects")
    assert len(table.rows) == len(QUANTITIES)
    assert table.title == "Novel objects: 2 people and objects, means of 2 seeds (100 to 101)"
    chosen = [one for one in result.trials if one.novel and one.space == JOINTS]
    assert float(table.rows[0][1].split("+-")[0]) == pytest.approx(
        1e3 * np.mean([one.position_error for one in chosen]), abs=0.06
    )
    assert all(table.as_text() for table in joint_space_tables(result))


def test_the_picture_shows_seven_joints_and_two_views_and_is_the_same_twice(result: JointSpaceResult) -> None:
    run = result.runs[0]
    figure = joint_space_figure(run)
    titles = [axes.get_title() for axes in figure.axes]
    assert titles[:7] == [f"left_{name}" for name in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")]
    assert len(titles) == 9
    grippers = [line.get_xydata() for line in figure.axes[7].lines]
    assert any(np.allclose(data, [RIGHT_GRIPPER[1:]]) for data in grippers if len(data) == 1)
    assert png(figure) == png(joint_space_figure(run))


def test_the_report_holds_the_headline_and_all_figures(result: JointSpaceResult, tmp_path: Path) -> None:
    report = write_study(STUDY, findings(result), tmp_path)
    assert joint_space_headline(result).split(". ")[0].split(",")[0] in report.read_text()
    rows = json.loads((tmp_path / "figures.json").read_text())["rows"]
    assert len(rows) == 2 * len(result.trials)
    assert {row["demonstrations"] for row in rows} == {2, 3}
    assert set(ARM_PARTS) < set(rows[0])
    assert "seconds" not in rows[0]
    lost = changed(result, JOINTS, outcome=OUTSIDE, mouth=np.nan, arm=(np.nan,) * 3)
    write_study(STUDY, findings(lost), tmp_path)
    assert json.loads((tmp_path / "figures.json").read_text())["rows"][0]["hand"] is None
    before = report.read_bytes()
    assert write_study(STUDY, findings(lost), tmp_path).read_bytes() == before
