"""What a simulated run leaves for metrics and pictures: the true motion, the inputs, what the assistant thought."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, Pose2
from lfdcore.simulated.chair import Truth
from lfdcore.simulated.person_met import PersonMet
from lfdcore.wheelchair.drive_loop import Tick


@dataclass(frozen=True)
class Plan:
    """A path as the assistant made it."""

    stamp: float
    """[s]"""
    path: NDArray[np.float64]
    """(N, 2) [m] in map"""


@dataclass(frozen=True)
class DriveTrace:
    """One run at a fixed period, without its scans (the drive log has those). T ticks, frame map, by ground truth."""

    course: str
    driver: str
    assistant: str
    seed: int
    outcome: str
    """'completed', 'time_out' or 'stuck'"""
    footprint: Footprint
    stamp: NDArray[np.float64]
    """(T,) [s]"""
    pose: NDArray[np.float64]
    """(T, 3) x, y [m], yaw [rad]"""
    twist: NDArray[np.float64]
    """(T, 2) [m/s, rad/s]"""
    joystick: NDArray[np.float64]
    """(T, 2) forward, left as given"""
    desired: NDArray[np.float64]
    """(T, 2) forward, left as meant, before the disability"""
    command: NDArray[np.float64]
    """(T, 2) [m/s, rad/s] sent to the chair"""
    in_contact: NDArray[np.bool_]
    """(T,) with the map"""
    collision: NDArray[np.bool_]
    """(T,) true where a contact with the map begins"""
    mode: NDArray[np.str_]
    """(T,) who decided (Assistance.mode)"""
    supervised: NDArray[np.bool_]
    """(T,) where the supervisor changed the command"""
    compliance: NDArray[np.float64]
    """(T,) in [0, 1]; NaN without a path"""
    goal: NDArray[np.float64]
    """(T, 2) [m] the inferred intention; NaN without one"""
    control_point: NDArray[np.float64]
    """(T, 2) [m] of pure pursuit or DWA; NaN without one"""
    plans: tuple[Plan, ...] = ()
    people: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0, 2)))
    """(T, P, 2) where P people are [m]"""
    touches_person: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    """(T,) where a contact with a person is not yet over"""
    people_met: tuple[PersonMet, ...] = ()
    """contacts with people, in the order in which they began; none of them is in `collision`"""

    @property
    def completed(self) -> bool:
        """True if the driver reached the end of the course."""
        return self.outcome == "completed"

    @property
    def period(self) -> float:
        """Time between ticks [s]."""
        return float(self.stamp[1] - self.stamp[0]) if len(self.stamp) > 1 else 0.0

    @property
    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        arrays = [value for value in vars(self).values() if isinstance(value, np.ndarray)]
        return sum(a.nbytes for a in arrays) + sum(plan.path.nbytes for plan in self.plans)


class TraceRecorder:
    """Collects a run's ticks. start: the chair's first pose in map, where odometry begins at (0, 0, 0)."""

    def __init__(self, start: Pose2) -> None:
        self._T_map_odom = start
        self._rows: dict[str, list[Any]] = {}
        self._plans: list[Plan] = []

    def add(self, tick: Tick, truth: Truth) -> None:
        """Takes in a tick and what was true at its observation."""
        answer, state = tick.assistance, truth.state
        row = {
            "stamp": tick.stamp,
            "pose": tuple(state.pose),
            "twist": tuple(state.twist),
            "joystick": tick.observation.joystick,
            "desired": tuple(truth.desired),
            "command": tuple(answer.command),
            "in_contact": state.in_contact,
            "collision": truth.collision,
            "mode": answer.mode,
            "supervised": answer.supervised,
            "compliance": answer.compliance if answer.path is not None else np.nan,
            "goal": _in_map(self._T_map_odom, answer.goal),
            "control_point": _in_map(state.pose, answer.control_point),
            "people": truth.people,
            "touches_person": truth.touches_person,
        }
        for name, value in row.items():
            self._rows.setdefault(name, []).append(value)
        if answer.planned and answer.path is not None:
            self._plans.append(Plan(tick.stamp, self._T_map_odom.transform(answer.path)))

    def trace(
        self,
        course: str,
        driver: str,
        assistant: str,
        *,
        seed: int,
        outcome: str,
        footprint: Footprint,
        people_met: tuple[PersonMet, ...] = (),
    ) -> DriveTrace:
        """All ticks so far."""
        rows: dict[str, Any] = {name: np.array(values) for name, values in self._rows.items()}
        rows |= {"plans": tuple(self._plans), "people_met": people_met}
        return DriveTrace(course, driver, assistant, seed, outcome, footprint, **rows)


def _in_map(T_map_frame: Pose2, point: tuple[float, float] | None) -> tuple[float, float]:
    if point is None:
        return (np.nan, np.nan)
    x, y = T_map_frame.transform(np.array([point]))[0]
    return (float(x), float(y))
