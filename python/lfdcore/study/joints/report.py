"""The report of study joints: what each space is better at, what comes nearest to the object, times, a picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lfdcore.humanoid.baxter import ARM_PARTS
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study.joints.pictures import joint_space_figure
from lfdcore.study.joints.study import (
    FOLLOWED,
    GRIPPER,
    JOINTS,
    SPACES,
    ArmTrial,
    JointSpaceResult,
    JointSpaceRun,
    JointSpaceStudy,
    run_joint_space_study,
)
from lfdcore.study.report.cells import figure_cell, p_cell, summary_cell
from lfdcore.study.report.page import Section
from lfdcore.study.report.statistics import PairedTest, paired_test, summarise, summarise_bounded
from lfdcore.study.report.table import Row, Table
from lfdcore.study.study import Findings

KINDS = {"known objects": False, "novel objects": True}


@dataclass(frozen=True)
class Quantity:
    """What is compared, as shown; smaller is better unless `more` is."""

    label: str
    value: Callable[[ArmTrial], float]
    digits: int
    more: bool | None = False
    """None: neither is better"""
    bounded: bool = False
    """a share of the motions, in percent"""


_NOT_SENT = Quantity("cannot be sent to the arm [%]", lambda one: 100.0 * (one.outcome != FOLLOWED), 1, bounded=True)
QUANTITIES = (
    Quantity("gripper off, RMS [mm]", lambda one: 1e3 * one.position_error, 1),
    Quantity("orientation off, RMS [degrees]", lambda one: float(np.degrees(one.rotation_error)), 2),
    Quantity("covered, no contact [%]", lambda one: 100.0 * one.covered, 1, True, True),
    Quantity("... of the mouth alone [%]", lambda one: 100.0 * one.covered_by_mouth, 1, True, True),
    Quantity("mouth to object, nearest [mm]", lambda one: 1e3 * one.mouth, 1, more=None),
    Quantity("arm to object, nearest [mm]", lambda one: 1e3 * min(one.arm), 1, more=None),
    Quantity("beyond position limits [%]", lambda one: 100.0 * (one.beyond > 0), 1, bounded=True),
    Quantity("too fast before slowed down [%]", lambda one: 100.0 * (one.slowdown > 1 + 1e-9), 1, bounded=True),
    _NOT_SENT,
    Quantity("from position limits, nearest [degrees]", lambda one: float(np.degrees(one.margin)), 1, more=None),
    Quantity("of a velocity limit, largest [%]", lambda one: 100.0 * one.speed, 1, more=None),
    Quantity("robot's own links, nearest [mm]", lambda one: 1e3 * one.clearance, 1, more=None),
)


def _by_seed(result: JointSpaceResult, space: str, novel: bool, quantity: Quantity) -> list[float]:
    """(seeds,) means over objects and people; of what could be judged."""
    means = []
    for run in result.runs:
        chosen = [one for one in run.trials if one.space == space and one.novel == novel]
        values = np.array([quantity.value(one) for one in chosen])
        finite = values[np.isfinite(values)]
        means.append(float(finite.mean()) if len(finite) else float("nan"))
    return means


def compared(result: JointSpaceResult, novel: bool, quantity: Quantity) -> PairedTest:
    """Cartesian less joint space, paired by seed."""
    return paired_test(*(_by_seed(result, space, novel, quantity) for space in SPACES))


def comparison_table(result: JointSpaceResult, kind: str) -> Table:
    """A row a quantity: both spaces, their difference."""
    novel = KINDS[kind]
    n = sum(one.novel == novel for one in result.trials) // len(SPACES)
    rows = tuple(_comparison_row(result, novel, quantity) for quantity in QUANTITIES)
    return Table(
        f"{kind[0].upper()}{kind[1:]}: {n} people and objects, means of {len(result.runs)} seeds "
        f"({result.study.seed} to {result.study.seed + len(result.runs) - 1})",
        ("", JOINTS, GRIPPER, "difference", "p"),
        rows,
        "Mean+-standard deviation over seeds, below it the 95 % interval of the mean; p: Wilcoxon's signed "
        f"rank over seeds, 1 where they do not differ. Inferred from {result.study.protocol.observed:g} s of the "
        "partner and e. Errors are of the whole motion to the held-out demonstration's, which holds its demonstrator's "
        "own unsteadiness; all else of what is left from the observation's end on, through forward kinematics of the "
        "joints. Nearest: the smallest distance of a motion. In Cartesian space nothing is beyond position limits "
        "because inverse kinematics keeps inside, or fails.",
    )


def _comparison_row(result: JointSpaceResult, novel: bool, quantity: Quantity) -> Row:
    cells = []
    for space in SPACES:
        s = (summarise_bounded if quantity.bounded else summarise)(_by_seed(result, space, novel, quantity))
        cells.append(summary_cell(s, quantity.digits))
    test = compared(result, novel, quantity)
    return (quantity.label, *cells, figure_cell(test.difference, digits=quantity.digits, sign="+"), p_cell(test.p))


def few_table(result: JointSpaceResult) -> Table:
    """With the protocol's demonstrations and with few: what cannot be sent to the arm, and why."""
    protocol, few = result.study.protocol.demonstrations, result.study.few
    rows = [
        _few_row(f"{count} of each object, {space}", runs, space)
        for count, runs in ((protocol, result.runs), (few, result.few))
        for space in SPACES
    ]
    return Table(
        f"What little teaches ({len(result.runs)} seeds, all objects)",
        ("demonstrations", "n", "gripper off [mm]", "covered [%]", "not sent [%]", "why not", "beyond limits"),
        tuple(rows),
        "Means over seeds+-their standard deviation. Not sent: joints outside their position limits or links "
        "that touch in joint space; in Cartesian space also poses out of reach or without a continuous way of the "
        "joints. Beyond limits: how far the farthest inferred joint is outside them, in any motion.",
    )


