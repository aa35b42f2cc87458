"""A small study of Ch. 2 from recorded drives, and its report: tables, aims, pictures."""

import dataclasses
import json
from inspect import signature

import numpy as np
import pytest

from lfdcore.datasets import Goals, write_map
from lfdcore.progress import silent
from lfdcore.simulated.courses import goal_building, goals_in_map
from lfdcore.study.goals.drives import (
    RUNS_EACH,
    SEED,
    GoalDrives,
    noisy_joystick,
    perturbed_poses,
    record_goal_drives,
)
from lfdcore.study.goals.evaluation import BASELINES, agreement, confidence_time, drives_of
from lfdcore.study.goals.report import findings, goal_headline, goal_pictures, run
from lfdcore.study.goals.study import (
    FILTERED,
    NOISE,
    POSE_ERRORS,
    TRIAL_SEED,
    TRIALS,
    GoalResult,
    GoalStudy,
    _localised,
    judge_goal_drives,
)
from lfdcore.study.goals.tables import (
    accuracy_table,
    aims,
    consistency_table,
    goal_tables,
    noise_table,
    pose_table,
    time_table,
)
from lfdcore.study.preset import Preset
from lfdcore.study.study import default_of, write_study
from lfdcore.training.goals import GoalLearningConfig
from lfdcore.training.parts.goal_net import GoalNetConfig
from lfdcore.wheelchair.goals.model import GoalModel
from lfdcore.wheelchair.goals.samples import drive_samples
from lfdcore.wheelchair.goals.track import track_beliefs

SMALL = GoalLearningConfig(
    network=GoalNetConfig(epochs=40), search_samples=60, searches=1, generations=3, subset=60, candidates=20
)
NEAR = ("G2", "G3", "G6")


def some_of(drives: GoalDrives, first_run: int) -> GoalDrives:
    """Drives to the three destinations with the shortest ways, from a run on."""
    goals = Goals(tuple(g for g in drives.world.goals.goals if g.name in NEAR))
    world = dataclasses.replace(drives.world, goals=goals)
    kept = [k for k, name in enumerate(drives.destinations) if name in NEAR and drives.runs[k] >= first_run]
    paths, traces, names, runs = (
        tuple(values[k] for k in kept) for values in (drives.paths, drives.traces, drives.destinations, drives.runs)
    )
    return GoalDrives(paths, traces, world, names, runs)


@pytest.fixture(scope="module")
def result(goal_drives: GoalDrives) -> GoalResult:
    """Two drives to each of three destinations to learn from, the third is held out; the same drives with noise."""
    drives, trials = (some_of(goal_drives, first) for first in (RUNS_EACH - 3, 0))
    return judge_goal_drives(GoalStudy(seed=1), drives, trials, SMALL)


def test_what_is_learned_from_is_not_what_is_judged(result: GoalResult) -> None:
    learned, judged = set(result.drives.training), set(result.drives.held_out)
    assert len(learned) == 6
    assert len(judged) == 3
    assert not learned & judged
    assert len(drives_of(result.held_out)) == 3
    assert set(result.held_out.goal) == {0, 1, 2}


def test_the_model_knows_only_the_drives_to_learn_from(result: GoalResult) -> None:
    learned = result.drives.logs(result.drives.training)
    assert result.model.metadata["logs"] == [log.name for log in learned]
    known = {row.tobytes() for row in result.model.samples.pose}
    assert not known & {row.tobytes() for row in result.held_out.pose}


def test_without_process_noise_is_a_filter_without_process_noise(result: GoalResult) -> None:
    quiet = dataclasses.replace(result.model, config=dataclasses.replace(result.model.config, process_noise=0.0))
    begin = result.held_out.where(np.arange(40))
    track = track_beliefs(quiet, begin, quiet.action_model())
    np.testing.assert_array_equal(result.tracks["sparse, no process noise"].covariance[:40], track.covariance)
    assert not np.array_equal(result.tracks["sparse"].covariance[:40], track.covariance)


