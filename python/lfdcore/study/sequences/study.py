"""Which task has the partner begun (Sec. 6.2.2)? The HMM over primitives on three handwriting shapes at a time.

A shape is a task. The filter learns from five of its seven demonstrations; two are held out. Each begins in the origin,
so that only the motion tells shapes apart; a sample is a position and its difference from the one before. A fourth
shape, from which nothing was learned, is to be refused. After the whole of one shape, the way back and a part of
another, the filter is to name the other.

SequenceConfig's defaults were chosen on the triples of `tuned_on`. None of those is drawn here, but their 15 shapes are
the same: only combinations and splits are new.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.lasa import Handwriting, read_all_handwriting
from lfdcore.primitives import SequenceHmm
from lfdcore.progress import StageProgress, silent
from lfdcore.study.jobs import run_jobs
from lfdcore.study.report.statistics import block_bootstrap
from lfdcore.study.study import Option, Study

Array = NDArray[np.float64]
SHARES = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
"""of a motion that are seen"""
QUESTIONS = {
    "tasks": "names the task",
    "foreign": "refuses a foreign task",
    "switches": "names the second task",
}
TASKS = 3
LEARNED = 5
"""demonstrations of each shape to learn from"""
STRIDE = 10
"""every so many recorded samples are seen"""
BACK = 40
"""samples of the way back to the start before the next task"""
NONE = -1


@dataclass(frozen=True, kw_only=True)
class SequenceStudy(Study):
    """Three handwriting shapes as tasks: which has begun, foreign ones, switches, by share observed."""

    name = "sequences"
    title = "sequences of tasks"

    data: Annotated[Path, Option("Folder with the LASA handwriting shapes (.mat).", flag="argument")]
    draws: Annotated[int, Option("Draws of three shapes.", minimum=1)] = 40


@dataclass(frozen=True, eq=False)
class DrawAnswers:
    """What the filter said in one draw."""

    names: tuple[str, ...]
    """of the three tasks, then of the foreign one"""
    said: NDArray[np.int_]
    """(motions, shares) the task said of motions of the three tasks, NONE = none of them"""
    tasks: NDArray[np.int_]
    """(motions,) the right answers"""
    foreign: NDArray[np.int_]
    """(motions, shares) of a task that was not learned: right is NONE"""
    after: NDArray[np.int_]
    """(switches, shares) by share of a second task"""
    second: NDArray[np.int_]
    """(switches,) the right answers"""


@dataclass(frozen=True, eq=False)
class Draw:
    """One draw, as it is sent to a process."""

    motions: tuple[tuple[Array, ...], ...]
    """of three tasks and a foreign one, each all its demonstrations (T, 4)"""
    names: tuple[str, ...]
    order: NDArray[np.int_]
    """of the demonstrations: the first LEARNED are learned from"""

    def run(self) -> DrawAnswers:
        """Learns and asks."""
        learned, held_out = self.order[:LEARNED], self.order[LEARNED:]
        hmm = SequenceHmm.fit([[one[k] for k in learned] for one in self.motions[:TASKS]])
        cases = list(product(range(TASKS), held_out))
        said = [answers(hmm, self.motions[task][k]) for task, k in cases]
        foreign = [answers(hmm, self.motions[TASKS][k]) for k in held_out]
        pairs = [(a, b) for a, b in product(range(TASKS), range(TASKS)) if a != b]
        k = held_out[0]
        after = [answers(hmm, self.motions[b][k], before(self.motions[a][k])) for a, b in pairs]
        return DrawAnswers(
            self.names,
            np.array(said),
            np.array([task for task, _ in cases]),
            np.array(foreign),
            np.array(after),
            np.array([b for _, b in pairs]),
        )


def answers(hmm: SequenceHmm, motion: Array, before: Array | None = None) -> list[int]:
    """What is recognised after each of SHARES of the motion (T, 4), seen after `before`."""
    hmm.reset()
    for sample in before if before is not None else ():
        hmm.observe(sample)
    ends = {max(1, round(share * len(motion))): k for k, share in enumerate(SHARES)}
    said = [NONE] * len(SHARES)
    for count, sample in enumerate(motion, 1):
        recognised = hmm.observe(sample).recognised
        if count in ends:
            said[ends[count]] = recognised
    return said


def before(motion: Array) -> Array:
    """A whole motion and the straight way back to its start, which is part of no task."""
    back = np.linspace(motion[-1, :2], motion[0, :2], BACK + 1)[1:]
    return np.vstack([motion, np.hstack([back, np.diff(back, axis=0, prepend=motion[-1:, :2])])])


def samples(positions: Array) -> Array:
    """(T, 2) [mm] -> (T / STRIDE, 4): from the origin, and differences."""
    few = positions[::STRIDE]
    return np.hstack([few - few[0], np.diff(few, axis=0, prepend=few[:1])])


def tuned_on(shapes: int) -> set[frozenset[int]]:
    """The triples of shapes, by number, on which SequenceConfig's defaults were chosen (tests/py/primitives)."""
    random, triples = np.random.default_rng(0), set()
    for _ in range(25):
        *triple, _fourth = random.choice(shapes, TASKS + 1, replace=False).tolist()
        random.permutation(7)
        triples.add(frozenset(triple))
    return triples


