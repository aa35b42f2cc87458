"""The figures of two runs of a study side by side: paired where their seeds agree."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lfdcore.errors import DataError
from lfdcore.study.report.cells import figure_cell, p_cell, summary_cell
from lfdcore.study.report.statistics import paired_test, summarise
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import FIGURES

Key = tuple[object, ...]
SEED = "seed"
"""the column that says which repetition a row is of"""
DIGITS = 3


@dataclass(frozen=True)
class Comparison:
    """One figure of one thing in both runs."""

    about: Mapping[str, object]
    """what the rows are about: keys and their values, without the seed"""
    figure: str
    """name of the column"""
    first: Sequence[float]
    """a value a repetition"""
    second: Sequence[float]
    paired: bool
    """whether both have the same seeds, in the same order"""

    @property
    def difference(self) -> tuple[float, float, float]:
        """second - first with its 95 % interval (Student's, of paired differences); NaN where there is none"""
        if not self.paired:
            return float(np.mean(self.second) - np.mean(self.first)), float("nan"), float("nan")
        s = summarise(np.subtract(self.second, self.first))
        return s.mean, s.low, s.high

    @property
    def p(self) -> float:
        """Wilcoxon's, of paired repetitions; NaN for fewer than two"""
        return paired_test(self.first, self.second).p if self.paired else float("nan")


def read_document(path: Path) -> dict[str, Any]:
    """The figures.json of a report, of its folder or given itself. DataError for what holds no study's figures."""
    file = path / FIGURES if path.is_dir() else path.parent / FIGURES if path.suffix == ".html" else path
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError) as broken:
        raise DataError(f"{file}: holds no JSON: {broken}") from broken
    needed = {"study", "keys", "rows", "command"}
    if not isinstance(document, dict) or needed - document.keys():
        raise DataError(f"{file}: holds no figures of a study, which have {', '.join(sorted(needed))}")
    return document


def compare(first: dict[str, Any], second: dict[str, Any]) -> list[Comparison]:
    """Figures that both have. ValueError for runs of different studies, or without a figure in common."""
    if first["study"] != second["study"]:
        raise ValueError(f"the reports are of study {first['study']} and of study {second['study']}, must be of one")
    a, b = _figures(first), _figures(second)
    paired = all(SEED in document["keys"] for document in (first, second))
    found = [_comparison(key, a[key], b[key], paired) for key in a if key in b]
    if not found:
        raise ValueError(f"the two reports of study {first['study']} have no figure in common")
    return found


def _figures(document: dict[str, Any]) -> dict[Key, dict[object, float]]:
    """(what it is about, figure) -> seed -> value; of a study that has rows for single repetitions, those alone."""
    keys, rows = document["keys"], document["rows"]
    single = [row for row in rows if row.get(SEED) is not None] if SEED in keys else []
    found: dict[Key, dict[object, float]] = {}
    for number, row in enumerate(single or rows):
        about = tuple((name, row[name]) for name in keys if name in row and name != SEED)
        for name, value in row.items():
            if name not in keys and not _beside(name) and isinstance(value, int | float):
                values = found.setdefault((about, name), {})
                values[row[SEED] if single else number] = float(value)
    return found


def _beside(name: str) -> bool:
    """Whether a column stands beside a figure: an interval's end, a count, a verdict."""
    return name.rsplit("_", 1)[-1] in ("low", "high", "n", "missing", "reached")


def _comparison(key: Key, first: dict[object, float], second: dict[object, float], paired: bool) -> Comparison:
    about, figure = key
    common = [seed for seed in first if seed in second] if paired else []
    of_both = [[values[seed] for seed in common] for values in (first, second)]
    a, b = of_both if common else (list(first.values()), list(second.values()))
    return Comparison(dict(about), str(figure), a, b, bool(common))  # type: ignore[call-overload]


def comparison_table(first: dict[str, Any], second: dict[str, Any]) -> Table:
    """A row a figure that differs; what is the same in both is counted below."""
    every = compare(first, second)
    shown = [one for one in every if list(one.first) != list(one.second)]
    return Table(
        f"Study {first['study']}, two runs side by side",
        ("", "first", "second", "second - first", "p"),
        tuple(_row(one) for one in shown),
        f"First: `{first['command']}`; second: `{second['command']}`. {len(every) - len(shown)} of {len(every)} "
        "figures are equal and not shown. Means+-sd over seeds; differences with the 95 % interval and p "
        "(Wilcoxon's signed rank) over the seeds that both have.",
    )


def _row(one: Comparison) -> Row:
    named = ((name, value) for name, value in one.about.items() if value is not None)
    what = ", ".join(value if isinstance(value, str) else f"{name} {value}" for name, value in named)
    figures = (figure_cell(*one.difference, digits=DIGITS), p_cell(one.p))
    return (
        f"{what}\n{one.figure}",
        *(summary_cell(summarise(values), DIGITS) for values in (one.first, one.second)),
        *figures,
    )
