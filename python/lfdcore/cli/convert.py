"""lfdcore convert: a log of another robot as a drive log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lfdcore.cli.common import require_writable
from lfdcore.cli.log_options import (
    AxesOption,
    CommandOption,
    JoyOption,
    LogOptions,
    MountingOption,
    OdometryOption,
    ScanOption,
)


def convert(
    log_file: Annotated[Path, typer.Argument(metavar="LOG", help="A log of any format that lfdcore reads.")],
    output: Annotated[Path, typer.Argument(metavar="OUT.mcap", help="Where the drive log goes.")],
    scan: ScanOption = None,
    odometry: OdometryOption = None,
    joy: JoyOption = None,
    axes: AxesOption = None,
    command: CommandOption = None,
    mounting: MountingOption = None,
    force: Annotated[bool, typer.Option("--force", help="Replace OUT.mcap where it exists.")] = False,
) -> None:
    """Read a log of another robot, and write it as a drive log: what the options say, every command then knows."""
    from lfdcore.datasets.log_health import log_troubles

    if output.suffix != ".mcap":
        raise typer.BadParameter(f"OUT.mcap is {output}, must end in .mcap")
    require_writable(output, [log_file], "OUT.mcap")
    if output.exists() and not force:
        raise typer.BadParameter(f"{output} exists: --force replaces it")
    log = LogOptions(scan, odometry, joy, axes, command, mounting).open(log_file)
    log.save(output)
    typer.echo(f"{output}: {len(log.scan_stamp)} scans in {log.duration:.1f} s")
    for trouble in log_troubles(log):
        typer.echo(f"- {trouble}")
