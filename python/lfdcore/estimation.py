"""One-class radial basis function networks. Re-exports lfdcore._core.estimation."""

from lfdcore._core.estimation import (
    RbfNetwork,
    RbfNetworkBank,
    RbfNetworkConfig,
    fit_rbf_network,
)

__all__ = [
    "RbfNetwork",
    "RbfNetworkBank",
    "RbfNetworkConfig",
    "fit_rbf_network",
]
