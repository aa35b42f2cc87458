"""CollaborationModel: the same answers after saving, at once and sample by sample; what it cannot use."""

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.datasets.tensor_file import read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.humanoid.collaboration import KIND, VERSION, CollaborationConfig, CollaborationModel
from lfdcore.primitives import Dmp, InteractionPrimitiveConfig
from lifts import DURATION, PARTNER, SAMPLES, lift, lifts

CONFIG = CollaborationConfig(steps=80)
MODEL = CollaborationModel.fit(lifts(), CONFIG)
PLAIN = CollaborationModel.fit(lifts(), dataclasses.replace(CONFIG, environment=False))
NEW = lift(99)


def hidden(one: InteractionRecording, rows: slice, columns: slice = slice(None)) -> InteractionRecording:
    partner = one.partner.copy()
    partner[rows, columns] = np.nan
    return dataclasses.replace(one, partner=partner)


def test_what_a_collaboration_sets_reaches_the_core_and_its_defaults_are_the_core_s() -> None:
    config = CollaborationConfig(
        basis_functions=7,
        observe="forcing",
        phase="warped",
        noise=0.5,
        environment_noise=0.02,
        printed_environment_weights=True,
    )
    ours = config.primitive()
    assert (ours.observe, ours.noise, ours.environment_noise) == ("forcing", 0.5, 0.02)
    assert ours.printed_environment_weights and ours.dmp.basis_functions == 7
    default, core = CollaborationConfig(), InteractionPrimitiveConfig()
    for name in ("observe", "noise", "environment_noise", "printed_environment_weights"):
        assert getattr(default, name) == getattr(core, name)


# -- oracles --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "config", [CONFIG, CollaborationConfig.thesis(), dataclasses.replace(CONFIG, environment=False)]
)
def test_a_saved_model_gives_the_same_answers_and_the_same_bytes(tmp_path: Path, config: CollaborationConfig) -> None:
    model = CollaborationModel.fit(lifts(), config)
    model.save(tmp_path / "a.safetensors")
    again = CollaborationModel.load(tmp_path / "a.safetensors")
    again.save(tmp_path / "b.safetensors")
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert again.summary() == model.summary()
    for partial in (None, NEW.partial(share=0.0), NEW.partial(share=0.4), NEW):
        for environment in (None, {"height": 0.8}):
            said, same = model.infer(partial, environment), again.infer(partial, environment)
            np.testing.assert_array_equal(said.robot_motion(), same.robot_motion())
            np.testing.assert_array_equal(said.robot_deviation(), same.robot_deviation())
            assert (said.share, said.duration) == (same.share, same.duration)


def test_nothing_seen_gives_the_mean_of_the_demonstrations() -> None:
    said = MODEL.infer()
    np.testing.assert_allclose(said.posterior.mean, MODEL.primitive.parameters.mean(axis=0), rtol=1e-9, atol=1e-9)
    even = [one.resample(CONFIG.steps) for one in lifts()]
    np.testing.assert_allclose(said.partner_motion(), np.mean([one.partner for one in even], axis=0), atol=0.01)
    learned = [MODEL.robot.learned(one.robot) for one in even]
    np.testing.assert_allclose(MODEL.robot.learned(said.robot_motion()), np.mean(learned, axis=0), atol=0.01)
    np.testing.assert_allclose(said.robot_deviation(), np.std(learned, axis=0), atol=0.01)
    assert (said.share, said.phase, said.duration) == (0.0, None, pytest.approx(DURATION))


def test_the_posterior_is_the_dense_gaussian_over_the_fitted_motions() -> None:
    """Joint Gaussian over all samples of all columns and e (5.7-5.9, 5.16), conditioned by inverting the covariance of
    what was seen: the first sample of the partner, and the standardised environment."""
    p, n = MODEL.primitive, len(PARTNER)
    N, M = p.starts.shape[1], p.config.dmp.basis_functions
    motions = []
    for theta, start in zip(p.parameters, p.starts, strict=True):
        rows = theta.reshape(N, M + 1)
        motions.append(Dmp(start, rows[:, M], rows[:, :M], p.config.dmp).rollout(CONFIG.steps).positions)
    X = np.array(motions).reshape(len(motions), -1)
    e = p.environment[:, 0]
    joint = np.column_stack([X, (e - e.mean()) / e.std()])
    mu, C = joint.mean(axis=0), np.cov(joint.T, bias=True)
    seen = [*range(n), X.shape[1]]
    R = np.diag([p.config.noise] * n + [p.config.environment_noise])
    partial = NEW.partial(share=0)
    values = np.append(partial.partner[0], (0.9 - e.mean()) / e.std())
    gain = C[:, seen] @ np.linalg.inv(C[np.ix_(seen, seen)] + R)
    wanted = (mu + gain @ (values - mu[seen]))[:-1].reshape(CONFIG.steps, N)
    said = MODEL.infer(partial, {"height": 0.9}).posterior.trajectory(CONFIG.steps)
    np.testing.assert_allclose(said.mean, wanted, atol=1e-7)
    variances = np.diag(C - gain @ C[seen])[:-1].reshape(CONFIG.steps, N)
    np.testing.assert_allclose(np.diagonal(said.covariance, axis1=1, axis2=2), variances, atol=1e-9)


