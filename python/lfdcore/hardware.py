"""The joystick's link, odometry from encoders, LIDARs. Re-exports lfdcore._core.hardware."""

from lfdcore._core.hardware import (
    EncoderConfig,
    EncoderOdometry,
    JoystickCalibration,
    JoystickIdentity,
    JoystickLink,
    JoystickReading,
    LinkStatistics,
    ScipLidar,
    ScipStatistics,
    TimedScan,
)

__all__ = [
    "EncoderConfig",
    "EncoderOdometry",
    "JoystickCalibration",
    "JoystickIdentity",
    "JoystickLink",
    "JoystickReading",
    "LinkStatistics",
    "ScipLidar",
    "ScipStatistics",
    "TimedScan",
]
