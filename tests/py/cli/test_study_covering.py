"""lfdcore study covering, as a user calls it."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from calling import run
from lfdcore.simulated.covering import BOUNDING_BOX, GROUND_TRUTH, CoveringProtocol, covering_data, write_demonstrations
from lfdcore.study.covering import study as covering
from lfdcore.training.collaborations import NoiseChoice

WORDS = ("study", "covering", "--seeds", "1", "--people", "1", "--seed", "101", "--processes", "1")


FEW = {"demonstrations": 3, "novel": GROUND_TRUTH.novel}

QUICK = NoiseChoice(factors=(100.0, 1e4), folds=2, shares=(0.4,))


@dataclass(frozen=True, kw_only=True)
class QuickStudy(covering.CoveringStudy):
    """Fewer demonstrations and objects, one setting of the curve."""

    dials: tuple[float, ...] = (0.35,)
    protocols: tuple[CoveringProtocol, CoveringProtocol] = (replace(GROUND_TRUTH, **FEW), replace(BOUNDING_BOX, **FEW))
    choice: NoiseChoice = QUICK


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(covering, "CoveringStudy", QuickStudy)


def test_the_command_writes_a_report_and_names_what_repeats_it(quick, monkeypatch, capsys, tmp_path: Path) -> None:
    code, out, _ = run(monkeypatch, capsys, *WORDS, "-o", tmp_path / "new")
    assert code == 0
    assert "Figures to reach" in out
    assert "EaIP 4 of 4 (protocol 5.6.1)" in out
    report = (tmp_path / "new" / "report.html").read_text()
    assert "lfdcore study covering -o out --seeds 1 --people 1 --seed 101" in report
    code, out, _ = run(monkeypatch, capsys, *WORDS, "-o", tmp_path / "new", "--json")
    assert code == 0
    said = json.loads(out)
    assert said["report"].endswith("report.html")
    assert any(aim["figure"].startswith("5.6.2: EaIP covers") for aim in said["aims"])
    assert (tmp_path / "new" / "report.html").read_text() == report


def test_a_study_without_seeds_is_refused(monkeypatch, capsys, tmp_path: Path) -> None:
    code, _, err = run(monkeypatch, capsys, "study", "covering", "-o", tmp_path, "--seeds", "0")
    assert code == 2
    assert "--seeds" in err


def test_its_demonstrations_can_be_learned_from_and_collaborated_with(monkeypatch, capsys, tmp_path: Path) -> None:
    write_demonstrations(tmp_path, covering_data(seed=100, held_out=1))
    demos = sorted(str(path) for path in tmp_path.glob("demo-*.npz"))
    assert len(demos) == 40
    assert len(list(tmp_path.glob("new-*.npz"))) == len(list(tmp_path.glob("new-*.json"))) == 8
    model = tmp_path / "model.safetensors"
    code, _, err = run(monkeypatch, capsys, "learn", "collaboration", *demos[::4], "-o", model)
    assert code == 0, err
    shelf = ["--observe", str(tmp_path / "new-shelf.npz"), "--environment", str(tmp_path / "new-shelf.json")]
    code, out, err = run(monkeypatch, capsys, "collaborate", model, *shelf, "--until", "1.5")
    assert code == 0, err
    assert "followed inside all limits" in out
    assert "BEYOND THE DEMONSTRATIONS: 0.75 to 0.98" in out  # the shelf is higher
    code, out, err = run(monkeypatch, capsys, "collaborate", model, *shelf, "--until", "1.5", "--tool", "3")
    assert code == 1
    assert "cannot follow from sample 0 on: out of reach" in err
    assert "no collision shapes" not in err


def test_one_seed_has_no_intervals_and_says_nothing_of_nan(quick, monkeypatch, capsys, tmp_path: Path) -> None:
    _, out, _ = run(monkeypatch, capsys, *WORDS, "-o", tmp_path)
    assert "nan" not in out
