"""Which frames a robot's messages are of, and so where its scanner is. What is not said is not assumed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lfdcore.datasets.frame_tree import FrameTree, Mounting, mounting_of
from lfdcore.ros.options import NodeOptions

SAME = 1e-3
"""[m, rad] by which two frames may differ that are one"""


@dataclass(frozen=True)
class Frames:
    """What the messages must say that they are of; a message of another frame is not listened to."""

    scan: str
    odometry: str
    base: str
    """The odometry's child frame"""


def frames_of(scan: Any, odometry: Any, options: NodeOptions, statics: FrameTree) -> Frames:
    """Of a sensor_msgs/LaserScan and a nav_msgs/Odometry. ValueError where odometry does not say what it is of, or says
    that it is of a frame that is not in the place of the base that was asked for."""
    topic, child, base = options.odometry, odometry.child_frame_id, options.base
    if not odometry.header.frame_id:
        raise ValueError(f"{topic} names no frame_id, so nobody knows what its poses are in")
    if not child and base is None:
        raise ValueError(f"{topic} names no child_frame_id: say --base FRAME")
    if child and base is not None and not _are_one(statics, base, child):
        raise ValueError(f"{topic} is of {child}, not of --base {base} or a frame in its place")
    return Frames(scan.header.frame_id, odometry.header.frame_id, child)


def scan_mounting(scan: Any, odometry: Any, options: NodeOptions, statics: FrameTree) -> Mounting:
    """As given, else as /tf_static says. ValueError where it does not say it, and for a tilted scanner."""
    if options.mounting is not None:
        return Mounting(options.mounting)
    frame, base = scan.header.frame_id, options.base or odometry.child_frame_id
    if not frame:
        raise ValueError(f"{options.scan} names no frame_id: say --mounting X,Y,YAW")
    T = statics.transform(base, frame)
    if T is None:
        raise ValueError(f"/tf_static does not join {frame} to {base}: say --mounting X,Y,YAW, or --base FRAME")
    return mounting_of(T)


def _are_one(statics: FrameTree, base: str, child: str) -> bool:
    """Whether two frames are one in the plane: odometry of the one then says where the other is."""
    T = statics.transform(base, child)
    if T is None:
        return False
    there = mounting_of(T)
    return not there.mirrored and all(abs(value) <= SAME for value in there.T_base_laser)