def test_a_trial_is_the_network_asked_with_a_noisy_stick(result: GoalResult, goal_drives: GoalDrives) -> None:
    drives, share = some_of(goal_drives, 0), 1 - np.exp(-0.1 / FILTERED)
    sure = 0
    for trial in result.trials:
        name = result.model.goals.names[trial.goal]
        (k,) = [
            k for k in range(len(drives.runs)) if (drives.destinations[k], drives.drivers[k]) == (name, trial.driver)
        ]
        drive = drive_samples(drives.logs([k])[0])
        stick = noisy_joystick(drive.joystick, trial.noise, result.study.seed + TRIAL_SEED + k)
        said = result.model.network.predict(drive.pose, stick)
        np.testing.assert_equal(trial.sure_after, confidence_time(said, drive.stamp, trial.goal))
        for t in range(1, len(said)):
            said[t] = said[t - 1] + share * (said[t] - said[t - 1])
        np.testing.assert_equal(trial.filtered, confidence_time(said, drive.stamp, trial.goal))
        sure += np.isfinite([trial.sure_after, trial.filtered]).all()
    assert sure > 10


def test_a_pose_error_is_of_the_metres_and_degrees_that_its_row_says(result: GoalResult) -> None:
    samples, sparse = result.held_out, result.model.action_model()
    for row, (metres, radians) in ((3, (1.0, 0.0)), (5, (0.0, np.pi / 9))):
        poses = samples.pose.copy()
        for drive in (0, 1, 2):
            mine = samples.drive == drive
            poses[mine] = perturbed_poses(poses[mine], metres, radians, drive)
        nearest = track_beliefs(result.model, dataclasses.replace(samples, pose=poses), sparse).nearest
        assert result.pose_errors[row].accuracy.share == (nearest == samples.goal).mean()


def test_the_scan_matcher_s_row_is_of_its_own_poses(result: GoalResult) -> None:
    _, matched = _localised(result.drives, silent)
    pose = np.concatenate([one.pose for one in matched])
    off = np.hypot(*(pose - result.held_out.pose)[:, :2].T)
    assert 0 < np.median(off) < 0.05


def test_every_filter_and_baseline_is_judged_on_all_held_out_samples(result: GoalResult) -> None:
    filters = {"sparse", "sparse, no process noise", "full", "full, no process noise"}
    assert set(result.tracks) == filters
    methods = {f"Gaussian process, {name}" for name in filters} | {"network", *BASELINES}
    assert {one.method for one in result.accuracies} == methods
    assert {one.samples for one in result.accuracies} == {len(result.held_out)}


def test_the_accuracy_table_has_the_shares_of_the_result(result: GoalResult) -> None:
    table = accuracy_table(result)
    assert f"n = {len(result.held_out)} samples of 3 drives, seed 1" in table.title
    for row, one in zip(table.rows, result.accuracies, strict=True):
        assert row[0] == one.method
        assert row[1] == f"{100 * one.share:.0f} %\n[{100 * one.low:.0f}, {100 * one.high:.0f}]"
    sparse = next(one for one in result.accuracies if one.method == "Gaussian process, sparse")
    assert sparse.share == (result.tracks["sparse"].nearest == result.held_out.goal).mean()


def test_table_2_1_has_the_same_driver_in_a_column_and_a_row_a_destination_and_noise(result: GoalResult) -> None:
    table = noise_table(result)
    assert len(table.rows) == 3 * len(NOISE)
    assert f"n = {len(result.trials)} drives" in table.title
    assert len(result.trials) == 3 * len(NOISE) * TRIALS
    for goal in range(3):
        for noise in NOISE:
            drivers = [t.driver for t in result.trials if (t.goal, t.noise) == (goal, noise)]
            assert drivers == list(range(TRIALS))


