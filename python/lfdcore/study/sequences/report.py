"""The report of study sequences: right answers by share observed, refusals and switches."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lfdcore import __version__
from lfdcore.pictures.style import PAGE, REFERENCE, RULE, SERIES, Picture, styled
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import block_bootstrap
from lfdcore.study.report.table import Table
from lfdcore.study.sequences.study import BACK, SHARES, TASKS, TAUGHT, DrawAnswers, SequenceStudy, right

QUESTIONS = {
    "tasks": "names the task",
    "foreign": "refuses a foreign task",
    "switches": "names the second task",
}
COLOURS = dict(zip(QUESTIONS, SERIES, strict=False))


def sequence_rows(results: Sequence[DrawAnswers], study: SequenceStudy) -> list[dict[str, object]]:
    """Every figure, for machines."""
    rows: list[dict[str, object]] = []
    for what in QUESTIONS:
        values, draws = right(results, what)
        low, high = block_bootstrap(values, draws, study.seed)
        for k, share in enumerate(SHARES):
            rows.append(
                {
                    "question": what,
                    "n": len(values),
                    "draws": len(results),
                    "seed": study.seed,
                    "share": share,
                    "right": float(values[:, k].mean()),
                    "low": float(low[k]),
                    "high": float(high[k]),
                }
            )
    return rows


def sequence_table(results: Sequence[DrawAnswers], study: SequenceStudy) -> Table:
    """A row a question, a column a share."""
    found = sequence_rows(results, study)
    rows = []
    for what, words in QUESTIONS.items():
        mine = [row for row in found if row["question"] == what]
        cells = [f"{100 * _number(row['right']):.0f} %\n{_bounds(row)}" for row in mine]
        rows.append((f"{words}\nn = {mine[0]['n']}", *cells))
    return Table(
        f"Right answers by share observed ({len(results)} draws of {TASKS} of {len(study.shapes)} shapes, seed "
        f"{study.seed})",
        ("", *(f"{share:.0%}" for share in SHARES)),
        tuple(rows),
        "Below: 95 % interval by a bootstrap of whole draws, which share their shapes: it is too narrow. 'None of "
        "them' counts as wrong for a task that was taught. Second task: after the whole of another and a straight way "
        f"back in {BACK} samples.",
    )


def _number(value: object) -> float:
    return float(value) if isinstance(value, float) else float("nan")


def _bounds(row: dict[str, object]) -> str:
    return f"[{100 * _number(row['low']):.0f}, {100 * _number(row['high']):.0f}]"


def aims(results: Sequence[DrawAnswers]) -> list[Aim]:
    """What was to be reached."""
    share = float(right(results, "tasks")[0][:, SHARES.index(0.3)].mean())
    return [Aim("task named at 30 % observed", ">= 0.90", share, 3, share >= 0.9)]


def aims_table(results: Sequence[DrawAnswers]) -> Table:
    """Figures to reach."""
    rows = tuple((aim.label, aim.wanted, aim.as_text()) for aim in aims(results))
    return Table("Figures to reach", ("", "wanted", "found"), rows)


@styled
def sequence_figure(results: Sequence[DrawAnswers], study: SequenceStudy) -> Figure:
    """Right answers against the share observed."""
    figure = Figure(figsize=(0.6 * PAGE, 3.8), layout="constrained")
    axes = figure.subplots()
    at = 100 * np.array(SHARES)
    for what, words in QUESTIONS.items():
        values, draws = right(results, what)
        low, high = block_bootstrap(values, draws, study.seed)
        axes.plot(at, 100 * values.mean(axis=0), "o-", color=COLOURS[what], ms=3.5, lw=1.6, label=words)
        axes.fill_between(at, 100 * low, 100 * high, color=COLOURS[what], alpha=0.14, lw=0)
    axes.axhline(90, color=REFERENCE, lw=0.8, ls=":")
    axes.set(xlabel="of the motion seen [%]", ylabel="right answers [%]", xlim=(0, 100), ylim=(0, 102))
    axes.grid(color=RULE, lw=0.6)
    axes.legend(loc="lower right")
    return figure


def sequence_headline(results: Sequence[DrawAnswers], study: SequenceStudy) -> str:
    """The result in a sentence."""
    parts = []
    found = sequence_rows(results, study)
    for what, share in (("tasks", 0.3), ("foreign", 1.0), ("switches", 0.3)):
        row = next(one for one in found if (one["question"], one["share"]) == (what, share))
        parts.append(
            f"{QUESTIONS[what]} after {share:.0%} in {100 * _number(row['right']):.0f} % {_bounds(row)} of {row['n']}"
        )
    return f"The filter {', '.join(parts)} cases; {len(results)} draws, seed {study.seed}."


def write_sequence_report(results: Sequence[DrawAnswers], study: SequenceStudy, folder: Path, command: str) -> Path:
    """Writes report.html and figures.json into `folder` -> the report's path. The same results give the same bytes."""
    write_figures(folder / "figures.json", sequence_rows(results, study))
    text = (
        f"Handwriting shapes (Khansari-Zadeh and Billard 2011) stand for tasks: {TAUGHT} demonstrations of each teach, "
        "the others are held out. All begin in the origin.\n\n"
        "The filter's widths and transition probabilities were chosen on 25 other triples of the same shapes: "
        "combinations and splits are new here, the shapes are not."
    )
    picture = Picture(
        sequence_figure(results, study), "Right answers by share observed; dotted: what was to be reached."
    )
    tables = [aims_table(results), sequence_table(results, study)]
    origin = f"lfdcore {__version__}, seed {study.seed}. Made by: `{command}`"
    section = Section("Which task has the partner begun?", text, tables, [picture])
    lead = sequence_headline(results, study)
    return write_report(folder / "report.html", "lfdcore: sequences of tasks", [section], lead, origin)