def _few_row(label: str, runs: Sequence[JointSpaceRun], space: str) -> Row:
    chosen = [[one for one in run.trials if one.space == space] for run in runs]
    every = [one for ones in chosen for one in ones]
    cells = []
    for quantity in (QUANTITIES[0], QUANTITIES[2], _NOT_SENT):
        s = summarise([float(np.mean([quantity.value(one) for one in ones])) for ones in chosen])
        cells.append(figure_cell(s.mean, digits=1, sd=s.sd))
    why = Counter(one.outcome.replace("_", " ") for one in every if one.outcome != FOLLOWED)
    reasons = "\n".join(f"{count} {outcome}" for outcome, count in why.most_common()) or "-"
    return (label, str(len(every)), *cells, reasons, f"{np.degrees(max(one.beyond for one in every)):.1f} degrees")


def nearest_table(result: JointSpaceResult) -> Table:
    """Does the arm or the bag's mouth come nearest to the object?"""
    rows = []
    for kind, novel in KINDS.items():
        for space in SPACES:
            chosen = [one for one in result.trials if one.space == space and one.novel == novel and one.arm[0] >= 0]
            rows.append(_nearest_row(f"{kind}, {space}", chosen))
    return Table(
        "What comes nearest to the object, share of the motions; its smallest distance in any [mm]",
        ("", "n", "mouth", *ARM_PARTS),
        tuple(rows),
        "The left arm as capsules of the URDF's radii up to 8 cm beyond the hand's plate. What lies beyond is not "
        "among them: 2.5 cm of the gripper's body, and the fingers, which hold the mouth.",
    )


def _nearest_row(label: str, chosen: Sequence[ArmTrial]) -> Row:
    names = ("mouth", *ARM_PARTS)
    if not chosen:
        return (label, "0", *("-" for _ in names))
    distances = np.array([(one.mouth, *one.arm) for one in chosen])
    first = Counter(distances.argmin(axis=1).tolist())
    cells = [f"{100 * first[k] / len(chosen):.0f} %\n{1e3 * distances[:, k].min():.0f}" for k in range(len(names))]
    return (label, str(len(chosen)), *cells)


def seconds_by_space(result: JointSpaceResult) -> dict[str, tuple[float, float, float]]:
    """Medians [s] over all trials, as ArmTrial.seconds."""
    found = {}
    for space in SPACES:
        infer, make, check = np.median([one.seconds for one in result.trials if one.space == space], axis=0)
        found[space] = (float(infer), float(make), float(check))
    return found


