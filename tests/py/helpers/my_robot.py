"""The robot of docs/on-your-robot.md: a simulated chair that moves on as wall time does, and whose stick is ahead."""

import time

import numpy as np

from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.chair import SimulatedChair
from lfdcore.simulated.courses import hall
from lfdcore.simulated.drivers import DriverInput
from lfdcore.simulation import ChairConfig, LidarConfig
from lfdcore.wheelchair.observation import Observation

TICKS = 25
given: list[tuple[float, float]] = []
"""What drive() was given"""


class _Ahead:
    def reset(self, seed: int) -> None:
        pass

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        return DriverInput(np.array([0.6, 0.0]), np.array([0.6, 0.0]))


_chair = SimulatedChair(hall(), _Ahead(), 1, ChairConfig(), LidarConfig())
_seen: list[tuple[float, Observation]] = []


def scan() -> tuple[list[float], float]:
    now = time.monotonic()
    began = _seen[0][0] if _seen else now
    _seen.append((now, _chair.observe(now - began)))
    return _seen[-1][1].scan.ranges.tolist(), now


def odometry() -> tuple[Pose2, Twist2, float]:
    now, seen = _seen[-1]
    return seen.pose, seen.twist, now


def stick() -> tuple[tuple[float, float], float]:
    now, seen = _seen[-1]
    return seen.joystick, now


def drive(linear: float, angular: float, duration: float = 0.0) -> None:
    given.append((linear, angular))
    _chair.command(Twist2(linear, angular), duration)


def is_switched_off() -> bool:
    return len(_seen) >= TICKS


def way() -> float:
    """[m] from where it stood"""
    pose = _seen[-1][1].pose
    return float(np.hypot(pose.x, pose.y))
