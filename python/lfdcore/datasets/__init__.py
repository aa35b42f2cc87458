"""Recorded drives and maps: one format of our own, readers for those of others."""

from lfdcore.datasets.carmen import read_carmen
from lfdcore.datasets.drive_log import DriveLog, DriveLogWriter, Intention, Plan
from lfdcore.datasets.drive_log_reader import read_drive_log
from lfdcore.datasets.formats import open_log
from lfdcore.datasets.maps import read_map, write_map
from lfdcore.datasets.motion import joystick_from_motion
from lfdcore.datasets.mrpt import read_mrpt
from lfdcore.datasets.rosbag import read_rosbag

__all__ = [
    "DriveLog",
    "DriveLogWriter",
    "Intention",
    "Plan",
    "joystick_from_motion",
    "open_log",
    "read_carmen",
    "read_drive_log",
    "read_map",
    "read_mrpt",
    "read_rosbag",
    "write_map",
]
