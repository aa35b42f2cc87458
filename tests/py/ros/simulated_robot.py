"""A ROS 2 robot for tests, run in a process of its own: publishes a simulated chair's scans, odometry and stick,
executes the commands that come, and does as it is told by lines on its standard input.

It prints a line of JSON for each tick, each message that it receives, and each line that it was told.

Told: `stick FORWARD LEFT`; `scan STATE`, `odom STATE` and `joy STATE`, where STATE is on, off or what is wrong with
them; `clock RATE` (times wall time); `back SECONDS`; `end`.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import threading
import time
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PointStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry, Path
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy, LaserScan
from std_msgs.msg import String

from lfdcore.geometry import Pose2, Twist2
from lfdcore.simulated.chair import SimulatedChair
from lfdcore.simulated.courses import hall
from lfdcore.simulated.drivers import DriverInput
from lfdcore.simulation import ChairConfig, LidarConfig
from lfdcore.wheelchair.observation import Observation

PERIOD = 0.05
"""[s] between messages"""
HOLDS = 1.0
"""[s] for which this robot obeys a command: it has a watchdog of its own"""


printing = threading.Lock()


def say(**what: Any) -> None:
    with printing:
        print(json.dumps({"at": time.monotonic(), **what}), flush=True)


class Stick:
    """A StickHolder that holds it as told."""

    def __init__(self) -> None:
        self.joystick = np.zeros(2)

    def reset(self, seed: int) -> None:
        pass

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        return DriverInput(self.joystick, self.joystick)


class Robot:
    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._stick = Stick()
        self._chair = SimulatedChair(hall(), self._stick, 1, ChairConfig(), LidarConfig())
        self._lock = threading.Lock()
        self._told = {"scan": "on", "odom": "on", "joy": "on"}
        self._rate, self._time = 1.0, 0.0
        self._epoch = 1000.0
        self.ended = threading.Event()
        self._node = rclpy.create_node("robot")
        self._publish()

    def _publish(self) -> None:
        node, sensors = self._node, qos_profile_sensor_data
        wrong = self._options.wrong
        self._scan = node.create_publisher(String if wrong == "scan" else LaserScan, "/scan", sensors)
        self._odom = node.create_publisher(Odometry, "/odom", 10)
        self._joy = node.create_publisher(String if wrong == "joy" else Joy, "/joy", 10)
        self._clock = node.create_publisher(Clock, "/clock", 10) if self._options.clock else None
        kind = TwistStamped if self._options.stamped else Twist
        node.create_subscription(kind, "/cmd_vel", self._command, 10)
        if self._options.wrong == "rival":
            node.create_publisher(Twist, "/cmd_vel", 10)
        kept = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(Path, "/lfdcore/path", self._saw_path, kept)
        node.create_subscription(PointStamped, "/lfdcore/intention", self._saw_intention, kept)
        node.create_subscription(String, "/lfdcore/state", lambda message: say(state=message.data), 10)

    def _saw_path(self, message: Path) -> None:
        ends = [[p.pose.position.x, p.pose.position.y] for p in (message.poses[:1] + message.poses[-1:])]
        say(path=len(message.poses), ends=ends, frame=message.header.frame_id)

    def _saw_intention(self, message: PointStamped) -> None:
        say(intention=[message.point.x, message.point.y], frame=message.header.frame_id)

    def _command(self, message: Any) -> None:
        twist = message.twist if self._options.stamped else message
        stamped = {"frame": message.header.frame_id} if self._options.stamped else {}
        with self._lock:
            self._chair.command(Twist2(twist.linear.x, twist.angular.z), HOLDS)
        say(command=[twist.linear.x, twist.angular.z], **stamped)

    def told(self, line: str) -> None:
        what, *values = line.split()
        with self._lock:
            if what == "stick":
                self._stick.joystick = np.array(values, float)
            elif what == "clock":
                self._rate = float(values[0])
            elif what == "back":
                self._epoch -= float(values[0])
            elif what == "end":
                self.ended.set()
            else:
                self._told[what] = values[0]
        say(told=line.strip())

    def tick(self, passed: float) -> None:
        with self._lock:
            self._time += passed * self._rate
            seen = self._chair.observe(self._time)
        now = time.time() if self._clock is None else self._epoch + self._time
        if self._clock is not None:
            self._clock.publish(Clock(clock=stamp(now)))
        where = self._chair.truth.state.pose
        self._publish_odometry(seen, now)
        self._publish_scan(seen, now)
        self._publish_joystick(seen, now)
        say(pose=[*where], joystick=seen.joystick, contact=self._chair.truth.collision)

    def _publish_scan(self, seen: Observation, now: float) -> None:
        state = self._told["scan"]
        if state == "off" or self._options.wrong == "scan":
            return
        message, scan = LaserScan(), seen.scan
        message.header.stamp, message.header.frame_id = stamp(now + self._options.ahead), self._options.laser
        message.angle_min, message.angle_increment = scan.angle_min, scan.angle_increment
        message.range_min, message.range_max = scan.range_min, scan.range_max
        message.ranges = np.asarray(scan.ranges, np.float32)
        if state == "empty":
            message.ranges = []
        if state == "nan":
            message.ranges = [math.nan] * len(scan.ranges)
        if state == "flat":
            message.angle_increment = 0.0
        if state == "frame":
            message.header.frame_id = "elsewhere"
        self._scan.publish(message)

    def _publish_odometry(self, seen: Observation, now: float) -> None:
        state = self._told["odom"]
        if state == "off":
            return
        message = Odometry()
        message.header.stamp, message.header.frame_id = stamp(now), "odom"
        message.child_frame_id = "elsewhere" if state == "frame" else self._options.child
        pose = message.pose.pose
        pose.position.x, pose.position.y = seen.pose.x, seen.pose.y
        pose.orientation.z, pose.orientation.w = math.sin(seen.pose.yaw / 2), math.cos(seen.pose.yaw / 2)
        message.twist.twist.linear.x, message.twist.twist.angular.z = seen.twist.linear, seen.twist.angular
        if state == "nan":
            pose.position.x = math.nan
        if state == "unturned":
            pose.orientation.w = pose.orientation.z = 0.0
        self._odom.publish(message)

    def _publish_joystick(self, seen: Observation, now: float) -> None:
        state = self._told["joy"]
        if state == "off" or self._options.wrong == "joy":
            return
        forward, left = seen.joystick
        message = Joy(axes=[left, forward, 0.0, 0.0])
        if self._options.stamped_stick:
            message.header.stamp = stamp(now)
        if state == "short":
            message.axes = message.axes[:1]
        self._joy.publish(message)

    def spin(self) -> None:
        executor = SingleThreadedExecutor()
        executor.add_node(self._node)
        while not self.ended.is_set():
            executor.spin_once(timeout_sec=0.1)


def stamp(seconds: float) -> Any:
    return rclpy.time.Time(nanoseconds=round(seconds * 1e9)).to_msg()


def listen(robot: Robot) -> None:
    for line in sys.stdin:
        robot.told(line)
    robot.ended.set()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--clock", action="store_true")
    parser.add_argument("--stamped", action="store_true")
    parser.add_argument("--stamped-stick", action="store_true")
    parser.add_argument("--wrong", choices=["", "scan", "joy", "rival"], default="")
    parser.add_argument("--laser", default="laser")
    parser.add_argument("--child", default="base_link")
    parser.add_argument("--ahead", type=float, default=0.0)
    options = parser.parse_args()
    rclpy.init()
    robot = Robot(options)
    spinning = threading.Thread(target=robot.spin)
    spinning.start()
    threading.Thread(target=listen, args=[robot], daemon=True).start()
    last = time.monotonic()
    while not robot.ended.wait(PERIOD):
        now = time.monotonic()
        robot.tick(now - last)
        last = now
    spinning.join()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
