"""What people see of the drive: path, intention and mode, for RViz and the terminal."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.ros.messages import fill_heading
from lfdcore.wheelchair.drive_loop import Tick
from lfdcore.wheelchair.observation import Assistance
from lfdcore.wheelchair.watch import HALTS, UNTIL_NEUTRAL

Floats = NDArray[np.float64]


class Display:
    """Publishes ~/path, ~/intention and ~/state; who comes late gets the newest.

    frame: of odometry, in which paths and intentions are.
    """

    def __init__(self, node: Any, frame: str) -> None:
        from geometry_msgs.msg import PointStamped, PoseStamped
        from nav_msgs.msg import Path
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        self._node, self._frame, self._pose_type = node, frame, PoseStamped
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._path = node.create_publisher(Path, "~/path", kept)
        self._intention = node.create_publisher(PointStamped, "~/intention", kept)
        self._state = node.create_publisher(String, "~/state", kept)
        self._shown: Floats | None = None
        self._mode = ""

    def show(self, tick: Tick) -> None:
        """The mode of each tick; path and intention when they are made, an empty path when it is left."""
        answer = tick.assistance
        self._state.publish(self._state.msg_type(data=answer.mode))
        if answer.planned or (answer.path is None) != (self._shown is None):
            self._show_path(answer.path)
        if answer.planned and answer.goal is not None:
            self._show_intention(answer.goal)
        self._say(answer)

    def _say(self, answer: Assistance) -> None:
        if answer.mode == self._mode:
            return
        self._mode = answer.mode
        until = ", until the stick was at neutral" if answer.mode in UNTIL_NEUTRAL else ""
        text = f"stopped: {answer.mode}{until}" if answer.mode in HALTS else f"mode {answer.mode}"
        self._node.get_logger().info(text)

    def _show_path(self, path: Floats | None) -> None:
        self._shown = path
        message = self._headed(self._path.msg_type())
        if path is not None and len(path):
            message.poses = [self._pose(message.header, *row) for row in _with_headings(path)]
        self._path.publish(message)

    def _show_intention(self, goal: tuple[float, float]) -> None:
        message = self._headed(self._intention.msg_type())
        message.point.x, message.point.y = goal
        self._intention.publish(message)

    def _pose(self, header: Any, x: float, y: float, yaw: float) -> Any:
        stamped = self._pose_type(header=header)
        stamped.pose.position.x, stamped.pose.position.y = x, y
        fill_heading(stamped.pose.orientation, yaw)
        return stamped

    def _headed(self, message: Any) -> Any:
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.header.frame_id = self._frame
        return message


def _with_headings(path: Floats) -> list[list[float]]:
    """(x, y, yaw) of each point; it looks along the path."""
    steps = np.diff(path, axis=0) if len(path) > 1 else np.array([[1.0, 0.0]])
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    rows: list[list[float]] = np.column_stack([path, np.append(yaws, yaws[-1:])[: len(path)]]).tolist()
    return rows
