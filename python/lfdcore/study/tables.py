"""Tables 3.1-3.3 beside the thesis's numbers, figures to reach, and tasks; every figure with n and an interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lfdcore.control import DynamicWindowConfig
from lfdcore.study.driving import DrivingResult
from lfdcore.study.driving_tasks import TASK_NAMES, TaskResult
from lfdcore.study.plots import arm_name
from lfdcore.study.prediction import LogPrediction, prediction_cells
from lfdcore.study.statistics import paired_proportions_test, paired_test, proportion, summarise
from lfdcore.wheelchair.assistants import DynamicWindowAssistant

WIDTH = 120
"""Columns of a terminal that a table is laid out for."""
_GAP = "  "

Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A titled table of text cells; a cell's lines are parted by newlines, the first one being its main figure."""

    title: str
    header: Row
    rows: tuple[Row, ...]
    note: str = ""

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"a row of '{self.title}' has {len(row)} cells, must have {len(self.header)}: {row}")

    def as_text(self, width: int = WIDTH) -> str:
        """Aligned for a terminal of `width` columns; columns that do not fit come below, with the first one again."""
        lines = [self.header, *self.rows]
        widths = [max(len(part) for line in lines for part in line[k].split("\n")) for k in range(len(self.header))]
        blocks = [_block(lines, widths, columns) for columns in _fitting(widths, width)]
        note = [*_wrapped(self.note, width), ""] if self.note else [""]
        return "\n".join([*_wrapped(self.title, width), *"\n\n".join(blocks).split("\n"), *note])


def _fitting(widths: Sequence[int], width: int) -> list[list[int]]:
    """Column numbers of each block: the first column and as many more as fit, at least one."""
    blocks: list[list[int]] = []
    for k in range(1, len(widths)):
        used = sum(widths[c] + len(_GAP) for c in blocks[-1]) if blocks else width
        if used + widths[k] <= width:
            blocks[-1].append(k)
        else:
            blocks.append([0, k])
    return blocks or [[0]]


def _block(lines: Sequence[Row], widths: Sequence[int], columns: Sequence[int]) -> str:
    rule = _GAP.join("-" * widths[c] for c in columns)
    head, *rows = ["\n".join(_row(line, widths, columns)) for line in lines]
    return "\n".join([head, rule, *rows])


def _row(line: Row, widths: Sequence[int], columns: Sequence[int]) -> list[str]:
    cells = [line[c].split("\n") for c in columns]
    shown = []
    for part in range(max(map(len, cells))):
        texts = [cell[part] if part < len(cell) else "" for cell in cells]
        texts = [text.rjust(widths[c]) if c else text.ljust(widths[c]) for text, c in zip(texts, columns, strict=True)]
        shown.append(_GAP.join(texts).rstrip())
    return shown


def _wrapped(text: str, width: int) -> list[str]:
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


@dataclass(frozen=True)
class Metric:
    """A row: our name, how to print it, and the thesis's figures."""

    key: str
    label: str
    digits: int
    thesis: str = ""


DRIVING = (
    Metric("angular_jerk", "angular jerk [rad/s3]", 2, "0.07+-0.03\n-> 0.03+-0.02"),
    Metric("time", "time taken [s]", 0, "166+-25\n-> 146+-16"),
    Metric("mean_free_speed", "mean free speed [m/s]", 2, "0.59+-0.07\n-> 0.67+-0.07"),
    Metric("distance", "distance travelled [m]", 0, "96+-1\n-> 97+-2"),
    Metric("steering_entropy", "steering entropy,\nown baseline", 2, "0.57+-0.02\n-> 0.55+-0.03"),
    Metric("steering_entropy_fixed", "steering entropy,\nfixed baseline", 2),
    Metric("reversals", "reversals", 1),
    Metric("stuck", "share of time stuck", 3),
    Metric("supervised", "share of commands\nsupervised", 2),
)
FRAMEWORK = (
    Metric("obedience", "user obedience", 2, "0.87+-0.11\n0.88+-0.09"),
    Metric("angular_error", "angular error\nbehind it [deg]", 0),
    Metric("path_compliance", "path compliance\n(share)", 2, "0.64+-0.33\n0.56+-0.40"),
    Metric("tracked_compliance", "... while it was\ntracked (share)", 2),
    Metric("compliant_length", "compliant length [m]", 2),
    Metric("path_rmse", "path RMSE [m]", 3, "0.04+-0.03\n0.10+-0.07"),
    Metric("path_rmse_ahead", "... of points agreed\nto, not reached [m]", 3),
    Metric("replans_per_metre", "replans per metre", 2),
)


_DEFINITIONS = (
    "The thesis does not define these to the letter; ours (study/metrics.py): path compliance counts path points that "
    "complied at any later time; compliant length reaches to the last control point that complied while its path was "
    "tracked; path RMSE is over the points passed by then, and would be the larger one with those ahead."
)