def test_the_shares_of_table_2_1_are_of_each_drive_s_duration(result: GoalResult) -> None:
    note, parts = noise_table(result).note, []
    for name in ("sure_after", "filtered"):
        shares = np.array([getattr(trial, name) / trial.duration for trial in result.trials])
        shares[np.isnan(shares)] = 1.0  # never sure: the whole drive
        parts.append(f"{100 * shares.mean():.0f}+-{100 * shares.std(ddof=1):.0f} %")
    assert f"Over all: {parts[0]} of the drive" in note
    assert f"filtered over 2 s {parts[1]}" in note
    aim = next(one for one in aims(result) if one.label.startswith("90 % sure"))
    assert aim.found == pytest.approx(np.nanmean(shares))


def test_a_run_to_another_destination_is_another_driver_s(goal_drives: GoalDrives) -> None:
    for driver in range(RUNS_EACH):
        mine = [name for name, one in zip(goal_drives.destinations, goal_drives.drivers, strict=True) if one == driver]
        assert sorted(mine) == sorted(goal_drives.world.goals.names)


def test_more_noise_on_the_stick_does_not_change_how_long_a_drive_took(result: GoalResult) -> None:
    for goal in range(3):
        for driver in range(TRIALS):
            mine = {t.duration for t in result.trials if (t.goal, t.driver) == (goal, driver)}
            assert len(mine) == 1


def test_the_consistency_table_has_the_nees_of_every_filter(result: GoalResult) -> None:
    rows = {row[0]: row for row in consistency_table(result).rows}
    for name, track in result.tracks.items():
        errors = track.normalised_errors(result.truth)
        assert rows[name][1].startswith(f"{errors.mean() / 2:.2f}\n")
        assert rows[name][3].count(",") == 2  # a mean for each of three drives


def test_poses_that_are_off_and_those_matched_to_the_map_have_a_row_each(result: GoalResult) -> None:
    table = pose_table(result)
    assert [row[0] for row in table.rows] == [
        "0 m",
        "0.1 m",
        "0.3 m",
        "1 m",
        "5 degrees",
        "20 degrees",
        "by the scan matcher",
    ]
    assert len(table.rows) == len(POSE_ERRORS) + 1
    sparse = next(one for one in result.accuracies if one.method == "Gaussian process, sparse")
    assert result.pose_errors[0].accuracy.share == sparse.share  # no error, no difference


def test_the_scan_matcher_knows_where_the_chair_is_to_a_few_centimetres(result: GoalResult) -> None:
    position, heading = result.matcher_errors.T
    assert position.mean() < 0.05
    assert np.degrees(heading.mean()) < 1


def test_the_time_table_gives_a_ratio_and_counts_what_it_is_of(result: GoalResult) -> None:
    (row,) = time_table(result).rows
    assert row[0] == f"N = {len(result.model.samples)} / 60"
    assert row[1] == f"{result.update_seconds['full'] / result.update_seconds['sparse']:.0f}"


def test_aims_are_figures_of_the_result_and_say_what_was_missed(result: GoalResult) -> None:
    by = {one.method: one.share for one in result.accuracies}
    found = {aim.label: aim for aim in aims(result)}
    full, sparse = by["Gaussian process, full"], by["Gaussian process, sparse"]
    best = max(by[name] for name in BASELINES)
    assert found["accuracy, full"].found == full
    assert found["accuracy, full"].reached == (full >= 0.65)
    assert found["... above the best baseline"].found == full - best
    assert found["accuracy, sparse, above the best baseline"].found == sparse - best
    _, kappa = agreement(result.tracks["full"].nearest, result.tracks["sparse"].nearest, 3)
    assert found["agreement full, sparse (kappa)"].found == kappa
    nees = result.tracks["sparse"].normalised_errors(result.truth).mean() / 2
    aim = found["NEES / 2, sparse, with process noise"]
    assert aim.found == nees
    assert aim.reached == (0.5 <= nees <= 2)


def without_full(result: GoalResult) -> GoalResult:
    return dataclasses.replace(
        result,
        tracks={name: track for name, track in result.tracks.items() if "full" not in name},
        accuracies=tuple(one for one in result.accuracies if "full" not in one.method),
        update_seconds={"sparse": result.update_seconds["sparse"]},
    )


