"""The command line: exit code 2 for wrong use, 1 with one clear line for a failure, 0 and parsable JSON otherwise."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lfdcore
from lfdcore.cli.main import main
from lfdcore.datasets import write_map
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ExpertDriver
from lfdcore.simulated.run import run_drive
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.observation import ChairGeometry

CHAIR = ChairGeometry.thesis()


@dataclass
class Outcome:
    code: int
    out: str
    err: str

    @property
    def last_line(self) -> str:
        return self.err.strip().splitlines()[-1]


Cli = Callable[..., Outcome]


@pytest.fixture
def cli(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Cli:
    """Runs lfdcore with arguments, in this process."""

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["lfdcore", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as stopped:
            main()
        said = capsys.readouterr()
        return Outcome(int(stopped.value.code or 0), said.out, said.err)

    return run


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a drive log, a map, and damaged ones."""
    folder, course = tmp_path_factory.mktemp("cli"), home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), seed=1, log_path=folder / "drive.mcap")
    write_map(course.grid, folder / "home.yaml")
    whole = (folder / "drive.mcap").read_bytes()
    (folder / "garbled.mcap").write_bytes(whole[:1000] + bytes(300) + whole[1300:])
    (folder / "stub.mcap").write_bytes(whole[:50])
    (folder / "killed.mcap").write_bytes(whole[: len(whole) // 2])
    (folder / "text.log").write_text("nothing of a log\n")
    write_map(OccupancyGrid(np.zeros((4, 4), np.int8), 0.05, (0.0, 0.0)), folder / "torn.yaml")
    image = next(folder.glob("torn.p*"))
    image.write_bytes(image.read_bytes()[:12])
    return folder


@pytest.fixture
def model(files: Path, cli: Cli) -> Path:
    path = files / "model.safetensors"
    if not path.exists():
        assert cli("learn", "drive", files / "drive.mcap", "-o", path).code == 0
    return path


def assert_fails_clearly(outcome: Outcome, *words: str) -> None:
    assert outcome.code == 1
    assert outcome.last_line.startswith("lfdcore: ")
    assert "Traceback" not in outcome.err
    for word in words:
        assert word in outcome.last_line


# -- wrong use ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["nonsense"],
        ["info"],
        ["info", "a", "b"],
        ["info", "--nonsense", "a"],
        ["learn"],
        ["learn", "drive", "log.mcap"],
        ["learn", "drive", "log.mcap", "-o", "m.safetensors", "--share", "1.5"],
        ["learn", "drive", "log.mcap", "-o", "m.safetensors", "--preset", "nobody"],
        ["study", "driving"],
        ["study", "driving", "-o", "folder", "--drivers", "0"],
        ["study", "driving", "-o", "folder", "--seed", "-1"],
        ["demo", "--drivers", "none"],
    ],
    ids=" ".join,
)
def test_wrong_use_exits_with_2_and_says_where_help_is(arguments: list[str], cli: Cli) -> None:
    outcome = cli(*arguments)
    assert outcome.code == 2
    assert "Usage" in outcome.err + outcome.out
    assert outcome.out == "" or "Options" in outcome.out  # an empty group shows its help instead


# -- failures -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["nothing.mcap", "nothing.safetensors", "nothing.yaml", "nothing"])
def test_info_on_a_missing_file_names_it(name: str, cli: Cli) -> None:
    assert_fails_clearly(cli("info", name), name, "no such")


@pytest.mark.parametrize("name", ["garbled.mcap", "stub.mcap", "text.log", "torn.yaml"])
def test_info_on_a_damaged_file_names_it(name: str, files: Path, cli: Cli) -> None:
    assert_fails_clearly(cli("info", files / name), name.split(".", maxsplit=1)[0])


def test_info_reads_a_log_whose_recorder_was_killed(files: Path, cli: Cli) -> None:
    outcome = cli("info", files / "killed.mcap")
    assert outcome.code == 0
    assert "incomplete" in outcome.out


