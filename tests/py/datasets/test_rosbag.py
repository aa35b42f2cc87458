"""ROS 1 and ROS 2 bags: topics found by type, choices left to the caller, mounting from the static transforms."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bags import EPOCH, Messages, write_ros2
from lfdcore.datasets import DriveLog, open_log, read_rosbag
from lfdcore.datasets import ros_messages as ros
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan, read_beams

SCAN = LaserScan([0.05, 1.0, 40.0, np.inf], -1.5, 1.0, 0.1, 30.0)


def drive(base: str = "base_link") -> Messages:
    """(topic, type, time received [ns], message) of three ticks, out of order on /odom."""
    messages: Messages = [
        (
            "/tf_static",
            "tf2_msgs/msg/TFMessage",
            EPOCH,
            ros.transform_message(EPOCH, base, "mast", Pose2(0.5, 0, np.pi / 2)),
        ),
        (
            "/tf_static",
            "tf2_msgs/msg/TFMessage",
            EPOCH,
            ros.transform_message(EPOCH, "mast", "laser", Pose2(0.2, 0, 0)),
        ),
    ]
    for tick in (0, 2, 1):
        at = EPOCH + tick * 100_000_000
        messages += [
            ("/odom", "nav_msgs/msg/Odometry", at, ros.odometry_message(at, Pose2(tick, 0, 0.5), Twist2(0.1, tick))),
            ("/base_scan", "sensor_msgs/msg/LaserScan", at, ros.scan_message(at, SCAN)),
            ("/joy", "sensor_msgs/msg/Joy", at, ros.joystick_message(at, -0.25 * tick, 0.5)),
            ("/cmd", "geometry_msgs/msg/Twist", at, ros.command_message(at, Twist2(0.3, -tick)).twist),
        ]
    return messages


def to_ros1(value: Any, store: Any) -> Any:
    """The same message in ROS 1's types (its headers also count)."""
    kind = getattr(value, "__msgtype__", None)
    if kind is None:
        return [to_ros1(one, store) for one in value] if isinstance(value, list) else value
    fields = {
        name: to_ros1(getattr(value, name), store) for name in value.__dataclass_fields__ if name != "__msgtype__"
    }
    if kind == "std_msgs/msg/Header":
        fields["seq"] = 0
    return store.types[kind](**fields)


def write_ros1(path: Path, messages: Messages) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    with Writer1(path) as writer:
        connections: dict[str, Any] = {}
        for topic, kind, at, message in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], at, store.serialize_ros1(to_ros1(message, store), kind))
    return path


