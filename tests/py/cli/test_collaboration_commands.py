"""lfdcore learn collaboration and collaborate, as a user calls them; the robot is stopped by Ctrl-C."""

import dataclasses
import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from PIL import Image
from scipy.spatial.transform import Rotation

from calling import run
from lfdcore.datasets.interaction import InteractionRecording, load_interaction
from lfdcore.datasets.joint_motion import read_joint_motion
from lfdcore.humanoid.arm import follow_gripper
from lfdcore.humanoid.baxter import baxter, baxter_arm
from lfdcore.humanoid.collaboration import CollaborationModel
from lfdcore.simulated.covering import CoveredObject, demonstrate_covering
from robots import joint, robot, ur5_forward, ur5_urdf

OBJECTS = (CoveredObject("stool", 0.75, 0.34, 0.34), CoveredObject("cabinet", 0.90, 0.40, 0.38))
SCENE = {"object.height": 0.82, "object.width": 0.4}
ROBOT = baxter()
LEFT = baxter_arm(ROBOT, "left")


def demonstrations() -> list[InteractionRecording]:
    names = ("object.height", "object.width")
    return [demonstrate_covering(one, [200, k, i], None, names) for k, one in enumerate(OBJECTS) for i in range(3)]


def with_joints(one: InteractionRecording, start: np.ndarray | None) -> InteractionRecording:
    joints = follow_gripper(ROBOT, one.robot_names, one.stamp, one.robot, start=start).joints
    assert joints is not None
    return dataclasses.replace(one, robot=joints.positions, robot_names=joints.names)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Demonstrations, models of gripper and of joints, a new person, a scene."""
    folder, ones = tmp_path_factory.mktemp("collaboration"), demonstrations()
    for k, one in enumerate(ones):
        one.save(folder / f"demo{k}.npz")
    model = CollaborationModel.fit(ones)
    model.save(folder / "model.safetensors")
    first = with_joints(ones[0], None)
    in_joints = [first, *(with_joints(one, first.robot[0]) for one in ones[1:])]
    CollaborationModel.fit(in_joints).save(folder / "joints.safetensors")
    shifted = [dataclasses.replace(one, robot=one.robot + np.eye(7)[0] * 3) for one in ones]
    CollaborationModel.fit(shifted).save(folder / "far.safetensors")
    places = [dataclasses.replace(one, robot=one.robot[:, :3], robot_names=one.robot_names[:3]) for one in ones]
    CollaborationModel.fit(places).save(folder / "places.safetensors")
    (folder / "e.json").write_text(json.dumps(SCENE))
    demonstrate_covering(CoveredObject("chair", 0.82, 0.4, 0.4), 300, None, tuple(SCENE)).save(folder / "person.npz")
    return folder


def words(folder: Path, *more: object, model: str = "model") -> list[object]:
    return ["collaborate", folder / f"{model}.safetensors", "--observe", folder / "person.npz", "--until", "1", *more]


def failure(err: str) -> str:
    """The single line that a failure is reported in."""
    (line,) = [line for line in err.splitlines() if line.startswith("lfdcore: ")]
    assert "Traceback" not in err
    return line


# -- learn ------------------------------------------------------------------------------------------------------------


def test_learn_writes_the_same_model_twice_and_says_what_it_learned(folder, monkeypatch, capsys, tmp_path) -> None:
    demos = [folder / f"demo{k}.npz" for k in range(6)]
    for name in ("a", "b"):
        model = tmp_path / f"{name}.safetensors"
        code, out, err = run(monkeypatch, capsys, "learn", "collaboration", *demos, "-o", model, "--json")
        assert code == 0, err
        facts = json.loads(out)
        assert (facts["demonstrations"], facts["environment"]) == (
            6,
            "object.height 0.75 to 0.9, object.width 0.34 to 0.4",
        )
        assert "noise" in err
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    plain = tmp_path / "plain.safetensors"
    code, out, _ = run(monkeypatch, capsys, "learn", "collaboration", *demos, "-o", plain, "--plain")
    assert code == 0
    assert "plain interaction primitive" in out
    assert CollaborationModel.load(plain).environment_names == ()
    thesis = tmp_path / "thesis.safetensors"
    assert run(monkeypatch, capsys, "learn", "collaboration", *demos, "-o", thesis, "--preset", "thesis")[0] == 0
    assert CollaborationModel.load(thesis).config.observe == "forcing"


def test_learn_refuses_what_cannot_be_learned_from(folder, monkeypatch, capsys, tmp_path) -> None:
    one, model = folder / "demo0.npz", tmp_path / "m.safetensors"
    damaged, other, alone = tmp_path / "damaged.npz", tmp_path / "other.npz", tmp_path / "alone.npz"
    damaged.write_bytes(one.read_bytes()[:900])
    recording = load_interaction(one)
    dataclasses.replace(recording, robot_names=tuple(f"r{k}" for k in range(7))).save(other)
    recording.first(50).save(alone)
    for files, code, said in (
        ([one], 1, "there must be 2 demonstrations or more, got 1"),
        ([one, one], 2, "is given twice"),
        ([one, damaged], 1, "damaged.npz"),
        ([one, other], 1, "has the robot_names r0"),
        ([one, alone], 1, "has no robot's motion"),
        ([one, tmp_path / "none.npz"], 1, "none.npz: No such file"),
    ):
        got, _, err = run(monkeypatch, capsys, "learn", "collaboration", *files, "-o", model)
        assert got == code, err
        assert said in err
        assert not model.exists()


# -- collaborate -------------------------------------------------------------------------------------------------------


def test_the_written_motion_is_inside_all_limits_and_is_the_inferred_one(folder, monkeypatch, capsys, tmp_path) -> None:
    for name in ("a.mcap", "b.mcap", "a.csv", "b.csv"):
        code, out, err = run(
            monkeypatch, capsys, *words(folder, "--environment", folder / "e.json"), "-o", tmp_path / name
        )
        assert code == 0, err
        assert "followed inside all limits" in out
        assert "samples of 7 joints" in out
    for suffix in ("mcap", "csv"):
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    motion = read_joint_motion(tmp_path / "a.mcap")
    assert motion.names == tuple(LEFT.joint_names)
    assert np.all((motion.positions >= LEFT.lower) & (motion.positions <= LEFT.upper))
    chords = np.diff(motion.positions, axis=0) / np.diff(motion.time)[:, None]
    assert np.all(np.abs(chords) <= LEFT.velocity * (1 + 1e-6))
    assert np.all(np.abs(motion.velocities) <= LEFT.velocity * (1 + 1e-9))
    model = CollaborationModel.load(folder / "model.safetensors")
    inference = model.infer(load_interaction(folder / "person.npz").partial(seconds=1), SCENE)
    _, wanted = inference.motion_from_now(0.02)
    made = np.array([LEFT.forward(q) for q in motion.positions])
    np.testing.assert_allclose(made[:, :3, 3], wanted[:, :3], atol=2e-4)
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table[:, 1:8], motion.positions)


def test_json_holds_facts_and_the_motion_and_the_picture_shows_both(folder, monkeypatch, capsys, tmp_path) -> None:
    picture = tmp_path / "p.png"
    code, out, err = run(monkeypatch, capsys, *words(folder, "--json", "--picture", picture, "--until", "4"))
    assert code == 0, err
    facts = json.loads(out)
    assert len(facts["motion"]) == 9
    assert set(facts["motion"][0]) == {"time", *CollaborationModel.load(folder / "model.safetensors").robot.names}
    assert 0.2 < facts["share"] < 0.6
    assert "object.height 0.82" in facts["environment"]
    pixels = np.asarray(Image.open(picture).convert("RGB"), float)
    assert pixels.std() > 10


def test_the_scene_changes_the_motion_and_the_observation_the_duration(folder, monkeypatch, capsys, tmp_path) -> None:
    tall = tmp_path / "tall.json"
    tall.write_text(json.dumps({**SCENE, "object.height": 0.95}))
    motions = []
    for scene in (folder / "e.json", tall):
        _, out, _ = run(monkeypatch, capsys, *words(folder, "--json", "--environment", scene))
        motions.append([row["left_gripper.z"] for row in json.loads(out)["motion"]])
    assert max(motions[1]) > max(motions[0]) + 0.05


def test_until_0_heeds_the_first_sample_alone(folder, monkeypatch, capsys) -> None:
    code, out, err = run(monkeypatch, capsys, *words(folder)[:-1], "0")
    assert code == 0, err
    assert "0.00 s of the partner, 1 samples" in out
    assert "not distinguishable from the start yet" in out


def test_joints_that_were_learned_are_sent_as_they_are(folder, monkeypatch, capsys, tmp_path) -> None:
    path = tmp_path / "j.mcap"
    code, out, err = run(monkeypatch, capsys, *words(folder, "-o", path, model="joints"))
    assert code == 0, err
    assert "joints were learned: 1.00 times as long inside all limits; links keep" in out
    made = [LEFT.forward(q)[:3, 3] for q in read_joint_motion(path).positions]
    inference = CollaborationModel.load(folder / "model.safetensors").infer(
        load_interaction(folder / "person.npz").partial(seconds=1), SCENE
    )
    _, wanted = inference.motion_from_now(0.02)
    assert np.linalg.norm(made[-1] - wanted[-1, :3]) < 0.03  # the two spaces agree on where it ends


def test_learned_joints_that_bring_links_together_are_not_sent(folder, monkeypatch, capsys, tmp_path) -> None:
    ones = [load_interaction(folder / f"demo{k}.npz") for k in (0, 3)]
    crossed = np.array([0.9, 0.9, 0, 2.5, 0, 0, 0])  # the forearm folded back into the body
    names = tuple(LEFT.joint_names)
    bad = []
    for k, one in enumerate(ones):
        s = np.linspace(0, 1, len(one))[:, None]
        positions = (1 - s) * (0.1 + 0.01 * k) + s * (crossed + 0.01 * k)
        bad.append(dataclasses.replace(one, robot=positions, robot_names=names))
    model = CollaborationModel.fit(bad)
    model.save(tmp_path / "bad.safetensors")
    for place in ("person.npz", "e.json"):
        (tmp_path / place).write_bytes((folder / place).read_bytes())
    code, _, err = run(monkeypatch, capsys, *words(tmp_path, "-o", tmp_path / "m.csv", model="bad"))
    assert code == 1
    assert "self collision" in failure(err)
    assert not (tmp_path / "m.csv").exists()


def test_an_unreachable_motion_is_reported_in_one_line_and_nothing_is_written(
    folder, monkeypatch, capsys, tmp_path
) -> None:
    there = tmp_path / "m.csv"
    there.write_text("mine")
    for flags in ((), ("--json",), ("--execute",)):
        code, out, err = run(monkeypatch, capsys, *words(folder, *flags, "-o", there, model="far"))
        assert code == 1
        assert failure(err).startswith("lfdcore: the arm cannot follow from sample 0 on: out of reach")
        assert failure(err).endswith("Nothing was written or executed")
        assert "3.7" in out  # the inferred motion is printed all the same
    assert there.read_text() == "mine"
    assert json.loads(run(monkeypatch, capsys, *words(folder, "--json", model="far"))[1])["motion"]


@pytest.fixture(scope="module")
def bad(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What cannot be used."""
    bad = tmp_path_factory.mktemp("bad")
    (bad / "lacking.json").write_text('{"object.height": 0.8}')
    (bad / "nan.json").write_text('{"object.height": NaN, "object.width": 0.4}')
    (bad / "empty.urdf").write_text("")
    unlimited = joint("a", "base", "l1", limit="<!-- none -->")
    (bad / "unlimited.urdf").write_text(robot(unlimited, links=("base", "l1")))
    (bad / "folder.csv").mkdir()
    (bad / "model.safetensors").write_bytes((folder / "model.safetensors").read_bytes()[:2000])
    person = load_interaction(folder / "person.npz")
    other = dataclasses.replace(person, partner_names=tuple(f"knee.{k}" for k in range(6)))
    other.save(bad / "other.npz")
    dataclasses.replace(person, partner=np.full_like(person.partner, np.nan)).save(bad / "unseen.npz")
    dataclasses.replace(person, environment={}).save(bad / "nowhere.npz")
    return bad


