"""The simulated chair in its world. Re-exports lfdcore._core.simulation."""

from lfdcore._core.simulation import (
    ChairConfig,
    ChairState,
    ContactConfig,
    DrivingWorld,
    LidarConfig,
    Person,
    PersonContact,
    StepResult,
    joystick_to_twist,
)

__all__ = [
    "ChairConfig",
    "ChairState",
    "ContactConfig",
    "DrivingWorld",
    "LidarConfig",
    "Person",
    "PersonContact",
    "StepResult",
    "joystick_to_twist",
]