def time_table(result: JointSpaceResult) -> Table:
    """From observation to joints, as a ratio: seconds are the machine's."""
    found = seconds_by_space(result)
    unchecked = sum(found[GRIPPER]) / sum(found[JOINTS][:2])
    ratios = [f"{b / a:.1f}" for a, b in zip(found[JOINTS][:2], found[GRIPPER][:2], strict=True)]
    whole = sum(found[GRIPPER]) / sum(found[JOINTS])
    times = ", ".join(f"{space} {1e3 * sum(found[space]):.1f} ms" for space in SPACES)
    return Table(
        "Time from observation to joint trajectory, Cartesian / joint space",
        ("", "infer", "make joints", "both", "and look for self-collision"),
        (("ratio", *ratios, f"{unchecked:.1f}", f"{whole:.1f}"),),
        f"Medians of {len(result.trials)} trials, interleaved, one thread each; on this machine {times} in all. "
        "Inverse kinematics keeps from self-collision on its way; joint space knows nothing of it, and is looked at "
        "once at the end.",
    )


def joint_space_tables(result: JointSpaceResult) -> list[Table]:
    """All of them."""
    return [
        *(comparison_table(result, kind) for kind in KINDS),
        few_table(result),
        nearest_table(result),
        time_table(result),
    ]


def better_at(result: JointSpaceResult) -> dict[str, list[str]]:
    """By space, what it is better at with p < .05 over seeds."""
    found: dict[str, list[str]] = {space: [] for space in SPACES}
    for kind, novel in KINDS.items():
        for quantity in QUANTITIES:
            test = compared(result, novel, quantity)
            if quantity.more is None or not test.p < 0.05:
                continue
            winner = GRIPPER if (test.difference > 0) == quantity.more else JOINTS
            found[winner].append(f"{quantity.label.split(' [')[0]} ({kind})")
    return found


def joint_space_headline(result: JointSpaceResult) -> str:
    """The result in sentences."""
    better, seconds = better_at(result), seconds_by_space(result)
    ratio = sum(seconds[GRIPPER]) / sum(seconds[JOINTS])
    parts = [f"{space} is better at {', '.join(better[space]) or 'nothing that shows over seeds'}" for space in SPACES]
    arm = np.mean([min(one.arm) < one.mouth for one in result.trials if one.arm[0] >= 0])
    return (
        f"{'. '.join(part[0].upper() + part[1:] for part in parts)}. From observation to joints Cartesian takes "
        f"{ratio:.1f} times as long. In {100 * arm:.0f} % of the motions the arm, not the bag's mouth, comes nearest "
        f"to the object. n = {len(result.runs)} seeds of simulated people (p < .05, paired)."
    )


def findings(result: JointSpaceResult) -> Findings:
    """Everything that is shown; the same result gives the same, but for the times."""
    counts = [run.demonstrations for run in result.runs]
    left_out = sum(run.left_out for run in result.runs)
    text = (
        "Two models learn from the same demonstrations of the covering task (Sec. 5.6.2; the people are simulated, "
        "simulated/covering.py says how). One learns poses of the left gripper. The other learns the seven joint "
        "angles that follow those poses by inverse kinematics from one first posture, the right arm holding the bag. "
        f"{min(counts)} to {max(counts)} demonstrations a seed; {left_out} that the arm cannot follow were left out of "
        "both. Real demonstrators lead an arm less evenly than inverse kinematics does: joint space is flattered here."
    )
    rounds = ((result.study.protocol.demonstrations, result.runs), (result.study.few, result.few))
    return Findings(
        headline=joint_space_headline(result),
        sections=[Section("Joint space or Cartesian?", text, joint_space_tables(result), [_picture(result.runs[0])])],
        rows=[{"demonstrations": n, **one.row()} for n, runs in rounds for run in runs for one in run.trials],
        keys=("demonstrations", "seed", "space", "covered_object", "novel", "person"),
    )


def _picture(run: JointSpaceRun) -> Picture:
    caption = (
        f"Seed {run.seed}, {run.shown.covered_object} (novel), the first person: seven joints as demonstrated, as "
        "inferred in joint space, and by inverse kinematics of what was inferred in Cartesian space; below, the "
        "gripper's paths."
    )
    return Picture(joint_space_figure(run), caption)


def run(study: JointSpaceStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study joints."""
    return findings(run_joint_space_study(study, tell))
