"""What a user says of the robot: its topics, its frames, the chair itself."""

from __future__ import annotations

from dataclasses import dataclass, field

from lfdcore.geometry import Footprint, MotionLimits, Pose2
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry


@dataclass(frozen=True, kw_only=True)
class NodeOptions:
    """Defaults are the usual names, and the thesis's chair (ChairGeometry.thesis)."""

    scan: str = "/scan"
    """Topic of sensor_msgs/LaserScan"""
    odometry: str = "/odom"
    """Topic of nav_msgs/Odometry"""
    joystick: str = "/joy"
    """Topic of sensor_msgs/Joy"""
    out: str = "/cmd_vel"
    """Topic of geometry_msgs/Twist, or TwistStamped"""
    stamped: bool = False
    """Commands are TwistStamped."""
    axes: tuple[int, int] = (1, 0)
    """Indices in Joy's axes of (forward, left)"""
    base: str | None = None
    """The frame of the axle's centre; None: the child frame that odometry names"""
    mounting: Pose2 | None = None
    """T_base_laser of an upright scanner; None: as /tf_static says"""
    footprint: Footprint = field(default_factory=Footprint)
    limits: MotionLimits = field(default_factory=MotionLimits)
    latency: float = 0.1
    """[s] from a command to the first motion that it causes"""
    scan_period: float = PERIOD
    """[s] between scans"""
    wait: float = 30.0
    """[s] of wall time within which all topics must have spoken"""

    def geometry(self, T_base_laser: Pose2) -> ChairGeometry:
        """The chair with its scanner mounted so. ValueError names a value out of range."""
        return ChairGeometry(
            footprint=self.footprint,
            limits=self.limits,
            T_base_laser=T_base_laser,
            latency=self.latency,
            scan_period=self.scan_period,
        )
