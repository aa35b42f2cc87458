"""The node: topics -> RosChair -> the drive loop -> topics, from its start-up to the last command, which is 0."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from lfdcore.datasets.frame_tree import FrameTree
from lfdcore.ros.chair import RosChair
from lfdcore.ros.clock import RosClock
from lfdcore.ros.command_outlet import CommandOutlet
from lfdcore.ros.display import Display
from lfdcore.ros.ending import one_ending
from lfdcore.ros.options import NodeOptions
from lfdcore.ros.senses import Senses
from lfdcore.ros.spinning import Spinning
from lfdcore.ros.startup import Startup
from lfdcore.ros.topics import Commands, Inputs, listen_to_static_frames
from lfdcore.wheelchair.assistants import Assistant
from lfdcore.wheelchair.drive_loop import Tick, drive
from lfdcore.wheelchair.observation import ChairGeometry

NAME = "lfdcore"
COMPLAINS_EVERY = 2.0
"""[s] between two complaints"""


def require_ros() -> None:
    """ValueError that says what to do where the robot's ROS cannot be imported."""
    try:
        for package in ("rclpy", "geometry_msgs.msg", "nav_msgs.msg", "sensor_msgs.msg", "std_msgs.msg"):
            import_module(package)
    except ImportError as error:
        raise ValueError(
            f"this needs ROS 2 ({error}): run `source /opt/ros/DISTRO/setup.bash` in this shell, and lfdcore with the "
            "Python that this ROS is for; without ROS, install lfdcore with the extra 'ros2' into a venv of its own"
        ) from error


def drive_node(
    make_assistant: Callable[[ChairGeometry], Assistant],
    options: NodeOptions,
    *,
    ros_arguments: Sequence[str] = (),
    record: Path | None = None,
) -> None:
    """Drives the robot until a signal ends it: KeyboardInterrupt or SystemExit. The last command is 0, also after any
    other exception. ValueError where ROS is missing, and for a robot that does not say what must be known.

    make_assistant: for the robot's chair, once its scanner's mounting is known. ros_arguments: from --ros-args on.
    record: where a drive log goes; a file that stands there is replaced once the drive begins.
    """
    require_ros()
    with one_ending(), _ros_node(ros_arguments) as node, _Parts(node, options) as parts:
        parts.drive(make_assistant, record)


@contextmanager
def _ros_node(arguments: Sequence[str]) -> Iterator[Any]:
    """A node whose context only ends here: rclpy's own signal handlers would end it before the last command."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from rclpy.utilities import remove_ros_args

    with _as_value_errors():
        left = remove_ros_args(["lfdcore", *arguments])[1:]
        if left:
            raise ValueError(f"{' '.join(left)} after --ros-args is none of ROS's own arguments")
        rclpy.init(args=["lfdcore", *arguments], signal_handler_options=SignalHandlerOptions.NO)
    try:
        with _as_value_errors():
            node = rclpy.create_node(NAME)
        yield node
    finally:
        rclpy.shutdown()


@contextmanager
def _as_value_errors() -> Iterator[None]:
    """What ROS refuses of names, arguments and parameters, in one line."""
    from rclpy.exceptions import NameValidationException, ParameterException

    try:
        yield
    except (RuntimeError, NameValidationException, ParameterException) as error:
        raise ValueError(f"ROS refuses this: {error}") from error


class _Parts:
    """All that hangs on the node; a context manager that ends the thread which takes in messages."""

    def __init__(self, node: Any, options: NodeOptions) -> None:
        from rclpy.executors import SingleThreadedExecutor

        self._node, self._options = node, options
        self._senses = Senses(options.axes, self._now, self._complain)
        statics = FrameTree()
        with _as_value_errors():
            self._commands = Commands(node, options)
            inputs = Inputs(node, options, self._senses)
        if options.mounting is None:
            listen_to_static_frames(node, statics)
        self._startup = Startup(node, options, self._senses, inputs, self._commands, statics)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        self._spinning = Spinning(executor)

    def __enter__(self) -> _Parts:
        return self

    def __exit__(self, *_: object) -> None:
        self._spinning.end()

    def drive(self, make_assistant: Callable[[ChairGeometry], Assistant], record: Path | None) -> None:
        """From the start-up on."""
        frames, mounting = self._startup.wait()
        self._senses.settle(frames, mirrored=mounting.mirrored)
        self._commands.frame = frames.base
        geometry = self._options.geometry(mounting.T_base_laser)
        assistant = make_assistant(geometry)
        display = Display(self._node, frames.odometry)
        self._node.get_logger().info(f"{assistant.name} drives; scanner at {mounting}")

        clock = RosClock(self._now, geometry.period, self._spinning.require_alive)
        outlet = CommandOutlet(self._commands.send, self._now, lambda: bool(self._node.get_clock().ros_time_is_active))
        with ExitStack() as stack:
            log = None if record is None else stack.enter_context(_log(record, geometry, assistant))
            stack.callback(self._commands.flush)
            stack.callback(outlet.stop)  # again: a signal may have come while the loop stopped the chair
            chair = RosChair(geometry, self._senses, outlet, clock)
            drive(chair, assistant, _Shown(display, self._commands, self._complain), clock=clock, log=log)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _complain(self, text: str) -> None:
        self._node.get_logger().error(text, throttle_duration_sec=COMPLAINS_EVERY)


class _Shown:
    """Called after each tick, none of which is the last: shows it, and says what is wrong with the commands' topic."""

    def __init__(self, display: Display, commands: Commands, complain: Callable[[str], None]) -> None:
        self._display, self._commands, self._complain = display, commands, complain
        self._looked = -math.inf

    def __call__(self, tick: Tick) -> bool:
        self._display.show(tick)
        if tick.stamp - self._looked >= COMPLAINS_EVERY or tick.stamp < self._looked:
            self._looked = tick.stamp
            for problem in self._commands.problems():
                self._complain(problem)
        return False


def _log(path: Path, geometry: ChairGeometry, assistant: Assistant) -> Any:
    from lfdcore.datasets.drive_log import DriveLogWriter

    return DriveLogWriter(path, T_base_laser=geometry.T_base_laser, metadata={"assistant": assistant.name})
