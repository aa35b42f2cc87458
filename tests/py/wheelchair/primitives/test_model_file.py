import os
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save

from lfdcore.datasets.tensor_file import read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.training.drive_primitives import LearningConfig, learn_drive
from lfdcore.wheelchair.primitives.model import VERSION, DriveAssistantModel
from model_files import rewritten
from synthetic_drive import AHEAD, LEFT, T_BASE_LASER, corner_drive, drive, log_of, scan_at


@pytest.fixture
def saved(corner_model, tmp_path):
    path = tmp_path / "model.safetensors"
    corner_model.save(path)
    return path


def test_a_loaded_model_answers_exactly_as_the_saved_one(corner_model, saved):
    loaded = DriveAssistantModel.load(saved)
    for pose, stick in [((0, 0, 0), AHEAD), ((5.5, 0, 0.2), LEFT)]:
        a, b = (m.intention.predict(stick, scan_at(*pose), T_BASE_LASER) for m in (corner_model, loaded))
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(corner_model.compliance.map(stick), loaded.compliance.map(stick))
    goal = np.array([1.5, 0.7])
    np.testing.assert_array_equal(corner_model.primitives.scaled_to(goal), loaded.primitives.scaled_to(goal))
    assert loaded.metadata == corner_model.metadata
    assert loaded.clearance == corner_model.clearance
    assert loaded.intention.config == corner_model.intention.config
    assert loaded.compliance.config == corner_model.compliance.config


def test_learning_and_saving_again_gives_the_same_bytes(corner_logs, corner_model, saved, tmp_path):
    learn_drive(corner_logs).save(tmp_path / "again.safetensors")
    DriveAssistantModel.load(saved).save(tmp_path / "resaved.safetensors")
    assert saved.read_bytes() == (tmp_path / "again.safetensors").read_bytes()
    assert saved.read_bytes() == (tmp_path / "resaved.safetensors").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "again.safetensors",
        "model.safetensors",
        "resaved.safetensors",
    ]


def test_the_stated_memory_is_what_the_file_holds(corner_model, saved):
    assert 0 <= saved.stat().st_size - corner_model.nbytes < 4096
    assert corner_model.summary()["bytes"] == corner_model.nbytes


def test_the_metadata_say_what_was_learned_from(corner_model, corner_paths):
    noted = corner_model.metadata
    assert noted["logs"] == ["synthetic"] * 3
    assert noted["lasers"][0] == {"beams": 181, "field_of_view": pytest.approx(np.pi), "T_base_laser": [0.7, 0.0, 0.0]}
    assert noted["n_paths"] == len(corner_paths) == sum(noted["ended_by"].values())
    assert len(noted["data_hash"]) == 64
    assert learn_drive([corner_drive(0.05)]).metadata["data_hash"] != noted["data_hash"]


@pytest.mark.parametrize("share", [0.0, 0.0005, 0.3, 0.9, 0.9999])
def test_a_truncated_file_is_refused(saved, share):
    data = saved.read_bytes()
    saved.write_bytes(data[: int(share * len(data))])
    with pytest.raises(ModelError, match="not a model file or is damaged"):
        DriveAssistantModel.load(saved)


