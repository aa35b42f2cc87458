"""The report of study safety: collisions per 100 km by assistant and condition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import isnan, nan
from pathlib import Path

import numpy as np

from lfdcore.control import SupervisorConfig
from lfdcore.pictures.course import arm_name
from lfdcore.progress import StageProgress
from lfdcore.simulated.people import PeopleConfig
from lfdcore.study.report.aims import Aim, reached_of
from lfdcore.study.report.cells import NONE, figure_cell, mean_cell, share_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import paired_ratio, poisson_rate, proportion
from lfdcore.study.report.table import Row, Table
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.study.safety.errands import AMONG_PEOPLE, COURSE, DOORS, ERRANDS
from lfdcore.study.safety.hostile_run import HostileCounts
from lfdcore.study.safety.standing import LONGEST
from lfdcore.study.safety.study import SafetyResult, SafetyStudy, run_safety_study
from lfdcore.study.study import Findings

RIVAL = "none"


COUNTED = (
    "driven\n[km]",
    "touched what\na scan showed",
    "per 100 km",
    "nose met a\nperson shown",
    "stood,\nper hour",
)
"""What both tables have of each row."""
STOOD = (
    f"Stood: for longer than {LONGEST:g} s in no mode that stops the chair, while the stick asked for a motion that is "
    f"free for {LONGEST:g} s in the true map, with {SupervisorConfig().margin:g} m and three standard deviations of a "
    "range around the chair."
)


def promised(study: SafetyStudy) -> list[str]:
    """The conditions of a study under which the chair touches nothing that stands, as is promised."""
    return [name for name in study.conditions if CONDITIONS[name].promised]


def promised_table(result: SafetyResult) -> Table:
    """A row an assistant: all those conditions together."""
    names = promised(result.study)
    note = (
        f"Together: {', '.join(names)}. In brackets: 95 % interval of Garwood (Poisson), whose upper end is what is "
        "given as at most."
    )
    rows = []
    for arm in result.study.arms:
        mine = _under(result, names, arm)
        rows.append((arm_name(arm), _at_most(mine), *_counted(mine)))
    header = ("assistant", "per 100 km,\nat most", *COUNTED)
    return Table("Under the conditions that promise no collision", header, tuple(rows), note)


def collisions_table(result: SafetyResult) -> Table:
    """A row a condition and an assistant."""
    study = result.study
    note = (
        f"{len(study.courses)} courses, in each {study.runs} runs of {study.seconds} s, or until something is touched, "
        "of each stick: "
        f"{', '.join(study.sticks)}; seeds {study.seed}.."
        f"{study.seed + study.runs - 1}. In brackets: 95 % interval of Garwood (Poisson). "
        "What no scan showed: the chair begins anywhere, and creeps into space that no beam has seen. A dagger: "
        "nothing is promised under this condition. Moving, halted: shares of the ticks. Halted: in a mode that stops "
        "the chair."
    )
    header = ("condition\nassistant", *COUNTED, "touched what\nnone showed", "moving\nhalted")
    rows = tuple(_row(result, condition, arm) for condition in study.conditions for arm in study.arms)
    return Table("Condition by condition", header, rows, note)


def _row(result: SafetyResult, condition: str, arm: str) -> Row:
    mine = _under(result, [condition], arm)
    dagger = "" if CONDITIONS[condition].promised else " \N{DAGGER}"
    return (
        f"{condition}{dagger}\n{arm_name(arm)}",
        *_counted(mine),
        str(sum(one.unseen_collisions for one in mine)),
        f"{sum(one.moving for one in mine) / len(mine):.2f}\n{sum(one.halted for one in mine) / len(mine):.3f}",
    )


def _under(result: SafetyResult, conditions: Sequence[str], arm: str) -> list[HostileCounts]:
    return [one for name in conditions for one in result.of(condition=name, arm=arm)]


def _counted(counts: Sequence[HostileCounts]) -> Row:
    """Cells of COUNTED."""
    collisions, stood = sum(one.collisions for one in counts), sum(one.stood for one in counts)
    hours = sum(one.lasted for one in counts) / 3600
    return (
        f"{_km(counts):.2f}",
        str(collisions),
        _per_100_km(counts),
        str(sum(one.nose_met_seen for one in counts)),
        f"{stood / hours:.2f}\n{stood} in {hours:.1f} h",
    )


def _km(counts: Sequence[HostileCounts]) -> float:
    return sum(one.distance for one in counts) / 1000


def _per_100_km(counts: Sequence[HostileCounts]) -> str:
    rate, low, high = _rate(counts)
    return figure_cell(rate, low, high, digits=0)


def _at_most(counts: Sequence[HostileCounts]) -> str:
    return figure_cell(_rate(counts)[2], digits=1)


def _rate(counts: Sequence[HostileCounts]) -> tuple[float, float, float]:
    """Collisions per 100 km and their interval; NaN where nothing was driven."""
    km = _km(counts)
    if km == 0:
        return nan, nan, nan
    rate, low, high = poisson_rate(sum(one.collisions for one in counts), 1)
    return 100 / km * rate, 100 / km * low, 100 / km * high


def errands_table(result: SafetyResult) -> Table:
    """A row an errand and an assistant."""
    study = result.study
    note = (
        f"{study.errands} impaired drivers, seeds {study.seed}..{study.seed + study.errands - 1}. Time: of pairs with "
        "the unassisted arm in which both arrive. Progress: along the route, up to where the driver came, on average. "
        f"A door is a gap in a wall, met from beside it and turned. People: {PeopleConfig().count}, who do not give "
        "way to the chair."
    )
    header = ("errand\nassistant", "arrived", "contacts", "nose met a\nperson shown", "time over\nunassisted", "m/s")
    return Table(
        "What caution costs", header, tuple(_errands_row(result, n, a) for n in ERRANDS for a in study.arms), note
    )


def _errands_row(result: SafetyResult, name: str, arm: str) -> Row:
    mine = result.errands_of(name, arm)
    ratio, pairs = _time_ratio(result, name, arm)
    return (
        f"{name}\n{arm_name(arm)}",
        share_cell(sum(one.arrived for one in mine), len(mine)),
        str(sum(one.contacts for one in mine)),
        str(sum(one.nose_met_seen for one in mine)),
        NONE if isnan(ratio) else f"{ratio:.2f}\nn {pairs}",
        mean_cell([one.progress for one in mine], 2),
    )


def _time_ratio(result: SafetyResult, name: str, arm: str) -> tuple[float, int]:
    """Mean time over the rival's, of the pairs in which both arrive; their number."""
    mine, rival = result.errands_of(name, arm), result.errands_of(name, RIVAL)
    if not rival:
        return nan, 0
    both = [one.arrived and other.arrived for one, other in zip(mine, rival, strict=True)]
    return paired_ratio([one.time for one in rival], [one.time for one in mine], both)


