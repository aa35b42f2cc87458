"""The joystick model: bins, fallback, calibration, file, adaptation to the driver."""

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.errors import ModelError
from lfdcore.estimation import Kernel
from lfdcore.wheelchair.heatmaps.joystick import (
    JoystickAdapter,
    JoystickAdapterConfig,
    JoystickBins,
    JoystickModel,
    JoystickModelConfig,
    JoystickPrior,
    bin_of,
)

Floats = NDArray[np.float64]
PRIOR = JoystickPrior(Kernel(0.2, [0.5, 0.5]), 0.01)
PRIORS = (PRIOR, PRIOR)
COORDINATE = st.floats(-1, 1)


def turned(stick: Floats, angle: float) -> Floats:
    """(N, 2) of (forward, left), turned to the left."""
    c, s = np.cos(angle), np.sin(angle)
    return stick @ np.array([[c, s], [-s, c]])


def drive(seed: int, samples: int, bias: float, noise: float = 0.1) -> tuple[Floats, Floats]:
    """Raw and wanted joystick of a driver who steers smoothly, mostly forward, `bias` [rad] too far to the left."""
    random = np.random.default_rng(seed)
    angle = np.zeros(samples)
    for i in range(1, samples):
        angle[i] = 0.95 * angle[i - 1] + 0.25 * random.normal()
    length = np.clip(random.normal(0.8, 0.1, samples), 0.2, 1)
    wanted = np.stack([length * np.cos(angle), length * np.sin(angle)], axis=1)
    raw = turned(wanted, bias) + random.normal(0, noise, wanted.shape)
    return np.clip(raw, -1, 1), wanted


@pytest.fixture(scope="module")
def trained() -> JoystickModel:
    return JoystickModel(JoystickBins.of_pairs(*drive(0, 8000, bias=0.0)), PRIORS)


def error(model: JoystickModel, raw: Floats, wanted: Floats) -> float:
    return float(np.sqrt(np.mean((model.predict_many(raw)[0] - wanted) ** 2)))


def test_bins_hold_what_a_loop_over_the_pairs_finds() -> None:
    raw, safe = drive(1, 500, bias=0.2)
    bins = JoystickBins.of_pairs(raw, safe)
    for index in range(100):
        i, j = divmod(index, 10)
        low = np.array([-1 + 0.2 * i, -1 + 0.2 * j])
        inside = np.all((raw >= low - 1e-12) & ((raw < low + 0.2 - 1e-12) | (low > 0.79)), axis=1)
        assert bins.count[index] == inside.sum()
        if inside.any():
            assert bins.raw[index] == pytest.approx(raw[inside].mean(0))
            assert bins.target[index] == pytest.approx((safe - raw)[inside].mean(0))
            assert bins.variance[index] == pytest.approx((safe - raw)[inside].var(0))


@pytest.mark.parametrize("noise", ["of_mean", "of_samples"])
def test_a_bins_noise_is_its_variance_taken_together_with_the_pooled_one(
    noise: Literal["of_mean", "of_samples"],
) -> None:
    config = JoystickModelConfig(noise=noise, pooled_samples=3.0)
    raw, safe = drive(1, 60, bias=0.2)
    bins = JoystickBins.of_pairs(raw, safe, config)
    offset, members = safe - raw, [bin_of(raw, 10) == b for b in range(100)]
    there = [m for m in members if m.any()]
    squares = np.sum([((offset[m] - offset[m].mean(0)) ** 2).sum(0) for m in there], axis=0)
    pooled = squares / sum(m.sum() - 1 for m in there)
    for axis in (0, 1):
        inputs, targets, variances = bins.training_data(axis, config)
        assert len(inputs) == len(there)
        for m, target, variance in zip(there, targets, variances, strict=True):
            shared = (m.sum() * offset[m, axis].var() + 3 * pooled[axis]) / (m.sum() + 3)
            assert target == pytest.approx(offset[m, axis].mean())
            assert variance == pytest.approx(shared / m.sum() if noise == "of_mean" else shared)


