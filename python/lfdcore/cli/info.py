"""lfdcore info: what a file holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from lfdcore.cli.common import JsonOption, print_facts, show_facts
from lfdcore.cli.log_options import (
    AxesOption,
    CommandOption,
    JoyOption,
    LogOptions,
    MountingOption,
    OdometryOption,
    ScanOption,
)


def info(
    file: Annotated[Path, typer.Argument(help="A drive log, a recorded collaboration, a model or a map.")],
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    as_json: JsonOption = False,
) -> None:
    """Say what a drive log, a recorded collaboration, a model or a map holds; of a log also what is wrong with it, and
    what to do."""
    facts = _facts(file, LogOptions(scan, odometry, joy, axes, command, mounting))
    if as_json or "wrong" not in facts:
        show_facts(facts, as_json)
        return
    print_facts({name: _known(value) for name, value in facts.items() if name not in ("wrong", "noted")})
    print_facts({name + " (noted)" * (name in facts): note for name, note in facts["noted"].items()})
    for trouble in facts["wrong"]:
        typer.echo(f"- {trouble}")


def _known(value: Any) -> Any:
    """Without what is not known."""
    return {name: one for name, one in value.items() if one is not None} if isinstance(value, dict) else value


def _facts(file: Path, options: LogOptions) -> dict[str, Any]:
    if not file.exists():
        raise FileNotFoundError(2, "no such file", str(file))
    from lfdcore.datasets.tensor_file import is_tensor_file

    if file.suffix == ".safetensors" or is_tensor_file(file):
        return _model_facts(file)
    if file.suffix == ".npz":
        return _interaction_facts(file)
    if file.suffix in {".yaml", ".yml"}:
        return _map_facts(file)
    return _log_facts(file, options)


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


def _log_facts(file: Path, options: LogOptions) -> dict[str, Any]:
    from lfdcore.datasets.log_health import log_facts

    log = options.open(file)
    return {"kind": "drive log", "name": log.name, **log_facts(log), "noted": log.metadata}
