"""Tables 3.1-3.3 and 4.1 beside the thesis's numbers, figures to reach, tasks; each figure with n and an interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lfdcore.control import DynamicWindowConfig
from lfdcore.pictures.course import arm_name
from lfdcore.simulated.courses import Course
from lfdcore.study.arms import PRINTED
from lfdcore.study.driving.metrics import JERK_WINDOW
from lfdcore.study.driving.plan import DrivingPlan, DrivingResult
from lfdcore.study.report.cells import mean_cell, p_cell, share_cell
from lfdcore.study.report.statistics import (
    paired_proportions_test,
    paired_test,
)
from lfdcore.study.report.table import Row, Table
from lfdcore.wheelchair.assistants import PROJECTION


@dataclass(frozen=True)
class Metric:
    """A row: our name, how to print it, and the thesis's figures from simulation and from the real chair."""

    key: str
    label: str
    digits: int
    simulated: str = ""
    real: str = ""
    bounded: bool = False
    """a count or in [0, 1] and near an end of it: the interval is a bootstrap's"""
    heatmaps: str = ""
    """the thesis's simulated figures with heatmaps (Table 4.1)"""


DRIVING = (
    Metric(
        "angular_jerk",
        "angular jerk [rad/s3]",
        2,
        "0.07+-0.03\n-> 0.03+-0.02",
        "0.03+-0.03\n-> 0.025+-0.03",
        heatmaps="0.04+-0.01\n-> 0.02+-0.01",
    ),
    Metric("time", "time taken [s]", 0, "166+-25\n-> 146+-16", "566\n-> 252", heatmaps="162+-22\n-> 150+-20"),
    Metric("mean_free_speed", "mean free speed [m/s]", 2, "0.59+-0.07\n-> 0.67+-0.07"),
    Metric("distance", "distance travelled [m]", 0, "96+-1\n-> 97+-2", "238\n-> 220", heatmaps="97+-2\n-> 97+-1"),
    Metric(
        "steering_entropy",
        "steering entropy,\nown baseline",
        2,
        "0.57+-0.02\n-> 0.55+-0.03",
        "0.57\n-> 0.60",
        heatmaps="0.58+-0.03\n-> 0.59+-0.02",
    ),
    Metric("steering_entropy_fixed", "steering entropy,\nfixed baseline", 2),
    Metric("reversals", "reversals", 1, bounded=True),
    Metric("stuck", "share of time stuck", 3, bounded=True),
    Metric("supervised", "share of commands\nsupervised", 2, bounded=True),
)
FRAMEWORK = (
    Metric("obedience", "user obedience", 2, "0.87+-0.11", "0.88+-0.09", bounded=True),
    Metric("angular_error", "angular error\nbehind it [deg]", 0),
    Metric("path_compliance", "path compliance\n(share)", 2, "0.64+-0.33", "0.56+-0.40", bounded=True),
    Metric("tracked_compliance", "... while it was\ntracked (share)", 2, bounded=True),
    Metric("compliant_length", "compliant length [m]", 2),
    Metric("path_rmse", "path RMSE [m]", 3, "0.04+-0.03", "0.10+-0.07"),
    Metric("path_rmse_ahead", "... of points agreed\nto, not reached [m]", 3),
    Metric("replans_per_metre", "replans per metre", 2),
)


DEFINITIONS = (
    "The thesis does not define these to the letter; ours (study/driving/metrics.py): path compliance counts path "
    "points that complied at any later time; compliant length reaches to the last control point that complied while "
    "its path was tracked; path RMSE is over the points passed by then, and would be the larger one with those ahead."
)


_INTERVALS = (
    "mean+-sd over drivers, below it the 95 % interval of the mean: Student's, cut at 0; for counts, shares and "
    "user obedience the percentiles of a seeded bootstrap, which are too narrow where n is small. "
)
_JERK = (
    f" Angular jerk: the thesis states no smoothing; ours is a Savitzky-Golay parabola over {JERK_WINDOW:g} s of the "
    "true motion, so only ratios between arms compare (docs/decisions.md)."
)
_NOT_MEASURED = (
    " '-': not measured, or too few pairs for a test; a fixed baseline of the steering entropy needs the same driver's "
    "unassisted run, and prediction errors in it."
)


def completed_runs(result: DrivingResult, course: str, arm: str) -> list[bool]:
    rows = (row for row in result.rows if (row["course"], row["assistant"]) == (course, arm))
    return [row["outcome"] == "completed" for row in rows]


def _contacts(counts: Sequence[float]) -> str:
    """Total, and below it how many drivers had any."""
    return f"{int(sum(counts))}\n{sum(c > 0 for c in counts)} of {len(counts)} drivers"


def horizon_note(arms: Sequence[str]) -> str:
    """What DWA's figures depend on most: its twists are held for longer than its goal lies ahead."""
    if "dwa" not in arms:
        return ""
    horizon, ahead = DynamicWindowConfig().horizon, PROJECTION
    return (
        f" DWA's horizon is {horizon:g} s and its goal the input projected {ahead:g} s ahead (Sec. 3.5), so in the "
        f"open it drives at {ahead / horizon:.0%} of the asked speed."
    )


def printed_note(arms: Sequence[str]) -> str:
    """What "driven as printed" leaves out: learning as printed."""
    if not set(PRINTED) & set(arms):
        return ""
    return " Driven as printed: plans and drives as the thesis prints; its model is learned by default."


