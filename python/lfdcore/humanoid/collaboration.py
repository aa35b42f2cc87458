"""A collaboration learned from demonstrations, and inferred from a glimpse of the partner and the scene (Ch. 5).

recordings -> columns, evenly sampled -> InteractionPrimitive over (theta, e) (5.6-5.9, 5.16) -> CollaborationModel
partner's samples -> phase and tempo (5.5, DTW) -> p(theta | partner, e) (5.15, 5.17-5.19) -> the robot's motion (5.1)
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.interaction import LONGEST_GAP, InteractionRecording, environments, require_environment
from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.humanoid.partner_phase import condition_at, follow, likeliest_share
from lfdcore.humanoid.pose_columns import PoseColumns, continuous_columns
from lfdcore.primitives import (
    DmpConfig,
    InteractionPosterior,
    InteractionPrimitive,
    InteractionPrimitiveConfig,
    PartnerPhase,
    PhaseEstimator,
)

KIND, VERSION = "lfdcore collaboration", 1
_MOST_STEPS = 1e6 - 2  # of a motion (Dmp.rollout)
_LARGEST = 1e15
"""of a learned parameter: beyond, a file is not of ours"""
Array = NDArray[np.float64]
Observed = Literal["positions", "forcing"]
_CORE = InteractionPrimitiveConfig()  # whose defaults hold
_OBSERVED = cast(Observed, _CORE.observe)


@dataclass(frozen=True, kw_only=True)
class CollaborationConfig:
    """How a collaboration is learned. `thesis()` has the printed form."""

    basis_functions: int = _CORE.dmp.basis_functions
    """M of every degree of freedom (F13)"""
    observe: Observed = _OBSERVED
    """What of the partner enters the likelihood: positions, or the forcing function as printed (5.11, 5.12), for which
    what a tracker saw is differentiated twice"""
    phase: Literal["likeliest", "warped"] = "likeliest"
    """How far the partner has come: where what was seen is likeliest, which needs positions, or by time warping as
    printed (5.5)"""
    noise: float | None = None
    """sigma^2 of what is observed, in its unit squared; None: the fit's residual (F13)"""
    environment_noise: float = _CORE.environment_noise
    """sigma_e^2 of the standardised environment (F13)"""
    environment: bool = True
    """False: a plain interaction primitive (Sec. 5.3), which does not look at the scene"""
    printed_environment_weights: bool = _CORE.printed_environment_weights
    """e = w_e theta as printed after 5.16, in place of the joint Gaussian (ERRATA 42)"""
    steps: int = 500
    """of a demonstration while it is learned from, and of an inferred motion (Sec. 5.6)"""
    longest_gap: float = LONGEST_GAP
    """[s] of lost tracking that a demonstration may have"""

    def __post_init__(self) -> None:
        if self.observe not in ("positions", "forcing"):
            raise ValueError(f"observe is {self.observe!r}, must be 'positions' or 'forcing'")
        if self.phase not in ("likeliest", "warped"):
            raise ValueError(f"phase is {self.phase!r}, must be 'likeliest' or 'warped'")
        if self.phase == "likeliest" and self.observe != "positions":
            raise ValueError(f"phase 'likeliest' needs positions, {self.observe} is observed: its phase is 'warped'")
        if not isinstance(self.steps, int) or not 10 <= self.steps <= 100_000:
            raise ValueError(f"steps is {self.steps!r}, must be a whole number in [10, 100000]")
        self.primitive()

    @staticmethod
    def thesis() -> CollaborationConfig:
        """The forcing function is observed, phases are time warping's, and the environment weighs as printed after
        5.16."""
        return CollaborationConfig(observe="forcing", phase="warped", printed_environment_weights=True)

    def primitive(self) -> InteractionPrimitiveConfig:
        """For the C++ core. ValueError as there."""
        return InteractionPrimitiveConfig(
            dmp=DmpConfig(basis_functions=self.basis_functions),
            observe=self.observe,
            noise=self.noise,
            environment_noise=self.environment_noise,
            printed_environment_weights=self.printed_environment_weights,
        )


