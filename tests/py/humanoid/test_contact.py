"""Distances of moving segments to boxes against slow obvious computations."""

import numpy as np
import pytest
from hypothesis import given, settings

from lfdcore.humanoid.contact import STEP, Capsule, nearest_approach, segment_box_distance
from lfdcore.humanoid.scene import Box
from sweeps import BOX, RIGHT, boxes, paths, points, sweep

Array = np.ndarray


# -- distances ------------------------------------------------------------------------------------------------------


def sampled_distance(begin: Array, end: Array, box: Box, count: int = 2001) -> float:
    """Distance by points along the segment, each clipped into the box: an upper bound."""
    dense = begin + np.linspace(0, 1, count)[:, None] * (end - begin)
    cos, sin = np.cos(box.yaw), np.sin(box.yaw)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    local = (dense - np.array(box.centre)) @ turn.T
    half = np.array(box.size) / 2
    return float(np.linalg.norm(local - np.clip(local, -half, half), axis=1).min())


@given(points, points, boxes)
def test_segment_to_box_is_the_least_distance_of_its_points(begin: tuple, end: tuple, box: Box) -> None:
    a, b = np.array(begin), np.array(end)
    (exact,), (at,) = segment_box_distance(a[None], b[None], box)
    coarse = sampled_distance(a, b, box)
    assert exact <= coarse + 1e-9
    assert coarse - exact <= np.linalg.norm(b - a) / 4000 + 1e-9
    assert 0 <= at <= 1
    here = a + at * (b - a)
    assert sampled_distance(here, here, box, 2) == pytest.approx(exact, abs=1e-9)


def test_distance_to_a_sampled_surface_agrees() -> None:
    rng = np.random.default_rng(3)
    box = Box((0.2, -0.1, 0.3), (0.4, 0.6, 0.8), 0.5)
    faces = rng.uniform(-0.5, 0.5, (60000, 3))
    axis = rng.integers(0, 3, len(faces))
    faces[np.arange(len(faces)), axis] = np.sign(rng.normal(size=len(faces))) * 0.5
    local = faces * box.size
    cos, sin = np.cos(box.yaw), np.sin(box.yaw)
    surface = local @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + np.array(box.centre)
    for _ in range(20):
        a, b = rng.uniform(-1.5, 1.5, (2, 3))
        exact = float(segment_box_distance(a[None], b[None], box)[0][0])
        along = a + np.linspace(0, 1, 60)[:, None] * (b - a)
        slow = np.sqrt(((along[:, None] - surface[None, ::6]) ** 2).sum(axis=2)).min()
        if exact > 0.05:
            assert exact - 1e-9 <= slow <= exact + 0.03


@pytest.mark.parametrize(
    ("begin", "end", "distance"),
    [
        ((-2, 0, 0), (2, 0, 0), 0.0),  # through
        ((0, 0, 0), (0.1, 0, 0), 0.0),  # wholly inside
        ((2, 0, 0), (2, 0, 0), 1.5),  # a point
        ((0.5, 0, 0), (3, 0, 0), 0.0),  # touching a face
        ((-3, 0, 1), (3, 0, 1), 0.5),  # along a face
        ((1.5, -3, 1.5), (1.5, 3, 1.5), np.sqrt(2)),  # along an edge
    ],
)
def test_known_distances_to_a_unit_box(begin: tuple, end: tuple, distance: float) -> None:
    found = segment_box_distance([begin], [end], Box((0, 0, 0), (1, 1, 1)))[0][0]
    assert found == pytest.approx(distance, abs=1e-12)


@given(points, points, boxes)
def test_the_order_of_the_ends_does_not_matter(begin: tuple, end: tuple, box: Box) -> None:
    one, other = (segment_box_distance([a], [b], box)[0][0] for a, b in ((begin, end), (end, begin)))
    assert one == pytest.approx(other, abs=1e-12)


# -- sweeps ---------------------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(paths, points, boxes)
def test_the_swept_distance_is_that_of_a_fine_sweep_within_the_stated_bound(
    path: Array, right: tuple, box: Box
) -> None:
    still = np.broadcast_to(right, path.shape)
    found = nearest_approach(still, path, box)
    parts = 4000
    at = np.linspace(0, len(path) - 1, parts)
    fine = np.stack([np.interp(at, np.arange(len(path)), column) for column in path.T], axis=1)
    slow = segment_box_distance(np.broadcast_to(right, fine.shape), fine, box)[0].min()
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert found.distance <= slow + STEP / 2 + 1e-9
    assert slow <= found.distance + length / parts + 1e-9
    nearest = np.array([found.point])
    assert segment_box_distance(nearest, nearest, box)[0][0] == pytest.approx(found.distance, abs=1e-9)
    assert 0 <= found.sample <= len(path) - 1


def test_a_capsule_that_reaches_into_the_box_touches_it_without_any_clearance_too() -> None:
    beside = np.array([[0.0, 0.53, 0.0], [0.1, 0.53, 0.0]])
    unit = Box((0, 0, 0), (1, 1, 1))
    thick, thin = (nearest_approach(beside, beside, unit, clearance=0, radius=radius) for radius in (0.05, 0.02))
    assert (thick.distance, thick.touches) == (0, True)
    assert (thin.distance, thin.touches) == (pytest.approx(0.01), False)


# -- bad input ------------------------------------------------------------------------------------------------------


def test_bounds_that_cannot_be_are_refused() -> None:
    still = np.broadcast_to(RIGHT, sweep().shape)
    with pytest.raises(ValueError, match="radius must be finite and >= 0 m, got -1"):
        Capsule(sweep(), sweep(), -1)
    with pytest.raises(ValueError, match="begin has 1 samples and end 60, must be as many"):
        nearest_approach([RIGHT], sweep(), BOX)
    with pytest.raises(ValueError, match="clearance must be >= 0 m and step > 0 m"):
        nearest_approach(still, sweep(), BOX, clearance=np.nan)
    with pytest.raises(ValueError, match="at most 1e6 evaluations"):
        nearest_approach(still, sweep(), BOX, step=1e-9)
