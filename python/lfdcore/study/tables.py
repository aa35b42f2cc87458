"""Tables 3.1-3.3 beside the thesis's numbers, every figure with n, spread and 95 % interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lfdcore.study.driving import DrivingResult
from lfdcore.study.statistics import paired_test, proportion, summarise


@dataclass(frozen=True)
class Table:
    """A titled table of text cells."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def as_text(self) -> str:
        """Aligned for a terminal."""
        lines = [self.header, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.header))]

        def show(line: Sequence[str]) -> str:
            cells = [
                line[0].ljust(widths[0]),
                *(cell.rjust(width) for cell, width in zip(line[1:], widths[1:], strict=True)),
            ]
            return "  ".join(cells).rstrip()

        rule = "  ".join("-" * width for width in widths)
        text = [self.title, show(self.header), rule, *map(show, self.rows)]
        return "\n".join([*text, self.note, ""] if self.note else [*text, ""])


@dataclass(frozen=True)
class Metric:
    """A row: our name, how to print it, and the thesis's simulated and real figures."""

    key: str
    label: str
    digits: int
    thesis: str = ""


DRIVING = (
    Metric("angular_jerk", "angular jerk [rad/s3]", 2, "0.07+-0.03 -> 0.03+-0.02"),
    Metric("time", "time taken [s]", 0, "166+-25 -> 146+-16"),
    Metric("mean_free_speed", "mean free speed [m/s]", 2, "0.59+-0.07 -> 0.67+-0.07"),
    Metric("distance", "distance travelled [m]", 0, "96+-1 -> 97+-2"),
    Metric("steering_entropy", "steering entropy, own baseline", 2, "0.57+-0.02 -> 0.55+-0.03"),
    Metric("steering_entropy_fixed", "steering entropy, fixed baseline", 2),
    Metric("reversals", "reversals", 1),
    Metric("stuck", "share of time stuck", 3),
    Metric("supervised", "share of commands supervised", 2),
)
FRAMEWORK = (
    Metric("obedience", "user obedience", 2, "0.87+-0.11 / 0.88+-0.09"),
    Metric("angular_error", "... angular error behind it [deg]", 0),
    Metric("path_compliance", "path compliance (share)", 2, "0.64+-0.33 / 0.56+-0.40"),
    Metric("compliant_length", "compliant length [m]", 2),
    Metric("path_rmse", "path RMSE [m]", 3, "0.04+-0.03 / 0.10+-0.07"),
    Metric("replans_per_metre", "replans per metre [1/m]", 2),
)


def _cell(values: Sequence[float], digits: int) -> str:
    s = summarise(values)
    if s.n == 0:
        return "-"
    if s.n == 1:
        return f"{s.mean:.{digits}f}"
    return f"{s.mean:.{digits}f}+-{s.sd:.{digits}f} [{s.low:.{digits}f}, {s.high:.{digits}f}]"


def _completion(outcomes: Sequence[str]) -> str:
    share, low, high = proportion(sum(o == "completed" for o in outcomes), len(outcomes))
    return f"{100 * share:.0f} % [{100 * low:.0f}, {100 * high:.0f}]"


def _outcomes(result: DrivingResult, course: str, arm: str) -> list[str]:
    return [row["outcome"] for row in result.rows if row["course"] == course and row["assistant"] == arm]


def _p(a: Sequence[float], b: Sequence[float]) -> str:
    p = paired_test(a, b).p
    return "-" if np.isnan(p) else f"{p:.3f}"


def _driving_table(result: DrivingResult, course: str) -> Table:
    arms = result.study.arms
    last = arms[-1]
    rows = [("completed", *(_completion(_outcomes(result, course, arm)) for arm in arms), "", "")]
    totals = [int(sum(result.column(course, arm, "collisions"))) for arm in arms]
    collisions = [result.column(course, arm, "collisions") for arm in arms]
    rows.append(("total collisions", *map(str, totals), _p(collisions[0], collisions[-1]), "5 -> 0"))
    for metric in DRIVING:
        columns = [result.column(course, arm, metric.key) for arm in arms]
        cells = [_cell(column, metric.digits) for column in columns]
        rows.append((metric.label, *cells, _p(columns[0], columns[-1]), metric.thesis))
    return Table(
        f"Driving metrics, {course} (Table 3.1; n = {result.study.drivers} simulated impaired drivers, seeds "
        f"{result.study.seed}..{result.study.seed + result.study.drivers - 1})",
        ("", *arms, f"p {arms[0]}/{last}", "thesis, simulated"),
        tuple(rows),
        "mean+-sd [95 % interval of the mean]; p: Wilcoxon signed-rank over drivers; failures stay in.",
    )


def _framework_table(result: DrivingResult) -> Table | None:
    arms = [arm for arm in result.study.arms if any("path_rmse" in r for r in result.rows if r["assistant"] == arm)]
    if not arms:
        return None
    names = [course.name for course in result.study.courses]
    header = tuple(f"{arm}, {name}" for arm in arms for name in names)
    rows = []
    for metric in FRAMEWORK:
        cells = [
            _cell(
                [r.get(metric.key, float("nan")) for r in result.rows if (r["assistant"], r["course"]) == (arm, name)],
                metric.digits,
            )
            for arm in arms
            for name in names
        ]
        rows.append((metric.label, *cells, metric.thesis))
    return Table("Framework metrics (Table 3.3)", ("", *header, "thesis, simulated / real"), tuple(rows))


def driving_tables(result: DrivingResult) -> list[Table]:
    """Tables 3.1 (one a course) and 3.3."""
    tables = [_driving_table(result, course.name) for course in result.study.courses]
    framework = _framework_table(result)
    return tables if framework is None else [*tables, framework]
