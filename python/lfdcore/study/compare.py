"""The figures of two runs of a study side by side: paired where their seeds agree."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import floor, isfinite, log10
from pathlib import Path
from typing import Any

import numpy as np

from lfdcore.errors import DataError
from lfdcore.study.report.cells import figure_cell, p_cell, summary_cell
from lfdcore.study.report.statistics import paired_test, summarise
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import FIGURES

Key = tuple[tuple[tuple[str, object], ...], str]
"""what a row is about, and the name of a figure"""
SEED = "seed"
"""the column that says which repetition a row is of"""
FORM = {"study": str, "command": str, "lfdcore": str, "keys": list, "rows": list}
"""what a study's document holds, at least"""
DIGITS = 3
"""significant ones, of the smaller of a figure and its change"""


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
    seeds: Sequence[int]
    """that both have, in the order of the values; none: the runs are not paired"""

    @property
    def paired(self) -> bool:
        """Whether the values of both are of the same seeds."""
        return bool(self.seeds)

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
    if not isinstance(document, dict) or not all(isinstance(document.get(name), one) for name, one in FORM.items()):
        raise DataError(f"{file}: holds no figures of a study, which have {', '.join(FORM)}")
    for number, row in enumerate(document["rows"]):
        if not isinstance(row, dict) or any(isinstance(row.get(name), list | dict) for name in document["keys"]):
            raise DataError(f"{file}: row {number} is no row of figures: {json.dumps(row)[:80]}")
    return document


def compare(first: dict[str, Any], second: dict[str, Any]) -> list[Comparison]:
    """Figures that both have. ValueError for runs of different studies, or without a figure in common."""
    if first["study"] != second["study"]:
        raise ValueError(f"the reports are of study {first['study']} and of study {second['study']}, must be of one")
    a, b = _figures(first), _figures(second)
    found = [_comparison(key, a[key], b[key]) for key in a if key in b]
    if not found:
        raise ValueError(f"the two reports of study {first['study']} have no figure in common")
    return found


def _figures(document: dict[str, Any]) -> dict[Key, dict[int | None, float]]:
    """Figures by seed; None: of a row that is about no single repetition, which counts only where there is none that
    is. ValueError for two rows that the keys do not tell apart."""
    found: dict[Key, dict[int | None, float]] = {}
    for row in document["rows"]:
        about = tuple((name, row[name]) for name in document["keys"] if row.get(name) is not None and name != SEED)
        seed = row.get(SEED) if SEED in document["keys"] else None
        for name in _figure_names(document, row):
            values = found.setdefault((about, name), {})
            if seed in values:
                raise ValueError(f"two rows of study {document['study']} are about {dict(about)}, seed {seed}")
            values[seed] = float(row[name])
    return {key: _repetitions(values) for key, values in found.items()}


def _figure_names(document: dict[str, Any], row: Mapping[str, object]) -> list[str]:
    """Of a row's columns those that are figures: not keys, nor what stands beside a figure (`_beside`)."""
    about = {SEED, *document["keys"]}
    return [name for name, value in row.items() if name not in about and not _beside(name) and _number(value)]


def _number(value: object) -> bool:
    """Also true and false, whose mean is a share."""
    return isinstance(value, int | float)


def _beside(name: str) -> bool:
    """Whether a column stands beside a figure: an interval's end, a count, what is wanted, a verdict."""
    return name.rsplit("_", 1)[-1] in ("low", "high", "n", "missing", "wanted", "reached")


def _repetitions(values: dict[int | None, float]) -> dict[int | None, float]:
    return {seed: value for seed, value in values.items() if seed is not None} or values


def _comparison(key: Key, first: dict[int | None, float], second: dict[int | None, float]) -> Comparison:
    about, figure = key
    seeds = [seed for seed in first if seed is not None and seed in second]
    a, b = ([values[seed] for seed in seeds or values] for values in (first, second))
    return Comparison(dict(about), figure, a, b, seeds)


def comparison_table(first: dict[str, Any], second: dict[str, Any]) -> Table:
    """A row a figure that differs; what is the same in both, or in one alone, is counted below."""
    every = compare(first, second)
    shown = [one for one in every if list(one.first) != list(one.second)]
    alone = len(_figures(first).keys() ^ _figures(second).keys())
    counted = f"{len(every) - len(shown)} of {len(every)} figures are equal and not shown."
    return Table(
        f"Study {first['study']}, two runs side by side",
        ("", "first", "second", "second - first", "n", "p"),
        tuple(_row(one) for one in shown),
        f"First: lfdcore {first['lfdcore']}, `{first['command']}`; second: lfdcore {second['lfdcore']}, "
        f"`{second['command']}`. {counted}{f' {alone} are of one run alone.' if alone else ''} Means+-sd over n seeds; "
        "differences with the 95 % interval and p (Wilcoxon's signed rank) over the seeds that both have; n of both "
        "runs and no p where they have none.",
    )


def _row(one: Comparison) -> Row:
    what = ", ".join(value if isinstance(value, str) else f"{name} {value}" for name, value in one.about.items())
    digits = _decimals(one)
    n = str(len(one.seeds)) if one.paired else f"{len(one.first)}, {len(one.second)}"
    return (
        f"{what}\n{one.figure}",
        *(summary_cell(summarise(values), digits) for values in (one.first, one.second)),
        figure_cell(*one.difference, digits=digits),
        n,
        p_cell(one.p),
    )


def _decimals(one: Comparison) -> int:
    """Enough that neither the figure nor its change is written as 0."""
    sizes = [abs(x) for x in (float(np.mean(one.first)), one.difference[0]) if x != 0 and isfinite(x)]
    return min(15, max(2, DIGITS - 1 - floor(log10(min(sizes))))) if sizes else 2
