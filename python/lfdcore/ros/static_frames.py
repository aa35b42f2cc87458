"""Where a scanner is mounted, from the transforms that never change (/tf_static)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2

MOST_TILTED = math.radians(5)
"""A scanner tilted by more than this does not see the plane that the chair drives in."""
MOST_JUMPS = 64
"""transforms between a frame and its root"""


@dataclass(frozen=True)
class Mounting:
    """Of a scanner on a chair."""

    T_base_laser: Pose2
    mirrored: bool = False
    """It hangs upside down: its angles grow clockwise as seen from above."""


class StaticFrames:
    """The tree of frames, as far as it was said."""

    def __init__(self) -> None:
        self._above: dict[str, tuple[str, NDArray[np.float64]]] = {}

    def add(self, message: Any) -> None:
        """Takes in a tf2_msgs/TFMessage; of a frame that is said twice the later one counts."""
        for one in message.transforms:
            self._above[_name(one.child_frame_id)] = (_name(one.header.frame_id), _matrix(one.transform))

    def transform(self, base: str, frame: str) -> NDArray[np.float64] | None:
        """T_base_frame (4, 4); None where nothing static joins the two. A frame is joined to itself."""
        base_root, T_root_base = self._climb(_name(base))
        frame_root, T_root_frame = self._climb(_name(frame))
        return np.linalg.inv(T_root_base) @ T_root_frame if base_root == frame_root else None

    def _climb(self, frame: str) -> tuple[str, NDArray[np.float64]]:
        """The frame's root, and where the frame is in it. ValueError for transforms that run in a circle."""
        T = np.eye(4)
        for _ in range(MOST_JUMPS):
            if frame not in self._above:
                return frame, T
            frame, step = self._above[frame]
            T = step @ T
        raise ValueError(f"/tf_static: the frames above {frame!r} run in a circle, or are more than {MOST_JUMPS}")


def mounting_of(T: NDArray[np.float64]) -> Mounting:
    """The mounting of a scanner at T_base_laser (4, 4), upright or upside down. ValueError for one that is tilted, and
    for a transform that is not finite."""
    if not np.isfinite(T).all():
        raise ValueError("the transform from the scanner to the chair is not finite")
    tilt = math.acos(min(1.0, abs(float(T[2, 2]))))
    if tilt > MOST_TILTED:
        raise ValueError(
            f"the scanner is tilted by {math.degrees(tilt):.1f} degrees, must be level within "
            f"{math.degrees(MOST_TILTED):g}: its ranges are not of the plane that the chair drives in"
        )
    yaw = math.atan2(T[1, 0], T[0, 0])
    return Mounting(Pose2(float(T[0, 3]), float(T[1, 3]), yaw), mirrored=bool(T[2, 2] < 0))


def _name(frame: str) -> str:
    return frame.lstrip("/")


def _matrix(transform: Any) -> NDArray[np.float64]:
    """(4, 4); NaN for what is no rotation"""
    q, t = transform.rotation, transform.translation
    norm = math.hypot(q.x, q.y, q.z, q.w)
    x, y, z, w = (value / norm if abs(norm - 1) < 0.01 else math.nan for value in (q.x, q.y, q.z, q.w))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t.z],
            [0, 0, 0, 1],
        ]
    )
