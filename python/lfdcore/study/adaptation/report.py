"""The report of study adaptation: errors by bias, their ratios to the trained model's, error over drive time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study.adaptation.pictures import BIN, adaptation_figure
from lfdcore.study.adaptation.study import (
    STAGES,
    AdaptationRun,
    AdaptationStudy,
    by_bias,
    pooled_ratio,
    run_adaptation_study,
)
from lfdcore.study.report.aims import Aim, reached_of
from lfdcore.study.report.cells import mean_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import block_bootstrap_ratio
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import Findings

TITLE = "On-line adaptation to a driver with a steering bias (Sec. 6.2.1)"
WANTED_BIASED, WANTED_UNBIASED = 0.7, 1.05
"""Largest ratio to the trained model's error, of a biased and of an unbiased driver."""
JUDGED = {"then": "model of {after:g} s", "adapting": "while it adapts"}
"""Stages whose error is compared with the trained model's"""


def aims(runs: Sequence[AdaptationRun]) -> list[Aim]:
    """Each bias's ratios of error, as ratio_aim."""
    return [ratio_aim(bias, mine, stage) for bias, mine in by_bias(runs) for stage in JUDGED]


def ratio_aim(bias: float, runs: Sequence[AdaptationRun], stage: str) -> Aim:
    """The pooled ratio to the trained model's error with its 95 % interval over drivers, and the worst drive's."""
    low, high = _interval(runs, stage)
    worst = max(run.mean(stage) / run.mean("before") for run in runs)
    label = f"{_bias_name(bias)}, {JUDGED[stage].format(after=runs[0].after)}: error / trained model's"
    found = pooled_ratio(runs, stage)
    return Aim.at_most(_wanted(bias), label, found, 2, low=low, high=high, note=f"worst {worst:.2f}")


def _bias_name(bias: float) -> str:
    return f"bias {bias:+.2f} rad" if bias else "no bias"


def _wanted(bias: float) -> float:
    return WANTED_BIASED if bias else WANTED_UNBIASED


def _interval(runs: Sequence[AdaptationRun], stage: str) -> tuple[float, float]:
    """Of the pooled ratio; a driver's runs on several courses are drawn together."""
    values, base = (np.array([run.mean(which) for run in runs]) for which in (stage, "before"))
    low, high = block_bootstrap_ratio(values[:, None], base, np.array([run.driver for run in runs]), seed=1)
    return float(low[0]), float(high[0])


def ratio_rows(runs: Sequence[AdaptationRun]) -> list[dict[str, Any]]:
    """A row a bias for machines: pooled ratios with 95 % intervals over drivers, and what is wanted."""
    rows = []
    for bias, mine in by_bias(runs):
        row: dict[str, Any] = {"bias": bias, "after": mine[0].after, "n": len(mine), "wanted": _wanted(bias)}
        for stage in JUDGED:
            row[f"ratio_{stage}"] = pooled_ratio(mine, stage)
            row[f"ratio_{stage}_low"], row[f"ratio_{stage}_high"] = _interval(mine, stage)
        rows.append(row)
    return rows


def origin(runs: Sequence[AdaptationRun]) -> str:
    """n and seeds of everything."""
    courses = ", ".join(dict.fromkeys(run.course for run in runs))
    seeds = sorted({run.seed for run in runs})
    return (
        f"n = {len(seeds)} simulated able drivers, seeds {seeds[0]}..{seeds[-1]}, each with every bias, on {courses}."
    )


def adaptation_headline(runs: Sequence[AdaptationRun]) -> str:
    """The result in two sentences, whether it was reached, n and seeds."""
    ratios = {
        stage: ", ".join(f"{pooled_ratio(mine, stage):.2f} ({_bias_name(bias)})" for bias, mine in by_bias(runs))
        for stage in JUDGED
    }
    return (
        f"While it adapts, the joystick model errs {ratios['adapting']} times as much as the trained model. As it was "
        f"after {runs[0].after:g} s and is kept: {ratios['then']}. {reached_of(aims(runs))} {origin(runs)}"
    )


def adaptation_table(runs: Sequence[AdaptationRun]) -> Table:
    """A row a bias: errors with intervals over runs, and their ratios to the trained model's."""
    after = f"{runs[0].after:g} s"
    header = (
        "bias\n[rad]",
        "runs",
        "completed",
        "contacts",
        "error before\n[rad]",
        f"of the model of\n{after} [rad]",
        "while it adapts\n[rad]",
        "ratio,\nmodel of " + after,
        "ratio, while\nit adapts",
        "wanted",
    )
    note = (
        f"{origin(runs)} Error: mean angle between the stick that the joystick model predicts and the one meant, over "
        f"the ticks after {after}, alike for the trained model, for the model as it had become by {after} and is kept, "
        "and for the model as it goes on adapting. Below it the 95 % interval over runs (Student's). Ratios: of means; "
        "below it the percentiles of a bootstrap over drivers, then the worst single drive."
    )
    return Table(TITLE, header, tuple(_row(bias, mine) for bias, mine in by_bias(runs)), note)


def _row(bias: float, runs: Sequence[AdaptationRun]) -> Row:
    ratios = [ratio_aim(bias, runs, stage) for stage in JUDGED]
    return (
        f"{bias:+.2f}",
        str(len(runs)),
        str(sum(run.outcome == "completed" for run in runs)),
        str(sum(run.collisions for run in runs)),
        *(mean_cell([run.mean(stage) for run in runs], 3, with_sd=False) for stage in STAGES),
        *(ratio.as_text() for ratio in ratios),
        ratios[0].wanted,
    )


def findings(runs: Sequence[AdaptationRun]) -> Findings:
    """Everything that is shown."""
    text = (
        "A driver whose stick points beside what is meant drives with the heatmaps' assistant, whose joystick model "
        "learns from what is followed. All is simulated: drivers, chair, courses."
    )
    caption = (
        f"Mean over runs in bins of {BIN:g} s with 95 % bands, while at least half of the runs go on. Dashed: from "
        f"here on the table judges. {origin(runs)}"
    )
    picture = Picture(adaptation_figure(runs), caption, "adaptation.png")
    return Findings(
        headline=adaptation_headline(runs),
        sections=[Section(TITLE, text, [adaptation_table(runs)], [picture])],
        rows=[*(run.row() for run in runs), *ratio_rows(runs)],
        keys=("course", "bias", "after", "seed"),
        aims=aims(runs),
    )


def run(study: AdaptationStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study adaptation."""
    return findings(run_adaptation_study(study, folder, tell))
