"""The one place where commands leave: each holds for so long, then 0 is sent, whatever became of the loop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from lfdcore.geometry import Twist2
from lfdcore.ros.clock import STANDSTILL

STOP = Twist2(0.0, 0.0)
CHECKED_EVERY = 0.01
"""[s] of wall time between two looks at whether the command still holds"""


class CommandOutlet:
    """Sends commands. A thread of its own sends 0 in the place of one that has held for its duration, and again each
    duration until the next one.

    A duration is counted by the node's clock and, unless that is a simulator's, by wall time too. A clock that is set
    back or stands still for STANDSTILL ends a command as well. The thread needs Python's lock: C++ lets go of it while
    it works; a process that is stopped or killed sends nothing.

    send: publishes a twist. now: the node's clock [ns]. is_simulated: whether that is a simulator's.
    """

    def __init__(
        self, send: Callable[[Twist2], None], now: Callable[[], int], is_simulated: Callable[[], bool]
    ) -> None:
        self._send, self._now, self._is_simulated = send, now, is_simulated
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._sent: Twist2 | None = None
        self._duration = 0.0
        self._thread = threading.Thread(target=self._watch, name="command outlet", daemon=True)
        self._thread.start()

    @property
    def sent(self) -> Twist2 | None:
        """What was sent last [m/s, rad/s]; None: nothing yet."""
        return self._sent

    def command(self, twist: Twist2, duration: float) -> None:
        """Sends `twist` [m/s, rad/s], which holds for `duration` [s]. RuntimeError after the stop, and where nobody
        watches that."""
        with self._lock:
            if self._ended.is_set() or not self._thread.is_alive():
                raise RuntimeError("no command is sent: commands were stopped, or the thread that ends them has died")
            self._give(twist, duration)

    def stop(self) -> None:
        """Sends 0. No other command is sent after that. May be called again."""
        with self._lock:
            self._send(STOP)
            self._sent = STOP
            self._ended.set()

    def _give(self, twist: Twist2, duration: float) -> None:
        self._send(twist)
        self._sent, self._duration = twist, duration
        self._given = self._seen = self._now()
        self._given_wall = self._seen_wall = time.monotonic()

    def _watch(self) -> None:
        while not self._ended.wait(CHECKED_EVERY):
            with self._lock:
                if self._sent is not None and not self._ended.is_set() and self._is_over():
                    self._give(STOP, self._duration)

    def _is_over(self) -> bool:
        now, wall = self._now(), time.monotonic()
        if now != self._seen:
            self._seen, self._seen_wall = now, wall
        if not 0 <= now - self._given < self._duration * 1e9 or wall - self._seen_wall >= STANDSTILL:
            return True
        return not self._is_simulated() and wall - self._given_wall >= self._duration
