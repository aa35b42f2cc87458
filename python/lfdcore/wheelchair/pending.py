"""Commands on their way: given to the chair, but not acting yet, because of its latency."""

from __future__ import annotations

from lfdcore.geometry import Twist2

_NOTHING = 1e-9
"""[s] A command that acts no longer than this does not act."""


class PendingCommands:
    """What the chair will do before a command that is given now begins to act.

    latency: of the chair [s], as declared.
    """

    def __init__(self, latency: float) -> None:
        self._latency = latency
        self.reset()

    def reset(self) -> None:
        """Nothing was given yet."""
        self._given: list[tuple[float, Twist2]] = []

    def give(self, stamp: float, twist: Twist2) -> None:
        """A command [m/s, rad/s] was given at `stamp` [s]."""
        self._given.append((stamp + self._latency, twist))

    def at(self, stamp: float) -> list[tuple[Twist2, float]]:
        """(twist, duration [s]) in the order in which they act from `stamp` [s] on, until a command given now does."""
        acting = [k for k, (begin, _) in enumerate(self._given) if begin <= stamp + _NOTHING]
        self._given = self._given[acting[-1] if acting else 0 :]
        ends = [begin for begin, _ in self._given[1:]] + [stamp + self._latency]
        spans = [(twist, end - max(begin, stamp)) for (begin, twist), end in zip(self._given, ends, strict=False)]
        return [(twist, duration) for twist, duration in spans if duration > _NOTHING]
