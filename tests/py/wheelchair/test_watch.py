"""What cannot be trusted stops the chair, in every assistant, as a mode and never as an exception."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfdcore.geometry import MotionLimits, Pose2, Twist2, approach, integrate
from lfdcore.grid import LaserScan
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DynamicWindowAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant
from lfdcore.wheelchair.watch import HALTS, WatchConfig
from observed import observed
from synthetic_drive import T_BASE_LASER, cast

CHAIR = ChairGeometry.thesis()
LIMITS, CONFIG = MotionLimits(), WatchConfig()
HALL = np.array([[[-15.0, -15.0], [15.0, -15.0]], [[15.0, -15.0], [15.0, 15.0]], [[-15.0, 15.0], [15.0, 15.0]]])
"""Walls far away on three sides"""
STOP = (0.0, 0.0)
AHEAD = (1.0, 0.0)
NAMES = ("none", "supervisor", "dwa", "primitives", "heatmaps", "two_way")
SEEING = NAMES[1:]


@pytest.fixture
def make(home_model: Path, heatmap_model: Path) -> Callable[[str], Assistant]:
    def made(name: str) -> Assistant:
        if name in ("primitives", "heatmaps"):
            return DriveAssistant(load_model(home_model if name == "primitives" else heatmap_model).planner(CHAIR))
        if name == "two_way":
            return TwoWayAssistant(load_model(heatmap_model), CHAIR)
        return {"none": Unassisted, "supervisor": Supervised, "dwa": DynamicWindowAssistant}[name](CHAIR)

    return made


def scan_at(pose: Pose2, walls: np.ndarray = HALL) -> LaserScan:
    laser = pose * T_BASE_LASER
    ranges = cast(np.array([laser.x, laser.y]), laser.yaw + np.radians(np.arange(181) - 90.0), walls)
    return LaserScan(np.where(ranges < 30, ranges, np.inf).astype(np.float32), -np.pi / 2, np.pi / 180, 0.05, 30.0)


class ObedientChair:
    """It does what it is told, within its limits, and says so truly, unless `says` changes it."""

    def __init__(self, assistant: Assistant, walls: np.ndarray = HALL, period: float = 0.1) -> None:
        self.assistant, self.walls, self.period = assistant, walls, period
        self.pose, self.twist, self.command = Pose2(), Twist2(), Twist2()
        self.stamp, self.way, self.limits = 0.0, 0.0, LIMITS

    def tick(self, stick: tuple[float, float] = AHEAD, **says: Any) -> Assistance:
        truth = {"pose": self.pose, "twist": self.twist, "command": self.command}
        self.told = {"pose": self.pose, "twist": self.twist}
        scan = says.pop("scan") if "scan" in says else scan_at(self.pose, self.walls)
        said = self.assistant.update(observed(self.stamp, scan, stick, **{**truth, **says}))
        self.command = said.command
        self.twist = approach(self.twist, said.command, self.limits, self.period)
        self.pose = integrate(self.pose, self.twist, self.period)
        self.said = self.stamp
        self.way += abs(self.twist.linear) * self.period
        self.stamp += self.period
        return said

    def drive(self, ticks: int, stick: tuple[float, float] = AHEAD, **says: Any) -> Assistance:
        for _ in range(ticks):
            said = self.tick(stick, **says)
        return said


@pytest.mark.hazard("The stick falls silent", "mode silent and a stop within 250 ms and a tick")
@pytest.mark.parametrize("name", NAMES)
def test_a_stick_that_falls_silent_stops_the_chair_within_the_stated_time(
    make: Callable[[str], Assistant], name: str
) -> None:
    """Its last value is handed on, as any latched subscriber does: that drove 40 m in 57 s."""
    chair = ObedientChair(make(name))
    chair.drive(20)
    assert chair.command.linear > 0.3
    last, before = chair.said, chair.way
    said = [chair.tick(joystick_stamp=last) for _ in range(20)]
    halted = [one.mode == "silent" and tuple(one.command) == STOP for one in said]
    first = halted.index(True)
    assert all(halted[first:])
    assert (first + 1) * 0.1 <= CONFIG.silent_after + 0.1 + 1e-9
    assert chair.way - before <= 1.0 * (CONFIG.silent_after + 0.1) + 1.0**2 / (2 * LIMITS.linear_braking) + 0.1
    assert chair.twist.linear == 0


@pytest.mark.hazard("The stick falls silent", "no stamp is silence, never now")
@pytest.mark.parametrize("name", NAMES)
def test_a_stick_that_never_spoke_is_silent_and_not_at_rest(make: Callable[[str], Assistant], name: str) -> None:
    said = ObedientChair(make(name)).tick(joystick_stamp=None)
    assert (said.mode, tuple(said.command)) == ("silent", STOP)


@pytest.mark.hazard("The stick falls silent", "ends only at neutral")
@pytest.mark.parametrize("name", NAMES)
def test_silence_ends_only_when_the_stick_is_back_at_neutral(make: Callable[[str], Assistant], name: str) -> None:
    chair = ObedientChair(make(name))
    chair.drive(10)
    chair.drive(5, joystick_stamp=chair.said)
    assert {chair.tick().mode for _ in range(10)} == {"silent"}
    assert chair.tick((0.0, 0.0)).mode != "silent"
    assert chair.drive(15).command.linear > 0.3


@pytest.mark.hazard(
    "A scan or odometry is old", "mode stale and a stop after 200 ms or 2.5 periods; the command is ramped up again"
)
@pytest.mark.parametrize("name", SEEING)
@pytest.mark.parametrize("stream", ["scan_stamp", "odometry_stamp"])
def test_what_is_stale_stops_the_chair_which_sets_off_gently_by_itself(
    make: Callable[[str], Assistant], name: str, stream: str
) -> None:
    chair = ObedientChair(make(name))
    chair.drive(20)
    usual = chair.command.linear
    last = chair.said
    says = {stream: last, **(chair.told if stream == "odometry_stamp" else {})}
    modes = [chair.tick(**says).mode for _ in range(8)]
    assert modes[-1] == "stale"
    assert modes.index("stale") * 0.1 <= CONFIG.stale_periods * 0.1 + 1e-9
    again = [chair.tick() for _ in range(12)]
    assert all(one.mode not in HALTS for one in again)
    speeds = [one.command.linear for one in again]
    assert all(speed <= (k + 1) * 0.1 + 1e-9 for k, speed in enumerate(speeds))
    assert max(speeds) == pytest.approx(usual, abs=0.3)


@pytest.mark.hazard("A scan or odometry is old", "no stamp is stale, never now")
@pytest.mark.parametrize("name", SEEING)
@pytest.mark.parametrize("stream", ["scan_stamp", "odometry_stamp"])
def test_what_was_never_said_is_stale(make: Callable[[str], Assistant], name: str, stream: str) -> None:
    assert ObedientChair(make(name)).tick(**{stream: None}).mode == "stale"


NOTHING_SEEN = {
    "no measurement": np.full(181, np.nan),
    "below the scanner's range": np.full(181, 0.01),
    "too near to tell": np.full(181, -np.inf),
    "zeros": np.zeros(181),
    "no beams": np.zeros(0),
}


@pytest.mark.hazard("The scanner sees nothing", "mode blind and a stop")
@pytest.mark.parametrize("name", SEEING)
@pytest.mark.parametrize("ranges", NOTHING_SEEN.values(), ids=NOTHING_SEEN.keys())
def test_a_blind_scanner_is_no_free_world(make: Callable[[str], Assistant], name: str, ranges: np.ndarray) -> None:
    chair = ObedientChair(make(name))
    blind = LaserScan(ranges.astype(np.float32), -np.pi / 2, np.pi / 180, 0.05, 30.0)
    said = chair.tick(scan=blind)
    assert (said.mode, tuple(said.command)) == ("blind", STOP)
    assert chair.drive(20).mode not in HALTS


@pytest.mark.hazard("The scanner sees nothing", "every sector of 30 degrees ahead is judged alone")
@pytest.mark.parametrize("name", SEEING)
def test_a_lens_covered_on_one_side_ahead_is_blind(make: Callable[[str], Assistant], name: str) -> None:
    ranges = np.full(181, 5.0, np.float32)
    ranges[30:60] = np.nan
    assert ObedientChair(make(name)).tick(scan=LaserScan(ranges, -np.pi / 2, np.pi / 180, 0.05, 30.0)).mode == "blind"


@pytest.mark.parametrize("name", SEEING)
def test_some_dropped_beams_and_a_coarse_scanner_are_not_blind(make: Callable[[str], Assistant], name: str) -> None:
    dropped = np.full(181, 5.0, np.float32)
    dropped[np.random.default_rng(1).random(181) < 0.1] = np.nan
    few = LaserScan(np.full(20, 5.0, np.float32), -np.pi / 2, np.pi / 19, 0.05, 30.0)
    for scan in (LaserScan(dropped, -np.pi / 2, np.pi / 180, 0.05, 30.0), few):
        assert ObedientChair(make(name)).tick(scan=scan).mode not in HALTS


@pytest.mark.hazard("The scanner sees nothing", "no hit for a second: at most .1 m/s")
@pytest.mark.parametrize("name", SEEING)
def test_where_no_beam_hits_anything_the_chair_creeps(make: Callable[[str], Assistant], name: str) -> None:
    """A dazzled or unplugged scanner says the same as a wide field."""
    chair = ObedientChair(make(name))
    nothing = LaserScan(np.full(181, np.inf, np.float32), -np.pi / 2, np.pi / 180, 0.05, 30.0)
    assert chair.drive(10, scan=nothing).command.linear <= CONFIG.creep_linear
    assert chair.drive(5, scan=nothing).command.linear > 0 or name in ("heatmaps", "two_way")
    assert chair.drive(10).command.linear > 0.3
    chair.drive(12, scan=nothing)
    assert chair.tick(scan=nothing).command.linear <= CONFIG.creep_linear


def broken() -> Iterator[tuple[str, dict[str, Any]]]:
    nan = math.nan
    yield "pose", {"pose": Pose2(nan, 0.0, 0.0)}
    yield "yaw", {"pose": Pose2(0.0, 0.0, math.inf)}
    yield "twist", {"twist": Twist2(0.0, nan)}
    yield "stick", {"joystick": (nan, 0.0)}
    yield "stick beyond its stops", {"joystick": (1.5, 0.0)}
    yield "now", {"stamp": nan}
    yield "scan stamp", {"scan_stamp": nan}
    yield "odometry stamp", {"odometry_stamp": math.inf}
    yield "scan pose", {"scan_pose": Pose2(nan, 0.0, 0.0)}
    yield "clock set back by 1 ns", {"stamp": 1.9 - 1e-9}
    yield "scan stamp goes back", {"scan_stamp": 1.8}
    yield "odometry jumps", {"pose": Pose2(25.0, 0.0, 0.0)}
    yield "odometry turns at once", {"pose": Pose2(1.0, 0.0, 3.0)}


@pytest.mark.hazard(
    "Data that cannot be: NaN, a clock set back, a jump", "mode fault and a stop, no exception; ends only at neutral"
)
@pytest.mark.parametrize("name", SEEING)
@pytest.mark.parametrize("what", dict(broken()))
def test_what_cannot_be_is_a_fault_that_the_stick_at_neutral_ends(
    make: Callable[[str], Assistant], name: str, what: str
) -> None:
    chair = ObedientChair(make(name))
    chair.drive(20)
    seen = observed(chair.stamp, scan_at(chair.pose), AHEAD, pose=chair.pose, twist=chair.twist)
    said = chair.assistant.update(dataclasses.replace(seen, **dict(broken())[what]))
    assert (said.mode, tuple(said.command)) == ("fault", STOP)
    chair.stamp += 0.1
    chair.twist = Twist2()
    assert {chair.tick().mode for _ in range(3)} == {"fault"}
    chair.drive(2, (0.0, 0.0))
    assert chair.drive(12).mode not in HALTS


@pytest.mark.hazard("Data that cannot be: NaN, a clock set back, a jump", "the map forgets what the jump made false")
def test_after_a_jump_the_map_holds_nothing_of_before() -> None:
    class Curious(Supervised):
        points = -1

        def _decide(self, observation: Observation, obstacles: Any) -> Assistance:
            self.points = len(obstacles.points)
            return super()._decide(observation, obstacles)

    wall = np.array([[[2.0, -3.0], [2.0, 3.0]]])
    assistant = Curious(CHAIR)
    chair = ObedientChair(assistant, wall)
    chair.drive(3, (0.0, 0.0))
    assert assistant.points > 20
    chair.tick(AHEAD, pose=Pose2(5.0, 0.0, 0.0))
    nothing_near = scan_at(Pose2(), np.array([[[14.0, -9.0], [14.0, 9.0]]]))
    chair.drive(3, (0.0, 0.0), scan=nothing_near)
    assert assistant.points == 0


@pytest.mark.hazard("Odometry is frozen", "no contact with a wall that the scan shows")
@pytest.mark.parametrize("name", ["supervisor", "primitives", "heatmaps"])
@pytest.mark.parametrize("distance", [1.0, 1.3, 1.8, 4.0])
def test_frozen_odometry_is_noticed_before_the_wall_that_the_scan_shows(
    make: Callable[[str], Assistant], name: str, distance: float
) -> None:
    """Pose and twist frozen at 0: the chair touched at 1.00 m/s."""
    wall = np.array([[[distance, -3.0], [distance, 3.0]]])
    chair = ObedientChair(make(name), wall)
    said = [chair.tick(pose=Pose2(), twist=Twist2()) for _ in range(100)]
    slow = max(one.command.linear for one in said[1:]) < 0.5
    assert any(one.mode == "fault" for one in said) or slow or distance < 2  # too near to get fast
    assert chair.pose.x + 0.8 < distance


@pytest.mark.parametrize("period", [0.05, 0.2, 0.8])
@pytest.mark.parametrize("distance", [1.3, 1.8, 4.0])
def test_frozen_odometry_is_noticed_at_other_periods_too(period: float, distance: float) -> None:
    chair = ObedientChair(Supervised(chair_of(period)), np.array([[[distance, -3.0], [distance, 3.0]]]), period)
    said = [chair.tick(pose=Pose2(), twist=Twist2()) for _ in range(round(10 / period))]
    assert any(one.mode == "fault" for one in said) or distance < 2
    assert chair.pose.x + 0.8 < distance


def test_a_chair_a_fifth_slower_or_quicker_than_declared_is_no_fault() -> None:
    chair = ObedientChair(Supervised(CHAIR))
    for share in (0.8, 1.2):
        chair.limits = MotionLimits(
            linear_acceleration=share * LIMITS.linear_acceleration,
            linear_braking=share * LIMITS.linear_braking,
            angular_acceleration=share * LIMITS.angular_acceleration,
        )
        for tick in range(100):
            stick = (0.9, 0.4) if tick % 40 < 20 else (-0.5, -0.4)
            assert chair.tick(stick).mode not in HALTS


def only_at_the_chair(foot_alone: bool) -> LaserScan:
    """Every beam ends on what covers the scanner; or six on the driver's foot, and the others nowhere."""
    ranges = np.where(np.arange(181) >= 175, 0.27, np.inf) if foot_alone else np.full(181, 0.06)
    return LaserScan(ranges.astype(np.float32), -np.pi / 2, np.pi / 180, 0.05, 30.0)


