"""MRPT rawlogs: the real one's known numbers, hand-made ones, and broken ones."""

import gzip
import math
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets import DriveLog, read_mrpt
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, arc_length

SENA = "sena-wheelchair-one-loop.rawlog"
SECOND = 10_000_000  # ticks


def thing(name: str, version: int, body: bytes) -> bytes:
    return bytes([0x80 | len(name)]) + name.encode() + bytes([version]) + body + b"\x88"


def pose_2d(x: float, y: float, yaw: float) -> bytes:
    return thing("CPose2D", 1, struct.pack("<ddd", x, y, yaw))


def pose_3d(x: float = 0.78, y: float = 0.1, yaw: float = 0.2, roll: float = 0.0) -> bytes:
    c, s = math.cos(yaw), math.sin(yaw)
    matrix = [[c, -s, 0, x], [s, c, 0, y], [0, 0, math.cos(roll), 0.3], [0, 0, 0, 1]]
    inner = thing("CMatrixD", 0, struct.pack("<II", 4, 4) + np.array(matrix).tobytes())
    return thing("CPose3D", 1, inner)


def scan(ticks: int, ranges: list[float], valid: list[int] | None = None, pose: bytes = b"", right: int = 1) -> bytes:
    body = struct.pack("<fBf", math.pi, right, 80.0) + (pose or pose_3d()) + struct.pack("<I", len(ranges))
    body += np.array(ranges, "<f4").tobytes() + bytes(valid or [1] * len(ranges))
    body += struct.pack("<fQf", 0.01, ticks, 0.004) + struct.pack("<I", 3) + b"LMS" + struct.pack("<d", 0)
    return thing("CObservation2DRangeScan", 6, body)


def frame(*observations: bytes) -> bytes:
    return thing("CSensoryFrame", 2, struct.pack("<I", len(observations)) + b"".join(observations))


def action(x: float, y: float, yaw: float, ticks: int = 0) -> bytes:
    body = struct.pack("<I", 0) + pose_2d(x, y, yaw) + struct.pack("<I6fi6f", 0, *[0.1] * 6, 300, *[0.1] * 6)
    body += struct.pack("<BffBiiQ", 0, 0, 0, 0, 0, 0, ticks)
    return thing("CActionCollection", 0, struct.pack("<I", 1) + thing("CActionRobotMovement2D", 6, body))


def odometry(ticks: int, x: float, version: int = 1) -> bytes:
    body = pose_2d(x, 0, 0) + struct.pack("<I", 0) + struct.pack("<Q", ticks)
    body += struct.pack("<BiiBff", 0, 0, 0, 0, 0, 0) if version == 1 else struct.pack("<BB", 0, 0)
    return thing("CObservationOdometry", version, body)


