"""lfdcore info: what a file holds."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer

from lfdcore.cli.common import JsonOption, show_facts


def info(
    file: Annotated[Path, typer.Argument(help="A drive log, a recorded collaboration, a model or a map.")],
    as_json: JsonOption = False,
) -> None:
    """Say what a drive log, a recorded collaboration, a model or a map holds."""
    show_facts(_facts(file), as_json)


def _facts(file: Path) -> dict[str, Any]:
    if not file.exists():
        raise FileNotFoundError(2, "no such file", str(file))
    from lfdcore.datasets.tensor_file import is_tensor_file

    if file.suffix == ".safetensors" or is_tensor_file(file):
        return _model_facts(file)
    if file.suffix == ".npz":
        return _interaction_facts(file)
    if file.suffix in {".yaml", ".yml"}:
        return _map_facts(file)
    return _log_facts(file)


def _model_facts(file: Path) -> dict[str, Any]:
    from lfdcore.datasets.tensor_file import tensor_file_format
    from lfdcore.humanoid import collaboration
    from lfdcore.wheelchair.models import load_any_model

    kind = tensor_file_format(file)
    load = collaboration.CollaborationModel.load if kind == collaboration.KIND else load_any_model
    return {"kind": f"{kind.removeprefix('lfdcore ')} model", **load(file).summary()}


def _interaction_facts(file: Path) -> dict[str, Any]:
    import numpy as np

    from lfdcore.datasets.interaction import load_interaction

    one = load_interaction(file)
    lost = float(np.isnan(one.partner).mean()) if one.partner.size else 0.0
    return {
        "kind": "recorded collaboration",
        "name": one.name,
        "duration [s]": round(one.duration, 2),
        "samples": len(one),
        "partner": f"{', '.join(one.partner_names)}; {100 * lost:.1f} % not seen",
        "robot": ", ".join(one.robot_names) or "not recorded",
        "frame": one.frame,
        "environment": one.environment,
        **one.metadata,
    }


def _map_facts(file: Path) -> dict[str, Any]:
    from lfdcore.datasets import read_map
    from lfdcore.wheelchair.window import free_mask

    grid = read_map(file)
    free, occupied = int(free_mask(grid).sum()), int(grid.occupied_mask().sum())
    return {
        "kind": "occupancy grid map",
        "size [cells]": f"{grid.width} x {grid.height}",
        "size [m]": f"{grid.width * grid.resolution:.1f} x {grid.height * grid.resolution:.1f}",
        "resolution [m]": grid.resolution,
        "origin [m]": grid.origin,
        "free, occupied, unknown": f"{free}, {occupied}, {grid.width * grid.height - free - occupied} cells",
    }


def _log_facts(file: Path) -> dict[str, Any]:
    from lfdcore.datasets import open_log
    from lfdcore.geometry import arc_length

    log = open_log(file)
    way = arc_length(log.pose[:, :2])[-1] if len(log.pose) else 0.0
    mounting = log.T_base_laser
    facts = {
        "kind": "drive log",
        "name": log.name,
        "duration [s]": round(log.duration, 1),
        "scans": f"{log.ranges.shape[0]} of {log.ranges.shape[1]} beams",
        "scanner at": f"{mounting.x:g} m, {mounting.y:g} m, {math.degrees(mounting.yaw):g} deg in base_link",
        "odometry": f"{len(log.odometry_stamp)} records, {way:.1f} m",
        "joystick": f"{len(log.joystick_stamp)} records",
        "commands": f"{len(log.command_stamp)} records",
        "plans": len(log.plans),
    }
    for name, note in log.metadata.items():
        facts[name] = f"{facts[name]}; {note}" if name in facts else note
    return facts
