"""What is judged of the public sets of handovers: recordings, and which columns are seen and predicted."""

from __future__ import annotations

import tokenize
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.handovers import KTH_FAULTS, read_dynamic_handovers, read_kth_handovers
from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.errors import DataError

Indices = NDArray[np.int_]
HANDS = ("baton", "hand", "left_hand", "right_hand")


@dataclass(frozen=True, eq=False)
class HandoverTask:
    """One set of handovers, and what is seen and predicted of them."""

    name: str
    description: str
    recordings: tuple[InteractionRecording, ...]

    def __post_init__(self) -> None:
        if len(self.recordings) < 10:
            raise ValueError(f"{self.name} has {len(self.recordings)} handovers, must have at least 10 to be split")


def handover_tasks(paths: Sequence[Path]) -> tuple[HandoverTask, ...]:
    """What is judged of these files, whose contents say which set they are: of kth_handover_6d positions and poses
    without tracking faults and positions with them, of dynamic_handover_120 the giver's hands and her 15 joints.
    DataError naming the file for any other."""
    return tuple(task for path in paths for task in _TASKS[_set_of(path)](path))


def _set_of(path: Path) -> str:
    try:
        with np.load(path, allow_pickle=False) as archive:
            names = set(archive.files)
    except (
        ValueError,
        TypeError,
        EOFError,
        zipfile.BadZipFile,
        AttributeError,
        tokenize.TokenError,
        SyntaxError,
    ) as broken:
        raise DataError(f"{path}: is no .npz file of handovers: {broken}") from broken
    if {"giver", "receiver", "lengths"} <= names:
        return "dynamic"
    if names and all(name.startswith(("train_", "test_")) for name in names):
        return "kth"
    raise DataError(f"{path}: is neither kth_handover_6d nor dynamic_handover_120: it holds {sorted(names)[:5]}")


def _kth_tasks(path: Path) -> list[HandoverTask]:
    everything = [every_nth(one, 4) for one in read_kth_handovers(path, with_faults=True)]
    sound = [one for one in everything if one.name not in KTH_FAULTS]
    return [
        HandoverTask("KTH, positions", "baton and hand, positions alone", tuple(positions_of(one) for one in sound)),
        HandoverTask("KTH, poses", "baton and hand with their orientations", tuple(sound)),
        HandoverTask(
            "KTH, positions, with faults",
            f"as the first, with {len(everything) - len(sound)} recordings whose tracking failed",
            tuple(positions_of(one) for one in everything),
        ),
    ]


def _dynamic_tasks(path: Path) -> list[HandoverTask]:
    hands, skeleton = read_dynamic_handovers(path), read_dynamic_handovers(path, partner="skeleton")
    return [
        HandoverTask("Dynamic, hands", "the giver's two hands; the taker's two hands", tuple(hands)),
        HandoverTask("Dynamic, skeleton", "the giver's 15 joints; the taker's two hands", tuple(skeleton)),
    ]


_TASKS: dict[str, Callable[[Path], list[HandoverTask]]] = {"kth": _kth_tasks, "dynamic": _dynamic_tasks}


def every_nth(one: InteractionRecording, n: int) -> InteractionRecording:
    """Every n-th sample."""
    return replace(one, stamp=one.stamp[::n], partner=one.partner[::n], robot=one.robot[::n])


def positions_of(one: InteractionRecording) -> InteractionRecording:
    """Without the columns of orientations."""
    partner, robot = position_columns(one.partner_names), position_columns(one.robot_names)
    return replace(
        one,
        partner=one.partner[:, partner],
        robot=one.robot[:, robot],
        partner_names=tuple(one.partner_names[k] for k in partner),
        robot_names=tuple(one.robot_names[k] for k in robot),
    )


def position_columns(names: Sequence[str]) -> list[int]:
    """Where x, y and z of anything are among the columns."""
    return [k for k, name in enumerate(names) if name.rpartition(".")[2] in ("x", "y", "z")]


def hand_columns(names: Sequence[str]) -> Indices:
    """(hands, 3) where the hands' x, y and z are among the columns."""
    return np.array(
        [[names.index(f"{hand}.{axis}") for axis in "xyz"] for hand in HANDS if f"{hand}.x" in names]
    ).reshape(-1, 3)
