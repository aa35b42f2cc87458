"""Simulated drivers: an expert demonstrator, an able driver and an impaired one. docs/simulated-drivers.md lists all
that is assumed.

A driver sees the chair's true pose, late, its route and the course's map. It never sees the assistant: its noise of
tick k depends on the seed and k only, so every arm of a study meets the same driver.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import ClassVar, Protocol

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, integrate, wrap_angle
from lfdcore.simulated.courses.course import Course
from lfdcore.simulated.courses.routes import clearance_field
from lfdcore.simulated.route_tracking import AutoregressiveNoise, DelayedView, MapSense, RouteTracker
from lfdcore.wheelchair.observation import PERIOD

FloatArray = npt.NDArray[np.float64]

ORIENTATIONS = tuple(math.radians(degrees) for degrees in (0, 72, -72, 144, -144))
"""The five evenly spaced joystick orientations [rad, 0 = forward, positive = left] of Sec. 3.5.1."""


@dataclass(frozen=True, eq=False)
class DriverInput:
    """joystick (2,) [forward, left] as given; desired (2,) as meant, before the disability. Both in [-1, 1]."""

    joystick: FloatArray
    desired: FloatArray


class StickHolder(Protocol):
    """Whoever moves a stick. It sees the chair's true pose; never the assistant."""

    def reset(self, seed: int) -> None:
        """A new run."""

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick at `stamp` [s], for the chair's pose [map] and twist."""


@dataclass(frozen=True)
class DriverConfig:
    """What all drivers have. Noise is one AR(1) sample per tick, i.e. per call of act(), meant at 10 Hz."""

    look_ahead: float = 0.8  # along the route [m]
    speed: float = 0.75  # stick magnitude when nothing slows the driver, 0..1
    delay: float = 0.2  # perception [s]
    noise_sd: float = 0.0  # steering: of `left` (expert, able) or of the stick's angle [rad] (impaired)
    noise_correlation: float = 0.8  # between ticks
    stop_within: float = 0.15  # the end counts as reached this far along the route before it [m]
    reverse_time: float = 1.2  # after a hit or a stall [s], and as much again each further time in a row, up to 3 x
    stall_time: float = 3.0  # no progress for so long [s] is a stall
    stall_distance: float = 0.10  # what counts as progress [m], or as much in [rad]
    free_clearance: float = 1.2  # from the nose to the nearest thing [m]: full speed from here on
    slowest: float = 1.0  # share of the speed left with half a chair's width around the nose; 1: never slows

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{field.name} must be finite and >= 0, got {value}")
        for name in ("speed", "noise_correlation"):
            if getattr(self, name) > 1:
                raise ValueError(f"{name} must be at most 1, got {getattr(self, name)}")
        if self.look_ahead < 0.1:
            raise ValueError(f"look_ahead must be at least 0.1 m, got {self.look_ahead} m")


@dataclass(frozen=True)
class ExpertConfig(DriverConfig):
    """A smooth demonstrator who slows down where it is tight."""

    look_ahead: float = 0.4
    speed: float = 0.8
    delay: float = 0.1
    noise_sd: float = 0.03
    noise_correlation: float = 0.9
    slowest: float = 0.35
    stick_rate: float = 2.0  # how fast the stick moves [1/s]


@dataclass(frozen=True)
class AbleConfig(DriverConfig):
    """Calibrated on the figure-8 against Table A.1."""

    look_ahead: float = 0.9
    speed: float = 0.46  # Table A.1: mean forward joystick signal
    delay: float = 0.4
    noise_sd: float = 0.10
    noise_correlation: float = 0.85
    slowest: float = 0.5
    notice_time: float = 1.0  # how far ahead it sees that its movement will hit [s]


