"""lfdcore demo and make demo: with the models of the package neither needs what only training needs."""

import json
import os
import subprocess
import sys
from importlib.abc import MetaPathFinder
from pathlib import Path

import pytest

from calling import run
from lfdcore.datasets import open_log
from lfdcore.simulated.courses import course_by_name
from lfdcore.study import arms, demonstrations
from lfdcore.study.demo import demo_study
from lfdcore.study.demonstrations import demonstrate_in_mazes, drive_to_destinations
from lfdcore.study.heatmaps import report
from lfdcore.study.report import page

ROOT = Path(__file__).parents[3]
FOR_TRAINING_ALONE = ("torch", "onnx", "sklearn")


@pytest.fixture
def short(monkeypatch) -> None:
    """A short course; 2 drives instead of 72 through the mazes, of which one is held out; 2 instead of 30 through the
    home; pictures that are made, but not drawn."""

    def mazes(folder, seed, progress):
        return demonstrate_in_mazes(folder, seed, runs=2, progress=progress)

    def homes(folder, seed, progress):
        return drive_to_destinations(folder, seed, runs=2, progress=progress)

    monkeypatch.setattr(arms, "course_by_name", lambda name, seed: course_by_name("flat", seed))
    monkeypatch.setattr(demonstrations, "demonstrate_in_mazes", mazes)
    monkeypatch.setattr(report, "drive_to_destinations", homes)
    monkeypatch.setattr(page, "png", lambda figure: b"")
    monkeypatch.setattr(report, "held_out_logs", lambda model, paths: [open_log(paths[0])])


class NotInstalled(MetaPathFinder):
    """Finds nothing of what the extra 'train' alone brings. (A None in sys.modules would not do: scipy looks there for
    torch.)"""

    def find_spec(self, name, path=None, target=None) -> None:
        if name.split(".")[0] in FOR_TRAINING_ALONE:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


@pytest.fixture
def without_training(monkeypatch) -> None:
    """As if the extra 'train' were not installed, nor any real log at hand."""
    for name in list(sys.modules):
        if name.split(".")[0] in FOR_TRAINING_ALONE or name.startswith("lfdcore.training."):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [NotInstalled(), *sys.meta_path])
    monkeypatch.delenv("LFDCORE_DATA", raising=False)


def test_the_demo_shows_all_its_parts_without_the_training_extra(
    short, without_training, tmp_path, monkeypatch, capsys
) -> None:
    words = ("demo", "-o", tmp_path, "--drivers", 1, "--task-starts", 0, "--seed", 2)
    code, out, err = run(monkeypatch, capsys, *words)
    assert code == 0, err
    assert "Table 4.1" in out
    rows = json.loads((tmp_path / "figures.json").read_text())["rows"]
    assert [row["assistant"] for row in rows] == ["none", "dwa", "primitives", "heatmaps"]
    assert {row["course"] for row in rows} == {"flat"}
    written = (tmp_path / "report.html").read_text()
    titles = ("Driving", "Where the models come from", "From demonstrations to a path")
    titles += ("From a scan and a stick to a path, by heatmaps", "What the methods predict, a posteriori (Sec. 4.6.2)")
    titles += ("What heat is worth as a probability", "Prediction along a real log")
    assert [title for title in titles if f"<h2>{title}</h2>" not in written] == []
    assert "learned from demonstrations of seed 1" in written
    assert "lfdcore demo --drivers 1 --task-starts 0 --seed 2</code>" in written


@pytest.mark.parametrize("train", [False, True])
def test_the_demo_says_the_command_that_repeats_it(train) -> None:
    words = demo_study(3, 0, 2, train=train).command().split()
    assert words == [*["lfdcore", "demo", "--drivers", "3", "--task-starts", "0", "--seed", "2"], *["--train"] * train]


def test_a_demo_that_trains_says_which_extra_is_missing(short, without_training, tmp_path, monkeypatch, capsys) -> None:
    words = ("demo", "-o", tmp_path, "--train", "--drivers", 1, "--task-starts", 0)
    code, _, err = run(monkeypatch, capsys, *words)
    assert code == 1
    assert "extra 'train'" in err


def recipe(*words: str) -> str:
    """What make would run in a checkout where nothing is installed yet."""
    settings = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "TRAIN")}
    command = ["make", "--dry-run", "VENV=nowhere", *words]
    return subprocess.run(command, cwd=ROOT, env=settings, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("words", [("demo",), ("demo", "TRAIN=0")], ids=" ".join)
def test_make_demo_installs_no_torch(words: tuple[str, ...]) -> None:
    done = recipe(*words)
    assert "'.[study]'" in done
    assert "torch" not in done and "train" not in done


@pytest.mark.parametrize("words", [("demo", "TRAIN=1"), ("models",), ("test",)], ids=" ".join)
def test_make_installs_torch_where_models_are_trained(words: tuple[str, ...]) -> None:
    assert "torch==" in recipe(*words)
    assert ("lfdcore demo --output demo --train" in recipe(*words)) == (words[0] == "demo")
