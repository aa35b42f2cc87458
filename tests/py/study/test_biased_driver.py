"""A driver whose stick points beside what is meant."""

import math

import numpy as np
import pytest

from lfdcore.geometry import Twist2
from lfdcore.simulated.biased_driver import BiasedDriver
from lfdcore.simulated.courses import office
from lfdcore.simulated.drivers import AbleDriver


def test_a_biased_driver_means_what_an_able_one_means_and_points_beside_it() -> None:
    able, biased = AbleDriver(office()), BiasedDriver(office(), 0.3)
    start = office().start
    for tick in range(20):
        meant = able.act(tick / 10, start, Twist2(), False).desired
        given = biased.act(tick / 10, start, Twist2(), False)
        np.testing.assert_array_equal(given.desired, meant)
        turned = math.atan2(given.joystick[1], given.joystick[0]) - math.atan2(meant[1], meant[0])
        assert turned == pytest.approx(0.3)
    for bias in (2.0, math.nan):
        with pytest.raises(ValueError, match="bias is"):
            BiasedDriver(office(), bias)