@pytest.mark.parametrize(
    ("flags", "code", "said"),
    [
        (["--tool", "nan"], 2, "--tool nan must be finite"),
        (["--tool", "inf"], 2, "--tool inf must be finite"),
        (["--until", "-1"], 2, "--until"),
        (["--until", "nan"], 2, "--until"),
        (["-o", "m.txt"], 2, "must end in .mcap or .csv"),
        (["-o", "no/m.csv"], 1, "there is no folder no to write to"),
        (["-o", "BAD/folder.csv"], 1, "no regular file"),
        (["--picture", "p.gif"], 2, "must end in .png"),
        (["--environment", "BAD/lacking.json"], 1, "the environment lacks object.width: it has object.height"),
        (["--environment", "BAD/nan.json"], 1, "nan.json"),
        (["--environment", "BAD/none.json"], 1, "none.json: No such file"),
        (["--urdf", "BAD/empty.urdf"], 1, "empty.urdf"),
        (["--urdf", "BAD/unlimited.urdf"], 1, "a"),
        (["--urdf", "BAD/none.urdf"], 1, "none.urdf"),
        (["--base", "nowhere"], 1, "nowhere"),
        (["--tip", "nowhere"], 1, "nowhere"),
        (["--observe", "BAD/other.npz"], 1, "the partner's column knee.0 was not learned from"),
        (["--observe", "BAD/unseen.npz"], 1, "no sample of the partner was seen"),
        (["--observe", "BAD/nowhere.npz"], 1, "the environment lacks object.height, object.width: it has nothing"),
        (["--observe", "BAD/model.safetensors"], 1, "model.safetensors"),
    ],
)
def test_bad_input_is_reported_in_one_line(folder, bad, monkeypatch, capsys, flags, code, said) -> None:  # type: ignore[no-untyped-def]
    flags = [flag.replace("BAD", str(bad)) for flag in flags]
    got, _, err = run(monkeypatch, capsys, *words(folder), *flags)
    assert got == code, err
    assert said in " ".join(err.split())
    if code == 1:
        failure(err)


