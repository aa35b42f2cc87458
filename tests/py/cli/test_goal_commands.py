"""lfdcore learn goals, track, study goals and info with a model of destinations, as a user calls them."""

import dataclasses
import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from calling import run
from goal_worlds import GOALS, drive_to, drives, learned
from lfdcore.datasets import Goal, Goals, open_log, write_goals, write_map
from lfdcore.grid import OccupancyGrid
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig
from lfdcore.wheelchair.goals.model import GoalModel


def one_line(err: str) -> str:
    """What a failure says, in a single line after the bars."""
    (line,) = [line for line in err.splitlines() if line.startswith("lfdcore: ")]
    return line


def room() -> OccupancyGrid:
    """14 x 14 m about the drives, with boxes that a scan tells apart."""
    data = np.zeros((280, 280), np.int8)
    data[:2], data[-2:], data[:, :2], data[:, -2:] = 100, 100, 100, 100
    for x, y in ((1.0, 3.0), (4.0, -3.5), (8.0, 5.0), (3.0, 5.5), (9.0, -5.0)):
        ix, iy = round((x + 3) / 0.05), round((y + 7) / 0.05)
        data[iy : iy + 12, ix : ix + 20] = 100
    return OccupancyGrid(data, 0.05, (-3.0, -7.0))


