"""
The simulated chair in its world.
"""

from __future__ import annotations
import collections.abc
import lfdcore._core.geometry
import lfdcore._core.grid
import numpy
import numpy.typing
import typing

__all__: list[str] = [
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

class ContactConfig:
    """
    How the body behaves where it touches: friction (Coulomb's coefficient), skid_resistance (how much harder than rolling it is to push the wheels sideways, a ratio of masses), skid_time [s] in which they grip again, gyration_radius [m]; a contact lasts until the body has been clear of everything by release_gap [m] for release_time [s], so that chattering counts once.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        friction: float = 0.3,
        skid_resistance: float = 2.0,
        skid_time: float = 0.2,
        gyration_radius: float = 0.4,
        release_gap: float = 0.02,
        release_time: float = 0.5,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def friction(self) -> float:
        """
        Coulomb's coefficient
        """

    @property
    def gyration_radius(self) -> float:
        """
        [m]
        """

    @property
    def release_gap(self) -> float:
        """
        [m]
        """

    @property
    def release_time(self) -> float:
        """
        [s]
        """

    @property
    def skid_resistance(self) -> float:
        """
        ratio of masses
        """

    @property
    def skid_time(self) -> float:
        """
        [s]
        """

class ChairConfig:
    """
    The simulated chair. linear_slip, angular_slip: share that the wheels turn too much, which the odometry believes; slip_sd: sd of a random share added to both, anew each control period; command_latency [s]: a command acts that long after it was given; sub_step [s]: the motors' own period. ValueError names a field out of range.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        footprint: lfdcore._core.geometry.Footprint = ...,
        limits: lfdcore._core.geometry.MotionLimits = ...,
        contact: ContactConfig = ...,
        linear_slip: float = 0.0,
        angular_slip: float = 0.0,
        slip_sd: float = 0.0,
        command_latency: float = 0.0,
        sub_step: float = 0.02,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def angular_slip(self) -> float:
        """
        share of the angle
        """

    @property
    def command_latency(self) -> float:
        """
        [s]
        """

    @property
    def contact(self) -> ContactConfig: ...
    @property
    def footprint(self) -> lfdcore._core.geometry.Footprint: ...
    @property
    def limits(self) -> lfdcore._core.geometry.MotionLimits: ...
    @property
    def linear_slip(self) -> float:
        """
        share of the distance
        """

    @property
    def slip_sd(self) -> float:
        """
        share
        """

    @property
    def sub_step(self) -> float:
        """
        [s]
        """

class LidarConfig:
    """
    The simulated LIDAR: number of beams over field_of_view [rad] (first to last, symmetric about ahead), range_max and noise_sd [m], T_base_laser. Default: 181 beams over 180 degrees, 0.70 m before the axle (Sec. 3.2). ValueError names a field out of range.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        beams: int = 181,
        field_of_view: float = 3.141592653589793,
        range_max: float = 30.0,
        noise_sd: float = 0.01,
        T_base_laser: lfdcore._core.geometry.Pose2 = ...,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def T_base_laser(self) -> lfdcore._core.geometry.Pose2: ...
    @property
    def beams(self) -> int: ...
    @property
    def field_of_view(self) -> float:
        """
        [rad]
        """

    @property
    def noise_sd(self) -> float:
        """
        [m]
        """

    @property
    def range_max(self) -> float:
        """
        [m]
        """

class StepResult:
    """
    What one control period led to.
    """

    @property
    def collision_started(self) -> bool:
        """
        a contact began in this period
        """

    @property
    def in_contact(self) -> bool:
        """
        touching, or not yet clear of the last contact
        """

    @property
    def odometry(self) -> lfdcore._core.geometry.Pose2:
        """
        T_odom_base, as the encoders have it
        """

    @property
    def odometry_twist(self) -> lfdcore._core.geometry.Twist2:
        """
        as the encoders have it
        """

    @property
    def pose(self) -> lfdcore._core.geometry.Pose2:
        """
        T_map_base, true
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        of the wheels at the end, after any contact
        """

class ChairState:
    """
    The truth about the chair, for drivers and metrics, not for assistants. Its contacts are those with the map.
    """

    @property
    def collisions(self) -> int:
        """
        contacts begun since the reset
        """

    @property
    def contact_point(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) of the last collision: centre of the touched cell in the map [m]; NaN before one
        """

    @property
    def distance(self) -> float:
        """
        travelled by the axle's centre since the reset [m]
        """

    @property
    def in_contact(self) -> bool:
        """
        touching, or not yet clear of the last contact
        """

    @property
    def pose(self) -> lfdcore._core.geometry.Pose2:
        """
        T_map_base
        """

    @property
    def stamp(self) -> float:
        """
        since the reset [s]
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        of the wheels
        """

class Person:
    """
    A whole person at the scanner's height as one disc: body, both legs and the room of a stride. Walks on at its velocity. ValueError names a field out of range: position within 1e6 m, at most 10 m/s along each axis, 0 < radius <= 5 m.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self, *, position: numpy.typing.ArrayLike = ..., velocity: numpy.typing.ArrayLike = ..., radius: float = 0.25
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def position(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) of the centre in map [m]
        """

    @property
    def radius(self) -> float:
        """
        [m]
        """

    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) [m/s]
        """

class PersonContact:
    """
    What was so when a contact of the chair with a person began: the first of the motors' periods at whose end disc and outline share a point.
    """

    @property
    def chair_approach(self) -> float:
        """
        speed of the outline at that point towards the person [m/s]
        """

    @property
    def chair_approach_since(self) -> float:
        """
        the largest chair_approach while they touched, until the person's centre was inside [m/s]
        """

    @property
    def part(self) -> str:
        """
        where that is: 'nose', 'left', 'right' or 'rear'; a corner belongs to the nose or the rear
        """

    @property
    def person(self) -> int:
        """
        its place among the people
        """

    @property
    def person_approach(self) -> float:
        """
        the person's speed towards the outline there [m/s]
        """

    @property
    def point(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) of the outline that is nearest to the person's centre, in base_link [m]
        """

    @property
    def pose(self) -> lfdcore._core.geometry.Pose2:
        """
        of the chair, T_map_base
        """

    @property
    def position(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) of the person in map [m]
        """

    @property
    def stamp(self) -> float:
        """
        since the reset [s]
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        of its wheels
        """

    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) of the person in map [m/s]
        """

