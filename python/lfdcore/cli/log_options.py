"""What a command line says of the logs of other robots: which topics they are, and where the scanner is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lfdcore.cli.common import pose_of

if TYPE_CHECKING:
    from lfdcore.datasets.drive_log import DriveLog

ScanOption = Annotated[str | None, typer.Option(help="Of bags with several: the topic of the scans.")]
OdometryOption = Annotated[
    str | None, typer.Option(help="Of bags: the topic of the odometry, or tf: the frame that moves on /tf.")
]
JoyOption = Annotated[str | None, typer.Option(help="Of bags with several: the topic of the stick, or none.")]
AxesOption = Annotated[str | None, typer.Option(help="Of bags: the axes of Joy that are FORWARD,LEFT. Default: 1,0.")]
CommandOption = Annotated[str | None, typer.Option(help="Of bags with several: the topic of the commands, or none.")]
MountingOption = Annotated[
    str | None, typer.Option(help="X,Y,YAW of the scanner in base_link [m, m, degrees], where the log does not say it.")
]


@dataclass(frozen=True)
class LogOptions:
    """What the options say."""

    scan: str | None = None
    odometry: str | None = None
    joy: str | None = None
    axes: str | None = None
    command: str | None = None
    mounting: str | None = None

    def open(self, path: Path) -> DriveLog:
        """Reads a log by them. BadParameter for an option that this log has no use for."""
        from lfdcore.datasets import open_log
        from lfdcore.datasets.formats import is_bag

        bag = {"scan": self.scan, "odometry": self.odometry, "joystick": self.joy, "command": self.command}
        said: dict[str, Any] = {name: value for name, value in bag.items() if value is not None}
        if self.axes is not None:
            said["joystick_axes"] = _axes(self.axes)
        if said and not (path.exists() and is_bag(path)):
            raise typer.BadParameter(
                f"{path} is no ROS bag: --scan, --odometry, --joy, --axes and --command are for bags"
            )
        log = open_log(path, **said)
        if self.mounting is None:
            return log
        mounting = pose_of("--mounting", self.mounting)
        return replace(log, T_base_laser=mounting, metadata=log.metadata | {"T_base_laser": "as given"})


def _axes(text: str) -> tuple[int, int]:
    try:
        forward, left = (int(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"--axes {text!r} must be FORWARD,LEFT, two indices of Joy.axes") from None
    if min(forward, left) < 0 or forward == left:
        raise typer.BadParameter(f"--axes {text!r} must be two indices that differ, from 0 on")
    return forward, left
