"""Models of destinations in a file, and the belief over destinations along a drive (Ch. 2)."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from goal_worlds import GOALS, drive_to, samples_of, tiny_model
from lfdcore.datasets import Goal, Goals
from lfdcore.datasets.tensor_file import read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.estimation import ActionKernel
from lfdcore.wheelchair.goals.model import KIND, VERSION, GoalFilter, GoalFilterConfig, GoalModel, prior_belief
from lfdcore.wheelchair.goals.samples import GoalSamples, goal_state

# -- oracle: the filter with moments written out ----------------------------------------------------------------------


def literal_moments(model: GoalModel, state: np.ndarray, mean: np.ndarray, covariance: np.ndarray) -> tuple:
    """m, G, C of the action for a goal ~ N(mean, covariance): the Gaussian integrals of Sec. 2.3 (ERRATA 1-4), sample
    by sample, over all samples."""
    x = goal_state(model.samples.pose, model.samples.twist, model.config.heading)
    g, y = model.goals.positions[model.samples.goal], model.samples.joystick
    kx, inverses, betas, lam = [], [], [], []
    for a, kernel in enumerate(model.kernels):
        near = np.exp(-(((x[:, None] - x) / kernel.state_lengthscales) ** 2).sum(-1) / 2)
        near *= np.exp(-(((g[:, None] - g) / kernel.goal_lengthscales) ** 2).sum(-1) / 2)
        inverses.append(np.linalg.inv(kernel.amplitude**2 * near + kernel.noise**2 * np.eye(len(x))))
        betas.append(inverses[a] @ y[:, a])
        kx.append(kernel.amplitude**2 * np.exp(-(((x - state) / kernel.state_lengthscales) ** 2).sum(-1) / 2))
        lam.append(np.diag(np.asarray(kernel.goal_lengthscales) ** 2))
    m, G, C = np.zeros(2), np.zeros((2, 2)), np.zeros((2, 2))
    for a in range(2):
        wide = covariance + lam[a]
        q = kx[a] * integral(g - mean, wide, lam[a])
        m[a] = betas[a] @ q
        C[:, a] = covariance @ np.linalg.solve(wide, (g - mean).T @ (betas[a] * q))
    for a in range(2):
        for b in range(2):
            Q = pair_expectation(g, mean, covariance, lam[a], lam[b]) * np.outer(kx[a], kx[b])
            G[a, b] = betas[a] @ Q @ betas[b] - m[a] * m[b]
            if a == b:
                kernel = model.kernels[a]
                G[a, a] += kernel.amplitude**2 - np.trace(inverses[a] @ Q) + kernel.noise**2
    return m, G, C


def integral(off: np.ndarray, wide: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """E of exp(-(g - g_i)' lam^-1 (g - g_i) / 2) over g, for off = g_i - mean (N, 2) and wide = covariance + lam."""
    d2 = (off * np.linalg.solve(wide, off.T).T).sum(1)
    return np.sqrt(np.linalg.det(lam) / np.linalg.det(wide)) * np.exp(-d2 / 2)


def pair_expectation(g, mean, covariance, lam_a, lam_b) -> np.ndarray:
    """(N, N) E of the product of the two Gaussians about g_i and g_j: one about their weighted mean, times how far they
    are apart."""
    ia, ib = np.linalg.inv(lam_a), np.linalg.inv(lam_b)
    both = np.linalg.inv(ia + ib)
    middle = (g[:, None] @ ia + g[None] @ ib) @ both
    apart = g[:, None] - g[None]
    d2 = (apart @ np.linalg.inv(lam_a + lam_b) * apart).sum(-1)
    n = len(g)
    return np.exp(-d2 / 2) * integral((middle - mean).reshape(-1, 2), covariance + both, both).reshape(n, n)


def no_wider(covariance: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """Cut where it is wider than the prior, in the coordinates in which both are diagonal."""
    widths, axes = scipy.linalg.eigh(covariance, prior)  # axes.T @ prior @ axes = I
    back = np.linalg.inv(axes)
    return back.T @ np.diag(np.minimum(widths, 1)) @ back


def test_the_belief_is_that_of_a_filter_written_out_in_numpy() -> None:
    model = tiny_model(process_noise=0.3)
    running, drive = GoalFilter(model, "full"), samples_of([drive_to(2, 50)])
    mean, prior = GOALS.positions.mean(axis=0), np.cov(GOALS.positions.T, bias=True) + 1e-6 * np.eye(2)
    covariance = prior
    for k in range(0, 100, 10):
        pose, twist, stick = drive.pose[k], drive.twist[k], drive.joystick[k]
        covariance = no_wider(covariance + 0.3 * np.eye(2), prior)
        m, G, C = literal_moments(model, goal_state(pose[None], twist[None], "embedded")[0], mean, covariance)
        gain = C @ np.linalg.inv(G)
        mean, covariance = mean + gain @ (stick - m), covariance - gain @ C.T
        belief = running.update(pose, twist, stick)
        np.testing.assert_allclose(belief.mean, mean, rtol=0, atol=1e-9)
        np.testing.assert_allclose(belief.covariance, covariance, rtol=0, atol=1e-9)


def test_likelihoods_are_the_softmax_of_half_the_squared_mahalanobis_distances() -> None:
    belief = updated(GoalFilter(tiny_model()))
    off = GOALS.positions - belief.mean
    weights = np.exp(-(off * np.linalg.solve(belief.covariance, off.T).T).sum(1) / 2)
    np.testing.assert_allclose(belief.likelihood, weights / weights.sum(), rtol=1e-9)
    assert belief.nearest == np.hypot(*off.T).argmin()


# -- laws of the filter -----------------------------------------------------------------------------------------------


def updated(running: GoalFilter, goal: int = 0, ticks: int = 40):
    """The belief after the first ticks of a drive."""
    drive = samples_of([drive_to(goal, 60 + goal)])
    for k in range(ticks):
        belief = running.update(drive.pose[k], drive.twist[k], drive.joystick[k])
    return belief


def same(a, b) -> bool:
    return np.array_equal(a.mean, b.mean) and np.array_equal(a.covariance, b.covariance)


def test_before_any_stick_the_belief_is_the_prior_of_the_goals() -> None:
    belief, (mean, covariance) = GoalFilter(tiny_model()).belief, prior_belief(GOALS.positions)
    np.testing.assert_allclose(belief.mean, mean)
    np.testing.assert_allclose(belief.covariance, covariance)
    assert belief.nearest == 1  # 'ahead' at (9, 0) is nearest to the mean (7, 0)


def test_likelihoods_sum_to_1_all_along_a_drive() -> None:
    running, drive = GoalFilter(tiny_model()), samples_of([drive_to(1, 70)])
    for k in range(len(drive)):
        likelihood = running.update(drive.pose[k], drive.twist[k], drive.joystick[k]).likelihood
        assert likelihood.shape == (3,)
        assert likelihood.sum() == pytest.approx(1, abs=1e-12)
        assert (likelihood >= 0).all()


def test_a_stick_at_rest_leaves_the_belief_and_one_displaced_does_not() -> None:
    running = GoalFilter(tiny_model(at_rest=0.05))
    before = updated(running)
    assert same(running.update([3, 0, 0], [0, 0], [0.03, -0.03]), before)
    assert not same(running.update([3, 0, 0], [0, 0], [0.04, -0.04]), before)


def test_with_at_rest_0_every_stick_counts() -> None:
    running = GoalFilter(tiny_model(at_rest=0.0))
    before = updated(running)
    assert not same(running.update([3, 0, 0], [0, 0], [0, 0]), before)


def test_a_drive_that_stands_still_is_believed_in_as_the_prior() -> None:
    running = GoalFilter(tiny_model())
    prior = running.belief
    for _ in range(50):
        standing = running.update([0, 0, 0], [0, 0], [0, 0])
    assert same(standing, prior)


def test_reset_goes_back_to_the_prior() -> None:
    running = GoalFilter(tiny_model())
    prior, first = running.belief, updated(running)
    running.reset()
    assert same(running.belief, prior)
    assert same(updated(running), first)


def test_beliefs_handed_out_do_not_change_with_later_updates() -> None:
    running = GoalFilter(tiny_model())
    first = updated(running, ticks=5)
    kept = first.mean.copy(), first.covariance.copy()
    updated(running, ticks=20)
    np.testing.assert_array_equal(first.mean, kept[0])
    np.testing.assert_array_equal(first.covariance, kept[1])


@pytest.mark.parametrize("projected", [True, False])
def test_a_subset_of_all_samples_gives_what_all_data_give(projected: bool) -> None:
    model = dataclasses.replace(tiny_model(projected=projected), subset=np.arange(40)[::-1].copy())
    sparse, full = (updated(GoalFilter(model, data)) for data in ("sparse", "full"))
    # what others of the subset span to 1e-10 is left out of a projection
    np.testing.assert_allclose(sparse.mean, full.mean, atol=1e-5)
    np.testing.assert_allclose(sparse.covariance, full.covariance, atol=1e-5)


def test_a_subset_that_projects_all_data_believes_otherwise_than_one_that_replaces_them() -> None:
    projecting, replacing = (updated(GoalFilter(tiny_model(projected=p))) for p in (True, False))
    assert np.abs(projecting.mean - replacing.mean).max() > 1e-3


def test_without_process_noise_the_belief_only_gets_surer_and_with_it_stays_wider() -> None:
    quiet, noisy = GoalFilter(tiny_model(process_noise=0.0)), GoalFilter(tiny_model(process_noise=0.5))
    drive, before = samples_of([drive_to(0, 61)]), np.inf
    for k in range(60):
        now = np.trace(quiet.update(drive.pose[k], drive.twist[k], drive.joystick[k]).covariance)
        wider = np.trace(noisy.update(drive.pose[k], drive.twist[k], drive.joystick[k]).covariance)
        assert now <= before + 1e-9
        assert wider >= now - 1e-9  # on some processors the first one is the same to the last bit
        before = now
    assert wider > now


def test_filters_may_share_an_action_model() -> None:
    model = tiny_model()
    shared = model.action_model()
    one, two = GoalFilter(model, action_model=shared), GoalFilter(model, action_model=shared)
    expected = updated(GoalFilter(model))
    updated(one, goal=2)
    assert same(updated(two), expected)


def test_duplicate_samples_and_no_noise_are_refused_in_full_and_projected_without_harm() -> None:
    model = tiny_model()
    twice = model.samples.where(np.repeat(np.arange(40), 2))
    silent = tuple(ActionKernel(k.amplitude, k.state_lengthscales, k.goal_lengthscales, 0.0) for k in model.kernels)
    noiseless = dataclasses.replace(model, samples=twice, kernels=silent)
    with pytest.raises(ValueError, match="not positive definite"):
        GoalFilter(noiseless, "full")
    for data in ("sparse", "full"):
        assert np.isfinite(updated(GoalFilter(dataclasses.replace(model, samples=twice), data)).mean).all()


def test_goals_in_a_row_have_a_prior_that_can_be_inverted() -> None:
    _, covariance = prior_belief(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))
    assert np.linalg.eigvalsh(covariance)[0] > 0


# -- border -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pose", "velocity", "stick", "said"),
    [
        ([0, np.nan, 0], [0, 0], [0.5, 0], "pose must be 3 finite numbers, is \\[0.0, nan, 0.0\\]"),
        ([0, 0], [0, 0], [0.5, 0], "pose must be 3"),
        ([0, 0, 0], [0, np.inf], [0.5, 0], "velocity must be 2 finite"),
        ([0, 0, 0], [0, 0], [np.nan, 0], "joystick must be 2 finite"),
        ([0, 0, 0], [0, 0], [1.01, 0], "joystick is \\[1.01, 0.0\\], must lie in \\[-1, 1\\]"),
    ],
)
def test_an_update_refuses_what_is_no_moment_of_a_drive_and_keeps_its_belief(pose, velocity, stick, said) -> None:
    running = GoalFilter(tiny_model())
    before = updated(running)
    with pytest.raises(ValueError, match=said):
        running.update(pose, velocity, stick)
    assert same(running.belief, before)


