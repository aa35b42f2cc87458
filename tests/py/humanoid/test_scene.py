"""e from JSON, boxes from e, and what is neither."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import InteractionRecording
from lfdcore.errors import DataError
from lfdcore.humanoid.scene import (
    BASE_HEIGHT,
    Box,
    box_from_environment,
    box_metadata,
    box_of,
    environment_of,
    read_environment,
    standing_box,
)

LOW, TALL = standing_box(0.75, 0.34, 0.34, (0.8, 0.27)), standing_box(1.0, 0.46, 0.38, (0.7, 0.2))

# -- boxes ----------------------------------------------------------------------------------------------------------


def test_a_standing_box_stands_on_the_floor() -> None:
    box = standing_box(0.75, 0.4, 0.3, (0.8, 0.2))
    assert box.centre[2] - box.size[2] / 2 == pytest.approx(-BASE_HEIGHT)
    assert box.top == pytest.approx(0.75 - BASE_HEIGHT)


def test_boxes_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="box size must be > 0 m, got 0"):
        Box((0, 0, 0), (1, 0, 1))
    with pytest.raises(ValueError, match="that are finite"):
        Box((0, np.nan, 0), (1, 1, 1))


def test_a_box_goes_to_an_environment_and_back() -> None:
    back = box_from_environment(environment_of(TALL), LOW)
    np.testing.assert_allclose([*back.centre, *back.size], [*TALL.centre, *TALL.size])
    higher = box_from_environment({"object.height": 0.9}, LOW)
    assert (higher.size[:2], higher.size[2]) == (LOW.size[:2], 0.9)


def test_a_recording_knows_its_box_by_its_metadata() -> None:
    turned = dataclasses.replace(TALL, yaw=0.3)
    one = InteractionRecording([0.0], np.zeros((1, 0)), np.zeros((1, 0)), (), metadata=box_metadata(turned))
    assert box_of(one) == turned
    with pytest.raises(DataError, match="its metadata holds no box"):
        box_of(dataclasses.replace(one, metadata={}))
    with pytest.raises(DataError, match="its metadata holds no box"):
        box_of(dataclasses.replace(one, metadata={"box": "[1, 2]"}))


# -- the environment ------------------------------------------------------------------------------------------------


def test_an_environment_is_names_and_numbers(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_text('{"object.height": 0.8, "object.count": 2}')
    assert read_environment(tmp_path / "e.json") == {"object.height": 0.8, "object.count": 2.0}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "Expecting value"),
        ("[1]", "must be names and numbers"),
        ("{}", "must hold at least one number"),
        ('{"h": 1, "h": 2}', "key 'h' comes 2 times"),
        ('{"h": NaN}', "holds NaN, must be finite"),
        ('{"h": -Infinity}', "holds -Infinity"),
        ('{"h": 1e999}', "environment 'h' is inf, must be finite"),
        ('{"h": 1' + "0" * 400 + "}", "must be finite and within 1e"),
        ('{"h": "0.8"}', "environment 'h' is '0.8', must be a number"),
        ('{"h": true}', "environment 'h' is True, must be a number"),
        ('{"h": {"a": 1}}', "must be a number"),
        ('{" ": 1}', "has the name ' '"),
        ("[" * 100000, "recursion"),
        ('{"h": 1}' + " " * 2**20, "bytes, must be <= 1048576"),
    ],
)
def test_what_is_no_environment_is_refused_with_file_and_key(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "e.json").write_text(text)
    with pytest.raises(DataError, match=rf"e\.json: is no environment: .*{reason}"):
        read_environment(tmp_path / "e.json")


def test_an_environment_in_another_encoding_or_place_is_refused(tmp_path: Path) -> None:
    (tmp_path / "e.json").write_bytes('{"h": 1}'.encode("utf-16"))
    with pytest.raises(DataError, match="utf-8"):
        read_environment(tmp_path / "e.json")
    with pytest.raises(DataError, match="no regular file"):
        read_environment(tmp_path)
