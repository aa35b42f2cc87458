"""Where a chair stands though a free motion is asked for: a deadlock, each of which is counted as a fault."""

from __future__ import annotations

import math

import numpy as np

from lfdcore.control import SupervisorConfig
from lfdcore.geometry import Pose2, Twist2, integrate
from lfdcore.grid import ObstaclePoints, OccupancyGrid
from lfdcore.simulated.chair import Truth
from lfdcore.simulated.run import RunConfig
from lfdcore.simulation import DrivingWorld, joystick_to_twist
from lfdcore.wheelchair.drive_loop import Tick
from lfdcore.wheelchair.stick import DEAD_ZONE
from lfdcore.wheelchair.watch import HALTS

STANDS_BELOW = 0.01
"""[m/s] (and [rad/s]) A chair that is slower stands."""
LONGEST = 2.0
"""[s] of standing that is no fault yet, and for which the motion asked for must be free"""
_STEP = 0.05
"""[s] between the poses that are looked at"""


class Standing:
    """Counts how often a chair stood for longer than LONGEST, while at each tick no mode stopped it and the stick asked
    for a free motion.

    Free: the body that keeps the asked twist for LONGEST, its accelerations ignored, stays `clearance` away from all in
    the true map, and from people where they are. `clearance` is what the supervisor keeps at speed from a point that
    one reading shows: its margin and three standard deviations of the range. Narrower ways are not counted.
    """

    def __init__(self, grid: OccupancyGrid, run: RunConfig) -> None:
        self.clearance = SupervisorConfig().margin + 3 * run.geometry.range_noise
        self.times = 0
        self._chair = run.chair
        self._world = DrivingWorld(grid, run.chair)
        self._from_people = self.clearance + (0.0 if run.people is None else run.people.radius)
        self._begin = math.inf
        self._counted = False

    def add(self, tick: Tick, truth: Truth) -> None:
        """Takes in a tick and what was true at its observation."""
        if not self._at_fault(tick, truth):
            self._begin, self._counted = math.inf, False
            return
        self._begin = min(self._begin, tick.stamp)
        if not self._counted and tick.stamp - self._begin > LONGEST:
            self.times += 1
            self._counted = True

    def _at_fault(self, tick: Tick, truth: Truth) -> bool:
        twist, stick = truth.state.twist, tick.observation.joystick
        if math.hypot(twist.linear, twist.angular) > STANDS_BELOW or math.hypot(*stick) < DEAD_ZONE:
            return False
        asked = joystick_to_twist(*stick, self._chair.limits)
        return tick.assistance.mode not in HALTS and self.is_free(truth, asked)

    def is_free(self, truth: Truth, asked: Twist2) -> bool:
        """Whether the motion at `asked` [m/s, rad/s] from where the chair is meets nothing."""
        people = ObstaclePoints(truth.people)
        poses = (integrate(truth.state.pose, asked, time) for time in np.arange(0, LONGEST + _STEP / 2, _STEP))
        return not any(self._touches(pose, people) for pose in poses)

    def _touches(self, pose: Pose2, people: ObstaclePoints) -> bool:
        near = self._world.touches(pose, self.clearance)
        return near or people.clearance(pose, self._chair.footprint) < self._from_people
