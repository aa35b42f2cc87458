"""A chair that stands where a free motion is asked for is counted, once each time, and no other chair is."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from lfdcore.geometry import Pose2, Twist2, integrate
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.chair import SimulatedChair, Truth
from lfdcore.simulated.courses import Course
from lfdcore.simulated.hostile_drivers import HeldStick
from lfdcore.simulated.people import PeopleConfig
from lfdcore.simulated.run import RunConfig
from lfdcore.simulation import DrivingWorld, joystick_to_twist
from lfdcore.study.safety.standing import LONGEST, Standing
from lfdcore.wheelchair.drive_loop import SimulatedClock, Tick, drive
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation

RUN = RunConfig()
START = Pose2(2.0, 2.0, 0.0)


def hall(wall_at: float = 11.5) -> Course:
    """12 x 4 m with walls all around, the chair 2 m from the one behind, looking at the one at x = `wall_at` [m]."""
    data = np.zeros((80, 240), np.int8)
    data[[0, -1]] = data[:, [0, -1]] = data[:, round(wall_at / 0.05) :] = 100
    route = np.array([[2.0, 2.0], [2.1, 2.0]])
    return Course("hall", OccupancyGrid(data, 0.05), START, route, False, "a hall", "test")


class Told:
    """Does what it is told for each moment: a mode and a command."""

    name = "told"

    def __init__(self, say: Callable[[float], tuple[str, Twist2]], chair: ChairGeometry) -> None:
        self.say, self.chair = say, chair

    def reset(self) -> None:
        """Nothing to forget."""

    def update(self, observation: Observation) -> Assistance:
        mode, command = self.say(observation.stamp)
        return Assistance(command, mode)


STOPPED = Twist2()


def stood(
    say: Callable[[float], tuple[str, Twist2]], stick: tuple[float, float], course: Course, seconds: float = 10.0
) -> int:
    chair = SimulatedChair(course, HeldStick(stick), 1, RUN.chair, RUN.lidar)
    standing = Standing(course.grid, RUN)

    def ended(tick: Tick) -> bool:
        standing.add(tick, chair.truth)
        return tick.stamp >= seconds - 1e-9

    drive(chair, Told(say, RUN.geometry), ended, clock=SimulatedClock())
    return standing.times


def test_a_chair_that_never_moves_is_counted_once() -> None:
    assert stood(lambda stamp: ("user", STOPPED), (1.0, 0.0), hall()) == 1


@pytest.mark.parametrize(("seconds", "times"), [(LONGEST, 0), (LONGEST + 0.1, 1)])
def test_standing_is_a_fault_from_two_seconds_on(seconds: float, times: int) -> None:
    assert stood(lambda stamp: ("user", STOPPED), (1.0, 0.0), hall(), seconds) == times


def test_each_time_counts_that_a_motion_ends() -> None:
    def starts_twice(stamp: float) -> tuple[str, Twist2]:
        return "user", Twist2(0.2, 0.0) if 3.0 < stamp < 3.5 or 8.0 < stamp < 8.5 else STOPPED

    assert stood(starts_twice, (1.0, 0.0), hall(), 14.0) == 3


def test_a_chair_that_its_watch_stops_is_no_fault() -> None:
    assert stood(lambda stamp: ("silent", STOPPED), (1.0, 0.0), hall()) == 0
    assert stood(lambda stamp: ("user" if stamp % 2 > 0.3 else "late", STOPPED), (1.0, 0.0), hall()) == 0


def test_a_stick_at_rest_asks_for_nothing() -> None:
    assert stood(lambda stamp: ("user", STOPPED), (0.03, -0.03), hall()) == 0


def test_what_moves_slowly_does_not_stand() -> None:
    assert stood(lambda stamp: ("user", Twist2(0.05, 0.0)), (1.0, 0.0), hall()) == 0
    assert stood(lambda stamp: ("user", Twist2(0.0, 0.05)), (1.0, 0.0), hall()) == 0


@pytest.mark.parametrize(
    ("forward", "times"),
    [(1.0, 0), (0.55, 0), (0.45, 1), (-0.5, 1)],
    ids=["into the wall", "too near to it", "short of it", "away"],
)
def test_only_a_motion_that_ends_clear_of_the_wall_is_asked_for(forward: float, times: int) -> None:
    """The nose is 1.10 m before the wall and the motion is 2 s long: it may be of .515 m/s with .07 m to spare."""
    assert stood(lambda stamp: ("user", STOPPED), (forward, 0.0), hall(wall_at=3.9)) == times


def test_free_is_what_touches_nothing_on_a_finer_way() -> None:
    """Against steps of 1 ms in cluttered maps. Between two poses the chair may come nearer by half of what it moves."""
    random = np.random.default_rng(3)
    data = np.where(random.random((160, 160)) < 0.002, 100, 0).astype(np.int8)
    grid = OccupancyGrid(data, 0.05)
    standing, world, free = Standing(grid, RUN), DrivingWorld(grid, RUN.chair), 0
    for _ in range(300):
        pose = Pose2(*random.uniform(2.5, 5.5, 2).tolist(), float(random.uniform(-math.pi, math.pi)))
        asked = joystick_to_twist(*random.uniform(-1, 1, 2).tolist(), RUN.chair.limits)
        way = [integrate(pose, asked, time) for time in np.linspace(0, LONGEST, 2001)]
        if standing.is_free(at_rest(pose), asked):
            free += 1
            assert not any(world.touches(at, standing.clearance - 0.045) for at in way)
        else:
            assert any(world.touches(at, standing.clearance) for at in way)
    assert 20 < free < 280


@dataclass
class AtRest:
    """A ChairState."""

    pose: Pose2
    twist: Twist2 = field(default_factory=Twist2)


def at_rest(pose: Pose2, *people: tuple[float, float]) -> Truth:
    where = np.array(people, float).reshape(-1, 2)
    return Truth(AtRest(pose), np.zeros(2), False, where)  # type: ignore[arg-type]


@pytest.mark.parametrize(("x", "free"), [(4.2, False), (5.0, False), (5.1, True), (1.0, True)])
def test_a_person_in_the_way_is_no_free_motion(x: float, free: bool) -> None:
    """The nose gets to x = 4.8 m; they have a radius of .2 m, and .07 m are left."""
    standing = Standing(hall().grid, RunConfig(people=PeopleConfig(radius=0.2)))
    assert standing.is_free(at_rest(START, (x, 2.0)), Twist2(1.0, 0.0)) is free
