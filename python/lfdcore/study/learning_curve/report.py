"""The report of study learning-curve: both methods by the number of runs, in the closed loop and a posteriori."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress, silent
from lfdcore.study.demonstrations import home_seed, maze_seed
from lfdcore.study.learning_curve.closed_loop import closed_loop_rows, way_seed
from lfdcore.study.learning_curve.curve import CurvePoint, LearningCurve
from lfdcore.study.learning_curve.models import learn_curve_models
from lfdcore.study.learning_curve.pictures import curve_figure, method_name
from lfdcore.study.learning_curve.predictions import prediction_rows
from lfdcore.study.learning_curve.study import METHODS, NOBODY, LearningCurveStudy
from lfdcore.study.prediction.study import STRAIGHT
from lfdcore.study.report.cells import count_cell, share_cell, summary_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import Summary
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import Findings

TITLE = "How much demonstration is enough"


def origin(curve: LearningCurve) -> str:
    """n and seeds of everything."""
    study = curve.study
    samples = sum(e["samples"] for e in curve.errors if e["method"] == STRAIGHT)
    return (
        f"Demonstrations: the first n of the runs in the mazes, seeds {_seeds(maze_seed, study, max(study.runs))}. "
        f"Closed loop: n = {study.drivers} simulated impaired drivers, each on a way of its own in home_20x19, seeds "
        f"{_seeds(way_seed, study, study.drivers)}. Predicted paths: {study.predicted} runs of simulated able "
        f"drivers there, seeds {_seeds(home_seed, study, study.predicted)}, {samples} scans."
    )


def _seeds(of: Callable[[int, int], int], study: LearningCurveStudy, runs: int) -> str:
    return f"{of(study.seed, 0)}..{of(study.seed, runs - 1)}"


def curve_headline(curve: LearningCurve) -> str:
    """Predicted paths and arrivals with the fewest and with the most demonstrations, n and seeds."""
    alone, *points = curve.points()
    ends = [[p for p in points if p.method == method][:: max(len(curve.study.runs) - 1, 1)] for method in METHODS]
    (name, baseline), runs = curve.baseline(), " and ".join(str(p.demonstrations) for p in ends[0])
    errors, arrived = (", ".join(map(words, ends)) for words in (_errors, _arrived))
    return (
        f"With {runs} runs demonstrated, paths are predicted with a mean error of {errors} ({name}: "
        f"{baseline.mean:.3f} m). Of {curve.study.drivers} impaired drivers arrive {arrived}, {alone.completed[0]} "
        f"unassisted. {origin(curve)}"
    )


def _errors(points: Sequence[CurvePoint]) -> str:
    return " and ".join(f"{p.path_error.mean:.3f}" for p in points) + f" m by {method_name(points[0].method)}"


def _arrived(points: Sequence[CurvePoint]) -> str:
    return " and ".join(str(p.completed[0]) for p in points) + f" with {method_name(points[0].method)}"


def curve_table(curve: LearningCurve) -> Table:
    """A row a method and number of runs."""
    header = (
        "",
        "runs",
        "completed",
        "contacts\n[a run]",
        "path RMSE [m]",
        "angular jerk /\nunassisted",
        "time /\nunassisted",
        "error of predicted\npaths, to 2.5 m [m]",
    )
    note = (
        f"{origin(curve)} In brackets 95 % intervals: of the share Wilson's, of contacts a run Garwood's (Poisson), of "
        "means over drivers and runs Student's. Ratios: means over the drivers who arrived with and without. One "
        "training for each n: the intervals do not cover what other runs or another start of the network would have "
        "given."
    )
    name, error = curve.baseline()
    baseline = (f"{name}\n(baseline)", *["-"] * 6, _mean(error, 3))
    return Table(TITLE, header, (*map(_row, curve.points()), baseline), note)


def _row(point: CurvePoint) -> Row:
    alone = point.method == NOBODY
    return (
        method_name(point.method),
        "-" if alone else str(point.demonstrations),
        share_cell(*point.completed),
        count_cell(point.contacts, point.completed[1]),
        _mean(point.path_rmse, 3),
        "1" if alone else _mean(point.jerk_ratio, 2),
        "1" if alone else _mean(point.time_ratio, 2),
        _mean(point.path_error, 3),
    )


def _mean(s: Summary, digits: int) -> str:
    return summary_cell(s, digits, with_sd=False, least=0.0)


def findings(curve: LearningCurve) -> Findings:
    """Everything that is shown."""
    text = (
        "Models of the first n of 72 runs in two mazes, in a home like neither. All is simulated: drivers, chair, "
        "courses. Bars: 95 % intervals. Dashed: unassisted; dotted: the better of straight on and a constant arc."
    )
    picture = Picture(curve_figure(curve), f"{text} {origin(curve)}", "learning-curve.png")
    return Findings(
        headline=curve_headline(curve),
        sections=[Section(TITLE, text, [curve_table(curve)], [picture])],
        rows=[*curve.rows, *curve.errors],
        keys=("demonstrations", "assistant", "method", "log", "seed"),
    )


def run_learning_curve(study: LearningCurveStudy, folder: Path, tell: StageProgress = silent) -> LearningCurve:
    """Learns what is not in `folder` yet (needs torch), drives and predicts; the result does not depend on the number
    of processes."""
    learn_curve_models(study, folder, tell)
    rows = closed_loop_rows(study, folder, tell)
    return LearningCurve(study, tuple(rows), tuple(prediction_rows(study, folder, tell)))


def run(study: LearningCurveStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study learning-curve. Models and logs stay in `folder`."""
    return findings(run_learning_curve(study, folder, tell))
