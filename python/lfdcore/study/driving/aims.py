"""Figures that a driving study is to reach, and its result in a sentence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lfdcore.pictures.course import arm_name
from lfdcore.study.driving.plan import DrivingResult
from lfdcore.study.driving.tables import (
    DEFINITIONS,
    completed_runs,
    course_labels,
    seeds_of,
)
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.cells import figure_cell
from lfdcore.study.report.statistics import (
    paired_ratio,
    summarise,
)
from lfdcore.study.report.table import Table

_JERK_RATIO = (
    " The thesis's angular jerk falls from 0.07 to 0.03 (Table 3.1), by its digits to between 0.33 and 0.54 of "
    "unassisted, with heatmaps from 0.04 to 0.02 (Table 4.1: 0.33 to 0.71). Ours need not agree: its smoothing is not "
    "stated, drivers, courses and the chair's limits are others. A low-pass on the driver's own stick lowers it as "
    "much, and takes more time (docs/results.md)."
)


def _ratio(result: DrivingResult, course: str, arm: str, metric: str) -> tuple[float, int]:
    """To unassisted, over the drivers who completed in both arms -> ratio, their number."""
    without, of_arm = (result.column(course, name, metric) for name in ("none", arm))
    both = np.array(completed_runs(result, course, "none")) & np.array(completed_runs(result, course, arm))
    return paired_ratio(without, of_arm, both)


def _aims(result: DrivingResult, course: str, arm: str) -> list[Aim]:
    def ratio(metric: str, label: str, most: float) -> Aim:
        found, n = _ratio(result, course, arm, metric)
        return Aim.at_most(most, f"{label} / unassisted", found, 2, note=f"n {n}" if n < result.plan.drivers else "")

    hits, done = sum(result.column(course, arm, "collisions")), completed_runs(result, course, arm)
    aims = [
        Aim.between(0, 0, "collisions", hits, 0),
        Aim.at_least(0.95, "completed (share)", sum(done) / len(done), 2),
        ratio("angular_jerk", "angular jerk", MOST_JERK[arm]),
        ratio("time", "time", 1.0),
    ]
    return aims if arm == "heatmaps" else [*aims, *_framework_aims(result, course, arm)]


MOST_JERK = {"primitives": 0.6, "heatmaps": 0.5}
"""Of unassisted driving's: Table 4.1 has it halved."""


def _framework_aims(result: DrivingResult, course: str, arm: str) -> list[Aim]:
    """Table 3.3's; Ch. 4 has none"""
    rows = [row for row in result.rows if (row["course"], row["assistant"]) == (course, arm)]

    def mean(name: str) -> float:
        return summarise([row.get(name, np.nan) for row in rows]).mean

    return [
        Aim.at_least(0.87, "user obedience", mean("obedience"), 2),
        Aim.at_most(0.04, "path RMSE [m]", mean("path_rmse"), 3),
        Aim.at_least(0.8, "compliant length [m]", mean("compliant_length"), 2),
        Aim.at_least(0.6, "path compliance (share)", mean("path_compliance"), 2),
    ]


def all_aims(result: DrivingResult) -> list[Aim]:
    """Of every learned arm on every course, each named by both; none without the unassisted arm."""
    arms = [arm for arm in MOST_JERK if "none" in result.plan.arms and arm in result.plan.arms]
    labels = course_labels(result.plan.courses)
    return [
        replace(aim, label=f"{arm_name(arm)}, {label}: {aim.label}")
        for arm in arms
        for course, label in labels.items()
        for aim in _aims(result, course, arm)
    ]


def aims_table(result: DrivingResult, arm: str) -> Table | None:
    """What 'primitives' or 'heatmaps' were to reach, and whether they did, on each course; None without that arm or the
    unassisted one."""
    if not {"none", arm} <= set(result.plan.arms):
        return None
    names = [course.name for course in result.plan.courses]
    columns = [_aims(result, name, arm) for name in names]
    rows = [(aims[0].label, aims[0].wanted, *(a.as_text() for a in aims)) for aims in zip(*columns, strict=True)]
    labels = course_labels(result.plan.courses)
    defined = "" if arm == "heatmaps" else f" {DEFINITIONS}"
    return Table(
        f"Figures to reach, {arm_name(arm)} (n = {result.plan.drivers} simulated drivers a course)",
        ("", "wanted", *(f"{labels[course.name]}\n({course.split})" for course in result.plan.courses)),
        tuple(rows),
        "Means over drivers; a ratio is that of the two arms' means over the drivers who completed in both arms, with "
        f"their n where that is not all. In brackets: what the course may be used for.{defined}{_JERK_RATIO}",
    )


def headline(result: DrivingResult) -> str:
    """The result in a sentence: collisions, completion and jerk of the learned arms (without any the last one) and
    unassisted."""
    study = result.plan
    arms = [arm for arm in MOST_JERK if arm in study.arms] or [study.arms[-1]]
    first = [name for name in ("none",) if name in study.arms and name not in arms]
    text = "; ".join(_counts(result, name) for name in (*arms, *first))
    if first:
        jerks = "; ".join(_jerk_ratios(result, arm, named=len(arms) > 1) for arm in arms)
        text += f". Angular jerk / unassisted: {jerks}"
    people = f"simulated impaired driver{'s' * (study.drivers != 1)}"
    return f"{text}. n = {study.drivers} {people} a course, {seeds_of(study)}."


def _jerk_ratios(result: DrivingResult, arm: str, named: bool) -> str:
    labels = course_labels(result.plan.courses)
    ratios = [
        f"{figure_cell(_ratio(result, name, arm, 'angular_jerk')[0], digits=2)} ({label})"
        for name, label in labels.items()
    ]
    return (f"{arm_name(arm)} " if named else "") + ", ".join(ratios)


def _counts(result: DrivingResult, arm: str) -> str:
    rows = [row for row in result.rows if row["assistant"] == arm]
    hits, done = sum(row["collisions"] for row in rows), sum(row["outcome"] == "completed" for row in rows)
    return f"{arm_name(arm)}: {hits} collision{'s' * (hits != 1)}, {done} of {len(rows)} runs completed"
