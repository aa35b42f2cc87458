"""The report of study driving: Tables 3.1-3.3 and pictures like Fig. 3.7-3.15."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lfdcore.study.driving import DrivingResult
from lfdcore.study.plots import course_figure
from lfdcore.study.report import Picture, Section, write_figures, write_report
from lfdcore.study.tables import driving_tables

INTRODUCTION = (
    "Everything here is simulated: the chair, the courses and the drivers (docs/simulated-drivers.md). Figures beside "
    "the thesis's tables come from our stand-ins, not from its users. Every arm of a comparison meets the same driver, "
    "seed and noise. Failures (stuck, out of time) stay in every denominator."
)


def course_pictures(result: DrivingResult) -> list[Picture]:
    """For each course the first driver's run in every arm."""
    pictures = []
    for course in result.study.courses:
        traces = [t for t in result.traces if t.course == course.name and t.seed == result.study.seed]
        caption = f"{course.description} Footprints every 0.7 m, driver seed {result.study.seed}."
        pictures.append(Picture(course_figure(course, traces), caption))
    return pictures


def write_driving_report(result: DrivingResult, folder: Path, more: Sequence[Section] = ()) -> Path:
    """Writes report.html and figures.json into `folder` -> the report's path."""
    memory = f"The study's {len(result.traces)} runs hold {result.nbytes / 1e6:.1f} MB without their scans."
    sections = [
        Section("Tables", INTRODUCTION + "\n\n" + memory, driving_tables(result)),
        Section("Courses", pictures=course_pictures(result)),
        *more,
    ]
    write_figures(folder / "figures.json", result.rows)
    return write_report(folder / "report.html", "lfdcore: driving study", sections)
