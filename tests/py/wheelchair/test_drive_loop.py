"""One loop drives any chair: it owns the stamps, records what a chair records, and always stops the chair."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLogWriter
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.drive_loop import SimulatedClock, Tick, WallClock, drive
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from observed import observed

CHAIR = ChairGeometry.thesis()

SCAN = LaserScan(np.full(5, 2.0, np.float32), -1.0, 0.5, 0.0, 30.0)


class Wheels:
    """The least chair: it notes what it is asked."""

    def __init__(self, geometry: ChairGeometry = CHAIR) -> None:
        self.geometry = geometry
        self.calls: list[tuple[str, float]] = []
        self.holds: list[float] = []

    def observe(self, stamp: float) -> Observation:
        self.calls.append(("observe", stamp))
        return observed(stamp, SCAN, (0.5, 0.0))

    def command(self, twist: Twist2, duration: float) -> None:
        self.calls.append(("command", twist.linear))
        self.holds.append(duration)

    def stop(self) -> None:
        self.calls.append(("stop", 0.0))


class Breaking(Unassisted):
    def update(self, observation: Observation) -> Assistance:
        if observation.stamp > 0.15:
            raise RuntimeError("broken")
        return super().update(observation)


def ticks(n: int) -> "list[Tick]":
    """Collects n ticks; called with a tick, it says whether that was the last."""

    class Collected(list[Tick]):
        def __call__(self, tick: Tick) -> bool:
            self.append(tick)
            return len(self) == n

    return Collected()


def test_every_tick_observes_then_commands_and_the_chair_is_stopped_at_the_end() -> None:
    chair, seen = Wheels(), ticks(2)
    drive(chair, Unassisted(CHAIR), seen, clock=SimulatedClock())
    assert [name for name, _ in chair.calls] == ["observe", "command", "observe", "command", "stop"]
    assert [tick.stamp for tick in seen] == [tick.observation.stamp for tick in seen] == pytest.approx([0.0, 0.1])
    assert chair.calls[1][1] == seen[0].assistance.command.linear > 0


def test_the_chair_is_stopped_when_the_assistant_breaks() -> None:
    chair = Wheels()
    with pytest.raises(RuntimeError, match="broken"):
        drive(chair, Breaking(CHAIR), ticks(9), clock=SimulatedClock())
    assert [name for name, _ in chair.calls][-2:] == ["observe", "stop"]


def test_the_chair_is_stopped_when_who_watches_interrupts() -> None:
    def interrupt(tick: Tick) -> bool:
        raise KeyboardInterrupt

    chair = Wheels()
    with pytest.raises(KeyboardInterrupt):
        drive(chair, Unassisted(CHAIR), interrupt, clock=SimulatedClock())
    assert chair.calls[-1] == ("stop", 0.0)


def test_the_loop_records_what_a_chair_records(tmp_path: Path) -> None:
    with DriveLogWriter(tmp_path / "drive.mcap", T_base_laser=Pose2(0.5, 0, 0)) as log:
        drive(Wheels(), Unassisted(CHAIR), ticks(3), clock=SimulatedClock(), log=log)
    drive_log = open_log(tmp_path / "drive.mcap")
    for stamps in (drive_log.scan_stamp, drive_log.odometry_stamp, drive_log.joystick_stamp, drive_log.command_stamp):
        np.testing.assert_allclose(stamps, [0.0, 0.1, 0.2])
    np.testing.assert_allclose(drive_log.joystick, [[0.5, 0.0]] * 3)


def test_a_scan_that_several_ticks_see_is_recorded_once(tmp_path: Path) -> None:
    class SlowScanner(Wheels):
        def observe(self, stamp: float) -> Observation:
            return replace(super().observe(stamp), scan_stamp=0.2 if stamp >= 0.2 else 0.0)

    with DriveLogWriter(tmp_path / "drive.mcap", T_base_laser=Pose2(0.5, 0, 0)) as log:
        drive(SlowScanner(), Unassisted(CHAIR), ticks(4), clock=SimulatedClock(), log=log)
    np.testing.assert_allclose(open_log(tmp_path / "drive.mcap").scan_stamp, [0.0, 0.2])


def test_a_scan_without_beams_is_not_recorded_and_the_drive_goes_on(tmp_path: Path) -> None:
    class Broken(Wheels):
        def observe(self, stamp: float) -> Observation:
            seen = super().observe(stamp)
            return seen if stamp > 0.05 else replace(seen, scan=LaserScan([], -1.0, 0.5, 0.0, 30.0))

    with DriveLogWriter(tmp_path / "drive.mcap", T_base_laser=Pose2(0.5, 0, 0)) as log:
        drive(Broken(), Unassisted(CHAIR), ticks(3), clock=SimulatedClock(), log=log)
    np.testing.assert_allclose(open_log(tmp_path / "drive.mcap").scan_stamp, [0.1, 0.2])


def test_the_chair_is_stopped_when_the_assistant_cannot_begin() -> None:
    class Unready(Unassisted):
        def reset(self) -> None:
            raise RuntimeError("unready")

    chair = Wheels()
    with pytest.raises(RuntimeError, match="unready"):
        drive(chair, Unready(CHAIR), ticks(1), clock=SimulatedClock())
    assert chair.calls == [("stop", 0.0)]


def test_a_command_that_is_not_finite_stops_the_chair_and_is_never_given() -> None:
    class Lost(Unassisted):
        def update(self, observation: Observation) -> Assistance:
            return replace(super().update(observation), command=Twist2(float("nan"), 0.0))

    chair = Wheels()
    with pytest.raises(ValueError, match="commands nan m/s"):
        drive(chair, Lost(CHAIR), ticks(1), clock=SimulatedClock())
    assert chair.calls == [("observe", 0.0), ("stop", 0.0)]


@pytest.mark.parametrize("period", [0.05, 0.1, 0.2])
def test_ticks_come_as_the_chair_says_and_a_command_holds_for_half_a_period_longer(period: float) -> None:
    chair, seen = Wheels(replace(CHAIR, period=period)), ticks(3)
    drive(chair, Unassisted(chair.geometry), seen, clock=SimulatedClock())
    assert [tick.stamp for tick in seen] == pytest.approx([0.0, period, 2 * period])
    assert chair.holds == pytest.approx([1.5 * period] * 3)


@pytest.mark.hazard("The loop is not as fast as the supervisor thinks", "refused before anything moves")
@pytest.mark.parametrize("period", [0.05, 0.2])
def test_an_assistant_made_for_another_period_is_refused_before_anything_moves(period: float) -> None:
    chair = Wheels(replace(CHAIR, period=period))
    with pytest.raises(ValueError, match=rf"whose period is 0\.1, but it is {period}"):
        drive(chair, Unassisted(CHAIR), ticks(1), clock=SimulatedClock())
    assert chair.calls == []


def test_a_chair_whose_driver_is_heard_once_in_two_seconds_is_not_driven() -> None:
    chair = Wheels(replace(CHAIR, period=2.0))
    with pytest.raises(ValueError, match=r"period is 2\.0 s, must be at most 1\.0 s"):
        drive(chair, Unassisted(chair.geometry), ticks(1), clock=SimulatedClock())
    assert chair.calls == []


def test_by_the_wall_clock_no_tick_comes_before_it_is_due() -> None:
    seen = ticks(3)
    quick = replace(CHAIR, period=0.02)
    drive(Wheels(quick), Unassisted(quick), seen)
    assert all(tick.stamp >= 0.02 * number for number, tick in enumerate(seen))
    clock = WallClock()
    assert 0 <= clock.wait_until(-1.0) < clock.wait_until(0.01)


@pytest.mark.parametrize("says", [float("nan"), float("inf")])
def test_a_clock_that_says_no_time_ends_the_drive_and_stops_the_chair(says: float) -> None:
    class Broken(SimulatedClock):
        def wait_until(self, due: float) -> float:
            return due if due < 0.25 else says

    chair = Wheels()
    with pytest.raises(ValueError, match="the clock says"):
        drive(chair, Unassisted(CHAIR), ticks(100), clock=Broken())
    assert chair.calls[-1][0] == "stop"
