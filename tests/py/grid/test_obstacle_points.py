"""Obstacle points through their Python face: what they hold, what crosses a process border, what is refused."""

import pickle

import numpy as np
import pytest

from lfdcore.grid import ObstaclePoints

POINTS = np.array([[2.0, 0.0], [0.0, 1.5]])


def test_uncertainty_is_one_a_point_and_crosses_process_borders() -> None:
    assert ObstaclePoints(POINTS).uncertainty.tolist() == [0.0, 0.0]
    unsure = ObstaclePoints(POINTS, uncertainty=np.array([0.02, 0.0]))
    again = pickle.loads(pickle.dumps(unsure))
    assert again.uncertainty.tolist() == [0.02, 0.0] and (again.points == POINTS).all()
    assert not unsure.uncertainty.flags.writeable


@pytest.mark.parametrize(
    ("uncertainty", "message"),
    [
        ([0.1], r"uncertainty has 1 values, must have 0 or 2, one a point"),
        ([0.1, -0.1], r"uncertainty is -0.1 m, must be between 0 and 100"),
        ([0.1, np.nan], r"uncertainty is nan m"),
    ],
)
def test_uncertainties_out_of_bounds_are_refused_by_name(uncertainty: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ObstaclePoints(POINTS, uncertainty=uncertainty)
