"""Gaussian processes against scikit-learn's, and the search of their hyper-parameters against SciPy's."""

import copy
import pickle
import threading

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import differential_evolution as scipy_evolution
from sklearn.gaussian_process import kernels as sklearn_kernels

from lfdcore.estimation import (
    DifferentialEvolutionConfig,
    GaussianProcess,
    GaussianProcessLikelihood,
    Kernel,
    differential_evolution,
)
from lfdcore.training.estimators.gaussian_process_regressor import GaussianProcessRegressor
from lfdcore.training.parts.gp_hyperparameters import (
    HyperParameterConfig,
    fit_gaussian_process,
    fit_hyper_parameters,
    search_bounds,
)

Floats = NDArray[np.float64]
FAMILIES = ("squared_exponential", "matern_3_2", "matern_5_2")


def data(count: int, seed: int = 0, dims: int = 2) -> tuple[Floats, Floats, Floats]:
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (count, dims))
    variances = random.uniform(0.001, 0.02, count)
    return X, np.sin(3 * X[:, 0]) + 0.5 * X[:, -1] + random.normal(0, np.sqrt(variances)), variances


def theirs(family: str, amplitude: float, scales: Floats) -> object:
    nu = {"matern_3_2": 1.5, "matern_5_2": 2.5}
    k = sklearn_kernels
    shape = k.RBF(scales) if family == "squared_exponential" else k.Matern(scales, nu=nu[family])
    return k.ConstantKernel(amplitude**2) * shape


@pytest.mark.parametrize("family", FAMILIES)
def test_likelihood_gradient_and_moments_are_scikit_learns_with_its_alpha_a_sample(family: str) -> None:
    from sklearn.gaussian_process import GaussianProcessRegressor as Theirs

    X, y, variances = data(90)
    scales, noise = np.array([0.5, 0.8]), 0.1
    rival = Theirs(theirs(family, 1.2, scales), alpha=variances + noise**2, optimizer=None).fit(X, y)
    value, slope = rival.log_marginal_likelihood(rival.kernel_.theta, eval_gradient=True)
    likelihood = GaussianProcessLikelihood(X, y, variances, family=family)
    ours, derivatives = likelihood.evaluate_with_gradient(np.log([1.2, *scales, noise]))
    assert ours == pytest.approx(value, rel=1e-10)
    assert derivatives[:3] == pytest.approx(slope * [2, 1, 1], rel=1e-8)  # theirs is by the log of a^2

    process = GaussianProcess(X, y, variances, Kernel(1.2, scales, family=family), noise)
    queries = np.random.default_rng(1).uniform(-2, 2, (77, 2))
    mean, sd = rival.predict(queries, return_std=True)
    moments = process.predict(queries)
    assert moments.mean == pytest.approx(mean, abs=1e-10)
    assert moments.variance == pytest.approx(sd**2, abs=1e-10)
    assert process.predict_one(queries[5]) == pytest.approx((mean[5], sd[5] ** 2), abs=1e-10)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_kernel_matrix_is_scikit_learns(family: str) -> None:
    a, b = data(20)[0], data(7, seed=1)[0]
    ours = Kernel(0.7, [0.3, 2.0], family=family).covariance(a, b)
    assert ours == pytest.approx(theirs(family, 0.7, np.array([0.3, 2.0]))(a, b), abs=1e-14)  # type: ignore[operator]


def test_evolution_ends_at_the_optimum_that_scipy_finds_with_numpys_likelihood() -> None:
    X, y, variances = data(60)
    bounds = search_bounds(X, y, HyperParameterConfig())

    def negative(at: Floats) -> float:
        a, l1, l2, noise = np.exp(at)
        squared = ((X[:, None] - X) ** 2 / np.array([l1, l2]) ** 2).sum(2)
        K = a**2 * np.exp(-0.5 * squared) + np.diag(variances + noise**2)
        sign, logdet = np.linalg.slogdet(K)
        return float(0.5 * y @ np.linalg.solve(K, y) + 0.5 * logdet + 30 * np.log(2 * np.pi)) if sign > 0 else np.inf

    rival = scipy_evolution(negative, bounds, seed=0, tol=1e-6)
    ours = fit_hyper_parameters(X, y, variances)
    assert ours.log_likelihood == pytest.approx(-rival.fun, abs=1e-3)
    shape = np.log([ours.kernel.amplitude, *ours.kernel.lengthscales])
    assert shape == pytest.approx(rival.x[:3], abs=0.02)  # the noise is at its lower bound, where nothing depends on it


