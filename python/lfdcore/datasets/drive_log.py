"""Drive logs: everything that is recorded of a drive, in memory and in one file (docs/drive-log.md)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

import lfdcore
from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.whole_file import whole_file
from lfdcore.errors import DataError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.grid import LaserScan

Array = NDArray[np.float64]

FORMAT = "drive log 1"
"""What the file calls itself; the number counts changes that an older reader cannot read."""
SCAN_LAYOUT = ("angle_min", "angle_increment", "range_min", "range_max")
"""Float64 beside the float32 of sensor_msgs/LaserScan, so that a replay sees the very same scans"""
FARTHEST = 1e7
"""[m] of a pose from its origin"""
LEAD = 2.0
"""[s] of odometry, joystick and commands that a share keeps from before its first scan"""

_STREAMS = {
    "odometry": ("pose", "twist"),
    "joystick": ("joystick",),
    "desired": ("desired",),
    "command": ("command",),
    "map": ("map_odom",),
}
_WIDTHS = {"pose": 3, "twist": 2, "joystick": 2, "desired": 2, "command": 2, "map_odom": 3}
_MAP = "/tf of map"
"""The localiser's transforms keep a clock of their own on /tf: they may be older than the odometry's."""
_JOYSTICK_BOUND = 1 + 1e-6  # float32 in the file


@dataclass(frozen=True, eq=False)
class Plan:
    """A path that an assistant made."""

    stamp: float
    """[s]"""
    path: Array
    """(N, 2) [m] in odom"""


@dataclass(frozen=True)
class Intention:
    """Where an assistant believed that the driver wants to go."""

    stamp: float
    """[s]"""
    goal: tuple[float, float]
    """[m] in odom"""
    likelihood: float
    """of the goal, as the assistant normalises it"""


def _no_stamps() -> Array:
    return np.zeros(0)


def _no_pairs() -> Array:
    return np.zeros((0, 2))


def _no_poses() -> Array:
    return np.zeros((0, 3))


@dataclass(frozen=True, kw_only=True, eq=False)
class DriveLog:
    """One drive. Stamps are seconds since the log's own epoch and never decrease; B beams a scan.

    ValueError for arrays whose shapes do not fit together, stamps that are not finite or go back, poses, twists or
    commands that are not finite, poses beyond 1e7 m, negative ranges, joystick values outside [-1, 1]. Ranges follow
    REP-117: inf is nothing within range_max, -inf too close, NaN no measurement (lfdcore.grid.read_beams). Headings are
    made continuous (unwrapped).
    """

    scan_stamp: Array
    """(S,) [s]"""
    ranges: NDArray[np.float32]
    """(S, B) [m]"""
    angle_min: float = -math.pi / 2
    """of beam 0 in the laser's frame [rad]"""
    angle_increment: float = math.pi / 180
    """[rad]"""
    range_min: float = 0.0
    """[m]"""
    range_max: float = 30.0
    """[m]"""
    T_base_laser: Pose2 | None = None
    """The sensor's mounting; None where it is not known: `mounting` is an error then"""
    odometry_stamp: Array = field(default_factory=_no_stamps)
    """(T,) [s]"""
    pose: Array = field(default_factory=_no_poses)
    """(T, 3) T_odom_base: x, y [m], yaw [rad], continuous"""
    twist: Array = field(default_factory=_no_pairs)
    """(T, 2) [m/s, rad/s] by odometry"""
    joystick_stamp: Array = field(default_factory=_no_stamps)
    """(J,) [s]"""
    joystick: Array = field(default_factory=_no_pairs)
    """(J, 2) (forward, left) as given, in [-1, 1]"""
    desired_stamp: Array = field(default_factory=_no_stamps)
    """(D,) [s]"""
    desired: Array = field(default_factory=_no_pairs)
    """(D, 2) (forward, left) as meant, before the disability; empty where nobody knows"""
    command_stamp: Array = field(default_factory=_no_stamps)
    """(C,) [s]"""
    command: Array = field(default_factory=_no_pairs)
    """(C, 2) [m/s, rad/s] sent to the chair"""
    map_stamp: Array = field(default_factory=_no_stamps)
    """(M,) [s]"""
    map_odom: Array = field(default_factory=_no_poses)
    """(M, 3) T_map_odom: x, y [m], yaw [rad], continuous: where a localiser put the odometry's frame in the map; each
    holds until the next. Empty where nobody knows"""
    plans: list[Plan] = field(default_factory=list)
    intentions: list[Intention] = field(default_factory=list)
    metadata: dict[str, str] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        self._convert()
        _require_stamps("scan_stamp", self.scan_stamp)
        _require_scans(self)
        for stream, values in _STREAMS.items():
            stamps: Array = getattr(self, f"{stream}_stamp")
            _require_stamps(f"{stream}_stamp", stamps)
            for name in values:
                _require_rows(name, getattr(self, name), len(stamps))
        _require_on_earth(self.pose)
        for name in ("joystick", "desired"):
            _require_joystick(name, getattr(self, name))
        _require_thoughts(self.plans, self.intentions)
        for name in ("pose", "map_odom"):
            poses = getattr(self, name)
            object.__setattr__(self, name, np.c_[poses[:, :2], np.unwrap(poses[:, 2])])

    def _convert(self) -> None:
        for one in dataclasses.fields(self):
            value = getattr(self, one.name)
            if one.name == "ranges":
                object.__setattr__(self, one.name, np.ascontiguousarray(value, np.float32))
            elif one.name.endswith("_stamp") or one.name in _WIDTHS:
                object.__setattr__(self, one.name, np.ascontiguousarray(value, np.float64))

    @property
    def mounting(self) -> Pose2:
        """T_base_laser. DataError where it is not known, saying what to do."""
        if self.T_base_laser is None:
            raise DataError(
                f"log {self.name!r} does not say where its scanner is on the robot: say --mounting X,Y,YAW (in Python "
                "T_base_laser=)"
            )
        return self.T_base_laser

    @property
    def duration(self) -> float:
        """[s] from the first record to the last, a localiser's aside; 0 for an empty log."""
        streams = (getattr(self, f"{n}_stamp") for n in _STREAMS if n != "map")  # what holds may be from long before
        stamps = [s for s in (self.scan_stamp, *streams) if len(s)]
        return float(max(s[-1] for s in stamps) - min(s[0] for s in stamps)) if stamps else 0.0

    def scan(self, index: int) -> LaserScan:
        """One scan, as the simulator and a chair give it; IndexError beyond the last."""
        return LaserScan(self.ranges[index], self.angle_min, self.angle_increment, self.range_min, self.range_max)

    def pose_at(self, t: ArrayLike) -> Array:
        """Poses in odom at times (N,) [s] -> (N, 3), linear between records and constant beyond the ends.

        Between two records this looks at the later one: right for what was driven, not for what was known.
        """
        times = _times(t)
        if not len(self.odometry_stamp):
            raise ValueError(f"log {self.name!r} holds no odometry, so no pose is known")
        return np.stack([np.interp(times, self.odometry_stamp, self.pose[:, k]) for k in range(3)], axis=1)

    def map_pose_at(self, t: ArrayLike) -> Array:
        """Poses in the map at times (N,) [s] -> (N, 3): T_odom_base as `pose_at` has it, by the T_map_odom last known.

        Before the first T_map_odom, that one counts. ValueError for a log without any, or without odometry.
        """
        times = _times(t)
        if not len(self.map_stamp):
            raise ValueError(f"log {self.name!r} holds no pose in a map (/tf from map to odom)")
        held = np.maximum(np.searchsorted(self.map_stamp, times, side="right") - 1, 0)
        x, y, yaw = self.map_odom[held].T
        pose = self.pose_at(times)
        c, s = np.cos(yaw), np.sin(yaw)
        return np.stack(
            [x + c * pose[:, 0] - s * pose[:, 1], y + s * pose[:, 0] + c * pose[:, 1], yaw + pose[:, 2]], axis=1
        )

    def twist_at(self, t: ArrayLike) -> Array:
        """The twist last known at times (N,) [s] -> (N, 2) [m/s, rad/s]; 0 before the first record."""
        return _held(_times(t), self.odometry_stamp, self.twist)

    def joystick_at(self, t: ArrayLike) -> Array:
        """The joystick as last given at times (N,) [s] -> (N, 2) (forward, left); centred before the first record."""
        return _held(_times(t), self.joystick_stamp, self.joystick)

    def slice(self, t0: float, t1: float, *, lead: float = 0.0) -> DriveLog:
        """The records with t0 <= stamp < t1 [s]; all but scans from t0 - lead on.

        The T_map_odom that holds there stays too, with its own stamp.
        """
        if not t0 <= t1:
            raise ValueError(f"t0 is {t0} s, must not lie after t1 = {t1} s")
        first, last = np.searchsorted(self.scan_stamp, (t0, t1))
        return self._cut(int(first), int(last), t0 - lead, t1)

    def share(self, a: float, b: float, *, lead: float = LEAD) -> DriveLog:
        """Scans int(a S) to int(b S) (exclusive) and what was recorded from `lead` s before the first of them on.

        Nothing reaches beyond the first scan that is left out: a share to learn from holds nothing of the next.
        """
        if not 0 <= a <= b <= 1:
            raise ValueError(f"a share goes from a to b with 0 <= a <= b <= 1, is {a} to {b}")
        count = len(self.scan_stamp)
        first, last = int(a * count), int(b * count)
        begin = self.scan_stamp[first] - lead if first and first < count else -math.inf
        return self._cut(first, last, begin, self.scan_stamp[last] if last < count else math.inf)

    def _cut(self, first: int, last: int, t0: float, t1: float) -> DriveLog:
        changes: dict[str, Any] = {"scan_stamp": self.scan_stamp[first:last], "ranges": self.ranges[first:last]}
        for stream, values in _STREAMS.items():
            stamps = getattr(self, f"{stream}_stamp")
            a, b = np.searchsorted(stamps, (t0, t1))
            if stream == "map" and a and (a == len(stamps) or stamps[a] > t0):
                a -= 1  # what holds at t0
            changes |= {f"{stream}_stamp": stamps[a:b]} | {name: getattr(self, name)[a:b] for name in values}
        changes["plans"] = [plan for plan in self.plans if t0 <= plan.stamp < t1]
        changes["intentions"] = [intention for intention in self.intentions if t0 <= intention.stamp < t1]
        return dataclasses.replace(self, **changes)

    def save(self, path: str | Path) -> None:
        """Writes the log to `path` as one .mcap; what stood there is replaced only by a whole file.

        The file holds stamps to 1 ns, the joystick as float32, all else as it is. ValueError for negative stamps
        and where `path` is a folder or a device.
        """
        with (
            whole_file(path, "log") as part,
            DriveLogWriter(part, T_base_laser=self.T_base_laser, name=self.name, metadata=self.metadata) as writer,
        ):
            for _, _, write in sorted(self._records(writer), key=lambda record: record[:2]):
                write()

    def _records(self, to: DriveLogWriter) -> Iterator[tuple[float, int, Callable[[], None]]]:
        for stamp, pose, twist in zip(self.odometry_stamp.tolist(), self.pose, self.twist, strict=True):
            yield stamp, 0, partial(to.odometry, stamp, Pose2(*pose), Twist2(*twist))
        for index, stamp in enumerate(self.scan_stamp.tolist()):
            yield stamp, 1, partial(lambda at, i: to.scan(at, self.scan(i)), stamp, index)
        for stamp, (forward, left) in zip(self.joystick_stamp.tolist(), self.joystick, strict=True):
            yield stamp, 2, partial(to.joystick, stamp, forward, left)
        for stamp, (forward, left) in zip(self.desired_stamp.tolist(), self.desired, strict=True):
            yield stamp, 3, partial(to.desired, stamp, forward, left)
        for stamp, twist in zip(self.command_stamp.tolist(), self.command, strict=True):
            yield stamp, 4, partial(to.command, stamp, Twist2(*twist))
        for stamp, transform in zip(self.map_stamp.tolist(), self.map_odom, strict=True):
            yield stamp, 7, partial(to.map_odom, stamp, Pose2(*transform))
        for plan in self.plans:
            yield plan.stamp, 5, partial(to.plan, plan.stamp, plan.path)
        for intention in self.intentions:
            yield intention.stamp, 6, partial(to.intention, intention.stamp, intention.goal, intention.likelihood)