@pytest.mark.hazard("The scanner sees nothing", "a covered one is blind, and the driver's own foot is nothing seen")
@pytest.mark.parametrize("name", SEEING)
def test_what_the_chair_itself_returns_is_nothing_seen(make: Callable[[str], Assistant], name: str) -> None:
    chair = ObedientChair(make(name))
    chair.drive(20)
    assert chair.drive(1, scan=only_at_the_chair(False)).mode == "blind"
    chair = ObedientChair(make(name))
    chair.drive(20, scan=only_at_the_chair(True))
    assert math.hypot(*chair.command) > 0
    assert chair.command.linear <= CONFIG.creep_linear + 1e-9


@pytest.mark.hazard("Data that cannot be: NaN, a clock set back, a jump", "fault, also at the first tick")
@pytest.mark.parametrize(
    "says",
    [
        {"twist": Twist2(50.0, 0.0)},
        {"twist": Twist2(0.0, 50.0)},
        {"pose": Pose2(2e7, 0.0, 0.0)},
        {"scan_pose": Pose2(3.0, 0.0, 1.0)},
        {"command": Twist2(math.nan, 0.0)},
    ],
)
@pytest.mark.parametrize("name", SEEING)
def test_what_no_chair_can_do_is_a_fault(make: Callable[[str], Assistant], name: str, says: dict[str, Any]) -> None:
    said = ObedientChair(make(name)).tick(**says)
    assert (said.mode, tuple(said.command)) == ("fault", STOP)