WRITERS: dict[str, Callable[[Path, Messages], Path]] = {
    "ros1": lambda folder, messages: write_ros1(folder / "drive.bag", messages),
    "ros2 sqlite3": lambda folder, messages: write_ros2(folder / "drive", messages),
    "ros2 mcap": lambda folder, messages: write_ros2(folder / "drive", messages, StoragePlugin.MCAP),
    "lone db3": lambda folder, messages: next(write_ros2(folder / "drive", messages).glob("*.db3")),
    "lone mcap": lambda folder, messages: next(
        write_ros2(folder / "drive", messages, StoragePlugin.MCAP).glob("*.mcap")
    ),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_every_kind_of_bag_gives_the_same_drive(tmp_path: Path, kind: str) -> None:
    log = open_log(WRITERS[kind](tmp_path, drive()))
    np.testing.assert_allclose(log.scan_stamp, [0, 0.1, 0.2])
    np.testing.assert_allclose(log.pose, [[0, 0, 0.5], [1, 0, 0.5], [2, 0, 0.5]])
    np.testing.assert_allclose(log.twist, [[0.1, 0], [0.1, 1], [0.1, 2]])
    np.testing.assert_array_equal(log.ranges[0], np.array([np.nan, 1, np.inf, np.inf], np.float32))
    np.testing.assert_array_equal(log.joystick, [[0.5, 0], [0.5, -0.25], [0.5, -0.5]])  # Joy.axes[1] is forward
    np.testing.assert_allclose(log.command, [[0.3, 0], [0.3, -1], [0.3, -2]])
    assert tuple(log.T_base_laser) == pytest.approx((0.5, 0.2, np.pi / 2))
    assert log.metadata["scan topic"] == "/base_scan"
    assert log.metadata["epoch [ns]"] == str(EPOCH)
    assert (log.angle_min, log.range_max) == (-1.5, 30)


def scans_of(*scans: LaserScan) -> Messages:
    """A drive with these scans in place of its own."""
    rest = [one for one in drive() if one[0] != "/base_scan"]
    times = [EPOCH + k * 100_000_000 for k in range(len(scans))]
    own = [
        ("/base_scan", "sensor_msgs/msg/LaserScan", at, ros.scan_message(at, scan))
        for at, scan in zip(times, scans, strict=True)
    ]
    return rest + own


def test_what_rep_117_says_of_a_range_is_neither_lost_nor_made_up(tmp_path: Path) -> None:
    nan, inf = np.nan, np.inf
    ranges = np.array([nan, -inf, inf, 0, -3, 0.125, 0.25, 2, 8, 40], np.float32)
    scan = LaserScan(ranges, -1.5, 0.1, 0.25, 8.0)
    log = read_rosbag(write_ros2(tmp_path / "drive", scans_of(scan)))
    kept = np.array([nan, -inf, inf, nan, nan, nan, 0.25, 2, inf, inf], np.float32)
    np.testing.assert_array_equal(log.ranges[0], kept)
    for read, meant in zip(read_beams(log.scan(0)), read_beams(scan), strict=True):
        np.testing.assert_array_equal(read, meant)


def test_a_range_is_judged_by_the_limits_of_its_own_message(tmp_path: Path) -> None:
    """The log keeps the limits of the first."""
    ranges = np.array([0.5, 2, 5, 20], np.float32)
    far, near = LaserScan(ranges, -1.5, 0.1, 0.25, 30.0), LaserScan(ranges, -1.5, 0.1, 1.0, 4.0)
    log = read_rosbag(write_ros2(tmp_path / "drive", scans_of(far, near)))
    np.testing.assert_array_equal(log.ranges, np.array([ranges, [np.nan, 2, np.inf, np.inf]], np.float32))


def test_two_topics_of_a_type_are_an_error_that_names_them_until_one_is_chosen(tmp_path: Path) -> None:
    second = [("/rear_scan", kind, at, message) for topic, kind, at, message in drive() if topic == "/base_scan"]
    bag = write_ros2(tmp_path / "drive", drive() + second)
    with pytest.raises(
        ValueError, match=r"more than one topic for scan: /base_scan, /rear_scan; say --scan TOPIC \(in Python scan=\)"
    ):
        read_rosbag(bag)
    assert read_rosbag(bag, scan="/rear_scan").metadata["scan topic"] == "/rear_scan"
    assert len(open_log(bag, scan="/base_scan").scan_stamp) == 3
    with pytest.raises(ValueError, match=r"scan is '/joy', .* has \['/base_scan', '/rear_scan'\] of sensor_msgs"):
        read_rosbag(bag, scan="/joy")


def test_a_bag_without_scans_or_odometry_names_what_it_holds(tmp_path: Path) -> None:
    bag = write_ros2(tmp_path / "drive", [one for one in drive() if one[0] in ("/joy", "/odom")])
    with pytest.raises(
        DataError, match=r"no message of type sensor_msgs/msg/LaserScan, so no scan; it holds /joy \(sensor"
    ):
        read_rosbag(bag)


def test_a_mounting_that_nothing_says_is_unknown_and_asked_for(tmp_path: Path) -> None:
    bag = write_ros2(tmp_path / "drive", drive(base="base_footprint"))
    log = read_rosbag(bag)
    assert log.T_base_laser is None
    assert log.metadata["T_base_laser"].startswith("unknown: no transform joins laser and base_link; say --mounting")
    with pytest.raises(DataError, match="say --mounting X,Y,YAW"):
        _ = log.mounting
    log.save(tmp_path / "unknown.mcap")
    assert open_log(tmp_path / "unknown.mcap").T_base_laser is None
    assert read_rosbag(bag, T_base_laser=Pose2(1, 2, 3)).mounting == Pose2(1, 2, 3)


def test_transforms_that_go_round_are_an_error(tmp_path: Path) -> None:
    ring = [
        ("/tf_static", "tf2_msgs/msg/TFMessage", EPOCH, ros.transform_message(EPOCH, parent, child, Pose2(1, 0, 0)))
        for parent, child in (("mast", "laser"), ("laser", "mast"))
    ]
    with pytest.raises(DataError, match="run in a circle"):
        read_rosbag(write_ros2(tmp_path / "drive", drive()[2:] + ring))


ODD: list[tuple[str, str, Any, str]] = [
    ("/base_scan", "sensor_msgs/msg/LaserScan", ros.scan_message(EPOCH, LaserScan([1.0], 0, 5)), "increment of 5 rad"),
    ("/joy", "sensor_msgs/msg/Joy", ros.joystick_message(EPOCH, 3.0, 0), r"the axes \(1, 0\) are \[0.0, 3.0\]"),
    (
        "/odom",
        "nav_msgs/msg/Odometry",
        ros.odometry_message(EPOCH, Pose2(np.nan, 0, 0), Twist2(0, 0)),
        r"pose and twist are \(nan",
    ),
]


@pytest.mark.parametrize(("topic", "kind", "message", "reason"), ODD)
def test_one_odd_record_costs_that_record_and_many_the_bag(
    tmp_path: Path, topic: str, kind: str, message: Any, reason: str
) -> None:
    def odd(count: int) -> Messages:
        return [(topic, kind, EPOCH + 10**9 + k, message) for k in range(count)]

    log = read_rosbag(write_ros2(tmp_path / "one", [*drive(), *odd(1)]))
    assert (len(log.scan_stamp), len(log.odometry_stamp), len(log.joystick_stamp)) == (3, 3, 3)
    assert [note for name, note in log.metadata.items() if name.endswith("records") and "1 " in note]
    with pytest.raises(DataError, match=f"{topic} at .*{reason}.* in 4 of 7 records"):
        read_rosbag(write_ros2(tmp_path / "many", [*drive(), *odd(4)]))


def test_axes_that_a_joystick_lacks_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"it has 2 axes, \(forward, left\) are said to be \(1, 4\): say --axes"):
        read_rosbag(write_ros2(tmp_path / "drive", drive()), joystick_axes=(1, 4))


