"""The picture of people about a chair shows where they are, and which of them the scan shows."""

import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.patches import Circle

from lfdcore.geometry import Twist2
from lfdcore.pictures.people import people_figure, scan_points
from lfdcore.pictures.style import SEEN, png
from lfdcore.simulated.courses import standard_course
from lfdcore.simulated.people import People, PeopleConfig
from lfdcore.simulation import DrivingWorld, LidarConfig

GRID, START = standard_course().grid, standard_course().start


@pytest.fixture(scope="module")
def world() -> DrivingWorld:
    """At a moment when some are in the scan and others are not."""
    made = DrivingWorld(GRID, lidar=LidarConfig(noise_sd=0), seed=1)
    made.reset(START)
    people = People(GRID, PeopleConfig(), (START.x, START.y), 1)
    for _ in range(300):
        made.set_people(people.walk(0.1))
        made.step(Twist2())
    return made


def test_every_person_is_drawn_and_those_in_the_scan_in_another_colour(world: DrivingWorld) -> None:
    circles = [patch for patch in people_figure(GRID, world).axes[0].patches if isinstance(patch, Circle)]
    assert [circle.center for circle in circles] == [tuple(person.position) for person in world.people]
    assert [same_color(circle.get_edgecolor(), SEEN) for circle in circles] == world.people_in_scan()
    assert 0 < sum(world.people_in_scan()) < 12


def test_beams_end_on_the_discs_that_are_in_the_scan_and_on_no_other(world: DrivingWorld) -> None:
    _, ends = scan_points(world, world.scan())
    for person, shown in zip(world.people, world.people_in_scan(), strict=True):
        on_edge = np.abs(np.hypot(*(ends - person.position).T) - person.radius) < 1e-5
        assert on_edge.any() == shown


def test_the_same_moment_gives_the_same_bytes(world: DrivingWorld) -> None:
    assert png(people_figure(GRID, world), 60) == png(people_figure(GRID, world), 60)
