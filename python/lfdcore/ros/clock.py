"""The time of a drive by a node's clock, which may be a simulator's: it may be slow, stand still or be set back."""

from __future__ import annotations

import time
from collections.abc import Callable

from lfdcore.wheelchair.drive_loop import TOLERANCE

STANDSTILL = 0.5
"""[s] of wall time for which a clock says the same, after which it stands still"""
SLICE = 0.02
"""[s] of wall time after which a wait looks again"""


class RosClock:
    """Time passes as the node's clock says. 0 is when this is made.

    now: the node's clock [ns]. period: of the chair [s]. require_alive: raises where nothing comes in any more.
    """

    def __init__(self, now: Callable[[], int], period: float, require_alive: Callable[[], None]) -> None:
        self._now = now
        self._period = period
        self._require_alive = require_alive
        self._epoch = now()
        self._last = 0.0

    def time_of(self, stamp: int) -> float:
        """A stamp of the node's clock [ns] as the drive's time [s]."""
        return (stamp - self._epoch) / 1e9

    def wait_until(self, due: float) -> float:
        """Waits until `due` [s], but no longer than a period after the last time: what the clock stood still is not
        made up for -> the time then. A clock that was set back: at once, with the time that it says. One that stands
        still: after STANDSTILL, with the same time as before."""
        due = min(due, self._last + self._period) - TOLERANCE
        now, changed = self._looked_at(), time.monotonic()
        while self._last <= now < due:
            if time.monotonic() - changed >= STANDSTILL:
                return self._last
            time.sleep(min(SLICE, max(due - now, 0.001)))
            before, now = now, self._looked_at()
            changed = changed if now == before else time.monotonic()
        self._last = now
        return now

    def _looked_at(self) -> float:
        self._require_alive()
        return self.time_of(self._now())
