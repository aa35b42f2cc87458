"""Laws of the assistants, and what they do at the borders of their input. All in worlds of a few walls."""

import dataclasses
import math
import resource
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfdcore.control import Supervisor
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, approach, integrate
from lfdcore.grid import LaserScan
from lfdcore.planning import DppConfig
from lfdcore.simulation import joystick_to_twist
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DriveAssistantConfig,
    DynamicWindowAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.pending import PendingCommands
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.planner import PrimitivesPlanner, PrimitivesPlannerConfig
from lfdcore.wheelchair.surroundings import Surroundings
from observed import observed
from synthetic_drive import L_WALLS, T_BASE_LASER, cast

CHAIR = ChairGeometry.thesis()

LIMITS = MotionLimits()
STOP = (0.0, 0.0)
OFF_CENTRE = Pose2(0.013, 0.007, 0.0)
"""Not on a cell's border, where the last bit of a number decides."""
Stick = Callable[[int], tuple[float, float]]


def scan_of(ranges: np.ndarray) -> LaserScan:
    return LaserScan(ranges.astype(np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)


def seen_from(pose: Pose2, walls: np.ndarray) -> LaserScan:
    """An exact scan of 181 beams."""
    laser = pose * T_BASE_LASER
    ranges = cast(np.array([laser.x, laser.y]), laser.yaw + np.radians(np.arange(181) - 90.0), walls)
    return scan_of(np.where(ranges < 30, ranges, np.inf))


def observe(
    stick: tuple[float, float],
    *,
    stamp: float = 0.0,
    pose: Pose2 = OFF_CENTRE,
    twist: Twist2 | None = None,
    walls: np.ndarray = L_WALLS,
    scan: LaserScan | None = None,
    **said: Any,
) -> Observation:
    return observed(stamp, scan or seen_from(pose, walls), stick, pose=pose, twist=twist or Twist2(), **said)


def drive(
    assistant: Assistant,
    stick: Stick,
    ticks: int,
    walls: np.ndarray = L_WALLS,
    start: Pose2 = OFF_CENTRE,
    begin: float = 0.0,
) -> list[tuple[Observation, Assistance]]:
    """A chair without slip or noise that obeys its commands."""
    pose, twist, done = start, Twist2(), []
    for tick in range(ticks):
        observation = observe(stick(tick), stamp=begin + tick / 10, pose=pose, twist=twist, walls=walls)
        said = assistant.update(observation)
        done.append((observation, said))
        twist = approach(twist, said.command, LIMITS, 0.1)
        pose = integrate(pose, twist, 0.1)
    return done


def push(assistant: Assistant, way: list[Pose2], walls: np.ndarray, stamp: float = 0.0) -> float:
    """Pushes a chair whose stick rests along the way at .5 m/s, turning at 1 rad/s -> the stamp after the last tick."""
    for start, end in pairwise(way):
        dx, dy, turn = end.x - start.x, end.y - start.y, end.yaw - start.yaw
        n = max(1, math.ceil(max(math.hypot(dx, dy) / 0.05, abs(turn) / 0.1)))
        for k in range(n + 1):
            pose = Pose2(start.x + dx * k / n, start.y + dy * k / n, start.yaw + turn * k / n)
            twist = Twist2(10 * math.hypot(dx, dy) / n, 10 * turn / n)
            assistant.update(observe((0.0, 0.0), stamp=stamp, pose=pose, twist=twist, walls=walls))
            stamp += 0.1
    return stamp


def wandering(tick: int) -> tuple[float, float]:
    """Ahead with turns, a halt and some reversing."""
    if 60 <= tick % 200 < 70:
        return (0.0, 0.0)
    if 150 <= tick % 200 < 165:
        return (-0.5, 0.1)
    return (0.7, float(np.round(0.6 * np.sin(tick / 9), 1)))


@pytest.fixture(scope="module")
def model(home_model: Path) -> DriveAssistantModel:
    return DriveAssistantModel.load(home_model)


@pytest.fixture
def assistant(model: DriveAssistantModel) -> DriveAssistant:
    return DriveAssistant(model.planner(CHAIR))


def test_a_joystick_at_rest_stops_the_chair_whatever_it_did(assistant: DriveAssistant) -> None:
    seen = drive(assistant, lambda _: (0.8, 0.0), 20)[-1][0]
    said = assistant.update(observe((0.03, -0.03), stamp=2.0, pose=seen.pose, twist=Twist2(0.8, 0.2)))
    assert (tuple(said.command), said.mode, said.path) == (STOP, "rest", None)


def test_a_stale_scan_ends_the_path(assistant: DriveAssistant) -> None:
    seen = drive(assistant, lambda _: (0.8, 0.0), 20)[-1][0]
    stale = assistant.update(observe((0.8, 0.0), stamp=2.2, scan_stamp=1.9, pose=seen.pose, twist=Twist2(0.8, 0.0)))
    assert (tuple(stale.command), stale.mode, stale.path) == (STOP, "stale", None)
    assert assistant.update(observe((0.8, 0.0), stamp=2.3, pose=seen.pose)).mode == "path"


def test_an_old_scan_is_placed_where_it_was_taken_and_only_once() -> None:
    """The chair turns by 40 degrees after its scan: the post ahead is then to its right."""
    post, then, now = np.array([[[3.0, -0.1], [3.0, 0.1]]]), Pose2(), Pose2(0.0, 0.0, np.radians(40))
    scan = seen_from(then, post)
    surroundings = Surroundings(CHAIR, 10.0)
    surroundings.see(observe((0.5, 0.0), pose=then, scan=scan))
    for stamp in (0.2, 0.4):
        seen = observe((0.5, 0.0), stamp=stamp, pose=now, scan=scan, scan_stamp=0.0, scan_pose=then)
        points = surroundings.see(seen).points
        bearing = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
        assert np.abs(bearing + 40).max() < 4.5  # with what 5 % of the turn may be wrong
        laser = seen.scan_mounting(T_BASE_LASER)
        assert tuple(laser) == pytest.approx(tuple(now.inverse() * T_BASE_LASER))


def test_after_a_rest_the_path_goes_on_from_what_the_chair_does(assistant: DriveAssistant) -> None:
    """Not from the command before the rest: a chair that stands starts gently."""
    drive(assistant, lambda _: (0.8, 0.0), 20)
    for tick in range(20, 30):
        assistant.update(observe((0.0, 0.0), stamp=tick / 10))
    said = assistant.update(observe((0.8, 0.0), stamp=3.0))
    assert said.mode == "path" and said.command.linear < 0.2


@pytest.mark.parametrize("stick", [(-0.6, 0.0), (-0.5, 0.3), (-0.2, -0.6)])
def test_reversing_is_the_drivers_own_where_there_is_room(
    assistant: DriveAssistant, stick: tuple[float, float]
) -> None:
    drive(assistant, lambda _: (0.6, 0.0), 25)
    said = assistant.update(observe(stick, stamp=2.5, pose=Pose2(1.4, 0.0, 0.0)))
    assert said.mode == "reverse" and said.path is None and not said.supervised
    assert tuple(said.command) == tuple(joystick_to_twist(*stick, LIMITS))


@pytest.mark.parametrize("pause", [0.1, 60.0])
def test_reversing_into_a_remembered_wall_is_stopped_by_the_supervisor(assistant: DriveAssistant, pause: float) -> None:
    """Nothing behind the chair is seen now; the rolling map has it from before. Also when the driver has rested."""
    walls = np.concatenate([L_WALLS, [[[2.0, -1.0], [2.0, 0.2]]]])
    turned = Pose2(3.0, -0.3, np.pi)  # sees the wall at x = 2
    stamp = push(assistant, [turned, Pose2(3.0, -0.3, 0.0)], walls)
    stamp = push(assistant, [Pose2(3.0, -0.3, 0.0)] * round(1 + pause * 5), walls, stamp)
    pose, twist = Pose2(3.0, -0.3, 0.0), Twist2()
    for tick in range(60):
        said = assistant.update(observe((-0.6, 0.0), stamp=stamp + tick / 10, pose=pose, twist=twist, walls=walls))
        twist = approach(twist, said.command, LIMITS, 0.1)
        pose = integrate(pose, twist, 0.1)
    assert 2.0 < pose.x - Footprint().rear < 2.2
    assert abs(twist.linear) < 0.05


@pytest.mark.parametrize("size", [0.3, 0.6, 1.0])
def test_along_a_path_the_command_is_at_most_the_sticks_share_of_the_limits(
    assistant: DriveAssistant, size: float
) -> None:
    def stick(tick: int) -> tuple[float, float]:
        angle = 0.9 * np.sin(tick / 15)
        return (size * float(np.cos(angle)), size * float(np.sin(angle)))

    commands = [said.command for _, said in drive(assistant, stick, 150) if said.mode == "path"]
    assert len(commands) > 20  # it comes to a wall
    assert max(abs(c.linear) for c in commands) <= size * LIMITS.max_linear + 1e-9
    assert max(abs(c.angular) for c in commands) <= size * LIMITS.max_angular + 1e-9


def test_without_a_path_the_drivers_own_input_is_slowed(assistant: DriveAssistant) -> None:
    """A box all around leaves no room for any path of at least .35 m."""
    box = np.array([[[-0.5, -0.6], [1.1, -0.6]], [[1.1, -0.6], [1.1, 0.6]], [[1.1, 0.6], [-0.5, 0.6]]], float)
    stick = (0.1, 0.05)
    said = assistant.update(observe(stick, walls=box))
    own, share = joystick_to_twist(*stick, LIMITS), assistant.config.no_path_share
    assert said.mode == "no_path" and said.path is None and not said.planned
    assert tuple(said.command) == pytest.approx((own.linear * share, own.angular * share))


def test_some_missing_beams_change_little(model: DriveAssistantModel) -> None:
    whole = seen_from(OFF_CENTRE, L_WALLS)
    gappy = np.array(whole.ranges)
    gappy[20:25] = np.nan
    said = [
        DriveAssistant(model.planner(CHAIR)).update(observe((0.7, 0.0), scan=scan)) for scan in (whole, scan_of(gappy))
    ]
    assert said[0].mode == said[1].mode == "path"
    assert tuple(said[0].command) == pytest.approx(tuple(said[1].command), abs=0.05)


@pytest.mark.parametrize("name", ["none", "dwa", "primitives"])
def test_a_reset_makes_the_next_drive_as_the_first(model: DriveAssistantModel, name: str) -> None:
    made: dict[str, Assistant] = {"none": Unassisted(CHAIR), "dwa": DynamicWindowAssistant(CHAIR)}
    assistant = made.get(name) or DriveAssistant(model.planner(CHAIR))
    runs = []
    for _ in range(2):
        assistant.reset()
        runs.append([(*said.command, said.mode) for _, said in drive(assistant, wandering, 180)])
    assert runs[0] == runs[1]


@pytest.mark.parametrize("stick", [(0.7, 0.0), (0.6, 0.4), (0.5, -0.5), (0.2, 0.7)])
def test_a_mirrored_world_and_joystick_give_nearly_mirrored_commands(
    model: DriveAssistantModel, stick: tuple[float, float]
) -> None:
    """Nearly: base_link lies in the window's cell (50, 50), so cells are not mirrored onto cells."""
    mirrored = L_WALLS * [1, -1]
    for x in (0.0, 2.0, 4.0):
        pose, other = Pose2(x + 0.013, 0.107, 0.1), Pose2(x + 0.013, -0.107, -0.1)
        a = DriveAssistant(model.planner(CHAIR)).update(observe(stick, pose=pose))
        b = DriveAssistant(model.planner(CHAIR)).update(observe((stick[0], -stick[1]), pose=other, walls=mirrored))
        assert a.mode == b.mode
        assert a.command.linear == pytest.approx(b.command.linear, abs=0.05)
        assert a.command.angular == pytest.approx(-b.command.angular, abs=0.08)


@pytest.mark.parametrize("gap", [0.01, 0.03])
def test_a_chair_beside_a_wall_can_get_away_and_is_not_driven_into_it(assistant: DriveAssistant, gap: float) -> None:
    """The wall was seen on the way there."""
    y = 1.0 - Footprint().half_width - gap
    begin = push(assistant, [Pose2(-1.0, y, 0.0), Pose2(0.513, y, 0.0)], L_WALLS)
    done = drive(assistant, lambda _: (0.6, -0.3), 60, start=Pose2(0.513, y, 0.0), begin=begin)
    assert done[-1][0].pose.x > 1.0
    nearest = max(seen.pose.transform(corners())[:, 1].max() for seen, _ in done)
    assert nearest <= max(1.0, 1.0 - gap) + 0.002  # the supervisor's own tolerance


def corners() -> np.ndarray:
    body = Footprint()
    return np.array([[x, y] for x in (-body.rear, body.front) for y in (-body.half_width, body.half_width)])


def test_a_chair_facing_a_wall_at_the_nose_stops_and_may_reverse(assistant: DriveAssistant) -> None:
    wall = np.array([[[0.83, -3.0], [0.83, 3.0]]])
    ahead = drive(assistant, lambda _: (0.8, 0.0), 30, walls=wall, start=Pose2())
    assert max(pose.transform(corners())[:, 0].max() for pose in (seen.pose for seen, _ in ahead)) < 0.83
    pose = ahead[-1][0].pose
    said = assistant.update(observe((-0.5, 0.0), stamp=3.0, pose=pose, walls=wall))
    assert said.command.linear < -0.1


def test_when_the_stick_turns_the_path_is_replanned_in_the_same_tick(assistant: DriveAssistant) -> None:
    """In a crossing: straight on, then hard to the left. The path must be let go at once (Sec. 3.4.3)."""
    crossing = np.array([[[1.5, 1.0], [1.5, 5.0]], [[4.0, 1.0], [4.0, 5.0]], [[-2.0, 1.0], [1.5, 1.0]]], float)
    walls = np.concatenate([crossing, crossing * [1, -1], [[[4.0, 1.0], [9.0, 1.0]]], [[[4.0, -1.0], [9.0, -1.0]]]])
    turned_at = 13
    done = drive(assistant, lambda k: (0.8, 0.0) if k < turned_at else (0.3, 0.75), turned_at + 8, walls=walls)
    before, at = done[turned_at - 1][1], done[turned_at][1]
    assert before.mode == "path" and not before.planned
    assert at.planned or at.mode == "no_path"
    pose = done[turned_at][0].pose
    assert pose.inverse().transform(np.array([at.goal]))[0, 1] > 0.3
    assert done[-1][1].command.angular > 0.3


def test_a_steady_compliant_stick_keeps_its_path_for_a_while(assistant: DriveAssistant) -> None:
    done = drive(assistant, lambda _: (0.7, 0.0), 40)
    planned = [said.planned for _, said in done]
    assert planned[0] and sum(planned) <= 10


def test_memory_does_not_grow_over_two_thousand_updates(model: DriveAssistantModel) -> None:
    few_sweeps = PrimitivesPlannerConfig(dpp=DppConfig(sweeps=20))  # as much memory, less time
    assistant = DriveAssistant(PrimitivesPlanner(model, few_sweeps, CHAIR))
    lived = [seen for seen, _ in drive(assistant, wandering, 200)]
    assistant.reset()
    for lap in range(12):
        if lap == 2:
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for seen in lived:
            stamp = seen.stamp + 20 * lap
            assistant.update(dataclasses.replace(seen, stamp=stamp, scan_stamp=stamp))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # KiB on Linux
    assert grown < 2048


def test_nothing_a_driver_does_in_the_corridor_touches_it(assistant: DriveAssistant) -> None:
    """The law of the whole assistant, on exact scans: a random stick, no contact."""
    rng = np.random.default_rng(4)
    sticks = np.repeat(rng.uniform(-1, 1, (60, 2)), 10, axis=0)
    done = drive(assistant, lambda k: (float(sticks[k, 0]), float(sticks[k, 1])), 600)
    assert {said.mode for _, said in done} >= {"path", "reverse"}
    points = np.concatenate([np.linspace(a, b, 1000) for a, b in L_WALLS])
    body = Footprint()
    for seen, _ in done[::2]:
        x, y = seen.pose.inverse().transform(points).T
        assert not ((x > -body.rear) & (x < body.front) & (np.abs(y) < body.half_width)).any()


def test_every_command_has_passed_the_supervisor(model: DriveAssistantModel) -> None:
    """Asked again with the same obstacles, it changes nothing."""
    assistant, supervisor = DriveAssistant(model.planner(CHAIR)), Supervisor()
    surroundings, pending = Surroundings(CHAIR), PendingCommands(CHAIR.latency, CHAIR.period + CHAIR.jitter)
    for seen, said in drive(assistant, wandering, 150):
        obstacles, before = surroundings.see(seen), pending.at(seen.stamp)
        unseen = surroundings.unseen(seen)
        allowed = supervisor.filter(said.command, seen.twist, obstacles, pending=before, unseen=unseen)
        assert tuple(allowed.twist) == pytest.approx(tuple(said.command), abs=1e-9)
        pending.give(seen.stamp, said.command)


def test_the_printed_loop_drives(model: DriveAssistantModel) -> None:
    assistant = DriveAssistant(model.planner(CHAIR, thesis=True), DriveAssistantConfig.thesis())
    assert {said.mode for _, said in drive(assistant, lambda _: (0.7, 0.0), 10)} == {"path"}


FAR = np.array([[[-25.0, -25.0], [25.0, -25.0]], [[-25.0, 25.0], [25.0, 25.0]], [[25.0, -25.0], [25.0, 25.0]]])
"""Walls within the scanner's range, and nothing near"""
"""Two walls far away: (W, 2, 2) [m]"""


def test_a_driver_who_holds_a_turn_through_a_quarter_turn_gets_the_turn_himself(assistant: DriveAssistant) -> None:
    done = drive(assistant, lambda _: (0.25, 0.75), 150, walls=FAR)
    first = next(k for k, (_, said) in enumerate(done) if said.mode == "own_turn")
    assert done[first][0].pose.yaw == pytest.approx(np.pi / 2, abs=0.15)
    own = joystick_to_twist(0.25, 0.75, LIMITS)
    assert tuple(done[first][1].command) == pytest.approx(tuple(own), abs=1e-6)
    assert all(said.mode == "own_turn" for _, said in done[first:])


def test_the_turn_is_given_back_as_soon_as_the_stick_goes_elsewhere(assistant: DriveAssistant) -> None:
    done = drive(assistant, lambda tick: (0.25, 0.75) if tick < 120 else (0.8, 0.0), 125, walls=FAR)
    assert done[119][1].mode == "own_turn"
    assert done[120][1].mode != "own_turn"


def test_a_slow_driver_who_holds_a_turn_for_6_s_gets_it_himself(assistant: DriveAssistant) -> None:
    done = drive(assistant, lambda _: (0.1, 0.2), 80, walls=FAR)
    first = next(k for k, (_, said) in enumerate(done) if said.mode == "own_turn")
    assert first == 60
    assert done[first][0].pose.yaw < np.pi / 2


def test_a_stick_that_flickers_to_behind_on_the_same_side_keeps_its_turn(assistant: DriveAssistant) -> None:
    """A coarse stick held at 72 degrees comes out at 144 now and then: the driver still asks for the same turn."""
    done = drive(assistant, lambda tick: (-0.6, 0.4) if tick in (60, 90) else (0.25, 0.75), 130, walls=FAR)
    assert {done[tick][1].mode for tick in (60, 90)} == {"reverse"}
    assert done[-1][1].mode == "own_turn"


@pytest.mark.parametrize("between", [(0.0, 0.0), (-0.6, 0.0)], ids=["rest", "reverse"])
def test_a_turn_after_a_rest_or_reversing_is_a_new_one(assistant: DriveAssistant, between: tuple[float, float]) -> None:
    done = drive(assistant, lambda tick: between if 120 <= tick < 125 else (0.25, 0.75), 130, walls=FAR)
    assert done[119][1].mode == "own_turn"
    assert all(said.mode != "own_turn" for _, said in done[120:])


def test_a_path_that_leads_against_the_stick_is_not_followed(model: DriveAssistantModel) -> None:
    always = dataclasses.replace(DriveAssistantConfig(), refuse_below=1.1)
    modes = {
        said.mode for _, said in drive(DriveAssistant(model.planner(CHAIR), config=always), lambda _: (0.8, 0.0), 10)
    }
    assert modes == {"no_path"}
    assert drive(DriveAssistant(model.planner(CHAIR)), lambda _: (0.8, 0.0), 10)[-1][1].mode == "path"


def test_the_bare_supervisor_gives_the_joysticks_twist_where_there_is_room_and_stops_at_a_wall() -> None:
    free = drive(Supervised(CHAIR), lambda _: (0.8, 0.1), 5, walls=FAR)[-1][1]
    assert tuple(free.command) == pytest.approx(tuple(joystick_to_twist(0.8, 0.1, LIMITS)))
    assert not free.supervised
    wall = np.array([[[2.5, -3.0], [2.5, 3.0]]])
    last, said = drive(Supervised(CHAIR), lambda _: (1.0, 0.0), 80, walls=wall)[-1]
    assert said.supervised
    assert 2.5 - 0.8 - last.pose.x == pytest.approx(0.03, abs=0.03)


def test_in_the_open_dwa_drives_at_the_share_of_its_projection_in_its_horizon() -> None:
    """As docs/decisions.md says: the goal lies 1 s ahead, a twist is held for 2 s."""
    dwa = DynamicWindowAssistant(CHAIR)
    end = drive(dwa, lambda _: (1.0, 0.0), 60, walls=FAR)[-1][1]
    assert end.command.linear == pytest.approx(dwa.projection / dwa.config.horizon, abs=0.02)


@pytest.mark.parametrize("period", [0.05, 0.1, 0.2])
def test_dwa_asks_for_what_the_chair_reaches_until_the_next_command(period: float) -> None:
    dwa = DynamicWindowAssistant(dataclasses.replace(CHAIR, period=period))
    ahead = observed(0.0, seen_from(Pose2(), FAR), (1.0, 0.0))
    assert dwa.update(ahead).command.linear == pytest.approx(LIMITS.linear_acceleration * period)


@pytest.mark.hazard("The chair turns by itself", "it turns to the side of the stick")
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("name", ["supervisor", "dwa", "primitives"])
def test_a_stick_fully_to_one_side_turns_the_chair_to_that_side(
    model: DriveAssistantModel, name: str, side: float
) -> None:
    """DWA's turns on the spot all end alike, and the first sample won: -1 rad/s."""
    made = {"supervisor": Supervised, "dwa": DynamicWindowAssistant}.get(name)
    assistant = made(CHAIR) if made else DriveAssistant(model.planner(CHAIR))
    done = drive(assistant, lambda _: (0.0, side), 20, walls=FAR)
    assert all(said.command.angular * side > 0 for _, said in done[1:])
    assert all(abs(said.command.linear) < 0.1 for _, said in done)


@pytest.mark.hazard("The chair turns by itself", "zero asked is zero given")
@pytest.mark.parametrize("name", ["none", "supervisor", "dwa", "primitives"])
def test_zero_asked_is_zero_given(model: DriveAssistantModel, name: str) -> None:
    made = {"none": Unassisted, "supervisor": Supervised, "dwa": DynamicWindowAssistant}.get(name)
    assistant = made(CHAIR) if made else DriveAssistant(model.planner(CHAIR))
    assert {tuple(said.command) for _, said in drive(assistant, lambda _: (0.0, 0.0), 20)} == {STOP}
