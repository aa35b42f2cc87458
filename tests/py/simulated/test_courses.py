"""Courses: sizes, connected routes with clearance, the chair fits through, determinism, refusals."""

import os
from pathlib import Path

import numpy as np
import pytest

from lfdcore.geometry import Footprint, Pose2, arc_length
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses import (
    HOME_ROUTES,
    MAZE_ROUTES,
    Course,
    Drawing,
    FootprintOnGrid,
    RoutePlanner,
    campus,
    distance_to_box,
    doorway_and_docking,
    drive_ideally,
    figure_eight,
    flat,
    from_map,
    hall,
    home,
    home_20x19,
    maze_1,
    maze_2,
    mazes,
    narrow_gap,
    office,
    route_clearance,
    standard_course,
)

COURSES = [
    *(home(route) for route in range(HOME_ROUTES)),
    office(),
    flat(),
    standard_course(),
    campus(),
    figure_eight(),
    hall(),
    *mazes(),
]
names = pytest.mark.parametrize("course", COURSES, ids=lambda course: course.name)


def size(course: Course) -> tuple[float, float]:
    return course.grid.width * course.grid.resolution, course.grid.height * course.grid.resolution


@pytest.mark.parametrize(
    ("course", "metres"),
    [
        (home(), (20, 10)),
        (standard_course(), (21, 37)),
        (campus(), (97, 58)),
        (maze_1(), (20, 10)),
        (maze_2(), (20, 10)),
        (home_20x19(), (20, 19)),
    ],
)
def test_a_course_has_the_size_of_its_figure(course: Course, metres: tuple[float, float]) -> None:
    assert size(course) == pytest.approx(metres)
    assert course.grid.resolution == 0.05


def test_routes_have_the_thesis_lengths() -> None:
    assert standard_course().length == pytest.approx(97, abs=3)  # Table 3.1
    assert campus().length == pytest.approx(229, abs=9)  # Table 3.2: 220 and 238 m
    assert figure_eight().length == pytest.approx(4 * np.pi, abs=0.02)  # Table A.1: 13 m


@names
def test_a_route_keeps_half_the_chairs_width_and_a_bit_from_every_wall(course: Course) -> None:
    assert route_clearance(course.grid, course.route).min() >= Footprint().half_width + 0.05


@names
def test_a_route_is_evenly_spaced_and_closed_if_it_is_a_loop(course: Course) -> None:
    steps = np.diff(arc_length(course.route))
    assert steps.min() > 0.05 and steps.max() < 0.13
    assert course.loop == (np.hypot(*(course.route[-1] - course.route[0])) < 1e-9)


@names
def test_an_ideal_chair_completes_the_course_without_contact(course: Course) -> None:
    drive = drive_ideally(course, margin=0.02)
    assert drive.completed
    assert not drive.contacts.any()


@names
def test_every_door_is_wide_enough_and_as_wide_as_it_says(course: Course) -> None:
    occupied = course.grid.occupied_mask()
    for door in course.doors:
        assert door.width >= 0.90
        ix, iy = course.grid.cell_at(door.x, door.y)
        line = occupied[:, ix] if door.along == "x" else occupied[iy, :]
        at = iy if door.along == "x" else ix
        walls = np.nonzero(line)[0]
        free = walls[walls > at].min() - walls[walls < at].max() - 1
        assert free * course.grid.resolution == pytest.approx(door.width)


def test_training_tuning_and_test_share_no_world() -> None:
    worlds: dict[bytes, set[str]] = {}
    for course in [*COURSES, home_20x19()]:
        worlds.setdefault(course.grid.data.tobytes(), set()).add(course.split)
    assert all(len(splits) == 1 for splits in worlds.values())
    assert {course.split for course in COURSES} == {"training", "tuning", "test"}


def test_a_course_is_the_same_bytes_every_time() -> None:
    first, again = standard_course(), standard_course.__wrapped__()
    assert first.route.tobytes() == again.route.tobytes()
    assert first.grid.data.tobytes() == again.grid.data.tobytes()


def test_the_homes_routes_differ_and_come_near_all_of_its_floor() -> None:
    visited = np.concatenate([home(route).route for route in range(HOME_ROUTES)])
    for room in ((2, 2), (2, 8), (8, 7.4), (12, 7.4), (7.5, 2), (12, 2), (17, 2), (16.5, 7.5), (10, 5)):
        assert np.hypot(*(visited - room).T).min() < 0.9
    assert home(0).route.tobytes() != home(2).route.tobytes()
    with pytest.raises(ValueError, match=r"route must be 0\.\.2, got 3"):
        home(3)


