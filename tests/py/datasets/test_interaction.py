"""Recordings of collaborations: what is saved is loaded to the bit; what cannot be one is refused with the reason."""

import dataclasses
import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lfdcore.datasets import InteractionRecording, environments, load_interaction
from lfdcore.errors import DataError


def recording(samples: int = 40, **changes: object) -> InteractionRecording:
    """Two partner columns t, t^2 and one robot column -t, every .1 s."""
    t = np.arange(samples) / 10
    given = {
        "stamp": t,
        "partner": np.stack([t, t**2], axis=1),
        "robot": -t[:, None],
        "partner_names": ("hand.x", "hand.y"),
        "robot_names": ("gripper.x",),
        "environment": {"height": 0.8},
        "metadata": {"object": "stool"},
        "name": "one",
    }
    return InteractionRecording(**{**given, **changes})


@st.composite
def recordings(draw: st.DrawFn) -> InteractionRecording:
    samples, n, r = draw(st.integers(1, 12)), draw(st.integers(0, 4)), draw(st.integers(0, 3))
    steps = draw(arrays(np.float64, samples, elements=st.floats(1e-3, 10)))
    values = st.floats(-1e6, 1e6)
    texts = st.text(st.characters(codec="utf-8"), max_size=8)
    named = st.text(st.characters(codec="utf-8"), min_size=1, max_size=8).filter(str.strip)
    return InteractionRecording(
        np.cumsum(steps),
        draw(arrays(np.float64, (samples, n), elements=values | st.just(np.nan))),
        draw(arrays(np.float64, (samples, r), elements=values)),
        tuple(f"p{k}" for k in range(n)),
        tuple(f"r{k}" for k in range(r)),
        draw(st.dictionaries(named, values, max_size=3)),
        draw(st.dictionaries(texts, texts, max_size=3)),
        draw(texts),
    )


@given(recordings())
def test_what_is_saved_is_loaded_to_the_last_bit_and_saved_to_the_same_bytes(
    tmp_path_factory: pytest.TempPathFactory, one: InteractionRecording
) -> None:
    folder = tmp_path_factory.mktemp("interaction")
    one.save(folder / "a.npz")
    read = load_interaction(folder / "a.npz")
    for field in dataclasses.fields(one):
        np.testing.assert_array_equal(getattr(read, field.name), getattr(one, field.name))
    read.save(folder / "b.npz")
    assert (folder / "a.npz").read_bytes() == (folder / "b.npz").read_bytes()


def test_numpy_itself_opens_the_file_without_pickle(tmp_path: Path) -> None:
    recording().save(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        np.testing.assert_array_equal(file["robot"], recording().robot)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"stamp": np.zeros(40)}, "stamps must increase: sample 1 is at 0.0 s after 0.0 s"),
        ({"stamp": np.r_[np.arange(39), np.nan]}, "stamp of sample 39 is nan s, must be finite"),
        ({"stamp": np.arange(39.0)}, r"partner has shape \(40, 2\), must be \(39, columns\)"),
        ({"stamp": np.zeros(0)}, r"stamp has shape \(0,\), must be \(T,\) with T >= 1"),
        ({"partner": np.full((40, 2), np.inf)}, "partner holds inf, must be finite and within 1e"),
        ({"partner": np.full((40, 3), 1.0)}, "partner has 3 columns, but 2 names"),
        ({"robot": np.full((40, 1), np.nan)}, "robot holds nan"),
        ({"robot": np.zeros(40)}, r"robot has shape \(40,\)"),
        ({"partner_names": ("hand.x", "hand.x")}, "partner has a column named 'hand.x', must be .* its own"),
        ({"partner_names": ("hand.x", " ")}, "partner has a column named ' '"),
        ({"environment": {"height": np.nan}}, "environment 'height' is nan, must be finite"),
        ({"environment": {"height": True}}, "environment 'height' is True, must be a number"),
        ({"environment": {"": 1.0}}, "environment has the name ''"),
        ({"metadata": {"object": 3}}, "metadata 'object' is 3, must be a text"),
        ({"frame": None}, "frame is None, must be a text"),
    ],
)
def test_what_is_no_recording_is_refused_with_value_and_bound(changes: dict[str, object], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        recording(**changes)


# -- parts of a recording -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cut", "samples"),
    [
        ({"seconds": 1.0}, 11),
        ({"seconds": 0.99}, 10),
        ({"seconds": 0.0}, 1),
        ({"seconds": 1e9}, 40),
        ({"share": 0.1}, 4),
        ({"share": 1.0}, 40),
    ],
)
def test_a_partial_observation_is_the_partners_beginning(cut: dict[str, float], samples: int) -> None:
    part = recording().partial(**cut)
    np.testing.assert_array_equal(part.partner, recording().partner[:samples])
    assert (part.robot.shape, part.robot_names) == ((samples, 0), ())
    assert (part.environment, part.metadata) == (recording().environment, recording().metadata)


