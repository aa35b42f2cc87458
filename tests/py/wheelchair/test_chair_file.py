"""The real chair's file, and the manual button; the link itself is tested on the simulated chip."""

import copy
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.hardware import EncoderOdometry, WheelEncoders
from lfdcore.wheelchair.assistants import Supervised
from lfdcore.wheelchair.chair_file import read_chair_file
from lfdcore.wheelchair.manual_override import ManualOverride
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation

PAGE = Path(__file__).parents[3] / "docs" / "on-your-robot.md"
TOLD: dict[str, Any] = json.loads(re.findall(r"```json\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)[0])


def written(folder: Path, told: object) -> Path:
    path = folder / "chair.json"
    path.write_text(json.dumps(told))
    return path


def test_the_file_of_the_page_is_the_thesiss_chair(tmp_path: Path) -> None:
    told = read_chair_file(written(tmp_path, TOLD))
    assert told.geometry(told.scanners["front"].T_base_laser, 0.025) == ChairGeometry.thesis(Pose2(0.7, 0.0, 0.0))
    assert told.wheels.track == 0.56


@pytest.mark.parametrize("part", sorted(TOLD))
def test_nothing_that_is_missing_is_assumed(part: str, tmp_path: Path) -> None:
    inside = TOLD[part]["front"] if part == "scanners" else TOLD[part]
    for name in inside:
        told = copy.deepcopy(TOLD)
        del (told[part]["front"] if part == "scanners" else told[part])[name]
        with pytest.raises(DataError, match=rf"{part}(\.front)? lacks {name}"):
            read_chair_file(written(tmp_path, told))
    told = {key: value for key, value in TOLD.items() if key != part}
    with pytest.raises(DataError, match=f"lacks {part}"):
        read_chair_file(written(tmp_path, told))


def test_a_scanner_that_is_tilted_or_that_there_is_none_of_is_refused(tmp_path: Path) -> None:
    told = copy.deepcopy(TOLD)
    told["scanners"]["front"]["roll_degrees"] = 10
    with pytest.raises(DataError, match=r"scanners\.front\.roll_degrees is 10"):
        read_chair_file(written(tmp_path, told))
    for none in ({}, [], None):
        with pytest.raises(DataError, match="scanners is"):
            read_chair_file(written(tmp_path, {**TOLD, "scanners": none}))


@pytest.mark.parametrize("value", ["1", None, True, [1], 10**400, "x" * 100_000])
def test_what_is_no_number_is_named(value: object, tmp_path: Path) -> None:
    told = copy.deepcopy(TOLD)
    told["wheels"]["track"] = value
    with pytest.raises(DataError, match=r"wheels\.track"):
        read_chair_file(written(tmp_path, told))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"errors": {"latency": 5.0, "odometry_error": 0.02}}, r"errors: latency is 5"),
        ({"wheels": {**TOLD["wheels"], "left_radius": -1}}, r"wheels: left_radius is -1 m"),
        ({"footprint": {**TOLD["footprint"], "front": -1}}, r"footprint.s front is -1"),
        (
            {
                "scanners": {
                    "front": TOLD["scanners"]["front"],
                    "rear": {**TOLD["scanners"]["front"], "range_noise": -1},
                }
            },
            "rear.range_noise is -1",
        ),
        ({"scanners": {"front": {**TOLD["scanners"]["front"], "x": 11}}}, r"scanners\.front or errors: T_base_laser"),
    ],
)
def test_what_is_out_of_range_names_file_and_part(change: dict[str, Any], why: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=rf"chair\.json: .*{why}"):
        read_chair_file(written(tmp_path, TOLD | change))


def test_whole_turns_are_none_and_a_key_comes_once(tmp_path: Path) -> None:
    told = copy.deepcopy(TOLD)
    told["scanners"]["front"]["yaw_degrees"] = 720
    assert read_chair_file(written(tmp_path, told)).scanners["front"].T_base_laser.yaw == pytest.approx(0)
    for text in ('{"footprint": {}, "footprint": {}}', '{"limits": NaN}', "[" * 10_000):
        (tmp_path / "chair.json").write_text(text)
        with pytest.raises(DataError, match="is no JSON file"):
            read_chair_file(tmp_path / "chair.json")