def _require_stamps(name: str, stamps: Array) -> None:
    if stamps.ndim != 1:
        raise ValueError(f"{name} has shape {stamps.shape}, must be (N,)")
    _require_finite(name, stamps)
    back = np.flatnonzero(np.diff(stamps) < 0)
    if len(back):
        k = back[0]
        raise ValueError(f"{name} goes back from {stamps[k]} s to {stamps[k + 1]} s at record {k + 1}, must be sorted")


def _require_rows(name: str, values: Array, count: int) -> None:
    if values.shape != (count, _WIDTHS[name]):
        raise ValueError(f"{name} has shape {values.shape}, must be {(count, _WIDTHS[name])}")
    _require_finite(name, values)


def _require_on_earth(pose: Array) -> None:
    """As the maps demand: UTM's coordinates lie within. Beyond, differences of positions are rounding and overflow."""
    wrong = np.argwhere(np.abs(pose[:, :2]) > FARTHEST)
    if len(wrong):
        raise ValueError(f"pose is {pose[tuple(wrong[0])]} m at record {wrong[0][0]}, must lie within +-{FARTHEST:g} m")


def _require_finite(name: str, values: Array) -> None:
    wrong = np.argwhere(~np.isfinite(values))
    if len(wrong):
        raise ValueError(f"{name} is {values[tuple(wrong[0])]} at record {wrong[0][0]}, must be finite")


