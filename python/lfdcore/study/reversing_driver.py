"""A driver who drives a route backwards."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.study.courses.course import Course
from lfdcore.study.drivers import AbleConfig, AbleDriver, DriverInput
from lfdcore.wheelchair.two_way_assistant import TURNED, swapped_ends, swapped_limits


@dataclass(frozen=True)
class ReversingConfig(AbleConfig):
    """As the able driver, but with more stick, since full stick backwards is .4 m/s only."""

    speed: float = 0.8


class ReversingDriver(AbleDriver):
    """An able driver who looks over the shoulder: to him the chair's back is its front.

    Drives `facing_back(course)`; needs a course with room, since the nose swings out where the chair turns. After a hit
    he drives ahead for a while. Of a stick straight back both joystick and desired have forward < 0.
    """

    name = "reversing"

    def __init__(
        self,
        course: Course,
        config: ReversingConfig | None = None,
        limits: MotionLimits | None = None,
        footprint: Footprint | None = None,
    ) -> None:
        super().__init__(
            course,
            config or ReversingConfig(),
            swapped_limits(limits or MotionLimits()),
            swapped_ends(footprint or Footprint()),
        )

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick now, as in Driver.act."""
        given = super().act(stamp, pose * TURNED, Twist2(-twist.linear, twist.angular), in_contact)
        given.joystick[0] *= -1
        given.desired[0] *= -1
        return given


def facing_back(course: Course) -> Course:
    """The same course, with the chair's back to the way it is to go."""
    return replace(course, name=f"{course.name}-backwards", start=course.start * TURNED)