def test_models_that_are_damaged_or_hold_no_pose_are_refused(folder, bad, monkeypatch, capsys) -> None:
    code, _, err = run(
        monkeypatch, capsys, "collaborate", bad / "model.safetensors", "--observe", folder / "person.npz"
    )
    assert code == 1
    assert "model.safetensors" in failure(err)
    code, _, err = run(monkeypatch, capsys, *words(folder, model="places"))
    assert code == 1
    assert "a gripper's pose needs one column each of x, y, z, qx, qy, qz, qw" in failure(err)


# -- another robot -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ur5(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A UR5, and demonstrations of its tool that goes where the partner goes."""
    folder = tmp_path_factory.mktemp("ur5")
    (folder / "ur5.urdf").write_text(ur5_urdf())
    tool = np.eye(4)
    tool[2, 3] = 0.1
    begin, end = np.array([0.3, -1.2, 1.4, -0.6, 0.9, 0.2]), np.array([0.9, -1.0, 1.1, -0.4, 1.1, 0.5])
    s = np.linspace(0, 1, 120)[:, None]
    ones = []
    for k in range(3):
        joints = begin + s * s * (3 - 2 * s) * (end - begin) * (1 + 0.1 * k)
        poses = np.array([ur5_forward(q) @ tool for q in joints])
        robot_columns = np.hstack([poses[:, :3, 3], Rotation.from_matrix(poses[:, :3, :3]).as_quat()])
        names = tuple(f"tool.{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw"))
        partner = np.hstack([poses[:, :2, 3] + 0.5, 0.3 + 0.1 * k + 0.5 * s])
        ones.append(
            InteractionRecording(4 * s[:, 0], partner, robot_columns, ("h.x", "h.y", "h.z"), names, {"e": 1.0 * k})
        )
    CollaborationModel.fit(ones).save(folder / "model.safetensors")
    ones[1].save(folder / "person.npz")
    return folder


