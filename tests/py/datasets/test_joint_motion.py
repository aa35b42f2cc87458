"""Joint trajectories in files: what an independent decoder reads is what was written; damage is refused."""

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.interpolate import CubicHermiteSpline

from lfdcore.datasets.joint_motion import TOPIC, JointMotion, read_joint_motion, write_joint_motion
from lfdcore.errors import DataError

NAMES = ("s0", "ellbogen_ä", "w2")


def motion(samples: int = 7, seed: int = 1) -> JointMotion:
    rng = np.random.default_rng(seed)
    time = 0.25 + np.cumsum(rng.uniform(0.01, 2.0, samples))
    return JointMotion(NAMES, time, rng.normal(size=(samples, 3)), rng.normal(size=(samples, 3)))


def test_an_independent_decoder_reads_the_message_that_was_written(tmp_path: Path) -> None:
    given_motion, path = motion(), tmp_path / "m.mcap"
    write_joint_motion(given_motion, path)
    with path.open("rb") as file:
        decoded = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        ((schema, channel, _, message),) = decoded
    assert (channel.topic, schema.name) == (TOPIC, "trajectory_msgs/msg/JointTrajectory")
    assert tuple(message.joint_names) == NAMES
    assert message.header.frame_id == "base"
    for k, point in enumerate(message.points):
        assert list(point.positions) == given_motion.positions[k].tolist()
        assert list(point.velocities) == given_motion.velocities[k].tolist()
        assert not len(point.accelerations) and not len(point.effort)
        stamp = point.time_from_start.sec + point.time_from_start.nanosec * 1e-9
        assert stamp == pytest.approx(given_motion.time[k], abs=1e-9)
    assert len(message.points) == 7


@given(st.integers(1, 20), st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_what_is_written_is_read_back_and_the_bytes_are_the_same_twice(tmp_path_factory, samples: int, seed: int):  # type: ignore[no-untyped-def]
    folder = tmp_path_factory.mktemp("motion")
    one = motion(samples, seed)
    for path in (folder / "a.mcap", folder / "b.mcap"):
        write_joint_motion(one, path)
    assert (folder / "a.mcap").read_bytes() == (folder / "b.mcap").read_bytes()
    read = read_joint_motion(folder / "a.mcap")
    assert read.names == one.names
    np.testing.assert_array_equal(read.positions, one.positions)
    np.testing.assert_array_equal(read.velocities, one.velocities)
    np.testing.assert_allclose(read.time, one.time, atol=1e-9)


def test_a_motion_in_any_order_of_memory_is_written(tmp_path: Path) -> None:
    one = motion()
    write_joint_motion(one, tmp_path / "a.mcap")
    turned = dataclasses.replace(one, positions=np.asfortranarray(one.positions))
    write_joint_motion(turned, tmp_path / "b.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_the_table_has_a_column_a_joint_and_one_a_velocity(tmp_path: Path) -> None:
    one = motion()
    write_joint_motion(one, tmp_path / "m.csv")
    with (tmp_path / "m.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time", *NAMES, *(f"{name}.velocity" for name in NAMES)]
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table, np.column_stack([one.time, one.positions, one.velocities]))


@given(st.floats(-1, 20), st.integers(1, 9))
def test_between_samples_it_is_the_cubic_through_positions_and_velocities(time: float, samples: int) -> None:
    one = motion(samples)
    if samples == 1:
        np.testing.assert_array_equal(one.at(time), one.positions[0])
        return
    slow = CubicHermiteSpline(one.time, one.positions, one.velocities)
    np.testing.assert_allclose(one.at(time), slow(np.clip(time, one.time[0], one.time[-1])), atol=1e-12)


def test_a_failed_writing_leaves_what_stood_there_and_no_parts(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "m.csv"
    write_joint_motion(motion(), path)
    before = path.read_bytes()

    def full(*args: object) -> int:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        write_joint_motion(motion(3), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"names": ("a", "a", "b")}, "a name of its own"),
        ({"names": ("a", "", "b")}, "a name of its own"),
        ({"names": ()}, "joints are none"),
        ({"names": ("a", "b")}, r"positions have shape \(7, 3\), must be \(7, 2\)"),
        ({"time": np.zeros(0)}, r"time has shape \(0,\)"),
        ({"time": np.arange(7.0)[::-1]}, "sample 1 is at 5.0 s after 6.0 s"),
        ({"time": np.full(7, np.nan)}, "times are nan"),
        ({"time": np.arange(7.0) - 1}, "times are -1.0 to"),
        ({"time": np.arange(7.0) * 2**30}, "must be in"),
        ({"positions": np.full((7, 3), np.inf)}, "positions have shape .* finite"),
        ({"velocities": np.full((7, 3), np.nan)}, "velocities have shape .* finite"),
        ({"velocities": np.zeros((6, 3))}, r"velocities have shape \(6, 3\)"),
    ],
)
def test_what_is_no_motion_is_refused(change: dict, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        dataclasses.replace(motion(), **change)


def test_other_suffixes_and_places_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"must end in \.mcap or \.csv"):
        write_joint_motion(motion(), tmp_path / "m.bag")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(ValueError, match="no regular file"):
        write_joint_motion(motion(), tmp_path / "folder.csv")
    with pytest.raises(DataError, match="no regular file"):
        read_joint_motion(tmp_path / "folder.csv")
    with pytest.raises(FileNotFoundError):
        read_joint_motion(tmp_path / "none.mcap")


def test_a_truncated_or_garbled_file_is_refused_by_name_or_harmless(tmp_path: Path) -> None:
    path, one = tmp_path / "m.mcap", motion()
    write_joint_motion(one, path)
    whole, rng, refused = path.read_bytes(), np.random.default_rng(5), 0
    cut = [whole[:n] for n in range(0, len(whole), 97)]
    flipped = []
    for _ in range(300):
        data = bytearray(whole)
        data[rng.integers(len(data))] ^= 1 << rng.integers(8)
        flipped.append(bytes(data))
    for data in [*cut, *flipped, b"not an mcap", whole + whole]:
        path.write_bytes(data)
        try:
            read = read_joint_motion(path)
        except DataError as said:
            assert str(path) in str(said)
            assert "\n" not in str(said)
            refused += 1
        else:  # what was hit is not read, or the CRC would have shown it
            np.testing.assert_array_equal(read.positions, one.positions)
    assert refused > len(cut)


def test_an_mcap_without_a_joint_trajectory_is_refused(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "empty.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(DataError, match=f"holds nothing on {TOPIC}"):
        read_joint_motion(path)


def test_points_without_velocities_are_refused(tmp_path: Path, monkeypatch) -> None:
    from lfdcore.datasets import ros_messages

    message = ros_messages.joint_trajectory_message

    def without(names, time, positions, velocities):  # type: ignore[no-untyped-def]
        return message(names, time, positions, np.zeros((len(time), 0)))

    monkeypatch.setattr(ros_messages, "joint_trajectory_message", without)
    write_joint_motion(motion(), tmp_path / "m.mcap")
    with pytest.raises(DataError, match="3 positions and velocities each"):
        read_joint_motion(tmp_path / "m.mcap")