@dataclass(frozen=True, eq=False)
class CollaborationInference:
    """What the robot is to do, given what was seen so far."""

    posterior: InteractionPosterior
    """p(theta | partner, e)"""
    phase: PartnerPhase | None
    """how far the partner has come by time warping, and how fast (5.5); until it is determined, only a
    partner's place counts; None: not seen"""
    share: float
    """of the motion that is over, 0 to 1"""
    duration: float
    """[s] of the whole motion at the partner's tempo (F14)"""
    columns: PoseColumns
    """of the robot"""
    partner_columns: int
    """n"""
    steps: int
    """of whole motions, evenly spread from 0 to `duration`"""

    def robot_motion(self) -> Array:
        """(steps, r) the robot's recorded columns: the posterior's mean."""
        return self.columns.recorded(self.posterior.robot.rollout(self.steps).positions)

    def partner_motion(self) -> Array:
        """(steps, n) the partner's, as expected."""
        return np.array(self.posterior.partner.rollout(self.steps).positions)

    def robot_deviation(self) -> Array:
        """(steps, r') standard deviations of the learned columns."""
        covariance = self.posterior.trajectory(self.steps).covariance
        variances = np.diagonal(covariance, axis1=1, axis2=2)[:, self.partner_columns :]
        return np.asarray(np.sqrt(variances.clip(0)))

    def motion_from_now(self, period: float, position: ArrayLike | None = None) -> tuple[Array, Array]:
        """What is left, from phase x* on (end of Sec. 5.3): times from now [s] (K,) every `period` [s] or a little more
        often, and the robot's recorded columns (K, r). It starts from rest at `position` (r,), where the robot is
        (F14), by default where the whole motion begins. ValueError for a period that is not > 0, another r, and where
        nothing is left."""
        left = (1 - self.share) * self.duration
        if not 0 < period < np.inf:
            raise ValueError(f"period is {period} s, must be > 0 s and finite")
        if left < period:
            raise ValueError(
                f"the partner has come to the end of the motion: {left:.3g} s are left, period {period:g} s"
            )
        robot = self.posterior.robot
        begin = float(np.exp(-robot.config.phase_decay * self.share))
        if left / period > _MOST_STEPS:
            raise ValueError(f"period is {period} s, must be >= {left / _MOST_STEPS:.3g} s for the {left:.3g} s left")
        start = None if position is None else self.columns.learned(np.atleast_2d(np.asarray(position, np.float64)))[0]
        steps = int(np.ceil(left / period)) + 1
        run = robot.rollout(steps, rate=1 / self.duration, phase=begin, position=start, duration=left)
        return np.array(run.time), self.columns.recorded(run.positions)


