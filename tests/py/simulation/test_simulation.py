"""Laws and borders of the simulated chair."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, integrate
from lfdcore.grid import OccupancyGrid
from lfdcore.simulation import ChairConfig, ContactConfig, DrivingWorld, LidarConfig, joystick_to_twist

RESOLUTION = 0.05


def room(*blocks: tuple[float, float, float, float], width: float = 8, height: float = 5) -> OccupancyGrid:
    """Free floor within walls, lower left corner at (-1, 2) m; blocks are x0, y0, x1, y1 [m] from that corner."""
    data = np.zeros((round(height / RESOLUTION), round(width / RESOLUTION)), np.int8)
    data[[0, -1]] = data[:, [0, -1]] = 100
    for block in blocks:
        x0, y0, x1, y1 = (round(side / RESOLUTION) for side in block)
        data[y0:y1, x0:x1] = 100
    return OccupancyGrid(data, RESOLUTION, (-1.0, 2.0))


CLUTTER = room((3, 1, 3.4, 2.2), (5, 2.5, 5.05, 4.95), (5, 0, 5.05, 1.6), (1, 3.6, 2.1, 4.0), (6.5, 2.2, 7.2, 2.9))
START = Pose2(1.0, 4.2, 0.0)


def deepest_overlap(grid: OccupancyGrid, pose: Pose2, footprint: Footprint) -> float:
    """Separating axes over every occupied cell: the largest smallest overlap [m], negative if all are apart."""
    iy, ix = np.nonzero(grid.occupied_mask())
    centres = np.column_stack([ix + 0.5, iy + 0.5]) * grid.resolution + grid.origin
    corners = pose.transform(footprint.corners())
    overlap = np.full(len(centres), np.inf)
    for angle in (0.0, np.pi / 2, pose.yaw, pose.yaw + np.pi / 2):
        axis = np.array([np.cos(angle), np.sin(angle)])
        reach = np.abs(axis).sum() * grid.resolution / 2
        along, body = centres @ axis, corners @ axis
        overlap = np.minimum(overlap, np.minimum(body.max() - along + reach, along + reach - body.min()))
    return float(overlap.max())


def drive(world: DrivingWorld, linear: float, angular: float, steps: int) -> None:
    for _ in range(steps):
        world.step(Twist2(linear, angular))


commands = st.tuples(st.floats(-0.5, 1.2), st.floats(-1.2, 1.2), st.integers(1, 12))


@settings(max_examples=60, deadline=None)
@given(st.lists(commands, min_size=1, max_size=10))
def test_the_body_never_overlaps_an_obstacle_whatever_is_commanded(course):
    world = DrivingWorld(CLUTTER, seed=1)
    world.reset(START)
    for linear, angular, steps in course:
        for _ in range(steps):
            result = world.step(Twist2(linear, angular))
            assert deepest_overlap(CLUTTER, result.pose, world.chair.footprint) <= 1e-9


@settings(max_examples=60, deadline=None)
@given(st.lists(commands, min_size=3, max_size=10))
def test_some_command_frees_the_chair_wherever_random_commands_have_driven_it(course):
    world = DrivingWorld(CLUTTER, seed=1)
    world.reset(START)
    for linear, angular, steps in course:
        drive(world, linear, angular, steps)
    stuck_at = world.state.pose
    for linear, angular in [(-0.4, 0), (-0.4, 0.6), (-0.4, -0.6), (0.4, 0.6), (0.4, -0.6), (0.4, 0), (0, 1), (0, -1)]:
        drive(world, linear, angular, 20)
        moved = np.hypot(world.state.pose.x - stuck_at.x, world.state.pose.y - stuck_at.y)
        if moved > 0.1:
            return
    pytest.fail(f"no command moved the chair from {stuck_at}")


@pytest.mark.parametrize("steer", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize(
    "start",
    [
        Pose2(0.3, 3.6, 0),  # head-on into a block
        Pose2(1.5, 4.6, 0),  # into the post of a door
        Pose2(2.9, 4.4, -0.4),  # into the door, badly aligned
        Pose2(4.6, 3.2, -0.6),  # along a wall into a corner
        Pose2(3.0, 5.5, 0.6),  # into a wall at a slant
        Pose2(0.0, 5.0, 0.3),  # along the edge of a table
    ],
)
def test_reversing_frees_the_chair_from_any_typical_contact(start, steer):
    world = DrivingWorld(CLUTTER, seed=1)
    world.reset(start)
    drive(world, 1.0, steer, 40)
    assert world.state.collisions >= 1
    held = world.state.pose
    drive(world, -0.4, 0, 30)
    assert np.hypot(world.state.pose.x - held.x, world.state.pose.y - held.y) > 0.25


def test_a_chair_that_lies_along_a_wall_can_turn_away_from_it_on_the_spot():
    world = DrivingWorld(room(), seed=1)
    world.reset(Pose2(0.5, 6.3, 0.3))
    drive(world, 0.8, 0.2, 50)
    assert world.state.in_contact
    assert abs(world.state.pose.yaw) < 0.1
    for _ in range(80):
        if world.step(Twist2(0, -1)).pose.yaw < -1:
            return
    pytest.fail(f"still at a heading of {world.state.pose.yaw} rad")


def test_a_contact_with_chattering_counts_once_and_a_second_approach_counts_again():
    world = DrivingWorld(room(), seed=1)
    world.reset(Pose2(4.5, 4.5, 0))
    started = [world.step(Twist2(0.6, 0)).collision_started for _ in range(40)]
    assert sum(started) == 1
    for _ in range(5):
        drive(world, -0.1, 0, 1)
        drive(world, 0.3, 0, 3)
    assert world.state.collisions == 1
    drive(world, -0.4, 0, 12)
    assert not world.state.in_contact
    drive(world, 0.6, 0, 30)
    assert world.state.collisions == 2


def test_the_last_collision_is_located_at_the_obstacle():
    world = DrivingWorld(room(), seed=1)
    world.reset(Pose2(4.5, 4.5, 0))
    assert np.isnan(world.state.contact_point).all()
    drive(world, 0.6, 0, 40)
    assert world.state.contact_point[0] == pytest.approx(6.975)
    assert abs(world.state.contact_point[1] - 4.5) <= 0.4


def test_scraping_along_a_wall_costs_speed_and_standing_against_one_costs_all():
    world = DrivingWorld(room(), seed=1)
    world.reset(Pose2(0.5, 6.2, 0.4))
    speeds = [world.step(Twist2(1.0, 0)).twist.linear for _ in range(25)]
    assert min(speeds[12:]) < 0.97
    world.reset(Pose2(5.0, 4.5, 0))
    drive(world, 1, 0, 30)
    assert abs(world.state.twist.linear) < 0.01
    assert world.step(Twist2(1, 0)).odometry_twist.linear < 0.01


def test_free_motion_without_slip_is_what_the_odometry_says():
    world = DrivingWorld(room(), seed=4)
    world.reset(Pose2(1.5, 4.0, 0.7))
    for k in range(60):
        result = world.step(Twist2(0.5, np.sin(k / 5) - 0.2))
    assert not result.in_contact
    np.testing.assert_allclose([*(Pose2(1.5, 4.0, 0.7) * result.odometry)], [*result.pose], atol=1e-12)
    assert result.odometry_twist == result.twist


def test_the_chair_reaches_a_commanded_twist_as_its_acceleration_allows():
    world = DrivingWorld(room(width=30), seed=4)
    world.reset(Pose2(1.5, 4.0, 0))
    assert world.step(Twist2(5.0, 0)).twist.linear == pytest.approx(0.08)
    drive(world, 5.0, 0, 20)
    assert world.state.twist.linear == world.chair.limits.max_linear
    assert world.state.distance == pytest.approx(world.state.pose.x - 1.5)
    assert world.state.stamp == pytest.approx(2.1)


def test_systematic_slip_scales_the_odometry_and_random_slip_averages_out():
    limits = MotionLimits(linear_acceleration=100)
    world = DrivingWorld(room(width=200), ChairConfig(limits=limits, linear_slip=0.05, angular_slip=-0.1), seed=2)
    world.reset(Pose2(1, 4.5, 0))
    drive(world, 0.5, 0, 100)
    assert world.odometry.x == pytest.approx(1.05 * (world.state.pose.x - 1))
    drive(world, 0, 0.5, 5)
    assert world.odometry.yaw == pytest.approx(0.9 * world.state.pose.yaw)
    noisy = DrivingWorld(room(width=200), ChairConfig(limits=limits, slip_sd=0.1), seed=2)
    noisy.reset(Pose2(1, 4.5, 0))
    measured = np.array([noisy.step(Twist2(0.5, 0)).odometry_twist.linear / 0.5 for _ in range(1000)])[1:]
    assert measured.mean() == pytest.approx(1, abs=4 * 0.1 / np.sqrt(999))
    assert measured.std() == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize("periods", [0, 1, 3])
def test_a_command_acts_after_the_stated_number_of_control_periods(periods):
    world = DrivingWorld(room(), ChairConfig(command_latency=0.1 * periods), seed=4)
    world.reset(START)
    speeds = [world.step(Twist2(0.5, 0)).twist.linear for _ in range(6)]
    assert speeds[:periods] == [0] * periods
    assert speeds[periods] > 0


def test_each_range_is_exact_without_noise_and_infinite_beyond_range_max():
    world = DrivingWorld(room(), lidar=LidarConfig(noise_sd=0, range_max=4), seed=4)
    world.reset(Pose2(0.3, 4.5, 0))
    scan = world.scan()
    laser_x, laser_y = 1.0, 4.5
    for angle, distance in zip(scan.angles(), scan.ranges, strict=True):
        ahead, aside = np.cos(angle), np.sin(angle)
        wall = 6.95 if ahead > 0 else -0.95
        far_x = (wall - laser_x) / ahead if abs(ahead) > 1e-12 else np.inf
        far_y = ((6.95 if aside > 0 else 2.05) - laser_y) / aside if abs(aside) > 1e-12 else np.inf
        expected = min(far_x, far_y)
        assert distance == (pytest.approx(expected, abs=1e-5) if expected < 4 else np.inf)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others():
    def run(seed: int) -> bytes:
        world = DrivingWorld(CLUTTER, ChairConfig(slip_sd=0.05), seed=seed)
        world.reset(START)
        out = []
        for k in range(30):
            result = world.step(Twist2(0.8, 0.3 * np.sin(k)))
            out.append(np.array([*result.pose, *result.odometry]).tobytes() + world.scan().ranges.tobytes())
        return b"".join(out)

    assert run(5) == run(5)
    assert run(5) != run(6)


def test_every_arm_of_a_study_meets_the_same_noise_whatever_it_drove_before():
    lidar = LidarConfig(noise_sd=0.02)

    def noise_after(route: list[tuple[float, float]], scans_between: bool) -> np.ndarray:
        noisy = DrivingWorld(CLUTTER, lidar=lidar, seed=9)
        plain = DrivingWorld(CLUTTER, lidar=LidarConfig(noise_sd=0), seed=9)
        for world in (noisy, plain):
            world.reset(START)
            for command in route:
                world.step(Twist2(*command))
                if scans_between:
                    world.scan()
        return noisy.scan().ranges - plain.scan().ranges

    straight = noise_after([(0.5, 0.0)] * 7, scans_between=True)
    curved = noise_after([(0.3, 0.9)] * 7, scans_between=False)
    np.testing.assert_allclose(straight, curved, atol=2e-6)
    assert straight.std() == pytest.approx(0.02, rel=0.3)


def test_slip_and_scan_noise_are_separate_streams():
    def scans(slip_sd: float) -> bytes:
        world = DrivingWorld(CLUTTER, ChairConfig(slip_sd=slip_sd), seed=9)
        world.reset(START)
        drive(world, 0.5, 0.1, 5)
        return world.scan().ranges.tobytes()

    assert scans(0.0) == scans(0.1)


def test_a_scan_asked_for_twice_in_a_period_is_the_same():
    world = DrivingWorld(CLUTTER, seed=3)
    world.reset(START)
    assert world.scan().ranges.tobytes() == world.scan().ranges.tobytes()


def test_a_reset_starts_everything_anew():
    world = DrivingWorld(room(), ChairConfig(slip_sd=0.1, command_latency=0.2), seed=3)
    world.reset(Pose2(5.0, 4.5, 0))
    first = [tuple(world.step(Twist2(1, 0.1)).odometry) for _ in range(30)]
    world.reset(Pose2(5.0, 4.5, 0))
    assert (world.state.collisions, world.state.stamp, world.state.distance) == (0, 0, 0)
    assert [tuple(world.step(Twist2(1, 0.1)).odometry) for _ in range(30)] == first


def test_unknown_cells_stop_the_chair_and_the_beams_alike():
    data = np.zeros((100, 160), np.int8)
    data[:, 100:] = -1
    grid = OccupancyGrid(data, RESOLUTION)
    for solid, last in [(True, 5.0), (False, 9.0)]:
        world = DrivingWorld(grid, lidar=LidarConfig(noise_sd=0), seed=0, unknown_is_solid=solid)
        world.reset(Pose2(2.5, 2.5, 0))
        assert world.scan().ranges[90] == (pytest.approx(5.0 - 3.2) if solid else np.inf)
        drive(world, 1.0, 0, 80)
        assert (world.state.pose.x + 0.8 <= last) == solid
        assert world.state.collisions == int(solid)


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (Pose2(6.5, 4.5, 0), r"start pose \(6.5 m, 4.5 m, 0 rad\) touches an obstacle at \(6.975, "),
        (Pose2(40, 4.5, 0), "lies outside the map"),
        (Pose2(float("nan"), 4.5, 0), "pose.x is nan m"),
        (Pose2(1e300, 4.5, 0), "pose.x is 1e[+]300 m"),
        (Pose2(1, 4.5, float("inf")), "pose.yaw is inf rad"),
    ],
)
def test_a_bad_start_is_refused_with_its_place(pose, message):
    with pytest.raises(ValueError, match=message):
        DrivingWorld(room()).reset(pose)


@pytest.mark.parametrize(
    ("command", "duration", "message"),
    [
        (Twist2(float("nan"), 0), 0.1, "command.linear is nan m/s"),
        (Twist2(0, float("inf")), 0.1, "command.angular is inf rad/s"),
        (Twist2(), 0.0, "duration is 0 s"),
        (Twist2(), float("nan"), "duration is nan s"),
        (Twist2(), 1e9, "duration is 1e[+]09 s, must be between 0 and 10"),
    ],
)
def test_a_bad_step_is_refused(command, duration, message):
    world = DrivingWorld(room())
    world.reset(START)
    with pytest.raises(ValueError, match=message):
        world.step(command, duration)


def test_a_world_without_a_start_says_so():
    with pytest.raises(ValueError, match="call reset"):
        DrivingWorld(room()).step(Twist2())
    with pytest.raises(ValueError, match="call reset"):
        DrivingWorld(room()).scan()


@pytest.mark.parametrize(
    "make",
    [
        lambda: ChairConfig(sub_step=0),
        lambda: ChairConfig(slip_sd=float("nan")),
        lambda: ChairConfig(footprint=Footprint(0.8, -0.1, 0.35)),
        lambda: ChairConfig(limits=MotionLimits(max_linear=1e9)),
        lambda: ChairConfig(command_latency=-0.1),
        lambda: ContactConfig(friction=-1),
        lambda: LidarConfig(beams=0),
        lambda: LidarConfig(field_of_view=7),
        lambda: LidarConfig(range_max=float("inf")),
        lambda: LidarConfig(T_base_laser=Pose2(float("nan"), 0, 0)),
    ],
)
def test_a_config_out_of_range_is_refused_with_the_fields_name(make):
    with pytest.raises(ValueError, match=r"\w+ is .*must be"):
        make()


@given(st.floats(-1, 1), st.floats(-1, 1))
def test_a_joystick_scales_the_limits(forward, left):
    twist = joystick_to_twist(forward, left, MotionLimits(max_linear=0.9, max_reverse=0.3, max_angular=1.1))
    assert twist.linear == pytest.approx(forward * (0.3 if forward < 0 else 0.9))
    assert twist.angular == pytest.approx(left * 1.1)


@pytest.mark.parametrize(("forward", "left"), [(1.01, 0), (0, -1.01), (float("nan"), 0), (0, float("nan"))])
def test_a_joystick_out_of_range_is_refused(forward, left):
    with pytest.raises(ValueError, match="of full stick, must be between -1 and 1"):
        joystick_to_twist(forward, left, MotionLimits())


def test_configs_survive_a_pickle():
    chair = ChairConfig(slip_sd=0.02, contact=ContactConfig(friction=0.4), limits=MotionLimits(max_linear=0.9))
    lidar = LidarConfig(beams=11, T_base_laser=Pose2(0.1, 0.2, 0.3))
    chair_again, lidar_again = pickle.loads(pickle.dumps((chair, lidar)))
    assert (chair_again.slip_sd, chair_again.contact.friction, chair_again.limits.max_linear) == (0.02, 0.4, 0.9)
    assert (lidar_again.beams, lidar_again.T_base_laser) == (11, lidar.T_base_laser)


def test_a_margin_widens_the_footprint():
    world = DrivingWorld(room())
    assert not world.touches(Pose2(6.1, 4.5, 0))
    assert world.touches(Pose2(6.1, 4.5, 0), margin=0.06)


def test_free_motion_at_a_constant_twist_is_an_exact_arc():
    world = DrivingWorld(room(), ChairConfig(limits=MotionLimits(linear_acceleration=1e3, angular_acceleration=1e3)))
    world.reset(Pose2(1.5, 4.0, 0.7))
    result = world.step(Twist2(0.5, 0.6), 1.0)
    np.testing.assert_allclose([*result.pose], [*integrate(Pose2(1.5, 4.0, 0.7), Twist2(0.5, 0.6), 1.0)], atol=1e-12)
