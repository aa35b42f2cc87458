"""lfdcore study adaptation, backwards and learning-curve, as a user calls them."""

import json
from pathlib import Path

import pytest

from calling import run
from lfdcore.cli.common import Stages, progress_bar
from lfdcore.study.demonstrations import heatmaps_or_learned


def test_adaptation_gives_a_row_a_bias_a_picture_and_what_repeats_it(heatmap_model, tmp_path, monkeypatch, capsys):
    words = ["--model", heatmap_model, "--courses", "flat", "--drivers", 1, "--processes", 1, "--seed", 2, "--json"]
    code, out, err = run(monkeypatch, capsys, "study", "adaptation", "-o", tmp_path / "new", *words)
    assert code == 0, err
    found = json.loads(out)
    biases = [row for row in found["rows"] if "wanted" in row]
    assert [row["bias"] for row in biases] == [-0.3, 0.0, 0.3]
    assert [row["wanted"] for row in biases] == [0.7, 1.05, 0.7]
    (row,) = [row for row in found["rows"] if row["bias"] == 0.3 and row not in biases]
    assert biases[2]["ratio_then"] == pytest.approx(row["then"] / row["before"])
    assert found["aims"][4]["found"] == biases[2]["ratio_then"]
    assert row["seed"] == 2 and row["course"] == "flat" and row["before"] > 0.2
    report = Path(found["report"]).read_text()
    assert f"lfdcore study adaptation -o out --model {heatmap_model.name} --courses flat --drivers 1 --seed 2" in report
    assert report.count("data:image/png") == 1 and "&le; 0.7<" in report
    assert (tmp_path / "new" / "adaptation.png").read_bytes()[:4] == b"\x89PNG"
    written = json.loads((tmp_path / "new" / "figures.json").read_text())
    assert {"report": found["report"], **written} == found
    assert "drive" in err and not err.startswith("{")


def test_backwards_without_the_heatmaps_arm_needs_no_model(tmp_path, monkeypatch, capsys):
    words = ["--assistants", "none", "--drivers", 1, "--processes", 1, "--seed", 3]
    code, out, err = run(monkeypatch, capsys, "study", "backwards", "-o", tmp_path, *words)
    assert code == 0, err
    assert "impaired, reversing" in out and "unassisted" in out
    assert "seeds 3..3" in out
    rows = json.loads((tmp_path / "figures.json").read_text())["rows"]
    assert [row["driver"] for row in rows] == ["reversing", "impaired, reversing"]
    assert all(row["rolling_back"] > 0.5 for row in rows)
    assert (tmp_path / "report.html").read_text().count("data:image/png") == 2


def test_a_model_that_is_not_given_is_learned_in_the_folder_with_a_bar_a_stage(tmp_path, monkeypatch):
    def learn(folder, seed, progress, processes):
        progress("demonstrate", 72, 72)
        return folder / f"of-seed-{seed}.safetensors"

    monkeypatch.setattr("lfdcore.study.demonstrations.learn_heatmaps_from_demonstrations", learn)
    with progress_bar() as bar:
        learned = heatmaps_or_learned(None, tmp_path / "new", 4, Stages(bar), None)
    assert learned == tmp_path / "new" / "of-seed-4.safetensors" and learned.parent.is_dir()
    assert [(task.description, task.completed, task.total) for task in bar.tasks] == [("heatmaps: demonstrate", 72, 72)]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["adaptation", "--courses", "attic"], "attic"),
        (["adaptation", "--courses", "flat,flat"], "flat"),
        (["adaptation", "--drivers", "0"], "drivers"),
        (["adaptation", "--model", "none.safetensors"], "none.safetensors"),
        (["backwards", "--assistants", "none,both"], "both"),
        (["backwards", "--assistants", "none,none"], "none"),
    ],
)
def test_wrong_use_is_refused_before_anything_is_driven(words, said, tmp_path, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, "study", *words, "-o", tmp_path / "out")
    assert code in (1, 2) and said in err and out == ""
    assert not (tmp_path / "out" / "report.html").exists()


def test_learning_curve_refuses_words_for_numbers_and_leaves_no_folder(tmp_path, monkeypatch, capsys):
    code, out, err = run(monkeypatch, capsys, "study", "learning-curve", "-o", tmp_path / "out", "--runs", "five")
    assert code == 1 and "'five'" in err and out == ""
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("study", ["adaptation", "backwards"])
def test_a_model_of_primitives_is_refused(study, home_model, tmp_path, monkeypatch, capsys):
    code, _, err = run(monkeypatch, capsys, "study", study, "-o", tmp_path, "--model", home_model)
    assert code == 1 and "must be heatmaps" in err