class DrivingWorld:
    """
    A chair with odometry and a LIDAR, driven through a map among people in control periods. The chair stands nowhere until reset(). unknown_is_solid: unknown cells and all outside the map stop the chair and the LIDAR's beams alike (real buildings); else both pass. The same seed gives the same bytes; the noise of a period depends on the seed and the number of the period alone, whatever was driven, and scan noise and slip are separate streams.
    """

    def __init__(
        self,
        grid: lfdcore._core.grid.OccupancyGrid,
        chair: ChairConfig = ...,
        lidar: LidarConfig = ...,
        seed: int = 0,
        unknown_is_solid: bool = True,
    ) -> None: ...
    def people_in_scan(self) -> list[bool]:
        """
        For each person whether a beam of the LIDAR, without noise, meets it first -> list of bool.
        """

    def reset(self, pose: lfdcore._core.geometry.Pose2) -> None:
        """
        Puts the chair at rest at T_map_base, with odometry, counters, clock and noise as new. ValueError for a pose that is not finite or touches an obstacle, saying where.
        """

    def scan(self) -> lfdcore._core.grid.LaserScan:
        """
        What the LIDAR sees now -> LaserScan; asked twice in a period, the same.
        """

    def set_people(self, people: collections.abc.Sequence[Person]) -> None:
        """
        The people (list of Person) from now on, each known by its place in the list: a contact goes on from one list to the next. In step each walks straight on at its velocity, through whatever is there: they are no walls, neither the chair nor they are stopped or pushed where they meet, which is counted (person_contacts). Without people everything is as in a world that never had any, byte by byte. ValueError before a reset, which takes all people away.
        """

    def step(self, command: lfdcore._core.geometry.Twist2, duration: float = 0.1) -> StepResult:
        """
        Drives towards the command (Twist2) for `duration` [s], at most 10 -> StepResult. A command beyond the limits is cut to them. Never ends touching an obstacle. ValueError for values that are not finite and before a reset.
        """

    def touches(self, pose: lfdcore._core.geometry.Pose2, margin: float = 0.0) -> bool:
        """
        True if the footprint, grown by a margin [m], of a chair at T_map_base touches a solid cell.
        """

    @property
    def chair(self) -> ChairConfig:
        """
        its ChairConfig
        """

    @property
    def lidar(self) -> LidarConfig:
        """
        its LidarConfig
        """

    @property
    def odometry(self) -> lfdcore._core.geometry.Pose2:
        """
        T_odom_base; starts at (0, 0, 0)
        """

    @property
    def people(self) -> list[Person]:
        """
        where they are now: list of Person, copies
        """

    @property
    def person_contacts(self) -> list[PersonContact]:
        """
        list of PersonContact since the reset, in the order in which they began
        """

    @property
    def state(self) -> ChairState:
        """
        the truth now (ChairState, a copy)
        """

    @property
    def touches_person(self) -> bool:
        """
        whether a contact with a person is not yet over: until it has been clear by ContactConfig.release_gap for release_time
        """

def joystick_to_twist(
    forward: float, left: float, limits: lfdcore._core.geometry.MotionLimits = ...
) -> lfdcore._core.geometry.Twist2:
    """
    The Twist2 that a joystick asks for: forward in [-1, 1] scales max_linear (max_reverse when negative), left in [-1, 1] scales max_angular. ValueError for values out of [-1, 1] or NaN.
    """
