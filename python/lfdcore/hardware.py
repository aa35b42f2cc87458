"""The link to a chair's joystick, odometry from its encoders. Re-exports lfdcore._core.hardware."""

from lfdcore._core.hardware import (
    EncoderConfig,
    EncoderOdometry,
    JoystickCalibration,
    JoystickIdentity,
    JoystickLink,
    JoystickReading,
    LinkStatistics,
)

__all__ = [
    "EncoderConfig",
    "EncoderOdometry",
    "JoystickCalibration",
    "JoystickIdentity",
    "JoystickLink",
    "JoystickReading",
    "LinkStatistics",
]
