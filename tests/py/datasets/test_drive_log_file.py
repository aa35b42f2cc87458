"""The file of a drive log: others read it, a killed process leaves it whole, a broken one is said to be broken."""

import io
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import (
    DriveLog,
    DriveLogWriter,
    Intention,
    Plan,
    drive_log_reader,
    joystick_from_motion,
    read_drive_log,
)
from lfdcore.datasets.ros_messages import TOPICS
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan

ARRAYS = ("scan_stamp", "ranges", "odometry_stamp", "twist", "joystick_stamp", "joystick", "desired_stamp", "desired")
ARRAYS += ("command_stamp", "command", "map_stamp")
NUMBERS = ("angle_min", "angle_increment", "range_min", "range_max", "T_base_laser", "metadata", "name", "intentions")


def small_drive_log(scans: int) -> DriveLog:
    stamp = np.arange(scans) / 10
    pairs = np.ones((scans, 2))
    return DriveLog(
        scan_stamp=stamp,
        ranges=np.ones((scans, 3)),
        odometry_stamp=stamp,
        pose=np.ones((scans, 3)),
        twist=pairs,
        joystick_stamp=stamp,
        joystick=pairs,
        command_stamp=stamp,
        command=pairs,
        plans=[Plan(0.0, pairs)],
        intentions=[Intention(0.0, (1.0, 2.0), 0.5)],
    )


def read_bytes(data: bytes) -> DriveLog:
    return drive_log_reader._read(io.BytesIO(data), len(data), "cut.mcap")


def assert_same(read: DriveLog, written: DriveLog) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name), err_msg=name)
    for name in NUMBERS:
        assert getattr(read, name) == getattr(written, name), name
    np.testing.assert_allclose(read.pose, written.pose, atol=1e-14)  # a yaw goes through a quaternion
    np.testing.assert_allclose(read.map_odom, written.map_odom, atol=1e-14)
    assert [plan.stamp for plan in read.plans] == [plan.stamp for plan in written.plans]
    for one, other in zip(read.plans, written.plans, strict=True):
        np.testing.assert_array_equal(one.path, other.path)


def assert_prefix(part: DriveLog, whole: DriveLog) -> None:
    """Each stream of `part` is a beginning of that of `whole`."""
    for name in ARRAYS:
        values, expected = getattr(part, name), getattr(whole, name)
        if len(values):
            np.testing.assert_array_equal(values, expected[: len(values)], err_msg=name)


def test_a_saved_log_comes_back_to_the_last_bit(small_log: DriveLog, small_file: Path) -> None:
    assert_same(read_drive_log(small_file), small_log)
    assert not list(small_file.parent.glob("*.part"))


def test_the_same_log_gives_the_same_bytes(small_log: DriveLog, small_file: Path, tmp_path: Path) -> None:
    small_log.save(tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == small_file.read_bytes()


def test_mcap_ros2_decodes_every_topic_to_what_was_recorded(small_log: DriveLog, small_file: Path) -> None:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    seen: dict[str, list] = {}
    with small_file.open("rb") as file:
        for schema, channel, message, decoded in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            assert schema.name == TOPICS[channel.topic]
            seen.setdefault(channel.topic, []).append((message.log_time / 1e9, decoded))
    assert set(seen) == set(TOPICS)
    assert [stamp for stamp, _ in seen["/scan"]] == small_log.scan_stamp.tolist()
    scan = seen["/scan"][1][1]
    np.testing.assert_array_equal(np.array(scan.ranges, np.float32), small_log.ranges[1])
    assert scan.header.frame_id == "laser"
    assert scan.angle_max == pytest.approx(np.pi / 2)
    stamp, odometry = seen["/odom"][2]
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_link")
    assert odometry.header.stamp.sec + odometry.header.stamp.nanosec / 1e9 == pytest.approx(stamp, abs=1e-9)
    assert (odometry.pose.pose.position.x, odometry.twist.twist.angular.z) == (
        small_log.pose[2, 0],
        small_log.twist[2, 1],
    )
    yaw = 2 * np.arctan2(odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w)
    assert yaw == pytest.approx(small_log.pose[2, 2])
    assert list(seen["/joy"][3][1].axes) == small_log.joystick[3].tolist()
    assert list(seen["/joy_desired"][0][1].axes) == small_log.desired[0].tolist()
    command = seen["/cmd_vel"][0][1].twist
    assert (command.linear.x, command.angular.z) == tuple(small_log.command[0])
    plan = seen["/plan"][0][1]
    assert [[p.pose.position.x, p.pose.position.y] for p in plan.poses] == small_log.plans[0].path.tolist()
    cloud = seen["/intention"][0][1]
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "likelihood"]
    assert np.frombuffer(bytes(cloud.data)).tolist() == [1.5, 2.0, 0.0, 0.003]
    mounting = seen["/tf_static"][0][1].transforms[0]
    assert (mounting.header.frame_id, mounting.child_frame_id) == ("base_link", "laser")
    assert mounting.transform.translation.x == 0.7
    for parent, child, poses in (("odom", "base_link", small_log.pose), ("map", "odom", small_log.map_odom)):
        moving = [one for _, message in seen["/tf"] for one in message.transforms if one.child_frame_id == child]
        assert {one.header.frame_id for one in moving} == {parent}
        assert [one.transform.translation.y for one in moving] == poses[:, 1].tolist()


