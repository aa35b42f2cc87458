"""Backwards with a scanner that sees all around (Sec. 6.2.1): the reversing driver in the hall, by assistant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from lfdcore.simulation import LidarConfig
from lfdcore.study.courses import hall
from lfdcore.study.driving import StudyModels, make_assistant
from lfdcore.study.reversing_driver import ReversingDriver, facing_back
from lfdcore.study.runner import Job, RunConfig, run_jobs
from lfdcore.study.statistics import summarise
from lfdcore.study.tables import Row, Table
from lfdcore.study.trace import DriveTrace
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant

AROUND = LidarConfig(beams=361, field_of_view=2 * math.pi)
ARMS = ("none", "supervisor", "dwa_1s", "two_way")
"""two_way: the heatmaps' assistant for a stick that points behind too; the others as in the driving study."""


def drive_backwards(
    heatmaps: Path, arms: Sequence[str] = ARMS, seeds: Sequence[int] = (1, 2, 3), processes: int | None = None
) -> tuple[DriveTrace, ...]:
    """One run an arm and seed. ValueError for an unknown arm; ModelError for a file that holds no heatmaps."""
    models, run, course = StudyModels(heatmaps=heatmaps), RunConfig(lidar=AROUND), facing_back(hall())
    jobs = [
        Job(course, ReversingDriver, partial(_assistant, arm, models, run), seed, run) for arm in arms for seed in seeds
    ]
    return run_jobs(jobs, processes=processes)


def _assistant(arm: str, models: StudyModels, run: RunConfig) -> Assistant:
    return TwoWayAssistant(models.of("heatmaps")) if arm == "two_way" else make_assistant(arm, models, run)


def backwards_table(traces: Sequence[DriveTrace]) -> Table:
    """A row an arm."""
    header = ("assistant", "runs", "completed", "hits", "time [s]", "ticks along a path", "ticks rolling back")
    arms = dict.fromkeys(trace.assistant for trace in traces)
    rows = tuple(_row(arm, [trace for trace in traces if trace.assistant == arm]) for arm in arms)
    note = "Means with 95 % intervals over runs. The driver looks over the shoulder and steers the chair's back."
    return Table(f"Backwards through the hall, {AROUND.beams} beams over 360 degrees", header, rows, note)


def _row(arm: str, traces: Sequence[DriveTrace]) -> Row:
    time = summarise([trace.stamp[-1] for trace in traces])
    along = summarise([(trace.mode == "path").mean() for trace in traces])
    back = summarise([np.mean(trace.twist[:, 0] < 0) for trace in traces])
    return (
        arm,
        str(len(traces)),
        str(sum(trace.completed for trace in traces)),
        str(sum(int(trace.collision.sum()) for trace in traces)),
        f"{time.mean:.0f} [{time.low:.0f}, {time.high:.0f}]",
        *(f"{s.mean:.2f} [{s.low:.2f}, {s.high:.2f}]" for s in (along, back)),
    )