@dataclass(frozen=True)
class ImpairedConfig(DriverConfig):
    """A driver who can only point roughly: five orientations, held between decisions."""

    slowest: float = 0.6
    noise_sd: float = math.radians(10)
    decision_time: float = 0.3  # between decisions [s]
    notice_probability: float = 0.4  # of seeing, at a decision, that its movement will hit
    notice_time: float = 0.6  # how far ahead it can see a hit [s]
    facing_away: float = math.radians(110)  # only a target beyond this bearing [rad] may ask for +-144 degrees

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.notice_probability > 1:
            raise ValueError(f"notice_probability must be at most 1, got {self.notice_probability}")


POPULATION = {
    "look_ahead": (0.7, 1.0),
    "speed": (0.65, 0.85),
    "delay": (0.15, 0.25),
    "noise_sd": (math.radians(8), math.radians(12)),
    "notice_probability": (0.3, 0.5),
}
"""Ranges from which `population` draws an impaired driver's parameters, uniformly."""


def population(n: int, seed: int) -> tuple[ImpairedConfig, ...]:
    """n impaired drivers drawn from POPULATION; driver i is the same whatever n. Raises ValueError if n < 1."""
    return tuple(ImpairedConfig(**drawn) for drawn in _drawn(_POPULATION, POPULATION, n, seed))


ABLE_POPULATION = {
    "look_ahead": (0.75, 1.05),
    "speed": (0.40, 0.52),
    "delay": (0.3, 0.5),
    "noise_sd": (0.07, 0.13),
}
"""Ranges, around AbleConfig's values, from which `able_population` draws an able driver's parameters, uniformly."""


def able_population(n: int, seed: int) -> tuple[AbleConfig, ...]:
    """n able drivers drawn from ABLE_POPULATION; driver i is the same whatever n. Raises ValueError if n < 1."""
    return tuple(AbleConfig(**drawn) for drawn in _drawn(_ABLE_POPULATION, ABLE_POPULATION, n, seed))


def _drawn(stream: int, ranges: dict[str, tuple[float, float]], n: int, seed: int) -> Iterator[dict[str, float]]:
    if n < 1:
        raise ValueError(f"n must be at least 1, got {n}")
    for i in range(n):
        rng = np.random.default_rng([stream, _checked_seed(seed), i])
        yield {name: float(rng.uniform(*span)) for name, span in ranges.items()}


_POPULATION, _ABLE_POPULATION, _STEERING, _NOTICING = 0x909, 0xAB1E, 0x57E, 0x707
"""Streams of random numbers."""


def _checked_seed(seed: int) -> int:
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise ValueError(f"seed must be an integer >= 0, got {seed!r}")
    return int(seed)


