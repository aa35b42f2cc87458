"""The examples run, and say what the README says they do."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ExpertDriver
from lfdcore.simulated.run import run_drive
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.observation import ChairGeometry

CHAIR = ChairGeometry.thesis()

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded drive of the expert through the simulated home."""
    path = tmp_path_factory.mktemp("drive") / "home.mcap"
    course = home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), seed=1, log_path=path)
    return path


def output_of(name: str, *arguments: object, folder: Path | None = None) -> list[str]:
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_ten_lines_assist_along_a_recorded_drive(drive: Path) -> None:
    lines = output_of("ten_lines.py", drive)
    on_path = [line for line in lines if re.search(r" s  path +Twist2\(.*goal \(", line)]
    assert len(lines) > 100
    assert len(on_path) > len(lines) / 2


def test_the_readme_shows_the_dozen_lines_as_they_are() -> None:
    source = (EXAMPLES / "ten_lines.py").read_text()
    code = source.split('"""')[2].strip()
    assert code in (ROOT / "README.md").read_text()
    assert len([line for line in code.splitlines() if line]) <= 12


def test_drive_a_course_prints_a_row_for_each_assistant() -> None:
    rows = output_of("drive_a_course.py", 1)
    assert [row.split()[0] for row in rows] == ["none", "dwa", "primitives"]
    assert all(re.search(r"\d contacts  angular jerk \d", row) for row in rows)


def test_the_ways_with_and_without_help_are_drawn_side_by_side(tmp_path: Path) -> None:
    rows = output_of("draw_assisted.py", 1, folder=tmp_path)
    assert [row.split(":")[0] for row in rows] == ["Without help", "With help"]
    assert all(row.endswith("1 of 1 completed") for row in rows)
    assert (tmp_path / "assisted.png").read_bytes()[:4] == b"\x89PNG"


def test_a_drive_among_people_tells_contacts_with_them_from_those_with_walls(tmp_path: Path) -> None:
    rows = output_of("drive_among_people.py", 1, folder=tmp_path)
    assert [row.split()[0] for row in rows] == ["none", "supervisor"]
    assert all(re.search(r"\d contacts with walls  \d+ with people: \d+ by the moving nose", row) for row in rows)
    assert (tmp_path / "people.png").read_bytes()[:4] == b"\x89PNG"


def test_predict_a_log_compares_with_both_baselines(drive: Path) -> None:
    head, *rows = output_of("predict_a_log.py", drive)
    assert re.match(r"[1-9]\d* samples", head)
    assert [row[:14].strip() for row in rows] == ["learned", "constant arc", "straight on"]
    assert all(len(row[14:].split()) == 6 and float(row[14:].split()[0]) > 0 for row in rows)


def test_each_heatmap_of_a_scan_is_a_call_and_a_plot(heatmap_model: Path, drive: Path, tmp_path: Path) -> None:
    (line,) = output_of("heatmaps_of_a_scan.py", heatmap_model, drive, 10, folder=tmp_path)
    assert re.search(r"at 1\d\.\d s, stick at -?\d+ degrees, taken to mean -?\d+", line)
    assert (tmp_path / "heatmaps.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.realdata
def test_predict_a_log_reads_a_real_one(data_folder: Path) -> None:
    head, *rows = output_of("predict_a_log.py", data_folder / "logs" / "freiburg-079-corrected.log.gz")
    assert head.startswith("768 samples")
    assert len(rows) == 3


def test_every_example_is_run_here() -> None:
    ran = re.findall(r'output_of\("(\w+\.py)"', Path(__file__).read_text())
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(ran)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_an_example_says_how_to_call_it(path: Path) -> None:
    assert f"python examples/{path.name}" in (ast.get_docstring(ast.parse(path.read_text())) or "")
