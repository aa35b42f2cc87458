"""What `learn_drive` gives serves every command: above all, it says what its demonstrations' stick meant."""

import dataclasses

import numpy as np
import pytest

from lfdcore.datasets import DriveLog, joystick_from_motion
from lfdcore.study.prediction.study import predict_log
from lfdcore.training.drive_primitives import learn_drive
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.stick import StickMeaning, full_deflection_of, with_stick
from synthetic_drive import corner_drive


def silent_drive(offset: float) -> DriveLog:
    """Through the L corridor at .5 m/s, with a quarter turn of some 1 m radius; nobody recorded the stick."""
    drive = corner_drive(offset)
    return DriveLog(
        scan_stamp=drive.scan_stamp,
        ranges=drive.ranges,
        odometry_stamp=drive.odometry_stamp,
        pose=drive.pose,
        twist=np.zeros((len(drive.pose), 2)),
        T_base_laser=drive.T_base_laser,
        name="corner",
    )


@pytest.fixture(scope="module")
def model() -> DriveAssistantModel:
    """As the README's ten lines learn it."""
    return learn_drive([joystick_from_motion(silent_drive(offset)) for offset in (-0.15, 0.0, 0.15)])


def test_the_model_says_what_full_deflection_meant_in_its_demonstrations(model: DriveAssistantModel) -> None:
    assert len(model.metadata["full_deflection"]) == 3
    full = full_deflection_of(model)
    assert full is not None and [*full] == pytest.approx([0.5, 0.5], rel=0.02)


def test_so_a_stick_as_demonstrated_differs_from_one_by_the_log_s_own_limits(model: DriveAssistantModel) -> None:
    log = silent_drive(0.0)
    wide = dataclasses.replace(log, pose=log.pose * [4, 4, 1])  # the same turns over four times the way
    turning = np.abs(joystick_from_motion(log).joystick[:, 1]) > 0.9
    for meaning, slope in ((StickMeaning.own, 1.0), (StickMeaning.demonstrated, 0.25)):
        stick = with_stick(wide, model, meaning).joystick[turning]
        assert np.median(stick[:, 1] / stick[:, 0]) == pytest.approx(slope, rel=0.05)


def test_predict_says_which_limits_made_its_stick(model: DriveAssistantModel) -> None:
    log = silent_drive(0.0)
    wide = dataclasses.replace(log, pose=log.pose * [4, 4, 1])
    for meaning, limits in ((StickMeaning.own, "2.000 m/s and 0.5"), (StickMeaning.demonstrated, "2.000 m/s and 2.0")):
        found = predict_log(wide, {"ours": model.predictor()}, meaning)
        assert f"full deflection at {limits}" in found.models["ours"].stick
