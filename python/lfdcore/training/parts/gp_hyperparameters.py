"""Hyper-parameters of Gaussian processes: differential evolution, then L-BFGS with the exact gradient (F4).

Both run on the C++ likelihood (C.3). Needs SciPy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from lfdcore.estimation import DifferentialEvolutionConfig, GaussianProcess, GaussianProcessLikelihood, Kernel
from lfdcore.wheelchair.heatmaps.joystick import JoystickBins, JoystickModel, JoystickModelConfig, JoystickPrior

Floats = NDArray[np.float64]
Range = tuple[float, float]


def _evolution() -> DifferentialEvolutionConfig:
    return DifferentialEvolutionConfig(absolute_tolerance=0.01, generations=300)


@dataclass(frozen=True)
class HyperParameterConfig:
    """The search: ranges are multiples of the data's own scale, so that they hold in any unit."""

    family: str = "squared_exponential"
    """squared_exponential (C.5), matern_3_2 or matern_5_2 (C.6)."""
    amplitude: Range = (0.01, 100.0)
    """Times the targets' root mean square."""
    lengthscale: Range = (0.01, 100.0)
    """Times the range of each input dimension."""
    longest: tuple[float, ...] = ()
    """The upper ends of the length-scales, one a dimension in its own unit, where not those of `lengthscale`."""
    noise: Range = (0.001, 1.0)
    """Times the targets' root mean square; not 0, or duplicate inputs have no likelihood."""
    evolution: DifferentialEvolutionConfig = field(default_factory=_evolution)
    polish: bool = True
    """L-BFGS from where differential evolution ended."""

    def __post_init__(self) -> None:
        for name in ("amplitude", "lengthscale", "noise"):
            low, high = getattr(self, name)
            if not 0 < low < high < np.inf:
                raise ValueError(f"{name} is {(low, high)}, must be finite, > 0 and rising")
        if not all(0 < length < np.inf for length in self.longest):
            raise ValueError(f"longest is {self.longest}, must be finite and > 0")


@dataclass(frozen=True)
class HyperParameters:
    """Where the search ended."""

    kernel: Kernel
    noise: float
    log_likelihood: float
    evaluations: int
    """Of the likelihood, those given up early and those with a gradient included."""


def search_bounds(inputs: Floats, targets: Floats, config: HyperParameterConfig) -> Floats:
    """(D + 2, 2): the box of log amplitude, log length-scales and log noise. ValueError if `longest` does not fit."""
    scale = float(np.sqrt(np.mean(targets**2))) or 1.0
    lengthscales = np.multiply.outer([w or 1.0 for w in np.ptp(inputs, axis=0)], config.lengthscale)
    if config.longest:
        if len(config.longest) != len(lengthscales):
            raise ValueError(f"longest has {len(config.longest)} length-scales for {len(lengthscales)} dimensions")
        lengthscales[:, 1] = config.longest
        lengthscales[:, 0] = np.minimum(lengthscales[:, 0], lengthscales[:, 1] / 10)
    rows = [np.multiply(config.amplitude, scale), *lengthscales, np.multiply(config.noise, scale)]
    bounds: Floats = np.log(np.array(rows))
    return bounds


def fit_hyper_parameters(
    inputs: ArrayLike,
    targets: ArrayLike,
    noise_variances: ArrayLike,
    config: HyperParameterConfig | None = None,
) -> HyperParameters:
    """Maximises C.3 for inputs (N, D), targets (N,) and the samples' own noise variances (N,).

    ValueError for data that no Gaussian process can use, or if no point of the box has a likelihood.
    """
    config = config or HyperParameterConfig()
    X, y = np.ascontiguousarray(inputs, dtype=float), np.ascontiguousarray(targets, dtype=float)
    likelihood = GaussianProcessLikelihood(X, y, np.asarray(noise_variances, dtype=float), family=config.family)
    bounds = search_bounds(X, y, config)
    found = likelihood.maximise(bounds, config.evolution)
    best, value, evaluations = np.array(found.best), found.value, found.evaluations
    if not np.isfinite(value):
        raise ValueError("no hyper-parameters in the box have a likelihood: raise the lower bound of noise")
    if config.polish:
        best, value, more = _polish(likelihood, best, value, bounds)
        evaluations += more
    sizes = np.exp(best)
    kernel = Kernel(sizes[0], sizes[1:-1], family=config.family)
    return HyperParameters(kernel, float(sizes[-1]), value, evaluations)


def _polish(
    likelihood: GaussianProcessLikelihood, best: Floats, value: float, bounds: Floats
) -> tuple[Floats, float, int]:
    def negative(at: Floats) -> tuple[float, Floats]:
        found, slope = likelihood.evaluate_with_gradient(at)
        return (-found, -slope) if np.isfinite(found) else (1e300, np.zeros_like(at))

    result: Any = minimize(negative, best, jac=True, method="L-BFGS-B", bounds=bounds)
    if -result.fun < value:
        return best, value, int(result.nfev)
    return result.x, float(-result.fun), int(result.nfev)


def fit_gaussian_process(
    inputs: ArrayLike,
    targets: ArrayLike,
    noise_variances: ArrayLike,
    config: HyperParameterConfig | None = None,
) -> GaussianProcess:
    """A Gaussian process with fitted hyper-parameters; arguments as `fit_hyper_parameters`."""
    found = fit_hyper_parameters(inputs, targets, noise_variances, config)
    X = np.ascontiguousarray(inputs, dtype=float)
    return GaussianProcess(
        X, np.asarray(targets, dtype=float), np.asarray(noise_variances, dtype=float), found.kernel, found.noise
    )


STICK_SEARCH = HyperParameterConfig(amplitude=(0.01, 1.0), lengthscale=(0.1, 1.0))
"""Length-scales from a bin of the used range to all of it: where nothing was corrected, any other would do as well. And
no driver to come is thought to be corrected by more than demonstrators were: for some draws of demonstrations the
likelihood is largest at several times that, which says of a stick beyond theirs that it may mean anything."""


def fit_joystick_model(
    raw: ArrayLike,
    safe: ArrayLike,
    config: JoystickModelConfig | None = None,
    search: HyperParameterConfig = STICK_SEARCH,
    least_amplitude: float = 0.1,
) -> JoystickModel:
    """The model of Sec. 4.4.2 from pairs (N, 2) of raw and safe joystick, (forward, left): bins, then one search of
    hyper-parameters for each axis. Able demonstrators are hardly corrected; the driver to come may be, so the amplitude
    is at least least_amplitude.

    ValueError for pairs that do not fit, are not finite or outside [-1, 1].
    """
    config = config or JoystickModelConfig()
    bins = JoystickBins.of_pairs(raw, safe, config)
    priors = []
    for axis in (0, 1):
        inputs, targets, variances = bins.training_data(axis, config)
        found = fit_hyper_parameters(inputs, targets, variances, search)
        amplitude = max(found.kernel.amplitude, least_amplitude)
        kernel = Kernel(amplitude, found.kernel.lengthscales, family=found.kernel.family)
        priors.append(JoystickPrior(kernel, found.noise))
    return JoystickModel(bins, (priors[0], priors[1]), config)
