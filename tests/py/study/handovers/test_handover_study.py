"""The study of real handovers: honest splits, methods against slow ones, sets known by contents, the same bytes."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import read_kth_handovers
from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.errors import DataError
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel
from lfdcore.study.handovers.report import findings, handover_headline
from lfdcore.study.handovers.study import (
    MEASURES,
    METHODS,
    SHARES,
    STEPS,
    HandoverResult,
    HandoverSplit,
    HandoverStudy,
    NearestDemonstration,
    Truth,
    infer_by_clock,
    judge_handovers,
    run_handover_study,
    with_place,
)
from lfdcore.study.handovers.tables import handover_rows, seen_tables, task_tables
from lfdcore.study.handovers.tasks import HandoverTask, hand_columns, handover_tasks
from lfdcore.study.study import write_study

COUNT, SAMPLES = 12, 81


def handover(k: int) -> np.ndarray:
    """Giver's baton and taker's hand meet at a place of their own, then part; poses (T, 14)."""
    random = np.random.default_rng(k)
    place = np.array([0.5, 0.0, 1.0]) + random.normal(0, 0.1, 3)
    s = np.sin(np.linspace(0, np.pi, SAMPLES))[:, None] ** 2
    giver, taker = s * place, np.array([1.0, 0, 1]) + s * (place - [1.0, 0, 1])
    turn = np.tile([0.0, 0, 0, 1], (SAMPLES, 1)) + 0.1 * s * [1, 0, 0, 0]
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    return np.hstack([giver + random.normal(0, 0.001, (SAMPLES, 3)), turn, taker, turn])


@pytest.fixture(scope="module")
def kth(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """12 handovers under another name; one of them is listed as faulty."""
    path = tmp_path_factory.mktemp("handovers") / "some.npz"
    names = ["train_001", *(f"test_{k:03}" for k in range(COUNT - 1))]
    np.savez(path, **{name: handover(k) for k, name in enumerate(names)})
    return path


@pytest.fixture(scope="module")
def dynamic(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("handovers") / "any.npz"
    joints, lengths = np.array([0, 8, 15]), np.arange(COUNT) + 30
    parts = [[], []]
    for k, length in enumerate(lengths):
        both = handover(k)[np.linspace(0, SAMPLES - 1, length).round().astype(int)]
        for body, columns in zip(parts, (slice(0, 3), slice(7, 10)), strict=True):
            body.append(both[:, None, columns] + np.array([[[0, 0, -0.5]], [[0.1, 0, 0]], [[0, 0, 0]]]).swapaxes(0, 1))
    giver, receiver = map(np.concatenate, parts)
    names = np.array([f"h{k}" for k in range(COUNT)])
    place = np.zeros((len(giver), 3))
    np.savez(path, names=names, lengths=lengths, joints=joints, giver=giver, receiver=receiver, object_pos=place)
    return path


@pytest.fixture(scope="module")
def task(kth: Path) -> HandoverTask:
    return handover_tasks([kth])[0]


@pytest.fixture(scope="module")
def result(kth: Path, task: HandoverTask) -> HandoverResult:
    """Of the first of the file's three tasks."""
    return judge_handovers(HandoverStudy(data=(kth,), splits=2, seed=3, processes=1), [task])


def test_a_files_contents_tell_which_set_it_is(kth: Path, dynamic: Path) -> None:
    tasks = handover_tasks([dynamic, kth])
    assert [len(one.recordings) for one in tasks] == [COUNT, COUNT, COUNT - 1, COUNT - 1, COUNT]
    assert [one.recordings[0].partner.shape[1] for one in tasks] == [6, 9, 3, 7, 3]
    assert [one.recordings[0].robot.shape[1] for one in tasks] == [6, 6, 3, 7, 3]
    assert tasks[2].recordings[0].partner_names == ("baton.x", "baton.y", "baton.z")
    assert [tuple(hand_columns(one.recordings[0].robot_names)[0]) for one in tasks] == [(0, 1, 2)] * 5


def test_other_files_are_refused_by_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    np.savez(tmp_path / "few.npz", train_002=handover(0))
    (tmp_path / "text.npz").write_text("nothing")
    np.save(tmp_path / "array.npy", np.zeros(3))
    for name in ("other.npz", "text.npz", "array.npy"):
        with pytest.raises(DataError, match=name):
            handover_tasks([tmp_path / name])
    with pytest.raises(ValueError, match="has 1 handovers, must have at least 10"):
        handover_tasks([tmp_path / "few.npz"])
    with pytest.raises(FileNotFoundError):
        handover_tasks([tmp_path / "none.npz"])


