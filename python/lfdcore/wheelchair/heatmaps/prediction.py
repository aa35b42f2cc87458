"""The path that a driver is going to take, from the heatmaps of Ch. 4 (Sec. 4.6.2): `predict` as PathPredictor's.

The sensor heatmap, sharpened, times a stick heatmap, then the median of the heat at every distance (heatmap_path).
The stick heatmap is Eq. 4.3 around the orientation that the joystick's Gaussian process takes for meant, but its
standard deviation is .25 rad and .1 rad more for every metre: the farther off, the less a stick says. The variance that
the process gives knows no distance. The values were found by blocks inside freiburg-079's first 70 %
(docs/real-logs.md). Planning uses none of this; ProductPredictor predicts from the heat that is planned over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import MotionLimits, Pose2, Twist2
from lfdcore.grid import local_grid
from lfdcore.planning import MovementTemplate, OrientationMoments, compliances, joystick_orientation
from lfdcore.wheelchair.heatmaps.path import heatmap_path
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.observation import Observation
from lfdcore.wheelchair.stick import full_deflection_of
from lfdcore.wheelchair.window import cell_centres, free_mask

if TYPE_CHECKING:
    from lfdcore.grid import LaserScan
    from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class HeatmapPredictionConfig:
    """sharpness: power of the network's heatmap; sd [rad], sd_per_metre [rad/m]: of the stick's orientation at a
    distance from base_link; reach [m], points: of the path."""

    sharpness: float = 1.5
    sd: float = 0.25
    sd_per_metre: float = 0.1
    reach: float = 2.5
    points: int = 26

    def __post_init__(self) -> None:
        if not 0 < self.sharpness <= 100:
            raise ValueError(f"sharpness is {self.sharpness}, must lie in (0, 100]")
        if not (0 < self.sd < np.inf and 0 <= self.sd_per_metre < np.inf):
            raise ValueError(f"sd {self.sd} rad and sd_per_metre {self.sd_per_metre} rad/m cannot be used")


class HeatmapPathPredictor:
    """Predicts paths with one model of both heatmaps. The stick is read by the full deflection that the model's file
    says, or the simulated chair's where it says none."""

    def __init__(self, model: HeatmapModel, config: HeatmapPredictionConfig | None = None) -> None:
        self.model, self.config = model, config or HeatmapPredictionConfig()
        planner = HeatmapPlannerConfig()
        self.look_ahead = planner.look_ahead
        self._doubt = planner.driver_sd**2
        self._limits = _limits(full_deflection_of(model))
        self._orientation = MovementTemplate(self._limits).orientation.astype(np.float64)
        distance = np.hypot(*np.moveaxis(cell_centres(), -1, 0))
        self._precision = 1 / (self.config.sd + self.config.sd_per_metre * distance) ** 2

    @property
    def compliance(self) -> HeatmapPathPredictor:
        """Who judges compliance: itself."""
        return self

    def predict(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats | None:
        """(points, 2) [m] in base_link from the origin, equally spaced up to `reach`; None for a stick at rest or
        pulled back and for a scan that sees no free cell. ValueError for a stick out of range."""
        heat = self.heat(joystick, scan, T_base_laser)
        return None if heat is None else heatmap_path(heat, self.config.reach, self.config.points)

    def heat(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats | None:
        """(100, 100) heat that the path is drawn from; None as `predict`."""
        meant = self._meant(joystick)
        if meant is None or abs(meant.mean) > np.pi / 2:
            return None
        sensor = self.model.sensor.predict(free_mask(local_grid(scan, T_base_laser)))
        return np.asarray(sensor.astype(np.float64) ** self.config.sharpness * self.stick_heatmap(meant.mean))

    def stick_heatmap(self, orientation: float) -> Floats:
        """(100, 100) in (0, 1] for an orientation [rad] that is meant."""
        beside = np.abs(self._orientation - orientation)
        beside = np.minimum(beside, 2 * np.pi - beside)
        return np.asarray(np.exp(-0.5 * beside**2 * self._precision))

    def compliances(self, control_points: Floats, joystick: Floats) -> Floats:
        """As HeatmapPlanner judges by default: the density of what is meant; 0 for (0, 0)."""
        meant = self._meant(joystick)
        if meant is None:
            return np.zeros(len(control_points))
        doubted = OrientationMoments(meant.mean, meant.variance + self._doubt)
        return np.asarray(compliances(np.ascontiguousarray(control_points), doubted, self._limits))

    def _meant(self, joystick: Floats) -> OrientationMoments | None:
        if not np.any(joystick):
            return None
        return joystick_orientation(*self.model.joystick.predict(joystick))


class ProductPredictor:
    """Predicts paths from the product of both heatmaps that a planner plans over (Sec. 4.5)."""

    def __init__(self, planner: HeatmapPlanner) -> None:
        self.model, self.compliance = planner.model, planner
        self._planner = planner

    def predict(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats | None:
        """(26, 2) [m] in base_link from the origin, equally spaced; None for a stick at rest and where no heat is left.
        The planner's chair has its laser at T_base_laser."""
        now = _as_if_at_rest(scan, joystick)
        heat = self._planner.heat(now, local_grid(scan, T_base_laser))
        return None if heat is None else heatmap_path(heat.intent)


class NaivePathPredictor:
    """Predicts paths with one naive network, its heatmap sharpened alike. It knows no compliance."""

    compliance = None

    def __init__(self, model: NaiveHeatmapModel, config: HeatmapPredictionConfig | None = None) -> None:
        self.model, self.config = model, config or HeatmapPredictionConfig()

    def predict(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats | None:
        """As HeatmapPathPredictor's."""
        if not np.any(joystick) or joystick[0] < 0:
            return None
        heat = self.model.network.predict(free_mask(local_grid(scan, T_base_laser)), joystick)
        return heatmap_path(heat.astype(np.float64) ** self.config.sharpness, self.config.reach, self.config.points)


def _limits(full: Twist2 | None) -> MotionLimits:
    if full is None:
        return MotionLimits()
    return MotionLimits(max_linear=full.linear, max_reverse=full.linear, max_angular=full.angular)


def _as_if_at_rest(scan: LaserScan, joystick: Floats) -> Observation:
    """A scan that stands alone, seen by a chair at the origin."""
    stick = (float(joystick[0]), float(joystick[1]))
    return Observation(
        stamp=0.0,
        scan=scan,
        scan_stamp=0.0,
        pose=Pose2(),
        twist=Twist2(),
        odometry_stamp=0.0,
        joystick=stick,
        joystick_stamp=0.0,
    )