def test_a_follower_says_what_infer_says_of_the_same_samples() -> None:
    watched = hidden(hidden(NEW, slice(0, 2)), slice(10, 14), slice(0, 1))
    follower = MODEL.follow({"height": 0.8})
    buffer = np.zeros(2)
    for k, (stamp, sample) in enumerate(zip(watched.stamp, watched.partner, strict=True)):
        buffer[:] = sample  # the tracker's own array, written again and again
        follower.observe(stamp, buffer)
        if k % 7 == 0:
            seen = watched.first(k + 1) if k >= 2 else None
            wanted, said = MODEL.infer(seen, {"height": 0.8}), follower.infer()
            np.testing.assert_array_equal(said.robot_motion(), wanted.robot_motion())
            assert (said.share, said.duration) == (wanted.share, wanted.duration)


# -- laws -----------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=25)
@given(st.floats(0, 1), st.floats(0.3, 1.5), st.integers(0, 2**20))
def test_seeing_more_never_makes_the_posterior_wider(share: float, height: float, seed: int) -> None:
    partial = lift(seed).partial(share=share)
    prior, scene = MODEL.infer(), MODEL.infer(None, {"height": height})
    both = MODEL.infer(partial, {"height": height})
    assert both.posterior.trace <= scene.posterior.trace * (1 + 1e-9) <= prior.posterior.trace * (1 + 2e-9)
    assert np.isfinite(both.robot_motion()).all()
    assert 0 <= both.share <= 1
    np.testing.assert_allclose(np.linalg.norm(both.robot_motion()[:, 1:], axis=1), 1, atol=1e-9)


@settings(deadline=None, max_examples=20)
@given(st.floats(0.5, 2.0), st.floats(0.2, 0.9), st.floats(-1e5, 1e5))
def test_the_duration_follows_the_partners_tempo_whenever_the_clock_began(slow: float, share: float, at: float) -> None:
    mean = MODEL.infer().partner_motion()
    stamps = at + np.linspace(0, slow * DURATION, len(mean))
    watched = InteractionRecording(stamps, mean, np.zeros((len(mean), 0)), PARTNER).partial(share=share)
    said = MODEL.infer(watched)
    assert said.share == pytest.approx(share, abs=0.06)
    assert said.duration == pytest.approx(slow * DURATION, rel=0.15)


def test_the_order_in_which_columns_are_seen_does_not_matter() -> None:
    partial = NEW.partial(share=0.5)
    turned = dataclasses.replace(partial, partner=partial.partner[:, ::-1], partner_names=PARTNER[::-1])
    np.testing.assert_array_equal(MODEL.infer(partial).robot_motion(), MODEL.infer(turned).robot_motion())


def test_an_unseen_column_is_the_same_as_a_missing_one() -> None:
    partial = NEW.partial(share=0.5)
    few = dataclasses.replace(partial, partner=partial.partner[:, 1:], partner_names=PARTNER[1:])
    np.testing.assert_array_equal(
        MODEL.infer(partial.seeing(PARTNER[1:])).robot_motion(), MODEL.infer(few).robot_motion()
    )


@pytest.mark.parametrize("samples", [7, 31, 240])
def test_a_demonstrations_sign_of_the_quaternion_does_not_matter(samples: int) -> None:
    """q and -q are the same rotation, also between two samples (ERRATA 44)."""
    ordinary = [lift(seed, samples) for seed in range(5)]
    flipped = []
    for k, one in enumerate(ordinary):
        robot = one.robot.copy()
        robot[:, 1:] *= np.where(np.random.default_rng(k).random(samples) < 0.5, -1, 1)[:, None]
        flipped.append(dataclasses.replace(one, robot=robot))
    plain, turned = (CollaborationModel.fit(some, CONFIG).infer(NEW.partial(share=0.5)) for some in (ordinary, flipped))
    np.testing.assert_allclose(plain.robot_motion(), turned.robot_motion(), atol=1e-9)


