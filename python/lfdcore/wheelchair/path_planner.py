"""From an inferred goal to a path that the chair's body can follow (Sec. 3.4.1-3.4.2, ERRATA 19-21).

primitive scaled to the goal -> reward landscape -> dynamic policy programming -> roll-out of the pursuit with the
oriented footprint -> where it would touch: hybrid A* to the same end.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import ObstaclePoints, inflate
from lfdcore.control import RolloutConfig, rollout_pursuit
from lfdcore.planning import (
    DppConfig,
    DppSolver,
    GridMdp,
    HybridAstar,
    HybridAstarConfig,
    RewardConfig,
    greedy_path,
    path_cells,
    path_reward,
)

CELLS = 100
RESOLUTION = 0.05  # [m]
CORNER = -2.5  # [m] of the window in base_link
ORIGIN = (CELLS // 2, CELLS // 2)  # cell of base_link
