"""Moving code moves no figure: every study, at a small size, gives the figures that are committed in figures/.

A file holds a study's options and the rows that the code at `commit` gave. Columns may be added; each number that stood
there must stand there still. Most take a minute or more: `make figures` runs all, the test suite runs the quick ones.
"""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from lfdcore.models import HEATMAPS, PRIMITIVES
from lfdcore.progress import silent
from lfdcore.study import demo
from lfdcore.study.catalogue import load_study
from lfdcore.study.compare import compare
from lfdcore.study.study import as_document

FOLDER = Path(__file__).parent / "figures"
QUICK = {"passing", "sequences"}
CASES = [
    pytest.param(file, id=file.stem, marks=() if file.stem in QUICK else pytest.mark.figures)
    for file in sorted(FOLDER.glob("*.json"))
]
RELATIVE, ABSOLUTE = 1e-9, 1e-12
"""Rounding that another order of the same sums makes, and what zero may become by it."""
PLACES = {"PRIMITIVES": PRIMITIVES, "HEATMAPS": HEATMAPS}


def given(value: Any) -> Any:
    """An option as the config has it: files are named after what holds them."""
    if isinstance(value, list):
        return tuple(given(one) for one in value)
    if isinstance(value, str) and value.startswith("$LFDCORE_DATA"):
        return Path(os.environ["LFDCORE_DATA"]) / value.removeprefix("$LFDCORE_DATA/")
    return PLACES.get(value, value) if isinstance(value, str) else value


def rows_of(recorded: dict[str, Any], folder: Path) -> list[dict[str, Any]]:
    """What the study gives now, in JSON values."""
    options = {name: given(value) for name, value in recorded["options"].items()}
    if recorded["study"] == "demo":
        study, run = demo.demo_study(**options), demo.run
    else:
        config, run = load_study(recorded["study"])
        study = config(**options)
    document = json.loads(json.dumps(as_document(study, run(study, folder, silent))))
    assert isinstance(document["rows"], list)
    assert all(list(one.first) == list(one.second) for one in compare(document, document))  # keys tell rows apart
    return [*document["rows"], *({"aim": aim["figure"], "found": aim["found"]} for aim in document["aims"])]


def same(old: Any, new: Any) -> bool:
    """Whether a number, or each of a list, is the one recorded."""
    if isinstance(old, list):
        return len(old) == len(new) and all(map(same, old, new))
    if isinstance(old, float | int) and not isinstance(old, bool):
        return new is not None and new == pytest.approx(old, rel=RELATIVE, abs=ABSOLUTE)
    return bool(old == new)


@pytest.mark.parametrize("file", CASES)
def test_every_recorded_figure_stands(file: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    recorded = json.loads(file.read_text())
    if "$LFDCORE_DATA" in json.dumps(recorded["options"]):
        request.getfixturevalue("data_folder")
    now = rows_of(recorded, tmp_path)
    for number, old in enumerate(recorded["rows"]):
        new = now[number]
        moved = {name: (value, new.get(name)) for name, value in old.items() if not same(value, new.get(name))}
        assert not moved, f"row {number} of {file.stem}: {moved}"
    aims = {row["aim"]: row["found"] for row in now if "aim" in row}
    for label, found in recorded.get("aims", {}).items():
        assert same(found, aims[label]), f"{label}: {aims[label]}, recorded {found}"


def test_a_figure_that_moved_is_seen() -> None:
    assert same(1.0, 1.0 + 1e-12) and same([1, None], [1, None])
    assert not same(1.0, 1.0 + 1e-6) and not same(1.0, None) and not same([1.0], [1.0, 2.0])
