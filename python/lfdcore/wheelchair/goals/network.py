"""Destinations from pose and joystick by a small network (Sec. 2.2, App. C.2): 15 hidden neurons, greedy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.wheelchair.goals.samples import Heading, pose_features

Floats = NDArray[np.float64]


def sigmoid(z: Floats) -> Floats:
    """C.1, without overflow."""
    return np.asarray(0.5 * (1 + np.tanh(0.5 * z)))


@dataclass(frozen=True)
class GoalNetwork:
    """Inference without torch. Inputs are standardised by `centre` and `scale` (D,), D = 6 (5 with a raw heading)."""

    heading: Heading
    centre: Floats
    scale: Floats
    hidden: Floats
    """(H, D + 1) weights of the hidden neurons, the bias last"""
    output: Floats
    """(L, H + 1) weights of the destinations' neurons, the bias last"""

    def __post_init__(self) -> None:
        width = 5 if self.heading == "raw" else 6
        neurons = len(self.hidden)
        shapes = {"centre": (width,), "scale": (width,), "hidden": (neurons, width + 1)}
        shapes["output"] = (len(self.output), neurons + 1)
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(f"{name} must be finite and {shape}, is {values.shape}")
        if not (self.scale > 0).all():
            raise ValueError(f"scale must be positive, is {self.scale.tolist()}")

    def predict(self, poses: ArrayLike, joysticks: ArrayLike) -> Floats:
        """Poses (N, 3) in the map and sticks (N, 2) -> likelihoods (N, L), each in (0, 1). ValueError if not finite."""
        inputs = network_inputs(np.asarray(poses, float), np.asarray(joysticks, float), self.heading)
        if not np.isfinite(inputs).all():
            raise ValueError("poses and joysticks must be finite")
        return sigmoid(_weighted(sigmoid(_weighted((inputs - self.centre) / self.scale, self.hidden)), self.output))


def network_inputs(poses: Floats, joysticks: Floats, heading: Heading) -> Floats:
    """(N, D): pose, then forward and left."""
    if poses.ndim != 2 or poses.shape[1:] != (3,) or joysticks.shape != (len(poses), 2):
        raise ValueError(f"poses must be (N, 3) and joysticks (N, 2), are {poses.shape} and {joysticks.shape}")
    return np.column_stack([pose_features(poses, heading), joysticks])


def _weighted(values: Floats, weights: Floats) -> Floats:
    return values @ weights[:, :-1].T + weights[:, -1]


def smoothed_over_time(likelihoods: Floats, period: float, time_constant: float) -> Floats:
    """Estimates (T, L) every `period` [s] through a first-order low-pass of `time_constant` [s] (end of Sec. 2.2).

    The first stays as it is; 0 leaves all as they are. ValueError for a negative time constant or a period <= 0.
    """
    if not (0 < period < np.inf and 0 <= time_constant < np.inf):
        raise ValueError(f"period is {period} s and time_constant {time_constant} s, must be > 0 and >= 0, finite")
    share = 1 - np.exp(-period / time_constant) if time_constant > 0 else 1.0
    filtered = np.array(likelihoods, float)
    for t in range(1, len(filtered)):
        filtered[t] = filtered[t - 1] + share * (filtered[t] - filtered[t - 1])
    return filtered
