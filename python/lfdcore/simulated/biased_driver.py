"""A driver with a steering bias: the stick points beside what is meant (Sec. 6.2.1)."""

from __future__ import annotations

import math

import numpy as np

from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.drivers import AbleConfig, AbleDriver, DriverInput


class BiasedDriver(AbleDriver):
    """An able driver whose stick points `bias` [rad, positive = left] beside what is meant.

    ValueError for a bias that is not within pi / 2 of 0.
    """

    name = "biased"

    def __init__(self, course: Course, bias: float, config: AbleConfig | None = None) -> None:
        if not abs(bias) < math.pi / 2:  # NaN too
            raise ValueError(f"bias is {bias} rad, must lie within pi / 2 of 0")
        super().__init__(course, config)
        self.bias = bias

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick now, as in Driver.act: desired as meant, joystick beside it."""
        meant = super().act(stamp, pose, twist, in_contact).desired
        c, s = math.cos(self.bias), math.sin(self.bias)
        return DriverInput(np.array([c * meant[0] - s * meant[1], s * meant[0] + c * meant[1]]).clip(-1, 1), meant)
