"""The topics of the node: who publishes what, and what is wrong with that."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from lfdcore.datasets.frame_tree import FrameTree
from lfdcore.geometry import Twist2
from lfdcore.ros.messages import fill_twist
from lfdcore.ros.options import NodeOptions
from lfdcore.ros.senses import Senses


class Inputs:
    """Subscribes what the loop observes, with the QoS of sensor data: it matches every publisher."""

    def __init__(self, node: Any, options: NodeOptions, senses: Senses) -> None:
        from nav_msgs.msg import Odometry
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        from sensor_msgs.msg import Joy, LaserScan

        self._node = node
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        several = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.scan = node.create_subscription(LaserScan, options.scan, senses.take_scan, newest)
        self.odometry = node.create_subscription(Odometry, options.odometry, senses.take_odometry, several)
        self.joystick = node.create_subscription(Joy, options.joystick, senses.take_joystick, newest)

    def why_silent(self, subscription: Any) -> str:
        """Of a topic on which nothing came."""
        wanted = _type_name(subscription.msg_type)
        found = {one.topic_type for one in self._node.get_publishers_info_by_topic(subscription.topic_name)}
        if not found:
            return f"nobody publishes {subscription.topic_name}"
        if wanted not in found:
            return f"{subscription.topic_name} is of {', '.join(sorted(found))}, must be of {wanted}"
        return f"nothing came on {subscription.topic_name}, though it has a publisher"


class Commands:
    """Publishes commands: reliable, the newest counts.

    frame: of stamped ones.
    """

    ACKNOWLEDGED_WITHIN = 0.2
    """[s] for which the last command waits until its receivers have it"""

    def __init__(self, node: Any, options: NodeOptions) -> None:
        from geometry_msgs.msg import Twist, TwistStamped

        self._node, self._stamped = node, options.stamped
        self.frame = ""
        self._publisher = node.create_publisher(TwistStamped if options.stamped else Twist, options.out, 1)

    def send(self, twist: Twist2) -> None:
        """Publishes `twist` [m/s, rad/s]."""
        message = self._publisher.msg_type()
        if self._stamped:
            message.header.stamp = self._node.get_clock().now().to_msg()
            message.header.frame_id = self.frame
        fill_twist(message.twist if self._stamped else message, twist)
        self._publisher.publish(message)

    def flush(self) -> None:
        """Waits until the receivers have what was sent last, but not for long."""
        from rclpy.duration import Duration

        with suppress(RuntimeError):  # it is sent; not every middleware says whether it arrived
            self._publisher.wait_for_all_acked(Duration(seconds=self.ACKNOWLEDGED_WITHIN))

    def problems(self) -> list[str]:
        """Why commands would not arrive, or not alone."""
        topic, mine = self._publisher.topic_name, _type_name(self._publisher.msg_type)
        listening = {one.topic_type for one in self._node.get_subscriptions_info_by_topic(topic)}
        if not listening:
            return [f"nobody listens on {topic}"]
        other = listening - {mine}
        found = [f"{topic} is listened to as {kind}, but commands are {mine} (see --stamped)" for kind in sorted(other)]
        rivals = [_full_name(one) for one in self._node.get_publishers_info_by_topic(topic)]
        if self._node.get_fully_qualified_name() in rivals:
            rivals.remove(self._node.get_fully_qualified_name())
        return found + [
            f"{name} publishes {topic} too, but a chair has one master (it is seen for 20 s if it was killed)"
            for name in sorted(set(rivals))
        ]


def listen_to_static_frames(node: Any, frames: FrameTree) -> None:
    """Subscribes /tf_static. ValueError where the robot's ROS lacks its type."""
    try:
        from tf2_msgs.msg import TFMessage
    except ModuleNotFoundError:
        raise ValueError("tf2_msgs is not installed, so /tf_static cannot be read: say --mounting X,Y,YAW") from None
    from rclpy.qos import DurabilityPolicy, QoSProfile

    latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(TFMessage, "/tf_static", frames.add, latched)


def _full_name(endpoint: Any) -> str:
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def _type_name(kind: Any) -> str:
    package, folder, *_ = kind.__module__.split(".")
    return f"{package}/{folder}/{kind.__name__}"
