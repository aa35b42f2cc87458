"""The model of Ch. 3 and its file: intention (Sec. 3.3), path primitives (Sec. 3.4.1), compliance (Sec. 3.4.3)."""

from __future__ import annotations

import reprlib
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.estimation import RbfNetworkBank
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.primitives.compliance import ComplianceConfig, ComplianceModel
from lfdcore.wheelchair.primitives.intention import IntentionConfig, IntentionModel
from lfdcore.wheelchair.primitives.path_primitives import PathPrimitives
from lfdcore.wheelchair.primitives.planner import PrimitivesPlanner, PrimitivesPlannerConfig
from lfdcore.wheelchair.primitives.prediction import PathPredictor
from lfdcore.wheelchair.window import CELLS, RESOLUTION

if TYPE_CHECKING:
    import os

VERSION = 1
_BANK = ("keys", "offsets", "centres", "weights")
_LAYOUT = {
    **{f"{part}.{name}": ("int32", 1) for part in ("intention", "compliance") for name in ("keys", "offsets")},
    **{f"{part}.centres": ("float64", 2) for part in ("intention", "compliance")},
    **{f"{part}.weights": ("float64", 1) for part in ("intention", "compliance")},
    "intention.frequencies": ("float64", 1),
    "primitives.ends": ("float64", 2),
    "primitives.shapes": ("float64", 3),
    "primitives.bins": ("int32", 1),
    "primitives.counts": ("int32", 1),
}
"""dtype and dimensions of each array in the file; the parts of the model check how their lengths fit together"""
LARGEST = 1e100
"""No number in a model is beyond: products of any two stay finite"""
MOST_CLEARANCE = 100.0
"""[m] that a model may have learned to keep"""