def test_all_ways_through_a_maze_start_in_its_corner_and_end_elsewhere() -> None:
    for maze in (maze_1, maze_2):
        routes = [maze(route).route for route in range(MAZE_ROUTES)]
        assert all(np.hypot(*(route[0] - (1, 1))) < 0.1 for route in routes)
        ends = np.array([route[-1] for route in routes])
        apart = np.hypot(*(ends[:, None] - ends).transpose(2, 0, 1)) + 9 * np.eye(MAZE_ROUTES)
        assert apart.min() > 0.3 and (ends.max(axis=0) > (18, 8.5)).all()
        with pytest.raises(ValueError, match=r"route must be 0\.\.11, got 12"):
            maze(12)


def test_the_ways_through_a_maze_meet_nearly_all_of_its_doors() -> None:
    """Each door of both mazes is on some way, .9 m ones included."""
    for maze in (maze_1, maze_2):
        visited = np.concatenate([maze(route).route for route in range(MAZE_ROUTES)])
        widths = [door.width for door in maze().doors]
        assert all(np.hypot(*(visited - (door.x, door.y)).T).min() < 0.1 for door in maze().doors)
        assert min(widths) == 0.9


@pytest.mark.parametrize("seed", range(6))
def test_arbitrary_destinations_in_the_large_home_can_be_driven_to_and_the_seed_decides_which(seed: int) -> None:
    course, again, other = home_20x19(seed), home_20x19.__wrapped__(seed), home_20x19(seed + 1)
    assert course.route.tobytes() == again.route.tobytes() != other.route.tobytes()
    assert course.length >= 10 and course.split == "test"
    assert route_clearance(course.grid, course.route).min() >= Footprint().half_width + 0.05 - 1e-6
    drive = drive_ideally(course)
    assert drive.completed and not drive.contacts.any()


def test_a_seed_whose_start_leads_nowhere_starts_elsewhere() -> None:
    blocked = home_20x19(517)
    with pytest.raises(ValueError, match="no route of"):
        from_map(blocked.grid, 517, 10.0, doors=blocked.doors)
    assert blocked.length >= 10 and blocked.name == "home-20x19-517"
    with pytest.raises(ValueError, match="seed must be >= 0, got -1"):
        home_20x19(-1)


@pytest.mark.parametrize("make", [doorway_and_docking, narrow_gap])
def test_a_task_is_drawn_from_its_seed(make) -> None:  # type: ignore[no-untyped-def]
    a, b, other = make(4), make(4), make(5)
    assert a.course.route.tobytes() == b.course.route.tobytes()
    assert tuple(a.course.start) == tuple(b.course.start) != tuple(other.course.start)
    with pytest.raises(ValueError, match="seed must be >= 0"):
        make(-1)


@pytest.mark.parametrize("make", [doorway_and_docking, narrow_gap])
@pytest.mark.parametrize("seed", range(6))
def test_an_ideal_chair_reaches_the_tasks_end_without_contact(make, seed: int) -> None:  # type: ignore[no-untyped-def]
    task = make(seed)
    drive = drive_ideally(task.course)
    assert not drive.contacts.any()
    assert task.reached(Pose2(*drive.poses[-1]))
    assert not task.reached(task.course.start)


def test_docking_is_measured_from_the_outline_to_the_table() -> None:
    box = (2.0, -1.0, 3.0, 1.0)
    assert distance_to_box(Pose2(1.0, 0, 0), Footprint(), box) == pytest.approx(0.2)
    assert distance_to_box(Pose2(1.0, 0, np.pi), Footprint(), box) == pytest.approx(0.65)
    assert distance_to_box(Pose2(1.5, 0, 0), Footprint(), box) == 0.0


def test_a_gap_has_the_width_asked_for_and_refuses_one_the_chair_does_not_fit() -> None:
    occupied = narrow_gap(0, 1.1).course.grid.occupied_mask()
    ix = narrow_gap(0).course.grid.cell_at(4.55, 3.0)[0]
    assert (~occupied[:, ix]).sum() * 0.05 == pytest.approx(1.1)
    with pytest.raises(ValueError, match=r"width must be in \(0.7, 3.0\] m, got 0.6"):
        narrow_gap(0, 0.6)
    with pytest.raises(ValueError, match=r"width must be a multiple of 0.1 m"):
        narrow_gap(0, 0.95)


