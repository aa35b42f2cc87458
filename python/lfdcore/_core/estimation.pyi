"""
Radial basis function networks, Gaussian processes, differential evolution, intention.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
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

class RbfNetworkConfig:
    """
    sigma: standard deviation of every Gaussian, in the inputs' units; threshold: stop once the largest squared residual is below it; max_centres: at most so many (App. C.1).
    """

    def __hash__(self) -> int: ...
    def __init__(self, *, sigma: float = 0.3, threshold: float = 0.01, max_centres: int = 20) -> None: ...
    def __repr__(self) -> str: ...
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

class Kernel:
    """
    A stationary covariance function with a length-scale for every input dimension, over r^2 = sum ((x_d - x'_d) / l_d)^2: 'squared_exponential' (C.5), 'matern_3_2' or 'matern_5_2' (C.6).
    """

    def __init__(
        self, amplitude: float, lengthscales: numpy.typing.ArrayLike, *, family: str = "squared_exponential"
    ) -> None:
        """
        amplitude: standard deviation of f, in the targets' unit; lengthscales (D,), in the inputs' units. ValueError unless all are > 0 and finite.
        """

    def covariance(self, a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Inputs (N, D), (M, D) -> (N, M). ValueError for another D.
        """

    @property
    def amplitude(self) -> float: ...
    @property
    def family(self) -> str: ...
    @property
    def lengthscales(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a view
        """

class DifferentialEvolutionConfig:
    """
    best/1/bin with dither, as SciPy's defaults: population: members for every parameter; generations: at most; recombination: probability of the mutant's parameter; mutation_low, mutation_high: range of the difference's weight; done once the values' standard deviation is <= absolute_tolerance + tolerance |mean|; seed.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        population: int = 15,
        generations: int = 1000,
        recombination: float = 0.7,
        mutation_low: float = 0.5,
        mutation_high: float = 1.0,
        tolerance: float = 0.01,
        absolute_tolerance: float = 0.0,
        seed: int = 0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def absolute_tolerance(self) -> float: ...
    @property
    def generations(self) -> int: ...
    @property
    def mutation_high(self) -> float: ...
    @property
    def mutation_low(self) -> float: ...
    @property
    def population(self) -> int: ...
    @property
    def recombination(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def tolerance(self) -> float: ...

class DifferentialEvolutionResult:
    """
    best (D,), its value, generations, evaluations; converged is False if the generations ran out.
    """

    @property
    def best(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a view
        """

    @property
    def converged(self) -> bool: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def generations(self) -> int: ...
    @property
    def value(self) -> float: ...

class GaussianMoments:
    """
    mean (M,) and variance (M,) of M Gaussians.
    """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,), a view
        """

    @property
    def variance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,) >= 0, a view
        """

class GaussianProcess:
    """
    y_n = f(x_n) + e_n, f ~ GP(0, kernel), e_n ~ N(0, noise_variances[n] + noise^2): conditioned once (App. C.3, ERRATA 33), then asked as often as wanted, from any thread.
    """

    def __init__(
        self,
        inputs: numpy.typing.ArrayLike,
        targets: numpy.typing.ArrayLike,
        noise_variances: numpy.typing.ArrayLike,
        kernel: Kernel,
        noise: float,
    ) -> None:
        """
        inputs (N, D), targets (N,), noise_variances (N,) the samples' own, noise a standard deviation. ValueError for data or parameters that do not fit, and if the covariance is not positive definite.
        """

    def __len__(self) -> int: ...
    def predict(self, queries: numpy.typing.ArrayLike, with_noise: bool = False) -> GaussianMoments:
        """
        Queries (M, D) -> mean and variance of f there (C.4), with_noise of y (noise^2 added). A query with NaN or inf gives NaN. ValueError for another D.
        """

    def predict_one(self, query: numpy.typing.ArrayLike) -> tuple[float, float]:
        """
        One query (D,) -> (mean, variance) of f: `predict` with less overhead.
        """

    @property
    def dimensions(self) -> int:
        """
        D
        """

    @property
    def kernel(self) -> Kernel: ...
    @property
    def log_likelihood(self) -> float:
        """
        C.3 of the data conditioned on
        """

    @property
    def noise(self) -> float: ...

class GaussianProcessLikelihood:
    """
    log p(Y | X) as a function of (log amplitude, log l_1 .. log l_D, log noise) (C.3).
    """

    def __init__(
        self,
        inputs: numpy.typing.ArrayLike,
        targets: numpy.typing.ArrayLike,
        noise_variances: numpy.typing.ArrayLike,
        *,
        family: str = "squared_exponential",
    ) -> None:
        """
        inputs (N, D), targets (N,), noise_variances (N,). ValueError for data that do not fit or are not finite.
        """

    def __len__(self) -> int: ...
    def evaluate(self, log_parameters: numpy.typing.ArrayLike, give_up_below: float = ...) -> float:
        """
        log_parameters (D + 2,) -> log p(Y | X) with K + diag(noise_variances + noise^2) (ERRATA 33); -inf where that is not positive definite, and early where the result is certain to be below give_up_below.
        """

    def evaluate_with_gradient(
        self, log_parameters: numpy.typing.ArrayLike
    ) -> tuple[float, numpy.typing.NDArray[numpy.float64]]:
        """
        -> log p(Y | X), its derivatives (D + 2,); NaN where the likelihood is -inf.
        """

    def maximise(
        self, bounds: numpy.typing.ArrayLike, config: DifferentialEvolutionConfig = ...
    ) -> DifferentialEvolutionResult:
        """
        Differential evolution over bounds (D + 2, 2) of the log parameters; the result's value is the likelihood.
        """

    @property
    def dimensions(self) -> int:
        """
        D
        """

class ActionKernel:
    """
    k((x, g), (x', g')) = a^2 exp(-r^2 / 2) over state and goal (C.5), and the action's noise: one action's. H is the squares of the length-scales (ERRATA 3).
    """

    def __init__(
        self,
        amplitude: float,
        state_lengthscales: numpy.typing.ArrayLike,
        goal_lengthscales: numpy.typing.ArrayLike,
        noise: float,
    ) -> None:
        """
        amplitude and noise: standard deviations in the action's unit; state_lengthscales (Dx,) in the state's units; goal_lengthscales (Dg,) [m], at most 4. ValueError unless noise is in [0, 1e20], all others in [1e-20, 1e20].
        """

    @property
    def amplitude(self) -> float: ...
    @property
    def goal_lengthscales(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (Dg,) [m], a view
        """

    @property
    def noise(self) -> float: ...
    @property
    def state_lengthscales(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (Dx,), a view
        """

class ActionMoments:
    """
    Joint moments of the action and the goal (Sec. 2.3).
    """

    def __init__(
        self, mean: numpy.typing.ArrayLike, covariance: numpy.typing.ArrayLike, cross_covariance: numpy.typing.ArrayLike
    ) -> None:
        """
        ValueError for shapes that do not fit.
        """

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        G (Da, Da), a copy: of y, so with the noise (ERRATA 2)
        """

    @property
    def cross_covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        C (Dg, Da), a copy: of the goal with y
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        m (Da,), a copy
        """

class Belief:
    """
    A Gaussian over the goal.
    """

    def __init__(self, mean: numpy.typing.ArrayLike, covariance: numpy.typing.ArrayLike) -> None:
        """
        mean (Dg,) [m], covariance (Dg, Dg) [m^2], may be singular. ValueError unless finite, symmetric and positive semidefinite (up to 1e-9 of the trace).
        """

    def conditioned(self, moments: ActionMoments, action: numpy.typing.ArrayLike) -> Belief:
        """
        The belief after the action (Da,), whose joint moments with the goal these are (2.2-2.3). ValueError for other sizes, for what is not finite and if the action's covariance is singular (kernels without noise).
        """

    def widened(self, prior: Belief, process_noise: float) -> Belief:
        """
        With process_noise [m^2] more variance along every axis, then cut where that is wider than the prior (not if the prior is singular). ValueError for a negative process_noise.
        """

    @property
    def covariance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (Dg, Dg) [m^2], a copy
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (Dg,) [m], a copy
        """

class ActionModel:
    """
    What a driver does on the way to a goal: Gaussian processes p(y_a | goal, state), conditioned once (Sec. 2.3, ERRATA 1-4 and 14), then asked as often as wanted, from any thread.
    """

    def __init__(
        self,
        states: numpy.typing.ArrayLike,
        goals: numpy.typing.ArrayLike,
        actions: numpy.typing.ArrayLike,
        kernels: collections.abc.Sequence[ActionKernel],
        subset: numpy.typing.ArrayLike | None = None,
        projected: bool = True,
    ) -> None:
        """
        states (N, Dx), goals (N, Dg) [m], actions (N, Da), a kernel for every action. subset (S,) integers: the samples to use, if projected as the basis of a predictor that keeps all N targets (DTC, ERRATA 14; what others of the subset span to 1e-10 is left out), else as a smaller training set, as the thesis has it. Holds 4 N^2 bytes an action, 4 S^2 with a subset. ValueError for data that do not fit or are not finite, indices out of range or named twice, a covariance that is not positive definite.
        """

    def __len__(self) -> int: ...
    def moments(
        self, state: numpy.typing.ArrayLike, mean: numpy.typing.ArrayLike, covariance: numpy.typing.ArrayLike
    ) -> ActionMoments:
        """
        Exact moments at state (Dx,) for a goal ~ N(mean (Dg,), covariance (Dg, Dg)), which may be singular. ValueError for other sizes and what is not finite.
        """

    @property
    def actions(self) -> int:
        """
        Da
        """

    @property
    def goal_dimensions(self) -> int:
        """
        Dg
        """

    @property
    def kernels(self) -> list[ActionKernel]: ...
    @property
    def nbytes(self) -> int:
        """
        memory held
        """

    @property
    def shared_goals(self) -> int:
        """
        goals that differ, if few enough for sums over pairs of goals in place of pairs of samples (about 8 N >= L^2), else 0
        """

    @property
    def size(self) -> int:
        """
        samples asked for: N, or the subset's
        """

    @property
    def state_dimensions(self) -> int:
        """
        Dx
        """

class IntentionFilter:
    """
    The belief over the driver's goal, updated action by action (2.2-2.3).
    """

    def __init__(
        self,
        model: ActionModel,
        mean: numpy.typing.ArrayLike,
        covariance: numpy.typing.ArrayLike,
        process_noise: float = 0.0,
    ) -> None:
        """
        Prior mean (Dg,) [m] and covariance (Dg, Dg) [m^2]; process_noise [m^2] widens the belief before every update (Belief.widened): 0 is the thesis, whose belief gets overconfident (ERRATA 6). ValueError for a prior that is none of the model's goals and a negative process_noise.
        """

    def reset(self) -> None:
        """
        Back to the prior.
        """

    def update(self, state: numpy.typing.ArrayLike, action: numpy.typing.ArrayLike) -> Belief:
        """
        The action (Da,) taken at state (Dx,) -> the new belief. ValueError, and the belief stays as it was, for other sizes, for what is not finite and if the action's covariance is singular (kernels without noise).
        """

    @property
    def belief(self) -> Belief: ...
    @property
    def model(self) -> ActionModel: ...
    @property
    def process_noise(self) -> float:
        """
        [m^2]
        """

def differential_evolution(
    objective: collections.abc.Callable[[numpy.typing.NDArray[numpy.float64]], float],
    bounds: numpy.typing.ArrayLike,
    config: DifferentialEvolutionConfig = ...,
) -> DifferentialEvolutionResult:
    """
    Minimises objective((D,)) -> float in the box of bounds (D, 2); NaN counts as +inf. The same seed gives the same result. ValueError for bounds that are not finite or not low < high.
    """

def fit_rbf_network(
    inputs: numpy.typing.ArrayLike, targets: numpy.typing.ArrayLike, config: RbfNetworkConfig
) -> RbfNetwork:
    """
    Alg. 5 (ERRATA 45): inputs (N, D), targets (N,) -> RbfNetwork. The next centre is the input of the largest squared residual; weights by least squares. ValueError for no or non-finite data.
    """

def goal_likelihoods(
    mean: numpy.typing.ArrayLike, covariance: numpy.typing.ArrayLike, goals: numpy.typing.ArrayLike
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Goals (L, Dg) -> (L,) likelihoods that sum to 1: softmax of -d^2 / 2, d the Mahalanobis distance (ERRATA F1). Standard deviations below 1e-6 of the largest, or 1 nm, count as that: a belief without spread gives all to the nearest goal. ValueError for no goals and what is not finite.
    """

def select_subset(
    states: numpy.typing.ArrayLike,
    goals: numpy.typing.ArrayLike,
    actions: numpy.typing.ArrayLike,
    kernels: collections.abc.Sequence[ActionKernel],
    size: int,
    candidates: int = 59,
    seed: int = 1,
) -> numpy.typing.NDArray[numpy.int64]:
    """
    Alg. 1 (ERRATA 11): (size,) int64 indices in the order of selection. In each round, of `candidates` samples drawn from those left, the one that lowers sum_a Q_a / var(y_a) most; ties to the smallest index; one that the selected span to 1e-10 gains nothing (ERRATA 13). Needs some 8 N (size + 96) bytes an action. ValueError for a size that is not in [1, N], candidates < 1, and as ActionModel.
    """
