"""
One-class radial basis function networks.
"""

from __future__ import annotations
import numpy
import numpy.typing
import typing

__all__: list[str] = ["RbfNetwork", "RbfNetworkBank", "RbfNetworkConfig", "fit_rbf_network"]

class RbfNetworkConfig:
    """
    sigma: standard deviation of every Gaussian, in the inputs' units; threshold: stop once the largest squared residual is below it; max_centres: at most so many (App. C.1).
    """

    def __init__(self, *, sigma: float = 0.3, threshold: float = 0.01, max_centres: int = 20) -> None: ...
    @property
    def max_centres(self) -> int: ...
    @property
    def sigma(self) -> float: ...
    @property
    def threshold(self) -> float: ...

class RbfNetwork:
    """
    y = sum_j w_j exp(-|x - m_j|^2 / (2 sigma^2)), clipped to [0, 1]: 0 far from every centre.
    """

    def __init__(self, centres: numpy.typing.ArrayLike, weights: numpy.typing.ArrayLike, sigma: float) -> None: ...
    def predict(self, inputs: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Inputs (N, D) -> (N,) in [0, 1]; an input with NaN gives 0. ValueError for another D.
        """

    @property
    def centres(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M, D)
        """

    @property
    def sigma(self) -> float: ...
    @property
    def weights(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,)
        """

class RbfNetworkBank:
    """
    One-class RBF networks side by side, one a key (Sec. 3.3: one a cell), as flat arrays.
    """

    @staticmethod
    def fit(inputs: numpy.typing.ArrayLike, keys: numpy.typing.ArrayLike, config: RbfNetworkConfig) -> RbfNetworkBank:
        """
        Inputs (N, D), keys (N,) int -> a network for every key that occurs, all targets 1.
        """

    def __init__(
        self,
        keys: numpy.typing.ArrayLike,
        offsets: numpy.typing.ArrayLike,
        centres: numpy.typing.ArrayLike,
        weights: numpy.typing.ArrayLike,
        sigma: float,
    ) -> None:
        """
        Network c: keys[c] (rising), centres[offsets[c]:offsets[c+1]]. ValueError unless they fit together.
        """

    def __len__(self) -> int: ...
    def predict(
        self, shared: numpy.typing.ArrayLike, own: numpy.typing.ArrayLike
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        All C networks at once: inputs are `shared` (S,), the same for all, then the network's row of `own` (C, D - S) -> (C,) in [0, 1]. NaN or inf in `own` gives 0; ValueError for wrong sizes or NaN in `shared`.
        """

    @property
    def centres(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M, D), a view
        """

    @property
    def dimensions(self) -> int:
        """
        D
        """

    @property
    def keys(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (C,) int32, a view
        """

    @property
    def offsets(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (C + 1,) int32, a view
        """

    @property
    def sigma(self) -> float: ...
    @property
    def weights(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,), a view
        """

def fit_rbf_network(
    inputs: numpy.typing.ArrayLike, targets: numpy.typing.ArrayLike, config: RbfNetworkConfig
) -> RbfNetwork:
    """
    Alg. 5 (ERRATA 45): inputs (N, D), targets (N,) -> RbfNetwork. The next centre is the input of the largest squared residual; weights by least squares. ValueError for no or non-finite data.
    """
