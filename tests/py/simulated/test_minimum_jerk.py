"""Smooth moves from rest to rest."""

import numpy as np

from lfdcore.simulated.minimum_jerk import minimum_jerk


def test_of_all_smooth_moves_from_rest_to_rest_it_has_the_least_jerk() -> None:
    s = np.linspace(0, 1, 2001)
    bump = s**3 * (1 - s) ** 3  # keeps place, speed and acceleration at both ends
    own, *others = ((np.diff(minimum_jerk(s) + share * bump, 3) ** 2).sum() for share in (0.0, 0.5, -0.5, 0.01, -0.01))
    assert own < min(others)


def test_it_is_still_before_and_after() -> None:
    assert minimum_jerk(np.array([-3.0, 0.0, 0.5, 1.0, 9.0])).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    ends = minimum_jerk(np.array([1e-3, 1 - 1e-3]))
    assert ends[0] < 2e-8 and 1 - ends[1] < 2e-8
