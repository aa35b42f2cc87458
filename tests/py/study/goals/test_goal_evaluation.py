"""How destinations that are named are judged: shares, kappa, times, NEES, baselines."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import accuracy_score, cohen_kappa_score, confusion_matrix

from goal_worlds import GOALS, drive_to, drives, samples_of, tiny_model
from lfdcore.study.goals.evaluation import (
    BASELINES,
    accuracy,
    agreement,
    along_heading,
    confidence_time,
    confusion,
    drives_of,
    nearest_neighbour,
    prior_only,
    quarter_of_drive,
)
from lfdcore.wheelchair.goals.model import GoalFilter
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import BeliefTrack, track_beliefs


def samples(goal: list[int], drive: list[int], stamp: list[float]) -> GoalSamples:
    n = len(goal)
    return GoalSamples(
        np.zeros((n, 3)), np.zeros((n, 2)), np.zeros((n, 2)), np.array(goal), np.array(drive), np.array(stamp, float)
    )


answers = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=2, max_size=60)

# -- oracle -----------------------------------------------------------------------------------------------------------


@settings(max_examples=60, derandomize=True)
@given(answers)
def test_kappa_confusion_and_agreement_are_scikit_learn_s(pairs: list[tuple[int, int]]) -> None:
    a, b = np.array(pairs).T
    same, kappa = agreement(a, b, 4)
    np.testing.assert_array_equal(confusion(a, b, 4), confusion_matrix(a, b, labels=range(4)))
    assert same == pytest.approx(accuracy_score(a, b))
    if len({*a.tolist(), *b.tolist()}) > 1:
        assert kappa == pytest.approx(cohen_kappa_score(a, b), abs=1e-12)
    else:
        assert kappa == 1.0  # one answer throughout, where scikit-learn has none


def test_the_likeliest_neighbour_is_the_one_that_a_search_through_all_finds() -> None:
    model, asked = tiny_model(), samples_of([drive_to(0, 31)])

    def inputs(s: GoalSamples) -> np.ndarray:
        yaw = s.pose[:, 2]
        return np.column_stack([s.pose[:, :2], np.cos(yaw), np.sin(yaw), s.joystick])

    model = dataclasses.replace(model, network=dataclasses.replace(model.network, scale=np.array([3, 2, 1, 1, 0.5, 1])))
    away = (inputs(asked)[:, None] - inputs(model.samples)) / model.network.scale
    expected = model.samples.goal[(away**2).sum(-1).argmin(axis=1)]
    np.testing.assert_array_equal(nearest_neighbour(model, asked), expected)


def test_beliefs_along_drives_are_those_of_a_filter_begun_anew_for_each() -> None:
    model, both = tiny_model(), samples_of([drive_to(0, 31), drive_to(2, 32)])
    together = track_beliefs(model, both, model.action_model())
    second = both.where(both.drive == 1)
    running = GoalFilter(model)
    for k in range(len(second)):
        belief = running.update(second.pose[k], second.twist[k], second.joystick[k])
    np.testing.assert_array_equal(together.mean[-1], belief.mean)
    np.testing.assert_array_equal(together.likelihood[-1], belief.likelihood)
    assert together.nearest[-1] == belief.nearest


# -- laws -------------------------------------------------------------------------------------------------------------


def test_beliefs_as_sure_as_they_may_be_have_a_nees_of_2_and_too_sure_ones_more() -> None:
    rng = np.random.default_rng(1)
    n, truth = 20_000, np.array([3.0, -1.0])
    root = rng.normal(size=(n, 2, 2))
    covariance = root @ root.transpose(0, 2, 1) + 0.1 * np.eye(2)
    off = (np.linalg.cholesky(covariance) @ rng.normal(size=(n, 2, 1)))[..., 0]
    track = BeliefTrack(truth + off, covariance, np.full((n, 2), 0.5), np.zeros(n, np.int64))
    errors = track.normalised_errors(np.tile(truth, (n, 1)))
    assert errors.mean() == pytest.approx(2, abs=0.06)  # 4 standard errors of chi-square with 2 degrees of freedom
    surer = dataclasses.replace(track, covariance=covariance / 4)
    np.testing.assert_allclose(surer.normalised_errors(np.tile(truth, (n, 1))), 4 * errors)


def test_methods_that_always_agree_do_so_beyond_chance() -> None:
    assert agreement(np.array([0, 1, 1, 2]), np.array([0, 1, 1, 2]), 3) == (1.0, 1.0)


def test_a_table_s_rows_count_true_goals_and_its_columns_answers() -> None:
    np.testing.assert_array_equal(confusion(np.array([0, 0, 1]), np.array([1, 1, 0]), 2), [[0, 2], [1, 0]])


def test_quarters_are_of_each_drive_s_own_duration() -> None:
    short, long = [0, 1, 2, 3, 4], [0, 10, 20, 30, 40]
    both = samples([0] * 10, [0] * 5 + [1] * 5, [*short, *long])
    np.testing.assert_array_equal(quarter_of_drive(both), [0, 1, 2, 3, 3] * 2)


def test_accuracy_counts_samples_overall_and_by_quarter_and_its_interval_is_over_drives() -> None:
    both = samples([0] * 8 + [1] * 8, [0] * 8 + [1] * 8, [*range(8), *range(8)])
    said = np.r_[np.zeros(8, int), np.zeros(8, int)]
    one = accuracy("always the first", said, both)
    assert (one.samples, one.drives, one.share, one.quarters) == (16, 2, 0.5, (0.5, 0.5, 0.5, 0.5))
    assert (one.low, one.high) == (0.0, 1.0)  # whole drives are right or wrong
    assert accuracy("late", np.where(both.stamp > 5, both.goal, 1 - both.goal), both).quarters == (0, 0, 0, 1)


def test_quarters_that_no_sample_lies_in_have_no_share() -> None:
    single = samples([0, 1], [0, 1], [0, 0])
    one = accuracy("single samples", np.array([0, 0]), single)
    assert one.share == 0.5
    assert one.quarters[0] == 0.5
    assert np.isnan(one.quarters[1:]).all()


# -- when sure --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("likelihood", "expected"),
    [
        ([0.1, 0.5, 0.95, 0.99], 2.0),
        ([0.95, 0.5, 0.95, 0.99], 2.0),  # sure, unsure, and sure for good
        ([0.1, 0.5, 0.95, 0.89], np.nan),
        ([0.9, 0.9, 0.9, 0.9], 0.0),
        ([0.1, 0.1, 0.1, 0.9], 3.0),
        ([0.95, np.nan, 0.95, 0.95], 2.0),
    ],
)
def test_the_time_of_confidence_is_when_it_stays(likelihood: list[float], expected: float) -> None:
    table = np.column_stack([np.zeros(4), likelihood])
    found = confidence_time(table, np.arange(4.0), goal=1)
    np.testing.assert_equal(found, expected)


# -- baselines --------------------------------------------------------------------------------------------------------


def test_the_prior_alone_always_names_the_goal_in_the_middle() -> None:
    model = tiny_model()
    assert set(prior_only(model, model.samples)) == {GOALS.index("ahead")}


def test_along_the_heading_lies_the_goal_whose_bearing_is_nearest_also_across_180_degrees() -> None:
    model = tiny_model()
    poses = np.array([[0, 0, 0.0], [0, 0, 0.6], [0, 0, -0.6], [20.0, 0.3, np.pi - 0.01], [0, 0, 2 * np.pi + 0.6]])
    asked = dataclasses.replace(samples([0] * 5, [0] * 5, [0] * 5), pose=poses)
    named = [GOALS.names[k] for k in along_heading(model, asked)]
    assert named == ["ahead", "left", "right", "ahead", "left"]


def test_samples_that_were_learned_are_their_own_nearest_neighbours() -> None:
    model = tiny_model()
    np.testing.assert_array_equal(nearest_neighbour(model, model.samples), model.samples.goal)


@pytest.mark.parametrize("name", BASELINES)
def test_every_baseline_answers_each_sample_with_a_goal(name: str) -> None:
    model, asked = tiny_model(), samples_of(drives(1))
    said = BASELINES[name](model, asked)
    assert said.shape == (len(asked),)
    assert set(said) <= {0, 1, 2}


def test_drives_come_one_by_one_in_their_order() -> None:
    mixed = samples([0, 1, 1, 2], [7, 3, 3, 5], [0, 0, 1, 0])
    parts = drives_of(mixed)
    assert [int(part.drive[0]) for part in parts] == [7, 3, 5]
    assert [len(part) for part in parts] == [1, 2, 1]
