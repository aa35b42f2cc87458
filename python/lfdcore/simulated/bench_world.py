"""A simulated world around a simulated chip: its DACs drive the chair, the chair turns its encoders, a simulated driver
holds its stick. In real time, since a PC's link is at the other end of it."""

from __future__ import annotations

import math
import threading
import time
from types import TracebackType

from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan
from lfdcore.hardware import JoystickCalibration, WheelEncoders
from lfdcore.simulated.courses import Course
from lfdcore.simulated.drivers import StickHolder
from lfdcore.simulated.joystick_bench import STICK_VOLTS, JoystickBench
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig, joystick_to_twist
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry

STEP = 0.02
"""[s] between two steps of the world"""
LATENCY = 0.1
"""[s] that answering a report, a step of the world and the chair's own controller take together, at most"""
CALIBRATION = JoystickCalibration(
    axes=[(200, 512, 824, 20), (200, 512, 824, 20)],
    outputs=[(1000, 2048, 3096), (1000, 2048, 3096)],
    profiles=[100, 100, 100, 100],
)
"""Of the simulated stick and the simulated controller"""
WHEELS = WheelEncoders(left_radius=0.17, right_radius=0.17, track=0.56, edges_per_turn=2000)
"""Of the simulated chair"""


class BenchWorld:
    """The world of a course at real time, in a thread of its own, and a ScanSource. To be used in a `with` statement.

    bench: the chip, calibrated by CALIBRATION, in real time. What holds its stick is `driver`, who knows what is true.
    """

    name = "sim"

    def __init__(self, bench: JoystickBench, course: Course, driver: StickHolder, seed: int) -> None:
        self._bench, self._driver = bench, driver
        self._lidar = LidarConfig()
        self._chair = ChairConfig(command_latency=0.0)
        self._world = DrivingWorld(course.grid, self._chair, self._lidar, seed)
        self._world.reset(course.start)
        driver.reset(seed)
        self.T_base_laser = self._lidar.T_base_laser
        self.scan_period = PERIOD
        self.collisions = 0
        """contacts with the map that began so far"""
        self._neutral_asked, self._acted = True, -math.inf
        self._lock = threading.Lock()
        self._begin = time.monotonic()
        self._scan = (self._world.scan(), self._begin)
        self._ended = threading.Event()
        self._trouble = ""
        self._thread = threading.Thread(target=self._run, daemon=True)

    def geometry(self) -> ChairGeometry:
        """The chair as an assistant must know it."""
        return ChairGeometry(
            footprint=self._chair.footprint,
            limits=self._chair.limits,
            T_base_laser=self.T_base_laser,
            latency=LATENCY,
            scan_period=2 * PERIOD,  # a loaded machine misses one now and then
        )

    def __enter__(self) -> BenchWorld:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Time stands still."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def newest(self) -> tuple[LaserScan, float]:
        """The last scan, and when it was taken by time.monotonic() [s]."""
        with self._lock:
            return self._scan

    def fault(self) -> str:
        """Why the world stands still; empty while it does not."""
        return self._trouble

    def ask_neutral(self, asked: bool) -> None:
        """The display asks the driver to let the stick go; so it does when a drive begins."""
        self._neutral_asked = asked

    @property
    def pose(self) -> Pose2:
        """Where the chair truly is [map]."""
        with self._lock:
            return self._world.state.pose

    def _run(self) -> None:
        try:
            number = 0
            while not self._ended.wait(max(0.0, self._begin + number * STEP - time.monotonic())):
                number = max(number + 1, math.floor((time.monotonic() - self._begin) / STEP))
                self._step()
        except Exception as error:  # a thread has nobody to raise to: fault() says it
            self._trouble = f"the simulated world stands still: {error}"

    def _step(self) -> None:
        outputs = self._bench.outputs()
        wanted = self._twist(outputs.dac) if outputs.enable else Twist2()
        with self._lock:
            passed = time.monotonic() - self._begin - self._world.state.stamp
            if passed > 0:
                self.collisions += self._world.step(wanted, passed).collision_started
            state = self._world.state
            if time.monotonic() - self._scan[1] >= PERIOD:
                self._scan = (self._world.scan(), time.monotonic())
        self._bench.set_wheels(*_edges(state.twist))
        if state.stamp - self._acted >= PERIOD:
            self._acted = state.stamp
            given = self._driver.act(state.stamp, state.pose, state.twist, state.in_contact)
            stick = (0.0, 0.0) if self._neutral_asked else given.joystick
            self._bench.set_stick(*(_volts(float(axis)) for axis in stick))

    def _twist(self, codes: tuple[int, int]) -> Twist2:
        forward, left = (_share(code, *ends) for code, ends in zip(codes, CALIBRATION.outputs, strict=True))
        return joystick_to_twist(forward, left, self._chair.limits)


def _share(code: int, minus: int, neutral: int, plus: int) -> float:
    """Of full output, in [-1, 1], as the chair's controller understands a voltage."""
    share = (code - neutral) / ((plus - neutral) if code >= neutral else (neutral - minus))
    return min(max(share, -1.0), 1.0)


def _volts(share: float) -> float:
    """Of a stick in [-1, 1]."""
    minus, centre, plus, dead = CALIBRATION.axes[0]
    if share == 0:
        return centre / 1023 * STICK_VOLTS
    end = plus if share > 0 else minus
    count = centre + math.copysign(dead, share) + abs(share) * (end - centre - math.copysign(dead, share))
    return count / 1023 * STICK_VOLTS


def _edges(twist: Twist2) -> tuple[float, float]:
    """[edges/s] of the left and the right encoder"""
    turn = twist.angular * WHEELS.track / 2
    per_metre = WHEELS.edges_per_turn / (2 * math.pi * WHEELS.left_radius)
    return (twist.linear - turn) * per_metre, (twist.linear + turn) * per_metre
