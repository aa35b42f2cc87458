"""Radial basis function networks, Gaussian processes, differential evolution. Re-exports lfdcore._core.estimation."""

from lfdcore._core.estimation import (
    DifferentialEvolutionConfig,
    DifferentialEvolutionResult,
    GaussianMoments,
    GaussianProcess,
    GaussianProcessLikelihood,
    Kernel,
    RbfNetwork,
    RbfNetworkBank,
    RbfNetworkConfig,
    differential_evolution,
    fit_rbf_network,
)

__all__ = [
    "DifferentialEvolutionConfig",
    "DifferentialEvolutionResult",
    "GaussianMoments",
    "GaussianProcess",
    "GaussianProcessLikelihood",
    "Kernel",
    "RbfNetwork",
    "RbfNetworkBank",
    "RbfNetworkConfig",
    "differential_evolution",
    "fit_rbf_network",
]
