"""Orientations against SciPy's Rotation (ERRATA 44)."""

import re

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from lfdcore.primitives import (
    continuous_quaternions,
    geodesic_angle,
    imaginary_parts,
    mean_orientation,
    quaternions_from_imaginary,
)

Floats = NDArray[np.float64]


def turning(seed: int, most: float, count: int = 60) -> Floats:
    """(T, 4) from one random orientation to another `most` rad away, with random signs and lengths."""
    random = np.random.default_rng(seed)
    axis = random.normal(size=3)
    start = Rotation.random(rng=random)
    ends = Rotation.concatenate([start, start * Rotation.from_rotvec(most * axis / np.linalg.norm(axis) * 0.999)])
    q = Slerp([0, 1], ends)(np.linspace(0, 1, count)).as_quat()
    return q * random.choice([-1, 1], (count, 1)) * random.uniform(0.1, 9, (count, 1))


def same_rotations(a: Floats, b: Floats, atol: float = 1e-7) -> bool:
    return bool(((Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude() < atol).all())


@pytest.mark.parametrize("seed", range(10))
def test_signs_become_continuous_and_rotations_stay(seed: int) -> None:
    q = turning(seed, 3)
    result = continuous_quaternions(q)
    assert same_rotations(result, q)
    assert result[0, 3] >= 0
    assert (np.sum(result[1:] * result[:-1], axis=1) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(result, axis=1), 1, rtol=1e-14)


@pytest.mark.parametrize("seed", range(10))
def test_imaginary_parts_are_those_of_the_relative_rotation_and_lead_back(seed: int) -> None:
    q = turning(seed, 3)
    reference = q[30]
    parts = imaginary_parts(q, reference)
    relative = (Rotation.from_quat(reference).inv() * Rotation.from_quat(q)).as_quat(canonical=True)
    np.testing.assert_allclose(parts, relative[:, :3], atol=1e-12)
    assert same_rotations(quaternions_from_imaginary(parts, reference), q, 1e-6)


def test_half_a_turn_from_the_reference_is_the_bound_and_the_error_names_the_angle() -> None:
    q = Rotation.from_rotvec(np.outer(np.linspace(0, 3.5, 71), [0, 0, 1])).as_quat()
    parts = imaginary_parts(q[:63], q[0])  # 3.1 rad
    assert np.isclose(parts[-1, 2], np.sin(1.55))
    with pytest.raises(ValueError, match=re.escape("quaternions[63] is turned by 3.15")):
        imaginary_parts(q, q[0])
    assert len(imaginary_parts(q, mean_orientation(q))) == 71


def test_parts_longer_than_1_count_as_half_a_turn() -> None:
    q = quaternions_from_imaginary(np.array([[0, 3.0, 0], [1e200, 0, 0], [0, 0, 0]]), np.array([0, 0, 0, 2.0]))
    np.testing.assert_allclose(q, [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]], atol=1e-15)


def test_angles_are_those_of_scipy() -> None:
    a, b = Rotation.random(200, rng=1), Rotation.random(200, rng=2)
    np.testing.assert_allclose(geodesic_angle(a.as_quat(), -3 * b.as_quat()), (a.inv() * b).magnitude(), atol=1e-12)
    assert geodesic_angle(a.as_quat(), a.as_quat()).max() < 1e-7


@pytest.mark.parametrize("seed", range(5))
def test_the_mean_is_that_of_scipy(seed: int) -> None:
    random = np.random.default_rng(seed)
    rotations = Rotation.random(rng=random) * Rotation.from_rotvec(random.normal(0, 0.5, (20, 3)))
    mean = mean_orientation(rotations.as_quat() * random.choice([-1, 1], (20, 1)))
    assert same_rotations(mean[None], rotations.mean().as_quat()[None])
    assert mean[3] >= 0


def test_no_mean_stands_out_of_orientations_half_a_turn_apart() -> None:
    with pytest.raises(ValueError, match="no mean orientation stands out"):
        mean_orientation(np.array([[0, 0, 0, 1.0], [1, 0, 0, 0]]))
    with pytest.raises(ValueError, match="empty"):
        mean_orientation(np.zeros((0, 4)))


@pytest.mark.parametrize("bad", [[0, 0, 0, 0], [0, np.nan, 0, 1], [0, np.inf, 0, 1], [1e-12, 0, 0, 0]])
def test_quaternions_without_a_direction_are_refused_by_row(bad: list[float]) -> None:
    good = np.array([[0, 0, 0, 1.0]])
    q = np.vstack([good, [bad]])
    for call in (
        lambda: continuous_quaternions(q),
        lambda: imaginary_parts(q, good[0]),
        lambda: geodesic_angle(q, np.vstack([good, good])),
        lambda: mean_orientation(q),
    ):
        with pytest.raises(ValueError, match=re.escape("[1] has length")):
            call()
    with pytest.raises(ValueError, match="reference has length"):
        imaginary_parts(good, bad)


def test_other_shapes_and_values_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match=r"must be \(T, 4\)"):
        continuous_quaternions(np.zeros((3, 3)))
    with pytest.raises(ValueError, match="not finite"):
        quaternions_from_imaginary(np.array([[np.nan, 0, 0]]), [0, 0, 0, 1])
    with pytest.raises(ValueError, match="2 rows and b has 1"):
        geodesic_angle(np.ones((2, 4)), np.ones((1, 4)))
