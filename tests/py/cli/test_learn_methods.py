"""lfdcore learn drive --method and predict, info with models of every kind, as a user calls them."""

import errno
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from calling import run
from heatmap_drives import corridor_log
from lfdcore.cli.common import print_facts
from lfdcore.datasets import DriveLog
from lfdcore.datasets.tensor_file import write_tensor_file
from lfdcore.study.arms import models_by_method
from lfdcore.study.demonstrations import drive_to_destinations
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.models import load_model
from model_files import rewritten
from synthetic_drive import corner_drive


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Two short drives of a place, and the way around a corner whose stick nobody recorded."""
    folder = tmp_path_factory.mktemp("methods")
    for number, offset in enumerate((-0.2, 0.2)):
        log = corridor_log([(2.0, 1.0, 0.4), (2.0, 1.0, -0.4)], (0.0, offset, 0.0), name=f"seen{number}", place="L")
        log.save(folder / f"seen{number}.mcap")
    drive = corner_drive(0.0)
    DriveLog(
        scan_stamp=drive.scan_stamp,
        ranges=drive.ranges,
        odometry_stamp=drive.odometry_stamp,
        pose=drive.pose,
        twist=np.zeros((len(drive.pose), 2)),
        T_base_laser=drive.T_base_laser,
        name="corner",
    ).save(folder / "corner.mcap")
    return folder


@pytest.fixture
def learned(folder, monkeypatch, capsys) -> dict[str, Path]:
    """A model of each kind from the corner (the place's logs for the primitives' are too short), once a module"""
    paths = {kind: folder / f"{kind}.safetensors" for kind in ("primitives", "naive", "heatmaps")}
    for kind, path in paths.items():
        if not path.exists():
            source = [folder / "corner.mcap", "--share", "1" if kind == "primitives" else ".35"]
            code, out, err = run(monkeypatch, capsys, "learn", "drive", *source, "--method", kind, "-o", path)
            assert code == 0, err
            (folder / f"{kind}.txt").write_text(out + err)
    return paths


def test_learning_shows_bars_and_learning_curves(learned, folder) -> None:
    for kind in ("naive", "heatmaps"):
        printed = (folder / f"{kind}.txt").read_text()
        assert "targets" in printed
        assert "network" in printed
        assert "epoch" in printed
        assert printed.count("kept") == 1
        assert "train_losses" not in printed  # they stand in the table
    assert "epoch" not in (folder / "primitives.txt").read_text()


def test_logs_of_a_place_share_their_paths_and_others_learn_their_own_ways(learned, folder, monkeypatch, capsys):
    place = folder / "place.safetensors"
    logs = [folder / "seen0.mcap", folder / "seen1.mcap"]
    code, out, err = run(monkeypatch, capsys, "learn", "drive", *logs, "--method", "heatmaps", "-o", place, "--json")
    assert code == 0, err
    found = json.loads(out)
    assert [epoch["epoch"] for epoch in found["curve"]] == list(range(1, len(found["curve"]) + 1))
    of_place, of_own = load_model(place), load_model(learned["heatmaps"])
    assert isinstance(of_place, HeatmapModel)
    assert of_place.sensor.metadata["config"]["epochs"] == 10
    assert of_own.sensor.metadata["config"]["epochs"] == 12
    assert of_place.metadata["pairs"] < 30  # 8 m, a scan every .5 m
    assert of_own.metadata["pairs"] > 40  # one every .05 m


def test_full_deflection_stands_in_every_model(learned) -> None:
    for path in learned.values():
        ((linear, angular),) = load_model(path).metadata["full_deflection"]
        assert 0 < linear < 2
        assert 0 < angular < 3


def test_three_kinds_side_by_side_in_one_table_and_picture(learned, folder, monkeypatch, capsys) -> None:
    picture, words = folder / "three.png", [*learned.values(), folder / "corner.mcap", "--to", ".4"]
    code, out, err = run(monkeypatch, capsys, "predict", *words, "--picture", picture)
    assert code == 0, err
    for kind in learned:
        assert out.count(f"\n{kind}  ") == 3
    assert "naive: " in out
    assert "compliance unknown to this model" in out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    code, out, _ = run(monkeypatch, capsys, "predict", *words, "--json")
    about = json.loads(out)["logs"][0]["models"]
    assert about["naive"]["compliant"] is None
    assert about["naive"]["rmse_compliant"] is None
    assert 0 < about["heatmaps"]["compliant"] <= 1


def test_three_kinds_are_compared_as_in_table_4_2_with_concatenated_landscapes(learned, folder, monkeypatch, capsys):
    (driven,) = drive_to_destinations(folder, 1, runs=1, processes=1).paths
    picture, words = folder / "landscapes.png", [*learned.values(), driven, "--to", ".5"]
    code, out, err = run(monkeypatch, capsys, "predict", *words, "--concatenated", picture)
    assert code == 0, err
    assert "A-posteriori comparison (as Table 4.2; n = 1 logs, " in out
    assert "reward at positions" in out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    code, out, _ = run(monkeypatch, capsys, "predict", *words, "--concatenated", picture, "--json")
    found = json.loads(out)["comparison"]
    assert list(found) == ["primitives", "naive", "heatmaps"]
    assert all(0 <= figures["rank"][0] <= 100 for figures in found.values())


def test_a_comparison_without_a_model_of_each_kind_says_which_were_given(learned, folder, monkeypatch, capsys):
    words = [learned["naive"], learned["heatmaps"], folder / "corner.mcap", "--concatenated", folder / "none.png"]
    code, _, err = run(monkeypatch, capsys, "predict", *words)
    assert code == 2
    assert "one model of each kind; given are 0 of primitives, 1 naive, 1 of heatmaps" in " ".join(err.split())
    assert not (folder / "none.png").exists()


@pytest.mark.parametrize("option", [("--rule", "goal"), ("--preset", "thesis")])
def test_what_only_path_primitives_know_is_refused_with_other_models(learned, folder, monkeypatch, capsys, option):
    code, _, err = run(monkeypatch, capsys, "predict", *learned.values(), folder / "corner.mcap", *option)
    assert code == 2
    assert f"{' '.join(option)} is of path primitives, and naive, heatmaps holds none" in " ".join(err.split())


def test_info_says_which_kind_a_model_is(learned, monkeypatch, capsys) -> None:
    kinds = {"primitives": "drive assistant model", "heatmaps": "heatmaps model", "naive": "naive heatmap model"}
    for name, path in learned.items():
        code, out, _ = run(monkeypatch, capsys, "info", path, "--json")
        assert code == 0
        found = json.loads(out)
        assert found["kind"] == kinds[name]
        assert found["logs"] == ["corner"]


def test_info_tells_people_long_lists_by_their_ends(capsys) -> None:
    print_facts({"loss": 0.10970439016819, "logs": [f"maze-{k}" for k in range(72)], "held_out": [5, 8]})
    loss, logs, held_out = (line.split(maxsplit=1)[1] for line in capsys.readouterr().out.splitlines())
    assert (loss, logs, held_out) == ("0.109704", "maze-0, maze-1, ..., maze-71 (72)", "5, 8")


def test_a_study_refuses_a_naive_model(learned) -> None:
    assert isinstance(load_model(learned["naive"]), NaiveHeatmapModel)
    with pytest.raises(ValueError, match="naive heatmap, which drives nothing"):
        models_by_method([learned["naive"]])


@pytest.mark.parametrize("kind", ["heatmaps", "naive"])
@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("cut", "cut.safetensors"),
        ("version", "version 9"),
        ("resolution", "resolution 0.06"),
    ],
)
def test_a_model_cut_short_or_of_another_version_or_resolution_is_one_clear_line(
    learned, folder, monkeypatch, capsys, kind, change, said
) -> None:
    source, target = learned[kind], folder / f"{change}.safetensors"
    if change == "cut":
        target.write_bytes(source.read_bytes()[: source.stat().st_size // 2])
    else:
        value = {"version": 9, "resolution": 0.06}[change]
        rewritten(source, target, lambda header: header.update({change: value}))
    for words in (("info", target), ("predict", target, folder / "corner.mcap")):
        code, _, err = run(monkeypatch, capsys, *words)
        assert code == 1
        assert said in err
        assert "Traceback" not in err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--method", "forest"), 2, "forest"),
        (("--method", "heatmaps", "--share", "0"), 1, "no scan"),
        (("--method", "naive", "--share", "0"), 1, "no scan"),
    ],
)
def test_what_cannot_be_learned_is_one_clear_line(folder, monkeypatch, capsys, words, code, said) -> None:
    output = folder / "never.safetensors"
    found, _, err = run(monkeypatch, capsys, "learn", "drive", folder / "corner.mcap", *words, "-o", output)
    assert found == code
    assert said in err
    assert "Traceback" not in err
    assert not output.exists()


@pytest.mark.parametrize(
    "words",
    [
        ("learn", "drive", "corner.mcap", "--method", "heatmaps", "-o", "never.safetensors"),
        ("study", "adaptation", "-o", "never", "--drivers", "1", "--processes", "1"),
        ("study", "backwards", "-o", "never", "--drivers", "1", "--processes", "1"),
    ],
)
def test_without_the_training_extra_heatmaps_say_what_is_missing(folder, monkeypatch, capsys, words) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.setitem(sys.modules, "torch", None)
    needing = ("lfdcore.training.parts.heatmap_net", "lfdcore.training.drive_")
    for name in [n for n in sys.modules if n.startswith(needing)]:
        monkeypatch.delitem(sys.modules, name)
    code, _, err = run(monkeypatch, capsys, *words)
    assert code == 1
    assert "extra 'train'" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("method", ["primitives", "naive", "heatmaps"])
def test_a_folder_that_is_not_there_is_said_before_anything_is_learned(folder, monkeypatch, capsys, method) -> None:
    output = folder / "no folder" / "model.safetensors"
    words = ("learn", "drive", folder / "corner.mcap", "--method", method, "-o", output)
    code, _, err = run(monkeypatch, capsys, *words)
    assert code == 1
    assert err.startswith(f"lfdcore: {output}: there is no folder {output.parent}")  # without a progress bar before
    assert err.count("\n") == 1


def test_a_full_disk_names_the_model_and_keeps_what_stood_there(tmp_path, monkeypatch) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    target = tmp_path / "model.safetensors"
    target.write_text("old")
    with pytest.raises(OSError, match=r"No space left on device: .*model\.safetensors'"):
        write_tensor_file(target, "any", 1, {}, {"a": np.zeros(2)})
    assert target.read_text() == "old"
    assert [*tmp_path.iterdir()] == [target]
