"""Where a scanner is mounted, from the transforms between frames that never change."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import Pose2

MOST_TILTED = math.radians(5)
"""A scanner tilted by more than this does not see the plane that the chair drives in."""
STILL = 1e-3
"""[m, and of a rotation's numbers] by which a transform that never changes may differ from its first"""
UNIT = 0.01
"""by which the length of a quaternion may differ from 1"""
MOST_JUMPS = 64
"""transforms between a frame and its root"""


@dataclass(frozen=True)
class Mounting:
    """Of a scanner on a chair."""

    T_base_laser: Pose2
    mirrored: bool = False
    """It hangs upside down: its angles grow clockwise as seen from above."""


class FrameTree:
    """The tree of frames, as far as it was said."""

    def __init__(self) -> None:
        self._above: dict[str, tuple[str, NDArray[np.float64]]] = {}

    def add(self, message: Any) -> None:
        """Takes in a tf2_msgs/TFMessage; of a frame that is said twice the later one counts."""
        for one in message.transforms:
            self.join(one.header.frame_id, one.child_frame_id, matrix_of(one.transform))

    def join(self, parent: str, child: str, T_parent_child: NDArray[np.float64]) -> None:
        """Takes in one transform (4, 4)."""
        self._above[frame_name(child)] = (frame_name(parent), T_parent_child)

    def transform(self, base: str, frame: str) -> NDArray[np.float64] | None:
        """T_base_frame (4, 4); None where nothing joins the two. A frame is joined to itself."""
        base_root, T_root_base = self._climb(frame_name(base))
        frame_root, T_root_frame = self._climb(frame_name(frame))
        return np.linalg.inv(T_root_base) @ T_root_frame if base_root == frame_root else None

    def _climb(self, frame: str) -> tuple[str, NDArray[np.float64]]:
        """The frame's root, and where the frame is in it. ValueError for transforms that run in a circle."""
        T = np.eye(4)
        for _ in range(MOST_JUMPS):
            if frame not in self._above:
                return frame, T
            frame, step = self._above[frame]
            T = step @ T
        raise ValueError(f"the frames above {frame!r} run in a circle, or are more than {MOST_JUMPS}")


class WatchedFrames:
    """Transforms that are said again and again (/tf): which of them never change and, with `ways`, the way of those
    that do."""

    def __init__(self, *, ways: bool) -> None:
        self._ways = ways
        self._first: dict[tuple[str, str], NDArray[np.float64]] = {}
        self._moving: set[tuple[str, str]] = set()
        self._said: dict[tuple[str, str], list[tuple[int, int, Pose2]]] = {}

    def add(self, message: Any, received: int) -> None:
        """Takes in a tf2_msgs/TFMessage that was received at a time [ns]."""
        for one in message.transforms:
            pair = frame_name(one.header.frame_id), frame_name(one.child_frame_id)
            T = matrix_of(one.transform)
            first = self._first.setdefault(pair, T)
            if not np.allclose(first, T, rtol=0, atol=STILL):
                self._moving.add(pair)
            if not self._ways:
                continue
            planar = Pose2(T[0, 3], T[1, 3], math.atan2(T[1, 0], T[0, 0]))
            self._said.setdefault(pair, []).append((nanoseconds(one.header.stamp), received, planar))

    def join_fixed(self, tree: FrameTree) -> None:
        """Gives a tree those that never changed, and that it does not know yet."""
        for (parent, child), T in self._first.items():
            if (parent, child) not in self._moving and tree.transform(parent, child) is None:
                tree.join(parent, child, T)

    def moving(self) -> dict[tuple[str, str], list[tuple[int, int, Pose2]]]:
        """Of each (parent, child) that moves: (header stamp [ns], received [ns], T_parent_child)."""
        return {pair: self._said[pair] for pair in sorted(self._moving & self._said.keys())}


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


def nanoseconds(time: Any) -> int:
    """A builtin_interfaces/Time as one number [ns]."""
    return int(time.sec) * 1_000_000_000 + int(time.nanosec)


def frame_name(frame: str) -> str:
    """As tf2 has it: ROS 1's leading slash means nothing."""
    return frame.lstrip("/")


def matrix_of(transform: Any) -> NDArray[np.float64]:
    """(4, 4) of a geometry_msgs/Transform; NaN where its rotation is none (its length is not 1 within 1 %)"""
    q, t = transform.rotation, transform.translation
    norm = math.hypot(q.x, q.y, q.z, q.w)
    x, y, z, w = (value / norm if abs(norm - 1) < UNIT else math.nan for value in (q.x, q.y, q.z, q.w))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t.z],
            [0, 0, 0, 1],
        ]
    )
