"""A chair behind a link to the very firmware on a simulated chip: what it observes, and when it stands."""

import math
import time
from collections.abc import Callable, Iterator

import pytest

from lfdcore.cli.ports import simulated_chip
from lfdcore.errors import DeviceError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.hardware import JoystickLink
from lfdcore.simulated.bench_world import WHEELS
from lfdcore.simulated.joystick_bench import JoystickBench, packaged
from lfdcore.wheelchair.counted_way import CountedWay
from lfdcore.wheelchair.linked_chair import LinkedChair
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.watch import FAULT, Watch

try:
    packaged("joystick.elf")
    packaged("joystick_bench")
except DeviceError as missing:
    pytest.skip(str(missing), allow_module_level=True)

SCAN = LaserScan([3.0] * 181, -math.pi / 2, math.pi / 180)
CENTRE, AHEAD = 512 / 1023 * 5, 824 / 1023 * 5
EDGES = 1000.0
"""[edges/s] of both wheels"""
SPEED = EDGES / WHEELS.edges_per_turn * 2 * math.pi * WHEELS.left_radius


class Still:
    """A scanner that took one scan, and has nothing newer."""

    name = "still"
    T_base_laser = ChairGeometry.thesis().T_base_laser
    scan_period = 0.1

    def __init__(self) -> None:
        self.taken = time.monotonic()

    def newest(self) -> tuple[LaserScan, float]:
        return SCAN, self.taken

    def fault(self) -> str:
        return ""

    def close(self) -> None:
        pass


class Rig:
    def __init__(self, bench: JoystickBench, link: JoystickLink) -> None:
        self.bench, self.link, self.scans = bench, link, Still()
        self.chair = LinkedChair(link, CountedWay(WHEELS), self.scans, ChairGeometry.thesis())
        self.began = time.monotonic()

    @property
    def now(self) -> float:
        return time.monotonic() - self.began


@pytest.fixture
def rig() -> Iterator[Rig]:
    with simulated_chip() as (bench, link):
        yield Rig(bench, link)


def wait_until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 10
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_what_was_observed_stays_what_it_was(rig: Rig) -> None:
    rig.bench.set_wheels(EDGES, EDGES)
    time.sleep(0.2)
    first = rig.chair.observe(rig.now)
    pose = Pose2(*first.pose)
    time.sleep(0.2)
    second = rig.chair.observe(rig.now)
    assert first.pose == pose
    assert second.pose.x - pose.x == pytest.approx(SPEED * 0.2, rel=0.5)


def test_a_scan_is_from_where_the_chair_was_when_it_was_taken(rig: Rig) -> None:
    rig.bench.set_wheels(EDGES, EDGES)
    time.sleep(0.3)
    rig.scans.taken = time.monotonic()
    taken = rig.chair.observe(rig.now).pose
    time.sleep(0.4)
    later = rig.chair.observe(rig.now)
    assert later.scan_pose is not None
    assert later.scan_pose.x == pytest.approx(taken.x, abs=0.05 * SPEED)
    assert later.pose.x - later.scan_pose.x > 0.3 * SPEED


def test_a_stamp_that_stands_still_does_so_in_the_loops_time(rig: Rig) -> None:
    stamps = set()
    for _ in range(50):
        stamps.add(rig.chair.observe(rig.now).scan_stamp)
        time.sleep(0.002)
    assert len(stamps) == 1


def test_the_twist_is_of_now_and_not_of_the_last_tick(rig: Rig) -> None:
    """Also when it is asked ten times a second, as a drive does."""
    rig.chair.observe(rig.now)
    rig.bench.set_wheels(EDGES, EDGES)
    time.sleep(0.15)
    assert rig.chair.observe(rig.now).twist.linear == pytest.approx(SPEED, rel=0.1)
    rig.bench.set_wheels(0, 0)
    time.sleep(0.15)
    assert rig.chair.observe(rig.now).twist.linear == pytest.approx(0, abs=0.01)


@pytest.mark.hazard(
    "The chip fails", "where the chair got to while nobody counted is not known: mode fault, and an empty map"
)
def test_a_chip_that_was_reset_leaves_a_fault_and_no_jump(rig: Rig) -> None:
    watch = Watch(rig.chair.geometry)
    rig.bench.set_wheels(EDGES, EDGES)
    time.sleep(0.3)
    rig.scans.taken = time.monotonic()
    before = rig.chair.observe(rig.now)
    assert watch.judge(before) is None
    rig.bench.reset()
    modes = []
    for _ in range(30):
        time.sleep(0.05)
        rig.scans.taken = time.monotonic()
        modes.append(watch.judge(rig.chair.observe(rig.now)))
    assert FAULT in modes
    assert rig.chair.observe(rig.now).pose.x - before.pose.x < 2 * SPEED


def test_a_cable_that_was_out_loses_no_way_since_the_chip_counts_on(rig: Rig) -> None:
    rig.bench.set_wheels(EDGES, EDGES)
    time.sleep(0.2)
    begin, before = time.monotonic(), rig.chair.observe(rig.now).pose
    rig.bench.cut_cable()
    time.sleep(0.4)
    rig.chair.observe(rig.now)
    rig.bench.cut_cable(False)
    wait_until(lambda: rig.link.state != "disconnected")
    time.sleep(0.1)
    after = rig.chair.observe(rig.now).pose
    assert math.isfinite(after.x)
    assert after.x - before.x == pytest.approx(SPEED * (time.monotonic() - begin), rel=0.2)


@pytest.mark.hazard(
    "The chair is faster than declared", "it stands while the chip has another profile than at the start"
)
def test_a_profile_that_the_chip_forgot_is_selected_again_before_anything_moves(rig: Rig) -> None:
    rig.link.select_profile(2)
    wait_until(lambda: (said := rig.link.read()) is not None and said.profile == 2)
    chair = LinkedChair(rig.link, CountedWay(WHEELS), rig.scans, ChairGeometry.thesis())
    chair.observe(rig.now)
    rig.bench.reset()
    profiles = []
    for _ in range(100):
        chair.observe(rig.now)
        chair.command(Twist2(1.0, 0.0), 0.15)
        said = rig.link.read()
        profiles.append(None if said is None else said.profile)
        rig.bench.set_stick(CENTRE if len(profiles) < 70 else AHEAD, CENTRE)
        if profiles[-1] == 0:
            assert rig.bench.outputs().dac == (2048, 2048)
        time.sleep(0.02)
    assert 0 in profiles
    assert profiles[-1] == 2
    assert rig.bench.outputs().dac[0] > 3000
