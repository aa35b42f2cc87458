"""Makes the tables of docs/architecture.md from the first sentence of every header and module, in the order of folders.

python tools/make_architecture.py writes them; with --check it writes nothing and fails where they are out of date.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable
from pathlib import Path

from made_part import ROOT, renew

HEADERS, PACKAGE = ROOT / "cpp" / "include" / "lfdcore", ROOT / "python" / "lfdcore"
CPP = ("", "grid", "simulation", "hardware", "planning", "control", "estimation", "primitives", "kinematics")
PYTHON = (
    "",
    "models",
    "datasets",
    "wheelchair",
    "humanoid",
    "simulated",
    "ros",
    "training",
    "pictures",
    "study",
    "cli",
)
"""Folders from the bottom up; '' are the files beside them. A folder that is not here is an error."""
ABBREVIATIONS = ("App", "Sec", "Fig", "Alg", "Eq", "Ch", "cf")
"""Their full stop ends no sentence."""


def first_sentence(text: str) -> str:
    """Of a comment or docstring: its first paragraph up to the first full stop that ends a sentence."""
    paragraph = " ".join(text.strip().split("\n\n")[0].split())
    no_abbreviation = "".join(rf"(?<!\b{word})" for word in ABBREVIATIONS)
    end = re.search(rf"{no_abbreviation}[.]\s+(?=[A-Z])", paragraph)
    return paragraph[: end.start() if end else None].rstrip(".")


def said_by_header(path: Path) -> str:
    """The comment that a header begins with."""
    lines = path.read_text().split("\n")
    comment = [line[2:].strip() for line in lines[: next(k for k, line in enumerate(lines) if line[:2] != "//")]]
    return first_sentence(" ".join(comment))


def said_by_module(path: Path) -> str:
    """The docstring that a module begins with."""
    return first_sentence(ast.get_docstring(ast.parse(path.read_text())) or "")


def row(base: Path, path: Path, said: str) -> str:
    """One line of a table. ValueError for a file that says nothing of itself."""
    name = path.relative_to(base).with_suffix("").as_posix().removesuffix("/__init__")
    if not said:
        raise ValueError(f"{path.relative_to(ROOT)} does not begin with a sentence that says what it holds")
    escaped = said.replace("|", "\\|")
    return f"| `{name}` | {escaped} |"


def in_order(base: Path, folders: Iterable[str], suffix: str) -> list[Path]:
    """Files folder by folder, a folder's before its subfolders'. ValueError for a folder that is in none of `folders`.

    A package with nothing but its __init__ is listed as that.
    """
    known = {folder for folder in folders if folder}
    there = {p.parent.name for p in base.glob(f"*/*{suffix}") if not p.parent.name.startswith("_")}
    if there != known:
        raise ValueError(f"folders in {base.relative_to(ROOT)} are {sorted(there)}, named are {sorted(known)}")
    files = []
    for folder in folders:
        found = list(base.glob(f"*{suffix}") if not folder else (base / folder).rglob(f"*{suffix}"))
        shown = [p for p in found if p.name[0] != "_"] or [p for p in found if p.name == "__init__.py"]
        files += sorted(shown, key=lambda p: (len(p.parts), p))
    return files


def table(title: str, rows: Iterable[str]) -> str:
    """A table of two columns."""
    return "\n".join([f"| {title} | what it holds |", "|---|---|", *rows])


def tables() -> str:
    """Both tables, C++ first."""
    cpp = [row(HEADERS, path, said_by_header(path)) for path in in_order(HEADERS, CPP, ".hpp")]
    python = [row(PACKAGE, path, said_by_module(path)) for path in in_order(PACKAGE, PYTHON, ".py")]
    return "\n\n".join([table("C++", cpp), table("Python (`python/lfdcore/`)", python)])


if __name__ == "__main__":
    renew("architecture.md", Path(__file__).name, tables())
