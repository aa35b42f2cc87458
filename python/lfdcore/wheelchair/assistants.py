"""The assistants: none, the supervisor alone, DWA (App. E.2), and one that follows planned paths (Ch. 3, Ch. 4).

One update a tick. An assistant sees scan, odometry and joystick, nothing else. Its whole state is what it remembers of
those.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import (
    CommandTiming,
    DynamicWindowConfig,
    PurePursuitResult,
    Supervisor,
    SupervisorConfig,
    pure_pursuit,
    solve_dynamic_window,
    time_to_contact,
)
from lfdcore.geometry import MotionLimits, Pose2, Twist2, integrate, wrap_angle
from lfdcore.grid import ObstaclePoints
from lfdcore.simulation import joystick_to_twist
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.pending import PendingCommands
from lfdcore.wheelchair.planner import COMPLIANT_FROM, PlannedPath, Planner
from lfdcore.wheelchair.stick import DEAD_ZONE
from lfdcore.wheelchair.surroundings import MEMORY, Surroundings
from lfdcore.wheelchair.watch import FAULT, Watch, WatchConfig

STOP = Twist2(0.0, 0.0)
PROJECTION = 1.0
"""[s] "forward projecting the user's input by one second" for DWA (Sec. 3.5)"""


class Assistant(Protocol):
    """What the chair asks for its next command."""

    name: str
    chair: ChairGeometry
    """Which chair it was made for"""

    def reset(self) -> None:
        """Forgets everything about the drive so far."""

    def update(self, observation: Observation) -> Assistance:
        """The command for this tick. Whatever is observed, it raises nothing."""


class Unassisted:
    """The joystick drives the chair. It needs no scanner: only a silent stick, or one that says nonsense, stops it."""

    name = "none"

    def __init__(self, chair: ChairGeometry, watch: WatchConfig | None = None) -> None:
        self.chair = chair
        self._watch = Watch(chair, watch)

    def reset(self) -> None:
        """Forgets all stamps."""
        self._watch.reset()

    def update(self, observation: Observation) -> Assistance:
        """The joystick's twist; a silent stick or numbers that are none: stop."""
        halt = self._watch.judge_stick(observation)
        if halt is not None:
            return Assistance(STOP, halt)
        return Assistance(joystick_to_twist(*observation.joystick, self.chair.limits), "user")


