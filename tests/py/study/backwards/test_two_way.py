"""Driving backwards with heatmaps and a scanner that sees all around."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.geometry import MotionLimits, Pose2, Twist2
from lfdcore.grid import LaserScan, local_grid
from lfdcore.simulated.courses import hall
from lfdcore.simulation import DrivingWorld, LidarConfig
from lfdcore.study.backwards.report import backwards_headline, backwards_table
from lfdcore.study.backwards.study import AROUND, BackwardsStudy, run_backwards_study
from lfdcore.wheelchair.assistants import DriveAssistant
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import ChairGeometry, Observation
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant, sees_all_around, turned, turned_chair
from observed import observed

CHAIR = ChairGeometry.thesis()


@pytest.fixture(scope="module")
def model(heatmap_model: Path) -> HeatmapModel:
    return HeatmapModel.load(heatmap_model)


def observe(joystick: tuple[float, float], lidar: LidarConfig = AROUND, twist: Twist2 | None = None) -> Observation:
    world = DrivingWorld(hall().grid, lidar=lidar, seed=1)
    pose = Pose2(4.0, 2.0, 0.0)
    world.reset(pose)
    return observed(0.0, world.scan(), joystick, pose=pose, twist=twist or Twist2())


def test_the_whole_way_backwards_is_driven_along_planned_paths_without_contact(
    heatmap_model: Path, tmp_path: Path
) -> None:
    study = BackwardsStudy(model=heatmap_model, arms=("two_way",), kinds=("able",), drivers=1, processes=1)
    (trace,) = run_backwards_study(study, tmp_path)
    assert trace.completed and trace.collision.sum() == 0
    assert (trace.mode == "path").mean() > 0.8 and len(trace.plans) > 20
    along = np.diff(trace.pose[:, :2], axis=0)
    heading = trace.pose[:-1, 2]
    rolled = along[:, 0] * np.cos(heading) + along[:, 1] * np.sin(heading)
    assert rolled.sum() == pytest.approx(-hall().length, rel=0.2)
    (row,) = backwards_table((trace,)).rows
    assert row[:2] == ("reversing\nheatmaps, both ways", "1")
    assert row[2].startswith("1 of 1") and row[3].startswith("0 in 1")
    said = "reversing: heatmaps, both ways 0 (1 of 1). n = 1 simulated drivers of each kind, seeds 1..1."
    assert said in backwards_headline((trace,))


@pytest.mark.parametrize(("wrong", "words"), [({"arms": ("both",)}, "both"), ({"kinds": ("expert",)}, "expert")])
def test_an_unknown_arm_or_kind_of_driver_is_refused(wrong: dict[str, tuple[str, ...]], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        BackwardsStudy(**{"arms": ("none",), **wrong})


@pytest.mark.parametrize(("arm", "learned"), [("two_way", 1), ("none", 0)])
def test_a_model_is_learned_for_the_arm_that_needs_one_alone(
    arm: str, learned: int, heatmap_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def learn(folder: Path, *_: object, **__: object) -> Path:
        asked.append(folder)
        return heatmap_model

    monkeypatch.setattr("lfdcore.study.demonstrations.learn_heatmaps_from_demonstrations", learn)
    monkeypatch.setattr("lfdcore.study.backwards.study.run_jobs", lambda jobs, *_: tuple(jobs))
    study = BackwardsStudy(arms=(arm,), kinds=("able",), drivers=1)
    (job,) = run_backwards_study(study, tmp_path)
    assert asked == [tmp_path] * learned
    assert job.make_assistant().name == arm  # type: ignore[attr-defined]


def test_a_scanner_that_sees_ahead_only_leaves_reversing_to_the_user(model: HeatmapModel) -> None:
    assistant = TwoWayAssistant(model, CHAIR)
    alone = DriveAssistant(model.planner(CHAIR))
    seen = observe((-0.5, 0.1), LidarConfig())
    said, expected = assistant.update(seen), alone.update(seen)
    assert said.mode == expected.mode == "reverse" and said.command == expected.command


def test_a_stick_ahead_is_answered_as_by_the_assistant_alone(model: HeatmapModel) -> None:
    seen = observe((0.6, 0.1))
    said, expected = TwoWayAssistant(model, CHAIR).update(seen), DriveAssistant(model.planner(CHAIR)).update(seen)
    assert said.mode == expected.mode == "path" and said.command == expected.command
    np.testing.assert_array_equal(said.path, expected.path)


def test_a_path_for_a_stick_behind_leads_behind_and_is_followed_backwards(model: HeatmapModel) -> None:
    said = TwoWayAssistant(model, CHAIR).update(observe((-0.6, 0.1)))
    assert said.mode == "path" and said.path is not None and said.control_point is not None
    assert said.path[-1, 0] < 4.0 and said.control_point[0] < 0 and said.command.linear < 0


def test_a_turn_on_the_spot_while_reversing_is_the_users_own(model: HeatmapModel) -> None:
    """... so that it does not become a path ahead."""
    assistant = TwoWayAssistant(model, CHAIR)
    assistant.update(observe((-0.6, 0.0)))
    said = assistant.update(replace(observe((0.0, 0.5)), stamp=0.1, scan_stamp=0.1))
    assert said.mode == "reverse" and said.command.linear == 0.0 and said.command.angular > 0
    said = assistant.update(replace(observe((0.6, 0.0)), stamp=0.2, scan_stamp=0.2))
    assert said.mode == "path" and said.command.linear > 0


def test_all_heatmaps_reach_behind_the_chair_where_the_scan_does(model: HeatmapModel) -> None:
    """The window is full; the user's heatmap has always reached behind, by the movement template's reverse arcs."""
    for lidar, behind in ((LidarConfig(), False), (AROUND, True)):
        seen = observe((-0.6, 0.0), lidar)
        planner = HeatmapPlanner(model, HeatmapPlannerConfig(), CHAIR)
        grid = local_grid(seen.scan, CHAIR.T_base_laser)
        heat = planner.heat(seen, grid)
        assert heat is not None
        assert ((grid.data[:, :45] == 0).mean() > 0.3) == behind
        assert heat.user[:, :45].max() == 1.0
        assert bool(heat.intent[:, :45].any()) == behind


def test_what_a_turned_chair_observes_is_the_same_place() -> None:
    chair, seen = CHAIR, observe((-0.6, 0.1), twist=Twist2(-0.3, 0.2))
    back = turned(seen)
    assert back.joystick == (0.6, 0.1) and tuple(back.twist) == (0.3, 0.2)
    same = seen.pose * chair.T_base_laser, back.pose * turned_chair(chair).T_base_laser
    assert tuple(same[1]) == pytest.approx(tuple(same[0]))
    body, other = chair.footprint, turned_chair(chair).footprint
    assert (other.front, other.rear, other.half_width) == (body.rear, body.front, body.half_width)
    assert turned_chair(chair).limits.max_linear == MotionLimits().max_reverse


@pytest.mark.parametrize(("beams", "degrees", "around"), [(181, 1.0, False), (361, 1.0, True), (270, 1.0, False)])
def test_a_scan_goes_all_around_if_its_beams_do(beams: int, degrees: float, around: bool) -> None:
    scan = LaserScan(np.ones(beams, np.float32), -np.pi, np.radians(degrees), 0.0, 30.0)
    assert sees_all_around(scan) == around
