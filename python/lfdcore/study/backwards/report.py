"""The report of study backwards: contacts, time and paths by kind of driver and assistant."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lfdcore.pictures.course import arm_name, course_figure
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.backwards.study import AROUND, BackwardsStudy, backwards_course, run_backwards_study
from lfdcore.study.driving.metrics import angular_jerk
from lfdcore.study.report.cells import count_cell, mean_cell, share_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import Findings

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
            "angular_jerk": angular_jerk(trace.twist[:, 1], trace.period),
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
    n, rows = len(traces), run_rows(traces)
    return (
        f"{driver}\n{arm_name(arm)}",
        str(n),
        share_cell(_arrived(traces), n),
        count_cell(_contacts(traces), n),
        mean_cell([row["time"] for row in rows if row["outcome"] == "completed"], 0, with_sd=False),
        mean_cell([row["angular_jerk"] for row in rows], 2, with_sd=False),
        mean_cell([row["along_path"] for row in rows], 2, bounded=True, with_sd=False),
        mean_cell([row["rolling_back"] for row in rows], 2, bounded=True, with_sd=False),
    )


def _arrived(traces: Sequence[DriveTrace]) -> int:
    return sum(trace.completed for trace in traces)


def _contacts(traces: Sequence[DriveTrace]) -> int:
    return sum(int(trace.collision.sum()) for trace in traces)


def backwards_headline(traces: Sequence[DriveTrace]) -> str:
    """Contacts and completed runs of each kind of driver and arm, n and seeds."""
    groups = _groups(traces)
    by_driver = [
        f"{driver}: " + ", ".join(_in_words(arm, mine) for (kind, arm), mine in groups.items() if kind == driver)
        for driver in dict.fromkeys(driver for driver, _ in groups)
    ]
    return f"Contacts, and runs completed, by driver and assistant: {'; '.join(by_driver)}. {origin(traces)}"


def _in_words(arm: str, traces: Sequence[DriveTrace]) -> str:
    return f"{arm_name(arm)} {_contacts(traces)} ({_arrived(traces)} of {len(traces)})"


def path_pictures(traces: Sequence[DriveTrace]) -> list[Picture]:
    """Of each kind of driver the first one's runs, a panel an assistant."""
    return [
        Picture(
            course_figure(backwards_course(), _first(traces, driver)),
            f"Driver: {driver}, seed {traces[0].seed}. The chair's long end, its nose, points back along the way that "
            "it has come.",
            f"backwards-{number}.png",
        )
        for number, driver in enumerate(dict.fromkeys(trace.driver for trace in traces))
    ]


def _first(traces: Sequence[DriveTrace], driver: str) -> list[DriveTrace]:
    mine = [trace for trace in traces if trace.driver == driver]
    return [trace for trace in mine if trace.seed == mine[0].seed]


def findings(traces: Sequence[DriveTrace]) -> Findings:
    """Everything that is shown."""
    text = (
        "The scanner sees behind the chair, and for a stick that points behind the heatmaps' assistant takes the "
        "chair's back for its front; nothing was learned anew. The scanner sits on the nose, and its beams pass "
        "through the chair's own body. All is simulated: drivers, chair, hall."
    )
    return Findings(
        headline=backwards_headline(traces),
        sections=[Section(TITLE, text, [backwards_table(traces)], path_pictures(traces))],
        rows=run_rows(traces),
        keys=("driver", "assistant", "seed"),
    )


def run(study: BackwardsStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study backwards."""
    return findings(run_backwards_study(study, folder, tell))
