"""One recorded collaboration: what the partner did, what the robot did, and what stood between them (Ch. 5).

Files are `.npz` (a zip of arrays, no pickle) with the members stamp, partner, robot and header (JSON as bytes).
"""

from __future__ import annotations

import dataclasses
import io
import json
import math
import os
import tokenize
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from reprlib import Repr
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.strict_json import parse_json
from lfdcore.datasets.whole_file import whole_file
from lfdcore.errors import DataError

Array = NDArray[np.float64]

VERSION = 1
LARGEST = 2**28
"""[bytes] of all arrays of one file together; a file that claims more is refused before it is unpacked"""
LONGEST_GAP = 0.6
"""[s] without a partner's column that `resample` bridges by a straight line, unless another is given"""
FARTHEST = 1e6
"""of any value of a recording, in its own unit"""
_FORMAT = "lfdcore interaction"
_ARRAYS = ("stamp", "partner", "robot")
_MEMBERS = (*_ARRAYS, "header")
_SHORT = Repr()
_SHORT.maxlevel = 2


@dataclass(frozen=True, eq=False)
class InteractionRecording:
    """T samples of a partner and a robot, and the environment they worked in.

    partner may hold NaN: the tracking lost that column then. robot has no columns where only the partner was observed.
    ValueError naming value and bound for stamps that do not increase, lengths that differ, columns without a name of
    their own, NaN elsewhere than in partner, values beyond 1e6, an environment that is not finite.
    """

    stamp: Array
    """(T,) [s] increasing, T >= 1"""
    partner: Array
    """(T, n) [m, or the unit of the column]; NaN = not seen"""
    robot: Array
    """(T, r)"""
    partner_names: tuple[str, ...]
    """(n,) columns, such as left_hand.x"""
    robot_names: tuple[str, ...] = ()
    """(r,) columns, such as left_gripper.qx"""
    environment: dict[str, float] = field(default_factory=dict)
    """name -> value, SI"""
    metadata: dict[str, str] = field(default_factory=dict)
    name: str = ""
    frame: str = "base"
    """in which all positions are given"""

    def __post_init__(self) -> None:
        for key in _ARRAYS:
            object.__setattr__(self, key, np.ascontiguousarray(getattr(self, key), dtype=np.float64))
        for key in ("partner_names", "robot_names"):
            object.__setattr__(self, key, tuple(getattr(self, key)))
        _require_stamps(self.stamp)
        _require_columns("partner", self.partner, self.partner_names, len(self.stamp))
        _require_columns("robot", self.robot, self.robot_names, len(self.stamp))
        _require_values("partner", self.partner[~np.isnan(self.partner)])
        _require_values("robot", self.robot)
        object.__setattr__(self, "environment", require_environment(self.environment))
        _require_texts(self)

    def __len__(self) -> int:
        return len(self.stamp)

    @property
    def duration(self) -> float:
        """[s] from the first to the last sample."""
        return float(self.stamp[-1] - self.stamp[0])

    def partial(self, *, seconds: float | None = None, share: float | None = None) -> InteractionRecording:
        """What was seen of the partner up to `seconds` [s] or up to a `share` (0 to 1) of the duration, at least the
        first sample; without the robot. ValueError unless exactly one is given, finite and >= 0 (share <= 1)."""
        if (seconds is None) == (share is None):
            raise ValueError(f"exactly one of seconds and share must be given, got {seconds} and {share}")
        if share is not None and not 0 <= share <= 1:
            raise ValueError(f"share must be in [0, 1], got {share}")
        until = self.duration * share if share is not None else seconds
        if until is None or not (math.isfinite(until) and until >= 0):
            raise ValueError(f"seconds must be finite and >= 0 s, got {seconds} s")
        return self.first(max(1, int(np.searchsorted(self.stamp - self.stamp[0], until * (1 + 1e-12), side="right"))))

    def first(self, samples: int) -> InteractionRecording:
        """The partner's first `samples` samples without the robot; ValueError unless 1 <= samples <= T."""
        if not 1 <= samples <= len(self):
            raise ValueError(f"samples must be in [1, {len(self)}], got {samples}")
        nothing = np.zeros((samples, 0))
        cut: dict[str, Any] = {"stamp": self.stamp[:samples], "partner": self.partner[:samples]}
        return dataclasses.replace(self, **cut, robot=nothing, robot_names=())

    def seeing(self, names: Sequence[str]) -> InteractionRecording:
        """The same with only these columns of the partner seen, the others NaN throughout. ValueError for a name that
        is none of its columns."""
        unknown = [name for name in names if name not in self.partner_names]
        if unknown:
            raise ValueError(f"column is {unknown[0]!r}, must be one of {', '.join(self.partner_names)}")
        hidden = [name not in names for name in self.partner_names]
        return dataclasses.replace(self, partner=np.where(hidden, np.nan, self.partner))

    def resample(self, steps: int, longest_gap: float = LONGEST_GAP) -> InteractionRecording:
        """T = `steps` samples evenly spaced in time from the first stamp to the last, by straight lines.

        Where the partner was lost for at most `longest_gap` [s], a straight line bridges the gap, and the nearest value
        stands in before the first and after the last sight. A column that was never seen stays NaN. ValueError naming
        column, place and length for a longer gap, for steps < 2, for fewer than 2 samples.
        """
        if steps < 2 or len(self) < 2:
            who = self.name or "recording"
            raise ValueError(f"{who}: resampling needs at least 2 samples and 2 steps, got {len(self)} and {steps}")
        if not longest_gap >= 0:
            raise ValueError(f"longest_gap must be >= 0 s, got {longest_gap} s")
        at = np.linspace(self.stamp[0], self.stamp[-1], steps)
        partner = [self._filled(k, at, longest_gap) for k in range(self.partner.shape[1])]
        robot = [np.interp(at, self.stamp, column) for column in self.robot.T]
        arrays = {"partner": _columns(partner, steps), "robot": _columns(robot, steps)}
        return dataclasses.replace(self, stamp=at, **arrays)  # type: ignore[arg-type]

    def _filled(self, column: int, at: Array, longest_gap: float) -> Array:
        seen = ~np.isnan(self.partner[:, column])
        if not seen.any():
            return np.full(len(at), np.nan)
        begin, length = _widest_gap(self.stamp, seen)
        if length > longest_gap * (1 + 1e-12):
            raise ValueError(
                f"{self.name or 'recording'}: {self.partner_names[column]} was not seen for {length:.3g} s from "
                f"{begin:.3f} s on, must be <= {longest_gap:g} s to be bridged"
            )
        filled: Array = np.interp(at, self.stamp[seen], self.partner[seen, column])
        return filled

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes what `load_interaction` reads, replacing the file in one step; the same recording, the same bytes.

        ValueError for a suffix other than .npz or for a path that is no regular file.
        """
        target = Path(path)
        if target.suffix != ".npz":
            raise ValueError(f"path is {target}, must end in .npz")
        with whole_file(target, "recording") as part:
            part.write_bytes(_packed(self))


def _columns(columns: list[Array], steps: int) -> Array:
    return np.stack(columns, axis=1) if columns else np.zeros((steps, 0))


def _widest_gap(stamp: Array, seen: NDArray[np.bool_]) -> tuple[float, float]:
    """Where the longest time without a sight begins [s] and its length [s]; one missing sample lasts from sight to
    sight. 0 where nothing is missing."""
    if seen.all():
        return float(stamp[0]), 0.0
    sights = np.concatenate([stamp[:1], stamp[seen], stamp[-1:]])
    lost = np.concatenate([[~seen[0]], np.diff(np.flatnonzero(seen)) > 1, [~seen[-1]]])
    length = np.where(lost, np.diff(sights), 0.0)
    worst = int(np.argmax(length))
    return float(sights[worst]), float(length[worst])


def _require_stamps(stamp: Array) -> None:
    if stamp.ndim != 1 or not len(stamp):
        raise ValueError(f"stamp has shape {stamp.shape}, must be (T,) with T >= 1")
    bad = np.flatnonzero(~np.isfinite(stamp))
    if len(bad):
        raise ValueError(f"stamp of sample {bad[0]} is {stamp[bad[0]]} s, must be finite")
    still = np.flatnonzero(np.diff(stamp) <= 0)
    if len(still):
        k = int(still[0])
        raise ValueError(f"stamps must increase: sample {k + 1} is at {stamp[k + 1]} s after {stamp[k]} s")


def _require_columns(what: str, values: Array, names: tuple[str, ...], samples: int) -> None:
    if values.ndim != 2 or values.shape[0] != samples:
        raise ValueError(f"{what} has shape {values.shape}, must be ({samples}, columns) as there are {samples} stamps")
    if len(names) != values.shape[1]:
        raise ValueError(f"{what} has {values.shape[1]} columns, but {len(names)} names")
    for name in names:
        if not (isinstance(name, str) and name.strip()) or names.count(name) > 1:
            raise ValueError(f"{what} has a column named {name!r}, must be a text that is not empty and its own")


def _require_values(what: str, values: Array) -> None:
    bad = values[~(np.abs(values) <= FARTHEST)]
    if bad.size:
        raise ValueError(f"{what} holds {bad.ravel()[0]}, must be finite and within {FARTHEST:g}")


def _require_texts(recording: InteractionRecording) -> None:
    for key, value in recording.metadata.items():
        if not (isinstance(key, str) and isinstance(value, str)):
            raise ValueError(f"metadata {key!r} is {_SHORT.repr(value)}, must be a text")
    for key, text in (("name", recording.name), ("frame", recording.frame)):
        if not isinstance(text, str):
            raise ValueError(f"{key} is {_SHORT.repr(text)}, must be a text")


def require_environment(values: Mapping[str, Any]) -> dict[str, float]:
    """A copy with every value a float; ValueError for what is no finite number within 1e6 or has no name."""
    if not isinstance(values, Mapping):
        raise ValueError(f"environment is {_SHORT.repr(values)}, must be names and numbers")
    for name, value in values.items():
        if not (isinstance(name, str) and name.strip()):
            raise ValueError(f"environment has the name {name!r}, must be a text that is not empty")
        if isinstance(value, bool) or not isinstance(value, int | float | np.floating | np.integer):
            raise ValueError(f"environment {name!r} is {_SHORT.repr(value)}, must be a number")
        size: Any = abs(value)
        if not size <= FARTHEST:
            raise ValueError(f"environment {name!r} is {_SHORT.repr(value)}, must be finite and within {FARTHEST:g}")
    return {name: float(value) for name, value in values.items()}


def environments(recordings: Sequence[InteractionRecording]) -> tuple[tuple[str, ...], Array]:
    """Names (E,) and values (S, E) of what all these recordings know of their environment, in the first one's order.

    ValueError naming the recording whose names differ, or for no recordings.
    """
    if not recordings:
        raise ValueError("there are no recordings")
    names = tuple(recordings[0].environment)
    for recording in recordings:
        if set(recording.environment) != set(names):
            raise ValueError(
                f"{recording.name or 'a recording'} has the environment {sorted(recording.environment)}, "
                f"must be {sorted(names)} as in the first"
            )
    return names, np.array([[r.environment[name] for name in names] for r in recordings]).reshape(len(recordings), -1)


# -- the file -------------------------------------------------------------------------------------------------------


def _packed(recording: InteractionRecording) -> bytes:
    header = {
        "format": _FORMAT,
        "version": VERSION,
        **{key: getattr(recording, key) for key in _HEADER},
    }
    text = json.dumps(header, allow_nan=False, ensure_ascii=False).encode()
    arrays = {**{key: getattr(recording, key) for key in _ARRAYS}, "header": np.frombuffer(text, np.uint8)}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for key, array in arrays.items():
            data = io.BytesIO()
            np.lib.format.write_array(data, array, version=(1, 0), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{key}.npy", (1980, 1, 1, 0, 0, 0)), data.getvalue())
    return out.getvalue()


_HEADER = ("partner_names", "robot_names", "environment", "metadata", "name", "frame")


def load_interaction(path: str | os.PathLike[str]) -> InteractionRecording:
    """Reads a recording. DataError naming the file for what is truncated, garbled, pickled, too large, of another
    version, has unknown or missing keys, or is refused by `InteractionRecording`; OSError if it cannot be opened."""
    path = Path(path)
    if path.exists() and not path.is_file():
        raise DataError(f"{path}: is no regular file, so no recording")
    with path.open("rb") as file:
        try:
            return _unpacked(file)
        except _BROKEN as broken:
            said = " ".join(str(broken).split()) or type(broken).__name__
            if isinstance(broken, zipfile.BadZipFile):
                said = f"is no recorded collaboration (.npz), or is cut: {said}"
            raise DataError(f"{path}: {said}") from broken


_BROKEN = (
    ValueError, TypeError, KeyError, SyntaxError, OverflowError, MemoryError, EOFError, RuntimeError, zlib.error,
    zipfile.BadZipFile, tokenize.TokenError,
)  # fmt: skip
"""What zipfile, NumPy's format and JSON raise for files that nobody meant."""


