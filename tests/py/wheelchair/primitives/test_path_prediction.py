import os
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from lfdcore.grid import LaserScan, read_beams
from lfdcore.training.drive_primitives import LearningConfig, learn_drive
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.paths import along, geometric_median
from lfdcore.wheelchair.primitives.local_paths import extract_local_paths
from lfdcore.wheelchair.primitives.prediction import PathPredictionConfig, PathPredictor
from synthetic_drive import AHEAD, LEFT, T_BASE_LASER, corner_drive, scan_at


def test_the_geometric_median_has_the_least_sum_of_distances():
    random = np.random.default_rng(3)
    paths, weights = random.normal(size=(15, 4, 2)), random.uniform(0.1, 1, 15)
    median = geometric_median(paths, weights, 200)
    for a in range(4):
        best = minimize(lambda p, a=a: weights @ np.linalg.norm(paths[:, a] - p, axis=1), paths[:, a].mean(0)).x
        np.testing.assert_allclose(median[a], best, atol=2e-3)


def test_a_path_of_weight_0_has_no_say_in_the_geometric_median():
    paths = np.random.default_rng(4).normal(size=(6, 3, 2))
    weights = np.array([1.0, 0.0, 2.0, 0.5, 0.0, 1.0])
    among = geometric_median(paths, weights, 20)
    np.testing.assert_allclose(among, geometric_median(paths[weights > 0], weights[weights > 0], 20), atol=1e-12)


def test_one_voter_or_equal_voters_are_their_own_median():
    path = np.array([[[1.0, 2.0], [3.0, 4.0]]])
    np.testing.assert_allclose(geometric_median(path, np.ones(1), 15), path[0])
    np.testing.assert_allclose(geometric_median(np.repeat(path, 3, 0), np.ones(3), 15), path[0])


def test_a_path_is_equally_spaced_and_goes_straight_on_beyond_its_end():
    quarter = np.stack([np.sin(np.linspace(0, np.pi / 2, 400)), 1 - np.cos(np.linspace(0, np.pi / 2, 400))], 1)
    path = along(quarter, np.linspace(0, 2.5, 26))
    assert path.shape == (26, 2)
    np.testing.assert_allclose(path[10], [np.sin(1.0), 1 - np.cos(1.0)], atol=1e-5)
    beyond = np.diff(path[17:], axis=0)
    np.testing.assert_allclose(np.hypot(*beyond.T), 0.1, atol=1e-9)
    np.testing.assert_allclose(beyond, np.repeat(beyond[:1], len(beyond), 0), atol=1e-9)
    assert np.arctan2(beyond[0, 1], beyond[0, 0]) == pytest.approx(np.pi / 2, abs=0.13)  # the chord of the last .25 m


@pytest.mark.parametrize("rule", ["median", "goal"])
def test_an_unseen_drive_through_the_corner_is_predicted_better_than_straight_on(corner_model, rule):
    log = corner_drive(0.07, speed=0.4)
    driven = extract_local_paths(log)
    predictor = PathPredictor(corner_model, PathPredictionConfig(rule=rule))
    errors, straight = [], []
    for i in np.flatnonzero(driven.reason == "window"):
        scan = LaserScan(
            log.ranges[np.searchsorted(log.scan_stamp, driven.stamp[i])], -np.pi / 2, np.pi / 180, 0.0, 30.0
        )
        path = predictor.predict(driven.joystick[i], scan, T_BASE_LASER)
        truth = along(driven.paths[i], np.linspace(0, 2.0, 21))
        errors.append(np.linalg.norm(path[:21] - truth, axis=1).mean())
        straight.append(np.linalg.norm(np.stack([np.linspace(0, 2, 21), 0 * truth[:, 0]], 1) - truth, axis=1).mean())
    assert len(errors) > 100
    assert np.mean(errors) < 0.75 * np.mean(straight)


def test_nothing_likely_is_no_path(corner_model):
    predictor = PathPredictor(corner_model)
    assert predictor.predict(np.zeros(2), scan_at(0, 0, 0), T_BASE_LASER) is None
    blind = LaserScan(np.full(181, np.nan, np.float32), -np.pi / 2, np.pi / 180)
    assert predictor.predict(AHEAD, blind, T_BASE_LASER) is None
    printed = PathPredictor(corner_model, PathPredictionConfig.thesis())
    assert printed.predict(np.zeros(2), scan_at(0, 0, 0), T_BASE_LASER) is None


