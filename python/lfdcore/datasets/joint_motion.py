"""Joint trajectories in files: trajectory_msgs/JointTrajectory in MCAP, and CSV for everything else."""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lfdcore
from lfdcore.datasets import ros_messages as ros
from lfdcore.datasets.whole_file import whole_file
from lfdcore.errors import DataError

Array = NDArray[np.float64]
TOPIC = "/joint_trajectory"
_TYPE = "trajectory_msgs/msg/JointTrajectory"
_LONGEST = 2**31
"""[s] that a message's duration can hold"""


@dataclass(frozen=True, eq=False)
class JointMotion:
    """T samples of N joints. ValueError for other shapes, what is not finite, times that do not increase from >= 0 s,
    and names that are not each joint's own."""

    names: tuple[str, ...]
    """(N,)"""
    time: Array
    """(T,) [s] since the motion is begun, T >= 1"""
    positions: Array
    """(T, N) [rad or m]"""
    velocities: Array
    """(T, N) [rad/s or m/s]"""

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        for key in ("time", "positions", "velocities"):
            object.__setattr__(self, key, np.array(getattr(self, key), np.float64, order="C"))  # as CDR wants rows
        if not self.names or len(set(self.names)) < len(self.names) or not all(self.names):
            raise ValueError(f"joints are {', '.join(self.names) or 'none'}, each must have a name of its own")
        if self.time.ndim != 1 or not len(self.time):
            raise ValueError(f"time has shape {self.time.shape}, must be (T,), T >= 1")
        shape = (len(self.time), len(self.names))
        for key in ("positions", "velocities"):
            values = getattr(self, key)
            if values.shape != shape or not np.isfinite(values).all():
                raise ValueError(f"{key} have shape {values.shape}, must be {shape} and finite")
        if not (np.isfinite(self.time).all() and self.time[0] >= 0 and self.time[-1] < _LONGEST):
            raise ValueError(f"times are {self.time[0]} to {self.time[-1]} s, must be in [0, {_LONGEST}) s")
        if (np.diff(self.time) <= 0).any():
            k = int(np.argmin(np.diff(self.time)))
            raise ValueError(f"times must increase: sample {k + 1} is at {self.time[k + 1]} s after {self.time[k]} s")

    @property
    def duration(self) -> float:
        """[s] from the first sample to the last."""
        return float(self.time[-1] - self.time[0])

    def at(self, time: float) -> Array:
        """(N,) positions at a time [s], by cubic pieces through positions and velocities; held outside."""
        k = int(np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, max(len(self.time) - 2, 0)))
        if len(self.time) == 1 or time <= self.time[0]:
            return np.array(self.positions[0])
        if time >= self.time[-1]:
            return np.array(self.positions[-1])
        step = self.time[k + 1] - self.time[k]
        s = (time - self.time[k]) / step
        h = ((1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2 * step, s**2 * (3 - 2 * s), s**2 * (s - 1) * step)
        between = (self.positions[k], self.velocities[k], self.positions[k + 1], self.velocities[k + 1])
        return np.asarray(sum(weight * values for weight, values in zip(h, between, strict=True)))


def write_joint_motion(motion: JointMotion, path: str | os.PathLike[str]) -> None:
    """To .mcap (one trajectory_msgs/JointTrajectory on /joint_trajectory, CDR) or .csv; the same motion, the same
    bytes. ValueError for another suffix or a path that is no regular file."""
    target = Path(path)
    if target.suffix not in (".mcap", ".csv"):
        raise ValueError(f"path is {target}, must end in .mcap or .csv")
    with whole_file(target, "motion") as part:
        part.write_bytes(_mcap(motion) if target.suffix == ".mcap" else _csv(motion))


def read_joint_motion(path: str | os.PathLike[str]) -> JointMotion:
    """From .mcap. DataError for what holds no such message or a damaged one; OSError if it cannot be opened."""
    from mcap.reader import make_reader

    source = Path(path)
    if source.exists() and not source.is_file():
        raise DataError(f"{source}: is no regular file, so no joint trajectory")
    with source.open("rb") as file:
        try:
            found = next(make_reader(file, validate_crcs=True).iter_messages(topics=[TOPIC]), None)
            if found is None:
                raise ValueError(f"holds nothing on {TOPIC}")
            return _motion_of(ros.deserialize(found[2].data, _TYPE))
        except Exception as broken:  # mcap, rosbags and struct raise whatever garbled bytes lead them to
            raise DataError(f"{source}: {' '.join(str(broken).split()) or type(broken).__name__}") from broken


def _motion_of(message: Any) -> JointMotion:
    time = [point.time_from_start.sec + point.time_from_start.nanosec * 1e-9 for point in message.points]
    shape = (len(time), len(message.joint_names))
    rows = {key: [getattr(point, key) for point in message.points] for key in ("positions", "velocities")}
    if any(len(row) != shape[1] for each in rows.values() for row in each):
        raise ValueError(f"its points must have {shape[1]} positions and velocities each, as there are joints")
    return JointMotion(tuple(message.joint_names), np.array(time), *(np.array(r).reshape(shape) for r in rows.values()))


def _mcap(motion: JointMotion) -> bytes:
    from mcap.writer import CompressionType, Writer

    out = io.BytesIO()
    writer = Writer(out, compression=CompressionType.NONE)  # in a chunk, whose CRC readers check
    writer.start(profile="ros2", library=f"lfdcore {lfdcore.__version__}")
    schema = writer.register_schema(_TYPE, "ros2msg", ros.schema(_TYPE))
    channel = writer.register_channel(TOPIC, "cdr", schema)
    message = ros.joint_trajectory_message(motion.names, motion.time, motion.positions, motion.velocities)
    writer.add_message(channel, 0, ros.serialize(message, _TYPE), 0, 1)
    writer.finish()
    return out.getvalue()


def _csv(motion: JointMotion) -> bytes:
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(["time", *motion.names, *(f"{name}.velocity" for name in motion.names)])
    table.writerows(np.column_stack([motion.time, motion.positions, motion.velocities]).tolist())
    return out.getvalue().encode()