def _unpacked(file: Any) -> InteractionRecording:
    with zipfile.ZipFile(file) as archive:
        members = [info.filename.removesuffix(".npy") for info in archive.infolist()]
        if sorted(members) != sorted(_MEMBERS):
            raise ValueError(f"holds {_SHORT.repr(members)}, must hold {', '.join(_MEMBERS)}")
        claimed = sum(info.file_size for info in archive.infolist())
        if claimed > LARGEST:
            raise ValueError(f"unpacks to {claimed} bytes, must be <= {LARGEST}")
        said = _header(_member(archive, "header"))
        arrays: dict[str, Any] = {key: _member(archive, key) for key in _ARRAYS}
    return InteractionRecording(**arrays, **said)


def _member(archive: zipfile.ZipFile, key: str) -> NDArray[Any]:
    """One array whose claimed shape is exactly as long as its bytes: NumPy would allocate first and read then."""
    data = archive.read(f"{key}.npy")  # checks the CRC
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError(f"{key} is no array of NumPy's format 1.0")
    shape, fortran, dtype = np.lib.format.read_array_header_1_0(stream)
    wanted = np.dtype(np.uint8) if key == "header" else np.dtype("<f8")
    if dtype != wanted or fortran:
        raise ValueError(f"{key} is {_SHORT.repr(dtype)}{' by columns' * fortran}, must be {wanted} by rows")
    size, there = math.prod(shape) * wanted.itemsize, len(data) - stream.tell()
    if size != there or min(shape, default=0) < 0:
        raise ValueError(f"{key} claims the shape {shape}, which needs {size} bytes, but has {there}")
    return np.frombuffer(data, wanted, offset=stream.tell()).reshape(shape)


def _header(data: NDArray[Any]) -> dict[str, Any]:
    said = parse_json(data.tobytes().decode())
    if not isinstance(said, dict) or said.pop("format", None) != _FORMAT:
        raise ValueError("is no recording of lfdcore")
    version = said.pop("version", None)
    if version != VERSION:
        raise ValueError(f"has format version {_SHORT.repr(version)}, this lfdcore reads version {VERSION}")
    if sorted(said) != sorted(_HEADER):
        raise ValueError(f"header has the keys {_SHORT.repr(sorted(said))}, must be {', '.join(sorted(_HEADER))}")
    for key in ("partner_names", "robot_names"):
        if not isinstance(said[key], list):
            raise ValueError(f"{key} is {_SHORT.repr(said[key])}, must be a list of texts")
    if not isinstance(said["metadata"], dict):
        raise ValueError(f"metadata is {_SHORT.repr(said['metadata'])}, must be names and texts")
    return said
