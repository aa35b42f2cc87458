"""The joystick's link, odometry from encoders, LIDARs. Re-exports lfdcore._core.hardware."""

from lfdcore._core.hardware import (
    EncoderOdometry,
    JoystickCalibration,
    JoystickIdentity,
    JoystickLink,
    JoystickReading,
    LinkStatistics,
    ScipLidar,
    ScipStatistics,
    TimedScan,
    WheelEncoders,
)

__all__ = [
    "EncoderOdometry",
    "JoystickCalibration",
    "JoystickIdentity",
    "JoystickLink",
    "JoystickReading",
    "LinkStatistics",
    "ScipLidar",
    "ScipStatistics",
    "TimedScan",
    "WheelEncoders",
]
