"""Commands on their way: given to the chair, but not acting yet, because of its latency."""

from __future__ import annotations

from lfdcore.geometry import Twist2

_NOTHING = 1e-9
"""[s] A command that acts no longer than this does not act."""


class PendingCommands:
    """What the chair will do before a command that is given now begins to act.

    latency: of the chair [s], as declared. holds: for how long a command acts [s], unless another one comes; then the
    chair brakes.
    """

    def __init__(self, latency: float, holds: float) -> None:
        self._latency, self._holds = latency, holds
        self.reset()

    def reset(self) -> None:
        """Nothing was given yet."""
        self._given: list[tuple[float, Twist2]] = []

    def give(self, stamp: float, twist: Twist2) -> None:
        """A command [m/s, rad/s] was given at `stamp` [s]."""
        begin, stop = stamp + self._latency, Twist2()
        last_begin, last = self._given[-1] if self._given else (begin, stop)
        if last != stop and begin > last_begin + self._holds + _NOTHING:
            self._given.append((last_begin + self._holds, stop))
        self._given.append((begin, twist))

    def at(self, stamp: float) -> list[tuple[Twist2, float]]:
        """(twist, duration [s]) in the order in which they act from `stamp` [s] on, until a command given now does."""
        self.give(stamp, Twist2())
        begun = [k for k, (begin, _) in enumerate(self._given) if begin <= stamp + _NOTHING]
        self._given = self._given[begun[-1] if begun else 0 :]
        ends = [begin for begin, _ in self._given[1:]]
        spans = [(twist, end - max(begin, stamp)) for (begin, twist), end in zip(self._given, ends, strict=False)]
        self._given.pop()
        return [(twist, duration) for twist, duration in spans if duration > _NOTHING]
