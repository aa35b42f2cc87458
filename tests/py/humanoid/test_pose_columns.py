"""PoseColumns: there and back again, and differences against SciPy's rotations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from lfdcore.humanoid.pose_columns import PoseColumns, continuous_columns

NAMES = ("a.x", "a.qx", "a.qy", "a.qz", "a.qw", "grip", "b.qx", "b.qy", "b.qz", "b.qw")
QUATERNION = ("q.qx", "q.qy", "q.qz", "q.qw")
parts = arrays(np.float64, (5, 8), elements=st.floats(-0.57, 0.57))  # of length < 1: less than half a turn
rotations = st.integers(0, 2**20).map(lambda seed: Rotation.random(2 * 5, random_state=seed).as_quat())
references = st.integers(0, 2**20).map(
    lambda seed: tuple(map(tuple, Rotation.random(2, random_state=seed).as_quat().tolist()))
)


@given(parts, references)
def test_what_was_learned_comes_back_from_what_is_recorded(learned: np.ndarray, both: tuple) -> None:
    """The samples of a series lie close together: jumps of more than half a turn are another rotation's."""
    columns = PoseColumns(NAMES, both)
    steady = learned[:1] + 0.1 * (learned - learned[:1])
    recorded = columns.recorded(steady)
    assert recorded.shape == (5, len(NAMES))
    for at in columns.quaternions:
        np.testing.assert_allclose(np.linalg.norm(recorded[:, at : at + 4], axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(columns.learned(recorded), steady, atol=1e-9)


@given(rotations)
def test_differences_are_scipys_rotations_whatever_the_signs(both: np.ndarray) -> None:
    columns, (a, b) = PoseColumns(QUATERNION, ((0.0, 0.0, 0.0, 1.0),)), (both[:5], both[5:])
    between = Rotation.from_quat(b).inv() * Rotation.from_quat(a)
    half = between.magnitude() / 2
    found = columns.difference(a, b)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), np.sin(half), atol=1e-9)
    sure = half < np.pi / 2 - 1e-3  # of half a turn the axis may point both ways
    np.testing.assert_allclose(
        found[sure], (between.as_rotvec() / (2 * half[:, None]) * np.sin(half)[:, None])[sure], atol=1e-9
    )
    np.testing.assert_allclose(columns.difference(-a, b)[sure], found[sure], atol=1e-12)
    np.testing.assert_allclose(columns.difference(a, a), 0, atol=1e-9)


def test_differences_of_other_columns_are_subtracted() -> None:
    columns = PoseColumns(("a", *QUATERNION, "b"), ((0.0, 0.0, 0.0, 1.0),))
    first, second = np.array([[1.0, 0, 0, 0, 1, 2.0]]), np.array([[4.0, 0, 0, 0, 1, 0.5]])
    np.testing.assert_allclose(columns.difference(first, second), [[-3, 0, 0, 0, 1.5]])


@given(rotations)
def test_continuous_columns_are_the_same_rotations_side_by_side(quaternions: np.ndarray) -> None:
    made = continuous_columns(("x", *QUATERNION), np.column_stack([np.arange(10.0), quaternions]))
    np.testing.assert_array_equal(made[:, 0], np.arange(10.0))
    np.testing.assert_allclose(np.abs((made[:, 1:] * quaternions).sum(axis=1)), 1, atol=1e-9)
    assert ((made[1:, 1:] * made[:-1, 1:]).sum(axis=1) >= -1e-12).all()


def test_the_reference_of_a_motion_is_in_its_middle() -> None:
    angles = np.linspace(0, 2.0, 41)
    motion = Rotation.from_rotvec(np.outer(angles, [0, 0, 1])).as_quat()
    columns = PoseColumns.of(QUATERNION, [motion[:20], -motion[20:]])
    np.testing.assert_allclose(columns.references[0], Rotation.from_euler("z", 1.0).as_quat(), atol=1e-9)
    np.testing.assert_allclose(columns.learned(motion)[:, 2], np.sin((angles - 1) / 2), atol=1e-9)
    np.testing.assert_allclose(columns.mean(motion)[0], Rotation.from_euler("z", 1.0).as_quat(), atol=1e-9)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("a.qx",), "column a.qx stands alone"),
        (("a.qw", "a.qx", "a.qy", "a.qz"), "column a.qw stands alone"),
        (("a.qx", "a.qy", "b.qz", "a.qw"), "stands alone"),
        (("a.qx", "a.qy", "a.qz", "a.x", "a.qw"), "stands alone"),
        (QUATERNION[:3], "stands alone"),
    ],
)
def test_parts_of_a_quaternion_are_refused(names: tuple[str, ...], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        PoseColumns.of(names, [np.ones((3, len(names)))])


@pytest.mark.parametrize(
    "bad",
    [
        (),
        ((0, 0, 0, 1), (0, 0, 0, 1)),
        ((0, 0, 0, 0),),
        ((0, 0, 0, 2),),
        ((0, 0, 0, np.nan),),
        ((0, 0, 1),),
        (("a",) * 4,),
    ],
)
def test_references_that_are_no_rotations_are_refused(bad: tuple) -> None:
    with pytest.raises(ValueError, match="reference"):
        PoseColumns(QUATERNION, bad)


def test_motions_that_do_not_fit_are_refused() -> None:
    columns = PoseColumns(QUATERNION, ((0.0, 0.0, 0.0, 1.0),))
    for call, said in (
        (lambda: PoseColumns.of(QUATERNION, []), r"shapes \[\], must be one or more \(T, 4\)"),
        (lambda: PoseColumns.of(QUATERNION, [np.ones(4)]), r"shapes \[\(4,\)\]"),
        (lambda: PoseColumns.of(QUATERNION, [np.zeros((3, 4))]), "length 0"),
        (lambda: columns.learned(np.ones((3, 5))), r"must be \(T, 4\)"),
        (lambda: columns.learned(np.zeros((3, 4))), "length 0"),
        (lambda: columns.learned(np.full((3, 4), np.nan)), "length nan"),
        (lambda: columns.recorded(np.ones((3, 4))), r"must be \(T, 3\)"),
        (lambda: columns.recorded(np.full((3, 3), np.inf)), "not finite"),
        (lambda: columns.difference(np.ones((3, 4)), np.ones((2, 4))), r"must both be \(T, 4\)"),
        (lambda: columns.difference(np.ones((2, 4)), np.zeros((2, 4))), "no rotation"),
    ):
        with pytest.raises(ValueError, match=said):
            call()


def test_nothing_seen_is_nothing_learned() -> None:
    columns = PoseColumns(QUATERNION, ((0.0, 0.0, 0.0, 1.0),))
    assert columns.learned(np.zeros((0, 4))).shape == (0, 3)
    assert columns.recorded(np.zeros((0, 3))).shape == (0, 4)
