"""What study learning-curve finds: all runs, and points of a curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lfdcore.study.learning_curve.study import METHODS, NOBODY, LearningCurveStudy
from lfdcore.study.prediction.study import ARC_ON, STRAIGHT
from lfdcore.study.report.statistics import Summary, poisson_rate, proportion, summarise


@dataclass(frozen=True)
class CurvePoint:
    """What a method is worth after so many runs (0: unassisted)."""

    demonstrations: int
    method: str
    completed: tuple[int, int]
    """runs that arrived, of how many"""
    contacts: int
    path_rmse: Summary
    """[m] over drivers: of path points that complied against the way driven (study/driving/metrics.py)"""
    jerk_ratio: Summary
    """angular jerk over the same driver's unassisted run, over drivers who completed both"""
    time_ratio: Summary
    """time taken, likewise"""
    path_error: Summary
    """[m] over runs: mean error up to 2.5 m of the predicted path"""

    @property
    def contact_rate(self) -> tuple[float, float, float]:
        """Contacts a run, with Garwood's interval."""
        return poisson_rate(self.contacts, self.completed[1])

    @property
    def completion(self) -> tuple[float, float, float]:
        """Share of runs that arrived, with Wilson's interval."""
        return proportion(*self.completed)


@dataclass(frozen=True)
class LearningCurve:
    """All runs, and what is made of them."""

    study: LearningCurveStudy
    rows: tuple[dict[str, Any], ...]
    """one a run, as closed_loop_rows"""
    errors: tuple[dict[str, Any], ...]
    """one a log and model or baseline, as prediction_rows"""

    def points(self) -> list[CurvePoint]:
        """Unassisted, then each method by the number of runs."""
        return [self._point(0, NOBODY), *(self._point(n, m) for m in METHODS for n in self.study.runs)]

    def baseline(self) -> tuple[str, Summary]:
        """The better of straight on and a constant arc, and its error [m] over runs."""
        found = {name: self._errors_of(0, name) for name in (STRAIGHT, ARC_ON)}
        return min(found.items(), key=lambda item: item[1].mean)

    def _errors_of(self, demonstrations: int, method: str) -> Summary:
        wanted = (demonstrations, method)
        return summarise([e["error"] for e in self.errors if (e["demonstrations"], e["method"]) == wanted])

    def _of(self, demonstrations: int, method: str) -> list[dict[str, Any]]:
        wanted = (demonstrations, method)
        return [row for row in self.rows if (row["demonstrations"], row["assistant"]) == wanted]

    def _point(self, demonstrations: int, method: str) -> CurvePoint:
        rows, alone = self._of(demonstrations, method), self._of(0, NOBODY)
        both = [(a, b) for a, b in zip(alone, rows, strict=True) if a["completed"] and b["completed"]]
        return CurvePoint(
            demonstrations,
            method,
            (sum(row["completed"] for row in rows), len(rows)),
            sum(row["collisions"] for row in rows),
            summarise([row.get("path_rmse", np.nan) for row in rows]),
            summarise([b["angular_jerk"] / a["angular_jerk"] for a, b in both]),
            summarise([b["time"] / a["time"] for a, b in both]),
            self._errors_of(demonstrations, method),
        )