# -- claims ---------------------------------------------------------------------------------------------------------


def test_the_environment_adapts_the_robot_before_anything_is_seen() -> None:
    """Sec. 5.5: suitable motions "even with no observation data present"; an interaction primitive alone cannot."""
    for height in (0.5, 0.7, 1.0):
        end = MODEL.infer(None, {"height": height}).robot_motion()[-1]
        assert end[0] == pytest.approx(1 - height, abs=0.02)
        assert 2 * np.arctan2(end[3], end[4]) == pytest.approx(height, abs=0.03)
        np.testing.assert_array_equal(
            PLAIN.infer(None, {"height": height}).robot_motion(), PLAIN.infer().robot_motion()
        )


def test_an_interaction_primitive_learns_the_height_from_the_partner() -> None:
    """Sec. 5.3: from the partner alone. Not more surely the more was seen: DTW against the mean motion (5.5) takes a
    small motion for an early one, so that EaIP stays the better to the end."""
    seeds = range(50, 60)
    errors = {
        (model, share): np.mean(
            [
                abs(
                    model.infer(lift(k).partial(share=share), lift(k).environment).robot_motion()[-1, 0]
                    - lift(k).robot[-1, 0]
                )
                for k in seeds
            ]
        )
        for model, share in itertools.product((PLAIN, MODEL), (0.0, 0.5, 1.0))
    }
    assert errors[PLAIN, 1.0] < errors[PLAIN, 0.5] < 0.7 * errors[PLAIN, 0.0]
    assert all(errors[MODEL, share] < errors[PLAIN, share] for share in (0.0, 0.5, 1.0))


def test_demonstrations_of_different_length_and_duration_teach_together() -> None:
    several = [lift(k, samples, duration) for k, (samples, duration) in enumerate([(30, 1.0), (60, 2.0), (333, 4.5)])]
    model = CollaborationModel.fit(several, CONFIG)
    assert model.duration == pytest.approx(2.5)
    assert model.infer(None, {"height": 0.7}).robot_motion()[-1, 0] == pytest.approx(0.3, abs=0.03)


# -- the border -----------------------------------------------------------------------------------------------------


def still(one: InteractionRecording) -> InteractionRecording:
    return dataclasses.replace(one, partner=np.zeros_like(one.partner))


def no_rotation(one: InteractionRecording) -> InteractionRecording:
    return dataclasses.replace(one, robot=np.zeros_like(one.robot))


def unseen(one: InteractionRecording) -> InteractionRecording:
    return hidden(one, slice(None), slice(0, 1))


def other_columns(one: InteractionRecording) -> InteractionRecording:
    return dataclasses.replace(one, partner_names=("foot.x", "foot.y"))


def no_robot(one: InteractionRecording) -> InteractionRecording:
    return dataclasses.replace(one, robot=np.zeros((len(one), 0)), robot_names=())


