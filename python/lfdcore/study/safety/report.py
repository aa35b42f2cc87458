"""The report of study safety: collisions per 100 km by assistant and condition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from lfdcore.pictures.course import arm_name
from lfdcore.progress import StageProgress
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import poisson_rate
from lfdcore.study.report.table import Row, Table
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.study.safety.hostile_run import HostileCounts
from lfdcore.study.safety.study import SafetyResult, SafetyStudy, run_safety_study
from lfdcore.study.study import Findings

RIVAL = "none"


def collisions_table(result: SafetyResult) -> Table:
    """A row a condition and an assistant."""
    study = result.study
    header = (
        "condition",
        "assistant",
        "driven\n[km]",
        "collisions with\nwhat a scan showed",
        "per 100 km",
        "with what\nnone showed",
        "person met by the\nnose, was shown",
        "moving",
        "halted",
    )
    note = (
        f"{len(study.courses)} courses, in each {study.runs} runs of {study.seconds} s of each stick: "
        f"{', '.join(study.sticks)}; seeds {study.seed}.."
        f"{study.seed + study.runs - 1}. In brackets: 95 % interval of Garwood (Poisson). "
        "What no scan showed: the chair begins anywhere, and creeps into space that no beam has seen. A dagger: "
        "nothing is promised under this condition."
    )
    rows = tuple(_row(result, condition, arm) for condition in study.conditions for arm in study.arms)
    return Table("Collisions with what stands", header, rows, note)


def _row(result: SafetyResult, condition: str, arm: str) -> Row:
    mine = result.of(condition=condition, arm=arm)
    km, collisions = _km(mine), sum(one.collisions for one in mine)
    return (
        condition if CONDITIONS[condition].promised else f"{condition} \N{DAGGER}",
        arm_name(arm),
        f"{km:.2f}",
        str(collisions),
        _per_100_km(collisions, km),
        str(sum(one.unseen_collisions for one in mine)),
        str(sum(one.nose_met_seen for one in mine)),
        f"{sum(one.moving for one in mine) / len(mine):.2f}",
        f"{sum(one.halted for one in mine) / len(mine):.3f}",
    )


def _km(counts: Sequence[HostileCounts]) -> float:
    return sum(one.distance for one in counts) / 1000


def _per_100_km(collisions: int, km: float) -> str:
    if km == 0:
        return "-"
    rate, low, high = (100 / km * value for value in poisson_rate(collisions, 1))
    return f"{rate:.0f} [{low:.0f}, {high:.0f}]"


def aims(result: SafetyResult) -> list[Aim]:
    """No collision where that is promised, and nobody run into who was shown."""
    found = []
    for arm in (arm for arm in result.study.arms if arm != RIVAL):
        for condition in (name for name in result.study.conditions if CONDITIONS[name].promised):
            mine = result.of(condition=condition, arm=arm)
            about = f"{arm_name(arm)}, {condition}"
            found.append(Aim.at_most(0, f"collisions: {about}", sum(one.collisions for one in mine), 0))
            if CONDITIONS[condition].run.people is not None:
                met = sum(one.nose_met_seen for one in mine)
                found.append(Aim.at_most(0, f"people met by the nose: {about}", met, 0))
    return found


def findings(result: SafetyResult) -> Findings:
    """Everything that is shown."""
    text = (
        "All is simulated. A random stick is drawn anew after a second on average. The adversarial one sees the true "
        "map and steers at what is nearest. A held one lies where it was put, beside furniture, for the whole run. "
        "This is research software, not a certified medical device."
    )
    driven = {arm: result.of(arm=arm) for arm in result.study.arms}
    said = [
        f"{arm_name(arm)}: {sum(one.collisions for one in mine)} in {_km(mine):.1f} km" for arm, mine in driven.items()
    ]
    rows = [{**run.about(), **asdict(counts)} for run, counts in zip(result.runs, result.counts, strict=True)]
    return Findings(
        headline=f"Collisions with what stands, all conditions together: {'; '.join(said)}.",
        sections=[Section("Hostile sticks", text, [collisions_table(result)], [])],
        rows=rows,
        keys=("arm", "condition", "stick", "course", "seed", "seconds"),
        aims=aims(result),
    )


def run(study: SafetyStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study safety."""
    return findings(run_safety_study(study, folder, tell))
