"""Small drive logs to write, cut and garble."""

from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import DriveLog, Intention, Plan
from lfdcore.geometry import Pose2


def small_drive_log(scans: int = 4, beams: int = 5) -> DriveLog:
    """A log with something of everything, awkward numbers included."""
    rng = np.random.default_rng(7)
    stamp = 1.0 + 0.1 * np.arange(scans)
    ranges = rng.uniform(0.1, 20, (scans, beams)).astype(np.float32)
    ranges[0, 0], ranges[-1, 1] = np.inf, np.nan
    yaw = 3.0 + 0.2 * np.arange(scans)  # passes pi
    pairs = rng.uniform(-1, 1, (scans, 2)).astype(np.float32).astype(float)
    return DriveLog(
        scan_stamp=stamp,
        ranges=ranges,
        angle_min=-np.pi / 2,
        angle_increment=np.pi / (beams - 1),
        range_min=0.05,
        range_max=29.9,
        T_base_laser=Pose2(0.7, -0.1, 0.01),
        odometry_stamp=stamp - 0.05,
        pose=np.c_[rng.normal(size=(scans, 2)), yaw],
        twist=rng.normal(size=(scans, 2)),
        joystick_stamp=stamp,
        joystick=pairs,
        desired_stamp=stamp[:2],
        desired=pairs[:2],
        command_stamp=stamp,
        command=rng.normal(size=(scans, 2)),
        map_stamp=np.round(stamp - 0.07, 2),  # a localiser is late
        map_odom=np.c_[rng.normal(size=(scans, 2)), -3.0 - 0.2 * np.arange(scans)],
        plans=[Plan(1.1, np.array([[0.0, 0.0], [1.0, 0.5], [1.5, 2.0]]))],
        intentions=[Intention(1.1, (1.5, 2.0), 0.003)],
        metadata={"driver": "Zoë", "course": "home"},
        name="small",
    )


@pytest.fixture
def small_log() -> DriveLog:
    return small_drive_log()


@pytest.fixture
def small_file(tmp_path: Path, small_log: DriveLog) -> Path:
    path = tmp_path / "small.mcap"
    small_log.save(path)
    return path
