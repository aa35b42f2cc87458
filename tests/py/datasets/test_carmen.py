"""CARMEN logs: read as the reference reads them, refused with the line where they are broken."""

import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import read_carmen
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2

LOGS = ["freiburg-079", "fhw", "aces", "freiburg-101", "seattle"]


def flaser(stamp: float, ranges: list[float]) -> str:
    words = " ".join(f"{r:.2f}" for r in ranges)
    return f"FLASER {len(ranges)} {words} 9 9 9 9 9 9 {stamp} host {stamp}\n"


def odom(stamp: float, x: float, y: float = 0, yaw: float = 0) -> str:
    return f"ODOM {x} {y} {yaw} 0 0 0 {stamp} host 0.5\n"


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "drive.log"
    path.write_text(text)
    return path


def reference(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What path error is measured on: scan times, ranges, raw odometry (time, x, y, unwrapped heading)."""
    scans, rows = [], []
    with gzip.open(path, "rt") as lines:
        for w in map(str.split, lines):
            if w and w[0] == "FLASER":
                n = int(w[1])
                scans.append([float(w[8 + n]), *map(float, w[2 : 2 + n])])
            elif w and w[0] == "ODOM" and float(w[7]) > 0:
                rows.append([float(w[k]) for k in (7, 1, 2, 3)])
    s, o = np.array(scans), np.array(rows)
    o = o[np.r_[True, np.diff(o[:, 0]) > 0]]
    o[:, 3] = np.unwrap(o[:, 3])
    return s[:, 0], s[:, 1:], o


@pytest.mark.realdata
@pytest.mark.parametrize("name", LOGS)
def test_real_logs_are_read_to_the_last_bit_as_the_reference_reads_them(data_folder: Path, name: str) -> None:
    path = data_folder / "logs" / f"{name}-corrected.log.gz"
    stamp, ranges, odometry = reference(path)
    log = read_carmen(path)
    np.testing.assert_array_equal(log.scan_stamp, stamp)
    np.testing.assert_array_equal(np.c_[log.odometry_stamp, log.pose], odometry)
    np.testing.assert_array_equal(log.ranges, np.where(ranges >= log.range_max, np.inf, ranges).astype(np.float32))
    assert log.range_max == {"fhw": 50, "aces": 50}.get(name, 81)
    assert np.isinf(log.ranges).any()
    assert log.angle_increment == pytest.approx(math.pi / (360 if log.ranges.shape[1] > 181 else 180))
    assert log.name == f"{name}-corrected"


@pytest.mark.realdata
def test_the_last_share_of_a_real_log_keeps_every_path_the_reference_samples(data_folder: Path) -> None:
    log = read_carmen(data_folder / "logs" / "freiburg-079-corrected.log.gz")
    late = log.share(0.7, 1)
    assert late.scan_stamp[0] == log.scan_stamp[int(0.7 * len(log.scan_stamp))]
    assert late.odometry_stamp[0] + 0.5 <= late.scan_stamp[0]
    assert late.odometry_stamp[-1] == log.odometry_stamp[-1]


@pytest.mark.parametrize(("beams", "last"), [(180, 89.0), (360, 89.5), (181, 90.0), (361, 90.0)])
def test_the_angles_follow_from_the_number_of_beams(tmp_path: Path, beams: int, last: float) -> None:
    scan = read_carmen(write(tmp_path, flaser(1, [2.0] * beams))).scan(0)
    assert math.degrees(scan.angles()[0]) == pytest.approx(-90)
    assert math.degrees(scan.angles()[-1]) == pytest.approx(last)


@pytest.mark.parametrize(
    ("readings", "expected"),
    [
        ([81.91, 81.83, 60.0, 50.0], [math.inf, math.inf, 60.0, 50.0]),
        ([51.1, 50.0, 49.9, 1.0], [math.inf, math.inf, 49.9, 1.0]),
        ([20.0, 30.0, 1.0, 0.0], [20.0, 30.0, 1.0, math.nan]),
    ],
)
def test_readings_at_the_sensors_end_are_no_return(
    tmp_path: Path, readings: list[float], expected: list[float]
) -> None:
    log = read_carmen(write(tmp_path, flaser(1, readings * 45)))
    np.testing.assert_array_equal(log.ranges[0, :4], np.array(expected, np.float32))


def test_odometry_without_a_time_or_back_in_time_is_dropped_and_the_rest_differentiated(tmp_path: Path) -> None:
    lines = (
        [odom(0.0, 99)] + [odom(1 + k / 10, 0.05 * k, 0, 0.02 * k) for k in range(21)] + [odom(1.5, 7), odom(0.0, 8)]
    )
    log = read_carmen(write(tmp_path, "# a comment\nPARAM x y\n\nNEFF 1\n" + "".join(lines) + flaser(2, [1.0] * 180)))
    assert len(log.odometry_stamp) == 21
    np.testing.assert_allclose(log.twist[0], 0)
    np.testing.assert_allclose(log.twist[1:, 1], 0.2)
    assert log.twist[20, 0] == pytest.approx(0.5 * math.cos(0.35), rel=1e-6)
    assert log.T_base_laser is None
    assert log.metadata["T_base_laser"].startswith("unknown: no PARAM robot_frontlaser_offset; say --mounting")


def test_parameters_say_where_the_scanner_is_and_that_it_hangs_upside_down(tmp_path: Path) -> None:
    ranges = [1.0 + 0.01 * k for k in range(181)]
    said = "PARAM robot_frontlaser_offset 0.25 nohost 0\n"
    upright = read_carmen(write(tmp_path, said + flaser(1, ranges)))
    assert upright.mounting == Pose2(0.25, 0, 0)
    flipped = read_carmen(write(tmp_path, said + "PARAM laser_flipped on nohost 0\n" + flaser(1, ranges)))
    np.testing.assert_allclose(flipped.scan(0).angles(), -upright.scan(0).angles())
    with pytest.raises(DataError, match="PARAM robot_frontlaser_offset"):
        read_carmen(write(tmp_path, "PARAM robot_frontlaser_offset nan x\n" + flaser(1, ranges)))


def test_scans_up_to_a_second_late_are_sorted_and_told(tmp_path: Path) -> None:
    stamps = [1.0, 2.0, 3.0, 2.4, 2.3, 4.0]
    log = read_carmen(write(tmp_path, "".join(flaser(t, [t] * 180) for t in stamps)))
    assert log.scan_stamp.tolist() == sorted(stamps)
    np.testing.assert_allclose(log.ranges[:, 0], sorted(stamps))
    assert log.metadata["scan records"] == "2 sorted"


def test_the_mounting_and_the_range_are_taken_as_given(tmp_path: Path) -> None:
    log = read_carmen(write(tmp_path, flaser(1, [9.0] * 181)), T_base_laser=Pose2(0.3, 0, 0), range_max=8.0)
    assert log.T_base_laser == Pose2(0.3, 0, 0)
    assert log.range_max == 8.0
    assert np.isinf(log.ranges).all()
    with pytest.raises(ValueError, match="range_max is 0 m, must be positive"):
        read_carmen(tmp_path / "drive.log", range_max=0)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "holds no FLASER line"),
        (odom(1, 2), "holds no FLASER line"),
        ("FLASER\n", "line 1: a scan of 0 beams"),
        ("FLASER many\n", "line 1: invalid literal"),
        (flaser(1, [1.0] * 90), "line 1: a scan of 90 beams: their angles are known for"),
        (flaser(1, [1.0] * 180)[:-30], "line 1: FLASER of 180 beams has"),
        (flaser(1, [1.0] * 180) + flaser(2, [1.0] * 181), "line 2: a scan of 181 beams, the first has 180"),
        (flaser(1, [1.0] * 180).replace("1.00", "-1.00", 1), "line 1: a range is -1.00 m"),
        (flaser(1, [1.0] * 180).replace("1.00", "x", 1), "line 1: could not convert"),
        (
            "".join(flaser(t, [1.0] * 180) for t in (20, 21, 1, 2)),
            "the clock of FLASER was set back by 20 s at its record 2",
        ),
        (flaser(float("nan"), [1.0] * 180), "line 1: time is nan"),
        (flaser(1, [1.0] * 180) + "ODOM 1 2\n", "line 2: ODOM has 3 words, must have 10"),
        (flaser(1, [1.0] * 180) + odom(1, math.inf), "line 2: x is inf, must be finite"),
        ("x" * (1 << 20), "line 1: longer than 1048576 bytes"),
    ],
)
def test_a_broken_log_is_refused_with_file_and_line(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(DataError, match=reason) as caught:
        read_carmen(write(tmp_path, text))
    assert "drive.log" in str(caught.value)


def test_a_gzipped_log_cut_anywhere_is_refused(tmp_path: Path) -> None:
    whole = gzip.compress("".join(flaser(k, [1.0 + k] * 180) for k in range(5)).encode())
    path = tmp_path / "drive.log.gz"
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        with pytest.raises(DataError, match=r"drive\.log\.gz"):
            read_carmen(path)
    path.write_bytes(whole)
    assert len(read_carmen(path).scan_stamp) == 5


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_garbled_text_is_read_or_refused_but_never_crashes(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    text = bytearray(("".join(odom(k, k) + flaser(k, [1.0] * 180) for k in range(1, 4))).encode())
    for _ in range(data.draw(st.integers(1, 6))):
        text[data.draw(st.integers(0, len(text) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("garbled") / "drive.log"
    path.write_bytes(bytes(text))
    try:
        read_carmen(path)
    except DataError as error:
        assert "drive.log" in str(error)


def test_odometry_behind_a_late_line_is_dropped_too(tmp_path: Path) -> None:
    stamps = [0.1, 0.2, 0.3, 1.0, 0.6, 0.7, 1.1, 1.2, 1.3]
    log = read_carmen(write(tmp_path, flaser(1, [1.0] * 180) + "".join(odom(t, t) for t in stamps)))
    assert log.odometry_stamp.tolist() == [0.1, 0.2, 0.3, 1.0, 1.1, 1.2, 1.3]
    assert log.metadata["dropped"] == "lines: 2 ODOM not forward in time"


def test_every_line_that_is_left_out_is_counted(tmp_path: Path) -> None:
    text = flaser(1, [1.0] * 180) + odom(1, 0) + odom(0, 1) + odom(-2, 1) + odom(1, 2) + odom(2, 3)
    log = read_carmen(write(tmp_path, text + "RLASER 180 1 2\nROBOTLASER1 0\nROBOTLASER1 0\nSYNC x\n"))
    assert len(log.odometry_stamp) == 2
    assert log.metadata["dropped"] == (
        "lines: 1 ODOM not forward in time, 2 ODOM without a time, 1 RLASER, 2 ROBOTLASER1"
    )
    assert "dropped" not in read_carmen(write(tmp_path, flaser(1, [1.0] * 180) + odom(1, 0))).metadata


def test_beams_that_change_from_180_to_361_are_refused_not_left_out(tmp_path: Path) -> None:
    text = "".join(flaser(k, [1.0] * beams) for k, beams in enumerate((180, 180, 361, 180), 1))
    with pytest.raises(DataError, match="line 3: a scan of 361 beams, the first has 180"):
        read_carmen(write(tmp_path, text))
