"""Learning destinations from drives: kernels, subset, network (Ch. 2)."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from goal_worlds import GOALS, drive_to, drives, learned, samples_of
from lfdcore.study.goals.evaluation import quarter_of_drive
from lfdcore.training.goals import (
    GoalLearningConfig,
    LongestScales,
    action_inputs,
    data_hash,
    fit_action_kernels,
    learn_goals,
    log_likelihood,
    moving,
)
from lfdcore.training.parts.goal_net import GoalNetConfig
from lfdcore.training.parts.gp_hyperparameters import HyperParameterConfig, search_bounds
from lfdcore.wheelchair.goals.model import GoalFilterConfig, GoalModel
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import track_beliefs

QUICK = GoalLearningConfig(
    network=GoalNetConfig(epochs=3), search_samples=40, searches=1, generations=3, subset=30, candidates=10
)


@pytest.mark.parametrize("data", ["sparse", "full"])
def test_late_in_unseen_drives_filter_and_network_name_the_goal(data: str) -> None:
    model, unseen = learned(), samples_of(drives(2, first_seed=100))
    late = quarter_of_drive(unseen) >= 2
    said = track_beliefs(model, unseen, model.action_model(data)).nearest
    network = model.network.predict(unseen.pose, unseen.joystick).argmax(axis=1)
    assert (said == unseen.goal)[late].mean() > 0.9
    assert (network == unseen.goal)[late].mean() > 0.9


def test_on_the_common_first_metres_nobody_can_tell() -> None:
    model, unseen = learned(), samples_of(drives(2, first_seed=100))
    said = track_beliefs(model, unseen, model.action_model()).nearest
    early = unseen.pose[:, 0] < 1.5
    assert (said == unseen.goal)[early].mean() < 0.7


def saved(model: GoalModel, path: Path) -> bytes:
    model.save(path)
    return path.read_bytes()


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(tmp_path: Path) -> None:
    logs = drives(1)
    first, second = (learn_goals(logs, GOALS, QUICK) for _ in range(2))
    assert saved(first, tmp_path / "a") == saved(second, tmp_path / "b")
    other = learn_goals(logs, GOALS, dataclasses.replace(QUICK, seed=2))
    assert saved(other, tmp_path / "c") != saved(first, tmp_path / "a")


def test_a_subset_larger_than_the_data_is_all_of_them() -> None:
    model = learn_goals(drives(1), GOALS, dataclasses.replace(QUICK, subset=10_000))
    assert sorted(model.subset) == list(range(len(model.samples)))


def test_what_was_learned_from_is_recorded() -> None:
    logs = drives(1)
    reported: list[tuple[str, int, int]] = []
    model = learn_goals(logs, GOALS, QUICK, lambda *args: reported.append(args))
    assert model.metadata["logs"] == [log.name for log in logs]
    assert model.metadata["data_sha256"] == data_hash(model.samples)
    assert {stage for stage, _, _ in reported} == {"network", "kernels", "subset"}
    for stage in ("network", "kernels", "subset"):
        _, done, total = [one for one in reported if one[0] == stage][-1]
        assert done == total


def test_the_hash_changes_with_any_sample() -> None:
    samples = samples_of(drives(1))
    changed = dataclasses.replace(samples, twist=samples.twist + np.eye(len(samples), 2) * 1e-12)
    assert data_hash(changed) != data_hash(samples)


def test_kernels_stay_within_the_ends_of_their_search_and_one_heading_has_one_length_scale() -> None:
    samples, longest = samples_of(drives(1)), LongestScales(position=1.5, angular=0.7)
    for heading, states in (("embedded", 6), ("raw", 5)):
        config = dataclasses.replace(QUICK, filter=GoalFilterConfig(heading=heading), longest=longest)
        for kernel in fit_action_kernels(samples, GOALS, config):
            sizes = [*kernel.state_lengthscales, *kernel.goal_lengthscales]
            assert len(kernel.state_lengthscales) == states
            assert (np.array(sizes) <= np.array(longest.of(heading)) * (1 + 1e-9)).all()


def test_of_several_searches_the_likelier_one_is_kept() -> None:
    samples = samples_of(drives(1))
    best = []
    for searches in (1, 3):
        config = dataclasses.replace(QUICK, searches=searches)
        kernels = fit_action_kernels(samples, GOALS, config)
        drawn = np.sort(np.random.default_rng(1).permutation(len(samples))[:40])
        inputs, sticks = action_inputs(samples.where(drawn), GOALS, config)
        best.append([log_likelihood(inputs, sticks[:, a], kernels[a]) for a in (0, 1)])
    assert (np.array(best[1]) >= np.array(best[0]) - 1e-6).all()


def test_the_full_likelihood_is_that_of_a_gaussian_with_the_kernel_s_covariance() -> None:
    samples = samples_of(drives(1)).where(np.arange(0, 300, 10))
    kernel = fit_action_kernels(samples, GOALS, QUICK)[0]
    inputs, sticks = action_inputs(samples, GOALS, QUICK)
    sizes = np.array([*kernel.state_lengthscales, *kernel.goal_lengthscales])
    K = kernel.amplitude**2 * np.exp(-(((inputs[:, None] - inputs) / sizes) ** 2).sum(-1) / 2)
    K += kernel.noise**2 * np.eye(len(inputs))
    y = sticks[:, 0]
    expected = -(y @ np.linalg.solve(K, y) + np.linalg.slogdet(K)[1] + len(y) * np.log(2 * np.pi)) / 2
    assert log_likelihood(inputs, y, kernel) == pytest.approx(expected, rel=1e-9)


def test_the_preset_thesis_learns_and_keeps_every_sample() -> None:
    logs = drives(1)
    thesis = GoalLearningConfig.thesis()
    config = dataclasses.replace(QUICK, filter=thesis.filter, network=dataclasses.replace(thesis.network, epochs=2))
    model = learn_goals(logs, GOALS, config)
    assert len(model.samples) == sum(len(log.odometry_stamp) for log in logs)
    assert model.network.heading == "raw"


# -- border -----------------------------------------------------------------------------------------------------------


def test_a_goal_to_which_no_drive_goes_is_refused() -> None:
    with pytest.raises(ValueError, match="no drive goes to goal 2 of 3"):
        learn_goals([drive_to(0, 1), drive_to(2, 1)], GOALS, QUICK)


def test_no_drive_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="no drive to learn destinations from"):
        learn_goals([], GOALS, QUICK)


def at_rest(samples: GoalSamples) -> GoalSamples:
    return dataclasses.replace(samples, joystick=np.zeros((len(samples), 2)))


def test_sticks_that_all_rest_are_refused_and_single_ones_left_out() -> None:
    samples = samples_of(drives(1))
    with pytest.raises(ValueError, match=r"no stick is displaced by 0.05 or more: nothing to learn from"):
        moving(at_rest(samples), 0.05)
    samples.joystick[10:20] = 0.01
    assert len(moving(samples, 0.05)) == len(samples) - 10
    assert len(moving(samples, 0.0)) == len(samples)


def test_a_drive_that_stands_still_is_as_if_it_were_not_there() -> None:
    logs = drives(1)
    still = dataclasses.replace(logs[0], joystick=np.zeros_like(logs[0].joystick))
    with pytest.raises(ValueError, match="no drive goes to goal 1 of 3"):
        learn_goals([still, *logs[1:]], GOALS, QUICK)
    assert len(learn_goals([*logs, still], GOALS, QUICK).samples) == len(samples_of(logs))


def test_duplicate_drives_can_be_learned_from() -> None:
    logs = drives(1)
    model = learn_goals([*logs, *logs], GOALS, QUICK)
    assert np.isfinite(track_beliefs(model, samples_of(logs[:1]), model.action_model()).mean).all()


def test_three_samples_are_enough_to_learn_something_that_can_be_asked() -> None:
    names = ("odometry_stamp", "pose", "twist", "joystick_stamp", "joystick")
    logs = [dataclasses.replace(log, **{name: getattr(log, name)[30:31] for name in names}) for log in drives(1)]
    model = learn_goals(logs, GOALS, QUICK)
    assert len(model.samples) == 3
    assert np.isfinite(track_beliefs(model, model.samples, model.action_model()).mean).all()


@pytest.mark.parametrize("count", [1, 801])
def test_search_samples_outside_2_to_800_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match=f"search_samples is {count}, must be 2..800"):
        GoalLearningConfig(search_samples=count)


@pytest.mark.parametrize("name", ["searches", "generations", "subset", "candidates"])
def test_counts_below_1_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is 0, must be at least 1"):
        GoalLearningConfig(**{name: 0})


def test_more_search_samples_than_data_are_all_data() -> None:
    samples = samples_of(drives(1)).where(np.arange(50))
    a, b = (fit_action_kernels(samples, GOALS, dataclasses.replace(QUICK, search_samples=n)) for n in (50, 800))
    assert a[0].noise == b[0].noise


def test_ends_of_the_search_that_do_not_fit_the_dimensions_are_refused() -> None:
    config = HyperParameterConfig(longest=(1.0, 2.0, 3.0))
    with pytest.raises(ValueError, match="longest has 3 length-scales for 2 dimensions"):
        search_bounds(np.zeros((4, 2)), np.ones(4), config)
    with pytest.raises(ValueError, match=r"longest is .* must be finite and > 0"):
        HyperParameterConfig(longest=(1.0, -2.0))


def test_ends_of_the_search_hold_in_the_data_s_own_units_and_leave_a_range_below_them() -> None:
    inputs = np.array([[0.0, 0.0], [100.0, 0.001]])
    bounds = np.exp(
        search_bounds(inputs, np.ones(2), HyperParameterConfig(lengthscale=(0.01, 1.0), longest=(0.5, 2.0)))
    )
    np.testing.assert_allclose(bounds[1], [0.05, 0.5])  # a hundredth of 100 would lie above the end
    np.testing.assert_allclose(bounds[2], [1e-5, 2.0])
