"""Covering furniture with a bag: interaction primitives with (EaIP) and without (IP) a look at the scene (Sec. 5.6).

For each seed, demonstrations are drawn from `simulated.covering`. EaIP and IP learn from them: the same code, IP
without e, the noise of both chosen by the same cross-validation. What they infer with people who were not seen in
training is judged: is the object covered without a collision, how far is the motion from the final one (all observed)
and from the held-out demonstration, and what is the partner's motion worth.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationInference, CollaborationModel
from lfdcore.humanoid.covering import CoveringVerdict, covering_verdict
from lfdcore.humanoid.scene import Box, box_of
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.covering import (
    BOUNDING_BOX,
    GROUND_TRUTH,
    PERIOD,
    RIGHT_GRIPPER,
    SEED,
    STEPS,
    CoveringConfig,
    CoveringData,
    CoveringProtocol,
    covering_data,
)
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Seed, Study
from lfdcore.training.collaborations import NoiseChoice, learn_collaboration, noise_factor

Floats = NDArray[np.float64]

METHODS = ("EaIP", "IP")
FORMS = {"positions": CollaborationConfig(), "forcing": CollaborationConfig.thesis()}
"""What of the partner is observed: positions, our default; the forcing function and w_e as printed"""
FEWEST = 10
"""samples that are always observed (Fig. 5.15)"""
SHARES = (0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""of the partner's motion (Fig. 5.15); the first is FEWEST samples"""
PARTNER_SHARES = (0.1, 0.3, 0.5, 0.7)
"""at which is asked what the partner's motion is worth"""
OWN, NOBODY, STRANGER, SHUFFLED = "own partner", "e alone", "another's partner", "learned from shuffled partners"
DIALS = (0.0, 0.2, 0.35, 0.5, 0.75, 1.0)
"""`informative` of the generator"""
CURVE_CHOICE = NoiseChoice(factors=(1.0, 100.0, 1e4), folds=3, shares=(0.1, 0.4))
"""of the curve over DIALS: coarser than elsewhere, and the same for both methods"""
EXAMPLE = "stepladder"
"""the object of Fig. 5.15a"""


@dataclass(frozen=True, kw_only=True)
class CoveringStudy(Study):
    """EaIP and IP cover furniture with a simulated partner: success, Fig. 5.9 and 5.13-5.17, what the partner is worth.

    Writes one repetition's demonstrations too.
    """

    name = "covering"
    title = "covering with environment-adaptive interaction primitives"

    seeds: Annotated[int, Option("Repetitions with demonstrations of their own, from --seed on.", minimum=1)] = 10
    held_out: Annotated[int, Option("Unseen people an object and repetition.", minimum=1, flag="--people")] = 5
    seed: Seed = SEED
    dials: tuple[float, ...] = DIALS
    protocols: tuple[CoveringProtocol, CoveringProtocol] = (GROUND_TRUTH, BOUNDING_BOX)
    """that of Sec. 5.6.1, over which the dials are turned too, and that of 5.6.2"""
    choice: NoiseChoice = field(default_factory=NoiseChoice)
    """of the noise, for both methods; the dials have CURVE_CHOICE"""

    @property
    def all_seeds(self) -> range:
        """Of the data, one a repetition."""
        return range(self.seed, self.seed + self.seeds)


@dataclass(frozen=True)
class CoveringTrial:
    """One method with one person at one object, after the protocol's time of observation."""

    seed: int
    protocol: str
    form: str
    method: str
    covered_object: str
    novel: bool
    person: int
    whole: CoveringVerdict
    """of the whole inferred motion"""
    executed: CoveringVerdict
    """of what is left from phase x* on, begun at rest at the demonstrations' mean start (F14)"""
    determined: bool
    """whether the partner's phase was known by then"""

    def row(self) -> dict[str, Any]:
        """For machines."""
        names = ("seed", "protocol", "form", "method", "covered_object", "novel", "person", "determined")
        said = {name: getattr(self, name) for name in names}
        for kind in ("whole", "executed"):
            verdict: CoveringVerdict = getattr(self, kind)
            said |= {f"{kind}_success": verdict.success, f"{kind}_collided": verdict.collided}
            said |= {f"{kind}_nearest": verdict.contact.distance, f"{kind}_reason": verdict.reason}
        return said


