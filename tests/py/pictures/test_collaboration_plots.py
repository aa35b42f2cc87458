"""The picture of a collaboration: dots where the partner was seen, the inferred motion, its spread, and now."""

import numpy as np
import pytest

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationInference, CollaborationModel
from lfdcore.pictures.collaboration import collaboration_figure
from lfdcore.pictures.style import png
from lfdcore.simulated.covering import CoveredObject, demonstrate_covering

OBJECTS = (CoveredObject("stool", 0.75, 0.34, 0.34), CoveredObject("cabinet", 0.90, 0.40, 0.38))
Inferred = tuple[CollaborationModel, CollaborationInference, InteractionRecording]


@pytest.fixture(scope="module")
def inferred() -> Inferred:
    ones = [demonstrate_covering(one, [200, k, i]) for k, one in enumerate(OBJECTS) for i in range(3)]
    model = CollaborationModel.fit(ones, CollaborationConfig(steps=100))
    seen = demonstrate_covering(OBJECTS[0], 300).partial(seconds=4)
    return model, model.infer(seen, {"object.height": 0.8}), seen


def test_the_partner_is_dots_where_seen_and_a_line_where_expected(inferred: Inferred) -> None:
    model, inference, seen = inferred
    partner = collaboration_figure(*inferred).axes[0]
    lines = {line.get_label(): line for line in partner.lines}
    for k, name in enumerate(model.partner_names):
        np.testing.assert_array_equal(lines[name].get_ydata(), inference.partner_motion()[:, k])
    dots = [line for line in partner.lines if line.get_marker() == "."]
    assert len(dots) == len(model.partner_names)
    np.testing.assert_array_equal(dots[0].get_ydata(), seen.partner[:, 0])
    assert dots[0].get_xdata()[-1] == pytest.approx(seen.duration)


def test_the_robot_has_its_places_with_two_standard_deviations_and_no_quaternions(inferred: Inferred) -> None:
    _, inference, _ = inferred
    robot = collaboration_figure(*inferred).axes[1]
    named = [line for line in robot.lines if not str(line.get_label()).startswith("_")]
    assert [line.get_label() for line in named] == ["left_gripper.x", "left_gripper.y", "left_gripper.z"]
    for k, band in enumerate(robot.collections):
        heights = band.get_paths()[0].vertices[:, 1]
        wanted = inference.robot_motion()[:, k] + 2 * inference.robot_deviation()[:, k]
        assert heights.max() == pytest.approx(wanted.max(), abs=1e-9)


def test_now_is_where_the_partner_is_inferred_to_be(inferred: Inferred) -> None:
    _, inference, _ = inferred
    for axes in collaboration_figure(*inferred).axes:
        (now,) = [line for line in axes.lines if line.get_linestyle() == ":"]
        assert set(now.get_xdata()) == {inference.share * inference.duration}
    assert 0 < inference.share < 1


def test_columns_after_a_quaternion_keep_their_own_spread(inferred: Inferred) -> None:
    ones = []
    for k in range(3):
        one = demonstrate_covering(OBJECTS[k % 2], [200, k])
        wide = 0.5 * k + np.linspace(0, 1, len(one))[:, None]
        columns = np.hstack([one.robot[:, 3:], wide])
        names = (*one.robot_names[3:], "left_gripper.opening")
        ones.append(InteractionRecording(one.stamp, one.partner, columns, one.partner_names, names, one.environment))
    model = CollaborationModel.fit(ones, CollaborationConfig(steps=100, environment=False))
    seen = ones[0].partial(seconds=0.5)
    inference = model.infer(seen)
    robot = collaboration_figure(model, inference, seen).axes[1]
    heights = robot.collections[0].get_paths()[0].vertices[:, 1]
    spread = inference.robot_deviation()[:, 3]
    assert heights.max() == pytest.approx((inference.robot_motion()[:, 4] + 2 * spread).max(), abs=1e-9)


def test_the_same_inference_gives_the_same_bytes(inferred: Inferred) -> None:
    assert png(collaboration_figure(*inferred)) == png(collaboration_figure(*inferred))


def test_more_columns_than_colours_are_counted(inferred: Inferred) -> None:
    one = demonstrate_covering(OBJECTS[0], 1)
    names = tuple(f"joint{k}.x" for k in range(13))
    ones = []
    for k in range(3):
        partner = np.linspace(0, 1 + 0.1 * k, len(one))[:, None] * np.arange(1, 14)
        ones.append(InteractionRecording(one.stamp, partner, one.robot[:, :3], names, one.robot_names[:3]))
    model = CollaborationModel.fit(ones, CollaborationConfig(steps=100, environment=False))
    seen = ones[0].partial(seconds=3)
    assert "3 columns more" in collaboration_figure(model, model.infer(seen), seen).axes[0].get_title()
