"""All that one set of demonstrations teaches a drive assistant: intention, path primitives, compliance."""

from __future__ import annotations

import hashlib
import reprlib
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.estimation import RbfNetworkBank
from lfdcore.wheelchair.compliance import ComplianceConfig, ComplianceModel
from lfdcore.wheelchair.intention import IntentionConfig, IntentionModel
from lfdcore.wheelchair.local_paths import LocalPathConfig, LocalPaths, extract_local_paths
from lfdcore.wheelchair.path_primitives import PathPrimitiveConfig, PathPrimitives
from lfdcore.wheelchair.typical_paths import TypicalPathConfig, typical_paths
from lfdcore.wheelchair.window import CELLS, RESOLUTION

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Sequence

    from lfdcore.datasets.drive_log import DriveLog

KIND, VERSION = "lfdcore drive assistant", 1
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
class LearningConfig:
    """Each part's own config; `thesis()` has the printed values. typical: which paths compliance is learned from."""

    local_paths: LocalPathConfig = field(default_factory=LocalPathConfig)
    intention: IntentionConfig = field(default_factory=IntentionConfig)
    primitives: PathPrimitiveConfig = field(default_factory=PathPrimitiveConfig)
    compliance: ComplianceConfig = field(default_factory=ComplianceConfig)
    typical: TypicalPathConfig = field(default_factory=TypicalPathConfig)

    @classmethod
    def thesis(cls) -> LearningConfig:
        return cls(
            intention=IntentionConfig.thesis(),
            primitives=PathPrimitiveConfig(mirror=False),
            compliance=ComplianceConfig.thesis(),
            typical=TypicalPathConfig(ratio=0.0),
        )


@dataclass(frozen=True)
class DriveAssistantModel:
    """clearance [m]: how near to what the scan showed the demonstrated paths came, but for the nearest 3 % (0 where no
    beam hit anything); metadata: JSON values about the demonstrations: logs, lasers (beams, field_of_view [rad],
    T_base_laser), n_paths, ended_by, dropped, data_hash (SHA-256 of the local paths)."""

    intention: IntentionModel
    primitives: PathPrimitives
    compliance: ComplianceModel
    clearance: float = 0.0
    metadata: dict[str, Any] = field(default_factory=dict)

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
        """One file, the same bytes for the same model (see model_file)."""
        header = {
            "metadata": self.metadata,
            "clearance": self.clearance,
            "resolution": RESOLUTION,
            "cells": CELLS,
            "frame": "base_link",
            "intention": asdict(self.intention.config),
            "compliance": asdict(self.compliance.config),
        }
        write_tensor_file(path, KIND, VERSION, header, self._tensors())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> DriveAssistantModel:
        """ModelError for a damaged file, or one of another kind, version, resolution or frame."""
        header, tensors = read_tensor_file(path, KIND, VERSION)
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


def learn_drive(
    logs: Sequence[DriveLog],
    config: LearningConfig | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> DriveAssistantModel:
    """Learns from demonstrations (Sec. 3.2-3.4). progress(done, total) is told after every log and every
    part.

    ValueError if no log is given, or none holds a local path: it says what was found instead.
    """
    config, tell = config or LearningConfig(), progress or (lambda done, total: None)
    total = len(logs) + 3
    parts = []
    for number, log in enumerate(logs):
        parts.append(extract_local_paths(log, config.local_paths))
        tell(number + 1, total)
    paths = LocalPaths.concatenate(parts)
    if not len(paths):
        found = ", ".join(f"{cause}: {count}" for cause, count in sorted(paths.dropped.items()))
        raise ValueError(
            f"{len(logs)} logs with {sum(len(log.scan_stamp) for log in logs)} scans hold no local path ({found})"
        )
    intention = IntentionModel.fit(paths, config.intention)
    tell(total - 2, total)
    primitives = PathPrimitives.fit(paths, config.primitives)
    tell(total - 1, total)
    learned = typical_paths(paths, config.compliance.look_ahead, config.typical)
    compliance = ComplianceModel.fit(learned, config.compliance)
    tell(total, total)
    return DriveAssistantModel(intention, primitives, compliance, _kept_clearance(paths), _metadata(logs, paths))


def _kept_clearance(paths: LocalPaths) -> float:
    near = paths.clearance[np.isfinite(paths.clearance)]
    return float(np.percentile(near, 3)) if len(near) else 0.0


def _metadata(logs: Sequence[DriveLog], paths: LocalPaths) -> dict[str, Any]:
    names, counts = np.unique(paths.reason, return_counts=True)
    return {
        "logs": [log.name for log in logs],
        "lasers": [
            {
                "beams": int(log.ranges.shape[1]),
                "field_of_view": float(abs(log.angle_increment) * (log.ranges.shape[1] - 1)),
                "T_base_laser": [float(value) for value in log.T_base_laser],
            }
            for log in logs
        ],
        "n_paths": len(paths),
        "ended_by": {str(name): int(count) for name, count in zip(names, counts, strict=True)},
        "dropped": {name: int(count) for name, count in sorted(paths.dropped.items())},
        "data_hash": _hash(paths),
    }


def _hash(paths: LocalPaths) -> str:
    digest = hashlib.sha256()
    arrays: list[NDArray[Any]] = [paths.joystick, paths.beam_range, paths.goal, paths.end_yaw, *paths.paths]
    for array in arrays:
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
