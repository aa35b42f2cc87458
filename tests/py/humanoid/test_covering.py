"""The covering verdict: what is covered, what touches, and what must hold of it whatever the motion."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lfdcore.humanoid.contact import Capsule
from lfdcore.humanoid.covering import DRAPE, covering_verdict
from lfdcore.humanoid.scene import Box
from sweeps import BOX, RIGHT, boxes, paths, points, sweep

Array = np.ndarray

# -- the swept mouth ------------------------------------------------------------------------------------------------


@given(paths, points, boxes, st.floats(0.2, 1.0), st.floats(0.2, 1.0), st.floats(0.2, 1.0))
def test_a_smaller_box_never_makes_a_collision(path: Array, right: tuple, box: Box, sx, sy, sz) -> None:  # type: ignore[no-untyped-def]
    depth, width, height = box.size
    smaller = dataclasses.replace(box, size=(sx * depth, sy * width, sz * height))
    assert not covering_verdict(path, right, smaller).collided or covering_verdict(path, right, box).collided


@given(paths, points, boxes, st.floats(0, 6.28), st.floats(0, 3))
def test_moving_the_box_away_never_makes_a_collision(
    path: Array, right: tuple, box: Box, heading: float, further: float
) -> None:
    away = np.array([np.cos(heading), np.sin(heading), 0.0])
    swept = np.vstack([path, right]) @ away  # beyond its last point nothing is ever near again
    reach = np.linalg.norm(box.size) / 2
    clear = box.moved(away * max(0.0, swept.max() + reach + 0.021 - np.array(box.centre) @ away))
    if not covering_verdict(path, right, clear).collided:
        assert not covering_verdict(path, right, clear.moved(further * away)).collided
    assert not covering_verdict(path, right, clear).collided


@given(paths, points, boxes, st.floats(-3, 3), points)
def test_the_verdict_is_the_same_from_wherever_one_looks(path, right, box, turn, shift) -> None:  # type: ignore[no-untyped-def]
    assume(np.hypot(*(path[-1, :2] - np.asarray(right)[:2])) > 1e-3)  # `past` needs a direction
    cos, sin = np.cos(turn), np.sin(turn)
    rotation = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    x, y, z = rotation @ box.centre + shift
    there = covering_verdict(
        path @ rotation.T + shift, rotation @ right + shift, Box((x, y, z), box.size, box.yaw + turn)
    )
    here = covering_verdict(path, right, box)
    assert there.contact.distance == pytest.approx(here.contact.distance, abs=1e-9)
    assert there.past == pytest.approx(here.past, abs=1e-9)
    if abs(here.contact.distance - 0.02) > 1e-6:
        assert there.collided == here.collided


@given(paths, points, boxes)
def test_the_verdict_is_the_same_in_a_mirror(path: Array, right: tuple, box: Box) -> None:
    flip = np.array([1, -1, 1])
    x, y, z = box.centre
    there = covering_verdict(path * flip, np.array(right) * flip, Box((x, -y, z), box.size, -box.yaw))
    here = covering_verdict(path, right, box)
    assert there.contact.distance == pytest.approx(here.contact.distance, abs=1e-9)
    assert (there.covered, there.part) == (here.covered, here.part)


# -- covered or not -------------------------------------------------------------------------------------------------


def test_a_sweep_over_and_past_the_object_covers_it() -> None:
    verdict = covering_verdict(sweep(), RIGHT, BOX)
    assert verdict.success, verdict.reason
    assert verdict.contact.first is None
    assert verdict.past > 0


@pytest.mark.parametrize("by", [(0, 0.3, 0), (0, -0.3, 0), (0.3, 0, 0), (-0.3, 0, 0)])
def test_a_box_30_cm_to_the_side_changes_the_verdict(by: tuple) -> None:
    verdict = covering_verdict(sweep(), RIGHT, BOX.moved(by))
    assert not verdict.success


def test_the_box_moved_left_is_neither_passed_nor_spared_by_a_low_end() -> None:
    verdict = covering_verdict(sweep(end=-0.1), RIGHT, BOX.moved((0, 0.3, 0)))
    assert verdict.collided
    assert not verdict.covered


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"beyond": -0.05}, "short of the object's far side"),
        ({"x": 0.5}, "does not lie across the object"),
        ({"end": DRAPE + 0.01}, "above the top, must be <= 0.15 m"),
    ],
)
def test_a_sweep_that_falls_short_says_why(changes: dict[str, float], reason: str) -> None:
    verdict = covering_verdict(sweep(**changes), RIGHT, BOX)
    assert not verdict.covered
    assert reason in verdict.reason


def test_the_clearance_is_kept_behind_the_object_too() -> None:
    exact, kept = (covering_verdict(sweep(), RIGHT, BOX, clearance=clearance) for clearance in (0.0, 0.02))
    assert kept.past == pytest.approx(exact.past - 0.02)


def test_a_motion_that_begins_behind_the_object_or_ends_below_its_top_does_not_cover_it() -> None:
    backwards = np.vstack([sweep()[-1:], sweep()])
    assert "does not begin short of the object" in covering_verdict(backwards, RIGHT, BOX).reason
    through = sweep()
    through[:, 2] = -0.4
    verdict = covering_verdict(through, (0.72, -0.32, -0.4), BOX)
    assert (verdict.covered, verdict.collided) == (False, True)
    assert "below the object's top" in verdict.reason
    assert "upright" in covering_verdict([RIGHT], RIGHT, BOX).reason


@pytest.mark.parametrize(("margin", "collided"), [(0.0201, False), (0.0199, True), (0.0, True), (-0.2, True)])
def test_the_clearance_is_2_cm(margin: float, collided: bool) -> None:
    verdict = covering_verdict(sweep(margin=margin, end=margin), RIGHT, BOX)
    assert verdict.collided == collided
    assert verdict.contact.distance == pytest.approx(max(margin, 0), abs=1e-6)


def test_where_and_when_it_touches_is_said() -> None:
    low = sweep()
    low[30:33, 2] = BOX.top - 0.05
    contact = covering_verdict(low, RIGHT, BOX).contact
    assert contact.distance == 0
    assert contact.first is not None
    assert 29 < contact.first <= contact.sample <= 33
    assert contact.point[2] <= BOX.top + 1e-9


def test_a_collision_between_two_samples_is_seen() -> None:
    over = np.array([[0.78, -0.2, 0.3], [0.78, 0.8, 0.3], [0.78, -0.2, -0.9]])  # the last move cuts through the box
    assert covering_verdict(over, (0.78, -0.3, 0.3), BOX).contact.distance == 0


def test_an_arm_that_touches_counts_and_is_named() -> None:
    path = sweep()
    elbow = path - np.array([0.3, 0.0, -0.1])
    free, low = Capsule(elbow, path, 0.05), Capsule(path - [0.15, 0.0, 0.3], path, 0.05)
    assert covering_verdict(path, RIGHT, BOX, links=[free]).success
    verdict = covering_verdict(path, RIGHT, BOX, links=[free, low])
    assert (verdict.collided, verdict.part) == (True, "link 2")
    assert (verdict.success, verdict.success_of_mouth) == (False, True)
    assert verdict.mouth == covering_verdict(path, RIGHT, BOX).contact
    assert [link.touches for link in verdict.links] == [False, True]


def test_further_columns_are_ignored() -> None:
    pose = np.hstack([sweep(), np.full((60, 4), np.nan)])
    assert covering_verdict(pose, RIGHT, BOX).success


def test_an_arm_inside_the_object_collides_however_small_the_clearance() -> None:
    path, middle = sweep(), np.tile(BOX.centre, (60, 1))
    verdict = covering_verdict(path, RIGHT, BOX, clearance=0, links=[Capsule(middle, middle, 0.05)])
    assert (verdict.collided, verdict.success_of_mouth) == (True, True)


# -- bad input ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("trajectory", "right", "reason"),
    [
        (np.zeros((0, 3)), RIGHT, r"trajectory has shape \(0, 3\)"),
        (np.zeros((5, 2)), RIGHT, r"trajectory has shape \(5, 2\)"),
        (np.zeros(3), RIGHT, r"trajectory has shape \(3,\)"),
        (np.full((5, 3), np.nan), RIGHT, "trajectory at sample 0 is .*nan.* must be finite"),
        (np.zeros((5, 3)), (0, 0), r"right_gripper has shape \(1, 2\)"),
        (np.zeros((5, 3)), np.zeros((2, 3)), r"right_gripper has shape \(2, 3\)"),
        (np.zeros((5, 3)), (0, 0, np.inf), "right_gripper at sample 0"),
        (np.array([[0, 0, 0], [1e5, 0, 0]]), RIGHT, "the segment moves 100000 m, must be <= 200 m"),
    ],
)
def test_motions_that_are_none_are_refused(trajectory: Array, right: object, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        covering_verdict(trajectory, right, BOX)  # type: ignore[arg-type]


def test_a_link_of_other_samples_than_the_trajectory_is_refused() -> None:
    with pytest.raises(ValueError, match="link 1 has 5 samples, must be 60"):
        covering_verdict(sweep(), RIGHT, BOX, links=[Capsule(sweep()[:5], sweep()[:5], 0.1)])
