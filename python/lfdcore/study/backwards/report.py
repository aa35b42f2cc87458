"""The study of study/backwards/study.py as a table, pictures of paths and one report.html."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lfdcore.pictures.course import arm_name, course_figure
from lfdcore.pictures.style import Picture, png
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.backwards.study import AROUND, backwards_course
from lfdcore.study.driving.metrics import driving_metrics
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import Summary, poisson_rate, proportion, summarise, summarise_bounded
from lfdcore.study.report.table import Row, Table

TITLE = f"Backwards through the hall, {AROUND.beams} beams over 360 degrees (Sec. 6.2.1)"


def run_rows(traces: Sequence[DriveTrace]) -> list[dict[str, Any]]:
    """A row a run for machines."""
    return [
        {
            "driver": trace.driver,
            "assistant": trace.assistant,
            "seed": trace.seed,
            "outcome": trace.outcome,
            "collisions": int(trace.collision.sum()),
            "time": float(trace.stamp[-1]),
            "angular_jerk": driving_metrics(trace).angular_jerk,
            "along_path": float((trace.mode == "path").mean()),
            "rolling_back": float((trace.twist[:, 0] < 0).mean()),
        }
        for trace in traces
    ]


def _groups(traces: Sequence[DriveTrace]) -> dict[tuple[str, str], list[DriveTrace]]:
    """By driver and assistant, in the order of the runs."""
    groups: dict[tuple[str, str], list[DriveTrace]] = {}
    for trace in traces:
        groups.setdefault((trace.driver, trace.assistant), []).append(trace)
    return groups


def origin(traces: Sequence[DriveTrace]) -> str:
    """n and seeds."""
    seeds = sorted({trace.seed for trace in traces})
    return f"n = {len(seeds)} simulated drivers of each kind, seeds {seeds[0]}..{seeds[-1]}."


def backwards_table(traces: Sequence[DriveTrace]) -> Table:
    """A row a kind of driver and arm."""
    header = (
        "driver,\nassistant",
        "runs",
        "completed",
        "contacts\n[a run]",
        "time of the\ncompleted [s]",
        "angular jerk\n[rad/s^3]",
        "ticks along\na path",
        "ticks\nrolling back",
    )
    note = (
        f"{origin(traces)} They look over the shoulder and steer the chair's back. In brackets 95 % intervals: of the "
        "share Wilson's, of contacts a run Garwood's (Poisson), of ticks a bootstrap's, of other means over runs "
        "Student's."
    )
    return Table(TITLE, header, tuple(_row(*key, mine) for key, mine in _groups(traces).items()), note)


def _row(driver: str, arm: str, traces: Sequence[DriveTrace]) -> Row:
    n, arrived = len(traces), sum(trace.completed for trace in traces)
    contacts = sum(int(trace.collision.sum()) for trace in traces)
    share, low, high = (100 * value for value in proportion(arrived, n))
    _, rate_low, rate_high = poisson_rate(contacts, n)
    return (
        f"{driver}\n{arm_name(arm)}",
        str(n),
        f"{arrived} of {n}\n{share:.0f} % [{low:.0f}, {high:.0f}]",
        f"{contacts} in {n}\n[{rate_low:.2f}, {rate_high:.2f}]",
        _mean(summarise([float(trace.stamp[-1]) for trace in traces if trace.completed]), 0),
        _mean(summarise([driving_metrics(trace).angular_jerk for trace in traces]), 2),
        _mean(summarise_bounded([float((trace.mode == "path").mean()) for trace in traces]), 2),
        _mean(summarise_bounded([float(np.mean(trace.twist[:, 0] < 0)) for trace in traces]), 2),
    )


def _mean(s: Summary, digits: int) -> str:
    if s.n == 0:
        return "-"
    return f"{s.mean:.{digits}f}" + (f"\n[{max(s.low, 0.0):.{digits}f}, {s.high:.{digits}f}]" if s.n > 1 else "")


def paths_figures(traces: Sequence[DriveTrace]) -> list[tuple[str, Figure]]:
    """Of each kind of driver the first one's runs, a panel an assistant."""
    figures = []
    for driver in dict.fromkeys(trace.driver for trace in traces):
        mine = [trace for trace in traces if trace.driver == driver]
        first = [trace for trace in mine if trace.seed == mine[0].seed]
        figures.append((driver, course_figure(backwards_course(), first)))
    return figures


def write_backwards(traces: Sequence[DriveTrace], folder: Path, command: str = "") -> Path:
    """backwards-N.png, figures.json and report.html in `folder` -> the report's path."""
    pictures = []
    for number, (driver, figure) in enumerate(paths_figures(traces)):
        (folder / f"backwards-{number}.png").write_bytes(png(figure))
        caption = (
            f"Driver: {driver}, seed {traces[0].seed}. The chair's long end, its nose, points back along the way that "
            "it has come."
        )
        pictures.append(Picture(figure, caption))
    write_figures(folder / "figures.json", run_rows(traces))
    text = (
        "The scanner sees behind the chair, and for a stick that points behind the heatmaps' assistant takes the "
        "chair's back for its front; nothing was learned anew. The scanner sits on the nose, and its beams pass "
        "through the chair's own body. All is simulated: drivers, chair, hall."
    )
    section = Section(TITLE, text, [backwards_table(traces)], pictures)
    made = f"Made by `{command}`" if command else ""
    return write_report(folder / "report.html", TITLE, [section], origin=made)