def test_nothing_that_is_learned_from_is_tested(task: HandoverTask) -> None:
    splits = [HandoverSplit(task, k, 3).parts() for k in range(5)]
    for learn, test in splits:
        assert sorted([*learn, *test]) == list(range(len(task.recordings)))
    assert len({tuple(test) for _, test in splits}) > 1
    assert all(
        (a[1] == b[1]).all() for a, b in zip(splits, [HandoverSplit(task, k, 3).parts() for k in range(5)], strict=True)
    )


def test_the_mean_trajectorys_errors_are_those_written_out(task: HandoverTask, result: HandoverResult) -> None:
    learn, test = HandoverSplit(task, 0, 3).parts()
    even = [one.resample(STEPS).robot for one in task.recordings]
    mean, at = np.mean([even[k] for k in learn], axis=0), METHODS.index("mean trajectory")
    for row, k in zip(result.tasks[0].splits[0].errors, test, strict=True):
        apart = np.linalg.norm(mean - even[k], axis=1)
        meeting = np.argmin(np.linalg.norm(even[k] - task.recordings[k].resample(STEPS).partner, axis=1))
        wanted = [np.sqrt(np.mean(apart**2)), apart[-1], apart[meeting]]
        np.testing.assert_allclose(row[at], np.tile(wanted, (len(SHARES), 1)), rtol=1e-9)


def test_the_nearest_demonstration_is_the_one_that_moved_most_alike(task: HandoverTask) -> None:
    nearest = NearestDemonstration(task.recordings)
    for k, one in enumerate(task.recordings):
        assert nearest.index(one.partial(share=0.6)) == k
    short = NearestDemonstration([task.recordings[0].first(3), task.recordings[1]])  # rests at its end
    assert short.index(task.recordings[1]) == 1


def test_given_the_phase_a_known_giver_is_followed_to_the_end(task: HandoverTask) -> None:
    model = CollaborationModel.fit(task.recordings, CollaborationConfig(environment=False, steps=STEPS))
    one = task.recordings[0]
    said = infer_by_clock(model, one, one.duration)
    assert said.share == pytest.approx(1)
    assert Truth.of(one).errors(said.robot_motion().reshape(STEPS, 1, 3)).max() < 0.02
    slow = infer_by_clock(model, one, one.duration / 2)  # the second half is beyond the motion
    assert slow.share == pytest.approx(1)
    assert infer_by_clock(model, one.partial(share=0), 2.0).share == 0


def test_the_place_is_where_the_hands_meet(task: HandoverTask) -> None:
    one = task.recordings[0]
    place = np.array([with_place(one).environment[f"place.{axis}"] for axis in "xyz"])
    apart = np.linalg.norm(one.partner - one.robot, axis=1)
    np.testing.assert_allclose(place, one.robot[np.argmin(apart)], atol=0.02)


def test_ip_predicts_the_taker_from_the_giver(result: HandoverResult) -> None:
    means = result.tasks[0].errors.mean(axis=0)[:, :, MEASURES.index("at the handover")]
    at = SHARES.index(0.5)
    assert means[METHODS.index("IP, phase by the clock"), at] < 0.3 * means[METHODS.index("mean trajectory"), at]
    assert means[METHODS.index("oracle: place given"), 0] < 0.3 * means[METHODS.index("IP"), 0]


def test_the_result_depends_on_the_seed_alone(task: HandoverTask, result: HandoverResult, tmp_path: Path) -> None:
    again = judge_handovers(dataclasses.replace(result.study, processes=2), [task])
    np.testing.assert_array_equal(again.tasks[0].errors, result.tasks[0].errors)
    reports = []
    for name, found in (("a", result), ("b", again)):
        (tmp_path / name).mkdir()
        reports.append(write_study(found.study, findings(found), tmp_path / name).read_bytes())
    assert reports[0] == reports[1]
    rows = json.loads((tmp_path / "a" / "figures.json").read_text())["rows"]
    assert len(rows) == len(METHODS) * len(SHARES) * len(MEASURES)
    assert rows == json.loads(json.dumps(handover_rows(result)))


