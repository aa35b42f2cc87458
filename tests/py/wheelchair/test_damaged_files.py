"""Files of models with a flipped bit, a dtype that NumPy lacks, or statistics that no stick has."""

import json
import multiprocessing
import struct
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets.tensor_file import read_tensor_file, write_tensor_file
from lfdcore.errors import DataError, ModelError
from lfdcore.estimation import Kernel
from lfdcore.wheelchair.heatmaps.joystick import (
    JoystickAdapter,
    JoystickBins,
    JoystickModel,
    JoystickModelConfig,
    JoystickPrior,
)
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.stick import full_deflection_of

ARRAYS = {"one": np.arange(5.0), "two": np.arange(6, dtype=np.uint8).reshape(2, 3)}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "any.safetensors"
    write_tensor_file(path, "any", 1, {"a": 1}, ARRAYS)
    return path


@pytest.fixture
def trained() -> JoystickModel:
    stick = np.random.default_rng(0).uniform(-1, 1, (300, 2))
    prior = JoystickPrior(Kernel(0.2, [0.5, 0.5]), 0.05)
    return JoystickModel(JoystickBins.of_pairs(stick, 0.9 * stick), (prior, prior))


def with_header(path: Path, change) -> Path:
    data = path.read_bytes()
    size = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8 : 8 + size])
    change(header)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + data[8 + size :])
    return path


def test_every_flipped_bit_of_the_file_is_noticed(file: Path) -> None:
    data = file.read_bytes()
    for place in range(len(data)):
        for bit in range(8):
            broken = bytearray(data)
            broken[place] ^= 1 << bit
            file.write_bytes(broken)
            with pytest.raises(ModelError):
                read_tensor_file(file, "any", 1)


def test_arrays_taken_for_others_are_noticed(file: Path) -> None:
    with pytest.raises(ModelError, match="damaged"):
        read_tensor_file(with_header(file, lambda h: h["two"].update(shape=[3, 2])), "any", 1)


def test_a_file_without_a_digest_is_refused(file: Path) -> None:
    def forget(header: dict) -> None:
        said = json.loads(header["__metadata__"]["lfdcore"])
        del said["digest"]
        header["__metadata__"]["lfdcore"] = json.dumps(said)

    with pytest.raises(ModelError, match="is damaged: it is not what was written"):
        read_tensor_file(with_header(file, forget), "any", 1)


def test_what_was_written_is_read(file: Path) -> None:
    header, arrays = read_tensor_file(file, "any", 1)
    assert header == {"a": 1, "format": "any", "version": 1}
    np.testing.assert_array_equal(arrays["two"], ARRAYS["two"])


@pytest.mark.parametrize(("dtype", "size"), [("BF16", 2), ("F8_E4M3", 1)])
def test_numbers_of_a_kind_that_numpy_may_lack_are_refused(file: Path, dtype: str, size: int) -> None:
    with_header(file, lambda h: h["one"].update(dtype=dtype, shape=[40 // size]))
    with pytest.raises(ModelError, match="damaged"):
        read_tensor_file(file, "any", 1)


def test_a_header_nested_too_deep_is_refused(file: Path) -> None:
    with_header(file, lambda h: h["__metadata__"].update(lfdcore="[" * 100_000))
    for read in (load_model, lambda path: read_tensor_file(path, "any", 1)):
        with pytest.raises(ModelError, match="damaged"):
            read(file)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("count", 1e300, "count is 1e.300 somewhere, must be at most"),
        ("raw", 1.5, "raw is 1.5 somewhere, must be at most 1"),
        ("target", -1e308, "target is 1e.308 somewhere, must be at most 2"),
        ("variance", 5.0, "variance is 5 somewhere, must be at most 4"),
        ("variance", np.nan, "variance must be finite"),
        ("lengthscales", 0.0, "length-scale is 0"),
    ],
)
def test_statistics_that_no_stick_has_are_refused(trained: JoystickModel, name: str, value: float, said: str) -> None:
    arrays = trained.tensors()
    arrays[name] = np.full_like(arrays[name], value)
    with pytest.raises(ModelError, match=said):
        JoystickModel.of_tensors(trained.header(), arrays)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("amplitude", "1", "amplitude is '1', must be a number"),
        ("amplitude", None, "amplitude is None, must be a number"),
        ("amplitude", 10**400, "too large"),
        ("noise", -1, "noise is -1.0 of full stick"),
        ("noise", "0.1", "noise is '0.1', must be a number"),
        ("family", 5, "family is 5, must be a name"),
    ],
)
def test_parameters_that_are_none_are_refused_in_one_line(trained, name, value, said) -> None:
    header = trained.header()
    header["axes"][0][name] = value
    with pytest.raises(ModelError, match=said) as refused:
        JoystickModel.of_tensors(header, trained.tensors())
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("change", [lambda a: a.astype(np.int64), lambda a: a[None]])
def test_arrays_of_another_kind_are_refused_in_one_line(trained: JoystickModel, change) -> None:
    for name in trained.tensors():
        arrays = trained.tensors()
        arrays[name] = change(arrays[name])
        with pytest.raises(ModelError, match=name) as refused:
            JoystickModel.of_tensors(trained.header(), arrays)
        assert "\n" not in str(refused.value)


def test_three_axes_are_refused(trained: JoystickModel) -> None:
    header = trained.header()
    header["axes"] *= 2
    with pytest.raises(ModelError, match="for 4 axes"):
        JoystickModel.of_tensors(header, trained.tensors())


def test_a_driver_of_another_configuration_or_beyond_the_stick_changes_nothing(trained, tmp_path: Path) -> None:
    other, adapter = tmp_path / "driver.safetensors", JoystickAdapter(trained)
    coarse = JoystickModelConfig(bins=5)
    JoystickAdapter(JoystickModel(JoystickBins.empty(coarse), trained.priors, coarse)).save(other)
    with pytest.raises(ModelError, match="another configuration"):
        adapter.resume(other)
    adapter.save(other)
    header, arrays = read_tensor_file(other, "joystick adaptation", 1)
    arrays["target"] += 7.0
    write_tensor_file(other, "joystick adaptation", 1, header, arrays)
    with pytest.raises(ModelError, match="target is 7 somewhere"):
        adapter.resume(other)
    assert adapter.model is trained


def test_a_speed_too_long_for_a_number_is_refused() -> None:
    class Says:
        metadata = {"full_deflection": [[10**400, 1]]}  # noqa: RUF012

    with pytest.raises(DataError, match="full_deflection is"):
        full_deflection_of(Says())  # type: ignore[arg-type]


def _write_and_read(path: Path, number: int) -> None:
    for _ in range(50):
        write_tensor_file(path, "any", 1, {}, {"a": np.full(5000, number)})
        read_tensor_file(path, "any", 1)


def test_two_processes_that_write_the_same_file_leave_a_whole_one(tmp_path: Path) -> None:
    path, spawn = tmp_path / "both.safetensors", multiprocessing.get_context("spawn")
    writers = [spawn.Process(target=_write_and_read, args=(path, number)) for number in (1, 2)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert [writer.exitcode for writer in writers] == [0, 0]
    _, arrays = read_tensor_file(path, "any", 1)
    assert len(np.unique(arrays["a"])) == 1
    assert [*tmp_path.iterdir()] == [path]
