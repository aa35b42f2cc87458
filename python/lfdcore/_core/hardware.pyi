"""
The joystick's link and its odometry, LIDARs.
"""

from __future__ import annotations
import collections.abc
import lfdcore._core.geometry
import lfdcore._core.grid
import typing

__all__: list[str] = [
    "EncoderOdometry",
    "JoystickCalibration",
    "JoystickIdentity",
    "JoystickLink",
    "JoystickReading",
    "LinkStatistics",
    "ScipLidar",
    "ScipStatistics",
    "TimedScan",
    "WheelEncoders",
]

class JoystickCalibration:
    """
    What a joystick's voltages mean, and what voltages the chair's controller takes (docs/joystick-link.md).
    """

    def __init__(
        self,
        *,
        axes: collections.abc.Sequence[collections.abc.Sequence[int]],
        outputs: collections.abc.Sequence[collections.abc.Sequence[int]],
        profiles: collections.abc.Sequence[int],
    ) -> None:
        """
        axes: of forward and left, each (minus, centre, plus, dead zone) [ADC counts, 0 to 1023]; outputs: of forward and left, each (minus, neutral, plus) [DAC codes, 0 to 4095]; profiles: 4, each 1 to 100 [%]. ValueError for what is not sound.
        """

    @property
    def axes(self) -> list[list[int]]:
        """
        of forward and left: (minus, centre, plus, dead zone) [ADC counts]
        """

    @property
    def outputs(self) -> list[list[int]]:
        """
        of forward and left: (minus, neutral, plus) [DAC codes]
        """

    @property
    def profiles(self) -> list[int]:
        """
        [%] of full output that each profile gives
        """

class JoystickReading:
    """
    What the newest report of the joystick's chip says.
    """

    @property
    def adc(self) -> list[int]:
        """
        of both axes [counts]
        """

    @property
    def chip(self) -> str:
        """
        the chip's state
        """

    @property
    def edges(self) -> list[int]:
        """
        of the left and the right encoder; they wrap around at 32 bits
        """

    @property
    def emergency(self) -> bool:
        """
        the emergency input is
        """

    @property
    def faults(self) -> list[str]:
        """
        by name
        """

    @property
    def forward(self) -> float:
        """
        of the stick, in [-1, 1]
        """

    @property
    def given_forward(self) -> float:
        """
        what the controller is given, in [-1, 1]
        """

    @property
    def given_left(self) -> float:
        """
        what the controller is given, in [-1, 1]
        """

    @property
    def left(self) -> float:
        """
        of the stick, in [-1, 1]
        """

    @property
    def lost_edges(self) -> int:
        """
        that came too fast, since power-up; wraps around
        """

    @property
    def manual(self) -> bool:
        """
        the manual button is pressed
        """

    @property
    def profile(self) -> int:
        """
        selected, 0 to 3
        """

    @property
    def run(self) -> int:
        """
        how often the chip began anew, as far as can be told: edges of two runs do not compare
        """

    @property
    def stamp(self) -> float:
        """
        [s] of time.monotonic(), when the stick was read
        """

    @property
    def tick(self) -> int:
        """
        [ms] of the chip's clock, the same; it wraps around at 32 bits
        """

class LinkStatistics:
    """
    Counted since the link began.
    """

    @property
    def answers(self) -> int: ...
    @property
    def bad_frames(self) -> int:
        """
        that came in and were none
        """

    @property
    def connections(self) -> int:
        """
        begun with a report after there was none, or of a chip that began anew
        """

    @property
    def lost_reports(self) -> int:
        """
        gaps in what the chip counts
        """

    @property
    def reports(self) -> int: ...

class JoystickIdentity:
    """
    Who the chip is.
    """

    @property
    def calibrated(self) -> bool: ...
    @property
    def calibration(self) -> JoystickCalibration:
        """
        what is stored; of no meaning if not calibrated
        """

    @property
    def firmware(self) -> int:
        """
        version
        """