class Driver(ABC):
    """A simulated person who drives a course. Call reset(seed), then act() every 0.1 s until `done`."""

    name: str
    default_config: ClassVar[type[DriverConfig]]

    def __init__(
        self,
        course: Course,
        config: DriverConfig | None = None,
        limits: MotionLimits | None = None,
        footprint: Footprint | None = None,
    ) -> None:
        self.course = course
        self.config = config or self.default_config()
        self._limits = limits or MotionLimits()
        self._footprint = footprint or Footprint()
        self._sense = MapSense(course.grid, self._footprint)
        self._clearance = clearance_field(course.grid)
        self._tracker = RouteTracker(course)
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Starts over at the route's start with fresh noise. Raises ValueError for a negative seed."""
        seed = _checked_seed(seed)
        c = self.config
        self._tracker.reset()
        self._view = DelayedView(c.delay)
        self._noise = AutoregressiveNoise(c.noise_sd, c.noise_correlation, np.random.default_rng([_STEERING, seed]))
        self._recovery = _Recovery(c)
        self._stamp = -math.inf
        self._done = False

    @property
    def done(self) -> bool:
        """Whether the route's end was reached; it stays so until reset()."""
        return self._done

    @property
    def progress(self) -> float:
        """Share of the route behind the driver, 0..1."""
        return 1.0 if self._done else self._tracker.travelled / self._tracker.length

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """The stick now. stamp [s], rising; pose: T_map_base, true; in_contact: what the driver feels.

        Raises ValueError for a stamp that does not rise or a pose or twist that is not finite.
        """
        self._check(stamp, pose, twist)
        self._stamp, self._felt = stamp, twist
        noise = self._draw()
        seen = self._view.see(stamp, pose)
        self._tracker.advance(seen.x, seen.y)
        self._done = self._done or self._at_end(seen)
        if self._done:
            return DriverInput(np.zeros(2), np.zeros(2))
        reversing = self._recovery.update(stamp, seen, in_contact, self._tracker.travelled)
        return self._steer(stamp, seen, noise, reversing)

    @abstractmethod
    def _steer(self, stamp: float, seen: Pose2, noise: tuple[float, float], reversing: bool) -> DriverInput: ...

    def _draw(self) -> tuple[float, float]:
        """This tick's noise; always drawn, whatever the driver does with it."""
        return self._noise.next(), 1.0

    def _check(self, stamp: float, pose: Pose2, twist: Twist2) -> None:
        if not math.isfinite(stamp) or stamp <= self._stamp:
            raise ValueError(f"stamp must be finite and later than {self._stamp} s, got {stamp} s")
        if not all(math.isfinite(value) for value in (*pose, *twist)):
            raise ValueError(f"pose and twist must be finite, got {pose} and {twist}")

    def _at_end(self, seen: Pose2) -> bool:
        end = self.course.route[-1]
        near = math.hypot(end[0] - seen.x, end[1] - seen.y) < 0.5 or self.course.loop
        return near and self._tracker.remaining <= self.config.stop_within

    def _target(self, seen: Pose2) -> tuple[float, float]:
        """Bearing [rad] and distance [m] of the farthest point of the route in view within the look-ahead.

        Where the driver slows down, it looks less far ahead by the same share.
        """
        reach = self.config.look_ahead * self._caution(seen)
        for share in (1.0, 0.75, 0.5, 0.25):
            point = self._tracker.point(share * reach)
            if self._sense.sees(seen.x, seen.y, point):
                break
        dx, dy = float(point[0]) - seen.x, float(point[1]) - seen.y
        return float(wrap_angle(math.atan2(dy, dx) - seen.yaw)), math.hypot(dx, dy)

    def _magnitude(self, seen: Pose2) -> float:
        """The stick's magnitude: less where it is tight, and before the end of a route, where the driver must stop."""
        speed = self.config.speed * self._caution(seen)
        return speed if self.course.loop else min(speed, max(0.15, self._tracker.remaining / 1.5))

    def _caution(self, seen: Pose2) -> float:
        """Share of the speed that the room around the nose leaves."""
        c = self.config
        if c.slowest == 1.0:
            return 1.0
        nose = seen * Pose2(self._footprint.front, 0.0, 0.0)
        at = (np.array([nose.x, nose.y]) - np.array(self.course.grid.origin)) / self.course.grid.resolution - 0.5
        room = float(map_coordinates(self._clearance, [[at[1]], [at[0]]], order=1, mode="nearest")[0])
        half = self._footprint.half_width
        return c.slowest + (1 - c.slowest) * float(np.clip((room - half) / (c.free_clearance - half), 0.0, 1.0))

    def _pursuit(self, seen: Pose2, speed: float) -> tuple[float, float]:
        """forward and left that follow the route at a stick magnitude: pure pursuit (E.1), turning where it is behind.

        Where the turn asks for more than the stick has, the driver goes slower.
        """
        bearing, distance = self._target(seen)
        if abs(bearing) > math.radians(75):
            return 0.0, math.copysign(min(1.0, 1.3 * speed), bearing)
        curvature = 2 * math.sin(bearing) / max(distance, 0.3)
        linear = speed * self._limits.max_linear
        linear = min(linear, 0.9 * self._limits.max_angular / max(abs(curvature), 1e-9))
        return linear / self._limits.max_linear, curvature * linear / self._limits.max_angular

    def _twist(self, stick: FloatArray) -> Twist2:
        limits = self._limits
        top = limits.max_linear if stick[0] >= 0 else limits.max_reverse
        return Twist2(float(stick[0]) * top, float(stick[1]) * limits.max_angular)


