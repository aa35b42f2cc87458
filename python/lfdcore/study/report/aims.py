"""A figure to reach, and how it came out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Aim:
    """A figure to reach, and how it came out."""

    label: str
    wanted: str
    found: float
    digits: int
    reached: bool
    pairs: int | None = None
    """of a ratio: the pairs it is over, where those are fewer than the drivers"""

    def as_text(self) -> str:
        """The figure, and below it whether it was reached."""
        found = "-" if np.isnan(self.found) else f"{self.found:.{self.digits}f}"
        said = f"{found}\n{'reached' if self.reached else 'MISSED'}"
        return said if self.pairs is None else f"{said}\nn {self.pairs}"
