"""The report of study sequences: right answers by share observed, refusals and switches."""

from __future__ import annotations

from pathlib import Path

from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study.report.aims import Aim, aims_table
from lfdcore.study.report.cells import in_a_line, percent_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.table import Table
from lfdcore.study.sequences.pictures import sequence_figure
from lfdcore.study.sequences.study import (
    BACK,
    LEARNED,
    QUESTIONS,
    SHARES,
    TASKS,
    SequenceResult,
    SequenceStudy,
    run_sequence_study,
)
from lfdcore.study.study import Findings

TEXT = (
    "Handwriting shapes (Khansari-Zadeh and Billard 2011) stand for tasks. The filter learns from "
    f"{LEARNED} demonstrations of each; the others are held out. All begin in the origin.\n\n"
    "The filter's widths and transition probabilities were chosen on 25 other triples of the same shapes: combinations "
    "and splits are new here, the shapes are not."
)


def sequence_rows(result: SequenceResult) -> list[dict[str, object]]:
    """Every figure, for machines."""
    return [row for what in QUESTIONS for row in _rows(result, what)]


def _rows(result: SequenceResult, what: str) -> list[dict[str, object]]:
    """A row a share."""
    about = {"question": what, "n": result.count(what), "draws": len(result.draws), "seed": result.study.seed}
    figures = zip(SHARES, *(values.tolist() for values in result.right(what)), strict=True)
    return [about | {"share": share, "right": right, "low": low, "high": high} for share, right, low, high in figures]


def _cells(result: SequenceResult, what: str) -> list[str]:
    """A cell a share."""
    return [percent_cell(*one) for one in zip(*result.right(what), strict=True)]


def sequence_table(result: SequenceResult) -> Table:
    """A row a question, a column a share."""
    rows = [(f"{words}\nn = {result.count(what)}", *_cells(result, what)) for what, words in QUESTIONS.items()]
    return Table(
        f"Right answers by share observed ({len(result.draws)} draws of {TASKS} of {result.shapes} shapes, seed "
        f"{result.study.seed})",
        ("", *(f"{share:.0%}" for share in SHARES)),
        tuple(rows),
        "Below: 95 % interval by a bootstrap of whole draws, which share their shapes: it is too narrow. 'None of "
        "them' counts as wrong for a task that was learned. Second task: after the whole of another and a straight way "
        f"back in {BACK} samples.",
    )


def aims(result: SequenceResult) -> list[Aim]:
    """What was to be reached."""
    share = float(result.right("tasks")[0][SHARES.index(0.3)])
    return [Aim.at_least(0.9, "task named at 30 % observed", share, 3)]


def sequence_headline(result: SequenceResult) -> str:
    """The result in a sentence."""
    parts = []
    for what, share in (("tasks", 0.3), ("foreign", 1.0), ("switches", 0.3)):
        found = in_a_line(_cells(result, what)[SHARES.index(share)])
        parts.append(f"{QUESTIONS[what]} after {share:.0%} in {found} of {result.count(what)}")
    return f"The filter {', '.join(parts)} cases; {len(result.draws)} draws, seed {result.study.seed}."


def findings(result: SequenceResult) -> Findings:
    """Everything that is shown."""
    picture = Picture(sequence_figure(result), "Right answers by share observed; dotted: what was to be reached.")
    tables = [aims_table("Figures to reach", aims(result)), sequence_table(result)]
    return Findings(
        headline=sequence_headline(result),
        sections=[Section("Which task has the partner begun?", TEXT, tables, [picture])],
        rows=sequence_rows(result),
        keys=("question", "share", "seed"),
        aims=aims(result),
    )


def run(study: SequenceStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study sequences."""
    return findings(run_sequence_study(study, tell))
