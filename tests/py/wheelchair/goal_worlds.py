"""Drives to destinations in the open, quick to make: synthetic, with a joystick that does what it says."""

from __future__ import annotations

import numpy as np

from lfdcore.datasets import DriveLog, Goal, Goals
from lfdcore.wheelchair.goal_samples import GoalSamples, goal_samples

GOALS = Goals((Goal("left", 6.0, 4.0), Goal("ahead", 9.0, 0.0), Goal("right", 6.0, -4.0)))


def drive_to(goal: int, seed: int, *, period: float = 0.1, speed: float = 0.6) -> DriveLog:
    """Straight on for 2 m, then turning towards the goal: at the beginning nobody can tell."""
    rng = np.random.default_rng(seed)
    target = GOALS.positions[goal]
    x, y, yaw = rng.normal(0, 0.1), rng.normal(0, 0.2), rng.normal(0, 0.05)
    poses, sticks = [], []
    while np.hypot(target[0] - x, target[1] - y) > 0.5 and len(poses) < 400:
        off = np.arctan2(target[1] - y, target[0] - x) - yaw if x > 2 else -0.3 * y - yaw
        left = float(np.clip(np.arctan2(np.sin(off), np.cos(off)) + rng.normal(0, 0.05), -1, 1))
        poses.append((x, y, yaw))
        sticks.append((0.6 + rng.normal(0, 0.02), left))
        yaw += left * period
        x, y = x + speed * period * np.cos(yaw), y + speed * period * np.sin(yaw)
    stamp = np.arange(len(poses)) * period
    pose, stick = np.array(poses), np.array(sticks)
    return DriveLog(
        scan_stamp=stamp[:1],
        ranges=np.full((1, 3), 5.0, np.float32),
        odometry_stamp=stamp,
        pose=pose,
        twist=np.column_stack([np.full(len(pose), speed), stick[:, 1]]),
        joystick_stamp=stamp,
        joystick=stick.clip(-1, 1),
        map_stamp=np.zeros(1),
        map_odom=np.zeros((1, 3)),
        name=f"drive-{goal}-{seed}",
        metadata={"destination": GOALS.names[goal]},
    )


def drives(each: int, first_seed: int = 1) -> list[DriveLog]:
    """`each` drives to every goal."""
    return [drive_to(goal, first_seed + 10 * k + goal) for k in range(each) for goal in range(len(GOALS))]


def samples_of(logs: list[DriveLog]) -> GoalSamples:
    """As learned from."""
    return goal_samples(logs, GOALS)