@dataclass(frozen=True)
class DriveAssistantModel:
    """clearance [m]: how near to what the scan showed the demonstrated paths came, but for the nearest 3 % (0 where no
    beam hit anything); metadata: JSON values about the demonstrations: logs, lasers (beams, field_of_view [rad],
    T_base_laser), n_paths, ended_by, dropped, data_hash (SHA-256 of the local paths), full_deflection (what the
    stick asked for when pushed fully, [m/s, rad/s] a log)."""

    method: ClassVar[str] = "primitives"
    kind: ClassVar[str] = "lfdcore drive assistant"
    drives: ClassVar[bool] = True

    intention: IntentionModel
    primitives: PathPrimitives
    compliance: ComplianceModel
    clearance: float = 0.0
    metadata: dict[str, Any] = field(default_factory=dict)

    def planner(self, chair: ChairGeometry, *, thesis: bool = False) -> PrimitivesPlanner:
        """See MethodModel; PrimitivesPlanner takes any other config."""
        config = PrimitivesPlannerConfig.thesis() if thesis else PrimitivesPlannerConfig()
        return PrimitivesPlanner(self, config, chair)

    def predictor(self) -> PathPredictor:
        """See MethodModel; PathPredictor takes any other config."""
        return PathPredictor(self)

    @property
    def nbytes(self) -> int:
        """Memory of the learned arrays [bytes]: what the file holds, and what stays in memory at most twice over."""
        return sum(array.nbytes for array in self._tensors().values())

    def summary(self) -> dict[str, Any]:
        """What was learned from what, for people: flat, in JSON values."""
        keys = ("logs", "n_paths", "ended_by", "dropped", "data_hash")
        return {
            **{key: self.metadata[key] for key in keys if key in self.metadata},
            "cells": len(self.intention.cells),
            "basis_functions": len(self.intention.bank.weights),
            "primitives": len(self.primitives),
            "clearance": round(self.clearance, 3),
            "bytes": self.nbytes,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file, the same bytes for the same model."""
        header = {
            "metadata": self.metadata,
            "clearance": self.clearance,
            "resolution": RESOLUTION,
            "cells": CELLS,
            "frame": "base_link",
            "intention": asdict(self.intention.config),
            "compliance": asdict(self.compliance.config),
        }
        write_tensor_file(path, self.kind, VERSION, header, self._tensors())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> DriveAssistantModel:
        """ModelError for a damaged file, or one of another kind, version, resolution or frame."""
        header, tensors = read_tensor_file(path, cls.kind, VERSION)
        for name, needed in (("resolution", RESOLUTION), ("cells", CELLS), ("frame", "base_link")):
            if header.get(name) != needed:
                raise ModelError(f"{path} has {name} {header.get(name)}, must be {needed}")
        try:
            return cls._from_parts(header, tensors)
        except (KeyError, TypeError, ValueError) as wrong:
            raise ModelError(f"{path} does not hold a usable drive assistant: {wrong}") from wrong

    def _tensors(self) -> Tensors:
        primitives = self.primitives
        named = {f"primitives.{name}": getattr(primitives, name) for name in ("ends", "shapes", "bins", "counts")}
        named["intention.frequencies"] = self.intention.frequencies
        for part, bank in (("intention", self.intention.bank), ("compliance", self.compliance.bank)):
            named |= {f"{part}.{name}": np.asarray(getattr(bank, name)) for name in _BANK}
        return named

    @classmethod
    def _from_parts(cls, header: dict[str, Any], tensors: Tensors) -> DriveAssistantModel:
        _require_layout(tensors)
        metadata = header["metadata"]
        if not isinstance(metadata, dict):
            raise ValueError(f"metadata is {_short(metadata)}, must be names and values")
        intention: IntentionConfig = _config(IntentionConfig, header["intention"])
        compliance: ComplianceConfig = _config(ComplianceConfig, header["compliance"])
        primitives = PathPrimitives(*(tensors[f"primitives.{name}"] for name in ("ends", "shapes", "bins", "counts")))
        return cls(
            IntentionModel(_bank(tensors, "intention", 1.0), tensors["intention.frequencies"], intention),
            primitives,
            ComplianceModel(_bank(tensors, "compliance", compliance.sigma), compliance),
            _clearance(header["clearance"]),
            metadata,
        )


def _short(value: Any) -> str:
    return repr(value) if isinstance(value, float) else reprlib.repr(value)


def _require_layout(tensors: Tensors) -> None:
    if tensors.keys() != _LAYOUT.keys():
        raise ValueError(f"it has the arrays {sorted(tensors)}, must have {sorted(_LAYOUT)}")
    for name, (kind, dimensions) in _LAYOUT.items():
        array = tensors[name]
        if array.dtype != kind or array.ndim != dimensions:
            raise ValueError(
                f"{name} has shape {array.shape} of {array.dtype}, must be {kind} with {dimensions} dimensions"
            )
        if not (np.abs(array, dtype=np.float64) <= LARGEST).all():
            raise ValueError(f"{name} holds NaN or a number beyond {LARGEST:g}")


def _clearance(value: Any) -> float:
    if not (_is_number(value) and 0 <= value <= MOST_CLEARANCE):
        raise ValueError(f"clearance is {_short(value)} m, must be a number between 0 and {MOST_CLEARANCE:g}")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)


def _bank(tensors: Tensors, part: str, sigma: float) -> RbfNetworkBank:
    keys, offsets, centres, weights = (tensors[f"{part}.{name}"] for name in _BANK)
    return RbfNetworkBank(keys, offsets, centres, weights, sigma)


def _config(kind: type[Any], values: dict[str, Any]) -> Any:
    names = {item.name for item in fields(kind)}
    if not isinstance(values, dict) or set(values) != names:
        raise ValueError(f"{kind.__name__} has the fields {sorted(names)}, the file has {_short(values)}")
    for item in fields(kind):
        _require_kind(f"{kind.__name__}.{item.name}", values[item.name], item.default)
    return kind(**{name: tuple(value) if isinstance(value, list) else value for name, value in values.items()})


def _require_kind(name: str, value: Any, example: Any) -> None:
    """A field's default says what the file must have: true or false, a whole number, a number, or several."""
    if isinstance(example, tuple):
        fits = isinstance(value, list) and all(map(_is_number, value))
    elif isinstance(example, float):
        fits = _is_number(value)
    else:
        fits = type(value) is type(example)
    if not fits:
        raise ValueError(f"{name} is {_short(value)}, must be like {example}")
