"""A chair in a simulated world, with a simulated driver at its stick and maybe people about: the first Chair of the
drive loop."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Twist2
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import Driver
from lfdcore.simulated.people import People
from lfdcore.simulated.person_met import PersonMet, person_met
from lfdcore.simulation import ChairConfig, ChairState, DrivingWorld, LidarConfig
from lfdcore.wheelchair.observation import Observation


@dataclass(frozen=True)
class Truth:
    """What nobody on the chair knows, at an observation."""

    state: ChairState
    """pose and twist in map, whether the chair touches anything of the map"""
    desired: NDArray[np.float64]
    """(2,) forward, left as the driver means it, before the disability"""
    collision: bool
    """whether a contact with the map began in the step that led here"""
    people: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    """(P, 2) where they are [m, map]"""
    touches_person: bool = False
    """whether a contact with a person is not yet over"""
    people_met: int = 0
    """how many contacts with people began in the step that led here"""


class SimulatedChair:
    """Stands at the course's start when it is made. The same seed gives the same scans, slip and driver.

    people: who walks there, as yet without a step. The scans show them; neither they nor the driver, who knows nothing
    of them, give way, and the chair is not stopped by them. Contacts with them are counted apart from the map's.
    """

    def __init__(
        self,
        course: Course,
        driver: Driver,
        seed: int,
        chair: ChairConfig,
        lidar: LidarConfig,
        people: People | None = None,
    ) -> None:
        self._world = DrivingWorld(course.grid, chair, lidar, seed)
        self._world.reset(course.start)
        self._driver = driver
        driver.reset(seed)
        self._people = people
        if people is not None:
            self._world.set_people(people.bodies())
        self._shown: list[tuple[float, list[bool]]] = []
        self._met_before = 0
        self._collision, self._odometry_twist = False, Twist2()
        self.truth: Truth
        """of the latest observation"""

    def observe(self, stamp: float) -> Observation:
        """What sensors and stick say at `stamp` [s]; the driver acts on what is true."""
        scan, state = self._world.scan(), self._world.state
        given = self._driver.act(stamp, state.pose, state.twist, state.in_contact)
        self.truth = Truth(state, given.desired, self._collision, *self._among_people())
        forward, left = (float(np.float32(axis)) for axis in given.joystick)  # as sensor_msgs/Joy
        return Observation(stamp, scan, stamp, self._world.odometry, self._odometry_twist, (forward, left))

    def people_met(self) -> tuple[PersonMet, ...]:
        """The contacts with people since the start."""
        return tuple(person_met(contact, self._shown) for contact in self._world.person_contacts)

    def _among_people(self) -> tuple[NDArray[np.float64], bool, int]:
        """Where they are, whether one is touched, how many were met since the last time."""
        if self._people is None:
            return np.zeros((0, 2)), False, 0
        self._shown.append((self._world.state.stamp, self._world.people_in_scan()))
        before, self._met_before = self._met_before, len(self._world.person_contacts)
        where = np.array([person.position for person in self._world.people]).reshape(-1, 2)
        return where, self._world.touches_person, self._met_before - before

    def command(self, twist: Twist2, duration: float) -> None:
        """Moves the world on by `duration` [s]."""
        if self._people is not None:
            self._world.set_people(self._people.walk(duration))
        result = self._world.step(twist, duration)
        self._collision, self._odometry_twist = result.collision_started, result.odometry_twist

    def stop(self) -> None:
        """Nothing to do: the world moves only while it is commanded."""
