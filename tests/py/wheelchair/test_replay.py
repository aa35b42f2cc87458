"""An assistant sees only scan, odometry and joystick: its recorded drive gives the same commands without the world."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lfdcore
from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.simulated.courses import flat
from lfdcore.simulated.drivers import ImpairedDriver
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels, make_assistant
from lfdcore.wheelchair.observation import observations

SECONDS = 30.0
REPLAY = Path(__file__).parents[1] / "helpers" / "replay_log.py"


@pytest.fixture(scope="module")
def drive(home_model: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, DriveTrace]:
    course = flat()
    config = RunConfig(slowest=course.length / SECONDS)  # too little time for the whole course
    path = tmp_path_factory.mktemp("replay") / "drive.mcap"
    assistant = make_assistant("primitives", StudyModels(primitives=home_model), config)
    trace = run_drive(course, ImpairedDriver(course), assistant, 3, config, path)
    return path, trace


def replay(model: Path, log: Path) -> list[list[str]]:
    """The rows that replay_log.py prints."""
    package = str(Path(lfdcore.__file__).parent.parent)
    command = [sys.executable, str(REPLAY), str(model), str(log)]
    done = subprocess.run(
        command, check=False, capture_output=True, text=True, timeout=120, env={"PYTHONPATH": package}
    )
    assert done.returncode == 0, done.stderr
    return [line.split() for line in done.stdout.splitlines()]


def test_another_process_without_the_world_gives_the_recorded_commands(
    home_model: Path, drive: tuple[Path, DriveTrace]
) -> None:
    path, trace = drive
    log, rows = open_log(path), replay(home_model, path)
    assert trace.outcome == "time_out" and len(rows) == len(log.command) == len(trace.stamp) > 10 * SECONDS
    assert np.allclose([float(row[0]) for row in rows], log.command_stamp, rtol=0, atol=1e-9)
    commands = np.array([[float(row[1]), float(row[2])] for row in rows])
    np.testing.assert_allclose(commands, log.command, rtol=0, atol=1e-9)  # headings return to 1e-15 only
    assert [row[3] for row in rows] == trace.mode.tolist()
    planned_at = [float(row[0]) for row in rows if row[4] == "True"]
    assert len(planned_at) > 10 and planned_at == [plan.stamp for plan in log.plans]


def test_the_recorded_drive_moved_was_assisted_and_supervised(drive: tuple[Path, DriveTrace]) -> None:
    _, trace = drive
    assert "path" in trace.mode and trace.supervised.any()
    assert np.hypot(*np.diff(trace.pose[:, :2], axis=0).T).sum() > 5


def test_a_log_without_its_commands_plans_and_intentions_replays_the_same(
    home_model: Path, drive: tuple[Path, DriveTrace], tmp_path: Path
) -> None:
    """What the assistant once said is not among what it hears."""
    log = open_log(drive[0]).slice(0, 5)
    bare = {name: getattr(log, name) for name in ("scan_stamp", "ranges", "angle_min", "angle_increment", "range_max")}
    bare |= {name: getattr(log, name) for name in ("odometry_stamp", "pose", "twist", "joystick_stamp", "joystick")}
    path = tmp_path / "bare.mcap"
    DriveLog(**bare, T_base_laser=log.T_base_laser).save(path)
    commands = np.array([[float(row[1]), float(row[2])] for row in replay(home_model, path)])
    np.testing.assert_allclose(commands, log.command, rtol=0, atol=1e-9)


def test_observations_hold_the_last_odometry_and_joystick_and_skip_scans_before_them() -> None:
    log = DriveLog(
        scan_stamp=np.array([0.0, 1.0, 2.0, 3.0]),
        ranges=np.ones((4, 3), np.float32),
        odometry_stamp=np.array([0.5, 1.5]),
        pose=np.array([[1.0, 0, 0], [2.0, 0, 0]]),
        twist=np.array([[0.1, 0], [0.2, 0]]),
        joystick_stamp=np.array([1.0, 2.5]),
        joystick=np.array([[0.5, 0], [-0.5, 0]]),
    )
    seen = list(observations(log))
    assert [o.stamp for o in seen] == [1.0, 2.0, 3.0]
    assert [o.pose.x for o in seen] == [1.0, 2.0, 2.0]
    assert [o.joystick[0] for o in seen] == [0.5, 0.5, -0.5]


@pytest.mark.parametrize("missing", ["odometry", "joystick"])
def test_a_log_without_odometry_or_joystick_is_refused_by_name(missing: str) -> None:
    fields = {
        "odometry_stamp": np.zeros(1),
        "pose": np.zeros((1, 3)),
        "twist": np.zeros((1, 2)),
        "joystick_stamp": np.zeros(1),
        "joystick": np.zeros((1, 2)),
    }
    gone = {"odometry": ("odometry_stamp", "pose", "twist"), "joystick": ("joystick_stamp", "joystick")}[missing]
    log = DriveLog(
        scan_stamp=np.zeros(1),
        ranges=np.ones((1, 3), np.float32),
        **{name: value for name, value in fields.items() if name not in gone},
    )
    with pytest.raises(ValueError, match=missing):
        list(observations(log))