def test_the_search_finds_the_parameters_the_data_were_drawn_from() -> None:
    random = np.random.default_rng(3)
    X = random.uniform(-1, 1, (300, 2))
    K = Kernel(1.5, [0.3, 0.9]).covariance(X, X) + 0.05**2 * np.eye(300)
    y = np.linalg.cholesky(K) @ random.normal(size=300)
    found = fit_hyper_parameters(X, y, np.zeros(300))
    assert found.kernel.lengthscales == pytest.approx([0.3, 0.9], rel=0.25)
    assert found.noise == pytest.approx(0.05, rel=0.15)


def test_the_same_seed_gives_the_same_parameters() -> None:
    X, y, variances = data(40)
    first, second = (fit_hyper_parameters(X, y, variances) for _ in range(2))
    assert np.array_equal(first.kernel.lengthscales, second.kernel.lengthscales)
    assert first.noise == second.noise


def test_the_moments_of_y_are_those_of_f_with_the_noise_added() -> None:
    random = np.random.default_rng(4)
    X, y = random.normal(size=(30, 2)), random.normal(size=30)
    process = GaussianProcess(X, y, np.zeros(30), Kernel(1.0, [0.7, 0.7]), 0.3)
    for queries in (random.normal(size=(2, 2)), random.normal(size=(40, 2))):
        of_f, of_y = process.predict(queries), process.predict(queries, with_noise=True)
        np.testing.assert_array_equal(of_y.mean, of_f.mean)
        np.testing.assert_allclose(of_y.variance, of_f.variance + 0.09, rtol=1e-12)


def test_precise_samples_count_more_than_noisy_ones() -> None:
    X = np.array([[0.0], [0.0]])
    process = GaussianProcess(X, [0.0, 1.0], [1.0, 0.01], Kernel(10.0, [1.0]), 0.0)
    weights = np.array([1 / 1.0, 1 / 0.01])
    assert process.predict([[0.0]]).mean[0] == pytest.approx(weights[1] / (weights.sum() + 1 / 100), rel=1e-12)


@pytest.mark.parametrize("count", [1, 2])
def test_one_or_two_samples_and_samples_that_are_all_alike_still_make_a_process(count: int) -> None:
    X = np.zeros((count, 2))
    process = fit_gaussian_process(X, np.ones(count), np.zeros(count))
    assert np.isfinite(process.predict([[0.0, 0.0], [5.0, 5.0]]).mean).all()
    still = fit_gaussian_process(X, np.zeros(count), np.zeros(count))
    assert still.predict([[0.0, 0.0]]).mean[0] == 0


def test_huge_lengthscales_with_noise_are_a_constant_and_without_are_refused() -> None:
    X, y, _ = data(50)
    flat = Kernel(1.0, [1e8, 1e8])
    mean = GaussianProcess(X, y, np.zeros(50), flat, 0.1).predict(X).mean
    assert mean == pytest.approx(np.full(50, y.sum() / (50 + 0.01)), abs=1e-10)
    with pytest.raises(ValueError, match=r"not positive definite at sample .* raise the noise"):
        GaussianProcess(X, y, np.zeros(50), flat, 0.0)


def test_duplicate_inputs_without_noise_are_refused_and_with_noise_are_averaged() -> None:
    X = np.array([[0.0], [0.0], [1.0]])
    with pytest.raises(ValueError, match="duplicate inputs"):
        GaussianProcess(X, [1.0, 2.0, 0.0], np.zeros(3), Kernel(1.0, [0.1]), 0.0)
    mean = GaussianProcess(X, [1.0, 2.0, 0.0], np.full(3, 1e-8), Kernel(1.0, [0.1]), 0.0).predict([[0.0]]).mean
    assert mean[0] == pytest.approx(1.5, abs=1e-6)


