"""A ROS 2 robot as the chair of the drive loop."""

from __future__ import annotations

from lfdcore.geometry import Pose2, Twist2
from lfdcore.ros.clock import RosClock
from lfdcore.ros.command_outlet import CommandOutlet
from lfdcore.ros.messages import NO_BEAMS
from lfdcore.ros.odometry_buffer import Motion
from lfdcore.ros.senses import Scan, Senses, Stick
from lfdcore.wheelchair.observation import ChairGeometry, Observation

_NO_SCAN = Scan(0, NO_BEAMS, Pose2())
_NO_MOTION = Motion(0, Pose2(), Twist2())
_NO_STICK = Stick(0, (0.0, 0.0))


class RosChair:
    """Observes what came in on topics and commands what goes out on one."""

    def __init__(self, geometry: ChairGeometry, senses: Senses, outlet: CommandOutlet, clock: RosClock) -> None:
        self.geometry = geometry
        self._senses, self._outlet, self._clock = senses, outlet, clock

    def observe(self, stamp: float) -> Observation:
        """The newest of each sense at `stamp` [s], with the stamps of their headers."""
        scan, stick = self._senses.scan(), self._senses.stick()
        motion = self._senses.motion()  # after the scan: it is then no older than the scan's pose
        taken, moved, held = scan or _NO_SCAN, motion or _NO_MOTION, stick or _NO_STICK
        return Observation(
            stamp=stamp,
            scan=taken.scan,
            scan_stamp=self._time_of(scan),
            scan_pose=None if scan is None else taken.pose,
            pose=moved.pose,
            twist=moved.twist,
            odometry_stamp=self._time_of(motion),
            joystick=held.joystick,
            joystick_stamp=self._time_of(stick),
            command=self._outlet.sent,
        )

    def command(self, twist: Twist2, duration: float) -> None:
        """Sends `twist` [m/s, rad/s]; after `duration` [s] without another one 0 is sent."""
        self._outlet.command(twist, duration)

    def stop(self) -> None:
        """Sends 0, and nothing after that."""
        self._outlet.stop()

    def _time_of(self, said: Scan | Motion | Stick | None) -> float | None:
        return None if said is None else self._clock.time_of(said.stamp)