def _require_scans(log: DriveLog) -> None:
    shape, count = log.ranges.shape, len(log.scan_stamp)
    if len(shape) != 2 or shape[0] != count:
        raise ValueError(f"ranges has shape {shape}, must be ({count}, beams)")
    if count and not shape[1]:
        raise ValueError("ranges has 0 beams, must have at least 1")
    numbers = (log.angle_min, log.angle_increment, log.range_min, log.range_max, *(log.T_base_laser or ()))
    if not np.isfinite(numbers).all():
        raise ValueError(
            f"angle_min, angle_increment, range_min, range_max, T_base_laser are {numbers}, must be finite"
        )
    if log.angle_increment == 0:
        raise ValueError("angle_increment is 0 rad, must not be 0")
    if not 0 <= log.range_min < log.range_max:
        raise ValueError(f"range_min is {log.range_min} m, must lie in [0, range_max = {log.range_max} m)")
    wrong = np.argwhere((log.ranges < 0) & np.isfinite(log.ranges))
    if len(wrong):
        raise ValueError(f"ranges is {log.ranges[tuple(wrong[0])]} m in scan {wrong[0][0]}, must not be negative")


def _require_joystick(name: str, values: Array) -> None:
    wrong = np.argwhere(np.abs(values) > _JOYSTICK_BOUND)
    if len(wrong):
        raise ValueError(f"{name} is {values[tuple(wrong[0])]} at record {wrong[0][0]}, must lie in [-1, 1]")