@dataclass(frozen=True, eq=False)
class ShareErrors:
    """RMSE [m] of the left gripper's position along the motion, (K objects, P people, len(SHARES))."""

    to_final: Floats
    """to the same method's motion with all of the partner observed"""
    to_demonstration: Floats
    """to what the person and the demonstrator did"""


@dataclass(frozen=True, eq=False)
class ShownMotions:
    """What pictures show of one seed: left gripper, (steps, 3) [m, base], by object."""

    demonstrations: dict[str, Floats]
    """means of the training data"""
    boxes: dict[str, Box]
    """of the first held-out person"""
    inferred: dict[str, dict[str, tuple[Floats, ...]]]
    """method -> object -> a motion a held-out person"""
    verdicts: dict[str, dict[str, CoveringVerdict]]
    """method -> object -> of the first held-out person"""
    by_share: dict[str, Floats]
    """method -> (len(SHARES), steps, 3) of the first held-out person at EXAMPLE; empty without it"""


@dataclass(frozen=True, eq=False)
class CoveringRun:
    """One seed of one protocol."""

    seed: int
    protocol: CoveringProtocol
    trials: tuple[CoveringTrial, ...]
    factors: dict[tuple[str, str], float]
    """(form, method) -> the noise chosen, over the fit's residual"""
    errors: dict[tuple[str, str], ShareErrors]
    """(form, method)"""
    partners: dict[str, Floats]
    """EaIP by whose motion it sees -> (len(PARTNER_SHARES),) RMSE [m] to the demonstrations, mean of all"""
    shown: ShownMotions


@dataclass(frozen=True, eq=False)
class DialRun:
    """One seed at one setting of the generator: GROUND_TRUTH's protocol, positions."""

    seed: int
    informative: float
    personal: bool
    """False: people do not differ in reach and carry"""
    errors: dict[str, Floats]
    """method -> (len(PARTNER_SHARES),) RMSE [m] to the demonstration, mean of objects and people"""


@dataclass(frozen=True, eq=False)
class CoveringResult:
    """Everything the report shows."""

    study: CoveringStudy
    runs: tuple[CoveringRun, ...]
    dials: tuple[DialRun, ...]

    @property
    def trials(self) -> list[CoveringTrial]:
        """Of all runs."""
        return [trial for run in self.runs for trial in run.trials]

    def of(self, protocol: CoveringProtocol) -> list[CoveringRun]:
        """The runs of a protocol, by seed."""
        return [run for run in self.runs if run.protocol == protocol]


def run_covering_study(study: CoveringStudy, tell: StageProgress = silent) -> CoveringResult:
    """Learns and judges over processes; the same study gives the same result whatever their number."""
    longest_first = reversed(study.protocols)
    runs = [_Job(study, seed, protocol) for protocol in longest_first for seed in study.all_seeds]
    dials = [_Dial(study, seed, i, own) for i in study.dials for own in (True, False) for seed in study.all_seeds]
    jobs: list[_Job | _Dial] = [*runs, *dials]
    done = run_jobs(jobs, partial(tell, "learn and judge"), study.processes)
    return CoveringResult(
        study,
        tuple(one for one in done if isinstance(one, CoveringRun)),
        tuple(one for one in done if isinstance(one, DialRun)),
    )


def method_config(form: str, method: str) -> CollaborationConfig:
    """IP differs from EaIP in nothing but e."""
    return replace(FORMS[form], environment=method == "EaIP")


def observed(one: InteractionRecording, share: float) -> InteractionRecording:
    """A share of the partner's motion, at least FEWEST samples."""
    part = one.partial(share=share)
    return part if len(part) >= FEWEST else one.first(min(FEWEST, len(one)))