def _stacked(name: str) -> str:
    """An arm's name over as many lines as it has parts."""
    return name.replace(" (", "\n(").replace(", ", ",\n").replace(" only", "\nonly")


def arm_columns(arms: Sequence[str]) -> Row:
    """Headers: a column an arm, then one for the p of each but the first."""
    short = (arm_name(arm).removesuffix(" (learned)") for arm in arms[1:])
    return (*(_stacked(arm_name(arm)) for arm in arms), *(_stacked(f"p, {name}") for name in short))


def course_labels(courses: Sequence[Course]) -> dict[str, str]:
    """By name, what tables call a course: without the seed of its random route, where that leaves them distinct."""
    short = {course.name: _without_seed(course) for course in courses}
    labels = list(short.values())
    return {name: label if labels.count(label) == 1 else name for name, label in short.items()}


def _without_seed(course: Course) -> str:
    name, _, seed = course.name.rpartition("-")
    return name if name and f"seed {seed}," in course.description else course.name


REAL_COURSE = "campus"
"""The course that stands for the thesis's real one (Fig. 3.18, Table 3.2); all others stand for Table 3.1's."""


@dataclass(frozen=True)
class _Thesis:
    """A table of the thesis, as a column beside ours."""

    number: str
    header: str
    figures: str
    """the field of a Metric"""
    collisions: str
    users: str


_PRIMITIVES_REAL = _Thesis("3.2", "thesis,\nreal", "real", "8 -> 0", "one volunteer on a real chair")
_PRIMITIVES = _Thesis("3.1", "thesis,\nCh. 3", "simulated", "5 -> 0", "10 people in simulation (Ch. 3)")
_HEATMAPS = _Thesis("4.1", "thesis,\nCh. 4", "heatmaps", "4 -> 0", "5 people in simulation (Ch. 4)")


def _thesis_columns(arms: Sequence[str], real: bool) -> list[_Thesis]:
    """What stands beside: of Ch. 3, and where heatmaps drive in what stands for its course, of Ch. 4 too."""
    if real:
        return [_PRIMITIVES_REAL]
    return [_PRIMITIVES, _HEATMAPS] if "heatmaps" in arms else [_PRIMITIVES]


def driving_table(result: DrivingResult, course: str, label: str) -> Table:
    arms, study = result.plan.arms, result.plan
    done = [completed_runs(result, course, arm) for arm in arms]
    hits = [result.column(course, arm, "collisions") for arm in arms]
    ps = [p_cell(paired_proportions_test(done[0], other)) for other in done[1:]]
    thesis = _thesis_columns(arms, course == REAL_COURSE)
    rows: list[Row] = [("completed", *(share_cell(sum(d), len(d)) for d in done), *ps, *("" for _ in thesis))]
    ps = [p_cell(paired_test(hits[0], other).p) for other in hits[1:]]
    rows.append(("collisions, total", *map(_contacts, hits), *ps, *(column.collisions for column in thesis)))
    for metric in DRIVING:
        columns = [result.column(course, arm, metric.key) for arm in arms]
        ps = [p_cell(paired_test(columns[0], other).p) for other in columns[1:]]
        cells = (mean_cell(column, metric.digits, metric.bounded) for column in columns)
        rows.append((metric.label, *cells, *ps, *(getattr(metric, column.figures) for column in thesis)))
    return Table(
        f"Driving metrics, {label} (as Table {' and '.join(column.number for column in thesis)}; n = {study.drivers} "
        f"simulated impaired drivers, {seeds_of(study)})",
        ("", *arm_columns(arms), *(column.header for column in thesis)),
        tuple(rows),
        f"{_INTERVALS}Completed: Wilson's interval. p: against {arm_name(arms[0])}, paired over drivers (exact "
        "Wilcoxon signed-rank; McNemar's exact test for completion), not corrected for their number. "
        "Failures (stuck, out of time) stay in, with the time at which they were given up: where an arm completes "
        "less, its time and distance are too small. Thesis: unassisted -> assisted, "
        f"{'; '.join(column.users for column in thesis)}, in another course of its own.{_JERK}{horizon_note(arms)}"
        f"{printed_note(arms)}"
        f"{_NOT_MEASURED if any('-' in row for row in rows) else ''}",
    )


def framework_table(result: DrivingResult) -> Table | None:
    arms = [arm for arm in result.plan.arms if any("path_rmse" in r for r in result.rows if r["assistant"] == arm)]
    if not arms:
        return None
    pairs = [(arm, course.name) for arm in arms for course in result.plan.courses]
    rows = []
    for metric in FRAMEWORK:
        values = [
            [r.get(metric.key, np.nan) for r in result.rows if (r["assistant"], r["course"]) == pair] for pair in pairs
        ]
        cells = (mean_cell(v, metric.digits, metric.bounded) for v in values)
        rows.append((metric.label, *cells, metric.simulated, metric.real))
    labels = course_labels(result.plan.courses)
    return Table(
        f"Framework metrics (as Table 3.3; n = {result.plan.drivers} simulated impaired drivers a column)",
        (
            "",
            *(f"{_stacked(arm_name(arm))}\n{labels[course]}" for arm, course in pairs),
            "thesis,\nsimulated",
            "thesis,\nreal",
        ),
        tuple(rows),
        _INTERVALS + DEFINITIONS,
    )


def seeds_of(study: DrivingPlan) -> str:
    last = study.seed + study.drivers - 1
    return f"seeds {study.seed}..{last}" if study.drivers > 1 else f"seed {last}"
