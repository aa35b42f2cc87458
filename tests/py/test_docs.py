"""The docs say what is there: modules, files, sources' references, code that runs."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import my_robot
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ExpertDriver
from lfdcore.simulated.run import run_drive
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.observation import ChairGeometry

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
SUFFIXES = {".cpp", ".hpp", ".py", ".pyi", ".md"}
SOURCES = sorted(
    p for folder in ("cpp", "python", "tests", "docs") for p in (ROOT / folder).rglob("*") if p.suffix in SUFFIXES
)
CHAIR = ChairGeometry.thesis()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)", page.read_text()):
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), f"{page.name} links to {target}"
        if anchor:
            titles = re.findall(r"^#+ (.+)$", file.read_text(), flags=re.MULTILINE)
            slugs = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert anchor in slugs, f"{page.name} links to {target}#{anchor}"


def test_the_tables_of_architecture_are_those_that_the_tool_makes() -> None:
    tool = ROOT / "tools" / "make_architecture.py"
    made = subprocess.run([sys.executable, str(tool), "--check"], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_of_ours_that_a_page_names_is_there(page: Path) -> None:
    stages = "|".join(sorted(p.parent.name for p in (ROOT / "python" / "lfdcore").glob("[!_]*/__init__.py")))
    for path in re.findall(rf"(?<![\w/])((?:{stages})/[\w/]+(?:\.py)?)(?![\w/])", page.read_text()):
        named = ROOT / "python" / "lfdcore" / path.removesuffix(".py")
        header = ROOT / "cpp" / "include" / "lfdcore" / path
        there = named.is_dir() or named.with_suffix(".py").exists() or header.with_suffix(".hpp").exists()
        assert there, f"{page.name} names {path}"


def test_every_erratum_and_choice_that_sources_cite_is_explained() -> None:
    decisions = (ROOT / "docs" / "decisions.md").read_text()
    explained = set(re.findall(r"^\| (F?\d+) \|", decisions, flags=re.MULTILINE))
    cited = set()
    for path in SOURCES:
        for several in re.findall(r"ERRATA ((?:F?\d+(?:, | and |-)?)+)", path.read_text()):
            cited |= set(re.findall(r"F?\d+", several))
    assert cited
    assert not cited - explained, f"cited but not in decisions.md: {sorted(cited - explained)}"


def test_the_code_of_bring_your_own_log_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    course = home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), seed=1, log_path=tmp_path / "drive.mcap")
    text = (ROOT / "docs" / "bring-your-own-log.md").read_text()
    code = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)[0]
    opened = 'open_log("drive.bag", scan="/front/scan", T_base_laser=Pose2(0.7, 0, 0))'
    assert opened in code  # the options belong to bags
    names: dict[str, object] = {}
    exec(code.replace(opened, 'open_log("drive.mcap")'), names)
    assert (tmp_path / "mine.safetensors").exists()
    assert getattr(names["path"], "shape", None) == (26, 2)


def test_the_loop_without_ros_runs_and_moves_a_chair() -> None:
    text = (ROOT / "docs" / "on-your-robot.md").read_text()
    code = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)[0]
    assert len([line for line in code.split("\n") if line and "import" not in line]) <= 32
    names: dict[str, object] = {}
    exec(code, names)
    assert my_robot.way() > 0.3
    assert my_robot.given[-1] == (0.0, 0.0)
