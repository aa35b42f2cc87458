"""Stamps of a stream that were not written in their order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LATE = 1.0
"""[s] by which a record may be late ..."""
FEW = 0.01
"""... and the share of records that may be later, which are left out; else the clock was set back."""


@dataclass(frozen=True)
class Order:
    """The records of a stream that are kept, in the order of their stamps."""

    kept: NDArray[np.intp]
    """(K,) indices into the stream"""
    late: int
    """of them, how many came after one of a later stamp"""
    left_out: int
    """too late to tell them from a clock that was set back"""

    def noted(self) -> str:
        """For people; empty where there is nothing to tell."""
        parts = [f"{self.late} sorted"] * (self.late > 0) + [f"{self.left_out} left out"] * (self.left_out > 0)
        return ", ".join(parts)


def in_order(stream: str, stamps: NDArray[np.float64]) -> Order:
    """Sorts stamps (N,) [s], those that are equal as they came. ValueError for a clock that was set back: more than a
    hundredth of the records (and more than one) are more than a second behind one before."""
    behind = np.maximum.accumulate(stamps) - stamps if len(stamps) else stamps
    on_time = behind <= LATE
    left_out = int((~on_time).sum())
    if left_out > max(1, FEW * len(stamps)):
        at = int(np.argmax(~on_time))
        raise ValueError(
            f"the clock of {stream} was set back by {behind[at]:.6g} s at its record {at} (at {stamps[at]:.6f} s): cut "
            "the log there"
        )
    kept = np.flatnonzero(on_time)
    late = int((behind[kept] > 0).sum())
    return Order(kept[np.argsort(stamps[kept], kind="stable")], late, left_out)