@pytest.mark.parametrize("kind", ["ros1", "lone mcap", "lone db3"])
def test_a_cut_bag_is_refused_or_read_in_part(tmp_path: Path, kind: str) -> None:
    path = WRITERS[kind](tmp_path, drive())
    whole = path.read_bytes()
    refused = 0
    for size in np.linspace(1, len(whole) - 1, 40).astype(int):
        path.write_bytes(whole[:size])
        try:
            assert isinstance(read_rosbag(path), DriveLog)
        except DataError as error:
            refused += 1
            assert path.name in str(error)
    assert refused >= 20


@pytest.fixture(scope="module")
def small_bag(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return write_ros1(tmp_path_factory.mktemp("bag") / "drive.bag", drive()).read_bytes()


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_garbled_bag_is_read_or_refused_but_never_crashes(
    small_bag: bytes, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("garbled") / "drive.bag"
    whole = bytearray(small_bag)
    for _ in range(data.draw(st.integers(1, 6))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(bytes(whole))
    try:
        read_rosbag(path)
    except (DataError, ValueError) as error:
        assert path.name in str(error)


def test_a_bag_that_is_not_there_is_not_found(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        read_rosbag(tmp_path / "none.bag")


def test_a_bag_whose_stamps_go_back_is_sorted_and_says_how_often(tmp_path: Path) -> None:
    received = [(topic, kind, EPOCH + k, message) for k, (topic, kind, _, message) in enumerate(drive())]
    (tmp_path / "late").mkdir()
    late = open_log(WRITERS["lone mcap"](tmp_path / "late", received))
    np.testing.assert_allclose(late.scan_stamp, [0, 0.1, 0.2])
    assert [late.metadata[f"{role} records"] for role in ("scan", "odometry", "joystick")] == ["1 sorted"] * 3
    assert "scan records" not in open_log(WRITERS["lone mcap"](tmp_path, drive())).metadata


def test_scans_that_are_none_are_refused_with_the_stamp(tmp_path: Path) -> None:
    messages = scans_of(SCAN, SCAN, SCAN)
    for message in messages[-2:]:
        message[-1].range_max = 0.0
    with pytest.raises(DataError, match=r"/base_scan at 1700000000\.1.* s: .*range_max"):
        read_rosbag(write_ros2(tmp_path / "drive", messages))
