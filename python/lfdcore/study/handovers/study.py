"""Real handovers (Sec. 5.3, 6.2.2): how well is the taker's motion foretold from what was seen of the giver?

The giver is the partner, the taker the robot. Demonstrations are split at random; of each one held out a share of the
giver's motion is seen, and the taker's whole motion is compared in normalised time. Nothing about the scene is known
beforehand in these sets, so there is no environment: where a method is told what nobody could know by then, it is
called an oracle.
"""

from __future__ import annotations

import tokenize
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.handovers import KTH_FAULTS, read_dynamic_handovers, read_kth_handovers
from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.errors import DataError
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationInference, CollaborationModel
from lfdcore.study.jobs import run_jobs
from lfdcore.training.collaborations import NoiseChoice, learn_collaboration

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
    "oracle: IP told the phase",
    "oracle: IP told the place",
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
HANDS = ("baton", "hand", "left_hand", "right_hand")


@dataclass(frozen=True, eq=False)
class HandoverTask:
    """One set of handovers, and what is seen and foretold of them."""

    name: str
    description: str
    recordings: tuple[InteractionRecording, ...]

    def __post_init__(self) -> None:
        if len(self.recordings) < 10:
            raise ValueError(f"{self.name} has {len(self.recordings)} handovers, must have at least 10 to be split")


@dataclass(frozen=True, kw_only=True)
class HandoverStudy:
    """What is to be judged: every task in `splits` random splits by demonstration."""

    tasks: tuple[HandoverTask, ...]
    splits: int = 10
    seed: int = 1

    def __post_init__(self) -> None:
        if self.splits < 1:
            raise ValueError(f"splits is {self.splits}, must be at least 1")


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


# -- the sets -------------------------------------------------------------------------------------------------------


def handover_tasks(paths: Sequence[Path]) -> tuple[HandoverTask, ...]:
    """What is judged of these files, whose contents tell which set they are: of kth_handover_6d positions and poses
    without tracking faults and positions with them, of dynamic_handover_120 the giver's hands and her 15 joints.
    DataError naming the file for any other."""
    return tuple(task for path in paths for task in _TASKS[_set_of(path)](path))


def _set_of(path: Path) -> str:
    try:
        with np.load(path, allow_pickle=False) as archive:
            names = set(archive.files)
    except (
        ValueError,
        TypeError,
        EOFError,
        zipfile.BadZipFile,
        AttributeError,
        tokenize.TokenError,
        SyntaxError,
    ) as broken:
        raise DataError(f"{path}: is no .npz file of handovers: {broken}") from broken
    if {"giver", "receiver", "lengths"} <= names:
        return "dynamic"
    if names and all(name.startswith(("train_", "test_")) for name in names):
        return "kth"
    raise DataError(f"{path}: is neither kth_handover_6d nor dynamic_handover_120: it holds {sorted(names)[:5]}")


def _kth_tasks(path: Path) -> list[HandoverTask]:
    everything = [every_nth(one, 4) for one in read_kth_handovers(path, with_faults=True)]
    sound = [one for one in everything if one.name not in KTH_FAULTS]
    return [
        HandoverTask("KTH, positions", "baton and hand, positions alone", tuple(positions_of(one) for one in sound)),
        HandoverTask("KTH, poses", "baton and hand with their orientations", tuple(sound)),
        HandoverTask(
            "KTH, positions, with faults",
            f"as the first, with {len(everything) - len(sound)} recordings whose tracking failed",
            tuple(positions_of(one) for one in everything),
        ),
    ]


def _dynamic_tasks(path: Path) -> list[HandoverTask]:
    hands, skeleton = read_dynamic_handovers(path), read_dynamic_handovers(path, partner="skeleton")
    return [
        HandoverTask("Dynamic, hands", "the giver's two hands; the taker's two hands", tuple(hands)),
        HandoverTask("Dynamic, skeleton", "the giver's 15 joints; the taker's two hands", tuple(skeleton)),
    ]


_TASKS: dict[str, Callable[[Path], list[HandoverTask]]] = {"kth": _kth_tasks, "dynamic": _dynamic_tasks}


def every_nth(one: InteractionRecording, n: int) -> InteractionRecording:
    """Every n-th sample."""
    return replace(one, stamp=one.stamp[::n], partner=one.partner[::n], robot=one.robot[::n])


def positions_of(one: InteractionRecording) -> InteractionRecording:
    """Without the columns of orientations."""
    partner, robot = _positions(one.partner_names), _positions(one.robot_names)
    return replace(
        one,
        partner=one.partner[:, partner],
        robot=one.robot[:, robot],
        partner_names=tuple(one.partner_names[k] for k in partner),
        robot_names=tuple(one.robot_names[k] for k in robot),
    )


def _positions(names: Sequence[str]) -> list[int]:
    return [k for k, name in enumerate(names) if name.rpartition(".")[2] in ("x", "y", "z")]


def hand_columns(names: Sequence[str]) -> Indices:
    """(hands, 3) where the hands' x, y and z are among the columns."""
    return np.array(
        [[names.index(f"{hand}.{axis}") for axis in "xyz"] for hand in HANDS if f"{hand}.x" in names]
    ).reshape(-1, 3)


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
    """Foretells the taker's motion of the demonstration whose giver moved most alike in the seconds seen: the least RMS
    distance of all of the giver's positions, sample by sample from the start; a shorter one rests at its end."""

    def __init__(self, demonstrations: Sequence[InteractionRecording]) -> None:
        self._demonstrations = demonstrations
        self._columns = _positions(demonstrations[0].partner_names)

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
        """Who teaches and who is tested; the same for tasks with as many recordings."""
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
        self.factors = (_factor(self.learned[0]), _factor(self.learned[1]))
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


def _factor(model: CollaborationModel) -> float:
    """Which of NOISE.factors was chosen."""
    rows = model.metadata["noise_choice"]
    return float(NOISE.factors[int(np.argmin([error for _, error in rows]))])


def run_handover_study(
    study: HandoverStudy, tell: Callable[[str, int, int], None], processes: int | None = None
) -> tuple[TaskErrors, ...]:
    """Judges every task; the result does not depend on the number of processes."""
    results = []
    for task in study.tasks:
        jobs = [HandoverSplit(task, k, study.seed) for k in range(study.splits)]
        results.append(TaskErrors(task, run_jobs(jobs, partial(tell, task.name), processes)))
    return tuple(results)
