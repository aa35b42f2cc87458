"""What is wrong with a log is said, with what to do about it; and a sound log has nothing wrong."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lfdcore.datasets import DriveLog
from lfdcore.datasets.log_health import log_facts, log_troubles
from lfdcore.datasets.motion import odometry_jumps
from lfdcore.geometry import Pose2

STAMPS = 0.1 * np.arange(100)


def sound(**changes: Any) -> DriveLog:
    fields: dict[str, Any] = {
        "scan_stamp": STAMPS,
        "ranges": np.full((100, 181), 2.0),
        "T_base_laser": Pose2(0.7, 0.0, 0.0),
        "odometry_stamp": STAMPS,
        "pose": np.c_[0.5 * STAMPS, 0 * STAMPS, 0 * STAMPS],
        "twist": np.tile([0.5, 0.0], (100, 1)),
        "joystick_stamp": STAMPS,
        "joystick": np.tile([1.0, 0.0], (100, 1)),
    }
    return DriveLog(**fields | changes)


def test_a_sound_log_has_nothing_wrong_and_plain_numbers() -> None:
    facts = log_facts(sound())
    assert facts["wrong"] == []
    assert facts["scans"] == {
        "records": 100,
        "rate [Hz]": 10.0,
        "longest gap [s]": 0.1,
        "beams": 181,
        "range_max [m]": 30.0,
        "returning": 1.0,
        "median [m]": 2.0,
    }
    assert facts["odometry"]["way [m]"] == pytest.approx(4.95)
    assert facts["scanner at"] == {"x [m]": 0.7, "y [m]": 0.0, "yaw [deg]": 0.0, "upside down": False}


def jumping() -> np.ndarray:
    pose = sound().pose.copy()
    pose[50:, 0] -= 2.5
    return pose


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"T_base_laser": None}, "say --mounting X,Y,YAW"),
        ({"ranges": np.full((100, 181), np.inf)}, "are the ranges in metres"),
        ({"ranges": np.full((100, 181), 0.3)}, "on the robot itself"),
        ({"pose": jumping()}, "jumps 1 times, first by 2.45 m"),
        ({"scan_stamp": STAMPS + 5}, "50 % of the scans have no odometry"),
        ({"scan_stamp": STAMPS + 3.0 * (STAMPS > 5)}, "scans pause 1 times, longest for 3.10 s"),
        ({"joystick": np.zeros((100, 2))}, "say --axes"),
        ({"joystick_stamp": [], "joystick": np.zeros((0, 2))}, "infers it from the motion"),
        ({"metadata": {"command left out": "/a, /b: --command chooses one"}}, "command: /a, /b: --command chooses one"),
    ],
)
def test_what_is_wrong_is_said_with_what_to_do(changes: dict[str, Any], why: str) -> None:
    assert any(why in trouble for trouble in log_troubles(sound(**changes)))


def test_a_jump_is_what_no_chair_does_and_not_a_quick_turn_or_a_slow_record() -> None:
    assert np.flatnonzero(odometry_jumps(sound(pose=jumping()))).tolist() == [50]
    quick = sound(pose=np.c_[0 * STAMPS, 0 * STAMPS, 2.5 * STAMPS], twist=np.tile([0.0, 2.5], (100, 1)))
    assert not odometry_jumps(quick).any()
    assert not odometry_jumps(replace(sound(), odometry_stamp=10 * STAMPS)).any()
