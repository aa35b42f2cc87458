"""What a planning method brings: a model that says how it plans and what it predicts (Ch. 3, Ch. 4).

A method is a folder beside this file (primitives, heatmaps) with model.py, planner.py and prediction.py. models.py
lists the classes of models. Assistants and predictions ask the model; only `lfdcore learn` and studies that compare
methods name them.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from lfdcore.wheelchair.planner import Judge, Planner
from lfdcore.wheelchair.stick import Learned

if TYPE_CHECKING:
    from lfdcore.geometry import Pose2
    from lfdcore.grid import LaserScan
    from lfdcore.wheelchair.observation import ChairGeometry


class Predictor(Protocol):
    """Predicts the path that a driver is going to take."""

    @property
    def model(self) -> Learned:
        """What it predicts with; says what full deflection of the stick meant."""

    @property
    def compliance(self) -> Judge | None:
        """Who judges whether a later input agrees with a path; None for a model that knows no compliance."""

    def predict(
        self, joystick: NDArray[np.float64], scan: LaserScan, T_base_laser: Pose2
    ) -> NDArray[np.float64] | None:
        """(points, 2) [m] in base_link from the origin on, equally spaced; None where nothing is predicted."""


class MethodModel(Learned, Protocol):
    """A learned model of any method."""

    method: ClassVar[str]
    """The method's name, as arms of studies and `lfdcore learn drive --method` have it"""
    kind: ClassVar[str]
    """What its file says that it is"""
    drives: ClassVar[bool]
    """Whether it has a planner"""

    def planner(self, chair: ChairGeometry, *, thesis: bool = False) -> Planner:
        """A new planner for a chair (default: the simulated one), with the method's defaults or the printed values.
        ModelError where the method does not drive."""

    def predictor(self) -> Predictor:
        """A new predictor with the method's defaults."""

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """ModelError for a damaged file, or one of another kind or version."""