@dataclass(frozen=True, eq=False)
class CollaborationModel:
    """What was learned from demonstrations of one collaboration."""

    primitive: InteractionPrimitive
    partner_names: tuple[str, ...]
    robot: PoseColumns
    environment_names: tuple[str, ...]
    """(E,), empty for a plain interaction primitive"""
    reference: Array
    """(n_ref, n) the partner's mean motion, as densely sampled as the demonstrations: phases are estimated by it"""
    duration: float
    """[s] mean of the demonstrations"""
    config: CollaborationConfig
    metadata: dict[str, Any] = field(default_factory=dict)

    @staticmethod
    def fit(
        demonstrations: Sequence[InteractionRecording], config: CollaborationConfig | None = None
    ) -> CollaborationModel:
        """From two or more demonstrations with the same columns and the same names in their environments. ValueError
        naming the demonstration for others, for one without a robot, for a column of the partner that was never seen,
        for a gap beyond config.longest_gap; for a partner who never moves, and as InteractionPrimitive.fit."""
        config = config or CollaborationConfig()
        partner_names, robot_names = _common_columns(demonstrations)
        even = [evenly(one, config) for one in demonstrations]
        robot = PoseColumns.of(robot_names, [one.robot for one in even])
        names, values = environments(demonstrations) if config.environment else ((), np.zeros((len(even), 0)))
        _require_varying(names, values)
        primitive = InteractionPrimitive.fit(
            [one.partner for one in even],
            [robot.learned(one.robot) for one in even],
            values if names else None,
            config.primitive(),
        )
        duration = float(np.mean([one.duration for one in demonstrations]))
        period = float(np.median([one.duration / (len(one) - 1) for one in demonstrations]))
        mean = np.mean([one.partner for one in even], axis=0)
        reference = _resampled(mean, max(2, round(duration / period) + 1))
        PhaseEstimator(reference, duration)  # refuses a partner who never moves now, not when one is observed
        metadata = {"demonstrations": [one.name for one in demonstrations]}
        return CollaborationModel(primitive, partner_names, robot, names, reference, duration, config, metadata)

    def infer(
        self, partial: InteractionRecording | None = None, environment: Mapping[str, float] | None = None
    ) -> CollaborationInference:
        """From what was seen of the partner (its columns may be a subset: the others were not seen) and the
        environment by name, which may hold more than was learned from. Neither: the demonstrations' mean.

        ValueError for a partner's column that was not learned from, an environment that lacks a name where any is
        given, and a recording in which no sample was seen.
        """
        given = self._environment(environment)
        if partial is None:
            posterior = self.primitive.condition(None, None, given)
            return self._inference(posterior, None, 0.0, self.duration)
        seen = self._columns(partial)
        if np.isnan(seen).all():
            raise ValueError(f"{partial.name or 'the recording'}: no sample of the partner was seen")
        followed = follow(self.reference, self.duration, partial.stamp, seen)
        share = followed.warped_share
        if self.config.phase == "likeliest":
            share = likeliest_share(self.primitive, followed, self.duration, given)
        posterior = condition_at(self.primitive, followed, share, given)
        duration = followed.moved / share if share > 0 else self.duration  # 1 / tau = T'/t* (F14)
        return self._inference(posterior, followed.phase, share, duration)

    def _inference(
        self, posterior: InteractionPosterior, phase: PartnerPhase | None, share: float, duration: float
    ) -> CollaborationInference:
        partner, steps = len(self.partner_names), self.config.steps
        return CollaborationInference(posterior, phase, share, duration, self.robot, partner, steps)

    def follow(self, environment: Mapping[str, float] | None = None) -> CollaborationFollower:
        """For a partner who is seen sample by sample."""
        return CollaborationFollower(self, environment)

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""
        return {
            "demonstrations": len(self.primitive.parameters),
            "partner": ", ".join(self.partner_names),
            "robot": ", ".join(self.robot.names),
            "environment": ", ".join(map(self._range, self.environment_names)) or "none: a plain interaction primitive",
            "duration": f"{self.duration:.2f} s",
            "observe": f"{self.config.observe}, noise {float(self.primitive.config.noise or 0):.3g}",
        }

    def demonstrated(self, name: str) -> tuple[float, float]:
        """The least and the largest value of the environment in the demonstrations. ValueError for another name."""
        if self.primitive.environment is None or name not in self.environment_names:
            raise ValueError(f"{name} was not learned from: {', '.join(self.environment_names) or 'no environment'}")
        column = self.primitive.environment[:, self.environment_names.index(name)]
        return float(column.min()), float(column.max())

    def _range(self, name: str) -> str:
        low, high = self.demonstrated(name)
        return f"{name} {low:g} to {high:g}"

    def _environment(self, given: Mapping[str, float] | None) -> Array | None:
        if given is None or not self.environment_names:
            return None
        values = require_environment(given)
        missing = [name for name in self.environment_names if name not in values]
        if missing:
            raise ValueError(f"the environment lacks {', '.join(missing)}: it has {', '.join(values) or 'nothing'}")
        return np.array([values[name] for name in self.environment_names])

    def _columns(self, partial: InteractionRecording) -> Array:
        unknown = [name for name in partial.partner_names if name not in self.partner_names]
        if unknown:
            raise ValueError(f"the partner's column {unknown[0]} was not learned from: {', '.join(self.partner_names)}")
        seen = np.full((len(partial), len(self.partner_names)), np.nan)
        for name, column in zip(partial.partner_names, partial.partner.T, strict=True):
            seen[:, self.partner_names.index(name)] = column
        return seen

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""
        header: dict[str, Any] = {
            "partner_names": self.partner_names,
            "robot_names": self.robot.names,
            "references": self.robot.references,
            "environment_names": self.environment_names,
            "duration": self.duration,
            "noise": self.primitive.config.noise,
            "config": dataclasses.asdict(self.config),
            "metadata": self.metadata,
        }
        tensors: Tensors = {"parameters": self.primitive.parameters, "starts": self.primitive.starts}
        tensors["reference"] = self.reference
        if self.primitive.environment is not None:
            tensors["environment"] = self.primitive.environment
        write_tensor_file(path, KIND, VERSION, header, tensors)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> CollaborationModel:
        """ModelError for a damaged file or one of another kind or version."""
        header, tensors = read_tensor_file(path, KIND, VERSION)
        try:
            return cls._of(header, tensors)
        except (KeyError, TypeError, ValueError, AttributeError) as broken:
            said = str(broken).partition("\n")[0]  # pybind11's go on with signatures
            raise ModelError(f"{path} does not hold a model of a collaboration: {said}") from broken

    @classmethod
    def _of(cls, header: dict[str, Any], tensors: Tensors) -> CollaborationModel:
        config = CollaborationConfig(**header["config"])
        used = dataclasses.replace(config, noise=float(header["noise"]))
        names, environment = _names(header, "partner_names"), _names(header, "environment_names")
        robot = PoseColumns(_names(header, "robot_names"), tuple(tuple(q) for q in header["references"]))
        for name, tensor in tensors.items():
            if tensor.ndim != 2 or not (np.abs(tensor) <= _LARGEST).all():
                raise ValueError(f"{name} has shape {tensor.shape}, must be a matrix, finite and within {_LARGEST:g}")
        primitive = InteractionPrimitive(
            tensors["parameters"], tensors["starts"], tensors.get("environment"), len(names), used.primitive()
        )
        learned = len(robot.names) - len(robot.references)
        found = primitive.starts.shape[1]
        if found != len(names) + learned:
            raise ValueError(f"{found} degrees of freedom, must be {len(names)} + {learned}")
        if len(environment) != (0 if primitive.environment is None else primitive.environment.shape[1]):
            raise ValueError(f"{len(environment)} names for an environment of other size")
        reference, duration = np.ascontiguousarray(tensors["reference"], np.float64), float(header["duration"])
        PhaseEstimator(reference, duration)
        if reference.shape[1] != len(names):
            raise ValueError(f"reference has shape {reference.shape}, must be (T, {len(names)})")
        return cls(primitive, names, robot, environment, reference, duration, config, dict(header["metadata"]))