def test_garbled_bytes_are_refused_or_read_but_never_crash(saved, tmp_path):
    data, random = saved.read_bytes(), np.random.default_rng(0)
    for _ in range(200):
        broken = bytearray(data)
        for at in random.integers(0, 6000, 3):
            broken[at] = random.integers(0, 256)
        path = tmp_path / "broken.safetensors"
        path.write_bytes(bytes(broken))
        try:
            DriveAssistantModel.load(path)
        except ModelError:
            continue


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda h: h.update(version=2), "has format version 2, this lfdcore reads version 1"),
        (lambda h: h.update(resolution=0.1), "has resolution 0.1, must be 0.05"),
        (lambda h: h.update(frame="odom"), "has frame odom, must be base_link"),
        (lambda h: h.update(format="something"), "does not hold a lfdcore drive assistant model"),
        (lambda h: h.pop("intention"), "usable drive assistant"),
        (lambda h: h["intention"].update(unknown=1), "usable drive assistant: IntentionConfig has the fields"),
        (lambda h: h["compliance"].update(look_ahead=-1.0), "look_ahead is -1.0 m, must be between 0.01 and 100 m"),
        (lambda h: h.update(clearance=-1.0), "clearance is -1.0 m"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_by_name(saved, change, message):
    with pytest.raises(ModelError, match=message):
        DriveAssistantModel.load(rewritten(saved, saved, change))


def test_other_safetensors_and_missing_files_are_distinguished(tmp_path):
    other = tmp_path / "other.safetensors"
    other.write_bytes(save({"x": np.zeros(3)}))
    with pytest.raises(ModelError, match="does not hold"):
        DriveAssistantModel.load(other)
    with pytest.raises(FileNotFoundError):
        DriveAssistantModel.load(tmp_path / "none.safetensors")


def test_empty_demonstrations_are_refused_with_what_was_found():
    with pytest.raises(ValueError, match="no demonstration was given"):
        learn_drive([])
    stamps, poses, stick = drive([(3.0, 0.0, 0.0)])
    with pytest.raises(ValueError, match=r"1 logs with 31 scans hold no local path \(no input: 30, no odometry: 1\)"):
        learn_drive([log_of(stamps, poses, stick)])


def test_progress_rises_to_its_total(corner_logs):
    reported = []
    learn_drive(corner_logs, progress=lambda done, total: reported.append((done, total)))
    assert reported == [(done, 6) for done in range(1, 7)]


def test_the_thesis_preset_reaches_every_part(corner_logs):
    model = learn_drive(corner_logs, LearningConfig.thesis())
    assert model.intention.config.sigma_joystick == model.compliance.config.sigma == 0.3
    assert model.primitives.counts.sum() == model.metadata["n_paths"]


def test_a_model_learned_by_one_process_is_the_same_in_another(corner_model, saved):
    code = f"""
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
import numpy as np
print(DriveAssistantModel.load({str(saved)!r}).compliance.map(np.array([0.7, 0.3])).sum(dtype=float).hex())
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == corner_model.compliance.map(np.array([0.7, 0.3])).sum(dtype=float).hex()


@pytest.mark.parametrize("part", ["intention", "compliance"])
@pytest.mark.parametrize("value", [None, "x", [], [1], {}, -1, 1e300, 10**400, True])
def test_every_setting_of_a_tampered_model_is_refused_by_name(saved, part, value):
    whole = saved.read_bytes()
    names = sorted(asdict(getattr(DriveAssistantModel.load(saved), part).config))
    for name in names:
        if (name, value) in (("mirror", True), ("shares", [1])):
            continue
        with pytest.raises(ModelError, match=name):
            DriveAssistantModel.load(rewritten(saved, saved, lambda h, name=name: h[part].update({name: value})))
        saved.write_bytes(whole)


@pytest.mark.parametrize("value", [None, "x", [], {}, True, -1, 1e300])
def test_a_tampered_clearance_is_refused_by_name(saved, value):
    with pytest.raises(ModelError, match="clearance is"):
        DriveAssistantModel.load(rewritten(saved, saved, lambda h: h.update(clearance=value)))


@pytest.mark.parametrize("value", [None, "x", [], 3])
def test_tampered_metadata_are_refused_by_name(saved, value):
    with pytest.raises(ModelError, match="metadata is"):
        DriveAssistantModel.load(rewritten(saved, saved, lambda h: h.update(metadata=value)))


ARRAYS = [
    *(f"{part}.{name}" for part in ("intention", "compliance") for name in ("keys", "offsets", "centres", "weights")),
    *("intention.frequencies", "primitives.ends", "primitives.shapes", "primitives.bins", "primitives.counts"),
]
TAMPERINGS = {
    "another type": lambda a: a.astype(np.float32),
    "wider integers": lambda a: a.astype(np.int64) + 2**40,
    "truth": lambda a: a.astype(bool),
    "one dimension more": lambda a: a[..., None],
    "NaN": lambda a: a * np.nan,
    "beyond all bounds": lambda a: a + 1e300,
}


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("tampering", TAMPERINGS)
def test_every_array_of_a_tampered_model_is_refused_by_name(saved, tmp_path, name, tampering):
    header, tensors = read_tensor_file(saved, DriveAssistantModel.kind, VERSION)
    tensors[name] = TAMPERINGS[tampering](tensors[name])
    write_tensor_file(saved, DriveAssistantModel.kind, VERSION, header, tensors)
    with pytest.raises(ModelError, match=name):
        DriveAssistantModel.load(saved)


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("change", [lambda a: a[:-1], lambda a: a[:0]])
def test_arrays_that_do_not_fit_together_are_refused(saved, name, change):
    header, tensors = read_tensor_file(saved, DriveAssistantModel.kind, VERSION)
    tensors[name] = change(tensors[name])
    write_tensor_file(saved, DriveAssistantModel.kind, VERSION, header, tensors)
    with pytest.raises(ModelError, match="does not hold a usable drive assistant"):
        DriveAssistantModel.load(saved)


def test_arrays_too_few_or_too_many_are_refused_by_name(saved):
    header, tensors = read_tensor_file(saved, DriveAssistantModel.kind, VERSION)
    for changed in ({k: v for k, v in tensors.items() if k != "intention.keys"}, tensors | {"more": np.zeros(3)}):
        write_tensor_file(saved, DriveAssistantModel.kind, VERSION, header, changed)
        with pytest.raises(ModelError, match=r"it has the arrays .* must have .*intention\.keys"):
            DriveAssistantModel.load(saved)


def test_a_model_is_written_to_no_folder_and_no_pipe_and_a_failure_leaves_no_part(corner_model, tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    for target in (tmp_path, tmp_path / "pipe", Path("/dev/null")):
        with pytest.raises(ValueError, match="exists and is no regular file"):
            corner_model.save(target)
    (tmp_path / "model").write_bytes(b"old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    with pytest.raises(OSError, match="No space"):
        corner_model.save(tmp_path / "model")
    assert (tmp_path / "model").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model", "pipe"]


def test_a_pipe_is_no_model_and_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ModelError, match="no regular file"):
        DriveAssistantModel.load(tmp_path / "pipe")
