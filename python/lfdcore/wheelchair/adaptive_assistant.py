"""The heatmaps' assistant that goes on learning what its driver means by the stick (Sec. 6.2.1).

Followed is what the chair was made to do along a path that the driver let stand. But that path is drawn by the very
stick that is to be judged: where nothing but the stick decides, it follows the stick's error, and to learn each tick's
pair would be to learn the assistant's mistakes. What tells of a bias is that demonstrators' ways (the sensor heatmap)
hold the chair to one side of where the stick alone would lead, place after place. So one angle is estimated from all
that was followed; it is believed as far as chance does not explain it; and the pairs learned, also where the stick asks
for what no path makes, are the raw stick and the same stick turned by that angle.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lfdcore.geometry import MotionLimits, Twist2, wrap_angle
from lfdcore.wheelchair.assistants import DriveAssistant, DriveAssistantConfig
from lfdcore.wheelchair.heatmaps.joystick import (
    JoystickAdapter,
    JoystickAdapterConfig,
    JoystickBins,
    JoystickModel,
    JoystickModelConfig,
)
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.watch import HALTS, WatchConfig

Floats = NDArray[np.float64]
_ALMOST_STILL = 0.05
"""A command below this [m/s, rad/s] has no direction to speak of."""


@dataclass(frozen=True, kw_only=True)
class AdaptationConfig:
    """What counts as followed, and how it becomes a driver's bias. Angles [rad] were measured on the tuning courses
    with able drivers, unbiased and biased by .3."""

    steepest: float = 1.1
    """A stick farther from ahead asks for a turn on the spot, which no path makes: it is not judged by one."""
    largest: float = 0.5
    """One tick's offset counts as at most so much: an evasion is no bias."""
    scatter: float = 0.73
    """Of n ticks' mean offset, times sqrt(n): .28 for a tick, and it stays alike for 7."""
    chance: float = 1.0
    """A mean offset within so many standard deviations of 0 is none. More: safer for an unbiased driver, and later."""
    corrected_share: float = 0.22
    """Of a bias that the model does not know, so much shows in what is followed; the rest the path follows."""
    memory: float = 1200.0
    """Ticks after which one counts e times less for the offset: 2 minutes at 10 Hz."""
    largest_turn: float = 0.6
    """A driver is thought to point at most so far beside what is meant."""
    adapter: JoystickAdapterConfig = field(default_factory=lambda: JoystickAdapterConfig(trained_samples=1.0))

    def __post_init__(self) -> None:
        for name in ("steepest", "largest", "scatter", "chance", "corrected_share", "largest_turn"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise ValueError(f"{name} is {value}, must be > 0 and finite")
        if self.corrected_share > 1:
            raise ValueError(f"corrected_share is {self.corrected_share}, must be at most 1")
        if not 1 <= self.memory < math.inf:
            raise ValueError(f"memory is {self.memory}, must be at least 1 tick and finite")


class SteeringOffset:
    """By what angle a driver's stick is to be turned to what is meant, from what was followed. Memory: two numbers."""

    def __init__(self, config: AdaptationConfig) -> None:
        self.config = config
        self.reset()

    def reset(self) -> None:
        """Another driver."""
        self.mean = self.ticks = 0.0

    def add(self, followed: float, known: float) -> None:
        """Angles from the stick [rad]: to what was followed, and to what the model took it to mean for that."""
        config = self.config
        bounded = min(max(followed, -config.largest), config.largest)
        unknown = bounded - (1 - config.corrected_share) * known  # what would show with a model that knew nothing
        self.ticks = self.ticks * (1 - 1 / config.memory) + 1
        self.mean += (unknown - self.mean) / self.ticks

    def resume(self, turn: float, ticks: float) -> None:
        """Goes on from a turn that was learned from so many ticks."""
        self.ticks = min(ticks, self.config.memory)
        self.mean = (
            math.copysign(math.hypot(turn * self.config.corrected_share, self._by_chance()), turn) if turn else 0.0
        )

    @property
    def turn(self) -> float:
        """From the stick to what is meant [rad]: what chance explains is taken out in quadrature."""
        beyond_chance = math.sqrt(max(self.mean**2 - self._by_chance() ** 2, 0.0))
        turn = min(beyond_chance / self.config.corrected_share, self.config.largest_turn)
        return math.copysign(turn, self.mean)

    def _by_chance(self) -> float:
        return self.config.chance * self.config.scatter / math.sqrt(max(self.ticks, 1.0))


class AdaptiveAssistant:
    """A DriveAssistant over heatmaps whose joystick model follows its driver.

    `reset` starts another drive of the same driver, `forget_driver` another driver.
    """

    def __init__(
        self,
        model: HeatmapModel,
        chair: ChairGeometry,
        config: DriveAssistantConfig | None = None,
        adaptation: AdaptationConfig | None = None,
        name: str = "heatmaps_adaptive",
        watch: WatchConfig | None = None,
    ) -> None:
        self.name = name
        self.chair = chair
        self.adaptation = adaptation or AdaptationConfig()
        self.adapter = JoystickAdapter(model.joystick, self.adaptation.adapter)
        self.planner = model.planner(self.chair)
        """With the joystick model as adapted so far"""
        self._drive = DriveAssistant(self.planner, config, watch=watch)
        self._offset = SteeringOffset(self.adaptation)

    @property
    def turn(self) -> float:
        """By which the driver's stick is thought to have to be turned [rad, positive = left]."""
        return self._offset.turn

    def reset(self) -> None:
        """Forgets everything about the drive so far, nothing about its driver."""
        self._drive.reset()

    def forget_driver(self) -> None:
        """Back to the trained model."""
        self._offset.reset()
        self.adapter.reset()
        self.planner.joystick = self.adapter.model

    def save_driver(self, path: str | os.PathLike[str]) -> None:
        """What is known of the driver in one file, for `resume_driver`."""
        self.adapter.save(path)

    def resume_driver(self, path: str | os.PathLike[str]) -> None:
        """Goes on where `save_driver` was called. ModelError as JoystickAdapter.resume; then nothing is changed."""
        self.adapter.resume(path)
        self._offset.resume(*_learned(self.adapter.own, self.adapter.trained.config))
        self.planner.joystick = self.adapter.model

    def update(self, observation: Observation) -> Assistance:
        """As DriveAssistant; then learns from what is followed."""
        said = self._drive.update(observation)
        joystick = np.array(observation.joystick)
        if said.mode not in ("rest", *HALTS):
            if self._followed(said):
                self._judge(joystick, _stick_angle(said.command, self.chair.limits))
            self.planner.joystick = self._learn(joystick)
        return said

    def _learn(self, joystick: Floats) -> JoystickModel:
        """A pair more, and all earlier ones as they are understood now."""
        turn = self._offset.turn
        self.adapter.relabel(_turned(self.adapter.own.raw, turn))
        return self.adapter.add(joystick, _turned(joystick, turn))

    def _followed(self, said: Assistance) -> bool:
        """Along a path, and not where the supervisor or standstill decides."""
        return said.mode == "path" and not said.supervised and float(np.hypot(*said.command)) > _ALMOST_STILL

    def _judge(self, joystick: Floats, followed: float) -> None:
        given = _orientation(joystick)
        if abs(given) <= self.adaptation.steepest:
            known = _orientation(np.array(self.adapter.model.predict(joystick).mean))
            self._offset.add(float(wrap_angle(followed - given)), float(wrap_angle(known - given)))


def _orientation(joystick: Floats) -> float:
    return math.atan2(joystick[1], joystick[0])


def _stick_angle(command: Twist2, limits: MotionLimits) -> float:
    """Of the stick that asks for a command, 0 = forward."""
    return math.atan2(command.angular / limits.max_angular, command.linear / limits.max_linear)


def _turned(joystick: Floats, angle: float) -> Floats:
    """Sticks (..., 2) turned to the left, within their end stops."""
    c, s = math.cos(angle), math.sin(angle)
    turned = joystick @ np.array([[c, s], [-s, c]])
    return np.asarray(turned / np.maximum(1.0, np.abs(turned).max(axis=-1, keepdims=True)))


def _learned(own: JoystickBins, config: JoystickModelConfig) -> tuple[float, float]:
    """The turn [rad] that a driver's bins hold on average, and of how many pairs."""
    pairs = float(own.count.sum())
    if pairs == 0:
        return 0.0, 0.0
    wanted = own.wanted(config)
    turns = wrap_angle(np.arctan2(wanted[:, 1], wanted[:, 0]) - np.arctan2(own.raw[:, 1], own.raw[:, 0]))
    return float((own.count * turns).sum() / pairs), pairs
