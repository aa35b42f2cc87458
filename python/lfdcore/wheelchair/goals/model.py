"""Where in a known map a driver is going (Ch. 2): a belief over destinations, filtered as the drive goes on.

log -> goal_samples -> kernels (C.3), subset (Alg. 1), network (Sec. 2.2) -> GoalModel
pose, velocities, stick -> GoalFilter.update -> belief N(mu, Sigma) over g (2.1-2.3) -> likelihood of each goal
"""

from __future__ import annotations

import dataclasses
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.goals import Goal, Goals
from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.estimation import ActionKernel, ActionModel, Belief, IntentionFilter, goal_likelihoods
from lfdcore.wheelchair.goals.network import GoalNetwork
from lfdcore.wheelchair.goals.samples import GoalSamples, Heading, goal_state
from lfdcore.wheelchair.stick import DEAD_ZONE

KIND, VERSION = "lfdcore goals", 2
Floats = NDArray[np.float64]
Data = Literal["sparse", "full"]
"""On which data a filter runs: the subset of Alg. 1, or all."""
_SMALL = 1e-6
"""Added to the prior's covariance [m^2] (F1): goals in a row have none across it."""


@dataclass(frozen=True, kw_only=True)
class GoalFilterConfig:
    """How beliefs are filtered. `thesis()` has the printed values."""

    heading: Heading = "embedded"
    projected: bool = True
    """The subset projects all data (ERRATA 14); False: it replaces them, as printed."""
    process_noise: float = 0.0
    """[m^2] that the belief's variance grows by at each update: samples at 10 Hz are not independent (ERRATA 6).
    `learn_goals` chooses it from the drives; 0, as printed, makes beliefs surer than they may be."""
    at_rest: float = DEAD_ZONE
    """A stick displaced less says nothing of a destination: not learned from, and the belief stays."""

    def __post_init__(self) -> None:
        for name in ("process_noise", "at_rest"):
            if not 0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is {getattr(self, name)}, must be >= 0 and finite")
        if not isinstance(self.projected, bool):
            raise ValueError(f"projected is {self.projected!r}, must be true or false")
        if self.heading not in ("embedded", "raw"):
            raise ValueError(f"heading is {self.heading!r}, must be 'embedded' or 'raw'")

    @staticmethod
    def thesis() -> GoalFilterConfig:
        """The yaw as a number, the subset in the place of the data, every sample (and no process noise)."""
        return GoalFilterConfig(heading="raw", projected=False, at_rest=0.0)


@dataclass(frozen=True)
class GoalBelief:
    """What is thought of the destination after an update."""

    mean: Floats
    """(2,) mu [m, map]"""
    covariance: Floats
    """(2, 2) Sigma [m^2]"""
    likelihood: Floats
    """(L,) of each goal: softmax of -d^2/2, d its Mahalanobis distance (F1); sums to 1"""
    nearest: int
    """the goal nearest to the mean (Sec. 2.3.2)"""


@dataclass(frozen=True)
class LeftOutFigures:
    """Beliefs along drives that their model had not learned from, with one process noise."""

    process_noise: float
    """[m^2]"""
    samples: int
    drives: int
    accuracy: float
    """share of samples whose destination was nearest to the mean"""
    nees: float
    """over its dimension, 2: 1 where beliefs are as wide as their errors"""

    def __post_init__(self) -> None:
        values = (self.process_noise, self.samples, self.drives, self.accuracy, self.nees)
        if not all(isinstance(value, (int, float)) and 0 <= value < np.inf for value in values):
            raise ValueError(f"figures of left-out drives must be finite and >= 0, are {values}")

    def __str__(self) -> str:
        return (
            f"{self.process_noise:g} m^2 an update; along {self.drives} drives left out {100 * self.accuracy:.0f} % of "
            f"{self.samples} samples named right, NEES / 2 {self.nees:.2f}"
        )


