"""A driver with a short task: through a doorway and dock at a table, or through a narrow gap."""

from __future__ import annotations

from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.courses import Task
from lfdcore.simulated.drivers import DriverInput, ImpairedConfig, ImpairedDriver

DOCKING_SPEED = 0.2
"""A chair beside its table counts as docked when it is no faster than this [m/s]: it stops within a few cm."""


class TaskDriver(ImpairedDriver):
    """An impaired driver who goes on until the task is done: behind the gap, or docked; only time ends it else."""

    def __init__(self, task: Task, config: ImpairedConfig) -> None:
        self._task = task
        super().__init__(task.course, config)

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        """As any driver, but for the end."""
        slow = self._task.table is None or abs(twist.linear) <= DOCKING_SPEED
        self._done = self._done or (slow and self._task.reached(pose))
        return super().act(stamp, pose, twist, in_contact)

    def _at_end(self, seen: Pose2) -> bool:
        return False
