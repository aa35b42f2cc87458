"""Whatever time a chair states between two commands, its supervisor keeps it from what a scan had shown."""

import pytest

from lfdcore.control import CommandTiming
from lfdcore.simulated.chair import SimulatedChair
from lfdcore.simulated.courses import home
from lfdcore.simulated.run import RunConfig
from lfdcore.study.safety.hostile_run import HostileCounts, RunCount, hostile
from lfdcore.study.safety.standing import Standing
from lfdcore.wheelchair import assistants
from lfdcore.wheelchair.assistants import Supervised
from lfdcore.wheelchair.drive_loop import SimulatedClock, drive

SECONDS = 60.0


def driven(period: float, kind: str, seed: int) -> HostileCounts:
    """A minute in the home, from its start."""
    course, run = home(), RunConfig(period=period)
    stick = hostile(kind, course, seed)
    chair = SimulatedChair(course, stick, seed, run.chair, run.lidar, period=run.period)
    count = RunCount(chair, Standing(course.grid, run), SECONDS)
    drive(chair, Supervised(run.geometry), count, clock=SimulatedClock())
    return count.result()


@pytest.mark.hazard(
    "The loop is not as fast as the supervisor thinks",
    "from .05 to .5 s a command, nothing that was shown is met at more than .05 m/s",
)
@pytest.mark.parametrize("kind", ["random", "held"])
@pytest.mark.parametrize("period", [0.05, 0.1, 0.2, 0.5])
def test_at_any_period_nothing_is_touched_at_speed_that_a_scan_had_shown(period: float, kind: str) -> None:
    """The corner of a thing may stick out 2 cm beyond the mean of the beams that ended on it: so, at a creep."""
    counts = [driven(period, kind, seed) for seed in (1, 2, 3)]
    assert [one.contact_speed if one.collisions else 0 for one in counts] == pytest.approx([0, 0, 0], abs=0.05)
    assert sum(one.distance for one in counts) > 10


def test_a_supervisor_that_takes_the_chair_for_a_quicker_one_touches_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the test above would say nothing."""
    monkeypatch.setattr(assistants, "CommandTiming", lambda **_: CommandTiming(period=0.1, jitter=0.05))
    assert max(driven(0.5, "random", seed).contact_speed for seed in (1, 2, 3)) > 0.3
