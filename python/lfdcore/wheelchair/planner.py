"""What every planner gives an assistant: a path for the driver's input, and whether an input complies with a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import FootprintRollout, FootprintRolloutConfig
from lfdcore.grid import ObstaclePoints, OccupancyGrid
from lfdcore.wheelchair.observation import ChairGeometry, Observation

LOOK_AHEAD = FootprintRolloutConfig().look_ahead
"""[m] of pure pursuit, and of the control points that an input may comply with (Sec. 3.4.2-3.4.3)"""
COMPLIANT_FROM = 0.9
"""Compliance from which an input agrees with a path (Sec. 3.4.3)"""


@dataclass(frozen=True, kw_only=True)
class PlannedPath:
    """A path with what led to it; frame base_link at the time of planning."""

    path: NDArray[np.float64]
    """(N, 2) [m]"""
    source: str
    """'grid' (DPP or Q-learning) or 'hybrid_astar'"""
    look_ahead: float
    """For pure pursuit [m]."""
    rollout: FootprintRollout | None
    """None if the footprint is not checked."""
    goal: tuple[float, float]
    """g* [m]"""
    likelihood: float
    """Of the goal's cell."""
    reward: NDArray[np.float32]
    """(100, 100) that the path was planned over."""


class Compliance(Protocol):
    """Whether a driver's input agrees with where a path leads (Sec. 3.4.3, 4.5)."""

    def compliances(self, control_points: NDArray[np.float64], joystick: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of a joystick (2,) (forward, left) with going to each of N control points (N, 2) [m] in base_link -> (N,) in
        [0, 1]."""


class Judge(Compliance, Protocol):
    """Judges compliance with control points up to a look-ahead."""

    @property
    def look_ahead(self) -> float:
        """Of pure pursuit [m], the one that compliance is defined for (Sec. 3.4.2-3.4.3)."""


class Planner(Judge, Protocol):
    """From an observation to a path that the body of one chair can follow. It keeps its solvers' memory between calls,
    so that it belongs to one assistant."""

    @property
    def chair(self) -> ChairGeometry:
        """Whose paths it plans."""

    def plan(self, observation: Observation, grid: OccupancyGrid, obstacles: ObstaclePoints) -> PlannedPath | None:
        """A path for the driver's input; None if nothing is intended or nothing leads there without contact.

        `grid` and `obstacles` are the rolling map's, in base_link.
        """
