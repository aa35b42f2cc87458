"""The Gaussian process as a scikit-learn estimator: passes sklearn.utils.estimator_checks.check_estimator."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from lfdcore.estimation import DifferentialEvolutionConfig, GaussianProcess
from lfdcore.training.parts.gp_hyperparameters import HyperParameterConfig, fit_hyper_parameters

Floats = NDArray[np.float64]


class GaussianProcessRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """f ~ GP(mean, kernel) with a length-scale a dimension and a noise variance a sample (App. C.3, ERRATA 33).

    family: squared_exponential (C.5), matern_3_2 or matern_5_2 (C.6); centre: take the targets' mean as the prior's
    (else 0, as in the thesis); generations: at most so many of differential evolution; polish: L-BFGS afterwards.
    After fit: kernel_, noise_ (standard deviation), mean_, log_marginal_likelihood_.
    """

    def __init__(
        self,
        *,
        family: str = "squared_exponential",
        centre: bool = True,
        generations: int = 300,
        polish: bool = True,
        random_state: Any = None,
    ) -> None:
        self.family = family
        self.centre = centre
        self.generations = generations
        self.polish = polish
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: ArrayLike, noise_variances: ArrayLike | float = 0.0) -> GaussianProcessRegressor:
        """X (N, D), y (N,), noise_variances (N,) or one for all: known before, beside the fitted noise."""
        inputs, outputs = validate_data(self, X, y, dtype=np.float64, y_numeric=True, order="C")
        targets = np.array(outputs, dtype=float)
        self.mean_ = float(targets.mean()) if self.centre else 0.0
        targets -= self.mean_
        variances = np.broadcast_to(np.asarray(noise_variances, dtype=float), targets.shape)
        seed = int(check_random_state(self.random_state).randint(2**31))
        evolution = DifferentialEvolutionConfig(generations=self.generations, absolute_tolerance=0.01, seed=seed)
        config = HyperParameterConfig(family=self.family, evolution=evolution, polish=self.polish)
        found = fit_hyper_parameters(inputs, targets, variances, config)
        self.kernel_, self.noise_ = found.kernel, found.noise
        self.log_marginal_likelihood_ = found.log_likelihood
        self._data = (inputs, targets, np.array(variances))
        self._condition()
        return self

    def _condition(self) -> None:
        self._process = GaussianProcess(*self._data, self.kernel_, self.noise_)

    def predict(self, X: ArrayLike, return_std: bool = False) -> Floats | tuple[Floats, Floats]:
        """X (M, D) -> mean (M,), with return_std also the standard deviation of f (C.4)."""
        check_is_fitted(self)
        queries = validate_data(self, X, dtype=np.float64, order="C", reset=False)
        moments = self._process.predict(queries)
        mean = moments.mean + self.mean_
        return (mean, np.sqrt(moments.variance)) if return_std else mean

    def __getstate__(self) -> dict[str, Any]:
        state = dict(super().__getstate__())
        state.pop("_process", None)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        if "_data" in state:
            self._condition()
