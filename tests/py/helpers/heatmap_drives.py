"""Small drives through the synthetic corridor, as real DriveLogs: what the heatmaps are tested with."""

import numpy as np

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Pose2
from synthetic_drive import L_WALLS, drive, log_of


def corridor_log(segments, start=(0.0, 0.0, 0.0), walls=L_WALLS, name="corridor", **metadata) -> DriveLog:
    """A drive with a scan every .1 s; start: base_link in the corridor's frame, where the odometry is 0. metadata:
    place="L" relates it to other logs."""
    stamps, poses, stick = drive(segments, start)
    seen = log_of(stamps, poses, stick, walls)
    odom = Pose2(*start).inverse()
    local = [tuple(odom * Pose2(*pose)) for pose in poses]
    if metadata:
        metadata["T_place_odom"] = " ".join(str(float(value)) for value in start)
    return DriveLog(
        scan_stamp=stamps,
        ranges=seen.ranges,
        angle_min=seen.angle_min,
        angle_increment=seen.angle_increment,
        T_base_laser=seen.T_base_laser,
        odometry_stamp=stamps,
        pose=np.array(local),
        twist=np.zeros((len(stamps), 2)),
        joystick_stamp=stamps,
        joystick=np.clip(stick, -1, 1),
        metadata=metadata,
        name=name,
    )


def around_the_corner(speed=1.0, start=(0.0, 0.0, 0.0), **metadata) -> DriveLog:
    """6.2 m ahead (at 1 m/s), a quarter turn to the left of radius .8 m, 3 m on."""
    turn = np.pi / 2 / 1.2
    return corridor_log([(6.2, speed, 0.0), (turn, 0.96, 1.2), (3.0, speed, 0.0)], start, **metadata)
