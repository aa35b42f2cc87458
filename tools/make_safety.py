"""Makes the table of docs/safety.md from the tests' own markers: hazard -> requirement -> test -> count.

python tools/make_safety.py writes it; with --check it writes nothing and fails where it is out of date. A test says
what it is evidence for by @pytest.mark.hazard(hazard, requirement), and by each=WHAT what each of its cases counts. In
a gtest's file it is a comment above the TEST:
// hazard: HAZARD | requirement: REQUIREMENT | count: WHAT
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import redirect_stdout
from pathlib import Path
from typing import NamedTuple

import pytest
from made_part import ROOT, renew

GTEST = re.compile(
    r"// hazard: (?P<hazard>[^|\n]+) \| requirement:\s(?P<requirement>(?:[^|]|\|w\||\|stick\|)+?)\s(?:// )?\| "
    r"count: (?P<count>[^\n]+)\n"
    r"TEST\((?P<suite>\w+), (?P<name>\w+)\)"
)


class Evidence(NamedTuple):
    """A test and what it is evidence for."""

    hazard: str
    requirement: str
    test: str
    count: str


class _Marked:
    """Collects the marked tests of a pytest session."""

    def __init__(self) -> None:
        self.cases: Counter[tuple[str, str, str, str]] = Counter()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            for mark in item.iter_markers("hazard"):
                hazard, requirement = mark.args
                path = item.path.relative_to(ROOT).as_posix()
                name = getattr(item, "originalname", item.name)
                self.cases[hazard, requirement, f"[{name}](../{path})", mark.kwargs.get("each", "")] += 1


def from_pytest() -> list[Evidence]:
    """The marked tests of tests/py, with how many cases each has."""
    files = [str(path) for path in sorted((ROOT / "tests/py").rglob("test_*.py")) if "mark.hazard" in path.read_text()]
    marked = _Marked()
    said = io.StringIO()
    with redirect_stdout(said):
        code = pytest.main(["--collect-only", "-q", "-p", "no:cacheprovider", *files], plugins=[marked])
    if code != 0:
        raise ValueError(f"pytest cannot collect: {said.getvalue()}")
    return [Evidence(*about, _cases(n, each)) for (*about, each), n in marked.cases.items()]


def _cases(count: int, each: str) -> str:
    cases = "1 case" if count == 1 else f"{count} cases"
    return f"{cases} of {each}" if each else cases


def from_gtests() -> Iterator[Evidence]:
    """The gtests that a comment marks."""
    for path in sorted((ROOT / "tests/cpp").rglob("*_test.cpp")):
        for found in GTEST.finditer(path.read_text()):
            link = f"[{found['suite']}.{found['name']}](../{path.relative_to(ROOT).as_posix()})"
            yield Evidence(found["hazard"], _one_line(found["requirement"]), link, found["count"])


def _one_line(comment: str) -> str:
    return " ".join(comment.replace("//", " ").split()).replace("|", "\\|")


def table() -> str:
    """All evidence, hazard by hazard in the order of their names."""
    evidence = sorted([*from_pytest(), *from_gtests()])
    rows = [f"| {' | '.join(one)} |" for one in evidence]
    return "\n".join(["| hazard | requirement | test | count |", "|---|---|---|---|", *rows])


if __name__ == "__main__":
    renew("safety.md", Path(__file__).name, table())
