"""The path error of real logs: the figures that its definition (a separate reference program) gives."""

from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import open_log
from lfdcore.study.prediction.path_error import ARC, at_arc_lengths, constant_arc, path_errors, path_samples, straight


@pytest.mark.realdata
def test_baselines_on_the_last_thirty_percent_of_freiburg_079_are_the_published_ones(data_folder: Path) -> None:
    log = open_log(data_folder / "logs" / "freiburg-079-corrected.log.gz")
    samples = path_samples(log.share(0.7, 1.0))
    assert len(samples) == 768
    for baseline, expected in ((straight, (0.111, 0.311, 0.438)), (constant_arc, (0.095, 0.339, 0.510))):
        predicted = baseline(samples.velocity)
        means = [path_errors(predicted, samples.driven, reach).mean() for reach in (1.0, 2.0, 2.5)]
        assert means == pytest.approx(expected, abs=5e-4)


def test_an_arc_without_rotation_is_the_straight_line() -> None:
    velocity = np.array([[0.5, 0.0]])
    assert np.abs(constant_arc(velocity) - straight(velocity)).max() < 1e-5


def test_the_error_of_the_driven_path_itself_is_zero_and_shapes_must_agree() -> None:
    path = straight(np.ones((3, 2)))
    assert path_errors(path, path, 2.5).tolist() == [0, 0, 0]
    with pytest.raises(ValueError, match=r"shape \(2, 25, 2\), must be \(3, 25, 2\)"):
        path_errors(path[:2], path, 2.5)


def test_a_short_path_goes_on_along_its_last_direction() -> None:
    path = at_arc_lengths(np.array([[1.0, 0.0], [1.0, 0.5]]))
    assert path[-1] == pytest.approx([1.0, 1.5])
    assert np.allclose(path[:10], np.stack([ARC[:10], np.zeros(10)], 1))


def test_a_path_without_length_is_refused() -> None:
    with pytest.raises(ValueError, match=r"length 0\.0 m"):
        at_arc_lengths(np.zeros((3, 2)))
