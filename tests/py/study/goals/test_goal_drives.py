"""The drives of Ch. 2: the building and its ways, who drives, what the logs hold, what noise does."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from lfdcore.datasets import open_log, read_goals, write_goals, write_map
from lfdcore.geometry import Footprint, Pose2, wrap_angle
from lfdcore.pictures.goals import plot_goal_drives
from lfdcore.pictures.style import png
from lfdcore.simulated.courses import drive_ideally, goal_building, goals_in_map, route_clearance
from lfdcore.simulated.drivers import AbleDriver, able_population
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulation import ChairConfig
from lfdcore.study.goals.drives import RUNS_EACH, SEED, GoalDrives, noisy_joystick, perturbed_poses, record_goal_drives
from lfdcore.study.goals.tables import drives_table
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.observation import ChairGeometry

CHAIR = ChairGeometry.thesis()

sticks = arrays.arrays(float, st.tuples(st.integers(0, 20), st.just(2)), elements=st.floats(-1, 1))
poses = arrays.arrays(float, st.tuples(st.integers(1, 20), st.just(3)), elements=st.floats(-50, 50))


@pytest.fixture(scope="module")
def drives(goal_drives: GoalDrives) -> GoalDrives:
    return goal_drives


# -- the building ---------------------------------------------------------------------------------------------------


def test_the_building_has_the_size_and_the_number_of_destinations_of_fig_2_4() -> None:
    world = goal_building()
    assert (world.grid.width * world.grid.resolution, world.grid.height * world.grid.resolution) == (72.0, 72.0)
    assert world.goals.names == ("G1", "G2", "G3", "G4", "G5", "G6")
    world.goals.require_inside(world.grid)


@pytest.mark.parametrize("goal", goal_building().goals.names)
def test_an_ideal_chair_gets_to_every_destination_without_contact(goal: str) -> None:
    for seed in range(3):
        course = goal_building().course(goal, seed)
        drive = drive_ideally(course, margin=0.05)
        assert drive.completed and not drive.contacts.any()
        assert route_clearance(course.grid, course.route).min() >= Footprint().half_width + 0.05


def test_routes_share_their_beginning_and_end_at_their_own_destination() -> None:
    world = goal_building()
    routes = [world.course(goal, 1).route for goal in world.goals.names]
    for route, place in zip(routes, world.goals.positions, strict=True):
        assert np.hypot(*(route[-1] - place)) < 0.5
        apart = np.hypot(*(world.goals.positions - route[-1]).T)
        assert (np.sort(apart)[1:] > 2.5).all()
    far = {
        pair: np.hypot(*(routes[pair[0]][60] - routes[pair[1]][60])) for pair in itertools.combinations((0, 1, 3, 4), 2)
    }
    assert max(far.values()) < 2.0  # 6 m on, nothing tells G1, G2, G4 and G5 apart but the line one keeps
    assert np.hypot(*(routes[3][85] - routes[4][85])) < 1.0  # 8.5 m on, G4 and G5 are still on one way


def test_the_same_seed_gives_the_same_course_and_another_another() -> None:
    world = goal_building()
    one, again, other = world.course("G4", 7), world.course("G4", 7), world.course("G4", 8)
    assert [*one.start] == [*again.start] and one.route.tobytes() == again.route.tobytes()
    assert [*one.start] != [*other.start]


def test_an_unknown_destination_and_a_negative_seed_are_refused() -> None:
    with pytest.raises(ValueError, match="goal is 'G7', must be one of G1, G2"):
        goal_building().course("G7", 0)
    with pytest.raises(ValueError, match="seed must be >= 0, got -1"):
        goal_building().course("G1", -1)


# -- the drives -----------------------------------------------------------------------------------------------------


def test_all_drives_arrive_without_contact_and_are_as_many_samples_as_the_thesis_has(drives: GoalDrives) -> None:
    assert (len(drives.paths), drives.unfinished, drives.collisions) == (36, 0, 0)
    train, test = drives.samples(drives.training), drives.samples(drives.held_out)
    assert train == pytest.approx(9513, rel=0.05)  # Sec. 2.3.2
    assert test == pytest.approx(1795, rel=0.1)  # Fig. 2.8


def test_the_drives_table_has_a_row_a_destination_and_the_numbers_of_samples(drives: GoalDrives) -> None:
    table = drives_table(drives)
    assert [row[0] for row in table.rows] == list(drives.world.goals.names)
    assert {(row[1], row[6], row[7]) for row in table.rows} == {("6", "6", "0")}
    times = [len(drives.traces[k].stamp) * drives.traces[k].period for k in range(12, 18)]  # to G3
    assert table.rows[2][2:5] == (f"{np.mean(times):.1f}", f"{min(times):.1f}", f"{max(times):.1f}")
    train, test = drives.samples(drives.training), drives.samples(drives.held_out)
    assert f"{train} to learn from (30 drives), {test} held out" in table.note


def test_durations_are_those_of_table_2_1(drives: GoalDrives) -> None:
    for goal, seconds in (("G1", 52), ("G2", 33), ("G3", 16), ("G4", 52)):
        times = [t.stamp[-1] for t, name in zip(drives.traces, drives.destinations, strict=True) if name == goal]
        assert np.mean(times) == pytest.approx(seconds, rel=0.12)


def test_one_drive_to_each_destination_is_held_out_and_each_is_another_drivers(drives: GoalDrives) -> None:
    held_out = [drives.destinations[k] for k in drives.held_out]
    assert held_out == list(drives.world.goals.names)
    assert not set(drives.held_out) & set(drives.training)
    assert len(drives.training) == 30
    for goals in zip(*[iter(drives.traces)] * RUNS_EACH, strict=True):
        assert len({t.joystick[:, 0].max() for t in goals}) == RUNS_EACH  # six drivers push the stick differently far


def test_a_log_holds_the_destination_and_the_true_pose_in_the_map(drives: GoalDrives) -> None:
    for k in (0, 17, 35):
        log, trace = open_log(drives.paths[k]), drives.traces[k]
        assert log.metadata["destination"] == drives.destinations[k]
        off = log.map_pose_at(trace.stamp) - trace.pose
        assert np.abs(off[:, :2]).max() < 1e-9
        assert np.abs(wrap_angle(off[:, 2])).max() < 1e-9
        np.testing.assert_allclose(log.joystick_at(trace.stamp), trace.joystick, atol=1e-7)


def test_the_pose_in_the_map_stays_true_when_the_odometry_slips(tmp_path: Path) -> None:
    course = goal_building().course("G3", 0)
    config = RunConfig(chair=ChairConfig(linear_slip=0.1, angular_slip=0.1))
    trace = run_drive(course, AbleDriver(course), Unassisted(config.geometry), 0, config, tmp_path / "slip.mcap", "G3")
    log = open_log(tmp_path / "slip.mcap")
    assert (
        np.hypot(*(course.start * Pose2(*log.pose[-1])).transform(np.zeros((1, 2)))[0] - trace.pose[-1, :2]).max() > 0.2
    )
    np.testing.assert_allclose(log.map_pose_at(trace.stamp)[:, :2], trace.pose[:, :2], atol=1e-9)


def test_a_drive_can_be_made_again_from_its_seed_alone(drives: GoalDrives, tmp_path: Path) -> None:
    k = 6 * 2 + 1  # the second drive to G3: by driver (1 + 2) mod 6
    course = goal_building().course("G3", 1000 * SEED + k)
    driver = AbleDriver(course, able_population(RUNS_EACH, SEED)[3])
    again = run_drive(course, driver, Unassisted(CHAIR), 1000 * SEED + k)
    assert again.pose.tobytes() == drives.traces[k].pose.tobytes()
    with pytest.raises(ValueError, match="seed must be >= 0"):
        record_goal_drives(tmp_path, seed=-1)


def test_the_picture_shows_every_drive_and_is_the_same_each_time(drives: GoalDrives) -> None:
    paths = [(name, trace.pose) for name, trace in zip(drives.destinations, drives.traces, strict=True)]
    figure = plot_goal_drives(drives.world, paths, drives.held_out)
    drawn = [line for axes in figure.axes for line in axes.collections]
    assert len(drawn) == 2 * 36
    assert png(figure) == png(plot_goal_drives(drives.world, paths, drives.held_out))
    with pytest.raises(ValueError, match="at least one"):
        plot_goal_drives(drives.world, [])
    with pytest.raises(ValueError, match="must be one of G1"):
        plot_goal_drives(drives.world, [("G9", paths[0][1])])


# -- any map --------------------------------------------------------------------------------------------------------


def test_destinations_in_a_map_can_be_reached_and_are_apart(tmp_path: Path) -> None:
    write_map(goal_building().grid, tmp_path / "building.yaml")
    world = goals_in_map(tmp_path / "building.yaml", seed=4, count=3)
    again = goals_in_map(tmp_path / "building.yaml", seed=4, count=3)
    assert world.goals == again.goals and [*world.start] == [*again.start]
    for one, other in itertools.combinations(world.goals.positions, 2):
        assert np.hypot(*(one - other)) >= 4.0
    for goal in world.goals.names:
        drive = drive_ideally(world.course(goal, 0))
        assert drive.completed and not drive.contacts.any()
    write_goals(world.goals, tmp_path / "goals.yaml")
    assert read_goals(tmp_path / "goals.yaml") == world.goals


def test_a_map_that_cannot_hold_the_destinations_is_refused(tmp_path: Path) -> None:
    write_map(goal_building().grid, tmp_path / "building.yaml")
    with pytest.raises(ValueError, match="seed must be >= 0"):
        goals_in_map(tmp_path / "building.yaml", seed=-1)
    with pytest.raises(ValueError, match="count must be at least 2 goals, got 1"):
        goals_in_map(tmp_path / "building.yaml", seed=0, count=1)
    with pytest.raises(ValueError, match="farthest must be finite and above"):
        goals_in_map(tmp_path / "building.yaml", seed=0, farthest=np.nan)
    with pytest.raises(FileNotFoundError):
        goals_in_map(tmp_path / "none.yaml", seed=0)


@pytest.mark.realdata
def test_destinations_in_real_offices_can_be_reached(data_folder: Path) -> None:
    world = goals_in_map(data_folder / "maps" / "willow_full.yaml", seed=1)
    assert len(world.goals) == 6
    for goal in world.goals.names:
        drive = drive_ideally(world.course(goal, 0))
        assert drive.completed and not drive.contacts.any()


# -- noise ----------------------------------------------------------------------------------------------------------


@given(sticks, st.floats(0, 25), st.integers(0, 99))
def test_noise_never_leaves_the_sticks_range_and_is_the_same_for_a_seed(
    given: np.ndarray, sigma: float, seed: int
) -> None:
    noisy = noisy_joystick(given, sigma, seed)
    assert noisy.shape == given.shape and (np.abs(noisy) <= 1).all()
    np.testing.assert_array_equal(noisy, noisy_joystick(given, sigma, seed))
    np.testing.assert_array_equal(noisy_joystick(given, 0, seed), given)


def test_noise_has_the_sigma_asked_for_and_is_cut_at_full_scale() -> None:
    centred = noisy_joystick(np.zeros((40_000, 2)), 20, 1)
    assert centred.std(axis=0) == pytest.approx([0.2, 0.2], rel=0.02)
    assert centred.mean(axis=0) == pytest.approx([0, 0], abs=0.004)
    full = noisy_joystick(np.ones((40_000, 2)), 20, 1)
    assert (full == 1).mean() == pytest.approx(0.5, abs=0.01)  # the half that would go beyond


def test_a_stick_or_a_noise_that_cannot_be_is_refused() -> None:
    for joystick, sigma, seed, reason in (
        (np.zeros(4), 5, 0, "shape"),
        (np.full((2, 2), 1.2), 5, 0, "must be finite and lie in"),
        (np.full((2, 2), np.nan), 5, 0, "must be finite and lie in"),
        (np.zeros((2, 2)), -1, 0, "sigma must lie in"),
        (np.zeros((2, 2)), np.nan, 0, "sigma must lie in"),
        (np.zeros((2, 2)), 5, -1, "seed must be >= 0"),
    ):
        with pytest.raises(ValueError, match=reason):
            noisy_joystick(joystick, sigma, seed)


@given(poses, st.floats(0, 2), st.floats(0, 1), st.integers(0, 99))
def test_an_error_of_the_pose_has_exactly_the_size_asked_for(
    given: np.ndarray, position: float, heading: float, seed: int
) -> None:
    off = perturbed_poses(given, position, heading, seed) - given
    np.testing.assert_allclose(np.hypot(off[:, 0], off[:, 1]), position, atol=1e-9)
    np.testing.assert_allclose(np.abs(wrap_angle(off[:, 2])), heading, atol=1e-9)


def test_an_error_of_the_pose_that_cannot_be_is_refused() -> None:
    for given_, position, heading, reason in (
        (np.zeros((2, 2)), 0.1, 0, "shape"),
        (np.full((1, 3), np.inf), 0.1, 0, "poses must be finite"),
        (np.zeros((1, 3)), -0.1, 0, "position must be finite and >= 0 m"),
        (np.zeros((1, 3)), 0.1, np.nan, "heading must be finite and >= 0 rad"),
    ):
        with pytest.raises(ValueError, match=reason):
            perturbed_poses(given_, position, heading, 0)
