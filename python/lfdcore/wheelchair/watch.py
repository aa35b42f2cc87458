"""What of an observation can be trusted: a stick that speaks, stamps that move, a scanner that sees, odometry that
agrees with the commands. What cannot be trusted is an outcome, a mode in which the chair stops, never an exception.

All ages are counted by the observation's `stamp`, which is the caller's clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import SupervisorConfig
from lfdcore.geometry import Pose2, Twist2, approach, wrap_angle
from lfdcore.grid import LaserScan, RollingMap, read_beams
from lfdcore.wheelchair.observation import ChairGeometry, Observation, usual_period
from lfdcore.wheelchair.stick import DEAD_ZONE

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog

SILENT, STALE, BLIND, LATE, FAULT = "silent", "stale", "blind", "late", "fault"
HALTS = (SILENT, STALE, BLIND, LATE, FAULT)
"""The modes in which every assistant stops"""
UNTIL_NEUTRAL = (SILENT, FAULT)
"""Of these, what only a stick at neutral ends"""
_SUPERVISOR = SupervisorConfig()
"""Whose creeping the watch shares"""
FARTHEST = 1e7
"""[m] (and [rad]) from where odometry began that a pose can be"""
TELLING = 0.5
"""[s] Poses that come less often are not judged by the twist: it may have changed between."""
FAR_AHEAD = 0.05
"""[s] A stamp later than now by more than this has no age."""


@dataclass(frozen=True, kw_only=True)
class WatchConfig:
    """From when on something counts as missing, and how the chair sets off again."""

    silent_after: float = 0.25
    """A stick that has said nothing for longer [s] is silent."""
    stale_after: float = 0.2
    """A scan or odometry older than this [s] is stale, but a scan not within `stale_periods` of its period."""
    stale_periods: float = 2.5
    late_periods: float = 3.5
    """Ticks farther apart than so many of the chair's periods stop it; those farther apart than a command holds (its
    period + jitter) slow it down, in proportion."""
    sector: float = math.radians(30)
    """A scan is judged by sectors of this width [rad] ..."""
    ahead: float = math.radians(60)
    """... up to this angle [rad] on both sides of straight ahead."""
    least_measured: float = 0.5
    """A sector of whose beams less than this share measured anything makes the scan blind; one without beams too."""
    seen_within: float = 1.0
    """Creep only, where no scan for so long [s] has hit anything: an unplugged scanner says the same."""
    creep_linear: float = _SUPERVISOR.creep_linear
    """Creeping: not faster than this [m/s] ..."""
    creep_angular: float = _SUPERVISOR.creep_angular
    """... and this [rad/s]."""
    ramp: float = 1.0
    """[s] from standstill to the full command, after a stop that ended by itself"""
    jump: float = 0.1
    """Odometry may be farther by this [m] than the chair can have come ..."""
    turn: float = 0.2
    """... and turned by this [rad] farther; else it jumped."""
    disagreement: float = 0.2
    """[m/s] (doubled: [rad/s]) by which odometry may differ from what the commands lead to, and this share of it ..."""
    disagreement_share: float = 0.3
    patience: float = 0.5
    """... for longer than this [s] and the latency."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0 < value < math.inf:
                raise ValueError(f"{name} is {value}, must be finite and > 0")
        if not self.sector <= 2 * self.ahead <= 2 * math.pi:
            raise ValueError(
                f"ahead is {self.ahead} rad, must lie between half a sector, {self.sector / 2} rad, and pi"
            )
        if self.least_measured > 1:
            raise ValueError(f"least_measured is {self.least_measured}, must be a share, at most 1")

    @staticmethod
    def of(log: DriveLog) -> WatchConfig:
        """For a replay: stick and odometry are missing after 2.5 of their own usual periods. Its ticks and scans come
        as its chair says (ChairGeometry.replayed)."""
        usual = WatchConfig()
        return WatchConfig(
            silent_after=max(usual.silent_after, usual.stale_periods * usual_period(log.joystick_stamp)),
            stale_after=max(usual.stale_after, usual.stale_periods * usual_period(log.odometry_stamp)),
        )