@pytest.mark.parametrize("pose", [(3.0, 0.4, 0.1), (5.2, 0.0, 0.1), (6.8, 2.0, 1.7)])
def test_primitives_nearer_to_the_scan_than_demonstrations_lose_their_vote(corner_model, pose):
    scan = scan_at(*pose)
    hits = BeamGeometry(181, -np.pi / 2, np.pi / 180, T_BASE_LASER).hits(*read_beams(scan))
    hits = hits[(np.abs(hits) < 2.5).all(1)]
    likelihood = corner_model.intention.cell_likelihoods(AHEAD, scan, T_BASE_LASER)
    votes = PathPredictor(corner_model).votes(AHEAD, scan, T_BASE_LASER)
    primitives = corner_model.primitives.scaled_to_all(corner_model.intention.centres)
    nearest = np.linalg.norm(primitives[:, :, None] - hits, axis=3).min(axis=(1, 2))
    near, far = nearest < corner_model.clearance - 0.3, nearest > corner_model.clearance + 0.3
    assert (likelihood[near] > 0).sum() > 3 or (likelihood[far] > 0).sum() > 3
    np.testing.assert_allclose(votes[near], 0.02 * likelihood[near])  # some doubt stays
    assert (votes[far] >= 0.99 * likelihood[far]).all()
    unmoved = PathPredictor(corner_model, PathPredictionConfig(edge=0.0)).votes(AHEAD, scan, T_BASE_LASER)
    np.testing.assert_array_equal(unmoved, likelihood)


def test_the_thesis_rule_is_the_primitive_to_the_likeliest_cell(corner_model):
    scan = scan_at(5.5, 0, 0.2)
    path = PathPredictor(corner_model, PathPredictionConfig.thesis()).predict(LEFT, scan, T_BASE_LASER)
    goal, _ = corner_model.intention.goal(corner_model.intention.predict(LEFT, scan, T_BASE_LASER))
    np.testing.assert_allclose(path, along(corner_model.primitives.scaled_to(goal), np.linspace(0, 2.5, 26)))
    assert np.linalg.norm(path - PathPredictor(corner_model).predict(LEFT, scan, T_BASE_LASER)) > 0.01


@pytest.mark.parametrize("field", [{"rule": "mean"}, {"reach": 0.0}, {"points": 1}, {"edge": -1.0}])
def test_configs_out_of_range_are_refused_by_name(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        PathPredictionConfig(**field)


@pytest.mark.realdata
def test_on_freiburg_079_it_beats_straight_and_arc_and_the_mark_of_31_cm():
    """Learned on the first 70 % of the scans, every sample of the rest; the printed form is worse than both."""
    folder = os.environ.get("LFDCORE_DATA")
    if not folder:
        pytest.skip("LFDCORE_DATA is not set: no real logs at hand")
    from lfdcore.datasets import joystick_from_motion, open_log
    from lfdcore.study.prediction.path_error import (
        ARC,
        at_arc_lengths,
        constant_arc,
        path_errors,
        path_samples,
        straight,
    )

    whole = joystick_from_motion(open_log(Path(folder) / "logs" / "freiburg-079-corrected.log.gz"))
    train, rest = whole.share(0.0, 0.7), whole.share(0.7, 1.0)
    samples = path_samples(rest)
    sticks = rest.joystick_at(rest.scan_stamp)

    def error(learning, prediction, reach):
        predictor = PathPredictor(learn_drive([train], learning), prediction)
        paths = [predictor.predict(sticks[i], rest.scan(int(i)), rest.T_base_laser) for i in samples.scan]
        fallback = np.stack([ARC, 0 * ARC], 1)
        predicted = np.array([fallback if path is None else at_arc_lengths(path) for path in paths])
        return [path_errors(predicted, samples.driven, r).mean() for r in reach]

    assert len(samples) > 700
    ours = error(LearningConfig(), PathPredictionConfig(), (2.0, 2.5))
    for reach, mine in zip((2.0, 2.5), ours, strict=True):
        for baseline in (straight, constant_arc):
            assert mine < 0.75 * path_errors(baseline(samples.velocity), samples.driven, reach).mean()
    assert ours[1] < 0.31
