"""lfdcore learn drive --method primitives: intention, path primitives and compliance from logs (Sec. 3.2-3.4)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import joystick_from_motion
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.datasets.motion import full_deflection
from lfdcore.progress import Progress, silent
from lfdcore.training.parts.typical_paths import TypicalPathConfig, typical_paths
from lfdcore.wheelchair.primitives.compliance import ComplianceConfig, ComplianceModel
from lfdcore.wheelchair.primitives.intention import IntentionConfig, IntentionModel
from lfdcore.wheelchair.primitives.local_paths import LocalPathConfig, LocalPaths, extract_local_paths
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.path_primitives import PathPrimitiveConfig, PathPrimitives


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


def learn_drive(
    logs: Sequence[DriveLog],
    config: LearningConfig | None = None,
    progress: Progress | None = None,
) -> DriveAssistantModel:
    """Learns from demonstrations (Sec. 3.2-3.4). progress(done, total) is called after every log and every part.

    ValueError if no log is given, or none holds a local path: it says what was found instead.
    """
    config, tell = config or LearningConfig(), progress or silent
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
                "T_base_laser": [float(value) for value in log.mounting],
            }
            for log in logs
        ],
        "n_paths": len(paths),
        "ended_by": {str(name): int(count) for name, count in zip(names, counts, strict=True)},
        "dropped": {name: int(count) for name, count in sorted(paths.dropped.items())},
        "data_hash": _hash(paths),
        "full_deflection": [[*full_deflection(log)] for log in logs],
    }


def _hash(paths: LocalPaths) -> str:
    digest = hashlib.sha256()
    arrays: list[NDArray[Any]] = [paths.joystick, paths.beam_range, paths.goal, paths.end_yaw, *paths.paths]
    for array in arrays:
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()


def first_share(logs: Sequence[DriveLog], share: float = 1.0) -> list[DriveLog]:
    """The first `share` of each log's scans, with a joystick: where none was recorded, inferred from that share."""
    return [joystick_from_motion(log.share(0.0, share)) for log in logs]