class JoystickLink:
    """
    The link to the Arduino at the joystick (docs/joystick-link.md). A thread answers each of its reports with the newest command, as far as the stick allows it. A cable that is pulled out is a state; the thread finds it again.
    """

    def __init__(self, port: str, patience: float = 3.0) -> None:
        """
        Opens a serial port and waits for the first report, `patience` [s] at the longest, 60 at most. DeviceError for a port that cannot be opened, and for one at which nothing, or something else, talks.
        """

    def calibrate(self, calibration: JoystickCalibration) -> None:
        """
        Stores a calibration in the chip. DeviceError where it does not take it: it drives, or does not answer.
        """

    def close(self) -> None:
        """
        Ends the thread and lets the port go.
        """

    def command(self, forward: float, left: float, duration: float = 0.25) -> None:
        """
        What the chair is to do from now on, each in [-1, 1] of full output, for `duration` [s], .25 at the longest. What is not finite or out of range is no error but the state fault, which ends at neutral after a sound command.
        """

    def identity(self) -> JoystickIdentity:
        """
        Asks who the chip is. DeviceError without an answer.
        """

    def read(self) -> JoystickReading | None:
        """
        -> what the newest report says; None while there is none
        """

    def select_profile(self, profile: int) -> None:
        """
        0 to 3; the stick is needed at neutral then. ValueError for another.
        """

    def take_readings(self) -> list[JoystickReading]:
        """
        -> all readings since this was called last, the oldest first: of the last 2 s at most
        """

    @property
    def fault(self) -> str:
        """
        why there is no link; empty while there is one
        """

    @property
    def port(self) -> str: ...
    @property
    def state(self) -> str:
        """
        'neutral_required', 'ready', 'driving', 'fault', 'emergency' or 'disconnected'
        """

    @property
    def statistics(self) -> LinkStatistics: ...

class WheelEncoders:
    """
    Wheels and their encoders. Nothing has a default that could be another chair's.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        left_radius: float = 0.0,
        right_radius: float = 0.0,
        track: float = 0.0,
        edges_per_turn: float = 0.0,
        window: float = 0.05,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def edges_per_turn(self) -> float:
        """
        of a wheel: four a line of a quadrature encoder; negative where it counts back
        """

    @property
    def left_radius(self) -> float:
        """
        [m]
        """

    @property
    def right_radius(self) -> float:
        """
        [m]
        """

    @property
    def track(self) -> float:
        """
        [m] between the wheels
        """

    @property
    def window(self) -> float:
        """
        [s] over which the twist is the mean
        """

class EncoderOdometry:
    """
    Adds up what two wheels' encoders count; counts wrap around.
    """

    def __init__(self, config: WheelEncoders) -> None:
        """
        ValueError names a field that is out of range.
        """

    def reset(self) -> None:
        """
        The next counts begin anew; the pose stays.
        """

    def update(self, stamp: float, left: int, right: int) -> None:
        """
        Takes counts read at `stamp` [s]; those of a stamp that is not later are not taken.
        """

    @property
    def pose(self) -> lfdcore._core.geometry.Pose2:
        """
        T_odom_base
        """

    @property
    def twist(self) -> lfdcore._core.geometry.Twist2:
        """
        [m/s, rad/s], the mean of the last window
        """

class TimedScan:
    """
    A scan, when it was taken, and its number.
    """

    @property
    def scan(self) -> lfdcore._core.grid.LaserScan:
        """
        LaserScan
        """

    @property
    def sequence(self) -> int:
        """
        1 for the first scan that was received
        """

    @property
    def stamp(self) -> float:
        """
        when the scanner's mirror began its turn, by the clock of time.monotonic() [s]
        """

class ScipStatistics:
    """
    What a ScipLidar has received.
    """

    @property
    def damaged(self) -> int:
        """
        replies with a wrong sum or a wrong length, and what was no reply
        """

    @property
    def lost(self) -> int:
        """
        scans that the device's clock says are missing between those received
        """

    @property
    def reconnects(self) -> int:
        """
        times that it measured anew after it was lost
        """

    @property
    def scans(self) -> int:
        """
        received whole
        """

class ScipLidar:
    """
    A LIDAR that speaks SCIP 2.0 (Hokuyo UTM-30LX, URG-04LX and their kin), read by a thread of its own from its construction to close().

    address: a serial port (/dev/...), or host or host:port in the network (port 10940 unless given). A serial port is tried at `baud`, then at 115200, 19200, 57600 and 500000. upside_down: mounted hanging, so that its scans are mirrored.

    Raises DeviceError unless it measures: absent, taken, no SCIP device, broken; ValueError for an address or a rate that cannot be. A device that is lost later is no error: fault() says what is wrong, newest() grows old, and the thread tries until it measures again.
    """

    def __init__(self, address: str, *, baud: int = 115200, upside_down: bool = False) -> None: ...
    def close(self) -> None:
        """
        Switches the laser off and ends the thread, within about a second. The last scan stays.
        """

    def fault(self) -> str:
        """
        What is wrong and what to do; empty while it measures.
        """

    def model(self) -> str:
        """
        As the device calls itself.
        """

    def newest(self) -> TimedScan | None:
        """
        The newest scan, at once; None before the first. Compare its stamp with now.
        """

    def scan_period(self) -> float:
        """
        [s]
        """

    def statistics(self) -> ScipStatistics:
        """
        ScipStatistics until now
        """

    def wait_newer(self, sequence: int, patience: float) -> TimedScan | None:
        """
        Waits for a scan with a higher sequence number, `patience` [s] at the longest -> TimedScan or None.
        """
