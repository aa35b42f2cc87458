"""Driving backwards with a scanner that sees all around."""

import math

import numpy as np
import pytest

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import RollingMap, local_grid
from lfdcore.simulated.courses import hall
from lfdcore.simulated.drivers import ORIENTATIONS, AbleDriver
from lfdcore.simulated.reversing_driver import ImpairedReversingDriver, ReversingConfig, ReversingDriver, facing_back
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulation import DrivingWorld, LidarConfig
from lfdcore.study.arms import StudyModels, make_assistant

ALL_AROUND = LidarConfig(beams=361, field_of_view=2 * math.pi)


@pytest.mark.parametrize("arm", ["none", "dwa_1s"])
def test_the_driver_goes_the_whole_way_backwards_without_contact(arm: str) -> None:
    run = RunConfig(lidar=ALL_AROUND)
    trace = run_drive(facing_back(hall()), ReversingDriver(hall()), make_assistant(arm, StudyModels(), run), 1, run)
    assert trace.completed and trace.collision.sum() == 0
    assert (trace.joystick[:-1, 0] < 0).all() and (trace.twist[1:, 0] < 0).mean() > 0.99
    behind = trace.pose[:, 2] + math.pi  # the back leads along the way
    step = np.diff(trace.pose[:, :2], axis=0)
    along = step[:, 0] * np.cos(behind[1:]) + step[:, 1] * np.sin(behind[1:])
    assert along.sum() == pytest.approx(hall().length, abs=1.0)


def test_he_gives_what_an_able_driver_of_a_chair_with_its_ends_swapped_gives_with_forward_negated() -> None:
    swapped = Footprint(front=Footprint().rear, rear=Footprint().front)
    forwards = AbleDriver(hall(), ReversingConfig(), MotionLimits(max_linear=0.4, max_reverse=1.0), swapped)
    backwards, start = ReversingDriver(hall()), facing_back(hall()).start
    for k in range(30):
        there = start * Pose2(-0.03 * k, 0.01 * k, 0.02 * k)
        seen = there * Pose2(0.0, 0.0, math.pi)
        given = backwards.act(0.1 * k, there, Twist2(-0.3, 0.2), k == 20).joystick
        meant = forwards.act(0.1 * k, seen, Twist2(0.3, 0.2), k == 20).joystick
        assert given.tolist() == pytest.approx((meant * [-1, 1]).tolist())


def test_an_impaired_one_points_to_five_orientations_over_the_shoulder() -> None:
    driver, start = ImpairedReversingDriver(hall()), facing_back(hall()).start
    for k in range(60):
        there = start * Pose2(-0.03 * k, 0.02 * k, 0.05 * k)
        given = driver.act(0.1 * k, there, Twist2(-0.3, 0.2), False).joystick
        over_the_shoulder = math.atan2(given[1], -given[0])
        assert min(abs(math.remainder(over_the_shoulder - option, 2 * math.pi)) for option in ORIENTATIONS) < 1e-9


def test_after_a_hit_he_drives_ahead_for_a_while_and_then_goes_on_backwards() -> None:
    driver, pose = ReversingDriver(hall()), facing_back(hall()).start
    forward = [float(driver.act(k * 0.1, pose, Twist2(), k == 10).joystick[0]) for k in range(40)]
    assert forward[8] < 0 and max(forward[14:21]) > 0 and min(forward[26:38]) < 0


def test_turning_left_backwards_asks_for_left() -> None:
    """The stick's left is the chair's rate of turn, whichever way it rolls."""
    driver = ReversingDriver(hall(), ReversingConfig(noise_sd=0.0))
    start = facing_back(hall()).start
    for side in (0.3, -0.3):
        driver.reset(0)
        aside = start * Pose2(0.0, 0.0, side)
        assert np.sign(driver.act(0.0, aside, Twist2(), False).joystick[1]) == -np.sign(side)


def test_a_speed_backwards_is_a_share_of_the_reverse_limit() -> None:
    limits = MotionLimits(max_reverse=0.2)
    given = ReversingDriver(hall(), ReversingConfig(noise_sd=0.0), limits).act(
        0.0, facing_back(hall()).start, Twist2(), False
    )
    assert given.joystick[0] == pytest.approx(-0.8, abs=0.05)


def test_facing_back_turns_the_start_only() -> None:
    course = facing_back(hall())
    assert course.route.tobytes() == hall().route.tobytes() and course.name == "hall-backwards"
    assert abs(math.cos(course.start.yaw - hall().start.yaw) + 1) < 1e-12


def scan_and_pose(lidar: LidarConfig):  # type: ignore[no-untyped-def]
    world = DrivingWorld(hall().grid, lidar=lidar, seed=1)
    pose = Pose2(4.0, 2.0, 0.0)
    world.reset(pose)
    return world.scan(), pose


def test_a_scanner_that_sees_all_around_fills_the_window_behind_the_chair_too() -> None:
    seen = {}
    for name, lidar in (("ahead", LidarConfig()), ("around", ALL_AROUND)):
        scan, pose = scan_and_pose(lidar)
        grid = local_grid(scan, lidar.T_base_laser)
        rolling = RollingMap()
        rolling.insert(0.0, scan, lidar.T_base_laser, pose)
        for made in (grid.data, rolling.local_grid(pose).data):
            seen.setdefault(name, []).append((made[:, :50] >= 0).mean())
    assert max(seen["ahead"]) == 0.0
    assert min(seen["around"]) > 0.6


def test_what_stands_behind_is_an_obstacle_where_it_stands() -> None:
    scan, pose = scan_and_pose(ALL_AROUND)
    rolling = RollingMap()
    rolling.insert(0.0, scan, ALL_AROUND.T_base_laser, pose)
    points = rolling.obstacles(pose).points
    wall = points[(np.abs(points[:, 1]) < 1.0) & (points[:, 0] < 0)]
    assert len(wall) > 10
    assert wall[:, 0].mean() == pytest.approx(0.10 - pose.x, abs=0.03)  # the left wall's face
