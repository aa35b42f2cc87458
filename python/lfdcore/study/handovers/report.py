"""The report of study handovers: errors against the share observed, differences to the baselines, a picture a task."""

from __future__ import annotations

from pathlib import Path

from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study.handovers.pictures import error_figure
from lfdcore.study.handovers.study import (
    LIKELIEST,
    MEAN,
    NEAREST,
    SHARES,
    STEPS,
    TESTED,
    WARPED,
    HandoverResult,
    HandoverStudy,
    TaskErrors,
    run_handover_study,
)
from lfdcore.study.handovers.tables import handover_rows, intervals, seen_tables, task_tables
from lfdcore.study.report.page import Section
from lfdcore.study.study import Findings

TEXT = (
    "People hand something to each other; the giver is the partner, the taker's hand stands for the robot's. Of each "
    "handover held out a share of the giver's motion is seen. The whole motion of the taker's hand is predicted and "
    f"compared in normalised time ({STEPS} steps). {TESTED:.0%} of the handovers are held out in each split, and "
    "sigma^2 is chosen from those that are learned from.\n\n"
    "Nothing of the scene is known beforehand in these data, so that there is no environment: IP is the plain "
    "interaction primitive. Its phase is where the samples are likeliest (humanoid/partner_phase), which is ours; "
    "by time warping, it is DTW's against the giver's mean motion (5.5), with IP's sigma^2; by the clock, the time "
    "over the demonstrations' mean duration. KTH's recordings were cut to one duration, so that there the clock says "
    "as much as the oracle. Oracles are given what nobody can know by then: the phase, or where the handover takes "
    "place (as e, with IP's sigma^2)."
)
COMPARED_AT = SHARES.index(0.3)


def handover_headline(result: HandoverResult) -> str:
    """What came of it, in a sentence a task, at 30 % observed."""
    parts = [_sentence(task, result.study.seed) for task in result.tasks]
    return (
        f"Taker's hands predicted after 30 % of the giver's motion, RMS over time, {result.study.splits} random "
        f"splits, seed {result.study.seed}. " + " ".join(parts)
    )


def _sentence(result: TaskErrors, seed: int) -> str:
    means = 1e3 * result.errors[:, :, COMPARED_AT, 0].mean(axis=0)
    said = [_verdict(result, way, other, seed) for way in (WARPED, LIKELIEST) for other in (MEAN, NEAREST)]
    return (
        f"{result.task.name} (n = {len(result.task.recordings)}): IP with DTW {means[WARPED]:.0f} mm, {said[0]} the "
        f"mean trajectory ({means[MEAN]:.0f}) and {said[1]} the nearest demonstration ({means[NEAREST]:.0f}); with the "
        f"likeliest phase {means[LIKELIEST]:.0f}, {said[2]} the mean and {said[3]} the nearest."
    )


def _verdict(result: TaskErrors, way: int, other: int, seed: int) -> str:
    errors = result.errors[:, :, COMPARED_AT, 0]
    _, low, high = intervals((errors[:, way] - errors[:, other])[:, None], result.tested, seed)
    if high[0] < 0:
        return "better than"
    return "worse than" if low[0] > 0 else "not distinguishable from"


def handover_sections(result: HandoverResult) -> list[Section]:
    """One a task, and one on what seeing more is worth."""
    seed = result.study.seed
    first, *others = result.tasks
    sections = [_section(first, seed, f"{TEXT}\n\n"), *(_section(task, seed) for task in others)]
    if tables := seen_tables(result.tasks, seed):
        text = "The same recordings and splits, but more of the giver (and, with poses, of the taker) in the model."
        sections.append(Section("Is seeing more better?", text, tables))
    return sections


def _section(result: TaskErrors, seed: int, before: str = "") -> Section:
    chosen = ", ".join(f"{factor:g}" for factor in sorted({split.factors[0] for split in result.splits}))
    text = (
        f"{before}Seen and predicted: {result.task.description}. sigma^2 over the fit's residual, as chosen in the "
        f"splits for positions: {chosen}."
    )
    picture = Picture(
        error_figure(result, seed),
        f"{result.task.name}: error against the share of the giver's motion observed. Bands: 95 % intervals by a "
        "bootstrap of whole demonstrations. Dashed: oracles.",
    )
    return Section(result.task.name, text, task_tables(result, seed), [picture])


def findings(result: HandoverResult) -> Findings:
    """Everything that is shown."""
    return Findings(
        headline=handover_headline(result),
        sections=handover_sections(result),
        rows=handover_rows(result),
        keys=("task", "measure", "method", "share", "seed"),
    )


def run(study: HandoverStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study handovers."""
    return findings(run_handover_study(study, tell))