def errand_aims(result: SafetyResult) -> list[Aim]:
    """Doors are passed, the standard course takes little longer, and people are no end to getting on."""
    found = []
    for arm in (arm for arm in result.study.arms if arm != RIVAL):
        for door in DOORS:
            mine = result.errands_of(door, arm)
            share, low, high = proportion(sum(one.arrived for one in mine), len(mine))
            found.append(Aim.at_least(0.9, f"arrived: {arm_name(arm)}, {door}", share, 2, low=low, high=high))
        if RIVAL not in result.study.arms:
            continue
        ratio, pairs = _time_ratio(result, COURSE, arm)
        found.append(Aim.at_most(1.15, f"time over unassisted: {arm_name(arm)}, {COURSE}", ratio, 2, note=f"n {pairs}"))
        share = _progress(result, arm) / _progress(result, RIVAL)
        found.append(Aim.at_least(0.5, f"progress over unassisted: {arm_name(arm)}, {AMONG_PEOPLE}", share, 2))
        for what, field in (("wall contacts", "contacts"), ("people met by the nose", "nose_met_seen")):
            met = sum(getattr(one, field) for one in result.errands_of(AMONG_PEOPLE, arm))
            found.append(Aim.at_most(0, f"{what}: {arm_name(arm)}, {AMONG_PEOPLE}", met, 0))
    return found


def _progress(result: SafetyResult, arm: str) -> float:
    return float(np.mean([one.progress for one in result.errands_of(AMONG_PEOPLE, arm)]))


def aims(result: SafetyResult) -> list[Aim]:
    """No collision where that is promised, nobody run into who was shown, and no standing where a free motion is asked
    for."""
    found = []
    for arm in (arm for arm in result.study.arms if arm != RIVAL):
        for condition in promised(result.study):
            mine = result.of(condition=condition, arm=arm)
            about = f"{arm_name(arm)}, {condition}"
            found.append(Aim.at_most(0, f"collisions: {about}", sum(one.collisions for one in mine), 0))
            found.append(Aim.at_most(0, f"stood, a free motion asked for: {about}", sum(one.stood for one in mine), 0))
            if CONDITIONS[condition].run.people is not None:
                met = sum(one.nose_met_seen for one in mine)
                found.append(Aim.at_most(0, f"people met by the nose: {about}", met, 0))
    return found


def findings(result: SafetyResult) -> Findings:
    """Everything that is shown."""
    text = (
        "All is simulated. A random stick is drawn anew after a second on average. The adversarial one sees the true "
        "map and steers at what is nearest. A held one lies where it was put, beside furniture, for the whole run. "
        "This is research software, not a certified medical device.\n\n"
        f"{STOOD}"
    )
    tables = [promised_table(result)] if promised(result.study) else []
    sections = [Section("Hostile sticks", text, [*tables, collisions_table(result)], [])]
    reached = aims(result)
    if result.errands:
        sections.append(Section("Drivers who mean to arrive", "", [errands_table(result)], []))
        reached += errand_aims(result)
    rows = [{**run.about(), **asdict(counts)} for run, counts in zip(result.runs, result.counts, strict=True)]
    rows += [asdict(errand) for errand in result.errands]
    return Findings(
        headline=f"{_headline(result)} {reached_of(reached)}" if reached else _headline(result),
        sections=sections,
        rows=rows,
        keys=("arm", "condition", "stick", "course", "errand", "seed", "seconds"),
        aims=reached,
    )


def _headline(result: SafetyResult) -> str:
    names = promised(result.study)
    which = "under the conditions that promise none" if names else "all conditions together"
    said = []
    for arm in result.study.arms:
        mine = _under(result, names or result.study.conditions, arm)
        said.append(f"{arm_name(arm)}: {sum(one.collisions for one in mine)} in {_km(mine):.1f} km")
    return f"Collisions with what stands, {which}: {'; '.join(said)}."


def run(study: SafetyStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study safety."""
    return findings(run_safety_study(study, folder, tell))
