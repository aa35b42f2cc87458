"""People who walk in courses: never in a wall, never in each other; met by the chair and judged."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.chair import SimulatedChair
from lfdcore.simulated.courses import Course, flat, home, standard_course
from lfdcore.simulated.drivers import ImpairedDriver
from lfdcore.simulated.people import People, PeopleConfig
from lfdcore.simulated.person_met import STANDING, PersonMet, person_met
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulated.walkways import Walkways
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig, Person
from lfdcore.wheelchair.assistants import STOP, Unassisted
from lfdcore.wheelchair.observation import Assistance, Observation

R = PeopleConfig().radius


CHAIR = RunConfig().geometry


class Standing:
    """An assistant that lets nobody drive."""

    name = "standing"
    chair = CHAIR

    def reset(self) -> None:
        pass

    def update(self, observation: Observation) -> Assistance:
        return Assistance(STOP, "rest")


def in_course(course: Course, seed: int, **changes: float) -> People:
    start = (course.start.x, course.start.y)
    return People(course.grid, PeopleConfig(**changes), start, seed)  # type: ignore[arg-type]


def for_seconds(course: Course, seconds: float, **changes: object) -> RunConfig:
    return RunConfig(slowest=course.length / seconds, **changes)  # type: ignore[arg-type]


class Walls:
    """All occupied cells of a map, and how far from the nearest points are: exact up to half a metre."""

    def __init__(self, grid: OccupancyGrid) -> None:
        iy, ix = np.nonzero(grid.occupied_mask())
        self._half = grid.resolution / 2
        self._centres = np.stack([ix + 0.5, iy + 0.5], axis=1) * grid.resolution + np.array(grid.origin)
        self._tree = cKDTree(self._centres)

    def gap(self, points: np.ndarray) -> np.ndarray:
        """(N,) [m] from points (N, 2); the nearest square is among the twelve nearest centres."""
        _, nearest = self._tree.query(points, k=12)
        aside = np.maximum(np.abs(self._centres[nearest] - points[:, None]) - self._half, 0.0)
        return np.asarray(np.hypot(aside[..., 0], aside[..., 1]).min(axis=1))


def nearest_pair(position: np.ndarray) -> float:
    apart = np.hypot(*(position[:, None] - position[None]).transpose(2, 0, 1))
    return float(apart[np.triu_indices(len(position), 1)].min())


# ---- the ground ------------------------------------------------------------------------------------------------------


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_the_gap_to_a_wall_is_never_more_than_a_search_over_all_cells_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((40, 60)) < 0.01, 100, 0).astype(np.int8)
    data[10, 10] = 0
    data[20, :20] = 100
    grid = OccupancyGrid(data, 0.05, (-1.0, 2.0))
    ways = Walkways(OccupancyGrid(np.pad(data, 40), 0.05, (-3.0, 0.0)), 0.1, (-2.5, 0.5), 2, rng)
    points = np.array(grid.origin) + rng.uniform(0, 1, (200, 2)) * (60 * 0.05, 40 * 0.05)
    exact, gap = Walls(grid).gap(points), ways.gap(points)
    assert (gap <= exact + 1e-9).all()
    assert (gap >= exact - 1.5 * 0.05).all()


def test_beyond_the_map_is_a_wall() -> None:
    course = flat()
    ways = Walkways(course.grid, R, (course.start.x, course.start.y), 2, np.random.default_rng(0))
    assert (ways.gap(np.array([[-1.0, 2.0], [1e6, 1.0]])) == -np.inf).all()


# ---- laws ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [flat, home, standard_course])
@pytest.mark.parametrize("seed", [0, 1])
def test_nobody_walks_into_a_wall_or_another_in_a_minute(make, seed: int) -> None:
    """Also between the ticks: five places of every straight step are looked at."""
    course = make()
    people, walls = in_course(course, seed), Walls(course.grid)
    walked = np.zeros(len(people.position))
    for _ in range(600):
        before = people.position
        people.walk(0.1)
        step = people.position - before
        walked += np.hypot(*step.T)
        for share in np.linspace(0.2, 1, 5):
            assert nearest_pair(before + share * step) >= 2 * R
            assert walls.gap(before + share * step).min() >= R
    assert np.median(walked) > 0.6 * 1.1 * 60  # they do get on


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.02, 0.4), st.integers(2, 20))
def test_whatever_the_period_and_the_number_nobody_is_in_anybody(seed: int, period: float, count: int) -> None:
    course = flat()
    people, walls = in_course(course, seed, count=count), Walls(course.grid)
    for _ in range(60):
        before = people.position
        people.walk(period)
        for share in np.linspace(0.1, 1, 10):
            there = before + share * (people.position - before)
            assert nearest_pair(there) >= 2 * R
            assert walls.gap(there).min() >= R


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    def walked(seed: int) -> bytes:
        people = in_course(flat(), seed)
        return b"".join([people.walk(0.1)[3].velocity.tobytes() + people.position.tobytes() for _ in range(100)])

    assert walked(4) == walked(4) != walked(5)


class OpenFloor:
    """No walls; the first of two walks towards +x, the second towards -x, and neither ever arrives."""

    def gap(self, points: np.ndarray) -> np.ndarray:
        return np.full(points.shape[:-1], np.inf)

    def heading(self, place: np.ndarray, points: np.ndarray) -> np.ndarray:
        return np.array([[1.0, 0.0], [-1.0, 0.0]])

    def way_left(self, place: np.ndarray, points: np.ndarray) -> np.ndarray:
        return np.full(2, 10.0)


def test_two_who_meet_head_on_pass_each_other_on_the_right() -> None:
    people = in_course(flat(), 0, count=2, patience=100.0)
    people._ways = OpenFloor()  # type: ignore[assignment]
    people.position = np.array([[0.0, 5.0], [6.0, 5.0]])
    while people.position[0, 0] < people.position[1, 0]:
        people.walk(0.1)
        assert people.velocity[0, 0] > 0.4 and people.velocity[1, 0] < -0.4
    assert people.position[0, 1] < 5 - R / 2 and people.position[1, 1] > 5 + R / 2


# ---- the chair among them --------------------------------------------------------------------------------------------


def test_a_run_among_people_gives_the_same_bytes_again_and_moves_the_driver_as_without() -> None:
    course = flat()
    alone, among, again = (
        run_drive(course, ImpairedDriver(course), Unassisted(CHAIR), 3, for_seconds(course, 20, people=people))
        for people in (None, PeopleConfig(), PeopleConfig())
    )
    for name in ("pose", "twist", "joystick", "desired", "command", "in_contact", "collision"):
        assert getattr(alone, name).tobytes() == getattr(among, name).tobytes() == getattr(again, name).tobytes()
    assert among.people.tobytes() == again.people.tobytes()
    assert among.people_met == again.people_met
    assert among.people.shape == (len(among.stamp), 12, 2) and alone.people.shape == (len(alone.stamp), 0, 2)
    assert not alone.touches_person.any() and alone.people_met == ()


def test_whoever_drives_blindly_through_a_crowd_meets_people_with_the_nose() -> None:
    course = home(0)
    met: list[PersonMet] = []
    for seed in range(3):
        config = for_seconds(course, 60, people=PeopleConfig(count=30))
        trace = run_drive(course, ImpairedDriver(course), Unassisted(CHAIR), seed, config)
        assert trace.touches_person.any() == bool(trace.people_met)
        met += trace.people_met
    assert any(meeting.foreseeable for meeting in met)
    assert all(meeting.chair_approach + meeting.person_approach > -0.05 for meeting in met)
    assert any(meeting.part != "nose" for meeting in met)


def test_a_standing_chair_drives_into_nobody_and_people_walk_into_it() -> None:
    course = home(0)
    config = for_seconds(course, 60, people=PeopleConfig(count=30), stuck_after=1e3)
    trace = run_drive(course, ImpairedDriver(course), Standing(), 1, config)
    assert len(trace.people_met) >= 1
    for meeting in trace.people_met:
        assert meeting.walked_into_standing_chair and not meeting.by_moving_nose and not meeting.foreseeable
        assert meeting.chair_approach_since < STANDING


def test_the_truth_of_every_tick_has_the_people_and_the_contacts_that_began() -> None:
    course = home(0)
    people = in_course(course, 1, count=30)
    chair = SimulatedChair(course, ImpairedDriver(course), 1, ChairConfig(), LidarConfig(), people)
    met = 0
    for tick in range(600):
        chair.observe(tick / 10)
        np.testing.assert_allclose(chair.truth.people, people.position, atol=1e-9)
        met += chair.truth.people_met
        assert met == len(chair.people_met()) and (chair.truth.touches_person or not chair.truth.people_met)
        assert not chair.truth.collision
        chair.command(Twist2(), 0.1)
    assert met >= 1


def meeting_at(distance: float, speed: float) -> PersonMet:
    """A chair at full speed meets one who comes out of hiding, or stands in view, `distance` ahead of its nose."""
    data = np.zeros((100, 240), np.int8)
    world = DrivingWorld(OccupancyGrid(data, 0.05), lidar=LidarConfig(), seed=1, unknown_is_solid=False)
    world.reset(Pose2(1.0, 2.5, 0.0))
    person, shown = Person(position=(1.8 + distance, 2.5)), []
    world.set_people([person])
    while not world.person_contacts:
        shown.append((world.state.stamp, world.people_in_scan()))
        world.step(Twist2(speed, 0.0))
    return person_met(world.person_contacts[0], shown)


def test_a_scan_warns_if_it_showed_the_person_a_second_before() -> None:
    long_before, too_late = meeting_at(3.0, 1.0), meeting_at(0.6, 1.0)
    assert long_before.was_shown and 1.0 <= long_before.shown_before <= 1.1
    assert long_before.foreseeable and long_before.chair_speed > 0.9
    assert not too_late.was_shown and too_late.shown_before == np.inf
    assert too_late.by_moving_nose and not too_late.foreseeable


@pytest.mark.parametrize(
    ("changes", "nose", "walked_into"),
    [
        ({}, True, False),
        ({"part": "left"}, False, False),
        ({"chair_approach": -0.1}, False, False),
        ({"chair_approach": 0.0, "chair_speed": 0.0}, False, True),
        ({"chair_approach": 0.0, "chair_speed": 0.0, "person_approach": 0.0}, False, False),
    ],
)
def test_a_meeting_is_judged_by_part_and_approach(changes: dict[str, object], nose: bool, walked_into: bool) -> None:
    meeting = PersonMet(0, 2.0, "nose", (0.8, 0.0), 0.5, 0.5, 0.3, 0.5, 1.05)
    meeting = replace(meeting, **changes)  # type: ignore[arg-type]
    assert (meeting.by_moving_nose, meeting.walked_into_standing_chair) == (nose, walked_into)
    assert meeting.foreseeable == nose
    assert not replace(meeting, shown_before=np.inf).foreseeable


# ---- borders ---------------------------------------------------------------------------------------------------------


def test_nobody_sets_out_beside_the_chair() -> None:
    course = standard_course()
    for seed in range(5):
        away = in_course(course, seed).position - (course.start.x, course.start.y)
        assert np.hypot(*away.T).min() >= 2.0


def test_no_people_walk_too() -> None:
    course = flat()
    nobody = in_course(course, 0, count=0)
    assert nobody.walk(0.1) == [] and nobody.position.shape == (0, 2)
    run = run_drive(course, ImpairedDriver(course), Unassisted(CHAIR), 1, for_seconds(course, 2, people=nobody.config))
    assert run.people.shape[1:] == (0, 2) and run.people_met == ()


def test_more_people_than_the_map_has_room_for_are_refused() -> None:
    with pytest.raises(ValueError, match=r"count is 1000 people, the map has room for \d+"):
        in_course(flat(), 0, count=1000)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("radius", 0.0, "radius is 0.0 m, must be between 0.1 and 1.0"),
        ("radius", -0.25, "radius is -0.25 m"),
        ("count", -1, "count is -1 people"),
        ("speed", float("nan"), "speed is nan m/s"),
        ("speed_sd", 0.8, "speed_sd is 0.8 m/s, must be between 0.0 and 0.55"),
        ("places", 1, "places is 1 places"),
        ("patience", 0.0, "patience is 0.0 s"),
    ],
)
def test_a_field_out_of_range_is_refused_by_name(field: str, value: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PeopleConfig(**{field: value})  # type: ignore[arg-type]


def test_a_map_without_ground_is_refused() -> None:
    solid = OccupancyGrid(np.full((60, 60), 100, np.int8), 0.05)
    with pytest.raises(ValueError, match="more than 1 m from any place"):
        People(solid, PeopleConfig(), (1.0, 1.0), 0)