@pytest.mark.parametrize(
    ("X", "y", "variances", "message"),
    [
        (np.zeros((0, 2)), [], [], "at least one training input"),
        (np.full((2, 1), np.nan), [0.0, 0.0], [0.0, 0.0], "must be finite"),
        (np.zeros((2, 1)), [0.0, np.inf], [0.0, 0.0], "must be finite"),
        (np.zeros((2, 1)), [0.0], [0.0, 0.0], "2 training inputs but 1 targets"),
        (np.zeros((2, 1)), [0.0, 0.0], [0.0, -1.0], "not negative"),
        (np.zeros((2, 1)), [0.0, 0.0], [0.0, np.nan], "must be finite"),
    ],
)
def test_data_that_no_process_can_use_are_refused(X: Floats, y: Floats, variances: Floats, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        GaussianProcessLikelihood(X, y, variances)
    with pytest.raises(ValueError, match=message):
        GaussianProcess(X, y, variances, Kernel(1.0, np.ones(X.shape[1])), 0.1)


def test_bad_parameters_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match="family is 'rbf'"):
        Kernel(1.0, [1.0], family="rbf")
    with pytest.raises(ValueError, match="length-scale is 0"):
        Kernel(1.0, [0.0])
    with pytest.raises(ValueError, match="inputs have 2 columns"):
        GaussianProcess(np.zeros((1, 2)), [0.0], [0.0], Kernel(1.0, [1.0]), 0.1)
    process = GaussianProcess(np.zeros((1, 2)), [0.0], [0.0], Kernel(1.0, [1.0, 1.0]), 0.1)
    with pytest.raises(ValueError, match="queries have 3 columns"):
        process.predict(np.zeros((5, 3)))
    with pytest.raises(ValueError, match="amplitude is"):
        HyperParameterConfig(amplitude=(1.0, 0.1))
    with pytest.raises(ValueError, match="population"):
        DifferentialEvolutionConfig(population=0)


def test_an_objective_that_raises_ends_the_search_with_its_error() -> None:
    def broken(_: Floats) -> float:
        raise RuntimeError("no value here")

    with pytest.raises(RuntimeError, match="no value here"):
        differential_evolution(broken, [[0.0, 1.0]])


def test_threads_that_share_a_likelihood_get_the_right_values() -> None:
    X, y, variances = data(100)
    likelihood = GaussianProcessLikelihood(X, y, variances)
    points = np.random.default_rng(0).uniform(-1, 0.5, (4, 4))
    wanted = [likelihood.evaluate(at) for at in points]
    found: list[set[float]] = [set() for _ in points]

    def ask(k: int) -> None:
        found[k] = {likelihood.evaluate(points[k]) for _ in range(100)}

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [{value} for value in wanted]


def test_the_estimator_keeps_scikit_learns_contract() -> None:
    from sklearn.utils.estimator_checks import check_estimator

    check_estimator(GaussianProcessRegressor(generations=1, polish=False))  # not a search of a minute


def test_the_estimator_fits_takes_known_noise_and_survives_pickling() -> None:
    X, y, variances = data(80)
    model = GaussianProcessRegressor(random_state=0).fit(X, y + 7, noise_variances=variances)
    assert model.score(X, y + 7) > 0.95
    again = pickle.loads(pickle.dumps(model))
    for ours, theirs_ in zip(model.predict(X, return_std=True), again.predict(X, return_std=True), strict=True):
        assert np.array_equal(ours, theirs_)
    assert model.predict([[50.0, 50.0]])[0] == pytest.approx((y + 7).mean())


def test_numbers_whose_squares_are_none_are_refused() -> None:
    for amplitude, lengthscale, said in (
        (1e200, 1.0, "amplitude"),
        (1e-320, 1.0, "amplitude"),
        (1.0, 1e-320, "length"),
    ):
        with pytest.raises(ValueError, match=said):
            Kernel(amplitude, [lengthscale])
    with pytest.raises(ValueError, match=r"targets must lie within .-1e150"):
        GaussianProcess(np.zeros((2, 1)), np.array([1.0, 1e300]), np.ones(2), Kernel(1.0, [1.0]), 0.1)
    with pytest.raises(ValueError, match="finite and rising"):
        differential_evolution(lambda x: 1.0, np.array([[-1e308, 1e308]]))


@pytest.mark.parametrize("answer", [None, "much", np.zeros(2)])
def test_an_objective_that_gives_no_number_is_refused(answer: object) -> None:
    with pytest.raises(ValueError, match="no number"):
        differential_evolution(lambda x: answer, np.array([[0.0, 1.0]]))  # type: ignore[arg-type,return-value]


def test_a_search_can_be_copied_and_sent_to_another_process() -> None:
    config = HyperParameterConfig(evolution=DifferentialEvolutionConfig(population=7, tolerance=0.5, seed=2**64 - 1))
    for other in (pickle.loads(pickle.dumps(config)), copy.deepcopy(config)):
        names = ("population", "generations", "recombination", "mutation_low", "mutation_high")
        for name in (*names, "tolerance", "absolute_tolerance", "seed"):
            assert getattr(other.evolution, name) == getattr(config.evolution, name)
