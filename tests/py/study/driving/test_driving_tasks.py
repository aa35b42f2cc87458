"""Tasks: who succeeds, who does not, and that arms meet the same starts."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.courses import doorway_and_docking, narrow_gap
from lfdcore.simulated.drivers import ImpairedConfig
from lfdcore.simulated.run import run_drive
from lfdcore.simulated.task_driver import DOCKING_SPEED, TaskDriver
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels
from lfdcore.study.driving.tasks import TaskPlan, run_task_plan, task_row
from lfdcore.wheelchair.assistants import Unassisted
from lfdcore.wheelchair.observation import ChairGeometry

CHAIR = ChairGeometry.thesis()


def docked_pose(task_seed: int) -> Pose2:
    task = doorway_and_docking(task_seed)
    assert task.table is not None
    return Pose2(task.table[0] - 0.8 - 0.2, (task.table[1] + task.table[3]) / 2, 0.0)


def driver_at(pose: Pose2, speed: float) -> TaskDriver:
    driver = TaskDriver(doorway_and_docking(1), ImpairedConfig())
    driver.act(0.0, pose, Twist2(speed, 0.0), False)
    return driver


def test_a_driver_beside_the_table_is_done_only_when_slow() -> None:
    assert driver_at(docked_pose(1), 0.9 * DOCKING_SPEED).done
    assert not driver_at(docked_pose(1), 2 * DOCKING_SPEED).done


def test_a_driver_is_not_done_at_the_routes_end_but_at_the_tasks() -> None:
    task = narrow_gap(1)
    driver = TaskDriver(task, ImpairedConfig())
    assert task.beyond_x is not None
    driver.act(0.0, Pose2(task.beyond_x + 0.34, 3.0, 0.0), Twist2(1.0, 0.0), False)  # the rear is still in the gap
    assert not driver.done
    stick = driver.act(0.1, Pose2(task.beyond_x + 0.36, 3.0, 0.0), Twist2(1.0, 0.0), False).joystick
    assert driver.done
    assert not stick.any()


@pytest.fixture(scope="module")
def trace() -> DriveTrace:
    task = narrow_gap(1)
    return run_drive(task.course, TaskDriver(task, ImpairedConfig()), Unassisted(CHAIR), 1)


def test_success_is_reached_without_any_contact(trace: DriveTrace) -> None:
    task = narrow_gap(1)
    clean, touched = np.zeros(len(trace.stamp), bool), np.arange(len(trace.stamp)) == 7
    assert task_row("narrow_gap", task, replace(trace, collision=clean))["success"]
    assert not task_row("narrow_gap", task, replace(trace, collision=touched))["success"]
    row = task_row("narrow_gap", task, replace(trace, collision=touched))
    assert (row["reached"], row["contacts"]) == (True, 1)


def test_a_chair_that_stands_while_forward_is_asked_is_stuck(trace: DriveTrace) -> None:
    n = 150
    still = replace(
        trace,
        **{
            name: np.repeat(getattr(trace, name)[:1], n, axis=0)
            for name in ("pose", "twist", "desired", "collision", "in_contact")
        },
        stamp=np.arange(n) * 0.1,
    )
    row = task_row("narrow_gap", narrow_gap(1), replace(still, desired=np.tile([1.0, 0.0], (n, 1))))
    assert (row["stuck"], row["reached"], row["success"]) == (True, False, False)
    assert not task_row("narrow_gap", narrow_gap(1), replace(still, desired=np.zeros((n, 2))))["stuck"]


def test_every_arm_meets_the_same_starts_and_the_result_does_not_depend_on_processes(tmp_path: Path) -> None:
    study = TaskPlan(models=StudyModels(), tasks=("narrow_gap",), arms=("none", "dwa"), starts=2)
    one, two = (partial(run_task_plan, study)(processes=n) for n in (1, 2))
    assert one.rows == two.rows
    assert [row["seed"] for row in one.rows] == [1, 1, 2, 2]
    starts = [tuple(trace.pose[0]) for trace in one.traces]
    assert starts[0] == starts[1] != starts[2] == starts[3]
