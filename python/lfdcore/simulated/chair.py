"""A chair in a simulated world, with a simulated driver at its stick and maybe people about: the first Chair of the
drive loop."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import StickHolder
from lfdcore.simulated.people import People
from lfdcore.simulated.person_met import PersonMet, person_met
from lfdcore.simulation import ChairConfig, ChairState, DrivingWorld, LidarConfig
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry, Observation
from lfdcore.wheelchair.watch import UNTIL_NEUTRAL

LEAST_NOISE = 0.002
"""[m] No scanner is declared to be better."""
READING = 0.5
"""[s] until a driver has read the display"""
FOOT = 0.02
"""[m] radius of what the scanner sees of the driver's foot"""


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


def geometry_of(chair: ChairConfig, lidar: LidarConfig, scanner: ScannerFaults, period: float) -> ChairGeometry:
    """What an assistant knows of a simulated chair that is commanded every `period` [s]: the truth."""
    return ChairGeometry(
        footprint=chair.footprint,
        limits=chair.limits,
        T_base_laser=lidar.T_base_laser,
        latency=chair.command_latency,
        period=period,
        scan_period=max(period, scanner.period),
        range_noise=max(lidar.noise_sd, LEAST_NOISE),
        odometry_error=min(max(abs(chair.linear_slip), abs(chair.angular_slip)) + 3 * chair.slip_sd, 0.5),
    )


@dataclass(frozen=True, kw_only=True)
class ScannerFaults:
    """What a cheap scanner does beside its noise, and what it always sees. ValueError names a field out of range."""

    period: float = 0.0
    """[s] between scans at the least; 0: one a tick"""
    dropped: float = 0.0
    """Share of the beams that measure nothing (NaN), drawn anew each scan"""
    foot: tuple[float, float] | None = None
    """Where the driver's foot is [m, base_link], a disc of `FOOT` that the beams do not get past; None: out of view"""

    def __post_init__(self) -> None:
        if not 0 <= self.period <= 10:
            raise ValueError(f"period is {self.period} s, must lie in [0, 10]")
        if not 0 <= self.dropped <= 1:
            raise ValueError(f"dropped is {self.dropped}, must be a share in [0, 1]")
        if self.foot is not None and not all(map(math.isfinite, self.foot)):
            raise ValueError(f"foot is at {self.foot} m, must be finite")


def ranges_to_disc(centre: NDArray[np.float64], radius: float, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far beams (B,) [rad] from the origin go until they meet a disc about `centre` (2,) [m] -> (B,) [m], inf for
    those that miss it."""
    along = centre[0] * np.cos(angles) + centre[1] * np.sin(angles)
    half_chord = np.sqrt(np.maximum(radius**2 - (centre @ centre - along**2), 0))
    return np.where((half_chord > 0) & (along > 0), np.maximum(along - half_chord, 0), np.inf)


class SimulatedChair:
    """Stands at the course's start when it is made. The same seed gives the same scans, slip and driver.

    period: between two commands [s]. people: who walks there, as yet without a step. The scans show them; neither
    they nor the driver, who knows nothing of them, give way, and the chair is not stopped by them. Contacts with them
    are counted apart from the map's.
    """

    def __init__(
        self,
        course: Course,
        driver: StickHolder,
        seed: int,
        chair: ChairConfig,
        lidar: LidarConfig,
        people: People | None = None,
        scanner: ScannerFaults | None = None,
        period: float = PERIOD,
    ) -> None:
        self._faults = scanner or ScannerFaults()
        self.geometry = geometry_of(chair, lidar, self._faults, period)
        self._world = DrivingWorld(course.grid, chair, lidar, seed)
        self._world.reset(course.start)
        self._seed = seed
        self._driver = driver
        driver.reset(seed)
        self._people = people
        if people is not None:
            self._world.set_people(people.bodies())
        self._shown: list[tuple[float, list[bool]]] = []
        self._met_before = 0
        self._collision, self._odometry_twist, self._command = False, Twist2(), Twist2()
        self._stamp, self._holds = 0.0, math.inf
        self._scans = 0
        self._scan: tuple[float, LaserScan, Pose2] | None = None
        self._centre_from = math.inf
        self.truth: Truth
        """of the latest observation"""

    def observe(self, stamp: float) -> Observation:
        """What sensors and stick say at `stamp` [s], to which the world moves on; the driver acts on what is true."""
        self._move_to(stamp)
        scan_stamp, scan, scan_pose = self._newest_scan(stamp)
        fresh = scan_stamp == stamp
        state = self._world.state
        given = self._driver.act(stamp, state.pose, state.twist, state.in_contact)
        self.truth = Truth(state, given.desired, self._collision, *self._among_people())
        forward, left = (float(np.float32(axis)) for axis in given.joystick)  # as sensor_msgs/Joy
        return Observation(
            stamp=stamp,
            scan=scan,
            scan_stamp=scan_stamp,
            scan_pose=None if fresh else scan_pose,
            pose=self._world.odometry,
            twist=self._odometry_twist,
            odometry_stamp=stamp,
            joystick=(0.0, 0.0) if stamp >= self._centre_from else (forward, left),
            joystick_stamp=stamp,
            command=self._command,
        )

    def show(self, mode: str, stamp: float) -> None:
        """The display says the assistant's mode of the tick at `stamp` [s]. Where it asks for a stick at neutral, the
        driver centres it after a moment."""
        if mode not in UNTIL_NEUTRAL:
            self._centre_from = math.inf
        elif math.isinf(self._centre_from):
            self._centre_from = stamp + READING

    def _newest_scan(self, stamp: float) -> tuple[float, LaserScan, Pose2]:
        if self._scan is None or stamp - self._scan[0] >= self._faults.period - 1e-9:
            self._scan = (stamp, self._with_faults(self._world.scan()), self._world.odometry)
        return self._scan

    def _with_faults(self, scan: LaserScan) -> LaserScan:
        self._scans += 1
        if self._faults.dropped == 0 and self._faults.foot is None:
            return scan
        ranges = np.array(scan.ranges)
        if self._faults.foot is not None:
            ranges = np.minimum(ranges, self._foot_ranges(scan.angles(), *self._faults.foot))
        random = np.random.default_rng([self._seed, self._scans, 0xD])
        ranges[random.random(len(ranges)) < self._faults.dropped] = np.nan
        return LaserScan(ranges.tolist(), scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)

    def _foot_ranges(self, angles: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
        """(B,) [m] to the foot at (x, y) [m, base_link], with the scanner's noise; inf for beams that miss it"""
        foot = self.geometry.T_base_laser.inverse() * Pose2(x, y, 0.0)
        noise = np.random.default_rng([self._seed, self._scans, 0xF]).normal(0, self._world.lidar.noise_sd, len(angles))
        return np.maximum(ranges_to_disc(np.array([foot.x, foot.y]), FOOT, angles) + noise, 0)

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
        """Drives `twist` [m/s, rad/s] from now on, for `duration` [s] at the longest."""
        self._command, self._holds = twist, duration

    def stop(self) -> None:
        """Nothing to do: the world moves only while it is observed."""

    def _move_to(self, stamp: float) -> None:
        passed = round(stamp - self._stamp, 9)  # so that a period is what it says, to the last bit
        self._stamp, self._collision = stamp, False
        if self._people is not None and passed > 0:
            self._world.set_people(self._people.walk(passed))
        for command, duration in ((self._command, min(passed, self._holds)), (Twist2(), passed - self._holds)):
            if duration > 0:
                result = self._world.step(command, duration)
                self._collision |= result.collision_started
                self._odometry_twist = result.odometry_twist