def test_info_on_a_garbled_model_names_it(model: Path, tmp_path: Path, cli: Cli) -> None:
    data = model.read_bytes()
    for number, broken in enumerate(
        (b"", data[:7], data[:200], data[:-9], b"{}" + data[2:], data.replace(b"drive", b"drove"))
    ):
        path = tmp_path / f"broken{number}.safetensors"
        path.write_bytes(broken)
        assert_fails_clearly(cli("info", path), path.name)


def test_learn_on_a_missing_log_writes_nothing(tmp_path: Path, cli: Cli) -> None:
    output = tmp_path / "model.safetensors"
    assert_fails_clearly(cli("learn", "drive", tmp_path / "nothing.mcap", "-o", output), "nothing.mcap")
    assert not output.exists()


def test_learn_on_a_share_without_scans_says_what_it_found(files: Path, tmp_path: Path, cli: Cli) -> None:
    output = tmp_path / "model.safetensors"
    assert_fails_clearly(cli("learn", "drive", files / "drive.mcap", "-o", output, "--share", "0"), "scans")
    assert not output.exists()


def test_learn_into_a_missing_folder_names_it(files: Path, tmp_path: Path, cli: Cli) -> None:
    output = tmp_path / "nowhere" / "model.safetensors"
    assert_fails_clearly(cli("learn", "drive", files / "drive.mcap", "-o", output), "nowhere")


def test_study_refuses_an_unknown_course_and_names_the_known_ones(tmp_path: Path, cli: Cli) -> None:
    outcome = cli("study", "driving", "-o", tmp_path, "--courses", "atlantis")
    assert_fails_clearly(outcome, "atlantis", "standard_course")


def test_study_refuses_an_unknown_assistant_and_names_the_known_ones(model: Path, tmp_path: Path, cli: Cli) -> None:
    arguments = ("--courses", "flat", "--drivers", 1, "--processes", 1, "--model", model)
    outcome = cli("study", "driving", "-o", tmp_path, "--assistants", "telepathy", *arguments)
    assert_fails_clearly(outcome, "telepathy", "primitives")


def test_study_refuses_a_missing_model(tmp_path: Path, cli: Cli) -> None:
    arguments = ("--courses", "flat", "--drivers", 1, "--processes", 1, "--assistants", "none,primitives")
    outcome = cli("study", "driving", "-o", tmp_path, "--model", tmp_path / "nothing.safetensors", *arguments)
    assert_fails_clearly(outcome, "nothing.safetensors")


# -- what works -----------------------------------------------------------------------------------------------------


def facts(outcome: Outcome) -> dict[str, Any]:
    assert outcome.code == 0, outcome.err
    read: dict[str, Any] = json.loads(outcome.out, parse_constant=not_json)
    return read


def not_json(name: str) -> None:
    pytest.fail(f"{name} is not JSON")


def test_info_tells_a_log_a_model_and_a_map_apart(files: Path, model: Path, cli: Cli) -> None:
    log = facts(cli("info", files / "drive.mcap", "--json"))
    learned = facts(cli("info", model, "--json"))
    grid = facts(cli("info", files / "home.yaml", "--json"))
    assert [log["kind"], learned["kind"], grid["kind"]] == ["drive log", "drive assistant model", "occupancy grid map"]
    assert log["scans"]["beams"] == 181
    assert log["wrong"] == []
    assert learned["n_paths"] > 100
    assert learned["bytes"] > 1000
    assert grid["resolution [m]"] == 0.05


