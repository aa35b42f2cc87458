"""lfdcore learn goals: network, hyper-parameters, process noise and subset from drives to destinations (Ch. 2)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.goals import Goals
from lfdcore.estimation import (
    ActionKernel,
    DifferentialEvolutionConfig,
    GaussianProcessLikelihood,
    Kernel,
    select_subset,
)
from lfdcore.progress import StageProgress, silent
from lfdcore.training.parts.goal_net import GoalNetConfig, train_goal_network
from lfdcore.training.parts.gp_hyperparameters import HyperParameterConfig, HyperParameters, fit_hyper_parameters
from lfdcore.training.parts.process_noise import best_calibrated, leave_drives_out
from lfdcore.wheelchair.goals.model import GoalFilterConfig, GoalModel, LeftOutFigures
from lfdcore.wheelchair.goals.samples import GoalSamples, Heading, goal_samples, goal_state

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LongestScales:
    """Upper ends of the kernels' length-scales; what each is for stands in docs/decisions.md."""

    position: float = 0.4
    """[m]"""
    heading: float = 0.7
    """of cosine and sine, or [rad]"""
    linear: float = 0.5
    """[m/s]"""
    angular: float = 1.0
    """[rad/s]"""
    goal: float = 10.0
    """[m]"""

    def of(self, heading: Heading) -> tuple[float, ...]:
        """(Dx + 2,) in the order of a state and a goal."""
        headings = (self.heading,) * (1 if heading == "raw" else 2)
        return (self.position, self.position, *headings, self.linear, self.angular, self.goal, self.goal)