def test_rosbags_opens_the_lone_file_and_reads_the_same(small_log: DriveLog, small_file: Path) -> None:
    from rosbags.highlevel import AnyReader

    with AnyReader([small_file]) as reader:
        scans = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages()
            if connection.topic == "/scan"
        ]
    np.testing.assert_array_equal(np.stack([scan.ranges for scan in scans]), small_log.ranges)


def test_the_file_is_one_unchunked_mcap(small_file: Path) -> None:
    from mcap.reader import make_reader

    with small_file.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.chunk_count == 0


def test_a_copy_that_mcap_chunked_and_compressed_reads_the_same(small_log: DriveLog, small_file: Path) -> None:
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader
    from mcap.writer import Writer

    copy = io.BytesIO()
    writer = Writer(copy)
    writer.start("ros2", "another tool")
    schemas, channels = {}, {}
    with small_file.open("rb") as file:
        for record in StreamReader(file).records:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(record.topic, "cdr", schemas[record.schema_id])
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Message):
                writer.add_message(channels[record.channel_id], record.log_time, record.data, record.publish_time)
    writer.finish()
    assert_same(read_bytes(copy.getvalue()), small_log)


KILLED = """
import os, sys
import numpy as np
from lfdcore.datasets import DriveLogWriter
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
writer = DriveLogWriter(sys.argv[1], T_base_laser=Pose2(0.7, 0, 0), name="killed")
scan = LaserScan(np.full(181, 2, np.float32), -1.5, 0.01)
for tick in range(10**9):
    writer.odometry(tick / 10, Pose2(tick, 0, 0), Twist2(0, 0))
    writer.scan(tick / 10, scan)
    writer.joystick(tick / 10, 0.5, 0.0)
    os.write(1, b"%d\\n" % tick)
"""


