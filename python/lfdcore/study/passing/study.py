"""The passing task judged: interaction primitives with and without the environment (Sec. 5.5, Fig. 5.5-5.7).

For every seed, primitives learn from demonstrations of TRAINING. Then each of as many people passes each rectangle,
known or novel. The first L samples are shown to each arm, and the motion that it completes is judged by its DTW
distance to demonstrations of the same rectangle: those learned from where it is known, else those of the other people.
Beside it: the distance to what that very person did, and whether the path passes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel
from lfdcore.primitives import InteractionPosterior
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.passing import (
    DEMONSTRATIONS,
    NOVEL,
    SEED,
    STEPS,
    TRAINING,
    PassingData,
    Rectangle,
    distance_to_samples,
    dtw_per_sample,
    passing_data,
    passing_verdict,
)
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Seed, Study
from lfdcore.training.collaborations import learn_collaboration, noise_factor

Floats = NDArray[np.float64]
Samples = tuple[InteractionRecording, ...]
Group = Literal["known", "novel"]
LENGTHS = (0, 10, 20, 40, 60, 80, 100, 120, 150)
"""L, samples of the partner that are seen (Fig. 5.7)"""
AXES: dict[str, tuple[str, ...]] = {"both axes": ("mouse.x", "mouse.y"), "horizontal only": ("mouse.x",)}
"""What of the partner is seen: Fig. 5.7a, 5.7b"""
RECTANGLES = TRAINING + NOVEL
GROUPS: tuple[Group, ...] = ("known", "novel")


@dataclass(frozen=True)
class Arm:
    """A way to complete a motion."""

    name: str
    config: CollaborationConfig
    phase_known: bool = False
    """the observation's phases are known instead of estimated"""


def _arms() -> tuple[Arm, ...]:
    ours, printed = CollaborationConfig(steps=STEPS), replace(CollaborationConfig.thesis(), steps=STEPS)
    return tuple(
        Arm(label + suffix, replace(config, environment=environment), phase_known)
        for suffix, config, phase_known in (
            ("", ours, False),
            (", phase given", ours, True),
            (", printed", printed, False),
        )
        for label, environment in (("IP", False), ("EaIP", True))
    )


ARMS = _arms()
"""IP and EaIP by positions; with known phases; by forcing functions, e weighing as printed (thesis)"""


@dataclass(frozen=True, kw_only=True)
class PassingStudy(Study):
    """Passing over rectangles, known and novel, after a glimpse of the partner: Fig. 5.5-5.7, IP beside EaIP."""

    name = "passing"
    title = "passing over a rectangle (Sec. 5.5)"

    seeds: Annotated[int, Option("Repetitions with demonstrations of their own, from --seed on.", minimum=1)] = 10
    demonstrations: Annotated[int, Option("Of each rectangle, to learn from and as many to judge by.", minimum=2)] = (
        DEMONSTRATIONS
    )
    lengths: tuple[int, ...] = LENGTHS
    seed: Seed = SEED

    def __post_init__(self) -> None:
        super().__post_init__()
        if list(self.lengths) != sorted(set(self.lengths)) or self.lengths[:1] + self.lengths[-1:] != (0, STEPS):
            raise ValueError(f"lengths are {self.lengths}, must increase from 0 to {STEPS} samples")


@dataclass(frozen=True, eq=False)
class PassingResult:
    """What came out. Arrays are (seeds, arms, axes, lengths, rectangles, people), as ARMS, AXES, RECTANGLES."""

    study: PassingStudy
    distance: Floats
    """[px per sample] DTW to demonstrations of the same rectangle, mean"""
    own: Floats
    """[px per sample] DTW to what the person who is seen did"""
    passed: NDArray[np.bool_]
    """over the rectangle without touching it"""
    floor: Floats
    """(seeds, rectangles) [px per sample] two people's demonstrations of the same rectangle"""
    factor: Floats
    """(seeds, arms) noise that cross-validation chose, over the fit's residual"""

    def by_seed(self, values: Floats | NDArray[np.bool_], arm: str, axes: str, group: Group) -> Floats:
        """(seeds, lengths) means of one of the arrays over rectangles and people. ValueError for an unknown name."""
        where = ([one.name for one in ARMS].index(arm), list(AXES).index(axes))
        chosen = np.asarray(values, float)[:, where[0], where[1]][:, :, _rectangles(group)]
        return np.asarray(chosen.mean(axis=(2, 3)))

    def floor_by_seed(self, group: Group) -> Floats:
        """(seeds,) [px per sample]"""
        return np.asarray(self.floor[:, _rectangles(group)].mean(axis=1))


def _rectangles(group: Group) -> slice:
    return slice(0, len(TRAINING)) if group == "known" else slice(len(TRAINING), None)


def run_passing_study(study: PassingStudy, tell: StageProgress = silent) -> PassingResult:
    """Learns and judges, a seed a job. The same study gives the same result, whatever the number of processes."""
    jobs = [_Job(study, seed) for seed in range(study.seed, study.seed + study.seeds)]
    runs = run_jobs(jobs, partial(tell, "learn and judge, by seed"), study.processes)
    distance, own, passed = (np.stack(values) for values in zip(*(run.judged for run in runs), strict=True))
    floor, factor = np.stack([run.floor for run in runs]), np.stack([run.factor for run in runs])
    return PassingResult(study, distance, own, passed.astype(bool), floor, factor)