@pytest.mark.parametrize(
    ("cut", "reason"),
    [
        ({}, "exactly one of seconds and share"),
        ({"seconds": 1.0, "share": 0.1}, "exactly one of seconds and share"),
        ({"seconds": -1.0}, "seconds must be finite and >= 0 s, got -1.0 s"),
        ({"seconds": float("nan")}, "seconds must be finite"),
        ({"share": 1.01}, r"share must be in \[0, 1\], got 1.01"),
        ({"share": float("nan")}, "share must be in"),
    ],
)
def test_a_part_that_cannot_be_is_refused(cut: dict[str, float], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        recording().partial(**cut)


def test_columns_not_seen_are_nan_and_unknown_ones_named() -> None:
    seen = recording().seeing(["hand.x"])
    assert np.isnan(seen.partner[:, 1]).all()
    np.testing.assert_array_equal(seen.partner[:, 0], recording().partner[:, 0])
    with pytest.raises(ValueError, match=r"column is 'foot.x', must be one of hand.x, hand.y"):
        recording().seeing(["foot.x"])


@given(st.integers(2, 300))
def test_resampling_keeps_ends_duration_and_straight_lines(steps: int) -> None:
    even = recording().resample(steps)
    assert (len(even), even.duration) == (steps, pytest.approx(recording().duration))
    np.testing.assert_allclose(even.partner[:, 0], np.linspace(0, 3.9, steps), atol=1e-12)
    np.testing.assert_allclose(even.robot[:, 0], -np.linspace(0, 3.9, steps), atol=1e-12)


def hidden(begin: int, end: int) -> InteractionRecording:
    partner = recording().partner.copy()
    partner[begin:end, 0] = np.nan
    return recording(partner=partner)


def test_a_gap_is_bridged_by_a_straight_line_up_to_the_stated_length() -> None:
    gap = hidden(10, 14)  # from the sight at .9 s to that at 1.4 s
    np.testing.assert_allclose(gap.resample(40, 0.5).partner[:, 0], recording().partner[:, 0], atol=1e-12)
    with pytest.raises(ValueError, match=r"hand.x was not seen for 0.5 s from 0.900 s on, must be <= 0.49 s"):
        gap.resample(40, 0.49)


@pytest.mark.parametrize(("begin", "end", "value"), [(0, 4, 0.4), (36, 40, 3.5)])
def test_a_gap_at_an_end_is_filled_with_the_nearest_sight(begin: int, end: int, value: float) -> None:
    np.testing.assert_allclose(hidden(begin, end).resample(40, 0.4).partner[begin:end, 0], value)
    with pytest.raises(ValueError, match=r"hand.x was not seen for 0.4 s"):
        hidden(begin, end).resample(40, 0.39)


def test_a_column_never_seen_stays_unseen() -> None:
    assert np.isnan(hidden(0, 40).resample(10).partner[:, 0]).all()


def test_resampling_needs_two_samples_and_two_steps() -> None:
    for one, steps in ((recording(1), 5), (recording(), 1)):
        with pytest.raises(ValueError, match="at least 2 samples and 2 steps"):
            one.resample(steps)
    with pytest.raises(ValueError, match="longest_gap must be >= 0 s, got nan s"):
        recording().resample(5, float("nan"))


def test_environments_come_in_one_order_and_must_have_the_same_names() -> None:
    two = recording(environment={"a": 1.0, "b": 2.0}), recording(environment={"b": 4.0, "a": 3.0}, name="two")
    names, values = environments(two)
    assert names == ("a", "b")
    np.testing.assert_array_equal(values, [[1, 2], [3, 4]])
    assert environments([recording(environment={})])[1].shape == (1, 0)
    with pytest.raises(ValueError, match=r"one has the environment \['height'\], must be \['a', 'b'\]"):
        environments([*two, recording()])
    with pytest.raises(ValueError, match="there are no recordings"):
        environments([])


# -- broken files ---------------------------------------------------------------------------------------------------


def rewritten(path: Path, changes: dict[str, bytes | None]) -> Path:
    """A recording's file with some members replaced, added or (None) dropped."""
    recording().save(path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in {**members, **changes}.items():
            if data is not None:
                archive.writestr(name, data)
    return path


def npy(array: np.ndarray, **options: bool) -> bytes:
    out = io.BytesIO()
    np.save(out, array, **options)
    return out.getvalue()


def header(**changes: object) -> dict[str, bytes]:
    said = {
        "format": "lfdcore interaction", "version": 1, "partner_names": ["hand.x", "hand.y"],
        "robot_names": ["gripper.x"], "environment": {"height": 0.8}, "metadata": {}, "name": "", "frame": "base",
    }  # fmt: skip
    text = json.dumps({**said, **changes}).encode()
    return {"header.npy": npy(np.frombuffer(text, np.uint8))}


def huge() -> bytes:
    """4 values that claim to be 1e15."""
    out = io.BytesIO()
    np.lib.format.write_array_header_1_0(out, {"descr": "<f8", "fortran_order": False, "shape": (10**15,)})
    return out.getvalue() + bytes(32)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"robot.npy": None}, "must hold stamp, partner, robot, header"),
        ({"more.npy": npy(np.zeros(1))}, "must hold stamp, partner, robot, header"),
        ({"stamp.npy": huge()}, r"stamp claims the shape \(1000000000000000,\), which needs 8000000000000000 bytes"),
        ({"stamp.npy": npy(np.array([{}] * 40), allow_pickle=True)}, r"stamp is dtype\('O'\), must be float64"),
        ({"stamp.npy": npy(np.arange(40))}, "stamp is .*int64.*, must be float64"),
        ({"stamp.npy": b"nothing at all"}, "magic string is not correct"),
        ({"stamp.npy": npy(np.arange(40.0))[:-8]}, "which needs 320 bytes, but has 312"),
        ({"stamp.npy": npy(np.arange(40.0)[::-1])}, "stamps must increase"),
        ({"partner.npy": npy(np.asfortranarray(np.ones((40, 2))))}, "by columns, must be float64 by rows"),
        ({"header.npy": npy(np.frombuffer(b"{", np.uint8))}, "delimiter|Expecting"),
        ({"header.npy": npy(np.frombuffer(b"\xff", np.uint8))}, "utf-8"),
        ({"header.npy": npy(np.frombuffer(b'{"a": 1, "a": 2}', np.uint8))}, "key 'a' comes 2 times"),
        ({"header.npy": npy(np.frombuffer(b"[" * 100000, np.uint8))}, "recursion"),
        (header(format="other"), "is no recording of lfdcore"),
        (header(version=2), "has format version 2, this lfdcore reads version 1"),
        (header(extra=1), "header has the keys"),
        (header(environment={"height": float("nan")}), "holds NaN, must be finite"),
        (header(environment=[1]), r"environment is \[1\], must be names and numbers"),
        (header(metadata=[["object", "stool"]]), "metadata is .* must be names and texts"),
        (header(partner_names="ab"), "partner_names is 'ab', must be a list"),
        (header(name=3), "name is 3, must be a text"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_recording_is_refused_by_name(
    tmp_path: Path, changes: dict[str, bytes | None], reason: str
) -> None:
    path = rewritten(tmp_path / "broken.npz", changes)
    with pytest.raises(DataError, match=rf"broken\.npz: .*({reason})"):
        load_interaction(path)


def test_every_truncation_is_refused(tmp_path: Path) -> None:
    recording(5).save(tmp_path / "whole.npz")
    data = (tmp_path / "whole.npz").read_bytes()
    for length in range(0, len(data), 37):
        (tmp_path / "cut.npz").write_bytes(data[:length])
        with pytest.raises(DataError, match=r"cut\.npz"):
            load_interaction(tmp_path / "cut.npz")


def test_a_flipped_bit_is_noticed_or_harmless(tmp_path: Path) -> None:
    recording(5).save(tmp_path / "whole.npz")
    data = (tmp_path / "whole.npz").read_bytes()
    for k in range(0, len(data), 11):
        flipped = bytearray(data)
        flipped[k] ^= 0x10
        (tmp_path / "flip.npz").write_bytes(flipped)
        try:
            read = load_interaction(tmp_path / "flip.npz")
        except DataError:
            continue
        np.testing.assert_array_equal(read.partner, recording(5).partner)


@pytest.mark.parametrize("flags", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_garbled_array_headers_are_refused(tmp_path: Path, flags: int) -> None:
    rng, path = np.random.default_rng(1), tmp_path / "garbled.npz"
    recording(5).save(path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    for _ in range(300):
        garbled = bytearray(members["stamp.npy"])
        garbled[rng.integers(0, 128)] = rng.choice(list(b"(){}'\",:\\\n\0\xff 9-"))
        with zipfile.ZipFile(path, "w", flags) as archive:
            for name, data in {**members, "stamp.npy": bytes(garbled)}.items():
                archive.writestr(name, data)
        try:
            assert len(load_interaction(path)) == 5  # a space may be another space
        except DataError as refused:
            assert "garbled.npz" in str(refused)


def test_garbled_compressed_data_are_refused(tmp_path: Path) -> None:
    recording().save(tmp_path / "whole.npz")
    with zipfile.ZipFile(tmp_path / "whole.npz") as whole, zipfile.ZipFile(tmp_path / "a.npz", "w", 8) as archive:
        for name in whole.namelist():
            archive.writestr(name, whole.read(name))
    data = (tmp_path / "a.npz").read_bytes()
    assert len(load_interaction(tmp_path / "a.npz")) == 40
    for k in range(40, len(data) - 300, 7):
        (tmp_path / "b.npz").write_bytes(data[:k] + bytes([data[k] ^ 0x55]) + data[k + 1 :])
        try:
            np.testing.assert_array_equal(load_interaction(tmp_path / "b.npz").partner, recording().partner)
        except DataError:
            continue


def test_a_bomb_is_refused_before_it_is_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lfdcore.datasets.interaction.LARGEST", 2**20)
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("stamp", "partner", "robot", "header"):
            archive.writestr(f"{name}.npy", bytes(2**19))
    with pytest.raises(DataError, match="unpacks to 2097152 bytes, must be <= 1048576"):
        load_interaction(tmp_path / "bomb.npz")


def test_paths_that_cannot_hold_a_recording_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"must end in \.npz"):
        recording().save(tmp_path / "a.mcap")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(ValueError, match="no regular file"):
        recording().save(tmp_path / "folder.npz")
    with pytest.raises(DataError, match="no regular file"):
        load_interaction(tmp_path / "folder.npz")
    with pytest.raises(FileNotFoundError):
        load_interaction(tmp_path / "none.npz")
