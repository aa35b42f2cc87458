"""The docs say what is there: modules, files, sources' references, code that runs."""

import re
from pathlib import Path

import pytest

from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ExpertDriver
from lfdcore.simulated.run import run_drive
from lfdcore.wheelchair.assistants import Unassisted

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
SUFFIXES = {".cpp", ".hpp", ".py", ".pyi", ".md"}
SOURCES = sorted(
    p for folder in ("cpp", "python", "tests", "docs") for p in (ROOT / folder).rglob("*") if p.suffix in SUFFIXES
)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]+))?\)", page.read_text()):
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), f"{page.name} links to {target}"
        if anchor:
            titles = re.findall(r"^#+ (.+)$", file.read_text(), flags=re.MULTILINE)
            slugs = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert anchor in slugs, f"{page.name} links to {target}#{anchor}"


def test_architecture_names_every_module_and_no_other() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text()
    package, headers = ROOT / "python" / "lfdcore", ROOT / "cpp" / "include" / "lfdcore"
    stages = ("datasets", "wheelchair", "humanoid", "training", "study")
    modules = [p for stage in stages for p in (package / stage).glob("[!_]*.py")]
    named = set(re.findall(r"[\w/]+", "".join(re.findall(r"^\| (`.*?) \|", text, flags=re.MULTILINE))))
    ends = {name.split("/")[-1] for name in named}
    there = {p.stem for p in modules} | {p.stem for p in headers.rglob("*.hpp")}
    assert not there - ends, f"not in architecture.md: {sorted(there - ends)}"
    folders = {p.name for p in package.iterdir()} | {p.name for p in headers.iterdir()} | {"courses", ""}
    layers = {"vocabulary", "bindings", "facades", "C", "Python", "python", "lfdcore", "errors"}
    gone = ends - there - folders - layers
    assert not gone, f"architecture.md names {sorted(gone)}, which are not there"


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
    run_drive(course, ExpertDriver(course), Unassisted(), seed=1, log_path=tmp_path / "drive.mcap")
    text = (ROOT / "docs" / "bring-your-own-log.md").read_text()
    code = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)[0]
    opened = 'open_log("drive.bag", scan="/front/scan", T_base_laser=Pose2(0.7, 0, 0))'
    assert opened in code  # the options belong to bags
    names: dict[str, object] = {}
    exec(code.replace(opened, 'open_log("drive.mcap")'), names)
    assert (tmp_path / "mine.safetensors").exists()
    assert getattr(names["path"], "shape", None) == (26, 2)