class _Recovery:
    """Reversing after a hit or a stall."""

    def __init__(self, config: DriverConfig) -> None:
        self._config = config
        self._until = -math.inf
        self._tries = 0
        self._last_try = 0.0
        self._was_in_contact = False
        self._mark: tuple[float, Pose2] | None = None

    def update(self, stamp: float, seen: Pose2, in_contact: bool, travelled: float) -> bool:
        """Whether the driver reverses now."""
        if stamp >= self._until and (self._hit(in_contact) or self._stalled(stamp, seen)):
            self._tries = self._tries + 1 if travelled - self._last_try < 0.5 else 1
            self._last_try = travelled
            self._until = stamp + self._config.reverse_time * min(self._tries, 3)
            self._mark = None
        self._was_in_contact = in_contact
        return stamp < self._until

    def _hit(self, in_contact: bool) -> bool:
        return in_contact and not self._was_in_contact

    def _stalled(self, stamp: float, seen: Pose2) -> bool:
        if self._mark is None or self._moved(self._mark[1], seen):
            self._mark = (stamp, seen)
        return stamp - self._mark[0] >= self._config.stall_time

    def _moved(self, before: Pose2, now: Pose2) -> bool:
        enough = self._config.stall_distance
        turned = abs(float(wrap_angle(now.yaw - before.yaw)))
        return math.hypot(now.x - before.x, now.y - before.y) > enough or turned > enough


def _stick(forward: float, left: float) -> FloatArray:
    """A stick within the unit circle."""
    size = max(1.0, math.hypot(forward, left))
    return np.array([forward / size, left / size])


class AbleDriver(Driver):
    """Follows the route with a small, correlated wobble of `left`; no disability, so joystick = desired."""

    name = "able"

    default_config = AbleConfig
    config: AbleConfig

    def _steer(self, stamp: float, seen: Pose2, noise: tuple[float, float], reversing: bool) -> DriverInput:
        forward, left = (-0.5, 0.0) if reversing else self._pursuit(seen, self._magnitude(seen))
        stick = _stick(forward, left + noise[0])
        if not reversing and self._hits(seen, stick):
            stick = self._away_from_the_hit(seen, stick)
        return DriverInput(stick, stick.copy())

    def _hits(self, seen: Pose2, stick: FloatArray) -> bool:
        # what is seen late, moved on by the motion that is felt
        now = integrate(seen, self._felt, self.config.delay)
        return math.isfinite(self._sense.time_to_hit(now, self._twist(stick), self.config.notice_time))

    def _away_from_the_hit(self, seen: Pose2, stick: FloatArray) -> FloatArray:
        """Half the speed and the least turn that avoids the hit; slower still where none does."""
        for turn in (0.0, 0.2, -0.2, 0.4, -0.4, 0.6, -0.6):
            option = _stick(stick[0] / 2, stick[1] + turn)
            if not self._hits(seen, option):
                return option
        return stick * 0.3


class ExpertDriver(Driver):
    """Demonstrates: slows down where something is near the nose, moves the stick without jumps; joystick = desired."""

    name = "expert"

    default_config = ExpertConfig
    config: ExpertConfig

    def reset(self, seed: int) -> None:
        super().reset(seed)
        self._last: tuple[float, FloatArray] | None = None

    def _steer(self, stamp: float, seen: Pose2, noise: tuple[float, float], reversing: bool) -> DriverInput:
        if reversing:
            forward, left = -0.4, 0.0
        else:
            forward, left = self._pursuit(seen, self._magnitude(seen))
        stick = self._moved_smoothly(stamp, _stick(forward, left + noise[0]))
        return DriverInput(stick, stick.copy())

    def _moved_smoothly(self, stamp: float, wanted: FloatArray) -> FloatArray:
        before, last = self._last or (stamp - PERIOD, np.zeros(2))
        step = wanted - last
        most = self.config.stick_rate * (stamp - before)
        now = last + step * min(1.0, most / max(float(np.hypot(*step)), 1e-12))
        self._last = (stamp, now)
        return np.asarray(now)


