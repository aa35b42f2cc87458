"""The closed loop touches nothing. Seeded, and so the same on every machine up to the last bits of exp and atan2."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from lfdcore.control import Supervisor, SupervisorResult
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, approach, integrate
from lfdcore.grid import ObstaclePoints, RollingMap
from lfdcore.simulated.courses import Course, flat, office
from lfdcore.simulated.drivers import ImpairedDriver, population
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig, joystick_to_twist
from lfdcore.study.arms import StudyModels, make_assistant

LIMITS = MotionLimits()


def drive_at_random(course: Course, seed: int, seconds: float, memory: float) -> tuple[int, float, float]:
    """A stick that jumps every second, mostly ahead, through the supervisor alone and the noisy LIDAR of 181 beams.

    -> contacts, distance [m], share of ticks on which it was stopped.
    """
    rng, supervisor, seen = np.random.default_rng(seed), Supervisor(), RollingMap(memory)
    world = DrivingWorld(course.grid, ChairConfig(), LidarConfig(), seed)
    world.reset(course.start)
    twist, stick, stopped = Twist2(), (0.0, 0.0), 0
    ticks = round(10 * seconds)
    for tick in range(ticks):
        if tick % 10 == 0:
            angle, size = rng.normal(0, 1.2), rng.uniform(0.4, 1)
            stick = (float(size * np.cos(angle)), float(size * np.sin(angle)))
        seen.insert(tick / 10, world.scan(), LidarConfig().T_base_laser, world.odometry)
        allowed = supervisor.filter(joystick_to_twist(*stick, LIMITS), twist, seen.obstacles(world.odometry))
        twist = world.step(allowed.twist, 0.1).odometry_twist
        stopped += allowed.stopped
    return world.state.collisions, world.state.distance, stopped / ticks


@pytest.mark.parametrize("make", [office, flat])
def test_a_random_stick_through_the_supervisor_touches_nothing_in_two_minutes(make) -> None:
    """With a memory that outlasts the drive: with 30 s, 5 of 40 such drives back into a door's edge that the chair has
    lingered beside for longer than that. The LIDAR does not look there."""
    for seed in range(4):
        contacts, distance, stopped = drive_at_random(make(), seed, 120, memory=300)
        assert contacts == 0, f"seed {seed}"
        assert distance > 3 and stopped < 0.5, f"seed {seed}: {distance} m, stopped {stopped}"


def beside_a_wall(gap: float, wanted: Twist2, ticks: int) -> Iterator[tuple[Pose2, SupervisorResult]]:
    """A chair along a wall on its left that it knows wholly."""
    wall = np.stack([np.linspace(-3, 12, 1501), np.full(1501, Footprint().half_width + gap)], axis=1)
    supervisor, pose, twist = Supervisor(), Pose2(), Twist2()
    for _ in range(ticks):
        allowed = supervisor.filter(wanted, twist, ObstaclePoints(pose.inverse().transform(wall)))
        yield pose, allowed
        twist = approach(twist, allowed.twist, LIMITS, 0.1)
        pose = integrate(pose, twist, 0.1)


@pytest.mark.parametrize("gap", [0.0, 0.005, 0.01, 0.02, 0.03, 0.05])
@pytest.mark.parametrize("angular", [-0.4, -0.17, 0.31])
def test_a_chair_beside_a_wall_is_not_frozen(gap: float, angular: float) -> None:
    """Too near for any turn (the rear corner swings out), it still may creep straight on; and gets no nearer."""
    for pose, _ in beside_a_wall(gap, Twist2(0.6, angular), 60):
        rear_left, front_left = pose.transform(np.array([[-0.35, 0.35], [0.80, 0.35]]))[:, 1]
        assert max(rear_left, front_left) <= 0.35 + max(gap - min(gap, 0.015), 0.0) + 0.002
    assert pose.x > 0.5 or pose.y < -0.5


@pytest.mark.parametrize("number", [0, 1])
def test_assisted_drivers_finish_the_flat_without_contact(number: int, home_model: Path) -> None:
    course, run = flat(), RunConfig()
    driver = ImpairedDriver(course, population(2, 1)[number])
    assistant = make_assistant("primitives", StudyModels(primitives=home_model), run)
    trace = run_drive(course, driver, assistant, 1 + number, run)
    assert trace.completed
    assert trace.collision.sum() == 0 and not trace.in_contact.any()


def test_the_same_drivers_unassisted_touch_something(home_model: Path) -> None:
    """Else the test above would say nothing."""
    course, run = flat(), RunConfig()
    for number, config in enumerate(population(2, 1)):
        trace = run_drive(
            course,
            ImpairedDriver(course, config),
            make_assistant("none", StudyModels(primitives=home_model), run),
            1 + number,
            run,
        )
        assert trace.collision.sum() > 0
