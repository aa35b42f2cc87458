"""The path that a driver is going to take, from the intention map and the path primitives (Sec. 3.3, 3.4.1).

The thesis predicts the primitive scaled to the likeliest cell (`rule="goal"`). One-class networks all answer about 1
near their data, however often a cell was driven to, so that the maximum jumps about between cells that are hardly less
likely. The default (`rule="median"`) lets every cell vote with its likelihood: the path at each arc length is the
geometric median of all cells' primitives there, the point of the least expected distance. Primitives that come nearer
to what the scan shows than demonstrations did lose their vote.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from lfdcore.grid import distance_field, local_grid
from lfdcore.wheelchair.paths import along, geometric_median
from lfdcore.wheelchair.window import CELLS, RESOLUTION, WINDOW

if TYPE_CHECKING:
    from lfdcore.geometry import Pose2
    from lfdcore.grid import LaserScan
    from lfdcore.wheelchair.primitives.compliance import ComplianceModel
    from lfdcore.wheelchair.primitives.model import DriveAssistantModel

Floats = NDArray[np.float64]
_DOUBT = 0.02  # of a vote stays where a place is narrower than all that was demonstrated


@dataclass(frozen=True)
class PathPredictionConfig:
    """rule: see the module; reach [m]: how long a path is predicted (straight on beyond its goal); points: in it;
    edge [m]: over how much clearance a primitive's vote fades, around the clearance that the demonstrations kept
    (0: no primitive loses its vote); iterations: of Weiszfeld's algorithm for the geometric median."""

    rule: Literal["median", "goal"] = "median"
    reach: float = 2.5
    points: int = 26
    edge: float = 0.05
    iterations: int = 15

    def __post_init__(self) -> None:
        if self.rule not in ("median", "goal"):
            raise ValueError(f"rule is {self.rule!r}, must be 'median' or 'goal'")
        if not (np.isfinite(self.reach) and self.reach > 0):
            raise ValueError(f"reach is {self.reach} m, must be positive and finite")
        if self.points < 2 or self.iterations < 0 or not self.edge >= 0:
            raise ValueError(f"points {self.points}, iterations {self.iterations}, edge {self.edge} m are too small")

    @classmethod
    def thesis(cls) -> PathPredictionConfig:
        return cls(rule="goal")


class PathPredictor:
    """Predicts paths with one learned model; all primitives are scaled to all cells once, when it is made."""

    def __init__(self, model: DriveAssistantModel, config: PathPredictionConfig | None = None) -> None:
        self.model, self.config = model, config or PathPredictionConfig()
        scaled = model.primitives.scaled_to_all(model.intention.centres)
        cells = np.floor((scaled + WINDOW) / RESOLUTION).clip(0, CELLS - 1).astype(np.intp)
        self._cells = cells[..., 1] * CELLS + cells[..., 0]
        self._at = np.linspace(0.0, self.config.reach, self.config.points)
        self._paths = np.array([along(path, self._at) for path in scaled])

    @property
    def compliance(self) -> ComplianceModel:
        """Who judges compliance: the model's own."""
        return self.model.compliance

    def predict(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats | None:
        """(points, 2) [m] in base_link from the origin, equally spaced up to `reach`; None where nothing is likely
        (stick at rest, scan without a measurement, nothing like it in the demonstrations)."""
        if self.config.rule == "goal":
            return self._to_goal(self.model.intention.predict(joystick, scan, T_base_laser))
        votes = self.votes(joystick, scan, T_base_laser)
        voters = np.flatnonzero(votes > 1e-3 * votes.max(initial=0.0))
        if len(voters) == 0:
            return None
        median = geometric_median(self._paths[voters], votes[voters], self.config.iterations)
        return along(median, self._at)

    def votes(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats:
        """How much each cell's primitive counts (C,), in the order of the intention model's `cells`: the cell's
        likelihood, less if the primitive comes nearer to what the scan shows than demonstrations did."""
        votes = self.model.intention.cell_likelihoods(joystick, scan, T_base_laser)
        if self.config.edge == 0 or self.model.clearance == 0 or not votes.any():
            return votes
        return votes * self._free(scan, T_base_laser)

    def _to_goal(self, likelihood: NDArray[np.float32]) -> Floats | None:
        found = self.model.intention.goal(likelihood)
        if found is None:
            return None
        return along(self.model.primitives.scaled_to(found[0]), self._at)

    def _free(self, scan: LaserScan, T_base_laser: Pose2) -> Floats:
        clearance = clearance_field(scan, T_base_laser).ravel()[self._cells].min(axis=1)
        vote = 1.0 / (1.0 + np.exp(np.clip((self.model.clearance - clearance) / self.config.edge, -50, 50)))
        return np.asarray(np.maximum(vote, _DOUBT))


def clearance_field(scan: LaserScan, T_base_laser: Pose2) -> NDArray[np.float32]:
    """(100, 100) [m]: from each cell of the local window to the nearest cell that a beam hit; inf without a hit."""
    return np.asarray(distance_field(local_grid(scan, T_base_laser).occupied_mask(), RESOLUTION))