@given(
    st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE, COORDINATE), min_size=1, max_size=30), COORDINATE, COORDINATE
)
@settings(max_examples=200, deadline=None)
def test_any_pairs_give_finite_means_and_positive_variances_everywhere(
    pairs: list[tuple[float, float, float, float]], forward: float, left: float
) -> None:
    both = np.array(pairs)
    for config in (JoystickModelConfig(), JoystickModelConfig(prior="zero", noise="of_samples")):
        model = JoystickModel(JoystickBins.of_pairs(both[:, :2], both[:, 2:], config), PRIORS, config)
        estimate = model.predict((forward, left))
        assert np.isfinite(estimate.mean).all()
        assert min(estimate.variance) > 0


def test_far_from_all_data_the_driver_is_taken_at_their_word_with_the_priors_variance() -> None:
    raw, wanted = drive(0, 4000, bias=0.3)
    ahead = raw[:, 0] > 0.3
    model = JoystickModel(JoystickBins.of_pairs(raw[ahead], wanted[ahead]), PRIORS)
    estimate = model.predict((-1.0, -1.0))
    assert estimate.mean == pytest.approx((-1, -1), abs=0.03)
    assert min(estimate.variance) > 0.2**2
    assert max(model.predict((0.8, 0.0)).variance) < min(estimate.variance)
    nothing = JoystickModel(JoystickBins.empty(JoystickModelConfig()), PRIORS)
    assert nothing.predict((0.3, -0.4)).mean == (0.3, -0.4)


def test_the_thesis_prior_falls_back_to_zero() -> None:
    config = JoystickModelConfig(prior="zero", noise="of_samples")
    model = JoystickModel(JoystickBins.of_pairs([[0.9, 0.9]], [[0.9, 0.9]], config), PRIORS, config)
    assert model.predict((-1.0, -1.0)).mean == pytest.approx((0, 0), abs=1e-3)
    assert model.predict((-1.0, -1.0)).variance == pytest.approx((0.04, 0.04), rel=1e-3)  # of f alone, C.4


def test_the_variance_is_that_of_the_wanted_input(trained: JoystickModel) -> None:
    raw, wanted = drive(77, 3000, bias=0.0)
    mean, variance = trained.predict_many(raw)
    score = (wanted - mean) ** 2 / variance
    assert np.all((score.mean(0) > 0.8) & (score.mean(0) < 1.25))
    assert np.mean(score < 1.96**2) == pytest.approx(0.95, abs=0.02)


def test_the_scatter_around_f_is_interpolated_between_the_bins_centres_and_constant_beyond() -> None:
    forward, left = np.meshgrid(np.arange(10), np.arange(10), indexing="ij")
    centre = np.stack([forward.ravel(), left.ravel()], axis=1) * 0.2 - 0.9
    many = np.full(100, 1e9)
    variance = np.stack([0.1 + 0.01 * forward.ravel(), 0.2 + 0.02 * left.ravel()], axis=1)
    model = JoystickModel(JoystickBins(many, centre, np.zeros((100, 2)), variance), PRIORS)
    for at in ((0.33, -0.58), (-0.9, 0.21), (0.11, 0.9), (1.0, -1.0)):
        step = np.clip((np.array(at) + 0.9) / 0.2, 0, 9)
        scatter = (0.1 + 0.01 * step[0] + PRIOR.noise**2, 0.2 + 0.02 * step[1] + PRIOR.noise**2)
        assert model.predict(at).variance == pytest.approx(scatter, abs=1e-3)


def test_learning_from_pairs_finds_a_bias_and_beats_the_raw_stick() -> None:
    pytest.importorskip("scipy")
    from lfdcore.training.parts.gp_hyperparameters import fit_joystick_model

    model = fit_joystick_model(*drive(2, 5000, bias=0.4))
    raw, wanted = drive(3, 1500, bias=0.4)
    assert error(model, raw, wanted) < 0.4 * float(np.sqrt(np.mean((raw - wanted) ** 2)))