def rmse(motion: Floats, other: Floats) -> float:
    """[m] of positions (T, 3) and (T, 3) at the same shares of their motions."""
    return float(np.sqrt(np.mean(np.sum((motion - other) ** 2, axis=1))))


def shuffled_partners(demonstrations: Sequence[InteractionRecording], seed: int) -> list[InteractionRecording]:
    """The same robots and environments, each with the partner of another demonstration, over that one's time."""
    order = np.random.default_rng([seed, 77]).permutation(len(demonstrations))
    mixed = list(demonstrations)
    for place, other in zip(order, np.roll(order, 1), strict=True):
        one, partner = demonstrations[int(place)], demonstrations[int(other)]
        robot = one.resample(len(partner)).robot
        mixed[int(place)] = dataclasses.replace(one, stamp=partner.stamp, partner=partner.partner, robot=robot)
    return mixed


@dataclass(frozen=True)
class _Case:
    """A held-out person at an object."""

    one: InteractionRecording
    name: str
    novel: bool
    person: int

    def truth(self, steps: int) -> Floats:
        return self.one.resample(steps).robot[:, :3]


def _cases(data: CoveringData) -> list[_Case]:
    """Object by object, known ones first."""
    return [
        _Case(one, name, novel, person)
        for novel, group in ((False, data.known), (True, data.novel))
        for name, people in group.items()
        for person, one in enumerate(people)
    ]


def _infer(model: CollaborationModel, one: InteractionRecording, seen: InteractionRecording) -> CollaborationInference:
    return model.infer(seen, one.environment)


@dataclass(frozen=True)
class _Job:
    study: CoveringStudy
    seed: int
    protocol: CoveringProtocol

    def run(self) -> CoveringRun | DialRun:
        data = covering_data(self.protocol, self.seed, held_out=self.study.held_out)
        cases = _cases(data)
        keys = [(form, method) for form in FORMS for method in METHODS]
        models = {key: learn_collaboration(data.training, method_config(*key), self.study.choice) for key in keys}
        start = np.mean([one.robot[0] for one in data.training], axis=0)
        trials = [self._trial(*key, models[key], case, start) for key in keys for case in cases]
        return CoveringRun(
            self.seed,
            self.protocol,
            tuple(trials),
            {key: noise_factor(model) for key, model in models.items()},
            {key: self._errors(model, cases) for key, model in models.items()},
            self._partners(models["positions", "EaIP"], data, cases),
            self._shown({method: models["positions", method] for method in METHODS}, data, cases),
        )

    def _trial(self, form: str, method: str, model: CollaborationModel, case: _Case, start: Floats) -> CoveringTrial:
        said, box = _infer(model, case.one, case.one.partial(seconds=self.protocol.observed)), box_of(case.one)
        whole = covering_verdict(said.robot_motion(), RIGHT_GRIPPER, box)
        executed = covering_verdict(said.motion_from_now(PERIOD, start)[1], RIGHT_GRIPPER, box)
        determined = said.phase is not None and said.phase.determined
        names = (self.seed, self.protocol.name, form, method, case.name, case.novel, case.person)
        return CoveringTrial(*names, whole, executed, determined)

    def _errors(self, model: CollaborationModel, cases: Sequence[_Case]) -> ShareErrors:
        final, truth = np.zeros((len(cases), len(SHARES))), np.zeros((len(cases), len(SHARES)))
        for k, case in enumerate(cases):
            paths = _paths(model, case)
            final[k] = [rmse(path, paths[-1]) for path in paths]
            demonstrated = case.truth(len(paths[-1]))
            truth[k] = [rmse(path, demonstrated) for path in paths]
        shape = (-1, self.study.held_out, len(SHARES))
        return ShareErrors(final.reshape(shape), truth.reshape(shape))

    def _partners(self, model: CollaborationModel, data: CoveringData, cases: Sequence[_Case]) -> dict[str, Floats]:
        """Whose motion is seen makes how much of a difference."""
        order = np.random.default_rng([self.seed, 78]).permutation(len(cases))
        stranger = {int(k): cases[int(j)] for k, j in zip(order, np.roll(order, 1), strict=True)}
        mixed = shuffled_partners(data.training, self.seed)
        shuffled = learn_collaboration(mixed, method_config("positions", "EaIP"), self.study.choice)
        own = _mean_errors(model, cases)
        alone = [rmse(_position(model.infer(None, c.one.environment)), c.truth(model.config.steps)) for c in cases]
        return {
            OWN: own,
            NOBODY: np.full(len(PARTNER_SHARES), np.mean(alone)),
            STRANGER: _mean_errors(model, cases, [stranger[k].one for k in range(len(cases))]),
            SHUFFLED: _mean_errors(shuffled, cases),
        }

    def _shown(self, models: dict[str, CollaborationModel], data: CoveringData, cases: Sequence[_Case]) -> ShownMotions:
        first = {case.name: case for case in cases if case.person == 0}
        inferred: dict[str, dict[str, tuple[Floats, ...]]] = {
            method: {
                name: tuple(self._after_observation(model, case) for case in cases if case.name == name)
                for name in first
            }
            for method, model in models.items()
        }
        boxes = {name: box_of(case.one) for name, case in first.items()}
        verdicts = {
            method: {name: covering_verdict(motions[0], RIGHT_GRIPPER, boxes[name]) for name, motions in found.items()}
            for method, found in inferred.items()
        }
        example = {m: np.array(_paths(model, first[EXAMPLE])) for m, model in models.items() if EXAMPLE in first}
        return ShownMotions(self._demonstrated(data), boxes, inferred, verdicts, example)

    def _after_observation(self, model: CollaborationModel, case: _Case) -> Floats:
        return _position(_infer(model, case.one, case.one.partial(seconds=self.protocol.observed)))

    def _demonstrated(self, data: CoveringData) -> dict[str, Floats]:
        """Object -> mean of its demonstrations."""
        each = self.protocol.demonstrations
        found = {}
        for k, one in enumerate(self.protocol.training):
            motions = [shown.resample(STEPS).robot[:, :3] for shown in data.training[k * each : (k + 1) * each]]
            found[one.name] = np.asarray(np.mean(motions, axis=0), np.float64)
        return found


