"""Sticks that no driver should move so: held for an hour, random, and aimed at what the chair could touch.

They say what no supervisor may be broken by. None of them sees the assistant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, integrate
from lfdcore.simulated.courses import Course
from lfdcore.simulated.courses.routes import clearance_field
from lfdcore.simulated.drivers import DriverInput
from lfdcore.simulation import joystick_to_twist

AT_REST = (0.0, 0.0)


@dataclass
class HeldStick:
    """A stick that lies where it is put: a driver who leans on it, or one who fell asleep."""

    stick: tuple[float, float]

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The same as ever."""
        return _input(self.stick)


class RandomStick:
    """Holds a stick drawn at random for a random while, 1 s on average; every tenth is full ahead."""

    def reset(self, seed: int) -> None:
        """The same seed gives the same stick."""
        self._random = np.random.default_rng([seed, 0x57])
        self._until = -math.inf
        self._stick = AT_REST

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick at `stamp` [s]."""
        if stamp >= self._until:
            self._until = stamp + float(self._random.exponential(1.0))
            forward, left = self._random.uniform(-1, 1, 2)
            self._stick = (1.0, 0.0) if self._random.random() < 0.1 else (float(forward), float(left))
        return _input(self._stick)


class AdversarialStick:
    """Sees the true map, and takes of 24 sticks the one that brings the outline nearest to anything within 1 s.

    Where the chair has stood for 3 s it goes elsewhere for 4 s, so that it finds more than one place.
    """

    HORIZON = 1.0
    STUCK, ELSEWHERE = 3.0, 4.0

    def __init__(self, course: Course, limits: MotionLimits | None = None, footprint: Footprint | None = None) -> None:
        self._limits = limits or MotionLimits()
        self._outline = _outline(footprint or Footprint())
        self._grid, self._clearance = course.grid, clearance_field(course.grid)
        angles = np.linspace(-math.pi, math.pi, 12, endpoint=False)
        self._sticks = [
            (size * math.cos(a) / _square(a), size * math.sin(a) / _square(a)) for size in (1.0, 0.4) for a in angles
        ]

    def reset(self, seed: int) -> None:
        """The same seed gives the same ways elsewhere."""
        self._random = np.random.default_rng([seed, 0xAD])
        self._moved = self._elsewhere_until = 0.0
        self._elsewhere = AT_REST

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick at `stamp` [s] for the true pose in map."""
        if math.hypot(twist.linear, twist.angular) > 0.02:
            self._moved = stamp
        if stamp - self._moved > self.STUCK and stamp >= self._elsewhere_until:
            self._elsewhere_until = stamp + self.ELSEWHERE
            forward, left = self._random.uniform(-1, 1, 2)
            self._elsewhere = (float(forward), float(left))
        if stamp < self._elsewhere_until:
            return _input(self._elsewhere)
        return _input(min(self._sticks, key=lambda stick: self._room(pose, stick)))

    def _room(self, pose: Pose2, stick: tuple[float, float]) -> float:
        """[m] between the outline and the nearest thing, at its least on the way that the stick asks for."""
        twist = joystick_to_twist(*stick, self._limits)
        poses = [integrate(pose, twist, self.HORIZON * share) for share in (0.25, 0.5, 1.0)]
        return min(self._clearance_at(at.transform(self._outline)) for at in poses)

    def _clearance_at(self, points: np.ndarray) -> float:
        cells = np.floor((points - np.array(self._grid.origin)) / self._grid.resolution).astype(int)
        height, width = self._clearance.shape
        inside = ((cells >= 0) & (cells < [width, height])).all(axis=1)
        if not inside.all():
            return 0.0
        return float(self._clearance[cells[:, 1], cells[:, 0]].min())


def _outline(body: Footprint) -> np.ndarray:
    """(8, 2) [m]: the corners and the middles between them"""
    x, y = np.array([-body.rear, (body.front - body.rear) / 2, body.front]), np.array([-1, 0, 1]) * body.half_width
    grid = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    return np.delete(grid, 4, axis=0)


def _square(angle: float) -> float:
    """From the stick's circle to its square end stops."""
    return max(abs(math.cos(angle)), abs(math.sin(angle)))


def _input(stick: tuple[float, float]) -> DriverInput:
    return DriverInput(np.array(stick), np.array(stick))
