"""The models of Ch. 4 and their files: where drivers go in a place (Sec. 4.3) and what they mean by the stick (Sec.
4.4.2); or one network for both (Sec. 4.6.2)."""

from __future__ import annotations

import reprlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.wheelchair.heatmaps.joystick import JoystickModel
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.heatmaps.prediction import HeatmapPathPredictor, NaivePathPredictor
from lfdcore.wheelchair.heatmaps.sensor import NaiveHeatmap, SensorHeatmap
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.window import CELLS, RESOLUTION

if TYPE_CHECKING:
    import os

VERSION = 1
_NETWORK, _JOYSTICK = "network.onnx", "joystick."


@dataclass(frozen=True)
class HeatmapModel:
    """sensor: the network of Sec. 4.3; joystick: the Gaussian processes of Sec. 4.4.2; metadata: JSON values about the
    demonstrations."""

    method: ClassVar[str] = "heatmaps"
    kind: ClassVar[str] = "lfdcore heatmaps"
    drives: ClassVar[bool] = True

    sensor: SensorHeatmap
    joystick: JoystickModel
    metadata: dict[str, Any] = field(default_factory=dict)

    def planner(self, chair: ChairGeometry, *, thesis: bool = False) -> HeatmapPlanner:
        """See MethodModel; HeatmapPlanner takes any other config."""
        config = HeatmapPlannerConfig.thesis() if thesis else HeatmapPlannerConfig()
        return HeatmapPlanner(self, config, chair)

    def predictor(self) -> HeatmapPathPredictor:
        """See MethodModel; HeatmapPathPredictor takes any other config."""
        return HeatmapPathPredictor(self)

    @property
    def nbytes(self) -> int:
        """Of the file's arrays [bytes]."""
        return sum(array.nbytes for array in self._tensors().values())

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""
        bins = self.joystick.bins
        return {**_shown(self.metadata), "joystick_bins": int((bins.count > 0).sum()), "bytes": self.nbytes}

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""
        header = _header(self.metadata) | {"joystick": self.joystick.header()}
        write_tensor_file(path, self.kind, VERSION, header, self._tensors())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> HeatmapModel:
        """ModelError for a damaged file, or one of another kind, version, resolution or frame."""
        header, tensors = _read(path, cls.kind)
        arrays = {name.removeprefix(_JOYSTICK): a for name, a in tensors.items() if name.startswith(_JOYSTICK)}
        with _named(path):
            joystick = JoystickModel.of_tensors(_part(header, "joystick"), arrays)
            return cls(SensorHeatmap(_network(tensors)), joystick, _part(header, "metadata"))

    def _tensors(self) -> Tensors:
        joystick = {_JOYSTICK + name: array for name, array in self.joystick.tensors().items()}
        return {_NETWORK: _bytes_as_array(self.sensor.onnx_bytes)} | joystick


@dataclass(frozen=True)
class NaiveHeatmapModel:
    """The network of Sec. 4.6.2 that takes scan and stick in one image. It predicts only: of the stick's meaning, which
    says whether a driver agrees with a path, it knows nothing."""

    method: ClassVar[str] = "naive"
    kind: ClassVar[str] = "lfdcore naive heatmap"
    drives: ClassVar[bool] = False

    network: NaiveHeatmap
    metadata: dict[str, Any] = field(default_factory=dict)

    def planner(self, chair: ChairGeometry, *, thesis: bool = False) -> NoReturn:
        """ModelError: there is none."""
        raise ModelError("a naive heatmap drives nothing: it does not know when a driver agrees with a path")

    def predictor(self) -> NaivePathPredictor:
        """See MethodModel; NaivePathPredictor takes any other config."""
        return NaivePathPredictor(self)

    @property
    def nbytes(self) -> int:
        """Of the file's arrays [bytes]."""
        return len(self.network.onnx_bytes)

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""
        return {**_shown(self.metadata), "bytes": self.nbytes}

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""
        write_tensor_file(
            path, self.kind, VERSION, _header(self.metadata), {_NETWORK: _bytes_as_array(self.network.onnx_bytes)}
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> NaiveHeatmapModel:
        """ModelError for a damaged file, or one of another kind, version, resolution or frame."""
        header, tensors = _read(path, cls.kind)
        with _named(path):
            return cls(NaiveHeatmap(_network(tensors)), _part(header, "metadata"))


def _shown(metadata: dict[str, Any]) -> dict[str, Any]:
    """Without the pair of speeds a log: too long where there are many."""
    return {name: value for name, value in metadata.items() if name != "full_deflection"}


def _header(metadata: dict[str, Any]) -> dict[str, Any]:
    return {"metadata": metadata, "resolution": RESOLUTION, "cells": CELLS, "frame": "base_link"}


def _read(path: str | os.PathLike[str], kind: str) -> tuple[dict[str, Any], Tensors]:
    header, tensors = read_tensor_file(path, kind, VERSION)
    for name, needed in (("resolution", RESOLUTION), ("cells", CELLS), ("frame", "base_link")):
        if header.get(name) != needed:
            raise ModelError(f"{path} has {name} {header.get(name)}, must be {needed}")
    return header, tensors


@contextmanager
def _named(path: str | os.PathLike[str]) -> Iterator[None]:
    """Names the file whose part cannot be used."""
    try:
        yield
    except ModelError as unusable:
        raise ModelError(f"{path}: {unusable}") from unusable


def _part(header: dict[str, Any], name: str) -> dict[str, Any]:
    part = header.get(name)
    if not isinstance(part, dict):
        raise ModelError(f"{name} is {reprlib.repr(part)}, must be an object")
    return part


def _network(tensors: Tensors) -> bytes:
    array = tensors.get(_NETWORK)
    if array is None or array.dtype != np.uint8 or array.ndim != 1:
        raise ModelError("holds no network")
    return array.tobytes()


def _bytes_as_array(data: bytes) -> NDArray[np.uint8]:
    return np.frombuffer(data, np.uint8)