@dataclass(frozen=True)
class _Dial:
    study: CoveringStudy
    seed: int
    informative: float
    personal: bool

    def run(self) -> CoveringRun | DialRun:
        config = CoveringConfig(informative=self.informative)
        config = config if self.personal else replace(config, personal=0.0)
        data = covering_data(self.study.protocols[0], self.seed, config, self.study.held_out)
        errors = {}
        for method in METHODS:
            model = learn_collaboration(data.training, method_config("positions", method), CURVE_CHOICE)
            errors[method] = _mean_errors(model, _cases(data))
        return DialRun(self.seed, self.informative, self.personal, errors)


def _position(said: CollaborationInference) -> Floats:
    """(steps, 3) [m] of the left gripper, the whole inferred motion."""
    return said.robot_motion()[:, :3]


def _paths(model: CollaborationModel, case: _Case) -> list[Floats]:
    """By SHARES."""
    return [_position(_infer(model, case.one, observed(case.one, share))) for share in SHARES]


def _mean_errors(
    model: CollaborationModel, cases: Sequence[_Case], partners: Sequence[InteractionRecording] | None = None
) -> Floats:
    """(len(PARTNER_SHARES),) RMSE [m] to the demonstrations, where instead of their own `partners` are seen."""
    seen = partners or [case.one for case in cases]
    errors = np.zeros((len(cases), len(PARTNER_SHARES)))
    for k, (case, partner) in enumerate(zip(cases, seen, strict=True)):
        truth = case.truth(model.config.steps)
        errors[k] = [rmse(_position(_infer(model, case.one, observed(partner, s))), truth) for s in PARTNER_SHARES]
    mean: Floats = errors.mean(axis=0)
    return mean