def draws_of(study: SequenceStudy, shapes: Sequence[Handwriting]) -> list[Draw]:
    """Triples that were not tuned on (unless all were), each with a foreign shape and a split. ValueError for too few
    shapes or demonstrations of one."""
    _require_enough(shapes)
    random, used = np.random.default_rng([study.seed, 5]), tuned_on(len(shapes))
    if len(shapes) < 10:  # too few for others
        used = set()
    motions = [tuple(samples(one) for one in shape.positions) for shape in shapes]
    made: list[Draw] = []
    while len(made) < study.draws:
        chosen = random.choice(len(motions), TASKS + 1, replace=False).tolist()
        order = random.permutation(min(len(motions[k]) for k in chosen))
        if frozenset(chosen[:TASKS]) not in used:
            made.append(Draw(tuple(motions[k] for k in chosen), tuple(shapes[k].name for k in chosen), order))
    return made


def _require_enough(shapes: Sequence[Handwriting]) -> None:
    if len(shapes) <= TASKS:
        raise ValueError(f"there are {len(shapes)} shapes, must be more than {TASKS}")
    for shape in shapes:
        if len(shape.positions) <= LEARNED:
            raise ValueError(f"{shape.name} has {len(shape.positions)} demonstrations, must have more than {LEARNED}")


_RIGHT: dict[str, Callable[[DrawAnswers], NDArray[np.bool_]]] = {
    "tasks": lambda one: one.said == one.tasks[:, None],
    "foreign": lambda one: one.foreign == NONE,
    "switches": lambda one: one.after == one.second[:, None],
}


def right(results: Sequence[DrawAnswers], what: str) -> tuple[Array, NDArray[np.int_]]:
    """Right answers (n, shares), 1 or 0, and the draw (n,) of each, to one of QUESTIONS."""
    each = [np.asarray(_RIGHT[what](one), np.float64) for one in results]
    return np.concatenate(each), np.repeat(np.arange(len(each)), [len(one) for one in each])


@dataclass(frozen=True, eq=False)
class SequenceResult:
    """All draws."""

    study: SequenceStudy
    shapes: int
    """how many were drawn from"""
    draws: tuple[DrawAnswers, ...]

    def count(self, what: str) -> int:
        """Answers to one of QUESTIONS."""
        return len(right(self.draws, what)[0])

    def right(self, what: str) -> tuple[Array, Array, Array]:
        """Of the answers to one of QUESTIONS the share (shares,) that is right, and its 95 % interval (low, high) by a
        bootstrap of whole draws."""
        values, draws = right(self.draws, what)
        return values.mean(axis=0), *block_bootstrap(values, draws, self.study.seed)


def ask_in_draws(study: SequenceStudy, shapes: Sequence[Handwriting], tell: StageProgress = silent) -> SequenceResult:
    """Asks the filter in every draw of these shapes; the result does not depend on the number of processes."""
    draws = run_jobs(draws_of(study, shapes), partial(tell, "draws"), study.processes)
    return SequenceResult(study, len(shapes), draws)


def run_sequence_study(study: SequenceStudy, tell: StageProgress = silent) -> SequenceResult:
    """Reads the shapes and asks. DataError as read_all_handwriting, ValueError as draws_of."""
    return ask_in_draws(study, read_all_handwriting(study.data), tell)
