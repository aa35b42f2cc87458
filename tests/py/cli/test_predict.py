"""lfdcore predict as a user calls it: outputs and exit codes."""

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from calling import run
from lfdcore.datasets import DriveLog, open_log
from synthetic_drive import corner_drive


def corner(path: Path, offset: float, scale: float = 1.0) -> Path:
    drive = corner_drive(offset)
    DriveLog(
        scan_stamp=drive.scan_stamp,
        ranges=drive.ranges,
        odometry_stamp=drive.odometry_stamp,
        pose=drive.pose * [scale, scale, 1],
        twist=np.zeros((len(drive.pose), 2)),
        T_base_laser=drive.T_base_laser,
        name=path.stem,
    ).save(path)
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("predict")


@pytest.fixture(scope="module")
def logs(folder) -> list[Path]:
    return [corner(folder / f"drive{k}.mcap", offset) for k, offset in enumerate((-0.15, 0.0, 0.15, 0.07))]


@pytest.fixture
def model(folder, logs, monkeypatch, capsys) -> Path:
    path = folder / "corner.safetensors"
    if not path.exists():
        assert run(monkeypatch, capsys, "learn", "drive", *logs[:3], "-o", path)[0] == 0
    return path


def test_a_table_a_log_with_baselines_and_model(model, logs, monkeypatch, capsys) -> None:
    code, out, err = run(monkeypatch, capsys, "predict", logs[3], model, logs[0])
    assert code == 0
    assert "drive3: path error" in out
    assert "drive0: path error" in out
    assert "drive3, drive0 together: path error" in out
    assert out.count("corner  ") == 9
    assert out.count("constant arc  ") == 9
    assert "seed 1" in out
    assert "drive3" in err  # the progress bar


def test_json_and_a_picture(model, logs, folder, monkeypatch, capsys) -> None:
    picture = folder / "along.png"
    code, out, _ = run(monkeypatch, capsys, "predict", model, logs[3], "--from", ".2", "--json", "--picture", picture)
    found = json.loads(out)
    assert code == 0
    assert found["from"] == 0.2
    rows = found["logs"][0]["errors"]
    assert [r["predictor"] for r in rows[:3]] == ["straight", "constant arc", "corner"]
    assert rows[-1]["mean"] < rows[-3]["mean"]
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_a_model_is_known_by_its_content_too_and_presets_and_rules_differ(model, logs, folder, monkeypatch, capsys):
    other = folder / "renamed.bin"
    shutil.copy(model, other)
    means = {}
    for words in ((), ("--rule", "goal"), ("--preset", "thesis")):
        code, out, _ = run(monkeypatch, capsys, "predict", other, logs[3], "--json", *words)
        assert code == 0
        means[words] = json.loads(out)["logs"][0]["errors"][-1]["mean"]
    assert means[()] != means["--rule", "goal"] == means["--preset", "thesis"]


def test_a_log_without_samples_is_said_and_fails_only_if_none_has_any(model, logs, folder, monkeypatch, capsys) -> None:
    still = corner(folder / "still.mcap", 0.0, scale=0.01)
    code, out, _ = run(monkeypatch, capsys, "predict", model, still, logs[3])
    assert code == 0
    assert "still: no sample" in out
    code, out, err = run(monkeypatch, capsys, "predict", model, still, "--picture", folder / "no.png")
    assert code == 1
    assert "still: no sample" in out
    assert "not drawn" in err
    assert not (folder / "no.png").exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("MODEL",), 2, "1 models and 0 logs"),
        (("LOG",), 2, "0 models and 1 logs"),
        (("MODEL", "LOG", "--from", ".8", "--to", ".2"), 2, "--from 0.8 must be less than --to 0.2"),
        (("MODEL", "LOG", "--from", "2"), 2, "'--from'"),
        (("MODEL", "LOG", "--footprint", "1,2"), 2, "FRONT,REAR,HALF_WIDTH"),
        (("MODEL", "LOG", "--picture", "a.bmp"), 2, ".png"),
        (("MODEL", "missing.log"), 1, "missing.log: no such model or drive log"),
        (("MODEL", "GARBAGE"), 1, "garbage.log"),
        (("BROKEN", "LOG"), 1, "broken.safetensors"),
    ],
)
def test_wrong_use_ends_with_2_and_bad_files_with_1_and_one_clear_line(
    model, logs, folder, monkeypatch, capsys, words, code, said
) -> None:
    (folder / "garbage.log").write_bytes(np.random.default_rng(0).bytes(500))
    (folder / "broken.safetensors").write_bytes(model.read_bytes()[:1000])
    names = {
        "MODEL": model,
        "LOG": logs[3],
        "GARBAGE": folder / "garbage.log",
        "BROKEN": folder / "broken.safetensors",
    }
    monkeypatch.setenv("COLUMNS", "200")
    found, _, err = run(monkeypatch, capsys, "predict", *(names.get(word, word) for word in words))
    assert found == code
    assert said in err
    assert "Traceback" not in err


def test_a_log_or_model_given_twice_is_refused_under_whatever_name(model, logs, folder, monkeypatch, capsys) -> None:
    other = folder / "other name.mcap"
    other.symlink_to(logs[0])
    for words in ([model, logs[0], logs[0]], [model, logs[0], other], [model, logs[0], model]):
        code, _, err = run(monkeypatch, capsys, "predict", *words)
        assert code == 2
        assert "given twice" in " ".join(err.replace("│", " ").split())
    code, _, err = run(monkeypatch, capsys, "learn", "drive", logs[0], other, "-o", folder / "never.safetensors")
    assert code == 2
    assert "given twice" in " ".join(err.replace("│", " ").split())


def test_scans_without_a_measurement_predict_nothing_and_no_nan_is_printed(
    model, folder, monkeypatch, capsys, recwarn
) -> None:
    path = corner(folder / "blind.mcap", 0.0)
    seen = open_log(path)
    dataclasses.replace(seen, ranges=seen.ranges * np.nan).save(path)
    code, out, _ = run(monkeypatch, capsys, "predict", model, path)
    assert code == 0
    assert "corner: 100.0 % without a prediction" in out
    assert "nan" not in out
    assert not recwarn.list