class CollaborationFollower:
    """Infers anew as the observation of the partner grows: observe at the tracker's rate, infer when wanted."""

    def __init__(self, model: CollaborationModel, environment: Mapping[str, float] | None = None) -> None:
        model._environment(environment)  # refused before anything is observed
        self.model, self.environment = model, environment
        self._stamps: list[float] = []
        self._samples: list[Array] = []

    def observe(self, stamp: float, partner: ArrayLike) -> None:
        """The partner's sample (n,) at `stamp` [s], NaN where not seen. ValueError for another n, what is infinite and
        a stamp that is not later than the last."""
        sample = np.array(partner, np.float64)  # a copy: trackers write into the same array again
        names = self.model.partner_names
        if sample.shape != (len(names),):
            raise ValueError(f"partner has shape {sample.shape}, must be ({len(names)},): {', '.join(names)}")
        InteractionRecording(np.array([stamp]), sample[None], np.zeros((1, 0)), names)
        if self._stamps and not stamp > self._stamps[-1]:
            raise ValueError(f"stamp is {stamp} s, must be later than the last, {self._stamps[-1]} s")
        self._stamps.append(float(stamp))
        self._samples.append(sample)

    def infer(self) -> CollaborationInference:
        """From all that was observed, as CollaborationModel.infer."""
        if not self._stamps or np.isnan(self._samples).all():
            return self.model.infer(None, self.environment)
        seen = np.array(self._samples)
        partial = InteractionRecording(np.array(self._stamps), seen, np.zeros((len(seen), 0)), self.model.partner_names)
        return self.model.infer(partial, self.environment)


def _names(header: Mapping[str, Any], key: str) -> tuple[str, ...]:
    names = header[key]
    if not isinstance(names, list) or not all(isinstance(name, str) and name.strip() for name in names):
        raise ValueError(f"{key} must be a list of texts that are not empty")
    if len(set(names)) < len(names):
        raise ValueError(f"{key} names {max(names, key=names.count)} more than once")
    return tuple(names)


def _require_varying(names: Sequence[str], values: Array) -> None:
    for name, column in zip(names, values.T, strict=True):
        if not np.ptp(column) > 0:
            raise ValueError(
                f"{name} is {column[0]:g} in all demonstrations, must vary: leave it out of their environments, or "
                "learn without any (--plain)"
            )


def _common_columns(demonstrations: Sequence[InteractionRecording]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if len(demonstrations) < 2:
        raise ValueError(f"there must be 2 demonstrations or more, got {len(demonstrations)}")
    first = demonstrations[0]
    for one in demonstrations:
        if not one.robot_names:
            raise ValueError(f"{one.name or 'a demonstration'} has no robot's motion to learn from")
        for what in ("partner_names", "robot_names"):
            found, wanted = getattr(one, what), getattr(first, what)
            if found != wanted:
                raise ValueError(
                    f"{one.name or 'a demonstration'} has the {what} {', '.join(found)}, must be {', '.join(wanted)}"
                )
        if one.frame != first.frame:
            raise ValueError(f"{one.name or 'a demonstration'} is in frame {one.frame}, must be in {first.frame}")
    return first.partner_names, first.robot_names


def evenly(one: InteractionRecording, config: CollaborationConfig) -> InteractionRecording:
    """config.steps samples; between a quaternion and its negative, the same rotation, it goes no long way (ERRATA 44).
    ValueError naming the demonstration for a column of the partner that was never seen and as `resample`."""
    even = replace(one, robot=continuous_columns(one.robot_names, one.robot)).resample(config.steps, config.longest_gap)
    never = [name for name, column in zip(one.partner_names, even.partner.T, strict=True) if np.isnan(column).any()]
    if never:
        raise ValueError(f"{one.name or 'a demonstration'}: {never[0]} was never seen")
    return even


def _resampled(motion: Array, steps: int) -> Array:
    """(T, D) -> (steps, D) by straight lines."""
    at = np.linspace(0, len(motion) - 1, steps)
    return np.stack([np.interp(at, np.arange(len(motion)), column) for column in motion.T], axis=1)