class ImpairedDriver(Driver):
    """Points roughly: the stick snaps to five orientations and is held between decisions.

    joystick: an orientation of ORIENTATIONS times the magnitude. desired: the direction meant now, before snapping and
    holding; while the driver reverses or gives way it means the orientation that it gives.
    """

    name = "impaired"

    default_config = ImpairedConfig
    config: ImpairedConfig

    def reset(self, seed: int) -> None:
        super().reset(seed)
        self._noticing = np.random.default_rng([_NOTICING, _checked_seed(seed)])
        self._next_decision = -math.inf
        self._was_reversing = False
        self._given = 0.0
        self._giving_way = False

    def _draw(self) -> tuple[float, float]:
        return self._noise.next(), float(self._noticing.random())

    def _steer(self, stamp: float, seen: Pose2, noise: tuple[float, float], reversing: bool) -> DriverInput:
        speed, (bearing, distance) = self._magnitude(seen), self._target(seen)
        meant = float(wrap_angle(self._angle(bearing, distance) + noise[0]))
        if stamp >= self._next_decision - 1e-9 or reversing != self._was_reversing:
            self._next_decision = stamp + self.config.decision_time
            self._given, self._giving_way = self._decide(seen, speed, bearing, meant, noise[1], reversing)
        self._was_reversing = reversing
        return DriverInput(_pointing(self._given, speed), _pointing(self._given if self._giving_way else meant, speed))

    def _decide(
        self, seen: Pose2, speed: float, bearing: float, meant: float, attention: float, reversing: bool
    ) -> tuple[float, bool]:
        """The orientation [rad] to hold, and whether it gives way to an obstacle, i.e. is itself what is meant."""
        if reversing:
            return self._way_back(seen, speed, bearing), True
        given = self._snap(meant, abs(bearing) > self.config.facing_away)
        if attention < self.config.notice_probability and self._hits(seen, given, speed):
            return self._nearest_free(seen, meant, speed, given), True
        return given, False

    def _angle(self, bearing: float, distance: float) -> float:
        """The stick's angle that pure pursuit (E.1) asks for; a target behind: straight to it."""
        if abs(bearing) > math.pi / 2:
            return bearing
        curvature = 2 * math.sin(bearing) / max(distance, 0.3)
        return math.atan2(curvature * self._limits.max_linear, self._limits.max_angular)

    def _snap(self, angle: float, backwards: bool) -> float:
        allowed = ORIENTATIONS if backwards else ORIENTATIONS[:3]
        return min(allowed, key=lambda option: abs(float(wrap_angle(option - angle))))

    def _hits(self, seen: Pose2, orientation: float, speed: float) -> bool:
        twist = self._twist(_pointing(orientation, speed))
        return math.isfinite(self._sense.time_to_hit(seen, twist, self.config.notice_time))

    def _nearest_free(self, seen: Pose2, meant: float, speed: float, otherwise: float) -> float:
        nearest_first = sorted(ORIENTATIONS, key=lambda option: abs(float(wrap_angle(option - meant))))
        return next((option for option in nearest_first if not self._hits(seen, option, speed)), otherwise)

    def _way_back(self, seen: Pose2, speed: float, bearing: float) -> float:
        """The orientation to reverse with: the nose turns to the target, unless only the other way is free."""
        wanted = math.copysign(ORIENTATIONS[3], bearing)
        return -wanted if self._hits(seen, wanted, speed) and not self._hits(seen, -wanted, speed) else wanted


def _pointing(angle: float, magnitude: float) -> FloatArray:
    return np.array([magnitude * math.cos(angle), magnitude * math.sin(angle)])