def test_convert_writes_a_drive_log_and_replaces_nothing_unasked(files: Path, tmp_path: Path, cli: Cli) -> None:
    out = tmp_path / "drive.mcap"
    done = cli("convert", files / "drive.mcap", out, "--mounting", ".5,0,90")
    assert done.code == 0
    converted = facts(cli("info", out, "--json"))
    assert converted["scanner at"] == {"x [m]": 0.5, "y [m]": 0.0, "yaw [deg]": 90.0, "upside down": False}
    assert cli("convert", files / "drive.mcap", out, "--force").code == 0
    for words, why in (
        (("convert", files / "drive.mcap", out), "--force"),
        (("convert", out, out, "--force"), "is read"),
        (("convert", out, tmp_path / "x.bag"), "must end in .mcap"),
        (("info", out, "--scan", "/scan"), "are for bags"),
        (("info", out, "--mounting", "1,2"), "--mounting"),
    ):
        refused = cli(*words)
        assert refused.code == 2
        assert why in " ".join(refused.err.replace("│", " ").split())


def test_info_for_people_has_the_same_facts(files: Path, cli: Cli) -> None:
    outcome = cli("info", files / "drive.mcap")
    assert outcome.code == 0
    for name in facts(cli("info", files / "drive.mcap", "--json")).keys() - {"wrong", "noted"}:
        assert name in outcome.out


def test_learn_gives_the_same_bytes_twice_and_another_model_with_the_preset(
    files: Path, model: Path, tmp_path: Path, cli: Cli
) -> None:
    again, printed = tmp_path / "again.safetensors", tmp_path / "printed.safetensors"
    said = facts(cli("learn", "drive", files / "drive.mcap", "-o", again, "--json"))
    assert said["model"] == str(again)
    assert again.read_bytes() == model.read_bytes()
    assert cli("learn", "drive", files / "drive.mcap", "-o", printed, "--preset", "thesis").code == 0
    assert printed.read_bytes() != model.read_bytes()


def test_study_driving_writes_a_report_and_json(model: Path, tmp_path: Path, cli: Cli) -> None:
    arguments = ("--courses", "flat", "--assistants", "none,dwa", "--drivers", 1, "--processes", 1, "--model", model)
    said = facts(cli("study", "driving", "-o", tmp_path, "--json", *arguments))
    report = Path(said["report"]).read_text()
    assert report.startswith("<!")
    assert f"lfdcore {lfdcore.__version__}, seed 1" in report
    assert "--courses flat --assistants none,dwa --drivers 1 --task-starts 20 --seed 1" in report
    of_courses = [row for row in said["rows"] if "course" in row]
    assert [row["assistant"] for row in of_courses] == ["none", "dwa"]
    assert all(row["time"] > 10 for row in of_courses)


def test_progress_goes_to_standard_error_only(files: Path, tmp_path: Path, cli: Cli) -> None:
    outcome = cli("learn", "drive", files / "drive.mcap", "-o", tmp_path / "m.safetensors", "--json")
    json.loads(outcome.out)
    assert "learning" in outcome.err


def test_version_is_the_package_s(cli: Cli) -> None:
    assert cli("--version").out.strip() == lfdcore.__version__


@pytest.mark.parametrize(
    "command",
    [
        [],
        ["demo"],
        ["info"],
        ["learn"],
        ["learn", "drive"],
        ["predict"],
        ["study"],
        ["study", "driving"],
        ["study", "learning-curve"],
        ["study", "adaptation"],
        ["study", "backwards"],
    ],
)
def test_every_command_has_help(command: list[str], cli: Cli) -> None:
    outcome = cli(*command, "--help")
    assert outcome.code == 0
    assert "Usage" in outcome.out


def test_the_command_line_starts_without_scipy_matplotlib_or_opencv() -> None:
    code = "import sys, lfdcore.cli.main; print(sorted({'scipy', 'matplotlib', 'cv2', 'rosbags'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_failure_of_the_installed_command_exits_with_1() -> None:
    installed = shutil.which("lfdcore", path=str(Path(sys.executable).parent))
    command = [installed] if installed else [sys.executable, "-m", "lfdcore"]
    done = subprocess.run([*command, "info", "nothing.mcap"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "lfdcore: nothing.mcap: no such file\n"