def learned(data: PassingData, arm: Arm) -> CollaborationModel:
    """The arm's model, its noise by cross-validation on the training demonstrations alone."""
    return learn_collaboration(data.training, arm.config)


def completed(
    model: CollaborationModel,
    person: InteractionRecording,
    length: int,
    seen: tuple[str, ...],
    phase_known: bool = False,
) -> InteractionPosterior:
    """p(theta) once the person's first `length` samples of the columns `seen` are known, and the environment where the
    model looks at it. phase_known: of the STEPS samples that the whole motion has."""
    if not length or not phase_known:
        partial_motion = person.first(length).seeing(seen) if length else None
        return model.infer(partial_motion, person.environment).posterior
    values = [person.environment[name] for name in model.environment_names]
    decay = model.primitive.config.dmp.phase_decay
    phases = np.exp(-decay * np.arange(length) / (STEPS - 1))
    return model.primitive.condition(
        person.first(length).seeing(seen).partner, phases, np.array(values) if values else None
    )


def path_of(posterior: InteractionPosterior) -> Floats:
    """(STEPS, 2) [px] the mean motion that the robot draws."""
    return np.array(posterior.trajectory(STEPS).mean[:, -2:])


@dataclass(frozen=True)
class _Run:
    judged: tuple[Floats, Floats, Floats]
    """distance, own, passed: (arms, axes, lengths, rectangles, people)"""
    floor: Floats
    factor: Floats


@dataclass(frozen=True)
class _Case:
    """A person at a rectangle, and whom the path is compared with."""

    rectangle: Rectangle
    person: InteractionRecording
    others: Samples


@dataclass(frozen=True)
class _Job:
    study: PassingStudy
    seed: int

    def run(self) -> _Run:
        data = passing_data(self.seed, self.study.demonstrations)
        models = {config: learned(data, Arm("", config)) for config in {arm.config: None for arm in ARMS}}
        cases = _cases(data)
        judge = partial(_judged, lengths=self.study.lengths, cases=cases)
        judged = np.array([[judge(models[arm.config], arm, seen) for seen in AXES.values()] for arm in ARMS])
        shape = (len(ARMS), len(AXES), len(self.study.lengths), len(RECTANGLES), self.study.demonstrations)
        distance, own, passed = np.moveaxis(judged, -1, 0).reshape(3, *shape)
        floor = np.array([distance_to_samples(case.person.partner, case.others) for case in cases])
        factor = np.array([noise_factor(models[arm.config]) for arm in ARMS])
        return _Run((distance, own, passed), floor.reshape(len(RECTANGLES), -1).mean(axis=1), factor)


def _cases(data: PassingData) -> list[_Case]:
    """Rectangle after rectangle, as RECTANGLES."""
    each = len(data.training) // len(TRAINING)
    learned_from = {r: data.training[k * each : (k + 1) * each] for k, r in enumerate(TRAINING)}
    known = [_Case(r, one, learned_from[r]) for r, several in data.known.items() for one in several]
    novel = [
        _Case(r, one, tuple(other for other in several if other is not one))
        for r, several in data.novel.items()
        for one in several
    ]
    return known + novel


def _judged(
    model: CollaborationModel, arm: Arm, seen: tuple[str, ...], lengths: tuple[int, ...], cases: list[_Case]
) -> Floats:
    """(lengths, cases, 3) distance, own, passed"""
    return np.array([[_verdict(model, arm, seen, length, case) for case in cases] for length in lengths])


def _verdict(
    model: CollaborationModel, arm: Arm, seen: tuple[str, ...], length: int, case: _Case
) -> tuple[float, float, bool]:
    path = path_of(completed(model, case.person, length, seen, arm.phase_known))
    own = dtw_per_sample(path, case.person.partner)
    return distance_to_samples(path, case.others), own, passing_verdict(path, case.rectangle).passed


@dataclass(frozen=True, eq=False)
class PassingExample:
    """One seed's demonstrations and EaIP, to be drawn (Fig. 5.5, 5.6)."""

    seed: int
    data: PassingData
    model: CollaborationModel
    samples: int = 20
    """drawn from each posterior"""

    @staticmethod
    def of(study: PassingStudy) -> PassingExample:
        """The study's first seed."""
        data = passing_data(study.seed, study.demonstrations)
        (arm,) = [arm for arm in ARMS if arm.name == "EaIP"]
        return PassingExample(study.seed, data, learned(data, arm))

    def drawn(self, person: InteractionRecording, length: int) -> tuple[Floats, Floats]:
        """Motions (samples, STEPS, 2) [px] from the posterior after `length` samples, and their mean (STEPS, 2)."""
        posterior = completed(self.model, person, length, AXES["both axes"])
        motions = posterior.sample_trajectories(self.samples, STEPS, self.seed)[:, :, -2:]
        return np.array(motions), path_of(posterior)
