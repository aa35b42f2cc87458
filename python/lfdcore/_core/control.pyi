"""
Pure pursuit, dynamic window, footprint roll-out and the supervisor.
"""

from __future__ import annotations
import collections.abc
import lfdcore._core.geometry
import lfdcore._core.grid
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "CommandTiming",
    "DynamicWindowConfig",
    "DynamicWindowResult",
    "FootprintRollout",
    "FootprintRolloutConfig",
    "PurePursuitResult",
    "Supervisor",
    "SupervisorConfig",
    "SupervisorResult",
    "pure_pursuit",
    "rollout_pursuit",
    "solve_dynamic_window",
    "time_to_contact",
]

class PurePursuitResult:
    """
    The control point and the twist towards it.
    """

    @property
    def arc_length(self) -> float:
        """
        of the control point along the path [m]
        """

    @property
    def at_end(self) -> bool:
        """
        True if the control point is the path's end, within look_ahead.
        """

    @property
    def control_point(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) g of Alg. 7 [m], in the robot's frame; a read-only view
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        Twist2 [m/s, rad/s]
        """

class DynamicWindowConfig:
    """
    Samples per axis, horizon [s] each twist is held, step [s] between tested poses.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self, *, linear_samples: int = 11, angular_samples: int = 21, horizon: float = 2.0, step: float = 0.1
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def angular_samples(self) -> int: ...
    @property
    def horizon(self) -> float:
        """
        [s]
        """

    @property
    def linear_samples(self) -> int: ...
    @property
    def step(self) -> float:
        """
        [s]
        """

class DynamicWindowResult:
    """
    The chosen twist and where it leads.
    """

    @property
    def cost(self) -> float:
        """
        distance [m] of end_point to the goal; inf if not feasible
        """

    @property
    def end_point(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) where `twist` held over the horizon leads, base_link [m]; a read-only view
        """

    @property
    def feasible(self) -> bool:
        """
        False: every candidate collides, `twist` brakes.
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        Twist2 [m/s, rad/s]
        """

class FootprintRolloutConfig:
    """
    How a path's pursuit is rolled out.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self, *, look_ahead: float = 0.8, linear: float = 0.5, duration: float = 8.0, step: float = 0.1
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def duration(self) -> float:
        """
        how far ahead in time [s]
        """

    @property
    def linear(self) -> float:
        """
        speed wanted along the path [m/s]
        """

    @property
    def look_ahead(self) -> float:
        """
        of the pursuit [m] (Sec. 3.4.3)
        """

    @property
    def step(self) -> float:
        """
        between commands [s]
        """

