"""Bags of other robots: the room is the right way round, or a sentence says what to type; never quietly wrong."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bags import EPOCH, Messages, joy, odometry, scan, transform, twist, write_ros2
from lfdcore.datasets import DriveLog, read_rosbag
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2
from lfdcore.grid import read_beams

TICKS = 40
RANGES = np.linspace(1.0, 4.0, 181)
"""[m] Left is farther than right, so that a mirrored world is another one."""


def bag(path: Path, *changes: Messages, static: Messages | None = None, scans: Messages | None = None) -> Path:
    """A drive of four seconds with what is changed: streams by topic, in the place of the usual ones."""
    usual: dict[str, Messages] = {
        "/tf_static": [transform("base_link", "laser", (0.7, 0.0, 0.3), (0.0, 0.0, 0.0))] if static is None else static,
        "/scan": [scan(k, RANGES) for k in range(TICKS)] if scans is None else scans,
        "/odom": [odometry(k, (0.05 * k, 0.0, 0.0)) for k in range(TICKS)],
        "/joy": [joy(k, (0.0, 1.0)) for k in range(TICKS)],
    }
    for messages in changes:
        usual |= {topic: [one for one in messages if one[0] == topic] for topic in {one[0] for one in messages}}
    return write_ros2(path / "bag", [one for stream in usual.values() for one in stream])


def points(log: DriveLog, index: int = 0) -> NDArray[np.float64]:
    """(N, 2) [m] what the scan hit, in base_link, in the order of their angles"""
    one = log.scan(index)
    lengths, hit = read_beams(one)
    angles, far = one.angles()[hit], lengths[hit]
    return np.asarray(log.mounting.transform(far[:, None] * np.c_[np.cos(angles), np.sin(angles)]))


def true_points(T: NDArray[np.float64], ranges: Sequence[float] = tuple(RANGES)) -> NDArray[np.float64]:
    """(N, 2) [m] where a scanner at T_base_laser (4, 4) sees these ranges, from -90 to 90 degrees of its own"""
    angles = -math.pi / 2 + math.pi / 180 * np.arange(len(ranges))
    far = np.asarray(ranges, np.float32).astype(float)
    return np.asarray((np.c_[far * np.cos(angles), far * np.sin(angles), 0 * far, 0 * far + 1] @ T.T)[:, :2])


def placed(x: float, y: float, roll: float, yaw: float) -> NDArray[np.float64]:
    c, s, r = math.cos(yaw), math.sin(yaw), math.cos(roll)
    return np.array([[c, -s * r, 0, x], [s, c * r, 0, y], [0, 0, r, 0.3], [0, 0, 0, 1]])


def test_an_upside_down_scanner_shows_the_room_the_right_way_round(tmp_path: Path) -> None:
    log = read_rosbag(bag(tmp_path, static=[transform("base_link", "laser", (0.7, 0.0, 0.3), (math.pi, 0.0, 0.5))]))
    np.testing.assert_allclose(points(log), true_points(placed(0.7, 0.0, math.pi, 0.5)), atol=1e-6)


def test_a_tilted_scanner_is_refused_with_its_angle(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"tilted by 20\.0 degrees"):
        read_rosbag(bag(tmp_path, static=[transform("base_link", "laser", (0.7, 0, 0.3), (0.0, math.radians(20), 0))]))


def test_a_mounting_is_found_up_and_down_the_tree_and_on_tf_where_it_never_changes(tmp_path: Path) -> None:
    both = [
        transform("base_footprint", "base_link", (0.0, 0.0, 0.1), (0.0, 0.0, 0.0)),
        transform("base_link", "laser", (0.7, 0.1, 0.3), (0.0, 0.0, 0.2)),
    ]
    for base in ("base_link", "base_footprint"):
        odom = [odometry(k, (0.05 * k, 0.0, 0.0), base=base) for k in range(TICKS)]
        on_tf = [
            transform(*pair, (0.1 * k if moves else x, 0.1, 0.3), (0.0, 0.0, 0.2), topic="/tf", at=k)
            for k in range(TICKS)
            for pair, moves, x in (((base, "laser"), False, 0.7), (("odom", base), True, 0.0))
        ]
        (tmp_path / base / "tf").mkdir(parents=True)
        for log in (
            read_rosbag(bag(tmp_path / base, odom, static=both)),
            read_rosbag(bag(tmp_path / base / "tf", odom, on_tf, static=[])),
        ):
            np.testing.assert_allclose([*log.mounting], [0.7, 0.1, 0.2], atol=1e-9)


def test_a_count_of_beams_that_wavers_is_put_on_the_first_scans_angles(tmp_path: Path) -> None:
    short = [scan(k, RANGES[: 181 - (k % 3 == 2)]) for k in range(TICKS)]
    log = read_rosbag(bag(tmp_path, scans=short))
    assert log.ranges.shape == (TICKS, 181)
    np.testing.assert_allclose(log.ranges[2, :180], RANGES[:180].astype(np.float32))
    assert np.isnan(log.ranges[2, 180])
    assert log.metadata["beams"] == "13 scans were put on the angles of the first"


@pytest.mark.parametrize("turn", [0.0, 2 * math.pi])
def test_an_all_round_scanner_whose_increment_wavers_keeps_each_beam_within_half_an_increment(
    turn: float, tmp_path: Path
) -> None:
    def wavering(k: int) -> Any:
        count = 360 + k % 4
        angles = -math.pi + 2 * math.pi / count * np.arange(count)
        return scan(k, 2 + np.cos(angles), angle_min=-math.pi + turn * (k % 2), increment=2 * math.pi / count)

    log = read_rosbag(bag(tmp_path, scans=[wavering(k) for k in range(TICKS)]))
    truth = 2 + np.cos(log.scan(0).angles())
    seen = ~np.isnan(log.ranges)
    assert seen.mean() > 0.99
    assert np.nanmax(np.abs(log.ranges - truth)) < 1.01 * math.radians(0.5)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"angle_max": math.pi / 2, "increment": -math.pi / 180}, "contradict each other"),
        ({"increment": 1.0, "angle_min": -90.0}, "in degrees"),
        ({"range_max": 30_000.0}, "in millimetres"),
        ({"ranges": 1000 * RANGES}, "in millimetres"),
    ],
)
def test_angles_and_units_that_cannot_be_are_refused_by_name(change: dict[str, Any], why: str, tmp_path: Path) -> None:
    ranges = change.pop("ranges", RANGES)
    with pytest.raises(DataError, match=f"/scan.*{why}"):
        read_rosbag(bag(tmp_path, scans=[scan(k, ranges, **change) for k in range(TICKS)]))


def test_an_angle_max_that_counts_one_beam_too_many_is_common_and_read(tmp_path: Path) -> None:
    log = read_rosbag(bag(tmp_path, scans=[scan(k, RANGES, angle_max=math.radians(91)) for k in range(TICKS)]))
    np.testing.assert_allclose(points(log), true_points(placed(0.7, 0, 0, 0)), atol=1e-6)


def test_a_range_of_exactly_0_is_no_measurement_also_with_a_range_min_of_0(tmp_path: Path) -> None:
    ranges = np.where(np.arange(181) < 60, 0.0, RANGES)
    log = read_rosbag(bag(tmp_path, scans=[scan(k, ranges, range_min=0.0) for k in range(TICKS)]))
    assert np.isnan(log.ranges[:, :60]).all()


def test_an_infinite_range_max_is_none(tmp_path: Path) -> None:
    ranges = np.where(np.arange(181) < 60, np.inf, RANGES)
    log = read_rosbag(bag(tmp_path, scans=[scan(k, ranges, range_max=math.inf) for k in range(TICKS)]))
    assert math.isfinite(log.range_max)
    assert len(points(log)) == 121


@pytest.mark.parametrize("topic", ["/scan", "/odom"])
def test_two_publishers_on_a_topic_are_an_error_naming_both(topic: str, tmp_path: Path) -> None:
    other = (
        [scan(k, RANGES, frame="laser_rear" if k % 2 else "laser") for k in range(TICKS)]
        if topic == "/scan"
        else [odometry(k, (5.0 * (k % 2), 0.0, 0.0), frame="map" if k % 2 else "odom") for k in range(TICKS)]
    )
    names = "laser_rear.* laser" if topic == "/scan" else "map and base_link.* odom and base_link"
    with pytest.raises(DataError, match=f"{topic} is of {names}: two publishers"):
        read_rosbag(bag(tmp_path, other))


@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.6, 0.0)])
def test_orientations_that_are_no_rotation_are_refused(turned: tuple[float, ...], tmp_path: Path) -> None:
    wrong = [odometry(k, (0.05 * k, 0.0, 0.0), turned=turned) for k in range(TICKS)]
    with pytest.raises(DataError, match=r"/odom at .* has length .* it is no rotation"):
        read_rosbag(bag(tmp_path, wrong))


def test_orientations_that_are_nearly_rotations_are(tmp_path: Path) -> None:
    nearly = (0.0, 0.0, 0.995 * math.sin(0.4), 0.995 * math.cos(0.4))
    log = read_rosbag(bag(tmp_path, [odometry(k, (0.0, 0.0, 0.0), turned=nearly) for k in range(TICKS)]))
    np.testing.assert_allclose(log.pose[:, 2], 0.8, atol=1e-12)


def test_streams_of_two_clocks_are_told_by_receipt(tmp_path: Path) -> None:
    """Scans and odometry in simulated time, the stick by the wall, commands without a header."""
    simulated = -EPOCH + 5_000_000_000
    log = read_rosbag(
        bag(
            tmp_path,
            [scan(k, RANGES, header=simulated) for k in range(TICKS)],
            [odometry(k, (0.05 * k, 0.0, 0.0), header=simulated) for k in range(TICKS)],
            [joy(k, (0.0, 1.0 if k >= 20 else 0.0)) for k in range(TICKS)],
            [twist(k, 0.5) for k in range(TICKS)],
        )
    )
    assert log.duration == pytest.approx(0.1 * (TICKS - 1))
    np.testing.assert_allclose(log.joystick_at([1.95, 2.05])[:, 0], [0.0, 1.0])
    np.testing.assert_allclose(log.command_stamp, log.scan_stamp, atol=1e-6)
    assert "by receipt: its own clock is" in log.metadata["joystick records"]


def test_two_clocks_that_receipt_cannot_tell_apart_are_an_error_naming_both(tmp_path: Path) -> None:
    at_once = [replace_receipt(scan(k, RANGES)) for k in range(TICKS)]
    late = [replace_receipt(odometry(k, (0.0, 0.0, 0.0), header=-EPOCH + 1)) for k in range(TICKS)]
    with pytest.raises(DataError, match=r"/odom is from 0\.000 to 3\.900 s, /scan from 17000.*two clocks"):
        read_rosbag(bag(tmp_path, at_once, late))


def replace_receipt(one: Any) -> Any:
    return (one[0], one[1], EPOCH, one[3])


def test_the_first_messages_before_a_simulated_clock_ran_do_not_make_the_log_54_years_long(tmp_path: Path) -> None:
    simulated = -EPOCH
    log = read_rosbag(
        bag(
            tmp_path,
            [scan(k, RANGES, header=simulated) for k in range(TICKS)],
            [odometry(k, (0.05 * k, 0.0, 0.0), header=simulated) for k in range(TICKS)],
            [joy(k, (0.0, 0.0), header=simulated) for k in range(TICKS)],
        )
    )
    assert log.duration < 4.0
    assert log.metadata["scan records"] == "1 without a time left out"


def test_a_clock_that_was_set_back_is_refused_and_one_late_record_is_not(tmp_path: Path) -> None:
    late = [scan(k, RANGES, header=-5_000_000_000 if k == 30 else 0) for k in range(TICKS)]
    assert "1 left out" in read_rosbag(bag(tmp_path, late)).metadata["scan records"]
    (tmp_path / "back").mkdir()
    back = [scan(k, RANGES, header=-5_000_000_000 if k >= 30 else 0) for k in range(TICKS)]
    with pytest.raises(DataError, match=r"the clock of /scan was set back by 4\.9 s at its record 30"):
        read_rosbag(bag(tmp_path / "back", back))


def test_an_axis_of_minus_32768_of_32767_is_full_stick(tmp_path: Path) -> None:
    log = read_rosbag(bag(tmp_path, [joy(k, (0.0, -32768 / 32767)) for k in range(TICKS)]))
    assert (log.joystick[:, 0] == -1).all()
    assert len(log.joystick) == TICKS


def test_optional_streams_of_which_there_are_several_are_left_out_and_said(tmp_path: Path) -> None:
    several = [twist(k, 0.5, topic) for k in range(TICKS) for topic in ("/cmd_vel", "/cmd_vel_nav")]
    path = bag(tmp_path, several)
    log = read_rosbag(path)
    assert len(log.command) == 0
    assert log.metadata["command left out"] == "/cmd_vel, /cmd_vel_nav: --command chooses one"
    assert len(read_rosbag(path, command="/cmd_vel_nav").command) == TICKS
    assert "command left out" not in read_rosbag(path, command="none").metadata


def test_odometry_may_come_from_tf(tmp_path: Path) -> None:
    moving = [
        transform("odom", "base_link", (0.05 * k, 0.0, 0.0), (0.0, 0.0, 0.0), topic="/tf", at=k) for k in range(TICKS)
    ]
    moving += [transform("map", "odom", (0.01 * k, 0, 0), (0, 0, 0), topic="/tf", at=k) for k in range(TICKS)]
    path = bag(tmp_path, moving, [])
    with_topic = read_rosbag(path, odometry="tf")
    np.testing.assert_allclose(with_topic.pose[:, 0], 0.05 * np.arange(TICKS))
    np.testing.assert_allclose(with_topic.twist[-1], [0.5, 0.0], atol=1e-6)
    assert with_topic.mounting == Pose2(0.7, 0.0, 0.0)


CODES = (0.0, math.nan, math.inf, -math.inf, 65.533, 8.0, 0.01)
"""What drivers say where nothing was seen, or nothing measured"""


@settings(max_examples=60, deadline=None)
@given(
    x=st.floats(-1, 1),
    y=st.floats(-1, 1),
    yaw=st.floats(-math.pi, math.pi),
    upside_down=st.booleans(),
    reversed_beams=st.booleans(),
    offset=st.sampled_from([0, 17, -EPOCH + 10**9, 3600 * 10**9]),
    code=st.sampled_from(CODES),
    which=st.sampled_from(["/scan", "/odom", "/joy"]),
)
def test_whatever_mounting_beams_clock_and_codes_a_robot_has_its_room_is_the_same(
    tmp_path_factory: pytest.TempPathFactory,
    x: float,
    y: float,
    yaw: float,
    upside_down: bool,
    reversed_beams: bool,
    offset: int,
    code: float,
    which: str,
) -> None:
    roll = math.pi if upside_down else 0.0
    T = placed(x, y, roll, yaw)
    unseen = np.arange(181) % 7 == 0
    ranges = np.where(unseen, code, RANGES)
    turn = -1 if reversed_beams else 1
    said = {
        "ranges": ranges[::turn],
        "angle_min": -turn * math.pi / 2,
        "angle_max": turn * math.pi / 2,
        "increment": turn * math.pi / 180,
        "range_max": 8.0,
        "range_min": 0.05,
    }
    headers = {topic: offset if topic == which else 0 for topic in ("/scan", "/odom", "/joy")}
    path = bag(
        tmp_path_factory.mktemp("bag"),
        [scan(k, header=headers["/scan"], **said) for k in range(12)],
        [odometry(k, (0.05 * k, 0.0, 0.0), header=headers["/odom"]) for k in range(12)],
        [joy(k, (0.0, 1.0), header=headers["/joy"]) for k in range(12)],
        static=[transform("base_link", "laser", (x, y, 0.3), (roll, 0.0, yaw))],
    )
    log = read_rosbag(path)
    hit = ~unseen if code != -math.inf else np.ones(181, bool)
    truth = true_points(T, np.where(unseen & (code == -math.inf), 0.05, RANGES))[hit]
    seen = points(log)
    order = [np.lexsort(np.round(each, 4).T) for each in (seen, truth)]
    np.testing.assert_allclose(seen[order[0]], truth[order[1]], atol=1e-6)
