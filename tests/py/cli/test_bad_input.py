"""Bad input at the command line and in maps: one clear line, nothing replaced that is not ours."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lfdcore.cli.main import main
from lfdcore.control import (
    FootprintRolloutConfig,
    Supervisor,
    rollout_pursuit,
    solve_dynamic_window,
    time_to_contact,
)
from lfdcore.datasets import DriveLog, read_map, write_map
from lfdcore.errors import DataError
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, resample
from lfdcore.grid import ObstaclePoints, OccupancyGrid
from lfdcore.planning import HybridAstar, baseline_preference

BOMB = "a0: &a0 [x, x, x, x]\n" + "".join(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(12))


def outcome(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    monkeypatch.setattr(sys, "argv", ["lfdcore", *map(str, arguments)])
    with pytest.raises(SystemExit) as stopped:
        main()
    return int(stopped.value.code or 0)


def empty_log(stamps: int = 1) -> DriveLog:
    return DriveLog(
        scan_stamp=np.arange(stamps, dtype=float), ranges=np.ones((stamps, 5), np.float32), T_base_laser=Pose2()
    )


def changed_map(folder: Path, key: str, value: str, before: str = "") -> Path:
    path = folder / "map.yaml"
    write_map(OccupancyGrid(np.zeros((4, 4), np.int8), 0.05, (0.0, 0.0)), path)
    kept = [line for line in path.read_text().splitlines() if not line.startswith((key, "- "))]
    kept += [] if key == "origin" else ["origin: [0.0, 0.0, 0.0]"]
    path.write_text(
        before + "\n".join(line for line in dict.fromkeys(kept) if line != "origin:") + f"\n{key}: {value}\n"
    )
    return path


@pytest.mark.parametrize("key", ["resolution", "origin", "mode", "negate", "image"])
def test_a_map_whose_entry_unfolds_to_gigabytes_is_refused_in_a_short_line(key: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=key) as refused:
        read_map(changed_map(tmp_path, key, "*a12", BOMB))
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize("value", ["1" + "0" * 400, "!!timestamp x", "1.0e+300"])
def test_a_map_with_a_number_that_is_none_is_refused(value: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"resolution|YAML"):
        read_map(changed_map(tmp_path, "resolution", value))


def test_a_map_whose_image_is_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.pgm")
    with pytest.raises(DataError, match=r"pipe.pgm cannot be read: is no regular file"):
        read_map(changed_map(tmp_path, "image", "pipe.pgm"))


def test_info_tells_of_a_log_without_odometry(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    empty_log().save(tmp_path / "still.mcap")
    assert outcome(monkeypatch, "info", tmp_path / "still.mcap") == 0
    assert "records 0, way [m] 0" in capsys.readouterr().out


def test_learn_does_not_replace_a_log_that_it_learns_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "drive.mcap"
    empty_log().save(log)
    before = log.read_bytes()
    assert outcome(monkeypatch, "learn", "drive", log, "-o", log) == 2
    assert log.read_bytes() == before


def test_learn_and_save_do_not_replace_what_is_no_regular_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    empty_log().save(tmp_path / "drive.mcap")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert outcome(monkeypatch, "learn", "drive", tmp_path / "drive.mcap", "-o", pipe) == 1
    assert "no regular file" in capsys.readouterr().err
    with pytest.raises(ValueError, match="no regular file"):
        empty_log().save(pipe)
    assert pipe.is_fifo()


@pytest.mark.parametrize("footprint", ["nan,1,1", "-1,1,1", "1e300,1,1", "1,inf,1"])
def test_predict_refuses_a_footprint_that_no_robot_has(footprint: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert outcome(monkeypatch, "predict", "model", "log", "--footprint", footprint) == 2


def test_a_failure_is_one_line_even_where_a_name_holds_a_line_break(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(monkeypatch, "info", "one\ntwo") == 1
    assert capsys.readouterr().err == "lfdcore: one two: no such file\n"


@pytest.mark.parametrize("size", [1e308, float("inf"), float("nan"), 101.0])
@pytest.mark.parametrize("side", ["front", "rear", "half_width"])
def test_no_search_begins_with_a_footprint_that_it_could_not_get_around(side: str, size: float) -> None:
    obstacles, body, goal = ObstaclePoints(np.ones((3, 2))), Footprint(), np.array([1.0, 0.5])
    setattr(body, side, size)
    limits, still, path = MotionLimits(), Twist2(0.5, 0.2), np.array([[0.0, 0.0], [1.0, 0.0]])
    rollout = FootprintRolloutConfig(look_ahead=0.8, linear=0.5)
    for search in (
        lambda: time_to_contact(still, obstacles, body, 1.0),
        lambda: rollout_pursuit(path, obstacles, body, limits, still, config=rollout),
        lambda: solve_dynamic_window(still, goal, obstacles, body, limits),
        lambda: Supervisor(body, limits),
        lambda: HybridAstar(body),
    ):
        with pytest.raises(ValueError, match=rf"footprint.{side} is .* m"):
            search()


def test_study_refuses_a_model_that_is_missing_before_it_drives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(monkeypatch, "study", "driving", "-o", tmp_path / "out", "--model", tmp_path / "none") == 1
    assert "none: No such file" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_seed_that_no_generator_takes_is_wrong_use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert outcome(monkeypatch, "study", "driving", "-o", tmp_path, "--seed", 2**64) == 2


@pytest.mark.parametrize(
    ("arms", "reason"),
    [
        ("none,dwa,none", "assistant 'none' is given 2 times"),
        ("none,,dwa", "assistant is ''"),
        ("", "assistant is ''"),
    ],
)
def test_study_refuses_assistants_that_are_empty_or_given_twice(
    arms: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(monkeypatch, "study", "driving", "-o", tmp_path / "out", "--assistants", arms) == 1
    said = capsys.readouterr().err
    assert reason in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_study_refuses_a_course_given_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], home_model: Path
) -> None:
    courses = "standard_course,standard_course"
    arguments = ("-o", tmp_path / "out", "--courses", courses, "--model", home_model)
    assert outcome(monkeypatch, "study", "driving", *arguments) == 1
    assert capsys.readouterr().err == "lfdcore: course 'standard' is given 2 times, must be given once\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["model", "model.bin", "model.mcap", "model.yml.old"])
def test_info_knows_a_model_by_what_it_holds(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], home_model: Path
) -> None:
    (tmp_path / name).write_bytes(home_model.read_bytes())
    assert outcome(monkeypatch, "info", tmp_path / name) == 0
    assert "drive assistant model" in capsys.readouterr().out


def test_info_does_not_wait_for_a_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert outcome(monkeypatch, "info", tmp_path / "pipe") == 1
    assert "no regular file" in capsys.readouterr().err


def worker_pids(parent: int) -> list[str]:
    return Path(f"/proc/{parent}/task/{parent}/children").read_text().split()


AT_A_TERMINAL = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job, as a CI may be, ignores it
from lfdcore.cli.main import main
main()
"""


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs Linux's /proc to see the workers")
@pytest.mark.parametrize(
    ("kill", "number", "code", "last"),
    [
        (os.killpg, signal.SIGINT, 130, "lfdcore: interrupted"),
        (os.kill, signal.SIGINT, 130, "lfdcore: interrupted"),
        (os.kill, signal.SIGTERM, 143, None),
        (os.kill, signal.SIGHUP, 129, None),
    ],
    ids=["Ctrl-C at a terminal", "SIGINT to the parent", "SIGTERM to the parent", "SIGHUP to the parent"],
)
def test_a_signal_ends_a_study_and_its_workers_at_once_without_a_traceback(
    kill: Callable[[int, int], None], number: int, code: int, last: str | None, tmp_path: Path, home_model: Path
) -> None:
    arguments = ["study", "driving", "-o", str(tmp_path), "--model", str(home_model), "--processes", "2"]
    arguments += ["--assistants", "none,dwa,primitives"]
    command = [sys.executable, "-c", AT_A_TERMINAL, *arguments]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as study:
        deadline = time.monotonic() + 60
        while len(workers := worker_pids(study.pid)) < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert len(workers) == 2
        kill(study.pid, number)
        try:
            _, said = study.communicate(timeout=20)  # 0.4 s on an idle machine; the study would take a minute or more
        finally:
            study.kill()  # or leaving `with` waits for it
    assert study.returncode == code, said
    assert last is None or said.splitlines()[-1] == last
    assert "Traceback" not in said
    assert "Error" not in said
    assert not [worker for worker in workers if Path(f"/proc/{worker}").exists()]


