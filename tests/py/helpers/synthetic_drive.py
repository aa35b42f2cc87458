"""Drives in a corridor with a corner, made with a few lines of NumPy: what the learning parts are tested with."""

from dataclasses import dataclass, field

import numpy as np

from lfdcore.datasets.motion import windowed_twist
from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan

T_BASE_LASER = Pose2(0.70, 0.0, 0.0)
# an L of 2 m wide corridors: ahead along x, then to the left along y
L_WALLS = np.array(
    [
        [[-2, -1], [8, -1]],
        [[8, -1], [8, 9]],
        [[-2, 1], [6, 1]],
        [[6, 1], [6, 9]],
        [[-2, -1], [-2, 1]],
        [[6, 9], [8, 9]],
    ],
    dtype=float,
)


@dataclass
class SyntheticLog:
    """The fields of a DriveLog that learning reads."""

    scan_stamp: np.ndarray
    ranges: np.ndarray
    odometry_stamp: np.ndarray
    pose: np.ndarray
    joystick_stamp: np.ndarray = field(default_factory=lambda: np.zeros(0))
    joystick: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    angle_min: float = -np.pi / 2
    angle_increment: float = np.pi / 180
    range_min: float = 0.0
    range_max: float = 30.0
    T_base_laser: Pose2 = field(default_factory=lambda: T_BASE_LASER)
    name: str = "synthetic"
    metadata: dict[str, str] = field(default_factory=dict)

    @property
    def twist(self):
        return windowed_twist(self.odometry_stamp, np.c_[self.pose[:, :2], np.unwrap(self.pose[:, 2])])

    @property
    def mounting(self) -> Pose2:
        return self.T_base_laser

    def pose_at(self, t):
        unwrapped = np.c_[self.pose[:, :2], np.unwrap(self.pose[:, 2])]
        return np.stack([np.interp(t, self.odometry_stamp, unwrapped[:, k]) for k in range(3)], 1)

    def joystick_at(self, t):
        before = np.searchsorted(self.joystick_stamp, t, side="right") - 1
        return self.joystick[np.maximum(before, 0)]


def cast(origin, angles, walls):
    """Exact ranges [m] of rays from one point; inf = no wall."""
    along = np.stack([np.cos(angles), np.sin(angles)], 1)[:, None]
    start, edge = walls[:, 0] - origin, walls[:, 1] - walls[:, 0]
    cross = along[..., 0] * edge[:, 1] - along[..., 1] * edge[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / cross
        share = (start[:, 0] * along[..., 1] - start[:, 1] * along[..., 0]) / cross
    hit = (distance > 0) & (share >= 0) & (share <= 1)
    return np.where(hit, distance, np.inf).min(axis=1)


def scans_at(poses, walls, beams=181, T_base_laser=T_BASE_LASER):
    angles = np.linspace(-np.pi / 2, np.pi / 2, beams)
    lasers = [Pose2(*pose) * T_base_laser for pose in poses]
    return np.array([cast(np.array([p.x, p.y]), p.yaw + angles, walls) for p in lasers], dtype=np.float32)


def log_of(stamps, poses, joystick=None, walls=L_WALLS, **changes):
    """A log with a scan at each of the poses (T, 3)."""
    given = {} if joystick is None else {"joystick_stamp": stamps, "joystick": joystick}
    values = {"scan_stamp": stamps, "ranges": scans_at(poses, walls), "odometry_stamp": stamps, "pose": poses}
    return SyntheticLog(**{**values, **given, **changes})


def drive(segments, start=(0.0, 0.0, 0.0), step=0.1):
    """Segments (duration [s], v, w) -> stamps (T,), poses (T, 3), stick (T, 2) with limits of 1 m/s and 1 rad/s."""
    pose, poses, twists = Pose2(*start), [list(start)], []
    for duration, v, w in segments:
        for _ in range(round(duration / step)):
            turned = Pose2(v * step * np.sinc(w * step / 2 / np.pi) * np.cos(w * step / 2), 0, w * step)
            pose = pose * Pose2(turned.x, v * step * np.sinc(w * step / 2 / np.pi) * np.sin(w * step / 2), turned.yaw)
            poses.append([pose.x, pose.y, pose.yaw])
            twists.append([v, w])
    twists.append(twists[-1])
    return np.arange(len(poses)) * step, np.array(poses), np.array(twists)


def corner_drive(offset=0.0, speed=0.5):
    """Through the L with a left quarter circle of 1 m radius, `offset` [m] to the left of the middle."""
    radius = 1.0 - offset
    turn = np.pi / 2 / (speed / radius)
    segments = [(6.0 / speed, speed, 0.0), (turn, speed, speed / radius), (7.0 / speed, speed, 0.0), (1.5, 0.0, 0.0)]
    stamps, poses, stick = drive(segments, start=(0.0, offset, 0.0))
    return log_of(stamps, poses, stick)


AHEAD, LEFT = np.array([1.0, 0.0]), np.array([0.5, 0.5])
"""Sticks (forward, left)."""


def scan_at(x, y, yaw, beams=181, T_base_laser=T_BASE_LASER):
    """A scan between the walls of the L from a pose of base_link."""
    ranges = scans_at(np.array([[x, y, yaw]]), L_WALLS, beams, T_base_laser)[0]
    return LaserScan(ranges, -np.pi / 2, np.pi / (beams - 1), 0.0, 30.0)
