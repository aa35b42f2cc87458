"""Safe joystick: the inverse of joystick_to_twist, and both sticks of a log side by side."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lfdcore.datasets import DriveLog, joystick_pairs, noted_limits, safe_joystick, twist_to_joystick
from lfdcore.datasets.safe_joystick import limits_note
from lfdcore.errors import DataError
from lfdcore.geometry import MotionLimits
from lfdcore.simulation import joystick_to_twist

LIMITS = MotionLimits(max_linear=0.9, max_reverse=0.3, max_angular=1.1)
axes = st.floats(-1, 1)


def log(**changes) -> DriveLog:  # type: ignore[no-untyped-def]
    some = DriveLog(
        scan_stamp=np.zeros(0),
        ranges=np.zeros((0, 1), np.float32),
        joystick_stamp=np.array([0.1, 0.2, 0.3]),
        joystick=np.array([[0.5, 0.0], [0.6, 0.1], [0.7, 0.2]]),
        command_stamp=np.array([0.0, 0.1, 0.25, 0.3]),
        command=np.array([[0, 0], [0.45, 0], [-0.15, 0.55], [0.9, -1.1]]),
        metadata=limits_note(LIMITS),
        name="some",
    )
    return dataclasses.replace(some, **changes)


@given(axes, axes)
def test_the_stick_that_asks_for_what_a_stick_asks_for_is_that_stick(forward: float, left: float) -> None:
    twist = joystick_to_twist(forward, left, LIMITS)
    assert twist_to_joystick([*twist], LIMITS) == pytest.approx([forward, left], abs=1e-12)


@given(st.floats(-0.3, 0.9), st.floats(-1.1, 1.1))
def test_the_twist_that_the_stick_for_a_twist_asks_for_is_that_twist(linear: float, angular: float) -> None:
    stick = twist_to_joystick([linear, angular], LIMITS)
    assert [*joystick_to_twist(*map(float, stick), LIMITS)] == pytest.approx([linear, angular], abs=1e-12)


def test_many_twists_at_once_are_as_each_alone() -> None:
    twists = np.random.default_rng(0).uniform(-0.3, 0.3, (4, 5, 2))
    alone = [[twist_to_joystick(twist, LIMITS) for twist in row] for row in twists]
    np.testing.assert_array_equal(twist_to_joystick(twists, LIMITS), alone)
    assert twist_to_joystick(np.zeros((0, 2)), LIMITS).shape == (0, 2)


@pytest.mark.parametrize(
    ("twist", "says"),
    [
        ([0.91, 0.0], r"twist is 0.91 m/s, 0.0 rad/s, must lie within -0.3..0.9 m/s and \+-1.1 rad/s"),
        ([[0.0, 0.0], [-0.31, 0.0]], "twist is -0.31 m/s"),
        ([0.0, -1.2], "-1.2 rad/s"),
        ([np.nan, 0.0], "must be finite"),
        ([0.0, 0.0, 0.0], r"shape \(3,\), must be \(..., 2\)"),
        (0.0, r"shape \(\), must be"),
    ],
)
def test_a_twist_that_no_stick_asks_for_is_refused(twist, says: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=says):
        twist_to_joystick(twist, LIMITS)


def test_pairs_hold_the_input_as_last_given_beside_the_safe_one_from_the_first_input_on() -> None:
    pairs = joystick_pairs(log())
    assert pairs.stamp.tolist() == [0.1, 0.25, 0.3]
    np.testing.assert_allclose(pairs.raw, [[0.5, 0], [0.6, 0.1], [0.7, 0.2]])
    np.testing.assert_allclose(pairs.safe, [[0.5, 0], [-0.5, 0.5], [1, -1]], atol=1e-12)
    assert safe_joystick(log()).shape == (4, 2)


def test_a_log_notes_the_limits_that_its_chair_had_and_given_ones_come_first() -> None:
    noted = noted_limits(log())
    assert (noted.max_linear, noted.max_reverse, noted.max_angular) == (0.9, 0.3, 1.1)
    assert safe_joystick(log(), MotionLimits(max_linear=1.8, max_angular=2.2))[3] == pytest.approx([0.5, -0.5])


@pytest.mark.parametrize("note", ["", "1 2", "1 2 x", "1 2 0", "1 2 nan", "1 -2 3"])
def test_a_note_that_is_no_limits_is_a_broken_log(note: str) -> None:
    with pytest.raises(DataError, match="full_stick of log 'some' is"):
        safe_joystick(log(metadata={"full_stick": note}))


def test_logs_without_what_is_needed_are_refused_by_name() -> None:
    nothing = {"command_stamp": np.zeros(0), "command": np.zeros((0, 2))}
    with pytest.raises(ValueError, match=r"does not say what full stick means"):
        joystick_pairs(log(metadata={}))
    with pytest.raises(ValueError, match="'some' has no command"):
        joystick_pairs(log(**nothing))
    with pytest.raises(ValueError, match="'some' has no joystick"):
        joystick_pairs(log(joystick_stamp=np.zeros(0), joystick=np.zeros((0, 2))))
    with pytest.raises(ValueError, match=r"twist is 0\.9 m/s"):
        safe_joystick(log(), MotionLimits(max_linear=0.5))
