"""What is always before the scanner, and a clock that does not keep time."""

import math

import numpy as np
import pytest

from lfdcore.geometry import Pose2
from lfdcore.simulated.chair import FOOT, ScannerFaults, SimulatedChair, ranges_to_disc
from lfdcore.simulated.courses import Course, home
from lfdcore.simulated.hostile_drivers import HeldStick
from lfdcore.simulated.unsteady_clock import TickFaults, UnsteadyClock
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig, Person
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.drive_loop import SimulatedClock, Tick, drive

COURSE = home()
QUIET = LidarConfig(noise_sd=0.0)


def chair_with(faults: ScannerFaults, lidar: LidarConfig = QUIET, course: Course = COURSE) -> SimulatedChair:
    return SimulatedChair(course, HeldStick((0.5, 0.2)), 1, ChairConfig(), lidar, scanner=faults)


@pytest.mark.parametrize("place", [(0.70, 0.27), (0.90, -0.10), (0.75, 0.0), (1.2, 0.9), (0.5, 0.0)])
def test_a_foot_is_seen_as_a_person_of_its_size_who_stands_there(place: tuple[float, float]) -> None:
    seen = chair_with(ScannerFaults(foot=place)).observe(0.0).scan
    world = DrivingWorld(COURSE.grid, lidar=QUIET)
    world.reset(COURSE.start)
    there = COURSE.start * Pose2(*place, 0.0)
    world.set_people([Person(position=(there.x, there.y), radius=FOOT)])
    assert np.array(seen.ranges) == pytest.approx(np.array(world.scan().ranges), abs=1e-5)


def test_beams_meet_a_disc_where_they_first_lie_in_it() -> None:
    random = np.random.default_rng(1)
    along = np.arange(0, 4, 1e-3)
    for _ in range(50):
        centre, radius = random.uniform(-2, 2, 2), random.uniform(0.05, 0.5)
        angles = random.uniform(-np.pi, np.pi, 20)
        points = along[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
        inside = np.hypot(*np.moveaxis(points - centre, -1, 0)) <= radius
        slow = np.where(inside.any(axis=0), along[inside.argmax(axis=0)], np.inf)
        if np.hypot(*centre) <= radius:
            continue  # the scanner is in it
        found = ranges_to_disc(centre, radius, angles)
        grazed = np.isinf(slow) & np.isfinite(found)  # a chord between two of the slow way's points
        assert found[~grazed] == pytest.approx(slow[~grazed], abs=1.1e-3)
        assert grazed.sum() <= 1


def test_the_foot_of_the_study_is_a_few_beams_inside_the_outline_in_every_scan() -> None:
    """About .1 m deep, also with the scanner's noise."""
    chair = chair_with(CONDITIONS["a point inside the outline"].run.scanner, LidarConfig())
    body, depths = chair.geometry.footprint, []
    for tick in range(50):
        scan = chair.observe(tick / 10).scan
        ranges = np.array(scan.ranges)[-5:]
        angles = scan.angles()[-5:]
        x, y = 0.70 + ranges * np.cos(angles), ranges * np.sin(angles)
        depths.append(np.min([body.front - x, body.half_width - y], axis=0))
        assert np.array(scan.ranges)[-6] > 0.35
    assert np.mean(depths) == pytest.approx(0.09, abs=0.01)
    assert np.min(depths) > 0.05
    assert np.std(depths) > 0.005


@pytest.mark.parametrize("faults", [{"foot": (math.nan, 0.0)}, {"dropped": 1.5}, {"period": -1.0}])
def test_a_fault_out_of_range_is_refused_by_name(faults: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=next(iter(faults))):
        ScannerFaults(**faults)  # type: ignore[arg-type]


def stamps_of(clock: object, seconds: float = 400.0) -> np.ndarray:
    stamps: list[float] = []

    def ended(tick: Tick) -> bool:
        stamps.append(tick.stamp)
        return tick.stamp > seconds

    chair = chair_with(ScannerFaults(), LidarConfig(beams=9))
    drive(chair, Unassisted(chair.geometry), ended, clock=clock)  # type: ignore[arg-type]
    return np.array(stamps)


def test_without_faults_the_clock_keeps_time() -> None:
    assert stamps_of(UnsteadyClock(TickFaults(), 1), 20).tolist() == stamps_of(SimulatedClock(), 20).tolist()


def test_the_ticks_of_the_study_jitter_by_half_a_period_and_one_in_200_is_late() -> None:
    faults = CONDITIONS["late ticks"].ticks
    stamps = stamps_of(UnsteadyClock(faults, 1))
    apart = np.diff(stamps)
    assert apart.min() > 0
    late = apart > 0.15 + 1e-9
    assert apart[late].min() >= 0.1 + 0.2 - 0.05 - 1e-9
    assert apart.max() <= 0.1 + 0.2 + 0.05 + 1e-9
    assert late.mean() == pytest.approx(1 / 200, rel=0.5)
    assert apart[~late].std() > 0.01
    assert stamps.tolist() == stamps_of(UnsteadyClock(faults, 1)).tolist()
    assert stamps.tolist() != stamps_of(UnsteadyClock(faults, 2)).tolist()


@pytest.mark.parametrize("faults", [{"jitter": -0.1}, {"late": math.nan}, {"late_share": 1.1}])
def test_a_clock_out_of_range_is_refused_by_name(faults: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(faults))):
        TickFaults(**faults)
