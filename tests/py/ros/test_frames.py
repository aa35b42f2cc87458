"""Where a scanner is mounted: from static transforms, upright or upside down, or an error that says what to do."""

import math

import numpy as np
import pytest

from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.frame_tree import FrameTree, Mounting, mounting_of
from lfdcore.geometry import Pose2
from lfdcore.ros.frames import Frames, frames_of, scan_mounting
from lfdcore.ros.messages import scan_of
from lfdcore.ros.options import NodeOptions
from ros_words import odometry, scan, static

UPSIDE_DOWN = (math.pi, 0.0, 0.0)


def frames(*messages: object) -> FrameTree:
    """Through bytes, as they come from a topic."""
    tree = FrameTree()
    for message in messages:
        tree.add(ros.deserialize(ros.serialize(message, "tf2_msgs/msg/TFMessage"), "tf2_msgs/msg/TFMessage"))
    return tree


def mounting(tree: FrameTree, options: NodeOptions | None = None, child: str = "base_link") -> Mounting:
    return scan_mounting(scan(0), odometry(0, Pose2(), child=child), options or NodeOptions(), tree)


def test_transforms_are_chained_up_and_down_the_tree() -> None:
    tree = frames(
        static("base_footprint", "base_link", (0, 0, 0.2), (0, 0, 0)),
        static("base_link", "mast", (0.5, 0.1, 0.3), (0, 0, math.pi / 2)),
        static("mast", "laser", (0.2, 0.0, 0.1), (0, 0, -math.pi / 2)),
    )
    for base in ("base_link", "base_footprint"):
        assert [*mounting(tree, child=base).T_base_laser] == pytest.approx([0.5, 0.3, 0.0])
    side = frames(
        static("chassis", "base_link", (1, 0, 0), (0, 0, 0)), static("chassis", "laser", (1.7, 0, 0), (0, 0, 0))
    )
    assert [*mounting(side).T_base_laser] == pytest.approx([0.7, 0.0, 0.0])


@pytest.mark.parametrize("seed", range(20))
def test_a_beam_ends_where_the_transform_in_space_puts_it_also_upside_down(seed: int) -> None:
    random = np.random.default_rng(seed)
    x, y, z, yaw = random.uniform(-1, 1, 4)
    rolled = UPSIDE_DOWN if seed % 2 else (0.0, 0.0, 0.0)
    tree = frames(static("base_link", "laser", (x, y, z), (rolled[0], 0.0, 3 * yaw)))
    message = scan(0, random.uniform(0.5, 5, 5).tolist())
    found = mounting(tree)
    seen = scan_of(message, found.mirrored)
    flat = seen.ranges[:, None] * np.column_stack([np.cos(seen.angles()), np.sin(seen.angles())])
    angles = message.angle_min + message.angle_increment * np.arange(5)
    beams = np.stack([np.cos(angles) * message.ranges, np.sin(angles) * message.ranges, np.zeros(5), np.ones(5)])
    T = tree.transform("base_link", "laser")
    assert T is not None
    np.testing.assert_allclose(found.T_base_laser.transform(flat), (T @ beams)[:2].T, atol=1e-6)
    assert found.mirrored == bool(seed % 2)


@pytest.mark.hazard("It is not known where the scanner is", "no frame is not the identity: an error, and no drive")
def test_frames_that_nothing_joins_are_an_error() -> None:
    with pytest.raises(ValueError, match="does not join laser to base_link: say --mounting"):
        mounting(frames())
    with pytest.raises(ValueError, match="does not join"):
        mounting(frames(static("base_link", "mast", (0, 0, 0), (0, 0, 0))))
    with pytest.raises(ValueError, match="names no frame_id: say --mounting"):
        scan_mounting(scan(0, frame=""), odometry(0, Pose2()), NodeOptions(), frames())
    given = NodeOptions(mounting=Pose2(0.7, 0.0, 0.0))
    assert mounting(frames(), given) == Mounting(Pose2(0.7, 0.0, 0.0))


def test_a_circle_a_tilt_and_what_is_no_rotation_are_errors() -> None:
    circle = frames(static("a", "b", (0, 0, 0), (0, 0, 0)), static("b", "a", (0, 0, 0), (0, 0, 0)))
    with pytest.raises(ValueError, match="run in a circle"):
        circle.transform("a", "b")
    tilted = frames(static("base_link", "laser", (0, 0, 0), (0, 0.3, 0)))
    with pytest.raises(ValueError, match=r"tilted by 17\.2 degrees, must be level within 5"):
        mounting(tilted)
    with pytest.raises(ValueError, match="not finite"):
        mounting_of(np.full((4, 4), np.nan))
    unturned = static("base_link", "laser", (0, 0, 0), (0, 0, 0))
    unturned.transforms[0].transform.rotation.w = 0.0
    with pytest.raises(ValueError, match="not finite"):
        mounting(frames(unturned))


def test_the_base_is_odometrys_child_or_a_frame_in_its_place() -> None:
    there = frames(static("base_footprint", "base_link", (0, 0, 0.2), (0, 0, 0)))
    away = frames(static("base_footprint", "base_link", (0.1, 0, 0), (0, 0, 0)))
    asked = NodeOptions(base="base_footprint")
    assert frames_of(scan(0), odometry(0, Pose2()), NodeOptions(), frames()) == Frames("laser", "odom", "base_link")
    assert frames_of(scan(0), odometry(0, Pose2()), asked, there).base == "base_link"
    for tree in (away, frames()):
        with pytest.raises(ValueError, match="/odom is of base_link, not of --base base_footprint"):
            frames_of(scan(0), odometry(0, Pose2()), asked, tree)
    with pytest.raises(ValueError, match="names no child_frame_id: say --base"):
        frames_of(scan(0), odometry(0, Pose2(), child=""), NodeOptions(), frames())
    assert frames_of(scan(0), odometry(0, Pose2(), child=""), asked, frames()).base == ""
    lost = odometry(0, Pose2())
    lost.header.frame_id = ""
    with pytest.raises(ValueError, match="names no frame_id"):
        frames_of(scan(0), lost, NodeOptions(), frames())