def test_another_robots_urdf_base_and_tip_give_its_joints(ur5, monkeypatch, capsys, tmp_path) -> None:
    path = tmp_path / "m.mcap"
    flags = ("--urdf", ur5 / "ur5.urdf", "--base", "l0", "--tip", "tool0", "--tool", "0.1", "-o", path)
    code, out, err = run(monkeypatch, capsys, *words(ur5, *flags))
    assert code == 0, err
    assert "self-collision was not looked for: the robot has no collision shapes" in out
    with path.open("rb") as file:
        ((_, _, _, message),) = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
    assert list(message.joint_names) == [f"j{k}" for k in range(6)]
    model = CollaborationModel.load(ur5 / "model.safetensors")
    person = load_interaction(ur5 / "person.npz")
    _, wanted = model.infer(person.partial(seconds=1), person.environment).motion_from_now(0.02)
    for point, row in zip(message.points, wanted, strict=True):
        place = ur5_forward(np.array(point.positions)) @ [0, 0, 0.1, 1]
        np.testing.assert_allclose(place[:3], row[:3], atol=2e-4)


def test_a_robot_whose_hand_no_column_names_needs_a_tip(ur5, monkeypatch, capsys) -> None:
    code, _, err = run(monkeypatch, capsys, *words(ur5, "--urdf", ur5 / "ur5.urdf", "--base", "l0"))
    assert code == 1
    assert "which hand moves?" in failure(err)


