"""Two public data sets of one person who hands something to another: the giver is the partner, the taker the robot."""

from __future__ import annotations

import os
import tokenize
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.errors import DataError

Array = NDArray[np.float64]
Joints = Literal["hands", "skeleton"]

KTH_FAULTS = frozenset(
    {"test_052", "test_055", "test_057", "test_059", "test_060", "test_061", "train_001", "train_023", "train_043"}
)
"""Recordings in which the tracking of a body fails (jumps, swapped or frozen bodies)."""
_KTH_PERIOD = 1 / 120
_DYNAMIC_PERIOD = 1 / 30
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_JOINTS = {
    0: "pelvis", 1: "navel", 2: "chest", 3: "neck", 4: "left_clavicle", 5: "left_shoulder", 6: "left_elbow",
    7: "left_wrist", 8: "left_hand", 11: "right_clavicle", 12: "right_shoulder", 13: "right_elbow", 14: "right_wrist",
    15: "right_hand", 26: "head",
}  # fmt: skip
"""ZED's BODY_34"""


def read_kth_handovers(path: str | os.PathLike[str], with_faults: bool = False) -> list[InteractionRecording]:
    """The recordings of kth_handover_6d.npz in the order of their names: poses of the giver's baton and the taker's
    hand [m, unit quaternion xyzw] at 120 Hz, in the frame of the motion capture.

    Quaternions are continuous in sign and begin with qw >= 0 (ERRATA 44). KTH_FAULTS are left out unless asked for.
    DataError naming file and recording for anything else.
    """
    names = [f"{body}.{axis}" for body in ("baton", "hand") for axis in _POSE]
    return _read(Path(path), lambda held: [_kth(k, held[k], names) for k in sorted(held) if _kept(k, with_faults)])


def _kept(name: str, with_faults: bool) -> bool:
    return with_faults or name not in KTH_FAULTS


def _kth(name: str, values: NDArray[Any], names: list[str]) -> InteractionRecording:
    if values.ndim != 2 or values.shape[1] != 14 or not np.isfinite(values).all():
        raise ValueError(f"{name} has shape {values.shape}, must be (T, 14) and finite")
    both: Array = values.astype(np.float64)
    for quaternion in (slice(3, 7), slice(10, 14)):
        both[:, quaternion] = _continuous(both[:, quaternion])
    stamp = _KTH_PERIOD * np.arange(len(both), dtype=np.float64)
    notes = {"source": "KTH-RPL/handovers_dataset", "tracking_fault": str(name in KTH_FAULTS).lower()}
    columns = (tuple(names[:7]), tuple(names[7:]))
    return InteractionRecording(stamp, both[:, :7], both[:, 7:], *columns, metadata=notes, name=name, frame="mocap")


def _continuous(quaternions: Array) -> Array:
    """(T, 4) of unit length, none far from the one before; the first with w >= 0."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if not (np.abs(lengths - 1) < 0.01).all():
        raise ValueError(f"a quaternion has the length {lengths[np.argmax(np.abs(lengths - 1)), 0]:.3g}, must be 1")
    flips = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    first = -1.0 if quaternions[0, 3] < 0 else 1.0
    signs: Array = np.cumprod([first, *flips])
    continuous: Array = quaternions / lengths * signs[:, None]
    return continuous


def read_dynamic_handovers(
    path: str | os.PathLike[str], partner: Joints = "hands", robot: Joints = "hands", with_object: bool = False
) -> list[InteractionRecording]:
    """The recordings of dynamic_handover_120.npz: joints of two upper bodies [m] at 30 Hz, in the camera's frame.

    "hands" takes the two hands (6 columns), "skeleton" all 15 joints (45). with_object: the handed object's position
    [m] as three more columns of the partner. Positions were stored in half precision: about 1 mm. DataError naming the
    file for anything else; ValueError for other words.
    """
    for what, word in (("partner", partner), ("robot", robot)):
        if word not in ("hands", "skeleton"):
            raise ValueError(f"{what} must be hands or skeleton, got {word!r}")
    return _read(Path(path), lambda held: _dynamic(held, partner, robot, with_object))


def _dynamic(held: dict[str, NDArray[Any]], partner: Joints, robot: Joints, with_object: bool) -> list[Any]:
    missing = {"names", "lengths", "joints", "giver", "receiver", "object_pos"} - set(held)
    if missing:
        raise ValueError(f"has no {sorted(missing)[0]}")
    lengths, joints = held["lengths"].astype(int), [int(j) for j in held["joints"]]
    total, unknown = int(lengths.sum()), [j for j in joints if j not in _JOINTS]
    if unknown or (lengths < 2).any() or len(held["names"]) != len(lengths):
        raise ValueError(f"joints are {joints}, lengths {lengths.min()} or more for {len(held['names'])} names")
    bodies = (total, len(joints), 3)
    for key, shape in (("giver", bodies), ("receiver", bodies), ("object_pos", (total, 3))):
        if held[key].shape != shape:
            raise ValueError(f"{key} has shape {held[key].shape}, must be {shape} by the lengths")
    giver, giver_names = _points(held["giver"], joints, partner)
    taker, taker_names = _points(held["receiver"], joints, robot)
    if with_object:
        giver = np.hstack([giver, held["object_pos"].astype(np.float64)])
        giver_names += tuple(f"object.{axis}" for axis in "xyz")
    cuts, made = np.concatenate([[0], np.cumsum(lengths)]), []
    for k, name in enumerate(held["names"]):
        rows = slice(cuts[k], cuts[k + 1])
        notes = {"source": "hyeonseong-kim98/dynamic_handover_dataset"}
        stamp, columns = _DYNAMIC_PERIOD * np.arange(lengths[k], dtype=np.float64), (giver_names, taker_names)
        one = InteractionRecording(
            stamp, giver[rows], taker[rows], *columns, metadata=notes, name=str(name), frame="camera"
        )
        made.append(one)
    return made


def _points(values: NDArray[Any], joints: list[int], which: Joints) -> tuple[Array, tuple[str, ...]]:
    kept = [k for k, j in enumerate(joints) if which == "skeleton" or _JOINTS[j] in ("left_hand", "right_hand")]
    names = tuple(f"{_JOINTS[joints[k]]}.{axis}" for k in kept for axis in "xyz")
    return values[:, kept].astype(np.float64).reshape(len(values), -1), names


def _read(
    path: Path, make: Callable[[dict[str, NDArray[Any]]], list[InteractionRecording]]
) -> list[InteractionRecording]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return make({key: archive[key] for key in archive.files})
    except _BROKEN as broken:
        raise DataError(f"{path}: is no such recording of handovers: {broken}") from broken


_BROKEN = (
    ValueError, TypeError, KeyError, AttributeError, SyntaxError, OverflowError, MemoryError, EOFError, RuntimeError,
    zlib.error, zipfile.BadZipFile, tokenize.TokenError,
)  # fmt: skip
"""What NumPy and zipfile raise for files that nobody meant."""
