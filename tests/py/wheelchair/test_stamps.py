"""Whatever the stamps do, no assistant moves on what is older than stated.

A schedule is one drive of 20 ticks on a virtual clock: streams that fall silent, jitter, repeat a stamp, come from the
future or have none, ticks that come late or at the same time, clocks that are set back. LFDCORE_STAMP_SCHEDULES says
how many are run through each assistant.
"""

import math
import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from lfdcore import models
from lfdcore.geometry import Twist2
from lfdcore.grid import LaserScan
from lfdcore.wheelchair.adaptive_assistant import AdaptiveAssistant
from lfdcore.wheelchair.assistants import (
    Assistant,
    DriveAssistant,
    DynamicWindowAssistant,
    SeeingAssistant,
    Supervised,
    Unassisted,
)
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation
from lfdcore.wheelchair.two_way_assistant import TwoWayAssistant
from lfdcore.wheelchair.watch import FAR_AHEAD, WatchConfig
from observed import observed

FEW, TICKS = 100, 20
SCHEDULES = int(os.environ.get("LFDCORE_STAMP_SCHEDULES", FEW))
CHAIR, CONFIG = ChairGeometry.thesis(), WatchConfig()
STREAMS = ("scan_stamp", "odometry_stamp", "joystick_stamp")
OLDEST = {
    "scan_stamp": max(CONFIG.stale_after, CONFIG.stale_periods * CHAIR.scan_period),
    "odometry_stamp": CONFIG.stale_after,
    "joystick_stamp": CONFIG.silent_after,
}
"""[s] as docs/safety.md states it"""
SCAN = LaserScan(np.full(19, 6.0, np.float32), -np.pi / 2, np.pi / 18, 0.05, 30.0)
"""A wall all around, far away"""
INTERVALS = np.array([0.1, 0.08, 0.12, 0.05, 0.2, 0.3, 0.5, 0.0, -1e-9, -2.0])
"""[s] between ticks; the last three are a clock's that stands still or is set back"""
DELAYS = np.array([0.0, 0.03, 0.1, 0.19, 0.21, 0.26, 0.6, -0.04, -0.3])
"""[s] of a stream; negative: from the future"""


class Blunt(SeeingAssistant):
    """Gives what the stick asks for, without map and supervisor: only the watch stands between."""

    name = "blunt"

    def __init__(self, watch: WatchConfig | None = None) -> None:
        super().__init__(CHAIR, supervisor=None, watch=watch)

    def _drive(self, observation: Observation) -> Assistance:
        return Assistance(self._watch.limited(Twist2(*observation.joystick), observation.stamp), "user")

    def _decide(self, observation: Observation, obstacles: Any) -> Assistance:
        raise NotImplementedError


ASSISTANTS: dict[str, Callable[[], Assistant]] = {
    "blunt": Blunt,
    "none": lambda: Unassisted(CHAIR),
    "supervisor": lambda: Supervised(CHAIR),
    "dwa": lambda: DynamicWindowAssistant(CHAIR),
    "primitives": lambda: DriveAssistant(load_model(models.PRIMITIVES).planner(CHAIR)),
    "heatmaps": lambda: DriveAssistant(load_model(models.HEATMAPS).planner(CHAIR)),
    "adaptive": lambda: AdaptiveAssistant(load_model(models.HEATMAPS), CHAIR),  # type: ignore[arg-type]
    "two_way": lambda: TwoWayAssistant(load_model(models.HEATMAPS), CHAIR),
}


def schedule(seed: int) -> Iterator[Observation]:
    """One drive of TICKS ticks. In half of them no clock is set back, in half every stream speaks mostly."""
    random = np.random.default_rng(seed)
    backwards, silence = random.choice([0.0, 0.1]), random.choice([0.05, 0.4])
    usual = np.where(INTERVALS > 0, [0.5, *[0.1] * (len(INTERVALS) - 1)], 0)
    p = (1 - backwards) * usual / usual.sum() + backwards * (INTERVALS <= 0) / 3
    now = np.cumsum(random.choice(INTERVALS, TICKS, p=p))
    speaks = random.random((TICKS, 3)) >= silence
    said = now[:, None] - np.where(random.random((TICKS, 3)) < 0.8, 0.0, random.choice(DELAYS, (TICKS, 3)))
    odd = random.random((TICKS, 3))
    steady = random.random((TICKS, 3)) >= backwards
    ahead = random.random(TICKS) < 0.7
    newest = np.zeros(3)
    for k in range(TICKS):
        heard = np.where(steady[k], np.maximum(said[k], newest), said[k])  # a stamp that would go back is repeated
        newest = np.where(speaks[k], heard, newest)
        stamps = newest.tolist()
        for n, chance in enumerate(odd[k]):
            if chance < 0.01:
                stamps[n] = None if chance < 0.005 else math.nan
        stick = (1.0, 0.0) if ahead[k] else (0.0, 0.0)
        yield observed(float(now[k]), SCAN, stick, **dict(zip(STREAMS, stamps, strict=True)))


def is_older_than_stated(seen: Observation, stream: str) -> bool:
    stamp = getattr(seen, stream)
    return stamp is None or not (stamp <= seen.stamp + FAR_AHEAD and seen.stamp - stamp <= OLDEST[stream])


def run_schedules(assistant: Assistant, streams: tuple[str, ...] = STREAMS) -> tuple[int, list[str]]:
    """-> on how many ticks it moved, and for each of these the streams that were older than stated"""
    moved, older = 0, []
    for seed in range(SCHEDULES):
        assistant.reset()
        for seen in schedule(seed):
            if any(assistant.update(seen).command):
                moved += 1
                older += [f"schedule {seed}: {name}" for name in streams if is_older_than_stated(seen, name)]
    return moved, older


@pytest.mark.hazard(
    "Streams stop, repeat, jitter, go back",
    "no command but 0 on anything older than stated, and no exception",
    each=f"{FEW} schedules of {TICKS} ticks, LFDCORE_STAMP_SCHEDULES",
)
@pytest.mark.parametrize("name", ASSISTANTS)
def test_whatever_the_stamps_do_nothing_moves_that_is_older_than_stated(name: str) -> None:
    """Unassisted needs the stick alone."""
    moved, older = run_schedules(ASSISTANTS[name](), ("joystick_stamp",) if name == "none" else STREAMS)
    print(f"{name}: {SCHEDULES} schedules of {TICKS} ticks, moved on {moved}, on {len(older)} by what was older")
    assert not older
    assert moved > SCHEDULES


@pytest.mark.parametrize(
    ("careless", "stream"),
    [
        (WatchConfig(silent_after=0.28), "joystick_stamp"),
        (WatchConfig(stale_after=0.23), "odometry_stamp"),
        (WatchConfig(stale_periods=2.8), "scan_stamp"),
    ],
)
def test_the_schedules_find_a_watch_that_is_a_little_careless(careless: WatchConfig, stream: str) -> None:
    _, older = run_schedules(Blunt(careless))
    assert older
    assert all(stream in one for one in older)
