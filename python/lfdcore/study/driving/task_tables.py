"""Tables of the short tasks: success, stuck, contacts, reversals, time in every arm."""

from __future__ import annotations

from lfdcore.pictures.course import arm_name
from lfdcore.study.driving.tables import (
    arm_columns,
    horizon_note,
    printed_note,
)
from lfdcore.study.driving.tasks import TASK_GOALS, TASK_NAMES, TaskResult
from lfdcore.study.report.cells import mean_cell, p_cell, share_cell
from lfdcore.study.report.statistics import (
    paired_proportions_test,
    paired_test,
)
from lfdcore.study.report.table import Row, Table

_TASK_SHARES = (("success", "success\n(reached, no contact)"), ("reached", "reached"), ("stuck", "stuck for a while"))


_TASK_FIGURES = (
    ("contacts", "contacts", 1, True),
    ("reversals", "reversals", 1, True),
    ("time", "time [s]", 0, False),
)


def _stuck_runs(result: TaskResult, task: str) -> str:
    """What stuck means in a task, and how the runs that were stuck ended."""
    ends = []
    for arm in result.plan.arms:
        reached = [
            end for end, s in zip(*(result.column(task, arm, k) for k in ("reached", "stuck")), strict=True) if s
        ]
        if reached:
            ends.append(f"{sum(reached)} of {len(reached)} ({arm_name(arm)})")
    meaning = "Stuck for a while: less than .1 m in some 10 s while forward is asked; in a task that ends no run"
    return f"{meaning}, and of these runs {', '.join(ends)} still reached it." if ends else f"{meaning}."


def _task_table(result: TaskResult, task: str) -> Table:
    arms, study = result.plan.arms, result.plan
    rows: list[Row] = []
    for key, label in _TASK_SHARES:
        columns = [result.column(task, arm, key) for arm in arms]
        ps = [p_cell(paired_proportions_test(columns[0], other)) for other in columns[1:]]
        rows.append((label, *(share_cell(sum(c), len(c)) for c in columns), *ps))
    for key, label, digits, bounded in _TASK_FIGURES:
        columns = [result.column(task, arm, key) for arm in arms]
        ps = [p_cell(paired_test(columns[0], other).p) for other in columns[1:]]
        rows.append((label, *(mean_cell(c, digits, bounded) for c in columns), *ps))
    return Table(
        f"Task: {TASK_NAMES[task]} (n = {study.starts} starts and simulated impaired drivers, seeds {study.seed}.."
        f"{study.seed + study.starts - 1})",
        ("", *arm_columns(arms)),
        tuple(rows),
        f"{TASK_GOALS[task]} Success: reached without any contact. {_stuck_runs(result, task)} Shares with Wilson's 95 "
        f"% interval, p (against {arm_name(arms[0])}) by McNemar's exact test; else mean+-sd, the mean's 95 % interval "
        "(Student's, cut at 0; for counts a seeded bootstrap's percentiles) and Wilcoxon's p."
        f"{horizon_note(arms)}{printed_note(arms)}",
    )


def task_tables(result: TaskResult) -> list[Table]:
    """One table a task: success, stuck rate, reversals in every arm."""
    return [_task_table(result, task) for task in result.plan.tasks]