@dataclass(frozen=True)
class GoalModel:
    """Destinations, the drives to them, and what was learned: see the module. ValueError for parts that do not fit."""

    goals: Goals
    samples: GoalSamples
    kernels: tuple[ActionKernel, ActionKernel]
    """of forward and left"""
    subset: NDArray[np.int64]
    """(S,) of the samples, in the order of their selection (Alg. 1)"""
    network: GoalNetwork
    config: GoalFilterConfig
    left_out: tuple[LeftOutFigures, ...] = ()
    """by process noise; the filter's was chosen by them"""
    metadata: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        goals, count = len(self.goals), len(self.samples)
        if not count or not len(self.subset) or len(np.unique(self.subset)) < len(self.subset):
            raise ValueError(
                f"subset names {len(self.subset)} of {count} samples, must name at least one, and each once"
            )
        _require_indices("samples go to goals", self.samples.goal, goals)
        _require_indices("subset names samples", self.subset, count)
        if len(self.network.output) != goals:
            raise ValueError(f"the network tells {len(self.network.output)} goals apart, there are {goals}")
        sizes = (5 if self.config.heading == "raw" else 6, 2)
        for kernel in self.kernels:
            found = (len(kernel.state_lengthscales), len(kernel.goal_lengthscales))
            if found != sizes:
                raise ValueError(f"a kernel has {found} length-scales of state and goal, must have {sizes}")

    def action_model(self, data: Data = "sparse") -> ActionModel:
        """p(y | g, x) (Sec. 2.3). `full` inverts a matrix of all N samples: minutes and gigabytes for N = 10^4."""
        subset = self.subset if data == "sparse" else None
        return ActionModel(*self.action_samples(), list(self.kernels), subset=subset, projected=self.config.projected)

    def action_samples(self) -> tuple[Floats, Floats, Floats]:
        """What an action model is conditioned on: states (N, Dx), goals (N, 2) [m, map], sticks (N, 2)."""
        states = goal_state(self.samples.pose, self.samples.twist, self.config.heading)
        return states, self.goals.positions[self.samples.goal], self.samples.joystick

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""
        goals = {goal.name: f"{goal.x:g}, {goal.y:g} m" for goal in self.goals.goals}
        sizes = {"samples": len(self.samples), "drives": len(set(self.samples.drive.tolist()))}
        noise = f"{self.config.process_noise:g} m^2 an update"
        chosen = next((str(one) for one in self.left_out if one.process_noise == self.config.process_noise), noise)
        return {**self.metadata, "goals": goals, **sizes, "subset": len(self.subset), "process noise": chosen}

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""
        goals = [dataclasses.asdict(goal) for goal in self.goals.goals]
        kernels = [_kernel_values(kernel) for kernel in self.kernels]
        header: dict[str, Any] = {"goals": goals, "map": str(self.goals.map or ""), "frame": "map", "kernels": kernels}
        header |= {"config": dataclasses.asdict(self.config), "network_heading": self.network.heading}
        header |= {"left_out": [dataclasses.asdict(one) for one in self.left_out], "metadata": self.metadata}
        write_tensor_file(path, KIND, VERSION, header, self._tensors())

    def _tensors(self) -> Tensors:
        network = {f"network.{name}": getattr(self.network, name) for name in ("centre", "scale", "hidden", "output")}
        samples = {f"samples.{name}": array for name, array in self.samples.arrays().items()}
        return {**samples, **network, "subset": self.subset}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> GoalModel:
        """ModelError for a damaged file or one of another kind or version."""
        header, tensors = read_tensor_file(path, KIND, VERSION)
        try:
            return cls._of(header, tensors)
        except (KeyError, TypeError, ValueError, AttributeError) as broken:
            raise ModelError(f"{path} does not hold a model of destinations: {broken}") from broken

    @classmethod
    def _of(cls, header: dict[str, Any], tensors: Tensors) -> GoalModel:
        place = Path(header["map"]) if header["map"] else None
        goals = Goals(tuple(Goal(**goal) for goal in header["goals"]), place)
        samples = GoalSamples(**{name: tensors[f"samples.{name}"] for name in GoalSamples.__dataclass_fields__})
        first, second = (ActionKernel(**values) for values in header["kernels"])
        config = GoalFilterConfig(**header["config"])
        weights = {name: tensors[f"network.{name}"] for name in ("centre", "scale", "hidden", "output")}
        network = GoalNetwork(header["network_heading"], **weights)
        if not isinstance(header["metadata"], dict):
            raise ValueError(f"metadata is {header['metadata']!r}, must be an object")
        left_out = tuple(LeftOutFigures(**figures) for figures in header["left_out"])
        return cls(goals, samples, (first, second), tensors["subset"], network, config, left_out, header["metadata"])