def _cell(values: Sequence[float], digits: int) -> str:
    """mean+-sd, and below it the 95 % interval of the mean."""
    s = summarise(values)
    if s.n == 0:
        return "-"
    if s.n == 1:
        return f"{s.mean:.{digits}f}"
    less = f"\nn {s.n}" if s.missing else ""
    return f"{s.mean:.{digits}f}+-{s.sd:.{digits}f}\n[{s.low:.{digits}f}, {s.high:.{digits}f}]{less}"


def _share(successes: int, n: int) -> str:
    """k of n, and below it the share with Wilson's 95 % interval."""
    share, low, high = proportion(successes, n)
    return f"{successes} of {n}\n{100 * share:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"


def _p(p: float) -> str:
    return "-" if np.isnan(p) else "<0.001" if p < 0.001 else f"{p:.3f}"


def _completed(result: DrivingResult, course: str, arm: str) -> list[bool]:
    rows = (row for row in result.rows if (row["course"], row["assistant"]) == (course, arm))
    return [row["outcome"] == "completed" for row in rows]


def _contacts(counts: Sequence[float]) -> str:
    """Total, and below it how many drivers had any."""
    return f"{int(sum(counts))}\n{sum(c > 0 for c in counts)} of {len(counts)} drivers"


def _horizon(arms: Sequence[str]) -> str:
    """What DWA's figures depend on most: its twists are held for longer than its goal lies ahead."""
    if "dwa" not in arms:
        return ""
    horizon, ahead = DynamicWindowConfig().horizon, DynamicWindowAssistant().projection
    return (
        f" DWA's horizon is {horizon:g} s and its goal the input projected {ahead:g} s ahead (Sec. 3.5), so in the "
        f"open it drives at {ahead / horizon:.0%} of the asked speed."
    )


def _against_first(arms: Sequence[str]) -> Row:
    return tuple(f"p, {arms[0]}\n/ {arm}" for arm in arms[1:])


def _driving_table(result: DrivingResult, course: str) -> Table:
    arms, study = result.study.arms, result.study
    done = [_completed(result, course, arm) for arm in arms]
    hits = [result.column(course, arm, "collisions") for arm in arms]
    ps = [_p(paired_proportions_test(done[0], other)) for other in done[1:]]
    rows: list[Row] = [("completed", *(_share(sum(d), len(d)) for d in done), *ps, "")]
    ps = [_p(paired_test(hits[0], other).p) for other in hits[1:]]
    rows.append(("collisions, total", *map(_contacts, hits), *ps, "5 -> 0"))
    for metric in DRIVING:
        columns = [result.column(course, arm, metric.key) for arm in arms]
        ps = [_p(paired_test(columns[0], other).p) for other in columns[1:]]
        rows.append((metric.label, *(_cell(column, metric.digits) for column in columns), *ps, metric.thesis))
    return Table(
        f"Driving metrics, {course} (as Table 3.1; n = {study.drivers} simulated impaired drivers, seeds {study.seed}.."
        f"{study.seed + study.drivers - 1})",
        (
            "",
            *(arm_name(arm).replace(" (", "\n(").replace(", ", ",\n") for arm in arms),
            *_against_first(arms),
            "thesis",
        ),
        tuple(rows),
        "mean+-sd over drivers, below it the 95 % interval of the mean; shares with Wilson's interval. p: paired over "
        "drivers (exact Wilcoxon signed-rank; McNemar's exact test for completion), not corrected for their number. "
        "Failures (stuck, out of time) stay in, with the time at which they were given up: where an arm completes "
        "less, its time and distance are too small. Thesis: unassisted -> assisted, 10 people in another course of its "
        "own." + _horizon(arms),
    )


def _framework_table(result: DrivingResult) -> Table | None:
    arms = [arm for arm in result.study.arms if any("path_rmse" in r for r in result.rows if r["assistant"] == arm)]
    if not arms:
        return None
    pairs = [(arm, course.name) for arm in arms for course in result.study.courses]
    rows = []
    for metric in FRAMEWORK:
        values = [
            [r.get(metric.key, np.nan) for r in result.rows if (r["assistant"], r["course"]) == pair] for pair in pairs
        ]
        rows.append((metric.label, *(_cell(v, metric.digits) for v in values), metric.thesis))
    return Table(
        f"Framework metrics (as Table 3.3; n = {result.study.drivers} simulated impaired drivers a column)",
        ("", *(f"{arm}\n{course}" for arm, course in pairs), "thesis\nsim., real"),
        tuple(rows),
        "mean+-sd over drivers, below it the 95 % interval of the mean. " + _DEFINITIONS,
    )


@dataclass(frozen=True)
class Aim:
    """A figure to reach, and how it came out."""

    label: str
    wanted: str
    found: float
    digits: int
    reached: bool


def _mean(values: Sequence[float]) -> float:
    return summarise(values).mean


