"""Radial basis function networks, Gaussian processes, differential evolution, the driver's intention.

Re-exports lfdcore._core.estimation.
"""

from lfdcore._core.estimation import (
    ActionKernel,
    ActionModel,
    ActionMoments,
    Belief,
    DifferentialEvolutionConfig,
    DifferentialEvolutionResult,
    GaussianMoments,
    GaussianProcess,
    GaussianProcessLikelihood,
    IntentionFilter,
    Kernel,
    RbfNetwork,
    RbfNetworkBank,
    RbfNetworkConfig,
    differential_evolution,
    fit_rbf_network,
    goal_likelihoods,
    select_subset,
)

__all__ = [
    "ActionKernel",
    "ActionModel",
    "ActionMoments",
    "Belief",
    "DifferentialEvolutionConfig",
    "DifferentialEvolutionResult",
    "GaussianMoments",
    "GaussianProcess",
    "GaussianProcessLikelihood",
    "IntentionFilter",
    "Kernel",
    "RbfNetwork",
    "RbfNetworkBank",
    "RbfNetworkConfig",
    "differential_evolution",
    "fit_rbf_network",
    "goal_likelihoods",
    "select_subset",
]