class FootprintRollout:
    """
    What following a path would do; see rollout_pursuit.
    """

    @property
    def min_clearance(self) -> float:
        """
        least distance [m] of the footprint at these poses from a point, 0 at a contact
        """

    @property
    def poses(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (T, 3) x, y [m], yaw [rad] each step from the start on, in the start's base_link, a view
        """

    @property
    def reached_end(self) -> bool:
        """
        the chair came to the path's end
        """

    @property
    def time_to_contact(self) -> float:
        """
        [s], inf if there is none
        """

class CommandTiming:
    """
    When commands come: a chair's own, not the supervisor's to choose.
    """

    def __hash__(self) -> int: ...
    def __init__(self, *, period: float = 0.1, jitter: float = 0.05) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def jitter(self) -> float:
        """
        [s] by which the next command may come late
        """

    @property
    def period(self) -> float:
        """
        [s] between two commands
        """

class SupervisorConfig:
    """
    How far ahead the supervisor looks and how near it lets the chair come.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        margin: float = 0.04,
        least_margin: float = 0.015,
        margin_linear: float = 0.5,
        margin_angular: float = 1.0,
        passing_margin: float = 0.01,
        dynamics_error: float = 0.2,
        speed_error: float = 0.05,
        obstacle_speed: float = 0.0,
        walking_speed: float = 1.5,
        creep_linear: float = 0.1,
        creep_reverse: float = 0.15,
        creep_angular: float = 0.2,
        least_scale: float = 0.75,
        linear_samples: int = 9,
        angular_samples: int = 17,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def angular_samples(self) -> int:
        """
        turning rates tried, around the wanted one
        """

    @property
    def creep_angular(self) -> float:
        """
        [rad/s] ... and turning; so, unseen space may be entered
        """

    @property
    def creep_linear(self) -> float:
        """
        [m/s] creeping: ahead at most this fast
        """

    @property
    def creep_reverse(self) -> float:
        """
        [m/s] ... backwards
        """

    @property
    def dynamics_error(self) -> float:
        """
        share by which accelerations and braking may be quicker or slower than the limits say
        """

    @property
    def least_margin(self) -> float:
        """
        [m] ... and at standstill; between them in proportion
        """

    @property
    def least_scale(self) -> float:
        """
        share down to which a twist is slowed down first
        """

    @property
    def linear_samples(self) -> int:
        """
        speeds tried, from the wanted one to 0
        """

    @property
    def margin(self) -> float:
        """
        [m] to keep between footprint and points at speed
        """

    @property
    def margin_angular(self) -> float:
        """
        [rad/s] ... or from this turning rate
        """

    @property
    def margin_linear(self) -> float:
        """
        [m/s] from which `margin` is kept ...
        """

    @property
    def obstacle_speed(self) -> float:
        """
        [m/s] at which points may come nearer
        """

    @property
    def passing_margin(self) -> float:
        """
        [m] beside the way of a chair that creeps straight on
        """

    @property
    def speed_error(self) -> float:
        """
        share by which speeds over ground may differ from odometry and command
        """

    @property
    def walking_speed(self) -> float:
        """
        [m/s] ... and those of who walks
        """

class SupervisorResult:
    """
    The command to send and what was done to the wanted one.
    """

    @property
    def changed(self) -> bool:
        """
        it is not the wanted one
        """

    @property
    def keeps(self) -> bool:
        """
        it is admissible; False: it is 0, and even stopping may bring a point nearer than it has to keep
        """

    @property
    def margin(self) -> float:
        """
        [m] that was required of points that were not nearer already, beyond their uncertainty
        """

    @property
    def scale(self) -> float:
        """
        its stick size as a share of the wanted one's (1 if that is 0)
        """

    @property
    def stopped(self) -> bool:
        """
        it is 0 though the wanted one is not
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        Twist2 to send [m/s, rad/s]
        """

class Supervisor:
    """
    Lets commands through that leave the chair able to stop: the admissible command nearest to the wanted one. What it promises, and on what assumptions: docs/safety.md.

    A command is admissible if the chair, from its current twist, obeys the pending commands, follows this one for the timing's `period`, up to `jitter` longer, and brakes to a standstill, without any point coming nearer to the footprint than it has to keep, whatever the errors of the config allow. A point has to keep the margin (by the speed) + its uncertainty + obstacle_speed (age + time until standstill), but never more than its distance now, below 0 inside the footprint: a point that is too near must not come nearer, and says nothing about others. A chair that creeps straight on may pass what is surely beside its way, and a wall that touches its side. Tried in turn: the wanted twist; its scaled copies down to least_scale; other twists that may replace it, by their distance to it; 0.

    Raises ValueError for invalid limits, config or timing. Not for use from two threads at once.
    """

    def __init__(
        self,
        footprint: lfdcore._core.geometry.Footprint = ...,
        limits: lfdcore._core.geometry.MotionLimits = ...,
        config: SupervisorConfig = ...,
        timing: CommandTiming = ...,
    ) -> None: ...
    def filter(
        self,
        wanted: lfdcore._core.geometry.Twist2,
        current: lfdcore._core.geometry.Twist2,
        obstacles: lfdcore._core.grid.ObstaclePoints,
        *,
        pending: collections.abc.Sequence[tuple[lfdcore._core.geometry.Twist2, float]] = [],
        age: float = 0.0,
        unseen: lfdcore._core.grid.ObstaclePoints | None = None,
        walkers: lfdcore._core.grid.ObstaclePoints | None = None,
    ) -> SupervisorResult:
        """
        The command to send.

        - current: the chair's twist now.
        - obstacles: in base_link, now. Without points everything is admissible: a caller whose scan is stale must want 0.
        - pending: (twist, duration [s]) of the commands already given, in the order in which they act from now on, before this one does.
        - age [s] of the points; counts with obstacle_speed and walking_speed.
        - unseen: places in base_link at the border of space that no beam has seen. A command faster than the creep speeds is admissible only if its roll-outs keep them out of the footprint. None: as if all were seen.
        - walkers: points in base_link of who walks about: they may come nearer at walking_speed. None: nobody.

        Raises ValueError for a non-finite twist, a current or pending one beyond 10 times the limits, a duration or an age that is not in [0, 10] s.
        """

    def may_replace(self, wanted: lfdcore._core.geometry.Twist2, twist: lfdcore._core.geometry.Twist2) -> bool:
        """
        Whether a twist may stand in for the wanted one (within the limits), as far as the driver is concerned. Where a turn on the spot is wanted (linear 0): a slower turn to the same side. Else: linear between 0 and the wanted one; a stick size hypot(linear / max_linear or max_reverse, angular / max_angular) no larger than the wanted one's; not to the side opposite to the one asked for; nearer to the wanted twist than 0 is.
        """

    def reset(self) -> None:
        """
        Forgets how near the walls were that touch the chair's sides. A wanted twist of 0 does so, too.
        """

    @property
    def config(self) -> SupervisorConfig: ...
    @property
    def footprint(self) -> lfdcore._core.geometry.Footprint: ...
    @property
    def limits(self) -> lfdcore._core.geometry.MotionLimits: ...
    @property
    def timing(self) -> CommandTiming: ...

def pure_pursuit(
    path: numpy.typing.ArrayLike,
    look_ahead: float,
    linear: float,
    max_angular: float = 1.0,
    *,
    pose: lfdcore._core.geometry.Pose2 = ...,
) -> PurePursuitResult:
    """
    Pure Pursuit (App. E.1, Alg. 7) of a path (N, 2) [m] by a robot at `pose` in the path's frame (default: the path is in base_link).

    Control point: where the path, after its point closest to the robot, first leaves the circle of radius look_ahead [m]; its end if it does not leave it; its closest point if it lies wholly outside. Twist: `linear` [m/s] >= 0 along the arc through it, both reduced together where it would turn faster than max_angular [rad/s]; a control point behind is turned to in place.

    Raises ValueError for an empty or non-finite path, look_ahead or max_angular that are not positive, or a negative or non-finite linear.
    """

def rollout_pursuit(
    path: numpy.typing.ArrayLike,
    obstacles: lfdcore._core.grid.ObstaclePoints,
    footprint: lfdcore._core.geometry.Footprint,
    limits: lfdcore._core.geometry.MotionLimits = ...,
    twist: lfdcore._core.geometry.Twist2 = ...,
    *,
    config: FootprintRolloutConfig = ...,
) -> FootprintRollout:
    """
    Follow a path (N, 2) [m] in base_link from its origin by pure pursuit (App. E.1), the speeds changing as
    `limits` allow from `twist` on, braking so as to stop at the path's end. Ends at a contact (the last pose is
    the one before it), at the path's end or after config.duration. The contact test is conservative between
    steps: never later than the true contact, and a gap below 5 mm may count. Obstacles are in base_link too;
    for a safety margin pass footprint.grown(margin). ValueError for a path that is empty or not finite.
    """

def solve_dynamic_window(
    current: lfdcore._core.geometry.Twist2,
    goal: numpy.typing.ArrayLike,
    obstacles: lfdcore._core.grid.ObstaclePoints,
    footprint: lfdcore._core.geometry.Footprint = ...,
    limits: lfdcore._core.geometry.MotionLimits = ...,
    config: DynamicWindowConfig = ...,
    wanted: lfdcore._core.geometry.Twist2 = ...,
    period: float = 0.1,
) -> DynamicWindowResult:
    """
    Dynamic Window Approach (App. E.2, Alg. 8; ERRATA 47): of the twists that `limits` let the chair reach from `current` within a `period` [s] between two commands, the one that ends nearest to goal (2,) [m] after the horizon without the footprint touching `obstacles` at any step; all in base_link. Of those that end alike (all turns on the spot do) the one nearest to `wanted`. If all collide it brakes at the limit (feasible = False).

    Raises ValueError for a non-finite twist or goal or a period that is not positive.
    """

def time_to_contact(
    twist: lfdcore._core.geometry.Twist2,
    obstacles: lfdcore._core.grid.ObstaclePoints,
    footprint: lfdcore._core.geometry.Footprint,
    horizon: float,
) -> float:
    """
    Time [s] until a body that keeps `twist` from base_link's origin touches a point, inf if not within `horizon`
    [s]; never later than the true contact. ValueError beyond 10 m/s, 10 rad/s or 600 s.
    """
