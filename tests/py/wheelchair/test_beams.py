"""The beams of a laser: which covers a place, where they end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lfdcore.geometry import Pose2, wrap_angle
from lfdcore.grid import read_beams
from lfdcore.wheelchair.beams import BeamGeometry


@settings(max_examples=200, deadline=None)
@given(
    beams=st.integers(1, 720),
    span=st.floats(0.1, 6.2),
    sign=st.sampled_from([-1, 1]),
    point=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
    yaw=st.floats(-3, 3),
)
def test_the_covering_beam_is_the_nearest_in_angle(beams, span, sign, point, yaw):
    T = Pose2(0.3, -0.1, yaw)
    increment = sign * span / max(beams - 1, 1)
    geometry = BeamGeometry(beams, -sign * span / 2, increment, T)
    beam, distance, _ = geometry.locate(np.array([point]))
    local = T.inverse().transform(np.array([point]))[0]
    angles = -sign * span / 2 + increment * np.arange(beams)
    off = np.abs(wrap_angle(angles - np.arctan2(local[1], local[0])))
    assert off[beam[0]] <= off.min() + 1e-9
    assert distance[0] == pytest.approx(np.hypot(*local))


def test_beams_end_where_they_hit_and_only_there():
    ranges = np.array([np.nan, -np.inf, np.inf, 0, -3, 0.125, 0.25, 2, 8, 40], np.float32)
    geometry = BeamGeometry(len(ranges), -0.9, 0.2, Pose2(0.7, 0.0, 0.0))
    hits = geometry.hits(*read_beams(ranges, 0.25, 8.0))
    angles, lengths = -0.9 + 0.2 * np.array([1, 6, 7]), np.array([0.25, 0.25, 2.0])
    np.testing.assert_allclose(hits, np.stack([0.7 + lengths * np.cos(angles), lengths * np.sin(angles)], axis=1))


@pytest.mark.parametrize("side", [0.0, -0.0])
def test_what_lies_straight_behind_is_at_plus_pi(side):
    """The convention's interval is (-pi, pi]: of two beams equally far in angle that of the larger angle."""
    geometry = BeamGeometry(181, -np.pi / 2, np.pi / 180, Pose2())
    beam, _, inside = geometry.locate(np.array([[-1.0, side]]))
    assert (beam[0], inside[0]) == (180, False)


def test_a_laser_outside_the_window_or_without_beams_is_refused():
    with pytest.raises(ValueError, match="outside the local window"):
        BeamGeometry(181, -1.5, 0.01, Pose2(3.0, 0, 0))
    with pytest.raises(ValueError, match="0 beams"):
        BeamGeometry(0, -1.5, 0.01, Pose2())
