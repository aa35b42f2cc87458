"""Drives to destinations in the open, quick to make: synthetic, with a joystick that does what it says."""

from __future__ import annotations

from functools import cache

import numpy as np

from lfdcore.datasets import DriveLog, Goal, Goals
from lfdcore.estimation import ActionKernel
from lfdcore.geometry import Pose2
from lfdcore.wheelchair.goals.model import GoalFilterConfig, GoalModel
from lfdcore.wheelchair.goals.network import GoalNetwork
from lfdcore.wheelchair.goals.samples import GoalSamples, goal_samples

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
        T_base_laser=Pose2(),
        name=f"drive-{goal}-{seed}",
        metadata={"destination": GOALS.names[goal]},
    )


def drives(each: int, first_seed: int = 1) -> list[DriveLog]:
    """`each` drives to every goal."""
    return [drive_to(goal, first_seed + 10 * k + goal) for k in range(each) for goal in range(len(GOALS))]


def samples_of(logs: list[DriveLog]) -> GoalSamples:
    """As learned from."""
    return goal_samples(logs, GOALS)


def tiny_model(count: int = 40, *, seed: int = 1, **config: object) -> GoalModel:
    """A model that nothing was learned for: samples of two drives to each goal, kernels and network as they come."""
    everything = samples_of(drives(2, first_seed=seed))
    samples = everything.where(np.linspace(0, len(everything) - 1, count).astype(np.int64))
    how = GoalFilterConfig(**config)
    width = 5 if how.heading == "raw" else 6
    rng = np.random.default_rng(seed)
    network = GoalNetwork(
        how.heading, np.zeros(width), np.ones(width), rng.normal(size=(4, width + 1)), rng.normal(size=(3, 5))
    )
    sizes = [2.0, 2.0, *[0.8] * (width - 4), 0.5, 1.0]
    kernels = (ActionKernel(0.5, sizes, [5.0, 5.0], 0.1), ActionKernel(0.4, sizes, [6.0, 4.0], 0.15))
    subset = rng.permutation(count)[: count // 2]
    return GoalModel(GOALS, samples, kernels, subset, network, how, metadata={"seed": seed})


@cache
def learned() -> GoalModel:
    """A model of three drives to every goal, learned in about a second; needs torch."""
    from lfdcore.training.goals import GoalLearningConfig, learn_goals
    from lfdcore.training.parts.goal_net import GoalNetConfig

    network = GoalNetConfig(epochs=30)
    config = GoalLearningConfig(network=network, search_samples=120, searches=1, generations=10, subset=120)
    return learn_goals(drives(3), GOALS, config)
