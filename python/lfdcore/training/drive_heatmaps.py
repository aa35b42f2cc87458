"""Learns the models of Ch. 4 from drive logs: the sensor heatmap and the joystick's meaning, or the naive network."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.safe_joystick import joystick_pairs
from lfdcore.training.gp_hyperparameters import HyperParameterConfig, fit_joystick_model
from lfdcore.training.heatmap_net import EpochLoss, HeatmapNetConfig, TrainedHeatmapNet, train_heatmap_net
from lfdcore.wheelchair.heatmap_model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmap_targets import HeatmapPairs, HeatmapTargetConfig, heatmap_pairs
from lfdcore.wheelchair.joystick_model import JoystickModel, JoystickModelConfig
from lfdcore.wheelchair.sensor_heatmap import NaiveHeatmap, SensorHeatmap

Progress = Callable[[str, int, int], None]
"""Told (stage, done, total)."""


@dataclass(frozen=True, kw_only=True)
class HeatmapLearningConfig:
    """Each part's own config; `thesis()` has the printed values."""

    targets: HeatmapTargetConfig = field(default_factory=HeatmapTargetConfig)
    network: HeatmapNetConfig = field(default_factory=HeatmapNetConfig)
    joystick: JoystickModelConfig = field(default_factory=JoystickModelConfig)
    hyper_parameters: HyperParameterConfig = field(default_factory=HyperParameterConfig)

    @staticmethod
    def thesis() -> HeatmapLearningConfig:
        """A zero prior and the bins' own variances as noise (Sec. 4.4.2)."""
        return HeatmapLearningConfig(joystick=JoystickModelConfig(prior="zero", noise="of_samples"))


@dataclass(frozen=True)
class LearnedHeatmaps:
    """model: to drive with; network: how its training went."""

    model: HeatmapModel
    network: TrainedHeatmapNet


def learn_heatmaps(
    logs: Sequence[DriveLog],
    config: HeatmapLearningConfig | None = None,
    progress: Progress | None = None,
    on_epoch: Callable[[EpochLoss], None] | None = None,
) -> LearnedHeatmaps:
    """From demonstrations with a joystick and commands (Sec. 4.2-4.4). ValueError as heatmap_pairs, joystick_pairs and
    train_heatmap_net."""
    config, tell = config or HeatmapLearningConfig(), progress or (lambda stage, done, total: None)
    joystick = learn_joystick(logs, config)
    pairs = heatmap_pairs(logs, config.targets, lambda done, total: tell("targets", done, total))
    network = train_heatmap_net(pairs, config.network, lambda done, total: tell("network", done, total), on_epoch)
    metadata = _metadata(logs, pairs, network)
    return LearnedHeatmaps(HeatmapModel(SensorHeatmap(network.onnx), joystick, metadata), network)


def learn_joystick(logs: Sequence[DriveLog], config: HeatmapLearningConfig) -> JoystickModel:
    """What drivers mean by the stick: raw against safe (Sec. 4.4.2)."""
    found = [joystick_pairs(log) for log in logs]
    raw, safe = (np.concatenate([getattr(pairs, name) for pairs in found]) for name in ("raw", "safe"))
    return fit_joystick_model(raw, safe, config.joystick, config.hyper_parameters)


def learn_naive_heatmap(
    logs: Sequence[DriveLog],
    config: HeatmapLearningConfig | None = None,
    progress: Progress | None = None,
    on_epoch: Callable[[EpochLoss], None] | None = None,
) -> tuple[NaiveHeatmapModel, TrainedHeatmapNet]:
    """The same network on scan and stick in one image, its target the driver's own way alone (Sec. 4.6.2)."""
    config, tell = config or HeatmapLearningConfig(), progress or (lambda stage, done, total: None)
    targets, settings = replace(config.targets, paths="own"), replace(config.network, kind="naive")
    pairs = heatmap_pairs(logs, targets, lambda done, total: tell("targets", done, total))
    network = train_heatmap_net(pairs, settings, lambda done, total: tell("network", done, total), on_epoch)
    return NaiveHeatmapModel(NaiveHeatmap(network.onnx), _metadata(logs, pairs, network)), network


def _metadata(logs: Sequence[DriveLog], pairs: HeatmapPairs, network: TrainedHeatmapNet) -> dict[str, Any]:
    """held_out: positions in `logs` of those that the network was validated on; losses: the learning curves."""
    return {
        "logs": [log.name for log in logs],
        "held_out": np.unique(pairs.log[network.validation]).tolist(),
        "pairs": len(pairs),
        "train_losses": [round(point.train, 6) for point in network.curve],
        "validation_losses": [round(point.validation, 6) for point in network.curve],
        "validation_loss": network.best.validation,
        "epochs": len(network.curve),
    }
