"""The adaptation study of study/adaptation/study.py as a table, a picture and one report.html."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.pictures.style import ANOTHER, BASELINE, LEARNED, PAGE, REFERENCE, RULE, Picture, png, styled
from lfdcore.study.adaptation.study import STAGES, AdaptationRun, pooled_ratio
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import block_bootstrap_ratio, summarise
from lfdcore.study.report.table import Row, Table

Floats = NDArray[np.float64]
TITLE = "On-line adaptation to a driver with a steering bias (Sec. 6.2.1)"
WANTED_BIASED, WANTED_UNBIASED = 0.7, 1.05
"""Largest ratio to the trained model's error, of a biased and of an unbiased driver."""
COLOURS = {"before": BASELINE, "then": ANOTHER, "adapting": LEARNED}
_BIN = 10.0
"""[s]"""


def by_bias(runs: Sequence[AdaptationRun]) -> list[tuple[float, list[AdaptationRun]]]:
    """The runs of each bias, biases rising."""
    return [(bias, [run for run in runs if run.bias == bias]) for bias in sorted({run.bias for run in runs})]


def ratio_rows(runs: Sequence[AdaptationRun]) -> list[dict[str, Any]]:
    """A row a bias for machines: pooled ratios with 95 % intervals over drivers, and what is wanted."""
    rows = []
    for bias, mine in by_bias(runs):
        row: dict[str, Any] = {"bias": bias, "runs": len(mine), "wanted": _wanted(bias)}
        for stage in STAGES[1:]:
            row[f"ratio_{stage}"] = pooled_ratio(mine, stage)
            row[f"ratio_{stage}_low"], row[f"ratio_{stage}_high"] = _interval(mine, stage)
        rows.append(row)
    return rows


def _wanted(bias: float) -> float:
    return WANTED_BIASED if bias else WANTED_UNBIASED


def _interval(runs: Sequence[AdaptationRun], stage: str) -> tuple[float, float]:
    """Of the pooled ratio; a driver's runs on several courses are drawn together."""
    values, base = (np.array([run.mean(which) for run in runs]) for which in (stage, "before"))
    low, high = block_bootstrap_ratio(values[:, None], base, np.array([run.driver for run in runs]), seed=1)
    return float(low[0]), float(high[0])


def origin(runs: Sequence[AdaptationRun]) -> str:
    """n and seeds of everything."""
    courses = ", ".join(dict.fromkeys(run.course for run in runs))
    seeds = sorted({run.seed for run in runs})
    return (
        f"n = {len(seeds)} simulated able drivers, seeds {seeds[0]}..{seeds[-1]}, each with every bias, on {courses}."
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
    return (
        f"{bias:+.2f}",
        str(len(runs)),
        str(sum(run.outcome == "completed" for run in runs)),
        str(sum(run.collisions for run in runs)),
        *(_error(runs, stage) for stage in STAGES),
        *(_ratio(bias, runs, stage) for stage in STAGES[1:]),
        f"<= {_wanted(bias):.2f}",
    )


def _error(runs: Sequence[AdaptationRun], stage: str) -> str:
    s = summarise([run.mean(stage) for run in runs])
    return f"{s.mean:.3f}" + (f"\n[{max(s.low, 0.0):.3f}, {s.high:.3f}]" if s.n > 1 else "")


def _ratio(bias: float, runs: Sequence[AdaptationRun], stage: str) -> str:
    ratio, (low, high) = pooled_ratio(runs, stage), _interval(runs, stage)
    worst = max(run.mean(stage) / run.mean("before") for run in runs)
    verdict = " MISSED" if ratio > _wanted(bias) else ""
    spread = f"\n[{low:.2f}, {high:.2f}]" if np.isfinite(low) else ""
    return f"{ratio:.2f}{verdict}{spread}\nworst {worst:.2f}"


def _over_time(runs: Sequence[AdaptationRun], stage: str) -> tuple[Floats, Floats]:
    """-> middles of bins (K,) [s], errors (runs, K), NaN where a run has none."""
    count = int(np.ceil(max(run.stamp[-1] for run in runs) / _BIN)) + 1
    errors = np.full((len(runs), count), np.nan)
    for row, run in zip(errors, runs, strict=True):
        error = getattr(run, f"error_{stage}")
        there = np.isfinite(error)
        if stage == "then":
            there &= run.stamp > run.after
        index = (run.stamp[there] / _BIN).astype(int)
        number = np.bincount(index, minlength=count)
        row[:] = np.bincount(index, error[there], minlength=count) / np.where(number, number, np.nan)
    middles = np.asarray((np.arange(count) + 0.5) * _BIN, float)
    return middles, errors


def _draw(axes: Axes, runs: Sequence[AdaptationRun], stage: str, label: str) -> None:
    """The mean over runs with its 95 % band, while at least half of them still drive."""
    at, errors = _over_time(runs, stage)
    enough = np.isfinite(errors).sum(axis=0) >= max(1, len(runs) / 2)
    bins = [summarise(column) for column in errors[:, enough].T]
    mean, low, high = (np.array([getattr(s, name) for s in bins]) for name in ("mean", "low", "high"))
    colour = COLOURS[stage]
    axes.plot(at[enough], mean, color=colour, lw=1.4, label=label, zorder=3)
    axes.fill_between(at[enough], np.maximum(low, 0), high, color=colour, alpha=0.18, lw=0, zorder=2)


@styled
def adaptation_figure(runs: Sequence[AdaptationRun]) -> Figure:
    """Error over drive time, a panel a bias: as trained, as of `after` and kept, adapting."""
    groups, after = by_bias(runs), runs[0].after
    figure = Figure(figsize=(PAGE, 3.2), layout="constrained")
    panels = figure.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    names = {"before": "as trained", "then": f"as of {after:g} s, kept", "adapting": "adapting"}
    for axes, (bias, mine) in zip(panels, groups, strict=True):
        for stage, label in names.items():
            _draw(axes, mine, stage, label)
        axes.axvline(after, color=REFERENCE, lw=0.8, ls="--", zorder=1)
        axes.set(
            xlabel="time into the drive [s]",
            title=f"bias {bias:+.2f} rad, n = {len(mine)}" if bias else f"no bias, n = {len(mine)}",
        )
        axes.set_xlim(left=0)
        axes.grid(axis="y", lw=0.4, color=RULE)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylim(bottom=0)  # of all, once all is drawn: limits set before would cut what comes later
    panels[0].set_ylabel("error of the joystick model [rad]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure


def write_adaptation(runs: Sequence[AdaptationRun], folder: Path, command: str = "") -> Path:
    """adaptation.png, figures.json and report.html in `folder` -> the report's path."""
    figure = adaptation_figure(runs)
    (folder / "adaptation.png").write_bytes(png(figure))
    write_figures(folder / "figures.json", [run.row() for run in runs])
    text = (
        "A driver whose stick points beside what is meant drives with the heatmaps' assistant, whose joystick model "
        "learns from what is followed. All is simulated: drivers, chair, courses."
    )
    caption = (
        f"Mean over runs in bins of {_BIN:g} s with 95 % bands, while at least half of the runs go on. Dashed: from "
        f"here on the table judges. {origin(runs)}"
    )
    section = Section(TITLE, text, [adaptation_table(runs)], [Picture(figure, caption)])
    made = f"Made by `{command}`" if command else ""
    return write_report(folder / "report.html", TITLE, [section], origin=made)