def _aims(result: DrivingResult, course: str, arm: str) -> list[Aim]:
    def ratio(metric: str) -> float:
        return _mean(result.column(course, arm, metric)) / _mean(result.column(course, "none", metric))

    def framework(metric: str) -> float:
        rows = [row for row in result.rows if (row["course"], row["assistant"]) == (course, arm)]
        return _mean([row.get(metric, np.nan) for row in rows])

    hits, done = sum(result.column(course, arm, "collisions")), _completed(result, course, arm)
    share, jerk, time = sum(done) / len(done), ratio("angular_jerk"), ratio("time")
    found = {name: framework(name) for name in ("obedience", "path_rmse", "compliant_length", "path_compliance")}
    return [
        Aim("collisions", "0", hits, 0, hits == 0),
        Aim("completed (share)", ">= 0.95", share, 2, share >= 0.95),
        Aim("angular jerk / unassisted", "<= 0.60", jerk, 2, jerk <= 0.6),
        Aim("time / unassisted", "<= 1.00", time, 2, time <= 1.0),
        Aim("user obedience", ">= 0.87", found["obedience"], 2, found["obedience"] >= 0.87),
        Aim("path RMSE [m]", "<= 0.040", found["path_rmse"], 3, found["path_rmse"] <= 0.04),
        Aim("compliant length [m]", ">= 0.80", found["compliant_length"], 2, found["compliant_length"] >= 0.8),
        Aim("path compliance (share)", ">= 0.60", found["path_compliance"], 2, found["path_compliance"] >= 0.6),
    ]


def aims_table(result: DrivingResult, arm: str = "primitives") -> Table | None:
    """What the assisted arm was to reach, and whether it did, on each course; None without it or the unassisted arm."""
    if not {"none", arm} <= set(result.study.arms):
        return None
    names = [course.name for course in result.study.courses]
    columns = [_aims(result, name, arm) for name in names]
    rows = [
        (
            aims[0].label,
            aims[0].wanted,
            *(f"{a.found:.{a.digits}f}\n{'reached' if a.reached else 'MISSED'}" for a in aims),
        )
        for aims in zip(*columns, strict=True)
    ]
    return Table(
        f"Figures to reach, {arm_name(arm)} (n = {result.study.drivers} simulated drivers a course)",
        ("", "wanted", *(f"{course.name}\n({course.split})" for course in result.study.courses)),
        tuple(rows),
        "Means over drivers; a ratio is that of the two arms' means. In brackets: what the course may be used for. "
        + _DEFINITIONS,
    )


def driving_tables(result: DrivingResult) -> list[Table]:
    """Figures to reach, Tables 3.1 (one a course) and 3.3."""
    tables = [_driving_table(result, course.name) for course in result.study.courses]
    return [t for t in (aims_table(result), *tables, _framework_table(result)) if t is not None]


def _task_table(result: TaskResult, task: str) -> Table:
    arms, study = result.study.arms, result.study
    rows: list[Row] = []
    for key, label in (("success", "success\n(reached, no contact)"), ("reached", "reached"), ("stuck", "stuck")):
        columns = [result.column(task, arm, key) for arm in arms]
        ps = [_p(paired_proportions_test(columns[0], other)) for other in columns[1:]]
        rows.append((label, *(_share(sum(c), len(c)) for c in columns), *ps))
    for key, label, digits in (("contacts", "contacts", 1), ("reversals", "reversals", 1), ("time", "time [s]", 0)):
        columns = [result.column(task, arm, key) for arm in arms]
        ps = [_p(paired_test(columns[0], other).p) for other in columns[1:]]
        rows.append((label, *(_cell(c, digits) for c in columns), *ps))
    return Table(
        f"Task: {TASK_NAMES[task]} (n = {study.starts} starts and simulated impaired drivers, seeds {study.seed}.."
        f"{study.seed + study.starts - 1})",
        ("", *(arm_name(arm).replace(" (", "\n(").replace(", ", ",\n") for arm in arms), *_against_first(arms)),
        tuple(rows),
        "Shares with Wilson's 95 % interval, p by McNemar's exact test; else mean+-sd, the mean's 95 % interval and "
        "Wilcoxon's p. Stuck: less than .1 m in some 10 s while forward is asked. A driver goes on until the task is "
        f"done or its time is over.{_horizon(arms)}",
    )


def task_tables(result: TaskResult) -> list[Table]:
    """One table a task: success, stuck rate, reversals in every arm."""
    return [_task_table(result, task) for task in result.study.tasks]


def prediction_table(prediction: LogPrediction, seed: int = 1) -> Table:
    """Path error along a real log beside both baselines."""
    header, *lines = prediction_cells(prediction, seed)
    note = "Mean path error at equal arc length; 95 % intervals by block bootstrap over 5 m of way, seed "
    return Table(f"Path error along {prediction.log.name} (real log)", header, tuple(lines), f"{note}{seed}.")