def test_a_pose_far_from_all_samples_says_nothing() -> None:
    running = GoalFilter(tiny_model(process_noise=0.0))
    before = running.belief
    after = running.update([1e6, -1e6, 0], [0, 0], [0.5, 0.5])
    np.testing.assert_allclose(after.mean, before.mean, atol=1e-9)


def test_one_goal_alone_is_refused() -> None:
    with pytest.raises(ValueError, match="must be at least 2: one alone leaves nothing to infer"):
        Goals((Goal("only", 1.0, 2.0),))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"process_noise": -1.0}, "process_noise is -1.0"),
        ({"at_rest": np.nan}, "at_rest is nan"),
        ({"heading": "north"}, "must be 'embedded' or 'raw'"),
        ({"projected": "no"}, "projected is 'no', must be true or false"),
    ],
)
def test_a_filter_refuses_a_config_that_is_none(change: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        GoalFilterConfig(**change)


def test_the_thesis_has_a_raw_heading_a_replacing_subset_no_process_noise_and_every_sample() -> None:
    thesis = GoalFilterConfig.thesis()
    assert (thesis.heading, thesis.projected, thesis.process_noise, thesis.at_rest) == ("raw", False, 0.0, 0.0)
    assert np.isfinite(updated(GoalFilter(tiny_model(**dataclasses.asdict(thesis)))).mean).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"goals": Goals(GOALS.goals[:2])}, "samples go to goals 0 to 2, there are 2"),
        ({"goals": Goals((*GOALS.goals, Goal("new", 0, 9)))}, "the network tells 3 goals apart, there are 4"),
        ({"subset": np.array([0, 40])}, "subset names samples 0 to 40, there are 40"),
        ({"subset": np.array([-1, 3])}, "subset names samples -1 to 3"),
        ({"subset": np.array([0.0, 1.0])}, "must be integers"),
        ({"subset": np.array([3, 3])}, "subset names 2 of 40 samples, must name at least one, and each once"),
        ({"subset": np.zeros(0, np.int64)}, "subset names 0 of 40 samples"),
        ({"config": GoalFilterConfig(heading="raw")}, r"a kernel has \(6, 2\) length-scales .* must have \(5, 2\)"),
    ],
)
def test_a_model_refuses_parts_that_do_not_fit(change: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        dataclasses.replace(tiny_model(), **change)


# -- file -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "goals.safetensors"
    tiny_model().save(path)
    return path


def test_a_model_comes_back_from_its_file_as_it_was(tmp_path: Path, saved: Path) -> None:
    model, back = tiny_model(), GoalModel.load(saved)
    assert back.goals == model.goals
    assert back.config == model.config
    assert back.metadata == model.metadata
    for name, array in model.samples.arrays().items():
        np.testing.assert_array_equal(back.samples.arrays()[name], array)
    assert same(updated(GoalFilter(back)), updated(GoalFilter(model)))
    back.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == saved.read_bytes()


def test_the_map_comes_back_as_a_path(tmp_path: Path) -> None:
    model = dataclasses.replace(tiny_model(), goals=Goals(GOALS.goals, Path("maps/home.yaml")))
    model.save(tmp_path / "with-map.safetensors")
    assert GoalModel.load(tmp_path / "with-map.safetensors").goals.map == Path("maps/home.yaml")


def test_a_network_may_take_headings_otherwise_than_the_filter(tmp_path: Path) -> None:
    mixed = dataclasses.replace(tiny_model(), network=tiny_model(heading="raw").network)
    mixed.save(tmp_path / "mixed.safetensors")
    assert GoalModel.load(tmp_path / "mixed.safetensors").network.heading == "raw"


@pytest.mark.parametrize("size", [0, 5, 400, -1])
def test_a_cut_file_is_refused(saved: Path, size: int) -> None:
    saved.write_bytes(saved.read_bytes()[:size])
    with pytest.raises(ModelError, match="is not a model file or is damaged"):
        GoalModel.load(saved)


def test_a_garbled_file_is_refused(saved: Path) -> None:
    data = bytearray(saved.read_bytes())
    data[-100] ^= 16
    saved.write_bytes(data)
    with pytest.raises(ModelError, match="is damaged"):
        GoalModel.load(saved)


def test_a_file_of_another_kind_or_version_is_refused(saved: Path) -> None:
    header, tensors = read_tensor_file(saved, KIND, VERSION)
    write_tensor_file(saved, KIND, VERSION + 1, header, tensors)
    with pytest.raises(ModelError, match=f"has format version {VERSION + 1}, this lfdcore reads version {VERSION}"):
        GoalModel.load(saved)
    write_tensor_file(saved, "lfdcore naive", VERSION, header, tensors)
    with pytest.raises(ModelError, match="does not hold a lfdcore goals model"):
        GoalModel.load(saved)


def without(name: str):
    return lambda header, tensors: (header.pop(name, None), tensors.pop(name, None))


def with_header(name: str, value):
    return lambda header, tensors: header.update({name: value})


def with_tensor(name: str, change):
    return lambda header, tensors: tensors.update({name: change(tensors[name])})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (with_tensor("samples.goal", lambda goal: goal + 1), "samples go to goals 1 to 3, there are 3"),
        (with_tensor("samples.goal", lambda goal: goal.astype(float)), "goal and drive must be integers"),
        (with_tensor("samples.pose", lambda pose: pose * np.nan), "pose must be finite"),
        (with_tensor("samples.stamp", lambda stamp: stamp[:-1]), "must be finite and"),
        (with_tensor("subset", lambda subset: subset + 1000), "subset names samples"),
        (with_tensor("subset", lambda subset: subset[None]), "must be integers"),
        (with_tensor("network.output", lambda output: output[:2]), "network tells 2 goals apart, there are 3"),
        (with_tensor("network.hidden", lambda hidden: hidden[:, 1:]), "hidden must be finite"),
        (with_header("goals", [{"name": "only", "x": 1.0, "y": 2.0}]), "at least 2"),
        (with_header("goals", 7), "does not hold a model of destinations"),
        (with_header("kernels", []), "does not hold a model of destinations"),
        (with_header("config", {"heading": "north"}), "heading is 'north'"),
        (with_header("config", {"speed": 1}), "does not hold a model of destinations"),
        (with_header("network_heading", "raw"), "centre must be finite"),
        (with_header("metadata", 3), "metadata"),
        (without("network_heading"), "network_heading"),
        (without("map"), "does not hold a model of destinations: 'map'"),
        (without("samples.twist"), "samples.twist"),
        (without("subset"), "subset"),
    ],
)
def test_a_file_whose_parts_do_not_fit_is_refused_with_what_is_wrong(saved: Path, change, said: str) -> None:
    header, tensors = read_tensor_file(saved, KIND, VERSION)
    change(header, tensors)
    write_tensor_file(saved, KIND, VERSION, header, tensors)
    with pytest.raises(ModelError, match=said):
        GoalModel.load(saved)


def test_the_summary_names_goals_and_counts_samples_drives_and_subset() -> None:
    said = tiny_model().summary()
    assert said["goals"] == {"left": "6, 4 m", "ahead": "9, 0 m", "right": "6, -4 m"}
    assert (said["samples"], said["drives"], said["subset"]) == (40, 6, 20)


def test_samples_name_goals_and_drives_by_integers() -> None:
    samples = tiny_model().samples
    with pytest.raises(ValueError, match="goal and drive must be integers, are float64 and int64"):
        GoalSamples(**{**samples.arrays(), "goal": samples.goal.astype(float)})
