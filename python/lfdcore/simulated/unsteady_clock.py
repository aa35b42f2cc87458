"""The clock of a loop that does not keep time: its ticks jitter, and now and then one is late."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class TickFaults:
    """By how much ticks come after their time. ValueError names a field out of range."""

    jitter: float = 0.0
    """[s] at the most, for each tick, drawn evenly"""
    late: float = 0.0
    """[s] more, for those that are late ..."""
    late_share: float = 0.0
    """... which is this share of them"""

    def __post_init__(self) -> None:
        for name in ("jitter", "late"):
            if not 0 <= getattr(self, name) <= 10:
                raise ValueError(f"{name} is {getattr(self, name)} s, must lie in [0, 10]")
        if not 0 <= self.late_share <= 1:
            raise ValueError(f"late_share is {self.late_share}, must be a share in [0, 1]")


class UnsteadyClock:
    """A simulated Clock (wheelchair/drive_loop.py). The same faults and seed give the same ticks."""

    def __init__(self, faults: TickFaults, seed: int) -> None:
        self._faults = faults
        self._random = np.random.default_rng([seed, 0x71C])
        self._now = 0.0

    def wait_until(self, due: float) -> float:
        """-> the time [s] at which a tick that is due at `due` [s] comes"""
        late = self._faults.late if self._random.random() < self._faults.late_share else 0.0
        self._now = max(self._now, due) + float(self._random.uniform(0, self._faults.jitter)) + late
        return self._now
