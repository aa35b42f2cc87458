"""Drivers who drive a route backwards."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.drivers import (
    AbleConfig,
    AbleDriver,
    Driver,
    DriverConfig,
    DriverInput,
    ImpairedDriver,
)
from lfdcore.wheelchair.two_way_assistant import TURNED, swapped_ends, swapped_limits


@dataclass(frozen=True)
class ReversingConfig(AbleConfig):
    """As the able driver, but with more stick, since full stick backwards is .4 m/s only."""

    speed: float = 0.8


class _OverTheShoulder(Driver):
    """To this driver the chair's back is its front.

    Drives `facing_back(course)`; needs a course with room, since the nose swings out where the chair turns. After a hit
    he drives ahead for a while. Of a stick straight back both joystick and desired have forward < 0.
    """

    def __init__(
        self,
        course: Course,
        config: DriverConfig | None = None,
        limits: MotionLimits | None = None,
        footprint: Footprint | None = None,
    ) -> None:
        super().__init__(
            course, config, swapped_limits(limits or MotionLimits()), swapped_ends(footprint or Footprint())
        )

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick now, as in Driver.act."""
        given = super().act(stamp, pose * TURNED, Twist2(-twist.linear, twist.angular), in_contact)
        given.joystick[0] *= -1
        given.desired[0] *= -1
        return given


class ReversingDriver(_OverTheShoulder, AbleDriver):
    """An able driver who looks over the shoulder."""

    name = "reversing"
    default_config = ReversingConfig


class ImpairedReversingDriver(_OverTheShoulder, ImpairedDriver):
    """One who can only point roughly, too: to the five orientations as seen over the shoulder."""

    name = "impaired, reversing"


def facing_back(course: Course) -> Course:
    """The same course, with the chair's back to the way it is to go."""
    return replace(course, name=f"{course.name}-backwards", start=course.start * TURNED)
