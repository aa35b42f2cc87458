"""Recorded drives, maps and collaborations: formats of our own, readers for those of others."""

from lfdcore.datasets.carmen import read_carmen
from lfdcore.datasets.drive_log import DriveLog, DriveLogWriter, Intention, Plan
from lfdcore.datasets.drive_log_reader import read_drive_log
from lfdcore.datasets.followed_joystick import followed_pairs
from lfdcore.datasets.formats import open_log
from lfdcore.datasets.goals import Goal, Goals, read_goals, write_goals
from lfdcore.datasets.handovers import KTH_FAULTS, read_dynamic_handovers, read_kth_handovers
from lfdcore.datasets.interaction import InteractionRecording, environments, load_interaction
from lfdcore.datasets.lasa import Handwriting, read_all_handwriting, read_handwriting
from lfdcore.datasets.maps import read_map, write_map
from lfdcore.datasets.motion import full_deflection, joystick_from_motion
from lfdcore.datasets.mrpt import read_mrpt
from lfdcore.datasets.rosbag import read_rosbag
from lfdcore.datasets.safe_joystick import JoystickPairs, joystick_pairs, noted_limits, safe_joystick, twist_to_joystick

__all__ = [
    "KTH_FAULTS",
    "DriveLog",
    "DriveLogWriter",
    "Goal",
    "Goals",
    "Handwriting",
    "Intention",
    "InteractionRecording",
    "JoystickPairs",
    "Plan",
    "environments",
    "followed_pairs",
    "full_deflection",
    "joystick_from_motion",
    "joystick_pairs",
    "load_interaction",
    "noted_limits",
    "open_log",
    "read_all_handwriting",
    "read_carmen",
    "read_drive_log",
    "read_dynamic_handovers",
    "read_goals",
    "read_handwriting",
    "read_kth_handovers",
    "read_map",
    "read_mrpt",
    "read_rosbag",
    "safe_joystick",
    "twist_to_joystick",
    "write_goals",
    "write_map",
]