def _require_indices(what: str, indices: NDArray[np.int64], count: int) -> None:
    if indices.ndim != 1 or not np.issubdtype(indices.dtype, np.integer):
        raise ValueError(f"{what} by {indices.dtype} {indices.shape}, must be integers (n,)")
    if len(indices) and not (indices.min() >= 0 and indices.max() < count):
        raise ValueError(f"{what} {indices.min()} to {indices.max()}, there are {count}")


def _kernel_values(kernel: ActionKernel) -> dict[str, Any]:
    return {
        "amplitude": kernel.amplitude,
        "state_lengthscales": kernel.state_lengthscales.tolist(),
        "goal_lengthscales": kernel.goal_lengthscales.tolist(),
        "noise": kernel.noise,
    }


class Intention(Protocol):
    """What a belief is filtered with: lfdcore.estimation.IntentionFilter, or its equations on another machine."""

    @property
    def belief(self) -> Belief: ...
    def update(self, state: ArrayLike, action: ArrayLike) -> Belief: ...
    def reset(self) -> None: ...


class OtherActionModel(Protocol):
    """An action model that is not lfdcore.estimation.ActionModel brings its filter."""

    def intention_filter(self, mean: ArrayLike, covariance: ArrayLike, process_noise: float) -> Intention: ...


class GoalFilter:
    """The belief over destinations along a drive (2.1-2.3).

    Ten lines: `GoalFilter(GoalModel.load(path))`, then `update` at 10 Hz.
    """

    def __init__(
        self, model: GoalModel, data: Data = "sparse", *, action_model: ActionModel | OtherActionModel | None = None
    ) -> None:
        """`action_model`: one already built from `model`, where several filters share it."""
        self.goals, self.config = model.goals, model.config
        mean, covariance = prior_belief(model.goals.positions)
        noise = model.config.process_noise
        acting = action_model or model.action_model(data)
        self._filter: Intention = (
            IntentionFilter(acting, mean, covariance, noise)
            if isinstance(acting, ActionModel)
            else acting.intention_filter(mean, covariance, noise)
        )

    def reset(self) -> None:
        """Another drive: back to the prior."""
        self._filter.reset()

    def update(self, pose: ArrayLike, velocity: ArrayLike, joystick: ArrayLike) -> GoalBelief:
        """Pose (x, y [m], yaw [rad]) in the map, velocities (m/s, rad/s), stick (forward, left) -> belief.

        A stick at rest leaves the belief as it is. ValueError for what is not finite or a stick outside [-1, 1].
        """
        at, moving, stick = (np.asarray(v, float) for v in (pose, velocity, joystick))
        for name, values, size in (("pose", at, 3), ("velocity", moving, 2), ("joystick", stick, 2)):
            if values.shape != (size,) or not np.isfinite(values).all():
                raise ValueError(f"{name} must be {size} finite numbers, is {values.tolist()}")
        if np.abs(stick).max() > 1:
            raise ValueError(f"joystick is {stick.tolist()}, must lie in [-1, 1]")
        if np.hypot(*stick) >= self.config.at_rest:
            state = goal_state(at[None], moving[None], self.config.heading)[0]
            self._filter.update(state, stick)
        return self.belief

    @property
    def belief(self) -> GoalBelief:
        """As of the last update; before the first, the prior."""
        now, places = self._filter.belief, self.goals.positions
        likelihood = goal_likelihoods(now.mean, now.covariance, places)
        nearest = int(np.argmin(np.hypot(*(places - now.mean).T)))
        return GoalBelief(np.array(now.mean), np.array(now.covariance), likelihood, nearest)


def prior_belief(positions: Floats) -> tuple[Floats, Floats]:
    """Mean (2,) and covariance (2, 2) of the goals (L, 2), a little wider (F1)."""
    return positions.mean(axis=0), np.cov(positions.T, bias=True) + _SMALL * np.eye(2)