@pytest.mark.parametrize(
    ("path", "count", "reason"),
    [
        ([[0, 0], [1, 0]], 10**12, r"count is 1e\+12 points, must be between 2 and 1e\+06"),
        ([[0, 0], [1, 0]], 1, "count is 1 points"),
        ([[0, 0], [1, 0]], -5, "count is -5 points"),
        ([[0, 0], [np.nan, 0]], 5, r"path point 1 is \(nan, 0\.0+\) m, must be finite"),
        ([[-1e308, 0], [1e308, 0]], 5, "length of the path is inf m"),
        (np.zeros((0, 2)), 5, "without points"),
    ],
)
def test_no_path_is_resampled_to_what_it_cannot_be(path: list[list[float]], count: int, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        resample(np.array(path, float), count)


@pytest.mark.parametrize(
    ("cells", "shape", "probability", "inverse_temperature", "reason"),
    [
        (
            [[0, 0], [1, 0]],
            (10**6, 10**6),
            0.9,
            0.001,
            r"number of cells is 1e\+12 cells, must be between 1 and 1e\+07",
        ),
        ([[0, 0], [1, 0]], (0, 5), 0.9, 0.001, "grid is 0 x 5 cells"),
        ([[0, 0], [1, 0]], (5, 5), np.nan, 0.001, "probability is nan"),
        ([[0, 0], [1, 0]], (5, 5), 0.9, np.nan, "inverse_temperature is nan"),
        ([[0, 0], [1, 0]], (5, 5), 0.9, 1e-310, "inverse_temperature is -inf reward"),
        ([[0, 0], [-(2**31), 2**31 - 1]], (5, 5), 0.9, 0.001, r"path cell 0 is \(0, 0\)"),
        ([[0, 0], [2**40, 0]], (5, 5), 0.9, 0.001, "beyond 32 bits"),
    ],
)
def test_no_baseline_is_made_of_what_has_no_preference(
    cells: list[list[int]], shape: tuple[int, int], probability: float, inverse_temperature: float, reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        baseline_preference(np.array(cells), shape, probability, inverse_temperature)
