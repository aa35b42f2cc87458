"""A figure to reach, and how it came out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nan
from typing import Any, Self

from lfdcore.study.report.cells import figure_cell
from lfdcore.study.report.table import Table


@dataclass(frozen=True)
class Aim:
    """A figure to reach, and how it came out."""

    label: str
    wanted: str
    found: float
    digits: int
    reached: bool
    low: float = nan
    """of the figure's 95 % interval; NaN: none is shown"""
    high: float = nan
    note: str = ""
    """shown below, e.g. how many pairs a ratio is over"""

    @classmethod
    def at_least(cls, bound: float, label: str, found: float, digits: int, **more: Any) -> Self:
        """Reached from `bound` on; more: low, high, note."""
        return cls.between(bound, inf, label, found, digits, **more)

    @classmethod
    def at_most(cls, bound: float, label: str, found: float, digits: int, **more: Any) -> Self:
        """Reached up to `bound`; more: low, high, note."""
        return cls.between(-inf, bound, label, found, digits, **more)

    @classmethod
    def between(cls, least: float, most: float, label: str, found: float, digits: int, **more: Any) -> Self:
        """Reached from `least` to `most`, of which one may be infinite; more: low, high, note."""
        bounds = f"{least:g} - {most:g}" if least < most else f"{least:g}"
        wanted = f"<= {most:g}" if least == -inf else f">= {least:g}" if most == inf else bounds
        return cls(label, wanted, found, digits, bool(least <= found <= most), **more)

    def as_text(self) -> str:
        """The figure, and below it whether it was reached, its interval and the note."""
        figure, *interval = figure_cell(self.found, self.low, self.high, digits=self.digits).split("\n")
        lines = [figure, "reached" if self.reached else "MISSED", *interval, self.note]
        return "\n".join(line for line in lines if line)

    def as_row(self) -> dict[str, object]:
        """For machines."""
        figure = {"figure": self.label, "wanted": self.wanted, "found": self.found}
        return figure | {"low": self.low, "high": self.high, "reached": self.reached, "note": self.note}


def reached_of(aims: Sequence[Aim]) -> str:
    """How many were reached, and the names of those that were not, as a sentence."""
    missed = "".join(f"; MISSED: {aim.label}" for aim in aims if not aim.reached)
    return f"Figures to reach: {sum(aim.reached for aim in aims)} of {len(aims)} reached{missed}."


def aims_table(title: str, aims: Sequence[Aim]) -> Table:
    """A row an aim."""
    return Table(title, ("", "wanted", "found"), tuple((aim.label, aim.wanted, aim.as_text()) for aim in aims))