class Watch:
    """Judges one observation a tick for one assistant of one chair.

    `silent` and `fault` end only when a fresh stick is back at neutral; `stale`, `blind` and `late` end by themselves,
    and the command is ramped up.
    """

    def __init__(self, chair: ChairGeometry, config: WatchConfig | None = None) -> None:
        self.chair = chair
        self.config = config or WatchConfig()
        self._scanner = _Scanner(chair, self.config)
        self._odometry = _Odometry(chair, self.config)
        self.reset()

    def reset(self) -> None:
        """A new drive: forgets all stamps."""
        self._stamps: dict[str, float] = {}
        self._now = -math.inf
        self._interval = self.chair.period
        self._until_neutral: str | None = None
        self._set_off = -math.inf
        self._halted = False
        self._scanner.reset()
        self._odometry.reset()

    def judge(self, observation: Observation) -> str | None:
        """-> the mode in which the chair must stop, one of HALTS; None: go on. Takes in the observation."""
        mode = self._latched(self._fault(observation) or self._silence(observation), observation)
        mode = mode or self._time(observation) or self._staleness(observation) or self._scanner.blind(observation)
        if self._halted and mode is None:
            self._set_off = observation.stamp
        self._halted = mode is not None
        self._note_time(observation)
        return mode

    def judge_stick(self, observation: Observation) -> str | None:
        """The same for a chair that its stick alone drives: whether the stick can be trusted."""
        back, late = observation.stamp < self._now, self._time(observation)
        self._note_time(observation)
        mode = FAULT if back or not _stick_is_sound(observation) else self._silence(observation)
        return self._latched(mode, observation) or late

    def twist(self, observation: Observation) -> Twist2:
        """How fast the chair is [m/s, rad/s]: what odometry says, but while that contradicts the commands what these
        lead to, where it is more."""
        return self._odometry.doubted(observation.twist)

    def limited(self, wanted: Twist2, stamp: float) -> Twist2:
        """A command of this tick as far as the watch lets it: ramped up after a stop, slowed down while ticks come
        late, creeping while no scan hits anything."""
        config, chair = self.config, self.chair
        ramp = (stamp - self._set_off + chair.period) / config.ramp
        late = (chair.period + chair.jitter) / self._interval
        share = min(1.0, ramp, late)
        if stamp - self._scanner.last_hit > config.seen_within:
            fastest = max(abs(wanted.linear) / config.creep_linear, abs(wanted.angular) / config.creep_angular)
            share = min(share, 1 / max(fastest, 1.0))
        return Twist2(share * wanted.linear, share * wanted.angular)

    def _latched(self, mode: str | None, observation: Observation) -> str | None:
        """A mode that only a stick at neutral ends, kept until then."""
        if mode is not None or is_neutral(observation):
            self._until_neutral = mode
        return self._until_neutral

    def _fault(self, observation: Observation) -> str | None:
        if not _is_sound(observation, self.chair) or self._went_back(observation):
            return FAULT
        return FAULT if self._odometry.at_fault(observation) or self._scanned_elsewhere(observation) else None

    def _scanned_elsewhere(self, observation: Observation) -> bool:
        """Whether the scan says to be from where the chair cannot have been when it was taken."""
        if observation.scan_pose is None:
            return False
        apart = observation.pose.inverse() * observation.scan_pose
        age = min(_age(observation.stamp, observation.scan_stamp), self._oldest_scan())
        limits = self.chair.limits
        way = 1.5 * max(limits.max_linear, limits.max_reverse) * age + self.config.jump
        turn = 1.5 * limits.max_angular * age + self.config.turn
        return math.hypot(apart.x, apart.y) > way or abs(float(wrap_angle(apart.yaw))) > turn

    def _oldest_scan(self) -> float:
        return max(self.config.stale_after, self.config.stale_periods * self.chair.scan_period)

    def _went_back(self, observation: Observation) -> bool:
        """Whether a clock was set back. It counts from there on."""
        names = ("stamp", "scan_stamp", "odometry_stamp", "joystick_stamp")
        now = {name: stamp for name in names if (stamp := getattr(observation, name)) is not None}
        back = any(stamp < self._stamps.get(name, -math.inf) for name, stamp in now.items())
        self._stamps |= now
        return back

    def _silence(self, observation: Observation) -> str | None:
        return SILENT if _age(observation.stamp, observation.joystick_stamp) > self.config.silent_after else None

    def _time(self, observation: Observation) -> str | None:
        """Time that stands still tells no age."""
        passed = observation.stamp - self._now
        if passed == 0:
            return STALE
        return LATE if math.isfinite(passed) and passed > self.config.late_periods * self.chair.period else None

    def _staleness(self, observation: Observation) -> str | None:
        config = self.config
        stale = _age(observation.stamp, observation.scan_stamp) > self._oldest_scan()
        return STALE if stale or _age(observation.stamp, observation.odometry_stamp) > config.stale_after else None

    def _note_time(self, observation: Observation) -> None:
        """The longest interval counts, and is forgotten by and by."""
        passed = observation.stamp - self._now
        if math.isfinite(passed) and passed > 0:
            self._interval = max(passed, self.chair.period, self._interval * math.exp(-passed / self.config.ramp))
        if math.isfinite(observation.stamp):
            self._now = observation.stamp