def test_a_process_killed_with_sigkill_loses_at_most_the_record_it_was_writing(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    with subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        for _ in range(50):
            child.stdout.readline()
        child.kill()
        rest = child.stdout.read().split()
        assert child.wait() == -signal.SIGKILL
    written = int(rest[-1]) if rest else 49
    log = read_drive_log(path)
    assert "incomplete" in log.metadata
    assert log.name == "killed"
    for stamps in (log.odometry_stamp, log.scan_stamp, log.joystick_stamp):
        assert len(stamps) >= written + 1
        np.testing.assert_array_equal(stamps, np.arange(len(stamps)) / 10)


def data_end(data: bytes) -> int:
    """Where the record stands that ends the data; the summary follows."""
    return data.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")


def test_a_log_cut_at_any_byte_gives_a_clean_beginning_or_says_that_it_is_cut(tmp_path: Path) -> None:
    log = small_drive_log(scans=2)
    log.save(tmp_path / "two.mcap")
    data = (tmp_path / "two.mcap").read_bytes()
    end = data_end(data)
    refused, read, last = 0, 0, 0
    for size in [*range(end + 30), *range(end + 30, len(data), 16)]:  # all data is there before the summary
        try:
            part = read_bytes(data[:size])
        except DataError as error:
            assert "cut.mcap" in str(error)
            assert not read, "once a beginning can be read, a longer one can"
            refused += 1
            continue
        read += 1
        count = sum(len(getattr(part, f"{name}_stamp")) for name in ("scan", "odometry", "joystick", "command"))
        assert count >= last
        if count > last:
            assert_prefix(part, log)
        last = count
    assert refused
    assert read
    assert last == 4 * 2


def test_one_changed_byte_of_a_whole_log_is_noticed(small_file: Path, small_log: DriveLog) -> None:
    data = bytearray(small_file.read_bytes())
    end = data_end(bytes(data))
    rng = np.random.default_rng(0)
    for place in rng.integers(8, end, 150):
        changed = bytearray(data)
        changed[place] ^= 1 << rng.integers(8)
        with pytest.raises(DataError, match=r"cut\.mcap"):
            read_bytes(bytes(changed))


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300), st.booleans())
def test_bytes_that_are_no_log_are_refused_and_nothing_else_happens(data: bytes, magic: bool) -> None:
    with pytest.raises(DataError):
        read_bytes(b"\x89MCAP0\r\n" * magic + data)


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_a_garbled_log_that_was_never_closed_is_read_or_refused_but_never_crashes(data: st.DataObject) -> None:
    whole = bytearray(UNCLOSED)
    for _ in range(data.draw(st.integers(1, 8))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    try:
        assert isinstance(read_bytes(bytes(whole)), DriveLog)
    except DataError as error:
        assert "cut.mcap" in str(error)


def _unclosed() -> bytes:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        writer = DriveLogWriter(Path(folder) / "log.mcap", T_base_laser=Pose2(0.7, 0, 0))
        for tick in range(5):
            writer.odometry(tick, Pose2(tick, 0, 0), Twist2(0.1, 0.2))
            writer.scan(tick, LaserScan(np.full(7, 2, np.float32), -1.5, 0.5))
            writer.plan(tick, [[0, 0], [1, 1]])
            writer.intention(tick, (1, 2), 0.5)
            writer.joystick(tick, 0.5, 0)
        data = (Path(folder) / "log.mcap").read_bytes()
        writer.close()
    return data


UNCLOSED = _unclosed()


@pytest.fixture
def writer(tmp_path: Path) -> DriveLogWriter:
    return DriveLogWriter(tmp_path / "log.mcap", T_base_laser=Pose2(0.7, 0.0, 0.0), metadata={"seed": "3"})


def test_notes_add_to_the_metadata_and_the_name_falls_back_to_the_files(writer: DriveLogWriter, tmp_path: Path) -> None:
    with writer:
        writer.note({"outcome": "arrived"})
        writer.note({"seed": "4"})
    log = read_drive_log(tmp_path / "log.mcap")
    assert log.metadata == {"seed": "4", "outcome": "arrived"}
    assert log.name == "log"
    assert log.duration == 0
    assert log.T_base_laser == Pose2(0.7, 0, 0)


def test_a_log_is_closed_when_its_block_ends_in_an_error_and_a_second_close_does_nothing(
    writer: DriveLogWriter, tmp_path: Path
) -> None:
    with pytest.raises(RuntimeError), writer:
        writer.joystick(0.0, 1, -1)
        raise RuntimeError
    writer.close()
    assert "incomplete" not in read_drive_log(tmp_path / "log.mcap").metadata
    with pytest.raises(ValueError, match="is closed"):
        writer.joystick(1.0, 0, 0)


def test_a_writer_refuses_what_no_reader_could_accept_and_goes_on(writer: DriveLogWriter, tmp_path: Path) -> None:
    scan = LaserScan([1.0, 2.0], -1.0, 1.0)
    writer.scan(1.0, scan)
    writer.joystick(1.0, 0.5, 0.5)
    refused = [
        (lambda: writer.scan(0.5, scan), "stamp on /scan goes back from 1.0 s to 0.5 s"),
        (lambda: writer.scan(2.0, LaserScan([1.0] * 3, -1.0, 1.0)), r"of a scan are \(3.0,"),
        (lambda: writer.scan(2.0, LaserScan([], -1.0, 1.0)), "a scan has 0 beams, must have at least 1"),
        (lambda: writer.joystick(np.nan, 0, 0), "stamp is nan s"),
        (lambda: writer.joystick(-1.0, 0, 0), r"stamp is -1.0 s, must lie in \[0, 2\^31\)"),
        (lambda: writer.joystick(2.0, 1.5, 0), r"forward on /joy is 1.5, must lie in \[-1, 1\]"),
        (lambda: writer.desired(2.0, 0, np.nan), "left on /joy_desired is nan"),
        (lambda: writer.odometry(2.0, Pose2(np.inf, 0, 0), Twist2(0, 0)), "odometry is inf"),
        (lambda: writer.command(2.0, Twist2(0, np.nan)), "command is nan"),
        (lambda: writer.plan(2.0, np.zeros((3, 3))), r"the plan at 2.0 s has shape \(3, 3\)"),
        (lambda: writer.intention(2.0, (1, 2, 3), 0.1), r"goal has shape \(3,\)"),
        (lambda: writer.intention(2.0, (1, 2), np.inf), "intention is inf"),
    ]
    for call, reason in refused:
        with pytest.raises(ValueError, match=reason):
            call()
    writer.close()
    log = read_drive_log(tmp_path / "log.mcap")
    assert (len(log.scan_stamp), len(log.joystick_stamp), len(log.odometry_stamp), len(log.plans)) == (1, 1, 0, 0)


def test_a_log_that_cannot_be_saved_leaves_the_old_file_alone(small_log: DriveLog, small_file: Path) -> None:
    import dataclasses

    before = small_file.read_bytes()
    with pytest.raises(ValueError, match="stamp is -1"):
        dataclasses.replace(small_log, scan_stamp=[-1.0, 0, 0, 0]).save(small_file)
    assert small_file.read_bytes() == before
    assert [p.name for p in small_file.parent.iterdir()] == ["small.mcap"]


@pytest.fixture
def careless_writer(writer: DriveLogWriter, monkeypatch: pytest.MonkeyPatch) -> DriveLogWriter:
    """A recorder that writes whatever stamps it is given."""
    monkeypatch.setattr(DriveLogWriter, "_time", lambda self, topic, stamp: round(stamp * 1e9))
    return writer


def test_beams_that_change_midway_are_refused_with_the_first_stamp_that_differs(
    careless_writer: DriveLogWriter, tmp_path: Path
) -> None:
    with careless_writer as log:
        for stamp, beams in ((1.0, 3), (2.0, 3), (3.0, 5), (4.0, 3)):
            log.scan(stamp, LaserScan([1.0] * beams, -1.0, 0.5))
            log._scan_layout = None
    with pytest.raises(DataError, match=r"log\.mcap: the scan at 3\.0 s has 5 beams, the first has 3"):
        read_drive_log(tmp_path / "log.mcap")


@pytest.mark.parametrize("stream", ["scan", "odometry", "joystick"])
def test_a_clock_that_jumps_back_is_refused_with_both_stamps(
    careless_writer: DriveLogWriter, tmp_path: Path, stream: str
) -> None:
    with careless_writer as log:
        for tick, stamp in enumerate((1.0, 2.0, 0.5, 3.0)):
            log.scan(stamp if stream == "scan" else tick, LaserScan([1.0, 2.0], -1.0, 1.0))
            log.odometry(stamp if stream == "odometry" else tick, Pose2(0, 0, 0), Twist2(0, 0))
            log.joystick(stamp if stream == "joystick" else tick, 0.0, 0.0)
    with pytest.raises(DataError, match=f"{stream}_stamp goes back from 2.0 s to 0.5 s at record 2"):
        read_drive_log(tmp_path / "log.mcap")


def test_records_of_one_stamp_are_all_kept_and_everything_can_still_be_asked(
    writer: DriveLogWriter, tmp_path: Path
) -> None:
    with writer as log:
        for tick in range(20):
            for copy in (0, 1):
                log.odometry(tick // 2, Pose2(0.1 * tick + copy, 0, 0), Twist2(0.5, 0))
                log.scan(tick // 2, LaserScan([1.0, 2.0], -1.0, 1.0))
    read = read_drive_log(tmp_path / "log.mcap")
    assert len(read.scan_stamp) == len(read.odometry_stamp) == 40
    assert np.isfinite(read.pose_at(np.linspace(-1, 20, 50))).all()
    inferred = joystick_from_motion(read)
    assert np.isfinite(inferred.joystick).all()
    assert len(inferred.joystick_stamp) == 40