def _require_thoughts(plans: list[Plan], intentions: list[Intention]) -> None:
    for plan in plans:
        if np.ndim(plan.path) != 2 or np.shape(plan.path)[1] != 2:
            raise ValueError(f"the plan at {plan.stamp} s has shape {np.shape(plan.path)}, must be (N, 2)")
        _require_finite(f"the plan at {plan.stamp} s", np.asarray(plan.path, float))
    for intention in intentions:
        _require_finite(f"the intention at {intention.stamp} s", np.array([*intention.goal, intention.likelihood]))
    for name, stamps in (("plans", [p.stamp for p in plans]), ("intentions", [i.stamp for i in intentions])):
        _require_stamps(name, np.array(stamps, float))


def _times(t: ArrayLike) -> Array:
    times = np.atleast_1d(np.asarray(t, float))
    if times.ndim != 1:
        raise ValueError(f"t has shape {times.shape}, must be (N,)")
    _require_finite("t", times)
    return times


def _held(times: Array, stamps: Array, values: Array) -> Array:
    padded = np.vstack([np.zeros((1, values.shape[1])), values])
    return np.asarray(padded[np.searchsorted(stamps, times, side="right")])


class DriveLogWriter:
    """Records a drive as it happens into one unchunked .mcap; a file that stood at `path` is replaced.

    Each record is handed to the operating system before the call returns: a process that is killed loses at most the
    record it was writing. Stamps [s] lie in [0, 2^31) and never decrease within a topic; all values must be finite.
    ValueError otherwise. A context manager; `close` writes the summary that makes the file complete.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        T_base_laser: Pose2 | None,
        name: str = "",
        metadata: Mapping[str, str] | None = None,
    ) -> None:
        from mcap.writer import Writer

        _require_finite("T_base_laser", np.array([*(T_base_laser or ())]))
        self._file = Path(path).open("wb")  # noqa: SIM115 close() ends what begins here
        self._mcap = Writer(self._file, use_chunking=False, enable_data_crcs=True)
        self._last = dict.fromkeys((*ros.TOPICS, _MAP), 0)
        self._counts = dict.fromkeys(ros.TOPICS, 0)
        self._scan_layout: tuple[float, ...] | None = None
        self._mcap.start(profile="ros2", library=f"lfdcore {lfdcore.__version__}")
        about = {"format": FORMAT, "lfdcore": lfdcore.__version__, "name": name}
        self._note("lfdcore", about | {"T_base_laser": _text(*T_base_laser) if T_base_laser else "unknown"})
        self.note(metadata or {})
        self._channels = self._register()
        if T_base_laser is not None:
            self._write("/tf_static", 0, ros.transform_message(0, "base_link", "laser", T_base_laser))

    def _register(self) -> dict[str, int]:
        kinds = dict.fromkeys(ros.TOPICS.values())
        schemas = {kind: self._mcap.register_schema(kind, "ros2msg", ros.schema(kind)) for kind in kinds}
        return {topic: self._mcap.register_channel(topic, "cdr", schemas[kind]) for topic, kind in ros.TOPICS.items()}

    def _note(self, record: str, values: dict[str, str]) -> None:
        self._mcap.add_metadata(record, values)
        self._file.flush()

    def _write(self, topic: str, nanoseconds: int, message: Any) -> None:
        data = ros.serialize(message, ros.TOPICS[topic])
        self._counts[topic] += 1
        try:
            self._mcap.add_message(self._channels[topic], nanoseconds, data, nanoseconds, self._counts[topic])
            self._file.flush()
        except OSError as error:  # a disk that is full
            raise OSError(error.errno, error.strerror, self._file.name) from error
        self._last[topic] = nanoseconds

    def _time(self, topic: str, stamp: float) -> int:
        if not 0 <= stamp < 2**31:
            raise ValueError(f"stamp is {stamp} s, must lie in [0, 2^31)")
        nanoseconds = round(stamp * 1e9)
        if nanoseconds < self._last[topic]:
            raise ValueError(f"stamp on {topic} goes back from {self._last[topic] / 1e9} s to {stamp} s")
        if self._file.closed:
            raise ValueError(f"{self._file.name} is closed")
        return nanoseconds

    def note(self, metadata: Mapping[str, str]) -> None:
        """Adds to the log's metadata; a later value of a key replaces an earlier one."""
        if metadata:
            self._note("drive", {str(key): str(value) for key, value in metadata.items()})

    def scan(self, stamp: float, scan: LaserScan) -> None:
        """/scan. It has beams; their number and the limits must be those of the first scan."""
        if not len(scan.ranges):
            raise ValueError("a scan has 0 beams, must have at least 1")
        time = self._time("/scan", stamp)
        layout = (float(len(scan.ranges)), scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
        if self._scan_layout is None:
            self._scan_layout = layout
            self._note("scan", dict(zip(SCAN_LAYOUT, map(repr, layout[1:]), strict=True)))  # float32 in the message
        if layout != self._scan_layout:
            names = ("beams", *SCAN_LAYOUT)
            raise ValueError(f"{names} of a scan are {layout}, must stay {self._scan_layout}")
        self._write("/scan", time, ros.scan_message(time, scan))

    def odometry(self, stamp: float, pose: Pose2, twist: Twist2) -> None:
        """/odom and /tf: T_odom_base and the twist in base_link."""
        time = self._time("/odom", stamp)
        _require_finite("odometry", np.array([*pose, *twist]))
        self._write("/odom", time, ros.odometry_message(time, pose, twist))
        self._write("/tf", time, ros.transform_message(time, "odom", "base_link", pose))

    def map_odom(self, stamp: float, transform: Pose2) -> None:
        """/tf: T_map_odom, where a localiser puts the odometry's frame in the map; it holds until the next."""
        time = self._time(_MAP, stamp)
        _require_finite("map_odom", np.array([*transform]))
        self._write("/tf", time, ros.transform_message(time, "map", "odom", transform))
        self._last[_MAP] = time

    def joystick(self, stamp: float, forward: float, left: float) -> None:
        """/joy: the input as given, each axis in [-1, 1], kept as float32."""
        self._joystick("/joy", stamp, forward, left)

    def desired(self, stamp: float, forward: float, left: float) -> None:
        """/joy_desired: the input as meant, before the disability; each axis in [-1, 1], kept as float32."""
        self._joystick("/joy_desired", stamp, forward, left)

    def _joystick(self, topic: str, stamp: float, forward: float, left: float) -> None:
        time = self._time(topic, stamp)
        for name, value in (("forward", forward), ("left", left)):
            if not abs(value) <= _JOYSTICK_BOUND:
                raise ValueError(f"{name} on {topic} is {value}, must lie in [-1, 1]")
        self._write(topic, time, ros.joystick_message(time, forward, left))

    def command(self, stamp: float, twist: Twist2) -> None:
        """/cmd_vel: the twist that was sent to the chair."""
        time = self._time("/cmd_vel", stamp)
        _require_finite("command", np.array([*twist]))
        self._write("/cmd_vel", time, ros.command_message(time, twist))

    def plan(self, stamp: float, path: ArrayLike) -> None:
        """/plan: a path (N, 2) [m] in odom."""
        plan = Plan(stamp, np.asarray(path, float))
        _require_thoughts([plan], [])
        time = self._time("/plan", stamp)
        self._write("/plan", time, ros.plan_message(time, plan.path))

    def intention(self, stamp: float, goal: ArrayLike, likelihood: float) -> None:
        """/intention: where the driver is believed to want to go, (2,) [m] in odom, and its likelihood."""
        time = self._time("/intention", stamp)
        point = np.asarray(goal, float)
        if point.shape != (2,):
            raise ValueError(f"goal has shape {point.shape}, must be (2,)")
        _require_finite("intention", np.array([*point, likelihood]))
        self._write("/intention", time, ros.intention_message(time, point, float(likelihood)))

    def close(self) -> None:
        """Writes the summary and closes the file; a second call does nothing."""
        if not self._file.closed:
            try:
                self._mcap.finish()
            finally:
                self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def _text(*numbers: float) -> str:
    return " ".join(map(repr, map(float, numbers)))
