"""The process noise of beliefs over destinations, chosen by leaving drives out (ERRATA 6)."""

import numpy as np
import pytest

from goal_worlds import GOALS, drives, learned, samples_of, tiny_model
from lfdcore.training.parts.process_noise import best_calibrated, leave_drives_out
from lfdcore.wheelchair.goals.model import GoalModel, LeftOutFigures
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import track_beliefs


def model_of(samples: GoalSamples) -> GoalModel:
    """Kernels and network as they come, conditioned on every seventh of these samples."""
    tiny, chosen = tiny_model(), samples.where(np.arange(0, len(samples), 7))
    return GoalModel(GOALS, chosen, tiny.kernels, np.arange(len(chosen)), tiny.network, tiny.config)


def test_the_figures_are_those_of_models_that_never_saw_the_drive() -> None:
    samples = samples_of(drives(2))
    found = leave_drives_out(samples, 5, (0.3,), model_of)[0]
    right, errors = [], []
    for k in range(2):  # drives come goal after goal: 0, 1, 2, then 3, 4, 5
        left_out = samples.drive // 3 == k
        model, unseen = model_of(samples.where(~left_out)), samples.where(left_out)
        object.__setattr__(model.config, "process_noise", 0.3)
        track = track_beliefs(model, unseen, model.action_model())
        right += (track.nearest == unseen.goal).tolist()
        off = GOALS.positions[unseen.goal] - track.mean
        errors += [e @ np.linalg.solve(S, e) / 2 for e, S in zip(off, track.covariance, strict=True)]
    assert (found.process_noise, found.samples, found.drives) == (0.3, len(samples), 6)
    assert found.accuracy == pytest.approx(np.mean(right), abs=1e-12)
    assert found.nees == pytest.approx(np.mean(errors), rel=1e-9)


def test_no_model_learns_from_what_it_is_judged_by_and_folds_stop_where_drives_do() -> None:
    samples, seen = samples_of(drives(3)), []
    figures = leave_drives_out(samples, 2, (0.1, 1.0), lambda s: (seen.append(set(s.drive.tolist())), model_of(s))[1])
    assert seen == [set(range(9)) - {0, 1, 2}, set(range(9)) - {3, 4, 5}]
    assert [one.drives for one in figures] == [6, 6]


def test_a_destination_with_one_drive_keeps_it_and_without_any_other_there_is_nothing_to_tell() -> None:
    samples = samples_of(drives(2))
    single = samples.where(samples.drive != 5)  # one drive to the last destination
    learned_from = []
    leave_drives_out(single, 3, (0.1,), lambda s: (learned_from.append(set(s.drive.tolist())), model_of(s))[1])
    assert all(2 in drives_of_fold for drives_of_fold in learned_from)
    assert leave_drives_out(samples_of(drives(1)), 3, (0.1,), model_of) == []


def test_without_process_noise_samples_of_a_drive_count_as_independent_and_beliefs_get_too_sure() -> None:
    by = {one.process_noise: one.nees for one in learned().left_out}
    assert by[0.0] > 3 * by[3.2]


@pytest.mark.parametrize(
    ("nees", "chosen"), [((8.0, 2.0, 0.6), 0.4), ((8.0, 2.0, 0.4), 0.2), ((4.0, 2.0, 0.5), 0.2), ((0.3, 0.2, 0.1), 0.0)]
)
def test_the_nees_nearest_to_its_dimension_as_a_ratio_is_chosen(nees: tuple[float, ...], chosen: float) -> None:
    rows = [LeftOutFigures(q, 10, 2, 0.5, value) for q, value in zip((0.0, 0.2, 0.4), nees, strict=True)]
    assert best_calibrated(rows) == chosen


def test_learning_takes_the_chosen_one_and_says_what_for() -> None:
    model = learned()
    assert model.config.process_noise == best_calibrated(model.left_out)
    assert "along 9 drives left out" in model.summary()["process noise"]
