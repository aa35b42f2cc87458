"""
Planar poses, twists, paths and the chair's outline.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "Footprint",
    "MotionLimits",
    "Pose2",
    "Twist2",
    "approach",
    "arc_length",
    "integrate",
    "resample",
    "wrap_angle",
]

class Pose2:
    """
    Position x, y [m] and heading yaw [rad]; T_a_b maps coordinates of frame b into frame a.
    """

    def __init__(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[float]:
        """
        x, y, yaw in turn, so that tuple(pose) and numpy.array([*pose]) work.
        """

    def __mul__(self, arg0: Pose2) -> Pose2:
        """
        T_a_c = T_a_b * T_b_c
        """

    def __repr__(self) -> str: ...
    def inverse(self) -> Pose2:
        """
        T_b_a
        """

    def transform(self, points: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Points (N, 2) [m] of frame b in frame a.
        """

    @property
    def x(self) -> float:
        """
        [m]
        """

    @x.setter
    def x(self, arg0: float) -> None: ...
    @property
    def y(self) -> float:
        """
        [m]
        """

    @y.setter
    def y(self, arg0: float) -> None: ...
    @property
    def yaw(self) -> float:
        """
        [rad]
        """

    @yaw.setter
    def yaw(self, arg0: float) -> None: ...

class Twist2:
    """
    Velocity of a differential drive: linear [m/s] ahead, angular [rad/s] anticlockwise.
    """

    def __init__(self, linear: float = 0.0, angular: float = 0.0) -> None: ...
    def __iter__(self) -> collections.abc.Iterator[float]: ...
    def __repr__(self) -> str: ...
    @property
    def angular(self) -> float:
        """
        [rad/s]
        """

    @angular.setter
    def angular(self, arg0: float) -> None: ...
    @property
    def linear(self) -> float:
        """
        [m/s]
        """

    @linear.setter
    def linear(self, arg0: float) -> None: ...

class Footprint:
    """
    A rectangle around the axle's centre: front, rear and half_width [m]. Default: the CAS chair (Sec. 3.2), 0.8 m from axle to front edge, 0.7 m wide.
    """

    def __init__(self, front: float = 0.8, rear: float = 0.35, half_width: float = 0.35) -> None: ...
    def __repr__(self) -> str: ...
    def corners(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (4, 2) [m] in base_link, anticlockwise from the front left.
        """

    def grown(self, margin: float) -> Footprint:
        """
        The rectangle grown by a margin [m] on every side.
        """

    def outer_radius(self) -> float:
        """
        Radius [m] of the circle around the axle that holds it.
        """

    @property
    def front(self) -> float:
        """
        [m]
        """

    @front.setter
    def front(self, arg0: float) -> None: ...
    @property
    def half_width(self) -> float:
        """
        [m]
        """

    @half_width.setter
    def half_width(self, arg0: float) -> None: ...
    @property
    def rear(self) -> float:
        """
        [m]
        """

    @rear.setter
    def rear(self, arg0: float) -> None: ...

class MotionLimits:
    """
    Speeds [m/s, rad/s] and accelerations [m/s^2, rad/s^2] of the chair, all positive.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        max_linear: float = 1.0,
        max_reverse: float = 0.4,
        max_angular: float = 1.0,
        linear_acceleration: float = 0.8,
        linear_braking: float = 1.5,
        angular_acceleration: float = 2.5,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def angular_acceleration(self) -> float:
        """
        either way [rad/s^2]
        """

    @property
    def linear_acceleration(self) -> float:
        """
        speeding up [m/s^2]
        """

    @property
    def linear_braking(self) -> float:
        """
        slowing down [m/s^2]
        """

    @property
    def max_angular(self) -> float:
        """
        [rad/s]
        """

    @property
    def max_linear(self) -> float:
        """
        ahead [m/s]
        """

    @property
    def max_reverse(self) -> float:
        """
        backwards [m/s], positive
        """

def approach(current: Twist2, wanted: Twist2, limits: MotionLimits, duration: float) -> Twist2:
    """
    The twist after `duration` [s] of changing `current` towards `wanted` as fast as the limits allow; `wanted` beyond the speed limits is cut to them.
    """

def arc_length(path: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    Distance [m] travelled up to each point of a path (N, 2) -> (N,).
    """

def integrate(pose: Pose2, twist: Twist2, duration: float) -> Pose2:
    """
    The pose after following a constant twist for a duration [s], exactly (a circular arc).
    """

def resample(path: numpy.typing.ArrayLike, count: int) -> numpy.typing.NDArray[numpy.float64]:
    """
    The path (N, 2) [m] at `count` (2 to 1 000 000) points equally spaced by arc length -> (count, 2). ValueError for other counts, a path without points, and points or a length that are not finite.
    """

def wrap_angle(angle: numpy.typing.ArrayLike) -> typing.Any:
    """
    The same angle(s) [rad] in (-pi, pi].
    """