def test_another_pose_with_the_same_stamp_is_a_fault() -> None:
    chair = ObedientChair(Supervised(CHAIR))
    chair.drive(10)
    last = chair.said
    assert chair.tick(odometry_stamp=last, pose=Pose2(5.0, 0.0, 0.0)).mode == "fault"


@pytest.mark.hazard("A clock stands still", "mode stale and a stop")
def test_a_time_that_stands_still_tells_no_age() -> None:
    chair = ObedientChair(Supervised(CHAIR))
    chair.drive(10)
    seen = observed(chair.stamp, scan_at(chair.pose), AHEAD, pose=chair.pose, twist=chair.twist)
    chair.tick()
    for _ in range(3):
        assert chair.assistant.update(seen).mode == "stale"


def chair_of(period: float) -> ChairGeometry:
    return dataclasses.replace(CHAIR, period=period, scan_period=period)


@pytest.mark.hazard("The loop is late", "slower in proportion, from 3.5 periods on a stop; periods .05 to .2 s")
@pytest.mark.parametrize("period", [0.05, 0.1, 0.2])
def test_late_ticks_slow_the_chair_down_and_later_ones_stop_it(period: float) -> None:
    chair = ObedientChair(Supervised(chair_of(period)), period=period)
    chair.drive(round(3 / period))
    usual = chair.command.linear
    chair.period = 3 * period
    slowed = chair.drive(4)
    assert slowed.mode == "user"
    assert 0 < slowed.command.linear <= usual * 1.5 / 3 + 1e-9
    chair.period = 4 * period
    assert (chair.drive(2).mode, chair.command.linear) == ("late", 0.0)
    chair.period = period
    assert chair.drive(round(4 / period)).command.linear == pytest.approx(usual, abs=0.05)


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(WatchConfig)])
def test_a_watch_that_never_looks_is_refused_by_name(field: str) -> None:
    for value in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match=field):
            WatchConfig(**{field: value})
