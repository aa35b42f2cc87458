"""Which commands act before the one that is given now."""

import pytest

from lfdcore.geometry import Twist2
from lfdcore.wheelchair.pending import PendingCommands


def given(latency: float, at: list[float], holds: float = 0.15) -> PendingCommands:
    """Commands of 1, 2, .. m/s."""
    pending = PendingCommands(latency, holds)
    for k, stamp in enumerate(at):
        pending.at(stamp)
        pending.give(stamp, Twist2(k + 1.0, 0.0))
    return pending


def said(pending: PendingCommands, stamp: float) -> list[tuple[float, float]]:
    return [(twist.linear, pytest.approx(duration)) for twist, duration in pending.at(stamp)]


def test_without_latency_a_command_acts_at_once() -> None:
    assert given(0.0, [0.0, 0.1]).at(0.2) == []


def test_all_that_was_given_within_the_latency_comes_first() -> None:
    assert said(given(0.3, [0.0, 0.1, 0.2, 0.3, 0.4]), 0.5) == [(3.0, 0.1), (4.0, 0.1), (5.0, 0.1)]


def test_what_acts_now_goes_on_until_the_next_does() -> None:
    assert said(given(0.15, [0.0, 0.1, 0.2]), 0.3) == [(2.0, 0.05), (3.0, 0.1)]


def test_after_a_late_tick_the_chair_has_braked() -> None:
    """The command of 0 s acts from .3 to .45 s, that of .4 s from .7 s on."""
    assert said(given(0.3, [0.0]), 0.4) == [(1.0, 0.05), (0.0, 0.25)]
    assert said(given(0.3, [0.0, 0.4]), 0.5) == [(0.0, 0.2), (2.0, 0.1)]
    assert said(given(0.1, [0.0]), 0.5) == [(0.0, 0.1)]


def test_the_durations_add_up_to_the_latency_once_it_has_passed() -> None:
    pending = given(0.25, [0.0, 0.07, 0.2, 0.21, 0.34])
    assert sum(duration for _, duration in pending.at(0.4)) == pytest.approx(0.25)


def test_what_acted_since_old_odometry_comes_first() -> None:
    """Odometry is of .25 s: the commands of .0, .1 and .2 s act from .2, .3 and .4 s on."""
    pending = given(0.2, [0.0, 0.1, 0.2])
    said_since = [(twist.linear, duration) for twist, duration in pending.at(0.3, since=0.25)]
    assert said_since == [(1.0, pytest.approx(0.05)), (2.0, pytest.approx(0.1)), (3.0, pytest.approx(0.1))]


def test_a_command_takes_the_place_of_one_given_at_the_same_time() -> None:
    pending = given(0.2, [0.0, 0.1])
    pending.give(0.1, Twist2(9.0, 0.0))
    assert said(pending, 0.2) == [(1.0, 0.1), (9.0, 0.1)]


def test_what_is_long_over_is_forgotten() -> None:
    pending = PendingCommands(0.1, 0.15)
    for k in range(1000):
        pending.give(0.1 * k, Twist2(1.0, 0.0))
    assert len(pending._given) < 20


def test_a_reset_forgets() -> None:
    pending = given(0.3, [0.0])
    pending.reset()
    assert pending.at(0.1) == []