@pytest.mark.parametrize("bad", [(np.nan, 0.0), (0.0, np.inf), (1.5, 0.0)])
def test_a_stick_that_is_none_is_refused(trained: JoystickModel, bad: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="within"):
        trained.predict(bad)
    with pytest.raises(ValueError, match="within"):
        JoystickBins.of_pairs([bad], [(0.0, 0.0)])
    adapter = JoystickAdapter(trained, JoystickAdapterConfig(every=1))
    with pytest.raises(ValueError, match="within"):
        adapter.add((0.0, 0.0), bad)
    assert adapter.model is trained


def test_no_pairs_unequal_pairs_and_bad_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="at least one pair"):
        JoystickBins.of_pairs(np.zeros((0, 2)), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="3 raw joystick samples but 2 safe"):
        JoystickBins.of_pairs(np.zeros((3, 2)), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="bins is 0"):
        JoystickModelConfig(bins=0)
    with pytest.raises(ValueError, match="memory"):
        JoystickAdapterConfig(memory=0.5)
    with pytest.raises(ValueError, match="bins for a model of 100"):
        JoystickModel(JoystickBins.empty(JoystickModelConfig(bins=5)), PRIORS)


def test_a_saved_model_answers_as_before_and_a_damaged_file_is_refused(tmp_path: Path, trained: JoystickModel) -> None:
    file = tmp_path / "driver.safetensors"
    trained.save(file)
    assert JoystickModel.load(file).predict((0.7, 0.2)) == trained.predict((0.7, 0.2))
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])
    with pytest.raises(ModelError):
        JoystickModel.load(file)
    tensors = trained.tensors()
    tensors["count"] = tensors["count"][:50]
    with pytest.raises(ModelError, match="count"):
        JoystickModel.of_tensors(trained.header(), tensors)