def test_tables_name_n_seed_and_oracles(result: HandoverResult) -> None:
    for table in task_tables(result.tasks[0], 3):
        assert f"n = {COUNT - 1} handovers, 4 tests in 2 splits" in table.title
        assert len(table.header) == 1 + len(SHARES)
    assert sum(row[0].startswith("oracle") for row in task_tables(result.tasks[0], 3)[0].rows) == 2
    assert f"(n = {COUNT - 1})" in handover_headline(result)


def test_what_more_that_is_seen_is_worth_is_paired(dynamic: Path) -> None:
    hands, skeleton = run_handover_study(HandoverStudy(data=(dynamic,), splits=1, seed=3, processes=1)).tasks
    (table,) = seen_tables([hands, skeleton], 3)
    apart = 1e3 * (skeleton.errors - hands.errors).mean(axis=0)[METHODS.index("IP, phase by time warping"), :, 0]
    assert [int(cell.split("\n")[0]) for cell in table.rows[0][1:]] == pytest.approx(apart, abs=0.51)
    assert seen_tables([hands], 3) == []


def test_a_study_without_splits_or_files_and_one_of_a_file_twice_are_refused(kth: Path) -> None:
    for files, splits, said in (((kth,), 0, "splits is 0"), ((), 1, "data is empty"), ((kth, kth), 1, "given twice")):
        with pytest.raises(ValueError, match=said):
            HandoverStudy(data=files, splits=splits)


@pytest.mark.realdata
def test_on_kth_ip_beats_the_mean_once_it_knows_the_phase(data_folder: Path) -> None:
    """One split of the real set: given the phase IP is the best of all; by DTW it is lost at the end, where the giver
    has come back to where it began."""
    tasks = handover_tasks([data_folder / "interaction" / "kth_handover_6d.npz"])
    assert [len(one.recordings) for one in tasks] == [97, 97, 106]
    errors = HandoverSplit(tasks[0], 0, 1).run().errors.mean(axis=0)[:, :, 0]
    at = SHARES.index(0.5)
    given, by_dtw, mean = (
        METHODS.index(name) for name in ("oracle: phase given", "IP, phase by time warping", "mean trajectory")
    )
    assert errors[given, at] < 0.8 * errors[mean, at]
    assert errors[given, -1] < 0.7 * errors[by_dtw, -1]
    assert len(read_kth_handovers(data_folder / "interaction" / "kth_handover_6d.npz")) == 97


@pytest.mark.realdata
def test_dynamic_handovers_are_120_by_hands_and_by_15_joints(data_folder: Path) -> None:
    hands, skeleton = handover_tasks([data_folder / "interaction" / "dynamic_handover_120.npz"])
    assert len(hands.recordings) == len(skeleton.recordings) == 120
    assert (hands.recordings[0].partner.shape[1], skeleton.recordings[0].partner.shape[1]) == (6, 45)
    assert all((a.robot == b.robot).all() for a, b in zip(hands.recordings, skeleton.recordings, strict=True))


def test_the_command_writes_a_report(kth: Path, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from lfdcore.cli.main import app

    arguments = ["study", "handovers", str(kth), "-o", str(tmp_path / "out"), "--splits", "1", "--processes", "1"]
    done = CliRunner().invoke(app, [*arguments, "--json"])
    assert done.exit_code == 0, done.output
    said = json.loads(done.stdout)
    assert said["report"] == str(tmp_path / "out" / "report.html")
    assert said["command"] == "lfdcore study handovers some.npz -o out --splits 1 --seed 1"
    assert {row["task"] for row in said["rows"]} == {one.name for one in handover_tasks([kth])}
    assert {"task", "measure", "method", "share", "error", "low", "high", "sd_of_splits"} < said["rows"][0].keys()
    assert (tmp_path / "out" / "report.html").is_file()
    twice = CliRunner().invoke(app, ["study", "handovers", str(kth), str(kth), "-o", str(tmp_path / "out")])
    assert twice.exit_code != 0


def test_recordings_of_one_body_alone_have_no_hands() -> None:
    one = InteractionRecording(np.arange(3.0), np.zeros((3, 1)), np.zeros((3, 0)), ("pelvis.x",))
    assert hand_columns(one.partner_names).shape == (0, 3)
