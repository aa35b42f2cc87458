"""lfdcore node: an assistant drives a ROS 2 robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from lfdcore.cli.common import footprint_of, pose_of, require_writable

if TYPE_CHECKING:
    from lfdcore.geometry import MotionLimits

"""In the place of a model: the stick drives, as far as the supervisor lets it."""
ROS_ARGUMENTS = "--ros-args"


class NodeCommand(TyperCommand):
    """What stands from --ros-args on is for ROS."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Takes ROS's arguments out, into the context's object."""
        at = args.index(ROS_ARGUMENTS) if ROS_ARGUMENTS in args else len(args)
        ctx.obj = args[at:]
        return super().parse_args(ctx, args[:at])


def node(
    context: typer.Context,
    model: Annotated[
        str, typer.Argument(metavar="MODEL", help="What `lfdcore learn drive` made, or the word 'supervisor'.")
    ],
    scan: Annotated[str, typer.Option(metavar="TOPIC", help="sensor_msgs/LaserScan.")] = "/scan",
    odom: Annotated[str, typer.Option(metavar="TOPIC", help="nav_msgs/Odometry.")] = "/odom",
    joy: Annotated[str, typer.Option(metavar="TOPIC", help="sensor_msgs/Joy.")] = "/joy",
    axes: Annotated[str, typer.Option(help="FORWARD,LEFT: which of the stick's axes these are, from 0.")] = "1,0",
    out: Annotated[str, typer.Option(metavar="TOPIC", help="geometry_msgs/Twist: the commands.")] = "/cmd_vel",
    stamped: Annotated[bool, typer.Option("--stamped", help="Commands are geometry_msgs/TwistStamped.")] = False,
    base: Annotated[
        str | None, typer.Option(metavar="FRAME", help="The axle's centre. Default: the odometry's child frame.")
    ] = None,
    mounting: Annotated[
        str | None,
        typer.Option(help="X,Y,YAW [m, m, degrees] of the scanner, upright, on the chair. Default: as in /tf_static."),
    ] = None,
    footprint: Annotated[
        str, typer.Option(help="FRONT,REAR,HALF_WIDTH of the chair around its axle, in metres.")
    ] = ".8,.35,.35",
    limits: Annotated[
        str,
        typer.Option(help="NAME=VALUE,... of the chair's limits [m, rad, s]; the thesis's where not named."),
    ] = "max_linear=1",
    latency: Annotated[float, typer.Option(help="Seconds from a command to the motion that it causes.")] = 0.1,
    scan_period: Annotated[float, typer.Option(help="Seconds between scans.")] = 0.1,
    wait: Annotated[float, typer.Option(min=0.1, max=3600, help="Seconds until all topics must have spoken.")] = 30.0,
    record: Annotated[Path | None, typer.Option(help="Where a drive log (.mcap) goes.")] = None,
) -> None:
    """Drive a ROS 2 robot with a learned model or the bare supervisor. ROS's own arguments follow --ros-args."""
    from lfdcore.ros.node import drive_node, require_ros
    from lfdcore.ros.options import NodeOptions
    from lfdcore.wheelchair.named_assistant import assistant_maker

    options = NodeOptions(
        scan=scan,
        odometry=odom,
        joystick=joy,
        out=out,
        stamped=stamped,
        axes=_axes(axes),
        base=base,
        mounting=None if mounting is None else pose_of("--mounting", mounting),
        footprint=footprint_of(footprint),
        limits=_limits(limits),
        latency=latency,
        scan_period=scan_period,
        wait=wait,
    )
    options.geometry(options.mounting or pose_of("", "0,0,0"))  # names a value out of range before ROS is asked
    if record is not None:
        require_writable(record, [Path(model)], "--record")
    make_assistant = assistant_maker(model)
    require_ros()
    drive_node(make_assistant, options, ros_arguments=context.obj, record=record)


def _axes(text: str) -> tuple[int, int]:
    try:
        forward, left = (int(word) for word in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"--axes {text!r} must be FORWARD,LEFT, two numbers from 0") from None
    if forward < 0 or left < 0 or forward == left:
        raise typer.BadParameter(f"--axes {text!r} must be two different numbers from 0")
    return forward, left


def _limits(text: str) -> MotionLimits:
    """ValueError for a value out of range."""
    from lfdcore.geometry import MotionLimits

    known = [name for name in vars(MotionLimits) if not name.startswith("_")]
    given: dict[str, Any] = {}
    for word in text.split(","):
        name, _, value = word.strip().partition("=")
        if name not in known or name in given:
            raise typer.BadParameter(f"--limits: {name!r} is unknown or there twice, names are {', '.join(known)}")
        try:
            given[name] = float(value)
        except ValueError:
            raise typer.BadParameter(f"--limits {word!r} must be NAME=VALUE") from None
    return MotionLimits(**given)
