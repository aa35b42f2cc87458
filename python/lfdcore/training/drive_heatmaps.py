"""lfdcore learn drive --method heatmaps, naive: where drivers go, and what their stick means (Sec. 4.2-4.4, 4.6.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.followed_joystick import followed_pairs
from lfdcore.datasets.motion import full_deflection
from lfdcore.datasets.safe_joystick import JoystickPairs, joystick_pairs, notes_limits
from lfdcore.geometry import arc_length
from lfdcore.progress import StageProgress, silent
from lfdcore.training.parts.gp_hyperparameters import STICK_SEARCH, HyperParameterConfig, fit_joystick_model
from lfdcore.training.parts.heatmap_net import HeatmapNetConfig, TrainedHeatmapNet, train_heatmap_net
from lfdcore.training.parts.heatmap_targets import HeatmapPairs, HeatmapTargetConfig, heatmap_pairs
from lfdcore.wheelchair.heatmaps.joystick import JoystickModel, JoystickModelConfig
from lfdcore.wheelchair.heatmaps.model import HeatmapModel, NaiveHeatmapModel
from lfdcore.wheelchair.heatmaps.sensor import NaiveHeatmap, SensorHeatmap
from lfdcore.wheelchair.window import WINDOW

_MOST_OWN = 20_000  # pairs, of 30 kB each, but for those that turns on the spot add


@dataclass(frozen=True, kw_only=True)
class HeatmapLearningConfig:
    """Each part's own config; `thesis()` has the printed values."""

    targets: HeatmapTargetConfig = field(default_factory=HeatmapTargetConfig)
    network: HeatmapNetConfig = field(default_factory=HeatmapNetConfig)
    joystick: JoystickModelConfig = field(default_factory=JoystickModelConfig)
    hyper_parameters: HyperParameterConfig = STICK_SEARCH

    @staticmethod
    def thesis() -> HeatmapLearningConfig:
        """A zero prior and the bins' own variances as noise (Sec. 4.4.2)."""
        return HeatmapLearningConfig(joystick=JoystickModelConfig(prior="zero", noise="of_samples"))

    def for_logs(self, logs: Sequence[DriveLog]) -> HeatmapLearningConfig:
        """Unchanged where every log names a place (see heatmap_targets). Else there is but one way a scan: targets are
        the driver's own ways from scans .05 m apart (farther on more than 1 km of way, so that memory is bounded), and
        the network, that sees each of them in nearly the same scans again and again, learns for 12 epochs with weights
        kept small (found by blocks inside freiburg-079's first 70 %, see docs/real-logs.md)."""
        if all("place" in log.metadata for log in logs):
            return self
        targets = replace(self.targets, paths="own", spacing=_own_spacing(logs))
        return replace(self, targets=targets, network=replace(self.network, epochs=12, weight_decay=1e-2))


def _own_spacing(logs: Sequence[DriveLog]) -> float:
    way = sum(float(arc_length(log.pose[:, :2])[-1]) for log in logs if len(log.pose))
    return float(np.clip(way / _MOST_OWN, 0.05, WINDOW))


Model = TypeVar("Model", HeatmapModel, NaiveHeatmapModel)


@dataclass(frozen=True)
class LearnedHeatmaps(Generic[Model]):
    """model: to drive or predict with; network: how its training went."""

    model: Model
    network: TrainedHeatmapNet


def learn_heatmaps(
    logs: Sequence[DriveLog],
    config: HeatmapLearningConfig | None = None,
    progress: StageProgress | None = None,
) -> LearnedHeatmaps[HeatmapModel]:
    """From demonstrations with a joystick (Sec. 4.2-4.4). ValueError as heatmap_pairs, learn_joystick and
    train_heatmap_net."""
    config, tell = config or HeatmapLearningConfig(), progress or silent
    pairs = heatmap_pairs(logs, config.targets, partial(tell, "targets"))
    joystick = learn_joystick(logs, config)
    network = train_heatmap_net(pairs, config.network, partial(tell, "network"))
    metadata = _metadata(logs, pairs, network)
    return LearnedHeatmaps(HeatmapModel(SensorHeatmap(network.onnx), joystick, metadata), network)


def learn_joystick(logs: Sequence[DriveLog], config: HeatmapLearningConfig) -> JoystickModel:
    """What drivers mean by the stick: raw against safe (Sec. 4.4.2) or, where a log has no commands or does not note
    what full stick meant, against followed. ValueError for a log without joystick, if no log has a pair, or if the
    stick is at rest in all of them."""
    found = [_pairs(log) for log in logs]
    raw, safe = (np.concatenate([getattr(pairs, name) for pairs in found]) for name in ("raw", "safe"))
    if len(raw) and not raw.any():
        raise ValueError(f"the joystick is at rest in all {len(raw)} pairs: what it means cannot be learned from that")
    return fit_joystick_model(raw, safe, config.joystick, config.hyper_parameters)


def _pairs(log: DriveLog) -> JoystickPairs:
    if len(log.command_stamp) and notes_limits(log):
        return joystick_pairs(log)
    return followed_pairs(log, full_deflection(log))


def learn_naive_heatmap(
    logs: Sequence[DriveLog],
    config: HeatmapLearningConfig | None = None,
    progress: StageProgress | None = None,
) -> LearnedHeatmaps[NaiveHeatmapModel]:
    """The same network on scan and stick in one image, its target the driver's own way alone (Sec. 4.6.2)."""
    config, tell = config or HeatmapLearningConfig(), progress or silent
    targets, settings = replace(config.targets, paths="own"), replace(config.network, kind="naive")
    pairs = heatmap_pairs(logs, targets, partial(tell, "targets"))
    network = train_heatmap_net(pairs, settings, partial(tell, "network"))
    model = NaiveHeatmapModel(NaiveHeatmap(network.onnx), _metadata(logs, pairs, network))
    return LearnedHeatmaps(model, network)


def _metadata(logs: Sequence[DriveLog], pairs: HeatmapPairs, network: TrainedHeatmapNet) -> dict[str, Any]:
    """held_out: positions in `logs` of those that the network was validated on; losses: the learning curves;
    full_deflection: what the stick asked for when pushed fully, [m/s, rad/s] a log."""
    return {
        "logs": [log.name for log in logs],
        "full_deflection": [[*full_deflection(log)] for log in logs],
        "held_out": np.unique(pairs.log[network.validation]).tolist(),
        "pairs": len(pairs),
        "train_losses": [round(point.train, 6) for point in network.curve],
        "validation_losses": [round(point.validation, 6) for point in network.curve],
        "validation_loss": network.best.validation,
        "epochs": len(network.curve),
    }