def with_scans(log, grid: OccupancyGrid):
    """The drive with what a scanner saw at every third moment."""
    lidar, chosen = LidarConfig(), slice(0, None, 3)
    world = DrivingWorld(grid, ChairConfig(), lidar, seed=1)
    scans = []
    for pose in log.pose[chosen]:
        world.reset(type(log.T_base_laser)(*pose))
        scans.append(world.scan())
    return dataclasses.replace(
        log,
        scan_stamp=log.odometry_stamp[chosen],
        ranges=np.array([scan.ranges for scan in scans], np.float32),
        angle_min=scans[0].angle_min,
        angle_increment=scans[0].angle_increment,
        range_min=scans[0].range_min,
        range_max=scans[0].range_max,
        T_base_laser=lidar.T_base_laser,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Map, goals, a model that names the map, a drive with poses in the map, and the same without any."""
    folder = tmp_path_factory.mktemp("goals")
    write_map(room(), folder / "room.yaml")
    goals = Goals(GOALS.goals, folder / "room.yaml")
    write_goals(goals, folder / "goals.yaml")
    dataclasses.replace(learned(), goals=goals).save(folder / "goals.safetensors")
    learned().save(folder / "no-map.safetensors")
    drive = with_scans(drive_to(0, 77), room())
    drive.save(folder / "drive.mcap")
    blind = dataclasses.replace(drive, map_stamp=np.zeros(0), map_odom=np.zeros((0, 3)), name="blind")
    blind.save(folder / "blind.mcap")
    dark = dataclasses.replace(blind, ranges=np.full_like(blind.ranges, np.inf), name="dark")
    dark.save(folder / "dark.mcap")
    silent = dataclasses.replace(drive, joystick_stamp=np.zeros(0), joystick=np.zeros((0, 2)), name="silent")
    silent.save(folder / "silent.mcap")
    return folder


# -- learn ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def quick(monkeypatch) -> None:
    """A search that takes no minutes."""
    from lfdcore.training import goals
    from lfdcore.training.parts.goal_net import GoalNetConfig

    network = GoalNetConfig(epochs=2)
    small = partial(goals.GoalLearningConfig, network=network, search_samples=40, searches=1, generations=2)
    monkeypatch.setattr(goals, "GoalLearningConfig", small)


def test_learn_goals_writes_a_model_that_info_describes(folder, quick, monkeypatch, capsys, tmp_path) -> None:
    logs = []
    for log in drives(1):
        log.save(tmp_path / f"{log.name}.mcap")
        logs.append(tmp_path / f"{log.name}.mcap")
    model = tmp_path / "model.safetensors"
    words = [
        "learn",
        "goals",
        *logs,
        "--goals",
        folder / "goals.yaml",
        "-o",
        model,
        "--subset",
        "50",
        "--seed",
        "3",
        "--json",
    ]
    code, out, err = run(monkeypatch, capsys, *words)
    assert code == 0, err
    assert (json.loads(out)["subset"], json.loads(out)["seed"]) == (50, 3)
    for stage in ("network", "kernels", "subset"):
        assert stage in err
    assert GoalModel.load(model).goals.map == folder / "room.yaml"
    code, out, _ = run(monkeypatch, capsys, "info", model)
    assert code == 0
    assert "goals model" in out
    assert "ahead 9, 0 m" in out
    code, out, _ = run(monkeypatch, capsys, "info", model, "--json")
    assert json.loads(out)["drives"] == 3


def test_learn_goals_refuses_before_minutes_of_work(folder, monkeypatch, capsys, tmp_path) -> None:
    goals, drive, there = folder / "goals.yaml", folder / "drive.mcap", tmp_path / "m.safetensors"
    outside = tmp_path / "outside.yaml"
    outside.write_text(
        f"map: {folder / 'room.yaml'}\ngoals:\n- {{name: a, x: 1, y: 0}}\n- {{name: far, x: 99, y: 0}}\n"
    )
    for words, code, said in (
        ([drive, drive, "--goals", goals, "-o", there], 2, "is given twice"),
        ([drive, "--goals", goals, "-o", tmp_path / "no" / "m.safetensors"], 1, "there is no folder"),
        ([drive, "--goals", goals, "-o", goals], 2, "is read, so nothing is written there"),
        ([drive, "--goals", outside, "-o", there], 1, "goal 'far' is at (99, 0) m, outside the map"),
        ([drive, "--goals", tmp_path / "none.yaml", "-o", there], 1, "none.yaml: No such file"),
        ([drive, "--goals", goals, "-o", there], 1, "no drive goes to goal 2 of 3"),
        ([folder / "silent.mcap", "--goals", goals, "-o", there], 1, "has no joystick"),
    ):
        found, _, err = run(monkeypatch, capsys, "learn", "goals", *words)
        assert found == code, err
        assert said in " ".join(err.split())
        assert not there.exists()


# -- track ------------------------------------------------------------------------------------------------------------


def track_json(monkeypatch, capsys, *words) -> list[dict]:
    code, out, err = run(monkeypatch, capsys, "track", *words, "--json")
    assert code == 0, err
    said = json.loads(out)
    assert said["goals"] == ["left", "ahead", "right"]
    return said["beliefs"]


def test_track_ends_at_the_goal_and_says_so_for_people_and_machines(folder, monkeypatch, capsys) -> None:
    beliefs = track_json(monkeypatch, capsys, folder / "goals.safetensors", folder / "drive.mcap")
    assert beliefs[-1]["nearest"] == 0
    assert all(sum(one["likelihood"]) == pytest.approx(1) for one in beliefs)
    np.testing.assert_allclose(np.diff([one["time"] for one in beliefs])[:-1], 2.0)
    code, out, _ = run(monkeypatch, capsys, "track", folder / "goals.safetensors", folder / "drive.mcap")
    assert code == 0
    assert len(out.splitlines()) == len(beliefs) + 1
    assert re.match(r"\s+[\d.]+  left ", out.splitlines()[-1])
    wide = np.sqrt(np.linalg.eigvalsh(beliefs[-1]["covariance"])[-1])  # the standard deviation where it is largest
    assert out.splitlines()[-1].split()[2] == f"{wide:.1f}"


def test_track_finds_poses_by_itself_where_a_log_has_none(folder, monkeypatch, capsys) -> None:
    model = folder / "no-map.safetensors"
    known = track_json(monkeypatch, capsys, model, folder / "drive.mcap")
    start = "--start=" + ",".join(f"{value:.4f}" for value in degrees(open_log(folder / "drive.mcap").pose[0]))
    for words in ([start], []):  # where a drive begins is known or as learned
        matched = track_json(monkeypatch, capsys, model, folder / "blind.mcap", "--map", folder / "room.yaml", *words)
        assert len(matched) == len(known)
        assert matched[-1]["nearest"] == known[-1]["nearest"] == 0
        off = np.array([one["mean"] for one in matched]) - [one["mean"] for one in known]
        assert np.hypot(*off.T).mean() < 1.0


def degrees(pose: np.ndarray) -> list[float]:
    return [pose[0], pose[1], float(np.degrees(pose[2]))]


def test_the_model_s_own_map_serves_where_none_is_given(folder, monkeypatch, capsys) -> None:
    assert track_json(monkeypatch, capsys, folder / "goals.safetensors", folder / "blind.mcap")[-1]["nearest"] == 0


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_track_draws_a_picture(folder, monkeypatch, capsys, tmp_path, suffix) -> None:
    picture = tmp_path / f"drive{suffix}"
    words = [folder / "goals.safetensors", folder / "drive.mcap", "--picture", picture]
    assert run(monkeypatch, capsys, "track", *words)[0] == 0
    if suffix == ".png":
        with Image.open(picture) as image:
            assert min(image.size) > 400
    else:
        assert "likelihood" in picture.read_text() or picture.stat().st_size > 10_000


def test_track_animates_half_seconds_and_the_end(folder, monkeypatch, capsys, tmp_path) -> None:
    short = open_log(folder / "drive.mcap").slice(0.0, 1.7)
    assert 1.5 < short.odometry_stamp[-1] < 2
    short.save(tmp_path / "short.mcap")
    movie = tmp_path / "belief.gif"
    words = [folder / "goals.safetensors", tmp_path / "short.mcap", "--animation", movie]
    code, _, err = run(monkeypatch, capsys, "track", *words)
    assert code == 0, err
    with Image.open(movie) as image:
        assert image.n_frames == 5


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["goals.safetensors", "drive.mcap", "--picture", "p.jpg"], 2, "--picture p.jpg must end in .png, .pdf, .svg"),
        (["goals.safetensors", "drive.mcap", "--animation", "p.mp4"], 2, "--animation p.mp4 must end in .gif"),
        (["goals.safetensors", "drive.mcap", "--every", "0"], 2, "--every"),
        (["goals.safetensors", "drive.mcap", "--every", "nan"], 2, "--every"),
        (["goals.safetensors", "blind.mcap", "--start", "1,2"], 2, "--start '1,2' must be X,Y,YAW"),
        (["goals.safetensors", "blind.mcap", "--start", "a,b,c"], 2, "--start 'a,b,c' must be X,Y,YAW"),
        (["goals.safetensors", "blind.mcap", "--start", "nan,0,0"], 2, "--start 'nan,0,0' must be"),
        (["goals.safetensors", "drive.mcap", "--start", "0,0,0"], 2, "--start is for a drive without poses in the map"),
        (["goals.safetensors", "blind.mcap", "--start", "500,0,90"], 1, "scans of log 'blind' fits the map about"),
        (["goals.safetensors", "dark.mcap"], 1, "scans of log 'dark' fits the map about"),
        (["goals.safetensors", "drive.mcap", "--map", "none.yaml"], 1, "none.yaml: No such file"),
        (["no-map.safetensors", "blind.mcap"], 2, "--map is needed"),
        (["no-map.safetensors", "drive.mcap", "--picture", "p.png"], 2, "--map is needed"),
        (["no-map.safetensors", "blind.mcap", "--map", "none.yaml"], 1, "none.yaml: No such file"),
        (["goals.safetensors", "silent.mcap"], 1, "log 'silent' has no joystick"),
        (["drive.mcap", "goals.safetensors"], 1, "drive.mcap is not a model file"),
        (["goals.safetensors", "goals.safetensors"], 1, "goals.safetensors"),
        (["none.safetensors", "drive.mcap"], 1, "none.safetensors: No such file"),
        (["goals.safetensors", "drive.mcap", "--picture", "none/p.png"], 1, "there is no folder none"),
    ],
)
def test_track_refuses_in_one_line(folder, monkeypatch, capsys, words, code, said) -> None:
    monkeypatch.chdir(folder)
    found, _, err = run(monkeypatch, capsys, "track", *words)
    assert found == code, err
    assert said in " ".join(err.replace("│", " ").split())
    if code == 1:
        one_line(err)


def test_a_drive_whose_poses_lie_outside_all_that_was_learned_leaves_the_prior(folder, monkeypatch, capsys, tmp_path):
    log = open_log(folder / "drive.mcap")
    far = dataclasses.replace(log, map_odom=log.map_odom + np.array([1e4, 0, 0]))
    far.save(tmp_path / "far.mcap")
    beliefs = track_json(monkeypatch, capsys, folder / "goals.safetensors", tmp_path / "far.mcap")
    np.testing.assert_allclose(beliefs[-1]["mean"], GOALS.positions.mean(axis=0), atol=1e-6)


def test_goals_outside_the_map_are_refused_where_a_map_is_given(folder, monkeypatch, capsys, tmp_path) -> None:
    elsewhere = Goals((*GOALS.goals[:2], Goal("moon", 500.0, 0.0)))
    dataclasses.replace(learned(), goals=elsewhere).save(tmp_path / "moon.safetensors")
    words = [tmp_path / "moon.safetensors", folder / "blind.mcap", "--map", folder / "room.yaml"]
    code, _, err = run(monkeypatch, capsys, "track", *words)
    assert code == 1
    assert "goal 'moon' is at (500, 0) m, outside the map" in one_line(err)


# -- other commands ---------------------------------------------------------------------------------------------------


def test_predict_refuses_a_model_of_destinations_in_one_line(folder, monkeypatch, capsys) -> None:
    code, _, err = run(monkeypatch, capsys, "predict", folder / "goals.safetensors", folder / "drive.mcap")
    assert code == 1
    assert "is a model of destinations (lfdcore track), no model that plans paths" in one_line(err)


def test_study_goals_explains_itself(monkeypatch, capsys) -> None:
    code, out, _ = run(monkeypatch, capsys, "study", "goals", "--help")
    assert code == 0
    for option in ("--output", "--map", "--sparse", "--subset", "--preset", "--seed"):
        assert option in out