def test_a_study_of_the_subset_alone_says_nothing_of_all_data(result: GoalResult) -> None:
    sparse = without_full(result)
    assert not any("full" in aim.label for aim in aims(sparse))
    assert time_table(sparse).rows[0][1] == "-"
    assert "full" not in goal_headline(sparse)
    assert all("all data" not in picture.caption for picture in goal_pictures(sparse))


def test_a_network_that_is_never_sure_is_reported_as_such(result: GoalResult) -> None:
    never = tuple(dataclasses.replace(trial, sure_after=float("nan"), filtered=float("nan")) for trial in result.trials)
    unsure = dataclasses.replace(result, trials=never)
    table = noise_table(unsure)
    assert set(table.rows[0][2:]) == {"never", "100 %"}
    assert "nan" not in table.as_text()
    aim = next(one for one in aims(unsure) if one.label.startswith("90 % sure"))
    assert not aim.reached
    assert all("nan" not in made.as_text() for made in goal_tables(unsure))


def test_the_headline_names_shares_n_and_seed(result: GoalResult) -> None:
    said = goal_headline(result)
    best = max((one for one in result.accuracies if one.method in BASELINES), key=lambda one: one.share)
    assert f"best baseline ({best.method}) {100 * best.share:.0f} %" in said
    assert f"n = {len(result.held_out)} samples of 3 held-out drives, 3 destinations" in said
    assert said.endswith("seed 1.")


def test_the_report_holds_five_pictures_all_tables_and_its_command(result: GoalResult, tmp_path) -> None:
    found = findings(result)
    assert len(found.pictures) == 5
    text = write_study(result.study, found, tmp_path).read_text()
    assert text.count("<img") + text.count("<svg") >= 5
    assert text.count("<table") == len(goal_tables(result)) == 9
    assert "lfdcore study goals -o out --full --subset 800 --preset default --seed 1" in text
    document = json.loads((tmp_path / "figures.json").read_text())
    shares = {row["method"]: row["accuracy"] for row in document["rows"] if "method" in row}
    assert shares == {one.method: one.share for one in result.accuracies}
    assert {row["figure"] for row in document["rows"] if "figure" in row} == {aim.label for aim in aims(result)}
    assert document["aims"] == [row for row in document["rows"] if "figure" in row]


def test_the_learned_model_is_written_beside_the_report(result: GoalResult, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("lfdcore.study.goals.report.run_goal_study", lambda study, folder, tell: result)
    assert run(result.study, tmp_path, silent).headline == goal_headline(result)
    written = GoalModel.load(tmp_path / "goals.safetensors")
    assert written.goals.names == result.model.goals.names
    assert written.metadata == result.model.metadata


# -- the config -----------------------------------------------------------------------------------------------------


def test_the_drives_and_their_study_have_one_default_seed_and_the_subset_is_that_of_learning() -> None:
    assert default_of(GoalStudy, "seed") == signature(record_goal_drives).parameters["seed"].default == SEED
    assert default_of(GoalStudy, "subset") == GoalLearningConfig().subset


def test_a_study_learns_by_its_preset_with_its_own_subset_and_seed() -> None:
    learning = GoalStudy(preset=Preset.thesis, subset=70, seed=5).learning()
    assert learning == dataclasses.replace(GoalLearningConfig.thesis(), subset=70, seed=5)
    assert GoalStudy(seed=1).learning() == GoalLearningConfig()


def test_a_map_stands_in_the_command_and_gives_the_world(tmp_path) -> None:
    write_map(goal_building().grid, tmp_path / "building.yaml")
    study = GoalStudy(map_file=tmp_path / "building.yaml", full=False, seed=4)
    assert study.world().goals == goals_in_map(tmp_path / "building.yaml", 4).goals
    assert "--map building.yaml --sparse --subset 800" in study.command()