@dataclass(frozen=True, kw_only=True)
class GoalLearningConfig:
    """filter: how the model will be used; network: of Sec. 2.2; search_samples: drawn by seed, on which kernels (C.3)
    are searched for `searches` times from other populations of `generations` each, the best being kept; longest: ends
    of that search; subset: how many samples Alg. 1 takes (all, where there are fewer); candidates: kappa, at each
    step it takes the best of so many; process_noises [m^2]: the filter's is the one of these that makes beliefs as wide
    as their errors along the drives that `folds` leave out, the largest of all if no destination has two drives."""

    filter: GoalFilterConfig = field(default_factory=GoalFilterConfig)
    network: GoalNetConfig = field(default_factory=GoalNetConfig)
    search_samples: int = 400
    searches: int = 2
    longest: LongestScales = field(default_factory=LongestScales)
    generations: int = 60
    subset: int = 800
    candidates: int = 59
    process_noises: tuple[float, ...] = (0.0, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
    folds: int = 3
    seed: int = 1

    def __post_init__(self) -> None:
        if not 2 <= self.search_samples <= 800:
            raise ValueError(f"search_samples is {self.search_samples}, must be 2..800: the likelihood costs its cube")
        for name in ("searches", "generations", "subset", "candidates", "folds"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1")
        if not self.process_noises or not all(0 <= noise < np.inf for noise in self.process_noises):
            raise ValueError(f"process_noises are {self.process_noises} m^2, must be one or more, >= 0 and finite")

    @staticmethod
    def thesis() -> GoalLearningConfig:
        """The printed form: see GoalFilterConfig.thesis."""
        return GoalLearningConfig(
            filter=GoalFilterConfig.thesis(), network=GoalNetConfig(heading="raw"), process_noises=(0.0,)
        )


def learn_goals(
    logs: Sequence[DriveLog],
    goals: Goals,
    config: GoalLearningConfig | None = None,
    progress: StageProgress | None = None,
    processes: int = 1,
) -> GoalModel:
    """From drives whose metadata name their destination. ValueError where a goal has no drive or a log no stick.

    `processes`: that search hyper-parameters side by side, by joblib, so that any of its backends serves (inside
    `joblib.parallel_config("dask")` a cluster); the result does not depend on it.
    """
    config, tell = config or GoalLearningConfig(), progress or silent
    samples = moving(goal_samples(logs, goals), config.filter.at_rest)
    network = train_goal_network(samples, len(goals), config.network, partial(tell, "network"))
    kernels = fit_action_kernels(samples, goals, config, tell, processes)

    def with_subset(chosen: GoalSamples) -> GoalModel:
        subset = _chosen_subset(chosen, goals, kernels, config)
        return GoalModel(goals, chosen, kernels, subset, network, config.filter)

    left_out = leave_drives_out(
        samples, config.folds, config.process_noises, with_subset, partial(tell, "process noise")
    )
    tell("subset", 0, 1)
    model = with_subset(samples)
    tell("subset", 1, 1)
    metadata = {"logs": [log.name for log in logs], "data_sha256": data_hash(samples), "seed": config.seed}
    return replace(model, config=_calibrated(config, left_out), left_out=tuple(left_out), metadata=metadata)


def _chosen_subset(
    samples: GoalSamples, goals: Goals, kernels: tuple[ActionKernel, ActionKernel], config: GoalLearningConfig
) -> NDArray[np.int64]:
    return select_subset(
        goal_state(samples.pose, samples.twist, config.filter.heading),
        goals.positions[samples.goal],
        samples.joystick,
        list(kernels),
        size=min(config.subset, len(samples)),
        candidates=config.candidates,
        seed=config.seed,
    )


def _calibrated(config: GoalLearningConfig, left_out: list[LeftOutFigures]) -> GoalFilterConfig:
    """The filter with the process noise that drives left out ask for."""
    noise = best_calibrated(left_out) if left_out else max(config.process_noises)
    return replace(config.filter, process_noise=noise)


def moving(samples: GoalSamples, at_rest: float) -> GoalSamples:
    """Without those whose stick is displaced less than `at_rest`. ValueError if none is left."""
    chosen = samples.where(np.hypot(*samples.joystick.T) >= at_rest)
    if not len(chosen):
        raise ValueError(f"of {len(samples)} samples no stick is displaced by {at_rest} or more: nothing to learn from")
    return chosen


def data_hash(samples: GoalSamples) -> str:
    """SHA-256 of what was learned from, as hexadecimal text."""
    digest = hashlib.sha256()
    for name, array in sorted(samples.arrays().items()):
        digest.update(name.encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def fit_action_kernels(
    samples: GoalSamples,
    goals: Goals,
    config: GoalLearningConfig,
    progress: StageProgress | None = None,
    processes: int = 1,
) -> tuple[ActionKernel, ActionKernel]:
    """Type-II maximum likelihood (C.3 corrected, F4) for forward and left, on a seeded draw of the samples."""
    tell = progress or silent
    drawn = drawn_samples(len(samples), config)
    inputs, targets = action_inputs(samples, goals, config)
    jobs = [(axis, k) for axis in (0, 1) for k in range(config.searches)]
    total, found = len(jobs), []
    tell("kernels", 0, total)
    searches = Parallel(n_jobs=processes, return_as="generator")(
        delayed(_search_once)(inputs[drawn], targets[drawn, axis], config, k) for axis, k in jobs
    )
    for one in searches:
        found.append(one)
        tell("kernels", len(found), total)
    best = [max(found[axis * config.searches :][: config.searches], key=lambda f: f.log_likelihood) for axis in (0, 1)]
    states = inputs.shape[1] - 2
    first, second = (action_kernel(one.kernel, one.noise, states) for one in best)
    return first, second


def drawn_samples(count: int, config: GoalLearningConfig) -> NDArray[np.int64]:
    """Ascending indices of those of `count` samples that kernels are searched on."""
    return np.sort(np.random.default_rng(config.seed).permutation(count)[: config.search_samples])


def action_inputs(samples: GoalSamples, goals: Goals, config: GoalLearningConfig) -> tuple[Floats, Floats]:
    """(N, Dx + 2) states and destinations side by side, (N, 2) sticks."""
    states = goal_state(samples.pose, samples.twist, config.filter.heading)
    return np.ascontiguousarray(np.column_stack([states, goals.positions[samples.goal]])), samples.joystick


def _search_once(inputs: Floats, targets: Floats, config: GoalLearningConfig, number: int) -> HyperParameters:
    evolution = DifferentialEvolutionConfig(
        absolute_tolerance=0.1, generations=config.generations, seed=config.seed + number
    )
    search = HyperParameterConfig(
        lengthscale=(0.01, 1.0),
        longest=config.longest.of(config.filter.heading),
        amplitude=(0.1, 10.0),
        noise=(0.01, 1.0),
        evolution=evolution,
    )
    return fit_hyper_parameters(inputs, np.ascontiguousarray(targets), np.zeros(len(inputs)), search)


def action_kernel(kernel: Kernel, noise: float, states: int) -> ActionKernel:
    """The kernel over (x, g) taken apart: the first `states` length-scales are the state's."""
    sizes = np.asarray(kernel.lengthscales)
    return ActionKernel(kernel.amplitude, sizes[:states], sizes[states:], noise)


@dataclass(frozen=True)
class KernelLikelihood:
    """C.3 of one axis of the stick, for the kernel that its search found."""

    drawn: int
    """samples searched on"""
    samples: int
    """all of them"""
    of_drawn: float
    of_all: float


def kernel_likelihoods(
    samples: GoalSamples,
    goals: Goals,
    kernels: tuple[ActionKernel, ActionKernel],
    config: GoalLearningConfig,
    progress: StageProgress | None = None,
) -> tuple[KernelLikelihood, KernelLikelihood]:
    """Of forward and left, once each: for N = 10^4 some 15 s and 4 N^2 bytes (400 MB)."""
    tell = progress or silent
    inputs, targets = action_inputs(samples, goals, config)
    drawn, found = drawn_samples(len(samples), config), []
    for axis, kernel in enumerate(kernels):
        tell("likelihood", axis, 2)
        of_drawn = log_likelihood(inputs[drawn], targets[drawn, axis], kernel)
        of_all = log_likelihood(inputs, targets[:, axis], kernel)
        found.append(KernelLikelihood(len(drawn), len(samples), of_drawn, of_all))
    tell("likelihood", 2, 2)
    forward, left = found
    return forward, left


def log_likelihood(inputs: Floats, targets: Floats, kernel: ActionKernel) -> float:
    """log p(targets (N,) | inputs (N, Dx + Dg)) (C.3)."""
    likelihood = GaussianProcessLikelihood(inputs, np.ascontiguousarray(targets), np.zeros(len(inputs)))
    sizes = [kernel.amplitude, *kernel.state_lengthscales, *kernel.goal_lengthscales, kernel.noise]
    return float(likelihood.evaluate(np.log(sizes)))
