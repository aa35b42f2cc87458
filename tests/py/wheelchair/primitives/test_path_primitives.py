import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.wheelchair.primitives.local_paths import LocalPaths
from lfdcore.wheelchair.primitives.path_primitives import PathPrimitiveConfig, PathPrimitives, orientation_bin


def arcs(curvatures, lengths):
    """Local paths that are circular arcs from the origin."""
    paths, yaws = [], []
    for k, length in zip(curvatures, lengths, strict=True):
        s = np.linspace(0, length, 30)
        paths.append(np.stack([np.sinc(k * s / np.pi) * s, np.sin(k * s / 2) ** 2 * 2 / k if k else 0 * s], 1))
        yaws.append(k * length)
    count = len(paths)
    goal = np.array([path[-1] for path in paths])
    return LocalPaths(
        np.ones((count, 2)),
        np.ones(count),
        goal,
        np.array(yaws),
        paths,
        np.ones(count),
        np.full(count, "window"),
        np.arange(count) * 1.0,
    )


def slow_primitive(paths, mean):
    """The least-squares shape: each path's rotation and scale to the mean end found as a matrix, then the average."""
    moved = []
    for path in paths:
        x, y = path[-1]
        a, b = np.linalg.solve(np.array([[x, -y], [y, x]]), mean)
        moved.append(path @ np.array([[a, -b], [b, a]]).T)
    return np.mean(moved, axis=0)


def test_a_primitive_is_the_average_after_a_similarity_to_the_mean_end():
    paths = arcs([0.5, 0.55, 0.6], [2.0, 1.8, 2.2])
    config = PathPrimitiveConfig(bins=5, mirror=False)
    assert len(set(orientation_bin(paths.end_yaw, 5))) == 1
    model = PathPrimitives.fit(paths, config)
    assert len(model) == 1
    mean = paths.goal.mean(0)
    np.testing.assert_allclose(model.ends[0], mean)
    dense = []
    for k, length in [(0.5, 2.0), (0.55, 1.8), (0.6, 2.2)]:
        s = np.linspace(0, length, 50)
        dense.append(np.stack([np.sin(k * s) / k, (1 - np.cos(k * s)) / k], 1))
    np.testing.assert_allclose(model.shapes[0], slow_primitive(dense, mean), atol=2e-3)


def test_seventeen_bins_are_equal_and_none_is_shared_by_both_ends():
    yaw = -np.pi + (np.arange(17 * 1000) + 0.5) * 2 * np.pi / (17 * 1000)
    assert np.bincount(orientation_bin(yaw)).tolist() == [1000] * 17
    assert orientation_bin(np.array([0.0, 0.18, -0.18])).tolist() == [8, 8, 8]
    assert orientation_bin(np.array([np.pi - 1e-9, -np.pi + 1e-9])).tolist() == [16, 0]
    assert orientation_bin(np.array([np.pi, -np.pi, 3 * np.pi])).tolist() == [16, 16, 16]  # (-pi, pi]


def test_bins_without_data_have_no_primitive_and_counts_say_how_many_paths():
    model = PathPrimitives.fit(arcs([0.0, 0.6, 0.62], [2, 2, 2]), PathPrimitiveConfig(mirror=False))
    assert model.counts.tolist() == [1, 2]
    mirrored = PathPrimitives.fit(arcs([0.0, 0.6, 0.62], [2, 2, 2]))
    assert mirrored.counts.tolist() == [2, 2, 2]


def test_the_chosen_primitive_has_the_nearest_average_end():
    model = PathPrimitives.fit(arcs([0.0, 0.6, 1.0], [2, 2, 2]))
    goals = np.random.default_rng(0).uniform(-2.5, 2.5, (200, 2))
    slow = [min(range(len(model)), key=lambda k: np.hypot(*(model.ends[k] - goal))) for goal in goals]
    assert model.nearest(goals).tolist() == slow


