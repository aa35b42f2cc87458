"""The drive's time by a clock that may misbehave, and commands that end by themselves."""

import math
import threading
import time

import numpy as np
import pytest

from lfdcore.geometry import Twist2
from lfdcore.ros.clock import STANDSTILL, RosClock
from lfdcore.ros.command_outlet import STOP, CommandOutlet
from lfdcore.wheelchair.drive_loop import TOLERANCE

PERIOD = 0.1
HELD = 0.15
SPARE = 0.5
"""[s] that a loaded machine may take longer"""


class Hands:
    """A clock [ns] that goes at a rate, from where it is set."""

    def __init__(self, rate: float = 1.0) -> None:
        self.set(1000.0, rate)

    def set(self, at: float, rate: float) -> None:
        self._at, self._rate, self._wall = at, rate, time.monotonic()

    def now(self) -> int:
        return round((self._at + self._rate * (time.monotonic() - self._wall)) * 1e9)


def clock(hands: Hands) -> RosClock:
    return RosClock(hands.now, PERIOD, lambda: None)


@pytest.mark.parametrize("rate", [0.5, 1.0, 4.0])
def test_a_wait_ends_at_its_time_by_the_nodes_clock(rate: float) -> None:
    told, begin = clock(Hands(rate)), time.monotonic()
    assert 0 <= told.wait_until(0.0) < SPARE
    last = told.wait_until(0.1)
    assert last >= 0.1
    assert time.monotonic() - begin >= 0.1 / rate - 1e-3


def test_every_step_of_a_clock_that_goes_in_periods_is_a_tick() -> None:
    stepped = [1000 * 10**9]

    def step(*_: object) -> None:
        stepped[0] += 10**8

    told, stamps, number = RosClock(lambda: stepped[0], PERIOD, step), [], 0
    for _ in range(50):
        stamps.append(told.wait_until(number * PERIOD))
        number = max(number + 1, math.floor((stamps[-1] + TOLERANCE) / PERIOD) + 1)
    np.testing.assert_allclose(np.diff(stamps), PERIOD, atol=1e-9)


def test_a_clock_that_stands_still_says_the_same_again_and_is_not_made_up_for() -> None:
    hands = Hands(0.0)
    told, begin = clock(hands), time.monotonic()
    stamps = [told.wait_until(due) for due in (0.0, 0.1, 0.2)]
    assert stamps == [0.0, 0.0, 0.0]
    assert time.monotonic() - begin >= 2 * STANDSTILL
    hands.set(1000.0, 1.0)
    assert PERIOD <= told.wait_until(0.3) < 0.3  # a period on, not three


def test_a_clock_that_was_set_back_is_told_at_once_and_goes_on_from_there() -> None:
    hands = Hands()
    told = clock(hands)
    told.wait_until(0.0)
    told.wait_until(0.1)
    hands.set(995.0, 1.0)
    back = told.wait_until(0.2)
    assert -5.01 <= back < -5.0 + SPARE
    assert back + PERIOD <= told.wait_until(0.3) < back + PERIOD + SPARE


def test_a_wait_ends_with_the_error_of_what_no_longer_takes_in_messages() -> None:
    def dead() -> None:
        raise RuntimeError("no messages are taken in any more")

    told = RosClock(Hands(0.0).now, PERIOD, dead)
    with pytest.raises(RuntimeError, match="no messages"):
        told.wait_until(0.1)


class Sent:
    """What left, and when; a condition to wait on."""

    def __init__(self) -> None:
        self.came = threading.Condition()
        self.log: list[tuple[float, Twist2]] = []

    def __call__(self, twist: Twist2) -> None:
        with self.came:
            self.log.append((time.monotonic(), twist))
            self.came.notify_all()

    def wait_for(self, count: int) -> list[tuple[float, Twist2]]:
        with self.came:
            assert self.came.wait_for(lambda: len(self.log) >= count, timeout=10)
            return list(self.log)


AHEAD = Twist2(0.5, 0.1)


@pytest.mark.parametrize(
    ("rate", "simulated", "ends"),
    [
        (1.0, False, HELD),
        (0.5, True, 2 * HELD),
        (0.0, True, STANDSTILL),
        (-1.0, True, 0.0),
        (0.0, False, HELD),  # a system's clock that stands still does not let a command hold for longer
        (4.0, True, HELD / 4),
    ],
)
@pytest.mark.hazard("The loop is late", "0 is sent once a command has held for its time, by any clock")
def test_a_command_ends_by_itself(rate: float, simulated: bool, ends: float) -> None:
    sent, hands = Sent(), Hands()
    outlet = CommandOutlet(sent, hands.now, lambda: simulated)
    hands.set(2000.0, rate)
    outlet.command(AHEAD, HELD)
    (begin, first), (end, second), (_, third) = sent.wait_for(3)
    outlet.stop()
    assert (first, second, third) == (AHEAD, STOP, STOP)
    assert ends - 0.02 <= end - begin < ends + SPARE


def test_commands_that_come_in_time_are_all_that_is_sent() -> None:
    sent = Sent()
    outlet = CommandOutlet(sent, Hands().now, lambda: False)
    assert outlet.sent is None
    for _ in range(5):
        outlet.command(AHEAD, 30.0)
    assert outlet.sent == AHEAD
    outlet.stop()
    assert outlet.sent == STOP
    assert [twist for _, twist in sent.log] == [AHEAD] * 5 + [STOP]


def test_nothing_is_sent_after_the_stop() -> None:
    sent = Sent()
    outlet = CommandOutlet(sent, Hands().now, lambda: False)
    outlet.command(AHEAD, 0.05)
    outlet.stop()
    assert sent.log[-1][1] == STOP
    count = len(sent.log)
    with pytest.raises(RuntimeError, match="no command is sent"):
        outlet.command(AHEAD, HELD)
    assert len(sent.log) == count


def test_without_the_thread_that_ends_commands_none_is_sent() -> None:
    def broken(_: Twist2) -> None:
        raise OSError("no more memory")

    outlet = CommandOutlet(lambda _: None, Hands().now, lambda: False)
    outlet.command(AHEAD, 0.05)
    outlet._send = broken
    died = threading.Event()
    threading.excepthook, before = lambda _: died.set(), threading.excepthook
    try:
        assert died.wait(10)
    finally:
        threading.excepthook = before
    with pytest.raises(RuntimeError, match="the thread that ends them has died"):
        outlet.command(AHEAD, HELD)
