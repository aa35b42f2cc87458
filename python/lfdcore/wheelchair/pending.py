"""Commands on their way: given to the chair, but not acting yet, because of its latency."""

from __future__ import annotations

from lfdcore.geometry import Twist2

_KEPT = 1.0
"""[s] Odometry is no older than this."""
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
        """A command [m/s, rad/s] was given at `stamp` [s], in the place of one that was given then already."""
        self._forget(stamp - _KEPT)
        begin, stop = stamp + self._latency, Twist2()
        self._given = [one for one in self._given if one[0] < begin - _NOTHING]
        last_begin, last = self._given[-1] if self._given else (begin, stop)
        if last != stop and begin > last_begin + self._holds + _NOTHING:
            self._given.append((last_begin + self._holds, stop))
        self._given.append((begin, twist))

    def at(self, stamp: float, since: float | None = None) -> list[tuple[Twist2, float]]:
        """(twist, duration [s]) in the order in which they act from `since` [s] (`stamp` unless given) on, until a
        command that is given at `stamp` does."""
        since = stamp if since is None else since
        self.give(stamp, Twist2())
        ends = [begin for begin, _ in self._given[1:]]
        spans = [(twist, end - max(begin, since)) for (begin, twist), end in zip(self._given, ends, strict=False)]
        self._given.pop()
        return [(twist, duration) for twist, duration in spans if duration > _NOTHING]

    def _forget(self, before: float) -> None:
        begun = [k for k, (begin, _) in enumerate(self._given) if begin <= before]
        self._given = self._given[begun[-1] if begun else 0 :]
