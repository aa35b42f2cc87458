"""A partner lifts something, the robot lifts along and turns its gripper: by how much, the environment says."""

from __future__ import annotations

import numpy as np

from lfdcore.datasets.interaction import InteractionRecording

SAMPLES, DURATION = 60, 2.0
PARTNER, ROBOT = ("hand.x", "hand.y"), ("gripper.x", "gripper.qx", "gripper.qy", "gripper.qz", "gripper.qw")


def lift(
    seed: int, samples: int = SAMPLES, duration: float = DURATION, height: float | None = None
) -> InteractionRecording:
    """One demonstration: the height [m] is drawn, or given, and is the environment."""
    random = np.random.default_rng(seed)
    drawn = random.uniform(0.5, 1.0)
    height = drawn if height is None else height
    u = np.linspace(0, 1, samples)
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    partner = np.stack([0.4 * s, height * s + 0.1 * np.sin(np.pi * s)], axis=1) + random.normal(0, 0.002, (samples, 2))
    half, zero = 0.5 * s * height, np.zeros(samples)
    robot = np.stack([1 - s * height, zero, zero, np.sin(half), np.cos(half)], axis=1)
    return InteractionRecording(
        duration * u, partner, robot, PARTNER, ROBOT, environment={"height": height}, name=f"lift {seed}"
    )


def lifts(count: int = 6) -> list[InteractionRecording]:
    """Different ones."""
    return [lift(seed) for seed in range(count)]