@pytest.mark.parametrize(
    ("demonstrations", "said"),
    [
        ([], "must be 2 demonstrations or more, got 0"),
        (lifts(1), "must be 2 demonstrations or more, got 1"),
        ([*lifts(2), no_robot(lift(2))], "lift 2 has no robot's motion"),
        ([*lifts(2), other_columns(lift(2))], "lift 2 has the partner_names foot.x, foot.y, must be hand.x, hand.y"),
        ([*lifts(2), dataclasses.replace(lift(2), frame="camera")], "lift 2 is in frame camera, must be in base"),
        (
            [*lifts(2), dataclasses.replace(lift(2), environment={"width": 1.0})],
            r"lift 2 has the environment \['width'\]",
        ),
        ([lift(k, height=0.7) for k in range(3)], "height is 0.7 in all demonstrations, must vary.*--plain"),
        ([*lifts(2), unseen(lift(2))], "lift 2: hand.x was never seen"),
        ([*lifts(2), hidden(lift(2), slice(10, 50))], "lift 2: hand.x was not seen for 1.39 s"),
        ([*lifts(2), lift(2, samples=1)], "lift 2: resampling needs at least 2 samples"),
        ([still(one) for one in lifts(3)], "never leaves its start"),
        ([no_rotation(one) for one in lifts(3)], r"quaternions\[0\] has length 0"),
    ],
)
def test_demonstrations_that_do_not_fit_together_are_refused_by_name(
    demonstrations: list[InteractionRecording], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        CollaborationModel.fit(demonstrations, CONFIG)


def test_gaps_that_are_short_are_bridged() -> None:
    gappy = [hidden(one, slice(20, 30)) for one in lifts()]
    said = CollaborationModel.fit(gappy, CONFIG).infer(NEW.partial(share=0.5)).robot_motion()
    np.testing.assert_allclose(said, MODEL.infer(NEW.partial(share=0.5)).robot_motion(), atol=0.05)


@pytest.mark.parametrize(
    ("watched", "environment", "said"),
    [
        (hidden(NEW, slice(None)), None, "lift 99: no sample of the partner was seen"),
        (InteractionRecording(np.arange(3.0), np.zeros((3, 0)), np.zeros((3, 0)), ()), None, "no sample"),
        (other_columns(NEW), None, "column foot.x was not learned from: hand.x, hand.y"),
        (NEW, {"width": 1.0}, "the environment lacks height: it has width"),
        (NEW, {}, "the environment lacks height: it has nothing"),
        (NEW, {"height": float("nan")}, "height.* must be finite"),
        (NEW, {"height": "1"}, "must be a number"),
        (NEW, [0.7], "must be names and numbers"),
    ],
)
def test_what_cannot_be_inferred_from_is_refused(watched: InteractionRecording, environment: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        MODEL.infer(watched, environment)
    if said.startswith("the env"):  # before anything was observed
        with pytest.raises(ValueError, match=said):
            MODEL.follow(environment)


def test_an_observation_longer_than_any_demonstration_ends_with_the_motion() -> None:
    """A partner who came to the end and stays there, twice as long as any demonstration lasted."""
    stamps = np.arange(3 * SAMPLES) * NEW.stamp[1]
    stays = np.vstack([NEW.partner, np.repeat(NEW.partner[-1:], 2 * SAMPLES, axis=0)])
    said = MODEL.infer(InteractionRecording(stamps, stays, np.zeros((len(stays), 0)), PARTNER), {"height": 0.8})
    assert said.share > 0.95
    assert np.isfinite(said.robot_motion()).all()
    if (1 - said.share) * said.duration < 0.1:
        with pytest.raises(ValueError, match="come to the end of the motion"):
            said.motion_from_now(0.1)


@pytest.mark.parametrize("where", [1e5, -1e6])
def test_a_partner_far_from_all_that_was_seen_gives_a_finite_motion(where: float) -> None:
    far = dataclasses.replace(NEW, partner=np.full_like(NEW.partner, where))
    assert np.isfinite(MODEL.infer(far, {"height": 0.8}).robot_motion()).all()


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan, np.inf, 1e-12, 10.0])
def test_a_period_without_sense_is_refused(period: float) -> None:
    with pytest.raises(ValueError, match="period"):
        MODEL.infer(NEW.partial(share=0.5)).motion_from_now(period)


def test_the_motion_from_now_begins_where_the_robot_is_and_ends_where_the_whole_ends() -> None:
    said = MODEL.infer(NEW.partial(share=0.5), NEW.environment)
    here = np.array([0.9, 0, 0, np.sin(0.3), np.cos(0.3)])
    times, motion = said.motion_from_now(0.01, here)
    np.testing.assert_allclose(motion[0], here, atol=1e-9)
    np.testing.assert_allclose(motion[-1], said.robot_motion()[-1], atol=0.03)
    assert times[-1] == pytest.approx((1 - said.share) * said.duration)
    assert (np.diff(times) <= 0.01 + 1e-12).all()
    for bad, reason in (([0.9, 0], "shape"), ([0.9, 0, 0, 0, 0], "length"), ([np.nan, 0, 0, 0, 1], "finite")):
        with pytest.raises(ValueError, match=reason):
            said.motion_from_now(0.01, bad)


def test_a_follower_refuses_a_bad_sample_and_goes_on() -> None:
    follower = MODEL.follow()
    np.testing.assert_array_equal(follower.infer().robot_motion(), MODEL.infer().robot_motion())
    follower.observe(0.0, [0.0, 0.0])
    for stamp, sample, said in (
        (0.0, [0, 0], "must be later"),
        (np.nan, [0, 0], "stamp"),
        (1.0, [0], r"shape \(1,\), must be \(2,\): hand.x, hand.y"),
        (1.0, [[0, 0]], r"shape \(1, 2\)"),
        (1.0, [0, np.inf], "holds inf"),
    ):
        with pytest.raises(ValueError, match=said):
            follower.observe(stamp, sample)
    follower.observe(0.1, [np.nan, 0.1])
    assert np.isfinite(follower.infer().robot_motion()).all()


