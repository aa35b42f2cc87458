"""Every beam of a scan has a length to learn from."""

import numpy as np
import pytest

from lfdcore.grid import read_beams
from lfdcore.wheelchair.primitives.beam_lengths import filled_lengths, measured_beams


def filled(ranges: np.ndarray, range_min: float = 0.0, range_max: float = 30.0) -> np.ndarray:
    return filled_lengths(*read_beams(np.asarray(ranges, np.float32), range_min, range_max))


def test_a_beam_that_measured_nothing_sees_as_far_as_the_nearest_that_did():
    nan, inf = np.nan, np.inf
    ranges = [nan, 1.0, nan, 0.125, 4.0, inf, -inf, 40.0, -3.0, 0.0, 0.5]
    expected = [1.0, 1.0, 1.0, 4.0, 4.0, 30.0, 0.25, 30.0, 30.0, 0.5, 0.5]
    assert filled(ranges, 0.25).tolist() == expected
    np.testing.assert_array_equal(filled([ranges, ranges[::-1]], 0.25)[0], expected)


def test_a_scan_without_any_measurement_sees_nothing():
    rows = [[np.nan, 2.0], [np.nan, 0.125]]
    assert filled(rows, 0.25).tolist() == [[2.0, 2.0], [0.0, 0.0]]
    lengths, hit = read_beams(np.array(rows, np.float32), 0.25, 30.0)
    assert measured_beams(lengths, hit).tolist() == [[False, True], [False, False]]


def test_a_hit_at_the_laser_is_a_measurement():
    assert filled([0.0, np.nan, np.nan, 3.0]).tolist() == [0.0, 0.0, 3.0, 3.0]


def test_filling_leaves_what_it_was_given_as_it_is():
    lengths, hit = read_beams(np.array([np.nan, 2.0], np.float32), 0.0, 30.0)
    filled_lengths(lengths, hit)
    assert lengths.tolist() == [0.0, 2.0]


def test_scans_without_beams_are_refused():
    with pytest.raises(ValueError, match="0 beams"):
        filled(np.zeros(0))