@pytest.mark.parametrize("bias", [0.3, -0.3, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_after_60_s_a_biased_driver_is_met_with_at_most_7_tenths_of_the_error(
    trained: JoystickModel, bias: float, seed: int
) -> None:
    adapter = JoystickAdapter(trained)
    for raw, followed in zip(*drive(10 + seed, 600, bias), strict=True):
        adapter.add(raw, followed)
    later = drive(50 + seed, 1000, bias)
    assert error(adapter.model, *later) <= 0.7 * error(trained, *later)


def test_a_driver_is_met_also_after_demonstrations_in_which_nothing_was_corrected() -> None:
    pytest.importorskip("scipy")
    from lfdcore.training.parts.gp_hyperparameters import fit_joystick_model

    wanted = drive(0, 3000, bias=0.0)[1]
    blank = fit_joystick_model(wanted, wanted)
    adapter = JoystickAdapter(blank)
    for raw, followed in zip(*drive(1, 600, bias=0.3), strict=True):
        adapter.add(raw, followed)
    later = drive(2, 1000, bias=0.3)
    assert error(adapter.model, *later) <= 0.7 * error(blank, *later)
    assert 0 < blank.predict((0.8, 0.0)).variance[0] < 0.2


@pytest.mark.parametrize("seed", range(5))
def test_after_60_s_an_unbiased_driver_is_met_with_at_most_1_05_of_the_error(trained: JoystickModel, seed: int) -> None:
    adapter = JoystickAdapter(trained)
    for raw, followed in zip(*drive(10 + seed, 600, bias=0.0), strict=True):
        adapter.add(raw, followed)
    later = drive(50 + seed, 1000, bias=0.0)
    assert error(adapter.model, *later) <= 1.05 * error(trained, *later)


def test_the_adapter_forgets_a_bias_that_is_gone(trained: JoystickModel) -> None:
    adapter = JoystickAdapter(trained, JoystickAdapterConfig(memory=300))
    later = drive(5, 1000, bias=0.0)
    errors = []
    for bias in (0.5, 0.0):
        for raw, followed in zip(*drive(4, 1500, bias), strict=True):
            adapter.add(raw, followed)
        errors.append(error(adapter.model, *later))
    assert errors[0] > 2 * error(trained, *later)
    assert errors[1] <= 1.05 * error(trained, *later)


def test_memory_is_bounded_and_the_processes_follow_every_tenth_pair(trained: JoystickModel) -> None:
    adapter = JoystickAdapter(trained, JoystickAdapterConfig(memory=50))
    models = [adapter.add((0.5, 0.1), (0.5, 0.0)) for _ in range(400)]
    assert len({id(model) for model in models}) == 41
    assert adapter.model.bins.count.max() <= 50 + 3
    assert all(len(process) <= 100 for process in adapter.model._processes if process is not None)


def test_bins_learned_in_two_parts_and_joined_are_those_learned_at_once() -> None:
    raw, safe = drive(8, 400, bias=0.2)
    joined = JoystickBins.of_pairs(raw[:150], safe[:150]).joined(JoystickBins.of_pairs(raw[150:], safe[150:]))
    whole = JoystickBins.of_pairs(raw, safe)
    for name, values in whole.tensors().items():
        assert joined.tensors()[name] == pytest.approx(values, abs=1e-12)


def test_one_pair_at_a_time_gives_the_statistics_of_all_at_once(trained: JoystickModel) -> None:
    raw, safe = drive(9, 300, bias=0.2)
    adapter = JoystickAdapter(
        JoystickModel(JoystickBins.empty(JoystickModelConfig()), PRIORS), JoystickAdapterConfig(memory=1e12)
    )
    for pair in zip(raw, safe, strict=True):
        adapter.add(*pair)
    for name, values in JoystickBins.of_pairs(raw, safe).tensors().items():
        assert adapter.model.bins.tensors()[name] == pytest.approx(values, abs=1e-6)


def test_relabelled_pairs_are_as_if_they_had_been_given_so(trained: JoystickModel) -> None:
    raw, _ = drive(5, 300, 0.0)
    once, anew = JoystickAdapter(trained), JoystickAdapter(trained)
    for x in raw:
        once.add(x, x)
        anew.add(x, np.clip(turned(x[None], 0.3)[0], -1, 1))
    anew.relabel(anew.own.raw)
    np.testing.assert_allclose(anew.own.target, once.own.target, atol=1e-12)
    assert not anew.own.target[anew.own.count == 0].any()
    for bad in (np.full((100, 2), np.nan), np.zeros((99, 2))):
        before = anew.own.target.copy()
        with pytest.raises(ValueError, match="wanted must be finite"):
            anew.relabel(bad)
        np.testing.assert_array_equal(anew.own.target, before)


def test_reset_and_resume_go_back_to_the_trained_model_and_to_the_driver(
    tmp_path: Path, trained: JoystickModel
) -> None:
    adapter, file = JoystickAdapter(trained), tmp_path / "driver.safetensors"
    for raw, followed in zip(*drive(6, 200, bias=0.5), strict=True):
        adapter.add(raw, followed)
    adapter.save(file)
    adapted = adapter.model.predict((0.7, 0.3))
    adapter.reset()
    assert adapter.model is trained
    adapter.resume(file)
    assert adapter.model.predict((0.7, 0.3)) == adapted != trained.predict((0.7, 0.3))


def test_a_file_of_another_configuration_kind_or_length_is_not_resumed(tmp_path: Path, trained: JoystickModel) -> None:
    adapter, file = JoystickAdapter(trained), tmp_path / "driver.safetensors"
    config = JoystickModelConfig(bins=5)
    JoystickAdapter(JoystickModel(JoystickBins.empty(config), PRIORS, config)).save(file)
    with pytest.raises(ModelError, match="another configuration"):
        adapter.resume(file)
    trained.save(file)
    with pytest.raises(ModelError, match="joystick adaptation"):
        adapter.resume(file)
    file.write_bytes(file.read_bytes()[:40])
    with pytest.raises(ModelError):
        adapter.resume(file)
    assert adapter.model is trained