def test_scaling_an_arc_to_another_end_of_its_own_chord_angle_gives_that_arc():
    model = PathPrimitives.fit(arcs([0.6], [2.0]), PathPrimitiveConfig(mirror=False))
    half = model.scaled_to(model.ends[0] / 2)
    s = np.linspace(0, 1.0, 50)
    np.testing.assert_allclose(half, np.stack([np.sin(1.2 * s) / 1.2, (1 - np.cos(1.2 * s)) / 1.2], 1), atol=2e-3)


@settings(max_examples=300, deadline=None)
@given(x=st.floats(-2.5, 2.5), y=st.floats(-2.5, 2.5))
def test_a_scaled_primitive_starts_at_the_origin_and_ends_at_the_goal(x, y):
    if np.hypot(x, y) < 1e-3:
        return
    path = PathPrimitives.fit(arcs([0.0, 0.6, 1.0], [2, 2, 2])).scaled_to(np.array([x, y]))
    np.testing.assert_allclose(path[0], 0, atol=1e-9)
    np.testing.assert_allclose(path[-1], [x, y], atol=1e-9)


@pytest.mark.parametrize("goal", [[0.0, 0.0], [np.nan, 1.0], [np.inf, 0.0]])
def test_a_goal_that_no_similarity_reaches_is_refused(goal):
    model = PathPrimitives.fit(arcs([0.0], [2.0]))
    with pytest.raises(ValueError, match="origin"):
        model.scaled_to(np.array(goal))


def test_loops_back_to_the_start_are_left_out_and_nothing_else_is_refused():
    loop = arcs([2 * np.pi / 2.05], [2.0])
    assert np.hypot(*loop.goal[0]) < 0.2
    with pytest.raises(ValueError, match="no path primitive"):
        PathPrimitives.fit(loop)
    assert len(PathPrimitives.fit(LocalPaths.concatenate([loop, arcs([0.0], [2.0])]))) == 1


@pytest.mark.parametrize("field", [{"bins": 0}, {"points": 1}, {"loop": 1.5}])
def test_configs_out_of_range_are_refused_by_name(field):
    with pytest.raises(ValueError, match=next(iter(field))):
        PathPrimitiveConfig(**field)


GOOD = {
    "ends": np.array([[1.0, 0.0], [1.0, 1.0]]),
    "shapes": np.array([[[0, 0], [0.5, 0.1], [1, 0]], [[0, 0], [0.6, 0.5], [1, 1.0]]]),
    "bins": np.array([3, 5], np.int32),
    "counts": np.array([1, 2], np.int32),
}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"ends": np.array([[0.0, 0.0], [1.0, 1.0]])}, "primitive 0 ends 0 m from the origin"),
        ({"ends": np.array([[1.0, 0.0], [1e-310, 0.0]])}, "primitive 1 ends 1e-310 m from the origin"),
        ({"ends": GOOD["ends"] * np.nan}, "must be finite"),
        ({"ends": GOOD["ends"] * 1e300}, r"within 1e\+06 m"),
        ({"ends": np.zeros(())}, "have ends of shape"),
        ({"ends": np.zeros((0, 2))}, "no path primitive"),
        ({"ends": GOOD["ends"].T[:, :1]}, "have ends of shape"),
        ({"shapes": GOOD["shapes"] * np.nan}, "must be finite"),
        ({"shapes": GOOD["shapes"] * 0}, "primitive 0 is a shape that misses the origin or its end by 1 m"),
        ({"shapes": GOOD["shapes"] + 0.1}, "misses the origin"),
        ({"shapes": GOOD["shapes"][:, :1]}, "shapes of shape"),
        ({"shapes": GOOD["shapes"][0]}, "shapes of shape"),
        ({"bins": np.array([5, 3])}, r"bins \[5 3\]"),
        ({"bins": np.array([-1, 3])}, r"bins \[-1 +3\]"),
        ({"bins": np.array([3])}, r"\(1,\) bins"),
        ({"counts": np.array([0, 3])}, r"counts \[0 3\]"),
    ],
)
def test_degenerate_primitives_are_refused(change, reason):
    assert len(PathPrimitives(**GOOD)) == 2
    with pytest.raises(ValueError, match=reason):
        PathPrimitives(**{**GOOD, **change})