def test_the_footprint_on_a_grid_agrees_with_clipping_cells_against_the_rectangle() -> None:
    rng = np.random.default_rng(0)
    cells = np.where(rng.random((60, 60)) < 0.004, 100, 0).astype(np.int8)
    grid, footprint = OccupancyGrid(cells, 0.05, (-1.5, -1.5)), Footprint()
    poses = np.column_stack([rng.uniform(-0.3, 0.3, (300, 2)), rng.uniform(-np.pi, np.pi, 300)])
    iy, ix = np.nonzero(cells)
    offsets = np.linspace(-0.0249, 0.0249, 21)
    fine = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    points = (np.stack([ix + 0.5, iy + 0.5], axis=1) * 0.05 - 1.5)[:, None] + fine
    wrong = 0
    for pose, touched in zip(poses, FootprintOnGrid(grid, footprint).touches(poses), strict=True):
        local = Pose2(*pose).inverse().transform(points.reshape(-1, 2))
        inside = (np.abs(local[:, 1]) <= 0.35) & (local[:, 0] <= 0.80) & (local[:, 0] >= -0.35)
        deep = (np.abs(local[:, 1]) <= 0.33) & (local[:, 0] <= 0.78) & (local[:, 0] >= -0.33)
        assert not deep.any() or touched
        wrong += int(touched != inside.any())
    assert wrong <= 6  # corners of cells that reach in by less than the lattice's step


def test_a_planner_refuses_places_it_cannot_reach() -> None:
    d = Drawing(6.0, 4.0)
    d.wall(3.0, 0.0, 3.0, 4.0)
    planner = RoutePlanner(d.grid())
    with pytest.raises(ValueError, match="no way for the chair from"):
        planner.route([(1.5, 2.0), (4.5, 2.0)])
    with pytest.raises(ValueError, match="more than 1 m from any place"):
        planner.route([(1.5, 2.0), (30.0, 2.0)])
    with pytest.raises(ValueError, match="at least 2 waypoints, got 1"):
        planner.route([(1.5, 2.0)])


def test_a_course_refuses_a_route_that_is_not_one() -> None:
    grid = Drawing(2.0, 2.0).grid()
    for bad in (np.zeros((1, 2)), np.zeros((4, 3)), np.array([[0, 0], [np.nan, 1]])):
        with pytest.raises(ValueError, match="route must be a finite"):
            Course("x", grid, Pose2(), bad, False, "", "test")
    with pytest.raises(ValueError, match="split must be"):
        Course("x", grid, Pose2(), np.zeros((2, 2)), False, "", "dev")  # type: ignore[arg-type]


def test_any_map_gives_a_course_that_the_chair_can_drive_and_the_seed_decides_which() -> None:
    course, again, other = (from_map(office().grid, seed, 25.0) for seed in (1, 1, 2))
    assert course.length >= 25.0
    assert course.route.tobytes() == again.route.tobytes() != other.route.tobytes()
    assert not drive_ideally(course).contacts.any()
    assert route_clearance(course.grid, course.route).min() >= 0.40 - 1e-6


def test_unknown_cells_are_not_driven_over() -> None:
    cells = office().grid.data.copy()
    cells[:, 330:] = -1
    course = from_map(OccupancyGrid(cells, 0.05), 0, 15.0)
    assert course.route[:, 0].max() < 330 * 0.05


def test_a_map_without_room_is_refused() -> None:
    with pytest.raises(ValueError, match=r"no place with 0.95 m of free space"):
        from_map(Drawing(1.5, 1.5).grid(), 0)
    with pytest.raises(ValueError, match="length must be positive and finite, got nan"):
        from_map(office().grid, 0, float("nan"))
    with pytest.raises(ValueError, match=r"no route of 500.0 m without contact found"):
        from_map(Drawing(3.0, 3.0).grid(), 0, 500.0)


@pytest.mark.realdata
def test_the_data_folders_furnished_home_gives_a_course() -> None:
    folder = os.environ.get("LFDCORE_DATA")
    if not folder:
        pytest.skip("LFDCORE_DATA is not set")
    from lfdcore.datasets.maps import read_map

    course = from_map(read_map(Path(folder) / "maps" / "aws_small_house.yaml"), 0, 40.0)
    assert course.length >= 40.0
    assert not drive_ideally(course).contacts.any()