# -- execution ---------------------------------------------------------------------------------------------------------

AT_A_TERMINAL = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job, as a CI may be, ignores it
from lfdcore.humanoid import execution
real = execution.in_real_time
def announced(*arguments):
    print("begun", flush=True)
    return real(*arguments)
execution.in_real_time = announced
from lfdcore.cli.main import main
main()
"""


def test_ctrl_c_stops_the_robot_at_once_it_holds_and_the_exit_code_is_130(folder: Path) -> None:
    command = [sys.executable, "-c", AT_A_TERMINAL, *map(str, words(folder, "--execute", "--json"))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "begun\n"
            time.sleep(0.5)
            asked = time.monotonic()
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=20)
        finally:
            process.kill()
        took = time.monotonic() - asked
    assert process.returncode == 130, err
    assert took < 8  # what is left of the motion takes longer
    executed = json.loads(out)["executed"]
    stopped = float(executed.split("stopped after ")[1].split(" s")[0])
    assert 0.2 < stopped < 8
    assert executed.endswith("it holds where it is")
    assert failure(err) == "lfdcore: interrupted"


def test_execution_to_the_end_tells_the_tracking_error(ur5, monkeypatch, capsys) -> None:
    flags = ("--urdf", ur5 / "ur5.urdf", "--base", "l0", "--tip", "tool0", "--tool", "0.1", "--execute", "--json")
    person = load_interaction(ur5 / "person.npz")
    begin = time.monotonic()
    code, out, err = run(monkeypatch, capsys, *words(ur5)[:-1], "3.6", *flags)
    assert code == 0, err
    facts = json.loads(out)
    ticks = int(facts["executed"].split()[0])
    assert ticks == pytest.approx((1 - facts["share"]) * 100 * person.duration, abs=12)
    assert time.monotonic() - begin >= ticks / 100 - 0.02
    assert "tracking error" in facts["executed"]
    assert "stopped" not in facts["executed"]
    assert math.isfinite(float(facts["executed"].split("error ")[1].split()[0]))


def test_study_joints_writes_a_report_and_says_who_is_better(monkeypatch, capsys, tmp_path) -> None:
    from lfdcore.simulated.covering import BOUNDING_BOX, CoveringProtocol
    from lfdcore.study.joints import study
    from lfdcore.training.collaborations import NoiseChoice

    small = dataclasses.replace(BOUNDING_BOX, demonstrations=2, novel=BOUNDING_BOX.novel[-1:])
    quick = NoiseChoice(factors=(1.0,), folds=2, shares=(0.1,))

    @dataclasses.dataclass(frozen=True, kw_only=True)
    class SmallStudy(study.JointSpaceStudy):
        protocol: CoveringProtocol = small
        choice: NoiseChoice = quick

    monkeypatch.setattr(study, "JointSpaceStudy", SmallStudy)
    more = ("--seeds", "1", "--seed", "100", "--held-out", "1", "--processes", "1")
    code, out, err = run(monkeypatch, capsys, "study", "joints", "-o", tmp_path / "out", *more)
    assert code == 0, err
    assert out.startswith("Joint space is better at nothing that shows over seeds.")
    for title in (
        "Known objects: 4 people",
        "Novel objects: 1 people",
        "What little teaches",
        "What comes nearest",
        "Time from observation",
    ):
        assert title in out
    report = (tmp_path / "out" / "report.html").read_text()
    assert "lfdcore study joints -o out --seeds 1 --held-out 1 --seed 100" in report
    assert report.count("<img") == 1
    code, out, _ = run(monkeypatch, capsys, "study", "joints", "-o", tmp_path / "out", *more, "--json")
    assert json.loads(out)["headline"].startswith("Joint space is better at nothing that shows over seeds.")
    assert run(monkeypatch, capsys, "study", "joints", "-o", tmp_path / "out", "--seeds", "0")[0] == 2