class _Scanner:
    """Whether a scan says anything of what lies ahead."""

    def __init__(self, chair: ChairGeometry, config: WatchConfig) -> None:
        self._chair, self._config = chair, config
        self._layout: tuple[int, float, float] | None = None
        self._sector_of: NDArray[np.intp] = np.zeros(0, np.intp)
        self.reset()

    def reset(self) -> None:
        self.last_hit = -math.inf

    def blind(self, observation: Observation) -> str | None:
        try:
            lengths, hit = read_beams(observation.scan)
        except ValueError:
            return BLIND
        below = np.asarray(observation.scan.ranges) < max(observation.scan.range_min, 1e-9)
        measured = (lengths > 0) & ~below & ~(hit & self._ends_on_the_chair(observation.scan, lengths))
        if hit[measured].any() and observation.scan_stamp is not None:
            self.last_hit = max(self.last_hit, observation.scan_stamp)
        return BLIND if self._least_share(observation.scan, measured) < self._config.least_measured else None

    def _ends_on_the_chair(self, scan: LaserScan, lengths: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(B,) whether each beam's end lies so deep inside the outline that it is the driver's own foot, or what covers
        the scanner: as the map has it."""
        body, angles = self._chair.footprint.grown(-RollingMap.own_depth), scan.angles()
        x, y = self._chair.T_base_laser.transform(lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)).T
        return np.asarray((x <= body.front) & (x >= -body.rear) & (np.abs(y) <= body.half_width))

    def _least_share(self, scan: LaserScan, measured: NDArray[np.bool_]) -> float:
        """Of the beams that measured anything, in the sector with the fewest."""
        sectors = self._sectors(scan, len(measured))
        count = math.ceil(2 * self._config.ahead / self._config.sector - 1e-9)
        inside = sectors >= 0
        there = np.bincount(sectors[inside], minlength=count)
        fine = np.bincount(sectors[inside & measured], minlength=count)
        return float((fine / np.maximum(there, 1)).min())

    def _sectors(self, scan: LaserScan, beams: int) -> NDArray[np.intp]:
        """(B,) the sector of each beam, -1 for those that look elsewhere."""
        layout = (beams, scan.angle_min, scan.angle_increment)
        if layout != self._layout:
            config = self._config
            angle = wrap_angle(scan.angles() + self._chair.T_base_laser.yaw)
            sector = np.floor((angle + config.ahead) / config.sector).astype(np.intp)
            self._sector_of = np.where(np.abs(angle) < config.ahead, sector, -1)
            self._layout = layout
        return self._sector_of


class _Odometry:
    """Whether odometry moves as a chair does, and as it was commanded to."""

    def __init__(self, chair: ChairGeometry, config: WatchConfig) -> None:
        self._chair, self._config = chair, config
        self.reset()

    def reset(self) -> None:
        self._stamp: float | None = None
        self._pose, self._twist = Pose2(), Twist2()
        self._expected: Twist2 | None = None
        self._contradicted = 0.0
        self._way = 0.0

    def at_fault(self, observation: Observation) -> bool:
        stamp, before, pose = observation.odometry_stamp, self._stamp, self._pose
        if stamp is None:
            return False
        if stamp == before:
            return (observation.pose, observation.twist) != (pose, self._twist) and self._forget()
        self._stamp, self._pose, self._twist = stamp, observation.pose, observation.twist
        if before is None:
            return False
        passed = stamp - before
        if self._jumped(pose, observation, passed):
            return self._forget()
        longest = max(self._config.stale_after, self._chair.period + self._chair.jitter)
        if passed > longest:  # who knows what was meanwhile
            self._forget()
            return False
        return self._contradicts(pose, observation, passed) and self._forget()

    def doubted(self, twist: Twist2) -> Twist2:
        """While its word is doubted, the faster of odometry's and what the commands lead to."""
        expected = self._expected
        if self._contradicted == 0 or expected is None:
            return twist
        return Twist2(max(twist.linear, expected.linear, key=abs), max(twist.angular, expected.angular, key=abs))

    def _forget(self) -> bool:
        self._expected, self._contradicted, self._way = None, 0.0, 0.0
        return True

    def _jumped(self, before: Pose2, observation: Observation, passed: float) -> bool:
        limits, config, now = self._chair.limits, self._config, observation.pose
        fastest = 1.5 * max(limits.max_linear, limits.max_reverse, abs(observation.twist.linear))
        turning = 1.5 * max(limits.max_angular, abs(observation.twist.angular))
        moved, turned = math.hypot(now.x - before.x, now.y - before.y), abs(float(wrap_angle(now.yaw - before.yaw)))
        return moved > fastest * passed + config.jump or turned > turning * passed + config.turn

    def _contradicts(self, before: Pose2, observation: Observation, passed: float) -> bool:
        """Its pose against its twist, and its twist against what the commands lead to."""
        config, now, twist = self._config, observation.pose, observation.twist
        kept = math.exp(-passed / config.ramp)
        moved = math.hypot(now.x - before.x, now.y - before.y)
        self._way = kept * self._way + abs(twist.linear) * passed - moved if passed <= TELLING else 0.0
        if abs(self._way) > config.disagreement * config.ramp + config.jump:
            return True
        expected = self._expect(observation, passed)
        if expected is None:
            return False
        linear = abs(expected.linear - twist.linear) - config.disagreement_share * abs(expected.linear)
        angular = abs(expected.angular - twist.angular) - config.disagreement_share * abs(expected.angular)
        apart = linear > config.disagreement or angular > 2 * config.disagreement
        self._contradicted = self._contradicted + passed if apart else 0.0
        return self._contradicted > config.patience + self._chair.latency

    def _expect(self, observation: Observation, passed: float) -> Twist2 | None:
        """The twist that the commands lead to; it follows odometry by and by, since no chair is just as declared."""
        if observation.command is None:
            self._expected = None
            return None
        if self._expected is None:
            self._expected = observation.twist
        share = 1 - math.exp(-passed / self._config.ramp)
        expected, seen = self._expected, observation.twist
        near = Twist2(
            expected.linear + share * (seen.linear - expected.linear),
            expected.angular + share * (seen.angular - expected.angular),
        )
        self._expected = approach(near, observation.command, self._chair.limits, passed)
        return self._expected


def _age(now: float, stamp: float | None) -> float:
    """[s]; infinite for what was never said, and for a stamp that lies ahead of now."""
    if stamp is None or not stamp <= now + FAR_AHEAD:
        return math.inf
    return max(0.0, now - stamp)


def _is_sound(observation: Observation, chair: ChairGeometry) -> bool:
    """Whether all numbers but the ranges are finite, the stick within its end stops, and pose and twist such that
    they can be a chair's."""
    stamps = [observation.scan_stamp, observation.odometry_stamp, observation.joystick_stamp]
    said = [stamp for stamp in stamps if stamp is not None]
    scan_pose = observation.scan_pose or observation.pose
    said += observation.command or ()
    places, twist = (*observation.pose, *scan_pose), observation.twist
    fastest, turn = 10 * max(chair.limits.max_linear, chair.limits.max_reverse), 10 * chair.limits.max_angular
    can_be = all(abs(value) <= FARTHEST for value in places) and abs(twist.linear) <= fastest
    return can_be and abs(twist.angular) <= turn and all(map(math.isfinite, said)) and _stick_is_sound(observation)


def _stick_is_sound(observation: Observation) -> bool:
    return math.isfinite(observation.stamp) and all(abs(axis) <= 1 for axis in observation.joystick)


def is_neutral(observation: Observation) -> bool:
    """Whether the stick is let go, as far as is known."""
    return math.hypot(*observation.joystick) < DEAD_ZONE
