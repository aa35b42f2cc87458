"""Real handovers (Sec. 5.3, 6.2.2): how well is the taker's motion predicted from what was seen of the giver?

The giver is the partner, the taker the robot. Demonstrations are split at random; of each one held out a share of the
giver's motion is seen, and the taker's whole motion is compared in normalised time. Nothing about the scene is known
beforehand in these sets, so there is no environment. A method that is given what nobody could know by then is called an
oracle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationInference, CollaborationModel
from lfdcore.progress import StageProgress, silent
from lfdcore.study.handovers.tasks import HandoverTask, hand_columns, handover_tasks, position_columns
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Study
from lfdcore.training.collaborations import NoiseChoice, learn_collaboration, noise_factor

Array = NDArray[np.float64]
Indices = NDArray[np.int_]

SHARES = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
"""of the giver's motion that are seen; 0: the first sample alone"""
METHODS = (
    "IP, phase by time warping",
    "IP, forcing (as printed)",
    "IP, phase by the clock",
    "IP",
    "mean trajectory",
    "nearest demonstration",
    "oracle: phase given",
    "oracle: place given",
)
WARPED, LIKELIEST, MEAN, NEAREST = (
    METHODS.index(name) for name in ("IP, phase by time warping", "IP", "mean trajectory", "nearest demonstration")
)
MEASURES = ("over time", "at the end", "at the handover")
"""RMS distances of the taker's hands [m]: over the whole motion, at its last sample, and where giver and taker are
closest"""
NOISE = NoiseChoice(factors=(1.0, 10.0, 100.0, 1e3, 1e4, 1e6), folds=2, shares=(0.2, 0.6))
"""how sigma^2 is chosen in each split, from its training demonstrations alone"""
STEPS = 100
"""of a motion"""
TESTED = 0.2
"""share of the demonstrations held out in a split"""


@dataclass(frozen=True, kw_only=True)
class HandoverStudy(Study):
    """Real handovers: error of the predicted taker by share observed, for IP and baselines, with intervals."""

    name = "handovers"
    title = "real handovers"

    data: Annotated[tuple[Path, ...], Option("kth_handover_6d.npz, dynamic_handover_120.npz or both.", flag="argument")]
    splits: Annotated[int, Option("Random splits by demonstration.", minimum=1)] = 10

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.data:
            raise ValueError("data is empty, must be at least one file")
        if len({path.resolve() for path in self.data}) < len(self.data):
            raise ValueError(f"a file of data is given twice: {', '.join(map(str, self.data))}")


@dataclass(frozen=True, eq=False)
class SplitErrors:
    """One split of a task."""

    tested: Indices
    """(K,) which recordings were held out"""
    errors: Array
    """(K, methods, shares, measures) [m]"""
    factors: tuple[float, float]
    """of the fit's residual that were chosen as sigma^2, for positions and for the forcing function"""


@dataclass(frozen=True, eq=False)
class TaskErrors:
    """All splits of a task."""

    task: HandoverTask
    splits: tuple[SplitErrors, ...]

    @property
    def tested(self) -> Indices:
        """(n,) the recording of each row of `errors`"""
        return np.concatenate([split.tested for split in self.splits])

    @property
    def errors(self) -> Array:
        """(n, methods, shares, measures) [m]"""
        return np.concatenate([split.errors for split in self.splits])

    @property
    def split_means(self) -> Array:
        """(splits, methods, shares, measures) [m]"""
        return np.stack([split.errors.mean(axis=0) for split in self.splits])

    @property
    def spread(self) -> Array:
        """(methods, shares, measures) [m] standard deviation of the splits' means; NaN of one split"""
        means = self.split_means
        return np.asarray(means.std(axis=0, ddof=1)) if len(means) > 1 else np.full(means.shape[1:], np.nan)


@dataclass(frozen=True, eq=False)
class HandoverResult:
    """All tasks."""

    study: HandoverStudy
    tasks: tuple[TaskErrors, ...]


# -- the methods ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Truth:
    """What one taker did."""

    hands: Array
    """(steps, H, 3) [m]"""
    meeting: int
    """the step in which a hand of the giver and one of the taker are closest"""

    @staticmethod
    def of(one: InteractionRecording) -> Truth:
        """In STEPS even steps."""
        even = one.resample(STEPS, np.inf)
        given = even.partner[:, hand_columns(one.partner_names)]
        taken = even.robot[:, hand_columns(one.robot_names)]
        apart = np.linalg.norm(given[:, :, None] - taken[:, None], axis=-1).reshape(STEPS, -1).min(axis=1)
        return Truth(taken, int(np.argmin(apart)))

    def errors(self, hands: Array) -> Array:
        """(steps, H, 3) -> (measures,) [m]"""
        square = ((hands - self.hands) ** 2).sum(axis=-1).mean(axis=1)
        return np.asarray(np.sqrt([square.mean(), square[-1], square[self.meeting]]))


def with_place(one: InteractionRecording) -> InteractionRecording:
    """With the place of the handover (the taker's closer hand where the two are closest) as environment: an oracle,
    it is known only afterwards."""
    truth, even = Truth.of(one), one.resample(STEPS, np.inf)
    given = even.partner[truth.meeting, hand_columns(one.partner_names)]
    taken = truth.hands[truth.meeting]
    closest = np.linalg.norm(given[:, None] - taken, axis=-1).min(axis=0).argmin()
    return replace(one, environment=dict(zip(("place.x", "place.y", "place.z"), taken[closest].tolist(), strict=True)))


