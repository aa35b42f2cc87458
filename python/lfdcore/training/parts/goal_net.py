"""Trains the network of Sec. 2.2 with torch; handed over as plain weights.

torch is imported where it trains: a study's config and the processes that search kernels need none of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.progress import Progress, silent
from lfdcore.wheelchair.goals.network import GoalNetwork, network_inputs
from lfdcore.wheelchair.goals.samples import GoalSamples, Heading

if TYPE_CHECKING:
    import torch
    from torch import nn


@dataclass(frozen=True)
class GoalNetConfig:
    """heading: see goal_samples; neurons: of the hidden layer; learning_rate, weight_decay: of AdamW."""

    heading: Heading = "embedded"
    neurons: int = 15
    epochs: int = 150
    batch: int = 256
    learning_rate: float = 0.02
    weight_decay: float = 1e-3
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("neurons", "epochs", "batch"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1")
        if not 0 < self.learning_rate < np.inf or not 0 <= self.weight_decay < np.inf:
            raise ValueError(f"learning_rate {self.learning_rate} and weight_decay {self.weight_decay} cannot be used")


def train_goal_network(
    samples: GoalSamples, goals: int, config: GoalNetConfig | None = None, progress: Progress | None = None
) -> GoalNetwork:
    """Minimises the cross-entropy of `goals` independent likelihoods. ValueError without samples of each goal.

    Runs on one thread: the same seed gives the same weights.
    """
    import torch

    config, tell = config or GoalNetConfig(), progress or silent
    missing = sorted(set(range(goals)) - set(samples.goal.tolist()))
    if missing:
        raise ValueError(f"no drive goes to goal {missing[0] + 1} of {goals}, each must have at least one")
    inputs = network_inputs(samples.pose, samples.joystick, config.heading)
    centre, scale = inputs.mean(axis=0), inputs.std(axis=0)
    scale[scale < 1e-9] = 1.0  # what never changes says nothing, at whatever scale
    x = torch.from_numpy((inputs - centre) / scale)
    y = torch.from_numpy(np.eye(goals)[samples.goal])
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        first, second = _optimise(x, y, config, tell)
    finally:
        torch.set_num_threads(threads)
    return GoalNetwork(config.heading, centre, scale, first, second)


def _optimise(
    x: torch.Tensor, y: torch.Tensor, config: GoalNetConfig, tell: Progress
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    import torch
    from torch.nn import functional

    random = torch.Generator().manual_seed(config.seed)
    hidden, output = _layer(x.shape[1], config.neurons, random), _layer(config.neurons, y.shape[1], random)
    weights = [*hidden.parameters(), *output.parameters()]
    optimiser = torch.optim.AdamW(weights, config.learning_rate, weight_decay=config.weight_decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, config.epochs)
    for epoch in range(config.epochs):
        for part in torch.split(torch.randperm(len(x), generator=random), config.batch):
            optimiser.zero_grad()
            said = output(torch.sigmoid(hidden(x[part])))
            functional.binary_cross_entropy_with_logits(said, y[part]).backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        schedule.step()
        tell(epoch + 1, config.epochs)
    return _weights(hidden), _weights(output)


def _layer(inputs: int, outputs: int, random: torch.Generator) -> nn.Linear:
    import torch

    layer = torch.nn.Linear(inputs, outputs, dtype=torch.float64)
    with torch.no_grad():
        layer.weight.normal_(0, inputs**-0.5, generator=random)
        layer.bias.zero_()
    return layer


def _weights(layer: nn.Linear) -> NDArray[np.float64]:
    return np.column_stack([layer.weight.detach().numpy(), layer.bias.detach().numpy()])
