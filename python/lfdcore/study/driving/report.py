"""The report of study driving: Tables 3.1-3.3 and 4.1, tasks, and pictures like Fig. 3.7-3.15."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.pictures.course import course_figure, demonstrations_figure
from lfdcore.pictures.path_stages import stage_figures
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.simulated.courses import Course, training_courses
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.driving.aims import (
    MOST_JERK,
    aims_table,
    all_aims,
    headline,
)
from lfdcore.study.driving.plan import DrivingResult
from lfdcore.study.driving.study import DrivingStudy, WholeResult, run_driving_study
from lfdcore.study.driving.tables import (
    REAL_COURSE,
    course_labels,
    driving_table,
    framework_table,
)
from lfdcore.study.driving.task_tables import task_tables
from lfdcore.study.driving.tasks import TASK_GOALS, TASK_NAMES, TaskResult
from lfdcore.study.report.page import Section
from lfdcore.study.report.table import Table
from lfdcore.study.study import Findings
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

INTRODUCTION = (
    "Everything here is simulated: the chair, the courses and the drivers (docs/simulated-drivers.md). Figures beside "
    "the thesis's tables come from our stand-ins, not from its users, and its courses had other walls. Every arm of a "
    "comparison meets the same driver, seed and noise. Failures (stuck, out of time) stay in every share and "
    "mean; only ratios to unassisted are over the drivers who completed in both arms."
)
STAGES = "How a demonstration becomes a path: one log, its moments chosen by rule (those with most to see)."
_READING = (
    "Grey rectangles: the chair's footprint. Green: path points that were followed; orange: the first half of what "
    "was discarded when the next path came, for a path about every {spacing:.1f} m. Red: where a contact began."
)


def _run_picture(number: str, name: str, course: Course, traces: Sequence[DriveTrace], n: int) -> Picture:
    reading = _READING.format(spacing=max(0.7, course.length / 150))
    caption = f"As {number}: {name}. {course.description[:1].upper()}{course.description[1:].rstrip('.')}."
    driver = f"One of {n} simulated impaired drivers (seed {traces[0].seed}), the same in every panel."
    return Picture(course_figure(course, traces), f"{caption} {driver} {reading}")


def course_pictures(result: DrivingResult) -> list[Picture]:
    """For each course the runs of the driver with the median number of contacts in the first arm."""
    pictures, labels = [], course_labels(result.plan.courses)
    for course in result.plan.courses:
        runs = [trace for trace in result.traces if trace.course == course.name]
        first = sorted((int(t.collision.sum()), t.seed) for t in runs if t.assistant == result.plan.arms[0])
        seed = first[len(first) // 2][1]
        chosen = [trace for trace in runs if trace.seed == seed]
        number = "Fig. 3.18" if course.name == REAL_COURSE else "Fig. 3.14-3.15"
        made = _run_picture(number, labels[course.name], course, chosen, result.plan.drivers)
        rule = "Shown is the driver with the median number of contacts in the first panel."
        pictures.append(replace(made, caption=f"{made.caption} {rule}"))
    return pictures


def task_pictures(result: TaskResult) -> list[Picture]:
    """Of each task the first start at which the arms differ in success, else the first."""
    pictures = []
    for name in result.plan.tasks:
        seeds = result.column(name, result.plan.arms[0], "seed")
        chosen = next((seed for seed in seeds if len({r["success"] for r in _of(result, name, seed)}) > 1), seeds[0])
        runs = [
            (course, trace)
            for course, trace, row in zip(result.courses, result.traces, result.rows, strict=True)
            if (row["task"], row["seed"]) == (name, chosen)
        ]
        made = _run_picture("Fig. 3.13, 3.15", TASK_NAMES[name], runs[0][0], [t for _, t in runs], len(seeds))
        rule = "The first start at which the arms differ in success, if there is one, else the first."
        pictures.append(replace(made, caption=f"{made.caption} {rule} {TASK_GOALS[name]}"))
    return pictures


def _of(result: TaskResult, task: str, seed: int) -> list[dict[str, object]]:
    return [row for row in result.rows if (row["task"], row["seed"]) == (task, seed)]


def demonstration_pictures(logs: Sequence[DriveLog]) -> list[Picture]:
    """Fig. 3.12, for the logs that were recorded in a training course."""
    courses = {course.name: course for course in training_courses()}
    known = [log for log in logs if log.name in courses]
    if not known:
        return []
    metres = sum(courses[log.name].length for log in known)
    caption = (
        f"As Fig. 3.12: demonstrations (blue) in the furnished home, n {len(known)} drives, together about "
        f"{metres:.0f} m, by a simulated expert, by odometry."
    )
    return [Picture(demonstrations_figure([courses[log.name] for log in known], known), caption)]


def stage_section(model: DriveAssistantModel, logs: Sequence[DriveLog]) -> Section:
    """Fig. 3.7-3.12 from demonstrations; the stages are those of the first log, the primitives those of all."""
    origin = f"Simulated expert, log {logs[0].name}."
    return Section(
        "From demonstrations to a path",
        STAGES,
        pictures=[*demonstration_pictures(logs), *stage_figures(model, logs[0], origin=origin, others=logs[1:])],
    )


def driving_tables(result: DrivingResult) -> list[Table]:
    """Figures to reach, Tables 3.1 and 4.1 (one a course) and 3.3."""
    tables = [driving_table(result, name, label) for name, label in course_labels(result.plan.courses).items()]
    aims = [aims_table(result, arm) for arm in MOST_JERK]
    return [t for t in (*aims, *tables, framework_table(result)) if t is not None]


def findings(result: WholeResult) -> Findings:
    """Everything that is shown: courses, then tasks, then how demonstrations became paths."""
    driven, tasks = result.courses, result.tasks
    size = f"{len(driven.traces)} runs, {driven.nbytes / 1e6:.1f} MB in memory without their scans."
    sections = [Section("Driving", f"{INTRODUCTION}\n\n{size}", driving_tables(driven), course_pictures(driven))]
    if tasks is not None:
        sections.append(Section("Tasks", "", task_tables(tasks), task_pictures(tasks)))
    primitives = driven.plan.models.file("primitives")
    if result.demonstrations and primitives is not None:
        logs = [open_log(path) for path in result.demonstrations]
        sections.append(stage_section(DriveAssistantModel.load(primitives), logs))
    return Findings(
        headline=headline(driven),
        sections=sections,
        rows=[*driven.rows, *(() if tasks is None else tasks.rows)],
        keys=("course", "task", "assistant", "seed"),
        aims=all_aims(driven),
    )


def run(study: DrivingStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study driving."""
    result = run_driving_study(study, folder, tell)
    tell("report", 0, 1)
    found = findings(result)
    tell("report", 1, 1)
    return found
