"""Assistance backwards too, for a chair whose scanner sees all around (Sec. 6.2.1).

Demonstrations, pure pursuit and roll-outs go forwards. So for a stick that points behind, the same assistant drives a
chair that has its ends swapped: its ahead is our behind, and all that it sees (window, scan, stick, twist, footprint)
is turned by 180 degrees. Nothing else is special about driving backwards.
"""

from __future__ import annotations

import math
from dataclasses import replace

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.wheelchair.assistants import STOP, DriveAssistant, DriveAssistantConfig
from lfdcore.wheelchair.method import MethodModel
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.watch import Watch, WatchConfig

TURNED = Pose2(0.0, 0.0, math.pi)
"""The chair as seen by one who takes its back for its front."""
ALL_AROUND = math.radians(350)
"""A scan over less [rad] leaves a part of the window behind the chair unseen."""


class TwoWayAssistant:
    """A DriveAssistant for each way, chosen by the stick; both see every scan.

    A scan that does not go all around leaves a stick that points behind to DriveAssistant: the user's own, supervised.
    """

    def __init__(
        self,
        model: MethodModel,
        chair: ChairGeometry,
        config: DriveAssistantConfig | None = None,
        name: str = "two_way",
        watch: WatchConfig | None = None,
    ) -> None:
        self.name = name
        self.chair = chair
        self._watch = Watch(chair, watch)
        self.config = config or DriveAssistantConfig()
        self._ahead = DriveAssistant(model.planner(self.chair), self.config, watch=watch)
        # to the side of a reversing chair: a turn on the spot, the user's own
        aside = replace(self.config, reverse_from=math.pi - self.config.reverse_from)
        self._behind = DriveAssistant(model.planner(turned_chair(self.chair)), aside, watch=watch)
        self._backwards = False

    def reset(self) -> None:
        """Forgets all scans and paths."""
        self._watch.reset()
        self._ahead.reset()
        self._behind.reset()
        self._backwards = False

    def update(self, observation: Observation) -> Assistance:
        """That of the assistant which drives the way the stick points; the other one lets go."""
        said = self._said(observation)
        self._ahead.overruled(observation.stamp, said.command)
        self._behind.overruled(observation.stamp, Twist2(-said.command.linear, said.command.angular))
        return said

    def _said(self, observation: Observation) -> Assistance:
        halt = self._watch.judge(observation)
        resting = replace(observation, joystick=(0.0, 0.0))
        if halt is not None:
            self._ahead.update(resting)
            self._behind.update(turned(resting))
            return Assistance(STOP, halt)
        self._backwards = sees_all_around(observation.scan) and self._points_behind(observation)
        if self._backwards:
            self._ahead.update(resting)
            return _turned_back(self._behind.update(turned(observation)))
        self._behind.update(turned(resting))
        return self._ahead.update(observation)

    def _points_behind(self, observation: Observation) -> bool:
        """A stick at rest or to the side goes on the way it went: it may be a turn on the spot."""
        forward, left = observation.joystick
        if math.hypot(forward, left) < self.config.dead_zone:
            return self._backwards
        angle = abs(math.atan2(left, forward))
        return angle >= math.pi - self.config.reverse_from if self._backwards else angle >= self.config.reverse_from


def sees_all_around(scan: LaserScan) -> bool:
    """Whether the scan's beams leave no sector out."""
    return len(scan.ranges) * abs(scan.angle_increment) >= ALL_AROUND


def turned_chair(chair: ChairGeometry) -> ChairGeometry:
    """The same chair with its back taken for its front."""
    return replace(
        chair,
        footprint=swapped_ends(chair.footprint),
        limits=swapped_limits(chair.limits),
        T_base_laser=TURNED.inverse() * chair.T_base_laser,
    )


def turned(observation: Observation) -> Observation:
    """What the turned chair observes. The stick's left stays the rate of turn, whichever way the chair rolls."""
    forward, left = observation.joystick
    return replace(
        observation,
        pose=observation.pose * TURNED,
        twist=_opposite(observation.twist),
        joystick=(-forward, left),
        scan_pose=None if observation.scan_pose is None else observation.scan_pose * TURNED,
        command=None if observation.command is None else _opposite(observation.command),
    )


def _opposite(twist: Twist2) -> Twist2:
    """As the turned chair has it: the rate of turn stays."""
    return Twist2(-twist.linear, twist.angular)


def _turned_back(said: Assistance) -> Assistance:
    """In our base_link; paths and goals are in odom already."""
    point = said.control_point
    return replace(
        said,
        command=_opposite(said.command),
        control_point=None if point is None else (-point[0], -point[1]),
    )


def swapped_ends(body: Footprint) -> Footprint:
    """Front for rear."""
    return Footprint(front=body.rear, rear=body.front, half_width=body.half_width)


def swapped_limits(limits: MotionLimits) -> MotionLimits:
    """Forwards for backwards."""
    return MotionLimits(
        max_linear=limits.max_reverse,
        max_reverse=limits.max_linear,
        max_angular=limits.max_angular,
        linear_acceleration=limits.linear_acceleration,
        linear_braking=limits.linear_braking,
        angular_acceleration=limits.angular_acceleration,
    )