def write(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "drive.rawlog"
    path.write_bytes(gzip.compress(data))
    return path


@pytest.mark.realdata
def test_the_wheelchairs_log_holds_what_is_known_of_it(data_folder: Path) -> None:
    log = read_mrpt(data_folder / "logs" / SENA)
    assert log.ranges.shape == (225, 361)
    assert tuple(log.T_base_laser) == pytest.approx((0.78, 0, 0))
    assert np.median(np.diff(log.scan_stamp)) == pytest.approx(0.23, abs=0.005)
    assert arc_length(log.pose[:, :2])[-1] == pytest.approx(76, abs=0.5)
    assert math.degrees(log.angle_min) == pytest.approx(-90, abs=1e-4)
    assert math.degrees(log.angle_increment) == pytest.approx(0.5, abs=1e-6)
    assert np.isinf(log.ranges).any()
    np.testing.assert_array_equal(log.odometry_stamp, log.scan_stamp)
    assert 0 < np.percentile(log.twist[:, 0], 95) < 2.5
    assert log.metadata["epoch"].startswith("2006-01-21")


def misfit(log: DriveLog, pose: np.ndarray, side: int = 1) -> float:
    """Median distance [m] between walls seen about half a second apart, put together by `pose` and the mounting."""

    def points(index: int) -> np.ndarray:
        near = log.ranges[index] < 8
        r, a = log.ranges[index][near], side * log.scan(index).angles()[near]
        return (Pose2(*pose[index]) * log.T_base_laser).transform(np.c_[r * np.cos(a), r * np.sin(a)])

    pairs = [(points(k), points(k + 2)) for k in range(10, 210, 4)]
    return float(np.median([np.median(np.linalg.norm(a[:, None] - b[None], axis=2).min(axis=1)) for a, b in pairs]))


@pytest.mark.realdata
def test_walls_stay_in_place_only_with_the_odometry_and_the_handedness_that_are_read(data_folder: Path) -> None:
    log = read_mrpt(data_folder / "logs" / SENA)
    others = {
        "standing still": misfit(log, 0 * log.pose),
        "beams from left to right": misfit(log, log.pose, side=-1),
        "odometry mirrored": misfit(log, log.pose * [1, -1, -1]),
        "odometry backwards": misfit(log, log.pose * [-1, -1, 1]),
    }
    found = misfit(log, log.pose)
    assert found < 0.15
    assert found < 0.7 * min(others.values()), others


def test_an_actions_increments_add_up_to_poses_at_the_scans(tmp_path: Path) -> None:
    data = action(9, 9, 9)  # before the first scan: nothing to count from
    data += frame(scan(5 * SECOND, [1, 2, 3])) + action(1, 0, math.pi / 2, 5 * SECOND + 7)
    data += frame(scan(6 * SECOND, [1, 2, 3])) + action(1, 0, 0) + action(1, 0, 0) + frame(scan(8 * SECOND, [1, 2, 3]))
    log = read_mrpt(write(tmp_path, data))
    np.testing.assert_allclose(log.odometry_stamp, [0, 1, 3])
    np.testing.assert_allclose(log.pose, [[0, 0, 0], [1, 0, math.pi / 2], [1, 2, math.pi / 2]], atol=1e-12)
    assert tuple(log.T_base_laser) == pytest.approx((0.78, 0.1, 0.2))


@pytest.mark.parametrize("version", [1, 2])
def test_a_log_of_observations_alone_gives_absolute_odometry(tmp_path: Path, version: int) -> None:
    data = b"".join(odometry(k * SECOND, 0.5 * k, version) + scan(k * SECOND + 1000, [1, 2]) for k in range(1, 4))
    log = read_mrpt(write(tmp_path, data))
    np.testing.assert_allclose(log.odometry_stamp, [0, 1, 2])
    np.testing.assert_allclose(log.pose[:, 0], [0.5, 1, 1.5])
    np.testing.assert_allclose(log.scan_stamp, [1e-4, 1 + 1e-4, 2 + 1e-4], atol=1e-12)


def test_invalid_beams_are_no_return_at_the_range_and_else_no_measurement(tmp_path: Path) -> None:
    log = read_mrpt(write(tmp_path, frame(scan(1, [1.0, 2.0, 81.9, 81.9], [1, 0, 0, 1]))))
    np.testing.assert_array_equal(log.ranges[0], [1, np.nan, np.inf, np.inf])


def test_a_sensor_that_turns_left_to_right_has_falling_angles(tmp_path: Path) -> None:
    turned = read_mrpt(write(tmp_path, frame(scan(1, [1, 2, 3], right=0)))).scan(0)
    np.testing.assert_allclose(turned.angles(), [math.pi / 2, 0, -math.pi / 2], atol=1e-6)


def test_a_pose_as_a_quaternion_means_the_same(tmp_path: Path) -> None:
    body = struct.pack("<7d", 0.78, 0.1, 0.3, math.cos(0.1), 0, 0, math.sin(0.1))
    log = read_mrpt(write(tmp_path, frame(scan(1, [1, 2], pose=thing("CPose3D", 2, body)))))
    assert tuple(log.T_base_laser) == pytest.approx((0.78, 0.1, 0.2))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "holds no planar scan"),
        (action(1, 0, 0), "holds no planar scan"),
        (thing("CObservationImage", 0, b""), "byte 0: expected CSensoryFrame or .*, found 'CObservationImage'"),
        (frame(thing("CPose2D", 1, bytes(24))), "expected CObservation2DRangeScan or CObservationOdometry"),
        (pose_2d(0, 0, 0), "a CPose2D stands outside any record"),
        (frame(scan(1, [1.0])), "a scan of 1 beams, must have at least 2"),
        (frame(scan(1, [])), "a scan of 0 beams"),
        (frame(scan(1, [1, 2]), scan(2, [1, 2, 3])), "a scan of 3 beams, the first has 2"),
        (frame(scan(1, [1, 2]), scan(2, [1, 2], pose=pose_3d(0.1))), "more than one sensor"),
        (frame(scan(1, [1, 2], pose=pose_3d(roll=0.3))), "the sensor is tilted"),
        (frame(scan(2, [1, 2]), scan(1, [1, 2])), "scan_stamp goes back"),
        (frame(scan(1, [1, 2])).replace(b"Scan\x06", b"Scan\x09"), "has version 9, versions 6 to 7 are read"),
        (frame(scan(1, [1, 2]))[:-1] + b"\x00", "CSensoryFrame version 2 ends with byte 0x0"),
        (frame() + struct.pack("<B", 0x8D) + b"CSensoryFrame\x02\xff\xff\xff\xff", "announces 4294967295 entries"),
        (frame(scan(1, [1, math.nan])) + odometry(1, math.inf), r"a pose is Pose2\(inf, 0, 0\), must be finite"),
    ],
)
def test_a_broken_rawlog_is_refused_with_file_and_reason(tmp_path: Path, data: bytes, reason: str) -> None:
    with pytest.raises(DataError, match=reason) as caught:
        read_mrpt(write(tmp_path, data))
    assert "drive.rawlog" in str(caught.value)


def test_a_rawlog_cut_anywhere_inside_an_object_is_refused(tmp_path: Path) -> None:
    data = frame(scan(1, [1, 2, 3])) + action(1, 0, 0)
    whole = len(frame(scan(1, [1, 2, 3])))
    for size in range(1, len(data)):
        path = tmp_path / "drive.rawlog"
        path.write_bytes(data[:size])
        if size == whole:
            assert len(read_mrpt(path).scan_stamp) == 1
        else:
            with pytest.raises(DataError, match=r"drive\.rawlog, byte"):
                read_mrpt(path)
    path.write_bytes(gzip.compress(data)[:-9])
    with pytest.raises(DataError, match="gzip stream is cut or garbled"):
        read_mrpt(path)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_garbled_rawlogs_are_read_or_refused_but_never_crash(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    whole = bytearray(frame(scan(1, [1, 2, 3])) + action(1, 0, 0) + odometry(3, 1.0) + frame(scan(9, [1, 2, 3])))
    for _ in range(data.draw(st.integers(1, 6))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("garbled") / "drive.rawlog"
    path.write_bytes(bytes(whole))
    try:
        read_mrpt(path)
    except DataError as error:
        assert "drive.rawlog" in str(error)
