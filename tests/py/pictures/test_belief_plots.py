"""Pictures of beliefs: ellipses where the belief is, the map where the drive is, animations from the first moment."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from goal_worlds import GOALS, drive_to, samples_of, tiny_model
from lfdcore.grid import OccupancyGrid
from lfdcore.pictures import belief as belief_plots
from lfdcore.pictures.belief import (
    belief_figure,
    confusion_figure,
    drive_figure,
    ellipse_of,
    likelihood_figure,
    save_belief_animation,
)
from lfdcore.pictures.goals import square_around
from lfdcore.pictures.style import png
from lfdcore.wheelchair.goals.samples import GoalSamples
from lfdcore.wheelchair.goals.track import BeliefTrack, track_beliefs


@pytest.fixture(scope="module")
def grid() -> OccupancyGrid:
    """A hall of 120 x 120 m, of which the drives see a corner."""
    return OccupancyGrid(np.zeros((1200, 1200), np.int8), 0.1, (-60.0, -60.0))


@pytest.fixture(scope="module")
def track() -> tuple[GoalSamples, BeliefTrack]:
    model, samples = tiny_model(), samples_of([drive_to(0, 31)])
    return samples, track_beliefs(model, samples, model.action_model())


def first(track: tuple[GoalSamples, BeliefTrack], count: int) -> tuple[GoalSamples, BeliefTrack]:
    mask = np.arange(len(track[0])) < count
    return track[0].where(mask), track[1].where(mask)


@pytest.mark.parametrize("covariance", [[[4.0, 0.0], [0.0, 1.0]], [[2.0, 1.5], [1.5, 3.0]], [[1.0, -0.9], [-0.9, 1.0]]])
def test_an_ellipse_s_edge_is_as_far_from_the_mean_in_mahalanobis_distance_all_around(covariance: list) -> None:
    mean, shape = np.array([3.0, -1.0]), np.array(covariance)
    ellipse = ellipse_of(mean, shape, "black")
    off = ellipse.get_patch_transform().transform(ellipse.get_path().vertices) - mean
    distance = np.sqrt((off * np.linalg.solve(shape, off.T).T).sum(1))
    on_edge = ellipse.get_path().codes != 79
    edge = distance[on_edge][::3]  # between them lie the control points of splines
    np.testing.assert_allclose(edge, belief_plots._SIGMAS, rtol=1e-6)


def test_a_belief_without_spread_is_drawn_as_a_point() -> None:
    ellipse = ellipse_of(np.zeros(2), np.array([[1.0, 0.0], [0.0, -1e-18]]), "black")
    assert ellipse.get_height() == 0 or ellipse.get_width() == 0


def test_a_square_around_points_holds_them_with_a_margin() -> None:
    x0, x1, y0, y1 = square_around(np.array([[0.0, 0.0], [10.0, 2.0]]), margin=1.0)
    assert (x0, x1, y0, y1) == (-1, 11, -5, 7)


def test_the_map_is_drawn_where_drive_and_goals_are(grid: OccupancyGrid, track: tuple) -> None:
    figure = drive_figure(grid, GOALS, track)
    panels = figure.axes[:4]
    points = np.concatenate([GOALS.positions, track[0].pose[:, :2]])
    for axes in panels:
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        assert ((points > [x0, y0]) & (points < [x1, y1])).all()
        assert x1 - x0 < 20
        assert axes.images[0].get_array().shape[0] < 250  # cells drawn, of 1200


def test_a_drive_s_panels_name_the_nearest_goal_and_the_time_of_each_quarter(grid: OccupancyGrid, track: tuple) -> None:
    samples, beliefs = track
    titles = [axes.get_title() for axes in drive_figure(grid, GOALS, track).axes[:4]]
    assert titles[3] == f"{samples.stamp[-1]:.0f} s: {GOALS.names[beliefs.nearest[-1]]}"
    times = [float(title.split(" s:")[0]) for title in titles]
    np.testing.assert_allclose(times, samples.stamp[-1] * np.arange(1, 5) / 4, atol=0.6)


def test_goals_outside_the_map_leave_the_map_whole() -> None:
    small = OccupancyGrid(np.zeros((20, 20), np.int8), 0.1, (500.0, 500.0))
    samples = samples_of([drive_to(0, 31)]).where(np.arange(3))
    model = tiny_model()
    figure = drive_figure(small, GOALS, (samples, track_beliefs(model, samples, model.action_model())))
    assert figure.axes[0].images[0].get_array().shape[:2] == (20, 20)


@pytest.mark.parametrize("count", [1, 2])
def test_a_drive_of_a_sample_or_two_can_be_drawn(grid: OccupancyGrid, track: tuple, count: int, tmp_path: Path) -> None:
    short = first(track, count)
    assert png(drive_figure(grid, GOALS, short))[:4] == b"\x89PNG"
    save_belief_animation(tmp_path / "short.gif", grid, GOALS, short)
    with Image.open(tmp_path / "short.gif") as image:
        assert image.n_frames == count


def test_the_same_beliefs_give_the_same_picture(grid: OccupancyGrid, track: tuple) -> None:
    one, two = (png(belief_figure(grid, GOALS, [track], (1.0, 5.0))) for _ in range(2))
    assert one == two


def test_an_instant_after_the_drive_s_end_shows_its_end(grid: OccupancyGrid, track: tuple) -> None:
    figure = belief_figure(grid, GOALS, [track], (1e6,))
    way = max((line.get_xydata() for line in figure.axes[0].lines), key=len)
    np.testing.assert_array_equal(way, track[0].pose[:, :2])


def test_likelihoods_of_a_drive_whose_goal_nobody_knows_are_drawn(track: tuple) -> None:
    samples, beliefs = track
    unknown = dataclasses.replace(samples, goal=np.full(len(samples), -1))
    figure = likelihood_figure(GOALS, [(unknown, beliefs.likelihood, beliefs.nearest)])
    assert figure.axes[0].get_title() == "drive to ?"


def test_a_confusion_picture_shows_shares_of_each_row_with_counts() -> None:
    table = np.array([[3, 1, 0], [0, 0, 0], [0, 2, 2]])
    axes = confusion_figure(GOALS, {"sparse": table}).axes[0]
    assert [text.get_text() for text in axes.texts[:2]] == ["75 %\n3", "25 %\n1"]
    assert axes.texts[3].get_text() == "0 %\n0"  # nothing went there: no division by nothing
    assert axes.get_title() == "sparse: 62 % right"
