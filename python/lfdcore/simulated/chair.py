"""A chair in a simulated world with a simulated driver at its stick: the first Chair of the drive loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Twist2
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import Driver
from lfdcore.simulation import ChairConfig, ChairState, DrivingWorld, LidarConfig
from lfdcore.wheelchair.observation import Observation


@dataclass(frozen=True)
class Truth:
    """What nobody on the chair knows, at an observation."""

    state: ChairState
    """pose and twist in map, whether the chair touches anything"""
    desired: NDArray[np.float64]
    """(2,) forward, left as the driver means it, before the disability"""
    collision: bool
    """whether a contact began in the step that led here"""


class SimulatedChair:
    """Stands at the course's start when it is made. The same seed gives the same scans, slip and driver."""

    def __init__(self, course: Course, driver: Driver, seed: int, chair: ChairConfig, lidar: LidarConfig) -> None:
        self._world = DrivingWorld(course.grid, chair, lidar, seed)
        self._world.reset(course.start)
        self._driver = driver
        driver.reset(seed)
        self._collision, self._odometry_twist = False, Twist2()
        self.truth: Truth
        """of the latest observation"""

    def observe(self, stamp: float) -> Observation:
        """What sensors and stick say at `stamp` [s]; the driver acts on what is true."""
        scan, state = self._world.scan(), self._world.state
        given = self._driver.act(stamp, state.pose, state.twist, state.in_contact)
        self.truth = Truth(state, given.desired, self._collision)
        forward, left = (float(np.float32(axis)) for axis in given.joystick)  # as sensor_msgs/Joy
        return Observation(stamp, scan, stamp, self._world.odometry, self._odometry_twist, (forward, left))

    def command(self, twist: Twist2, duration: float) -> None:
        """Moves the world on by `duration` [s]."""
        result = self._world.step(twist, duration)
        self._collision, self._odometry_twist = result.collision_started, result.odometry_twist

    def stop(self) -> None:
        """Nothing to do: the world moves only while it is commanded."""
