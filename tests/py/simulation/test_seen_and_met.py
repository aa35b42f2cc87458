"""People as the simulated world has them: seen, met, and no walls."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.geometry import Footprint, Pose2, Twist2
from lfdcore.grid import LaserScan, OccupancyGrid
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig, Person

START = Pose2(1.0, 2.5, 0.0)
STILL = LidarConfig(noise_sd=0)


def room(width: float = 8, height: float = 5) -> OccupancyGrid:
    data = np.zeros((round(height / 0.05), round(width / 0.05)), np.int8)
    data[[0, -1]] = data[:, [0, -1]] = 100
    return OccupancyGrid(data, 0.05)


def world(lidar: LidarConfig = STILL, start: Pose2 = START, seed: int = 3) -> DrivingWorld:
    made = DrivingWorld(room(), ChairConfig(slip_sd=0.05), lidar, seed)
    made.reset(start)
    return made


def standing(x: float, y: float, radius: float = 0.25) -> Person:
    return Person(position=(x, y), radius=radius)


def entered(laser: Pose2, scan: LaserScan, people: list[Person], empty: np.ndarray) -> np.ndarray:
    """Ranges (B,) [m] as NumPy has them: the smaller root of each beam's circle equation, if any, or the map's."""
    angles = laser.yaw + np.asarray(scan.angles())
    along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ranges = np.array(empty, dtype=np.float64)
    for person in people:
        to_laser = np.array([laser.x, laser.y]) - person.position
        half_b, c = along @ to_laser, to_laser @ to_laser - person.radius**2
        with np.errstate(invalid="ignore"):
            root = -half_b - np.sqrt(half_b**2 - c)
        hit = np.zeros_like(root) if c <= 0 else np.where(root >= 0, root, np.inf)
        ranges = np.fmin(ranges, hit)
    return np.where(ranges <= scan.range_max, ranges, np.inf)


places = st.tuples(st.floats(0.3, 7.7), st.floats(0.3, 4.7), st.floats(0.05, 0.6))


@settings(max_examples=60, deadline=None)
@given(st.lists(places, max_size=12), st.floats(-3, 3), st.floats(2, 12))
def test_every_beam_ends_where_numpy_says(drawn, yaw: float, range_max: float):
    seen = world(LidarConfig(noise_sd=0, range_max=range_max), Pose2(4, 2.5, yaw))
    empty = seen.scan().ranges
    people = [standing(*place) for place in drawn]
    seen.set_people(people)
    scan = seen.scan()
    laser = seen.state.pose * LidarConfig().T_base_laser
    np.testing.assert_allclose(scan.ranges, entered(laser, scan, people, empty), atol=2e-6)


def bytes_of(run: DrivingWorld, people: list[Person] | None) -> bytes:
    out = []
    for k in range(60):
        if people is not None:
            run.set_people(people)
        result = run.step(Twist2(0.8, 0.5 * np.sin(k / 3)))
        out.append(np.array([*result.pose, *result.twist, *result.odometry, *result.odometry_twist]).tobytes())
        out.append(run.scan().ranges.tobytes())
    state = run.state
    out.append(np.array([state.collisions, state.distance, state.stamp, *state.contact_point]).tobytes())
    return b"".join(out)


def test_a_world_without_people_gives_the_bytes_of_one_that_never_had_any():
    had = world(LidarConfig())
    had.set_people([standing(2.2, 2.5)])
    bytes_of(had, [Person(position=(3, 2.5), velocity=(-1, 0))])
    had.reset(START)
    assert had.people == [] and had.person_contacts == []
    never = bytes_of(world(LidarConfig()), None)
    assert bytes_of(had, None) == never == bytes_of(world(LidarConfig()), [])


def test_people_change_neither_the_motion_nor_the_noise_and_only_the_beams_that_meet_them():
    alone, among = world(LidarConfig()), world(LidarConfig())
    people = [Person(position=(3.0 - 0.02 * k, 2.2 + 0.1 * k), velocity=(-0.3, -0.1)) for k in range(6)]
    among.set_people(people)
    changed = 0
    for _ in range(60):
        a, b = alone.step(Twist2(0.7, 0.1)), among.step(Twist2(0.7, 0.1))
        assert (*a.pose, *a.odometry) == (*b.pose, *b.odometry)
        one, other = alone.scan().ranges, among.scan().ranges
        assert (other <= one + 1e-6).all()
        changed += int((one != other).sum())
    assert changed > 500
    assert alone.state.collisions == among.state.collisions
    assert len(among.person_contacts) >= 1


def test_a_person_walks_straight_on_at_its_velocity_through_walls_and_chair():
    run = world()
    run.set_people([Person(position=(3.0, 2.5), velocity=(-1.25, 0.0))])
    for _ in range(40):
        run.step(Twist2())
    np.testing.assert_allclose(run.people[0].position, (-2.0, 2.5))
    assert run.state.pose == START and run.state.collisions == 0
    assert len(run.person_contacts) == 1


def test_the_contact_is_noted_where_and_when_the_disc_reaches_the_outline():
    """The chair at 1 m/s from (1, 2.5): its nose is at 1.8 m; who stands at 4.55 m is met at a nose of 4.3 m."""
    run = world(start=START)
    run.set_people([standing(4.55, 2.6)])
    while not run.person_contacts:
        run.step(Twist2(1.0, 0.0))
    contact = run.person_contacts[0]
    assert contact.pose.x + 0.8 == pytest.approx(4.3, abs=0.02)
    assert contact.pose.x + 0.8 >= 4.3
    assert contact.part == "nose" and contact.person == 0
    np.testing.assert_allclose(contact.point, (0.8, 0.1), atol=1e-9)
    assert contact.chair_approach == contact.twist.linear > 0.9
    assert contact.person_approach == 0
    assert run.touches_person and not run.state.in_contact and run.state.collisions == 0


def test_a_contact_with_a_wall_is_no_contact_with_a_person_and_the_other_way_round():
    run = world(start=Pose2(6.5, 2.5, 0.0))
    run.set_people([Person(position=(3.0, 2.5), velocity=(1.0, 0.0))])
    for _ in range(40):
        run.step(Twist2(0.5, 0.0))
    assert run.state.collisions == 1
    assert [contact.part for contact in run.person_contacts] == ["rear"]


def test_who_hides_behind_a_wall_or_another_is_not_in_the_scan():
    run = world(start=Pose2(2.0, 2.5, 0.0))
    run.set_people(
        [standing(4.0, 2.5), standing(6.0, 2.5, 0.2), standing(9.0, 2.5), standing(1.0, 2.5), standing(5, 4)]
    )
    assert run.people_in_scan() == [True, False, False, False, True]
    run.set_people([])
    assert run.people_in_scan() == []


def test_a_person_on_the_scanner_leaves_it_a_range_of_zero():
    run = world()
    run.set_people([standing(1.7, 2.5)])
    assert (run.scan().ranges == 0).all()
    assert run.people_in_scan() == [True]


def test_a_disc_at_range_max_is_seen_and_one_beyond_is_not():
    run = world(LidarConfig(noise_sd=0, range_max=4), Pose2(1.3, 2.5, 0))  # the laser is at x = 2 m
    run.set_people([standing(6.25, 2.5)])
    assert run.scan().ranges[90] == 4.0 and run.people_in_scan() == [True]
    run.set_people([standing(6.2501, 2.5)])
    assert run.scan().ranges[90] == np.inf and run.people_in_scan() == [False]


@pytest.mark.parametrize(
    ("person", "message"),
    [
        ({"radius": 0.0}, r"radius of a person is 0 m, must be positive"),
        ({"radius": -0.1}, r"radius of a person is -0.1 m, must be positive"),
        ({"radius": 6.0}, r"radius of a person is 6 m, must be between 0 and 5"),
        ({"position": (np.nan, 0.0)}, r"position.x of a person is nan m"),
        ({"velocity": (0.0, 11.0)}, r"velocity.y of a person is 11 m/s, must be between -10 and 10"),
    ],
)
def test_a_person_out_of_range_is_refused_by_name(person, message: str):
    with pytest.raises(ValueError, match=message):
        Person(**person)


def test_people_before_a_reset_are_refused():
    with pytest.raises(ValueError, match="call reset"):
        DrivingWorld(room()).set_people([])


def test_the_outline_is_the_chairs_own():
    narrow = DrivingWorld(room(), ChairConfig(footprint=Footprint(0.8, 0.35, 0.1)), STILL)
    for run, met in ((narrow, 0), (world(), 1)):
        run.reset(START)
        run.set_people([standing(1.2, 2.95)])
        run.step(Twist2())
        assert len(run.person_contacts) == met