class NearestDemonstration:
    """Predicts the taker's motion of the demonstration whose giver moved most alike in the seconds seen: the least RMS
    distance of all of the giver's positions, sample by sample from the start; a shorter one rests at its end."""

    def __init__(self, demonstrations: Sequence[InteractionRecording]) -> None:
        self._demonstrations = demonstrations
        self._columns = position_columns(demonstrations[0].partner_names)

    def index(self, partial: InteractionRecording) -> int:
        """Of the demonstration."""
        at = partial.stamp - partial.stamp[0]
        seen = partial.partner[:, self._columns]
        return int(np.argmin([np.mean((self._at(one, at) - seen) ** 2) for one in self._demonstrations]))

    def _at(self, one: InteractionRecording, at: Array) -> Array:
        stamps = one.stamp - one.stamp[0]
        return np.stack([np.interp(at, stamps, one.partner[:, k]) for k in self._columns], axis=1)


def infer_by_clock(model: CollaborationModel, partial: InteractionRecording, duration: float) -> CollaborationInference:
    """As model.infer, but the phase is the time since the start over `duration` [s]: by the clock with the mean of the
    demonstrations' durations; an oracle with the true one, which nobody knows."""
    shares = (partial.stamp - partial.stamp[0]) / duration
    kept = shares <= 1 + 1e-9
    phases = np.exp(-float(model.primitive.config.dmp.phase_decay) * shares[kept].clip(0, 1))
    posterior = model.primitive.condition(partial.partner[kept], phases)
    share, width = float(shares[kept][-1]), len(model.partner_names)
    return CollaborationInference(posterior, None, share, duration, model.robot, width, model.config.steps)


@dataclass(frozen=True, eq=False)
class HandoverSplit:
    """One random split of one task, as it is sent to a process."""

    task: HandoverTask
    split: int
    seed: int

    def parts(self) -> tuple[Indices, Indices]:
        """Which recordings are learned from and which are tested; the same for tasks with as many recordings."""
        n = len(self.task.recordings)
        order = np.random.default_rng([self.seed, self.split]).permutation(n)
        tested = max(1, round(TESTED * n))
        return np.sort(order[tested:]), np.sort(order[:tested])

    def run(self) -> SplitErrors:
        """Learns and judges."""
        learn, test = self.parts()
        demonstrations = [self.task.recordings[k] for k in learn]
        methods = _Methods(demonstrations)
        errors = np.stack([methods.errors(self.task.recordings[k]) for k in test])
        return SplitErrors(test, errors, methods.factors)


class _Methods:
    """All METHODS, learned from the same demonstrations."""

    def __init__(self, demonstrations: Sequence[InteractionRecording]) -> None:
        plain = CollaborationConfig(environment=False, steps=STEPS)
        forcing = replace(plain, observe="forcing", phase="warped")
        self.learned = [learn_collaboration(demonstrations, config, NOISE) for config in (plain, forcing)]
        self.factors = (noise_factor(self.learned[0]), noise_factor(self.learned[1]))
        placed = replace(plain, environment=True, noise=self.learned[0].primitive.config.noise)
        self.placed = CollaborationModel.fit([with_place(one) for one in demonstrations], placed)
        self.warped = CollaborationModel.fit(demonstrations, replace(placed, environment=False, phase="warped"))
        self.nearest = NearestDemonstration(demonstrations)
        self.taken = [Truth.of(one).hands for one in demonstrations]
        self.hands = hand_columns(demonstrations[0].robot_names)

    def errors(self, one: InteractionRecording) -> Array:
        """(methods, shares, measures) of one held out."""
        truth, place = Truth.of(one), with_place(one).environment
        mean = np.mean(self.taken, axis=0)
        positions, forcing = self.learned
        found = []
        for share in SHARES:
            seen = one.partial(share=share)
            said = (
                self._taken(self.warped.infer(seen)),
                self._taken(forcing.infer(seen)),
                self._taken(infer_by_clock(positions, seen, positions.duration)),
                self._taken(positions.infer(seen)),
                mean,
                self.taken[self.nearest.index(seen)],
                self._taken(infer_by_clock(positions, seen, one.duration)),
                self._taken(self.placed.infer(seen, place)),
            )
            found.append([truth.errors(hands) for hands in said])
        return np.swapaxes(np.array(found), 0, 1)

    def _taken(self, said: CollaborationInference) -> Array:
        return said.robot_motion()[:, self.hands]


def judge_handovers(
    study: HandoverStudy, tasks: Sequence[HandoverTask], tell: StageProgress = silent
) -> HandoverResult:
    """Judges every task; the result does not depend on the number of processes."""
    judged = []
    for task in tasks:
        jobs = [HandoverSplit(task, k, study.seed) for k in range(study.splits)]
        judged.append(TaskErrors(task, run_jobs(jobs, partial(tell, task.name), study.processes)))
    return HandoverResult(study, tuple(judged))


def run_handover_study(study: HandoverStudy, tell: StageProgress = silent) -> HandoverResult:
    """Reads the files and judges. DataError as handover_tasks."""
    return judge_handovers(study, handover_tasks(study.data), tell)