@pytest.mark.parametrize(
    "change",
    [{"observe": "x"}, {"observe": None}, {"steps": 5}, {"steps": 50.5}, {"steps": "9"}, {"noise": -1},
     {"noise": np.nan}, {"environment_noise": 0}, {"basis_functions": 1}, {"basis_functions": 10**9}],
)  # fmt: skip
def test_a_config_without_sense_is_refused(change: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        CollaborationConfig(**change)


# -- files that nobody meant ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, dict]:
    path = tmp_path_factory.mktemp("model") / "model.safetensors"
    MODEL.save(path)
    header, tensors = read_tensor_file(path, KIND, VERSION)
    kept = {key: value for key, value in header.items() if key not in ("digest", "format", "version")}
    return kept, {key: np.array(value) for key, value in tensors.items()}


def refused(tmp_path: Path, header: dict, tensors: dict) -> str:
    write_tensor_file(tmp_path / "x.safetensors", KIND, VERSION, header, tensors)
    with pytest.raises(ModelError, match=r"x\.safetensors does not hold a model of a collaboration") as broken:
        CollaborationModel.load(tmp_path / "x.safetensors")
    assert "\n" not in str(broken.value)
    return str(broken.value)


def test_every_part_of_the_file_is_needed(tmp_path: Path, saved: tuple[dict, dict]) -> None:
    header, tensors = saved
    write_tensor_file(tmp_path / "whole.safetensors", KIND, VERSION, header, tensors)
    assert CollaborationModel.load(tmp_path / "whole.safetensors").partner_names == PARTNER
    for key in header:
        refused(tmp_path, {k: v for k, v in header.items() if k != key}, tensors)
    for key in tensors:
        refused(tmp_path, header, {k: v for k, v in tensors.items() if k != key})


@pytest.mark.parametrize("key", ["parameters", "starts", "reference", "environment"])
def test_arrays_of_other_shape_or_values_are_refused(tmp_path: Path, saved: tuple[dict, dict], key: str) -> None:
    header, tensors = saved
    whole = tensors[key]
    for fill in (np.nan, np.inf, 1e300):
        bad = whole.copy()
        bad.flat[-1] = fill
        refused(tmp_path, header, {**tensors, key: bad})
    for bad in (whole[:1], whole[:0], whole[:, :-1], np.hstack([whole, whole]), whole[:, 0].copy(), whole[None]):
        refused(tmp_path, header, {**tensors, key: bad})


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("partner_names", [[], ["hand.x"], ["hand.x"] * 2, "ab", ["hand.x", 5], [["a"], ["b"]], ["a", ""], None, 5]),
        ("robot_names", [[], "abcde", ["g.x"], ["g.x", "g.qx", "g.qy", "g.qz"], [1, 2, 3, 4, 5], ["a"] * 5, None]),
        ("references", [[], [[0, 0, 0, 1]] * 2, [[0, 0, 0, 0]], [[0, 0, 0, 2]], [[1e300, 0, 0, 1]], ["abcd"],
                        [[0, 0, 1]], [5], None, {"a": 1}, [[0, 0, 0, None]]]),
        ("environment_names", [[], ["a", "b"], "h", [5], None, [""]]),
        ("duration", [0, -1, None, [1], {}]),
        ("noise", [0, -1, None, [1]]),
        ("metadata", [None, 5, [1], "ab"]),
    ],
)  # fmt: skip
def test_headers_of_other_types_are_refused(tmp_path: Path, saved: tuple[dict, dict], key: str, values: list) -> None:
    header, tensors = saved
    for value in values:
        refused(tmp_path, {**header, key: value}, tensors)


@pytest.mark.parametrize(
    "change",
    [{"steps": 10**6}, {"steps": "5"}, {"steps": 99.5}, {"basis_functions": 21}, {"basis_functions": 10**9},
     {"observe": "x"}, {"observe": 5}, {"bogus": 1}, {"environment_noise": "a"}, {"printed_environment_weights": "a"}],
)  # fmt: skip
def test_configs_of_files_are_checked(tmp_path: Path, saved: tuple[dict, dict], change: dict) -> None:
    header, tensors = saved
    refused(tmp_path, {**header, "config": {**header["config"], **change}}, tensors)


def test_a_file_with_a_flipped_bit_or_cut_short_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    MODEL.save(path)
    whole = path.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole[:-1], b"", whole[:-9] + bytes([whole[-9] ^ 16]) + whole[-8:]):
        path.write_bytes(damaged)
        with pytest.raises(ModelError):
            CollaborationModel.load(path)


def test_the_range_of_what_was_demonstrated_is_known() -> None:
    low, high = MODEL.demonstrated("height")
    assert low < 0.8 < high
    assert f"height {low:g} to {high:g}" in MODEL.summary()["environment"]
    with pytest.raises(ValueError, match="width was not learned from: height"):
        MODEL.demonstrated("width")