def test_a_name_too_many_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="colour"):
        read_chair_file(written(tmp_path, {**TOLD, "colour": "red"}))


WHEELS = WheelEncoders(left_radius=0.2, right_radius=0.2, track=0.5, edges_per_turn=1000)
EDGE = 2 * math.pi * 0.2 / 1000


def test_odometry_of_a_quarter_turn_on_the_spot_and_a_metre_ahead() -> None:
    odometry = EncoderOdometry(WHEELS)
    odometry.update(0.0, 0, 0)
    quarter = math.pi / 2 * 0.5 / 2 / EDGE
    metre = 1 / EDGE
    odometry.update(1.0, -round(quarter), round(quarter))
    odometry.update(2.0, -round(quarter) + round(metre), round(quarter) + round(metre))
    assert odometry.pose.yaw == pytest.approx(math.pi / 2, abs=3e-3)
    assert (odometry.pose.x, odometry.pose.y) == pytest.approx((0.0, 1.0), abs=4e-3)
    assert odometry.twist.linear == pytest.approx(1.0, abs=2e-3)


def test_counts_that_wrap_around_are_no_jump() -> None:
    odometry = EncoderOdometry(WHEELS)
    odometry.update(0.0, 2**31 - 5, -(2**31) + 5)
    odometry.update(0.2, -(2**31) + 4, 2**31 - 4)
    assert odometry.pose.yaw == pytest.approx(-18 * EDGE / 0.5)
    assert odometry.pose.x == pytest.approx(0, abs=1e-9)


def test_wheels_of_nobody_are_refused() -> None:
    with pytest.raises(ValueError, match="left_radius is 0 m"):
        WheelEncoders()


class Saying:
    """An assistant whose command tells that it was asked."""

    chair = ChairGeometry.thesis()

    def __init__(self, name: str) -> None:
        self.name = name
        self.resets = 0

    def reset(self) -> None:
        self.resets += 1

    def update(self, observation: Observation) -> Assistance:
        return Assistance(Twist2(0.4, 0.0), self.name)


@pytest.mark.hazard("The manual button is pressed", "whoever takes over begins anew, at neutral", each="2 changes")
def test_the_manual_button_puts_the_assistant_aside_once_the_stick_was_at_neutral(seen: Observation) -> None:
    button = {"pressed": False}
    learned = Saying("learned")
    override = ManualOverride(learned, lambda: button["pressed"])
    held = replace(seen, joystick=(1.0, 0.0))
    assert override.update(held).mode == "learned"
    for pressed, taking_over in ((True, "user"), (False, "learned")):
        button["pressed"] = pressed
        for _ in range(3):
            waiting = override.update(held)
            assert (waiting.command, waiting.mode) == (Twist2(), "silent")
        assert override.update(seen).mode == taking_over
    assert learned.resets == 1


def test_a_manual_button_that_flickers_lets_nothing_move(seen: Observation) -> None:
    presses = iter([True, False] * 20)
    override = ManualOverride(Saying("learned"), lambda: next(presses))
    held = replace(seen, joystick=(1.0, 0.0))
    assert {override.update(held).mode for _ in range(40)} == {"silent"}


def test_what_is_a_fault_is_not_ended_by_the_manual_button(seen: Observation) -> None:
    pressed = False
    override = ManualOverride(Supervised(ChairGeometry.thesis()), lambda: pressed)
    assert override.update(replace(seen, joystick=(2.0, 0.0))).mode == "fault"
    pressed = True
    held = replace(seen, stamp=0.1, joystick=(1.0, 0.0))
    assert override.update(held).command == Twist2()


@pytest.fixture
def seen() -> Observation:
    return Observation(
        stamp=0.0,
        scan=LaserScan([2.0] * 181, -math.pi / 2, math.pi / 180),
        scan_stamp=0.0,
        pose=Pose2(),
        twist=Twist2(),
        odometry_stamp=0.0,
        joystick=(0.0, 0.0),
        joystick_stamp=0.0,
    )
