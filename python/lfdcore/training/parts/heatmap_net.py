"""The sensor heatmap's network (Sec. 4.3): trained with torch, handed over as ONNX bytes.

Topology (that of Fig. 4.8 is not in the text; fully convolutional, W = `width`):

    free space 1 x 100 x 100
    conv 5 x 5, stride 2         W/2 x 50 x 50    ----------------.
    conv 3 x 3, stride 2         W   x 25 x 25                    |
    + x, y of the cell           W+2 x 25 x 25                    |
    4 conv 3 x 3, dilated 1, 2, 4, 8, each but the first added to what it took
    conv 3 x 3, sub-pixel        W/2 x 50 x 50                    |
    beside the first layer's     W   x 50 x 50    <---------------'
    conv 3 x 3                   W/2 x 50 x 50
    conv 3 x 3, sub-pixel        1   x 100 x 100, sigmoid

ReLU after every convolution but the last. The dilated ones see the whole window from every cell. x and y are given
because a heatmap is about places relative to the chair, which a convolution alone cannot know.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from torch import Tensor, nn
from torch.nn import functional

from lfdcore.progress import Progress, silent
from lfdcore.training.parts.heatmap_targets import HeatmapPairs
from lfdcore.wheelchair.heatmaps.sensor import INPUT, METADATA_KEY, OUTPUT, VERSION, naive_images
from lfdcore.wheelchair.window import CELLS, RESOLUTION

OPSET, IR_VERSION = 17, 8
"""Fixed, so that the same weights give the same bytes whatever versions are installed."""
COARSE = CELLS // 4
DILATIONS = (1, 2, 4, 8)
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class HeatmapNetConfig:
    """kind: `sensor` sees the free space, `naive` the joystick beside it (Sec. 4.6.2); validation: share of the runs
    that early stopping looks at; patience: epochs without improvement after which it stops; threads: of torch (the
    bytes depend on their number; more than one crawls on a machine that is busy with other work)."""

    kind: Literal["sensor", "naive"] = "sensor"
    width: int = 24
    epochs: int = 10
    batch: int = 32
    learning_rate: float = 3e-3
    weight_decay: float = 1e-4
    patience: int = 3
    validation: float = 0.15
    mirror: bool = True
    seed: int = 0
    threads: int = 1

    def __post_init__(self) -> None:
        if self.kind not in ("sensor", "naive"):
            raise ValueError(f"kind is {self.kind!r}, must be 'sensor' or 'naive'")
        if self.width < 2 or self.width % 2:
            raise ValueError(f"width is {self.width} channels, must be even and at least 2")
        for name in ("epochs", "batch", "patience", "threads"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1")
        if not 0 < self.learning_rate < np.inf or not 0 <= self.weight_decay < np.inf:
            raise ValueError(f"learning_rate {self.learning_rate} and weight_decay {self.weight_decay} cannot be used")
        if not 0 < self.validation < 1:
            raise ValueError(f"validation is a share of {self.validation}, must lie between 0 and 1")


@dataclass(frozen=True)
class EpochLoss:
    """A point of the learning curves: mean binary cross-entropy a cell after `epoch` (from 1 on)."""

    epoch: int
    train: float
    validation: float


@dataclass(frozen=True)
class TrainedHeatmapNet:
    """onnx: the model (SensorHeatmap and NaiveHeatmap run it); curve: the epochs (`best` was kept); validation
    (N,): which pairs were not trained on; seconds: how long it took; net: the torch module, in evaluation mode."""

    onnx: bytes
    curve: tuple[EpochLoss, ...]
    best: EpochLoss
    validation: Mask
    seconds: float
    net: HeatmapNet


class HeatmapNet(nn.Module):
    """See the module. (B, 1, 100, 100) -> logits (B, 1, 100, 100)."""

    place: Tensor

    def __init__(self, width: int) -> None:
        super().__init__()
        half = width // 2
        self.first = nn.Conv2d(1, half, 5, stride=2, padding=2)
        self.second = nn.Conv2d(half, width, 3, stride=2, padding=1)
        inputs = [width + 2, *[width] * (len(DILATIONS) - 1)]
        self.middle = nn.ModuleList(
            nn.Conv2d(n, width, 3, padding=d, dilation=d) for n, d in zip(inputs, DILATIONS, strict=True)
        )
        self.up = nn.Conv2d(width, 4 * half, 3, padding=1)
        self.join = nn.Conv2d(width, half, 3, padding=1)
        self.last = nn.Conv2d(half, 4, 3, padding=1)
        self.register_buffer("place", _place())

    def forward(self, free: Tensor) -> Tensor:
        fine = functional.relu(self.first(free))
        coarse = functional.relu(self.second(fine))
        here = self.place.expand(len(free), -1, -1, -1)
        wide = functional.relu(self.middle[0](torch.cat([coarse, here], 1)))
        for layer in list(self.middle)[1:]:
            wide = wide + functional.relu(layer(wide))
        up = functional.relu(functional.pixel_shuffle(self.up(wide), 2))
        joined = functional.relu(self.join(torch.cat([up, fine], 1)))
        return functional.pixel_shuffle(self.last(joined), 2)


def _place() -> Tensor:
    """(1, 2, 25, 25): x, y of the coarse cells in [-1, 1]"""
    at = (torch.arange(COARSE) + 0.5) * (2 / COARSE) - 1
    y, x = torch.meshgrid(at, at, indexing="ij")
    return torch.stack([x, y])[None]


def train_heatmap_net(
    pairs: HeatmapPairs,
    config: HeatmapNetConfig | None = None,
    progress: Progress | None = None,
    validation: Mask | None = None,
) -> TrainedHeatmapNet:
    """Trains until the validation loss has not fallen for `patience` epochs and keeps the best one.

    progress(done, total) counts batches and ends at total; on_epoch gets every point of the learning curves;
    validation (N,): pairs to hold out, by default those of a share of the logs (of a single log: its last scans). The
    same pairs, config and torch build give the same bytes. ValueError for fewer than 2 pairs, a validation mask that
    leaves nothing on one side, a naive net without any joystick.
    """
    config = config or HeatmapNetConfig()
    held_out = _held_out(pairs, config) if validation is None else np.asarray(validation, bool)
    _check(pairs, held_out, config)
    started = time.perf_counter()
    with _deterministic(config):
        net = HeatmapNet(config.width)
        # a quarter faster on CPUs
        net.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        curve, best = _Training(net, pairs, config, progress).run(~held_out, held_out)
    net.eval()
    model = export_onnx(net, config.kind, {"config": dataclasses.asdict(config), "data_hash": _hash(pairs)})
    return TrainedHeatmapNet(model, curve, best, held_out, time.perf_counter() - started, net)


def _check(pairs: HeatmapPairs, held_out: Mask, config: HeatmapNetConfig) -> None:
    if held_out.shape != (len(pairs),):
        raise ValueError(f"validation has shape {held_out.shape}, must be ({len(pairs)},)")
    if not held_out.any() or held_out.all():
        raise ValueError(f"{held_out.sum()} of {len(pairs)} pairs are held out, must be at least 1 and not all")
    if config.kind == "naive" and not pairs.joystick.any():
        raise ValueError("the joystick is centred in all pairs: a naive net has nothing to learn from it")


def _held_out(pairs: HeatmapPairs, config: HeatmapNetConfig) -> Mask:
    if len(pairs) < 2:
        raise ValueError(f"{len(pairs)} training pairs, at least 2 are needed (one to validate with)")
    logs = np.unique(pairs.log)
    if len(logs) == 1:
        return np.asarray(np.arange(len(pairs)) >= min(len(pairs) - 1, round((1 - config.validation) * len(pairs))))
    count = min(max(1, round(config.validation * len(logs))), len(logs) - 1)
    return np.isin(pairs.log, np.random.default_rng(config.seed).permutation(logs)[:count])


@contextmanager
def _deterministic(config: HeatmapNetConfig) -> Iterator[None]:
    threads, strict = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()
    torch.set_num_threads(config.threads)
    torch.use_deterministic_algorithms(True)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            yield
    finally:
        torch.set_num_threads(threads)
        torch.use_deterministic_algorithms(strict)


class _Training:
    """One training."""

    def __init__(
        self,
        net: HeatmapNet,
        pairs: HeatmapPairs,
        config: HeatmapNetConfig,
        progress: Progress | None,
    ) -> None:
        self.net, self.pairs, self.config = net, pairs, config
        self.progress = progress or silent
        self.rng = np.random.default_rng(config.seed)

    def run(self, train: Mask, held_out: Mask) -> tuple[tuple[EpochLoss, ...], EpochLoss]:
        config, kept = self.config, np.flatnonzero(train)
        steps = -(-len(kept) // config.batch)
        total = steps * config.epochs
        optimiser = torch.optim.AdamW(self.net.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, config.learning_rate, total_steps=total)
        curve: list[EpochLoss] = []
        best: EpochLoss | None = None
        state: dict[str, Tensor] = {}
        for epoch in range(1, config.epochs + 1):
            loss = self._epoch(self.rng.permutation(kept), optimiser, schedule, (epoch - 1) * steps, total)
            curve.append(EpochLoss(epoch, loss, self._loss(np.flatnonzero(held_out))))
            if best is None or curve[-1].validation < best.validation:
                best, state = curve[-1], {name: value.clone() for name, value in self.net.state_dict().items()}
            elif epoch - best.epoch >= config.patience:
                break
        self.progress(total, total)
        if best is None or not np.isfinite(best.validation):
            raise ValueError(f"the loss is {curve[-1].validation}: learning_rate {config.learning_rate} is too large")
        self.net.load_state_dict(state)
        return tuple(curve), best

    def _epoch(
        self,
        order: NDArray[np.int_],
        optimiser: torch.optim.Optimizer,
        schedule: torch.optim.lr_scheduler.LRScheduler,
        done: int,
        total: int,
    ) -> float:
        self.net.train()
        spent = 0.0
        for step, first in enumerate(range(0, len(order), self.config.batch)):
            which = order[first : first + self.config.batch]
            flips = (self.rng.random(len(which)) < 0.5) & self.config.mirror
            inputs, targets = self._batch(which, flips)
            optimiser.zero_grad()
            loss = functional.binary_cross_entropy_with_logits(self.net(inputs), targets)
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            spent += loss.item() * len(which)
            self.progress(done + step + 1, total)
        return spent / len(order)

    @torch.no_grad()
    def _loss(self, which: NDArray[np.int_]) -> float:
        self.net.eval()
        spent = 0.0
        for first in range(0, len(which), 4 * self.config.batch):
            some = which[first : first + 4 * self.config.batch]
            inputs, targets = self._batch(some, np.zeros(len(some), bool))
            spent += functional.binary_cross_entropy_with_logits(self.net(inputs), targets).item() * len(some)
        return spent / len(which)

    def _batch(self, which: NDArray[np.int_], flips: Mask) -> tuple[Tensor, Tensor]:
        some = self.pairs.take(which)
        other = some.mirrored()
        free = np.where(flips[:, None, None], other.free, some.free).astype(np.float32)
        target = np.where(flips[:, None, None], other.target, some.target).astype(np.float32)
        if self.config.kind == "naive":
            joystick = np.where(flips[:, None], other.joystick, some.joystick)
            free = naive_images(free, joystick)
        return torch.from_numpy(free[:, None]), torch.from_numpy(target[:, None])


def _hash(pairs: HeatmapPairs) -> str:
    digest = hashlib.sha256()
    for array in (pairs.free, pairs.target, pairs.joystick.astype("<f4")):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def export_onnx(net: HeatmapNet, kind: str, about: dict[str, Any]) -> bytes:
    """The net and a sigmoid as ONNX bytes, weights inside; `about` joins the metadata that SensorHeatmap checks.

    Written node by node: torch's exporters put paths and stack traces of the machine into the file, and its bytes
    depend on their version.
    """
    graph = _Graph()
    fine = graph.conv(INPUT, "first", net.first, relu=True)
    coarse = graph.conv(fine, "second", net.second, relu=True)
    wide = graph.node("Concat", [coarse, graph.constant("place", net.place)], axis=1)
    for k, layer in enumerate(net.middle):
        assert isinstance(layer, nn.Conv2d)
        found = graph.conv(wide, f"middle.{k}", layer, relu=True)
        wide = found if k == 0 else graph.node("Add", [wide, found])
    up = graph.node("Relu", [graph.sub_pixel(graph.conv(wide, "up", net.up))])
    joined = graph.conv(graph.node("Concat", [up, fine], axis=1), "join", net.join, relu=True)
    graph.node("Sigmoid", [graph.sub_pixel(graph.conv(joined, "last", net.last))], OUTPUT)
    return graph.model({"kind": kind, "version": VERSION, "resolution": RESOLUTION, "cells": CELLS, **about})


class _Graph:
    """An ONNX graph under construction; every method returns the name of its result."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.weights: list[onnx.TensorProto] = []

    def node(self, kind: str, inputs: list[str], output: str = "", **attributes: Any) -> str:
        name = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name

    def constant(self, name: str, value: Tensor) -> str:
        self.weights.append(numpy_helper.from_array(value.detach().numpy().astype(np.float32), name))
        return name

    def conv(self, source: str, name: str, layer: nn.Conv2d, relu: bool = False) -> str:
        assert layer.bias is not None and not isinstance(layer.padding, str)
        weights = [self.constant(f"{name}.weight", layer.weight), self.constant(f"{name}.bias", layer.bias)]
        sizes: dict[str, Any] = {
            "kernel_shape": layer.kernel_size,
            "strides": layer.stride,
            "dilations": layer.dilation,
        }
        found = self.node("Conv", [source, *weights], pads=[*layer.padding, *layer.padding], **sizes)
        return self.node("Relu", [found]) if relu else found

    def sub_pixel(self, source: str) -> str:
        return self.node("DepthToSpace", [source], blocksize=2, mode="CRD")  # torch's pixel_shuffle

    def model(self, metadata: dict[str, Any]) -> bytes:
        shape = [1, 1, CELLS, CELLS]
        ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name in (INPUT, OUTPUT)]
        graph = helper.make_graph(self.nodes, "heatmap", ends[:1], ends[1:], self.weights)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)
        model.producer_name = "lfdcore"
        helper.set_model_props(model, {METADATA_KEY: json.dumps({**metadata, "frame": "base_link"}, sort_keys=True)})
        onnx.checker.check_model(model)
        return bytes(model.SerializeToString(deterministic=True))
