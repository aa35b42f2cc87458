"""lfdcore track: where a driver is going, as the drive goes on (Ch. 2)."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import JsonOption, Stages, pose_of, print_json, progress_bar, require_drawable, save_picture
from lfdcore.cli.log_options import (
    AxesOption,
    CommandOption,
    JoyOption,
    LogOptions,
    MountingOption,
    OdometryOption,
    ScanOption,
)

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog
    from lfdcore.estimation import ActionModel
    from lfdcore.geometry import Pose2
    from lfdcore.grid import OccupancyGrid
    from lfdcore.wheelchair.goals.model import GoalModel, OtherActionModel
    from lfdcore.wheelchair.goals.samples import GoalSamples
    from lfdcore.wheelchair.goals.track import BeliefTrack


class Device(StrEnum):
    """Where torch computes."""

    cuda = "cuda"
    cpu = "cpu"


def track(
    model_file: Annotated[Path, typer.Argument(metavar="MODEL", help="What `lfdcore learn goals` made.")],
    log_file: Annotated[Path, typer.Argument(metavar="LOG", help="A drive log.")],
    map_file: Annotated[
        Path | None, typer.Option("--map", help="The map (.yaml), where the model does not name it.")
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(
            help="X,Y,YAW [m, m, degrees]: where a drive without poses in the map begins. Default: as learned."
        ),
    ] = None,
    full: Annotated[
        bool, typer.Option("--full", help="All samples instead of the subset: minutes to prepare.")
    ] = False,
    device: Annotated[
        Device | None, typer.Option(help="With --full: through torch on this device. Default: C++.")
    ] = None,
    every: Annotated[float, typer.Option(min=0.01, help="Seconds between the lines printed.")] = 2.0,
    picture: Annotated[
        Path | None, typer.Option(help="Ellipses on the map and likelihoods (.png, .pdf, .svg).")
    ] = None,
    animation: Annotated[Path | None, typer.Option(help="The belief as the drive goes on (.gif).")] = None,
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    as_json: JsonOption = False,
) -> None:
    """Follow the belief over destinations along a drive. Poses are the log's or, without any, a scan matcher's."""
    from lfdcore.wheelchair.goals.model import GoalModel
    from lfdcore.wheelchair.goals.track import track_beliefs

    if device is not None and not full:
        raise typer.BadParameter("--device is for the model of all samples: give --full too")
    require_drawable("--picture", picture)
    require_drawable("--animation", animation, (".gif",))
    model, log = GoalModel.load(model_file), LogOptions(scan, odometry, joy, axes, command, mounting).open(log_file)
    if start is not None and len(log.map_stamp):
        raise typer.BadParameter(f"--start is for a drive without poses in the map, {log_file} has them")
    begin = _start(model, start)
    grid = _map(model, map_file) if map_file or picture or animation or not len(log.map_stamp) else None
    with progress_bar() as bar:
        tell = Stages(bar)
        samples = _samples(log, grid, begin, tell)
        model_read = tell.step("model")
        action_model = _action_model(model, full, device)
        model_read(1, 1)
        beliefs = track_beliefs(model, samples, action_model, tell.step("belief"))
        _draw(model, samples, beliefs, grid, picture, animation)
    if as_json:
        print_json({"goals": model.goals.names, "beliefs": _lines(samples, beliefs, every)})
        return
    _print(model, samples, beliefs, every)


def _action_model(model: GoalModel, full: bool, device: Device | None) -> ActionModel | OtherActionModel:
    if device is None:
        return model.action_model("full" if full else "sparse")
    from lfdcore.training.estimators.torch_action_model import full_action_model

    return full_action_model(model, device.value)


def _samples(log: DriveLog, grid: OccupancyGrid | None, start: Pose2, tell: Stages) -> GoalSamples:
    """With the log's poses in the map or, where it has none, a scan matcher's."""
    from lfdcore.wheelchair.goals.localisation import with_map_poses
    from lfdcore.wheelchair.goals.samples import drive_samples

    if grid is not None and not len(log.map_stamp):
        log = with_map_poses(log, grid, start, tell.step("localise"))
    return drive_samples(log)


def _map(model: GoalModel, map_file: Path | None) -> OccupancyGrid:
    from lfdcore.datasets import read_map

    path = map_file or model.goals.map
    if path is None:
        raise typer.BadParameter("--map is needed: neither the model nor the command names the map")
    grid = read_map(path)
    model.goals.require_inside(grid)
    return grid


def _start(model: GoalModel, text: str | None) -> Pose2:
    import numpy as np

    from lfdcore.geometry import Pose2

    if text is None:
        _, first = np.unique(model.samples.drive, return_index=True)
        x, y, yaw = model.samples.pose[first].T
        turned = np.arctan2(np.median(np.sin(yaw)), np.median(np.cos(yaw)))  # yaws about +-180 degrees have a mean too
        return Pose2(float(np.median(x)), float(np.median(y)), float(turned))
    return pose_of("--start", text)


def _draw(
    model: GoalModel,
    samples: GoalSamples,
    beliefs: BeliefTrack,
    grid: OccupancyGrid | None,
    picture: Path | None,
    animation: Path | None,
) -> None:
    if grid is None:
        return
    from lfdcore.pictures.belief import drive_figure, save_belief_animation

    if picture is not None:
        save_picture(drive_figure(grid, model.goals, (samples, beliefs)), picture)
    if animation is not None:
        save_belief_animation(animation, grid, model.goals, (samples, beliefs))


def _shown(samples: GoalSamples, every: float) -> list[int]:
    """Indices of the samples to print: the first one after each `every` seconds, and the last."""
    import numpy as np

    wanted = np.arange(0.0, float(samples.stamp[-1]), every)
    return sorted({*np.searchsorted(samples.stamp, wanted).tolist(), len(samples) - 1})


def _lines(samples: GoalSamples, beliefs: BeliefTrack, every: float) -> list[dict[str, object]]:
    return [
        {
            "time": float(samples.stamp[k]),
            "mean": beliefs.mean[k].tolist(),
            "covariance": beliefs.covariance[k].tolist(),
            "likelihood": beliefs.likelihood[k].tolist(),
            "nearest": int(beliefs.nearest[k]),
        }
        for k in _shown(samples, every)
    ]


def _print(model: GoalModel, samples: GoalSamples, beliefs: BeliefTrack, every: float) -> None:
    """A line every few seconds: the likelihood of each goal, the nearest one, and how wide the belief is."""
    import numpy as np

    names = model.goals.names
    typer.echo(f"{'time [s]':>8}  {'nearest':<10}  {'sd [m]':>6}  " + "  ".join(f"{name:>6.6}" for name in names))
    for k in _shown(samples, every):
        wide = float(np.sqrt(np.linalg.eigvalsh(beliefs.covariance[k])[-1]))
        shares = "  ".join(f"{value:6.2f}" for value in beliefs.likelihood[k])
        typer.echo(f"{samples.stamp[k]:8.1f}  {names[beliefs.nearest[k]]:<10.10}  {wide:6.1f}  {shares}")