class SeeingAssistant(ABC):
    """What every assistant that needs a scanner does at each tick: stop where its senses cannot be trusted (Watch),
    remember what is around (Surroundings), decide, then be limited: by the watch, then by the supervisor if it has one.
    """

    name: str

    def __init__(
        self,
        chair: ChairGeometry,
        *,
        supervisor: SupervisorConfig | None,
        map_duration: float = MEMORY,
        watch: WatchConfig | None = None,
    ) -> None:
        self.chair = chair
        self._watch = Watch(chair, watch)
        self._surroundings = Surroundings(chair, map_duration)
        self._pending = PendingCommands(chair.latency, chair.period + chair.jitter)
        timing = CommandTiming(period=chair.period, jitter=chair.jitter)
        self._supervisor = None if supervisor is None else Supervisor(chair.footprint, chair.limits, supervisor, timing)

    def reset(self) -> None:
        """Forgets everything about the drive so far."""
        self._watch.reset()
        self._surroundings.clear()
        self._pending.reset()
        if self._supervisor is not None:
            self._supervisor.reset()
        self._let_go(STOP)

    def update(self, observation: Observation) -> Assistance:
        """The command for this tick; what cannot be trusted is a mode in which it stops, never an exception."""
        halt = self._watch.judge(observation)
        said = self._drive(observation) if halt is None else self._halt(observation, halt)
        self._pending.give(observation.stamp, said.command)
        return said

    def overruled(self, stamp: float, command: Twist2) -> None:
        """The chair was given `command` [m/s, rad/s] at `stamp` [s], and not what update() said."""
        self._pending.give(stamp, command)

    def _halt(self, observation: Observation, mode: str) -> Assistance:
        if mode == FAULT:  # where the chair is, or when, is no longer what they were made with
            self._surroundings.clear()
            self._pending.reset()
        self._let_go(observation.twist)
        return Assistance(STOP, mode)

    def _drive(self, observation: Observation) -> Assistance:
        obstacles = self._surroundings.see(observation)
        said = self._decide(observation, obstacles)
        limited = self._watch.limited(said.command, observation.stamp)
        return self._supervised(replace(said, command=limited), observation, obstacles)

    @abstractmethod
    def _decide(self, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        """What the assistant would do, of itself."""

    def _let_go(self, twist: Twist2) -> None:  # noqa: B027 - most have nothing to let go of
        """The chair stops, from `twist`: a path that was followed ends."""

    def _supervised(self, said: Assistance, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        if self._supervisor is None:
            return said
        allowed = self._supervisor.filter(
            said.command,
            self._watch.twist(observation),
            obstacles,
            pending=self._pending.at(observation.stamp, observation.odometry_stamp),
            age=self._surroundings.age(observation),
            unseen=self._surroundings.unseen(observation),
            walkers=self._surroundings.walkers(observation),
        )
        return replace(said, command=allowed.twist, supervised=allowed.changed)


class Supervised(SeeingAssistant):
    """The joystick drives the chair as far as the supervisor lets it: what the supervisor does alone."""

    name = "supervisor"

    def __init__(self, chair: ChairGeometry, map_duration: float = MEMORY, watch: WatchConfig | None = None) -> None:
        super().__init__(chair, supervisor=SupervisorConfig(), map_duration=map_duration, watch=watch)

    def _decide(self, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        return Assistance(joystick_to_twist(*observation.joystick, self.chair.limits), "user")


class DynamicWindowAssistant(SeeingAssistant):
    """DWA towards the user's input projected ahead (Sec. 3.5, Alg. 8): the reactive baseline."""

    def __init__(
        self,
        chair: ChairGeometry,
        config: DynamicWindowConfig | None = None,
        projection: float = PROJECTION,
        map_duration: float = MEMORY,
        name: str = "dwa",
        watch: WatchConfig | None = None,
    ) -> None:
        super().__init__(chair, supervisor=None, map_duration=map_duration, watch=watch)
        self.name = name
        self.config = config or DynamicWindowConfig()
        self.projection = projection

    def _decide(self, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        """The twist whose end point comes nearest to the projected input; joystick at rest: stop."""
        if math.hypot(*observation.joystick) < DEAD_ZONE:
            return Assistance(STOP, "rest")
        wanted = joystick_to_twist(*observation.joystick, self.chair.limits)
        goal = integrate(Pose2(), wanted, self.projection)
        found = solve_dynamic_window(
            observation.twist,
            np.array([goal.x, goal.y]),
            obstacles,
            self.chair.footprint,
            self.chair.limits,
            self.config,
            wanted,
            self.chair.period,
        )
        ahead = observation.pose * goal
        end = (float(found.end_point[0]), float(found.end_point[1]))
        return Assistance(_within(found.twist, self.chair.limits), "dwa", goal=(ahead.x, ahead.y), control_point=end)


def _within(twist: Twist2, limits: MotionLimits) -> Twist2:
    return Twist2(
        float(np.clip(twist.linear, -limits.max_reverse, limits.max_linear)),
        float(np.clip(twist.angular, -limits.max_angular, limits.max_angular)),
    )


@dataclass(frozen=True, kw_only=True)
class DriveAssistantConfig:
    """How an assistant drives along planned paths. The printed values are those of `thesis()`."""

    compliance_threshold: float = COMPLIANT_FROM
    """Below it a new path is requested (Sec. 3.4.3)."""
    replan_after: float = 2.0
    """[s] A path is renewed at the latest after this, or long turns that look compliant circle; printed: never."""
    refuse_below: float = 0.1
    """A new path that leads so far from the input (compliance) is not followed at all; printed: 0, any is."""
    replan_pause: float = 0.5
    """[s] For so long a path stays that was incompliant already when it was made, unless the stick turns: asking again
    at once would give the same; printed: 0."""
    map_duration: float = MEMORY
    """Memory of the rolling map [s]; printed: the present scan only."""
    own_turn_after: float = np.radians(90)
    """A driver who goes on asking for a turn to one side after the chair has turned this far [rad] wants a tighter one
    than any path: the user's own input, supervised; printed: never."""
    own_turn_patience: float = 6.0
    """... or has asked for it this long [s], more than a turn takes at an usual speed; printed: never."""
    dead_zone: float = DEAD_ZONE
    """A joystick displaced less than this is at rest: stop."""
    reverse_from: float = np.radians(100)
    """Inputs at least this far [rad] from straight ahead are the user's own business (reversing), supervised."""
    no_path_share: float = 0.6
    """Without a path: the user's own input times this, supervised; printed: stop."""
    slow_within: float = 1.0
    """With contact ahead in less than this [s] on the present arc, slow in proportion; 0: never (printed)."""
    slowest_share: float = 0.35
    """... but not below this share."""
    smoothing: float = 0.2
    """Time constant [s] of the second-order low-pass on the command along a path, whose delay the pursuit looks ahead
    by; 0: none (printed)."""
    supervisor: SupervisorConfig | None = field(default_factory=SupervisorConfig)
    """None: no supervisor (printed)."""

    @staticmethod
    def thesis() -> DriveAssistantConfig:
        """The printed loop, which drives into things (docs/decisions.md). How paths are planned in it is the planner's
        to say: `model.planner(chair, thesis=True)`."""
        return DriveAssistantConfig(
            replan_after=float("inf"),
            refuse_below=0.0,
            replan_pause=0.0,
            own_turn_after=float("inf"),
            own_turn_patience=float("inf"),
            map_duration=0.01,
            no_path_share=0.0,
            slow_within=0.0,
            smoothing=0.0,
            supervisor=None,
        )


class _Smoother:
    """Two low-passes in a row on a twist: bounded angular jerk for a delay of twice the time constant.

    time_constant [s]; period [s] until the first tick of a drive.
    """

    def __init__(self, time_constant: float, period: float) -> None:
        self._time_constant, self._period = time_constant, period
        self._inner = self._outer = STOP
        self._stamp: float | None = None

    def restart(self, twist: Twist2, stamp: float | None = None) -> None:
        """Goes on from what the chair is doing, at `stamp` [s]."""
        self._inner = self._outer = twist
        self._stamp = stamp

    def filter(self, wanted: Twist2, stamp: float) -> Twist2:
        """The smoothed twist at `stamp` [s]; slowing down is never delayed."""
        passed = self._period if self._stamp is None else stamp - self._stamp
        share = 1.0 if self._time_constant <= 0 else 1.0 - math.exp(-passed / self._time_constant)
        self._stamp = stamp
        self._inner = _between(self._inner, wanted, share)
        self._outer = _between(self._outer, self._inner, share)
        if self._outer.linear > wanted.linear:
            self._outer = Twist2(wanted.linear, self._outer.angular)
        return self._outer


def _between(a: Twist2, b: Twist2, share: float) -> Twist2:
    return Twist2(a.linear + share * (b.linear - a.linear), a.angular + share * (b.angular - a.angular))


class _HeldTurn:
    """How far the chair has turned, and for how long, while the stick kept asking for a turn to one and the same side,
    also backwards."""

    STRAIGHT = 0.3  # inputs within this [rad] of straight ahead ask for no turn

    def __init__(self) -> None:
        self._side = 0.0
        self._yaw = 0.0
        self._turned = 0.0
        self._since = 0.0

    def update(self, observation: Observation) -> tuple[float, float]:
        """Takes in a tick; -> angle turned [rad], time [s]."""
        forward, left = observation.joystick
        side = float(np.sign(left)) if abs(np.arctan2(left, forward)) > self.STRAIGHT else 0.0
        yaw = observation.pose.yaw
        if side == 0 or side != self._side:
            self._turned, self._since = 0.0, observation.stamp
        else:
            self._turned += side * float(wrap_angle(yaw - self._yaw))
        self._side, self._yaw = side, yaw
        return self._turned, observation.stamp - self._since


@dataclass
class _Track:
    """The path being followed."""

    planned: PlannedPath
    stamp: float
    joystick: tuple[float, float]
    path_odom: NDArray[np.float64]
    goal_odom: tuple[float, float]


class DriveAssistant(SeeingAssistant):
    """Drives the planner's chair along its paths: plan, track, let go at once when the driver disagrees (Sec. 3.4)."""

    def __init__(
        self,
        planner: Planner,
        config: DriveAssistantConfig | None = None,
        name: str = "learned",
        watch: WatchConfig | None = None,
    ) -> None:
        self.config = config or DriveAssistantConfig()
        super().__init__(
            planner.chair, supervisor=self.config.supervisor, map_duration=self.config.map_duration, watch=watch
        )
        self.name = name
        self.planner = planner
        self._smoother = _Smoother(self.config.smoothing, self.chair.period)
        self._held_turn = _HeldTurn()
        self._track: _Track | None = None

    def _decide(self, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        """Joystick at rest: stop. Reversing, or a turn held for long: the user's own. Else: along a path to the
        intention."""
        forward, left = observation.joystick
        if np.hypot(forward, left) < self.config.dead_zone:
            self._let_go(observation.twist)
            return Assistance(STOP, "rest")
        turned, held = self._held_turn.update(observation)
        if abs(np.arctan2(left, forward)) >= self.config.reverse_from:
            self._track = None
            return Assistance(self._own(observation, 1.0), "reverse")
        if turned >= self.config.own_turn_after or held >= self.config.own_turn_patience - 1e-9:
            self._track = None
            return Assistance(self._own(observation, 1.0), "own_turn")
        planned = self._replan(observation, obstacles)
        if self._track is None:
            return Assistance(self._own(observation, self.config.no_path_share), "no_path")
        return self._follow(self._track, observation, obstacles, planned)

    def _let_go(self, twist: Twist2) -> None:
        self._track = None
        self._held_turn = _HeldTurn()
        self._smoother.restart(twist)  # what the chair still does is where a path would go on from

    def _own(self, observation: Observation, share: float) -> Twist2:
        wanted = joystick_to_twist(*observation.joystick, self.chair.limits)
        return Twist2(wanted.linear * share, wanted.angular * share)

    def _replan(self, observation: Observation, obstacles: ObstaclePoints) -> bool:
        """Keeps a path that is fresh, compliant and longer than a look-ahead; else asks for one. True if there is."""
        if self._track is not None and not self._due(self._track, observation):
            return False
        planned = self.planner.plan(observation, self._surroundings.grid(observation), obstacles)
        self._track = None if planned is None else _track(planned, observation)
        if self._track is not None and self._compliance(self._track, observation) < self.config.refuse_below:
            self._track = None
        return self._track is not None

    def _due(self, track: _Track, observation: Observation) -> bool:
        age = observation.stamp - track.stamp
        if age >= self.config.replan_after - 1e-9:
            return True
        if self._pursue(track, observation, track.planned.look_ahead).at_end:
            return True
        if self._compliance(track, observation) >= self.config.compliance_threshold:
            return False
        return age >= self.config.replan_pause - 1e-9 or _angle_between(track.joystick, observation.joystick) > 0.1

    def _compliance(self, track: _Track, observation: Observation) -> float:
        """Of the point a whole look-ahead on, also where the pursuit itself looks less far (Sec. 3.4.3)."""
        ahead = self._pursue(track, observation, self.planner.look_ahead)
        point = np.array([ahead.control_point])
        return float(self.planner.compliances(point, np.array(observation.joystick))[0])

    def _pursue(self, track: _Track, observation: Observation, look_ahead: float) -> PurePursuitResult:
        """|v| <= vmax |stick| and |w| <= wmax |stick| (Sec. 3.4.2)."""
        share = min(1.0, float(np.hypot(*observation.joystick)))
        limits = self.chair.limits
        speed, turn = limits.max_linear * share, limits.max_angular * share
        pose = integrate(observation.pose, observation.twist, 2 * self.config.smoothing)
        return pure_pursuit(track.path_odom, look_ahead, speed, turn, pose=pose)

    def _follow(self, track: _Track, observation: Observation, obstacles: ObstaclePoints, planned: bool) -> Assistance:
        pursuit = self._pursue(track, observation, track.planned.look_ahead)
        share = self._slow_share(pursuit.twist, obstacles)
        point = (float(pursuit.control_point[0]), float(pursuit.control_point[1]))
        return Assistance(
            command=self._smoother.filter(
                Twist2(pursuit.twist.linear * share, pursuit.twist.angular * share), observation.stamp
            ),
            mode="path",
            path=track.path_odom,
            planned=planned,
            goal=track.goal_odom,
            likelihood=track.planned.likelihood,
            compliance=self._compliance(track, observation),
            control_point=point,
        )

    def _slow_share(self, twist: Twist2, obstacles: ObstaclePoints) -> float:
        within = self.config.slow_within
        if within <= 0:
            return 1.0
        until = time_to_contact(twist, obstacles, self.chair.footprint, within)
        return float(np.clip(until / within, self.config.slowest_share, 1.0))

    def _supervised(self, said: Assistance, observation: Observation, obstacles: ObstaclePoints) -> Assistance:
        allowed = super()._supervised(said, observation, obstacles)
        if allowed.mode != "rest" and (allowed.supervised or allowed.mode != "path"):
            self._smoother.restart(allowed.command, observation.stamp)
        return allowed


def _track(planned: PlannedPath, observation: Observation) -> _Track:
    goal = observation.pose.transform(np.array([planned.goal]))[0]
    path = observation.pose.transform(planned.path)
    return _Track(planned, observation.stamp, observation.joystick, path, (float(goal[0]), float(goal[1])))


def _angle_between(a: tuple[float, float], b: tuple[float, float]) -> float:
    return abs(float(wrap_angle(np.arctan2(a[1], a[0]) - np.arctan2(b[1], b[0]))))
