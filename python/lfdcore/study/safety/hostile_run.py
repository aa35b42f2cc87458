"""One hostile run: a stick at a chair in a course for some minutes; what it touched, and where it stood still."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.whole_file import whole_file
from lfdcore.geometry import Pose2
from lfdcore.grid import LaserScan, read_beams
from lfdcore.simulated.chair import SimulatedChair
from lfdcore.simulated.courses import Course, course_by_name
from lfdcore.simulated.courses.routes import clearance_field
from lfdcore.simulated.drivers import StickHolder
from lfdcore.simulated.hostile_drivers import AdversarialStick, HeldStick, RandomStick
from lfdcore.simulated.people import People
from lfdcore.simulated.unsteady_clock import UnsteadyClock
from lfdcore.simulation import DrivingWorld
from lfdcore.study.arms import METHODS, StudyModels, make_assistant
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.study.safety.standing import STANDS_BELOW, Standing
from lfdcore.wheelchair.drive_loop import Tick, drive
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.watch import HALTS

STICKS = ("random", "adversarial", "held")
BESIDE = 0.3
"""[m] A held stick begins where something is this near."""


@dataclass(frozen=True, kw_only=True)
class HostileCounts:
    """What one run came to."""

    distance: float
    """[m] that the axle went"""
    lasted: float
    """[s]"""
    collisions: int
    """contacts with what stands, where a scan had shown it. A contact ends the run: where wheels turn against
    something, odometry and map are wrong from there on."""
    unseen_collisions: int
    """the same, where no scan had shown it: the chair creeps into such space"""
    contact_speed: float
    """of the axle [m/s] at the tick before the contact; 0 without one"""
    nose_met_seen: int
    """contacts in which the moving nose met a person whom the scan had shown for a second"""
    people_met: int
    moving: float
    """share of the ticks in which the chair moved"""
    halted: float
    """share of the ticks in a mode in which it stops"""
    stood: int
    """times that it stood though a free motion was asked for (Standing)"""


@dataclass(frozen=True, kw_only=True)
class HostileRun:
    """A job of the study. Its counts are kept in a file of `folder`, and read from there a second time."""

    arm: str
    condition: str
    stick: str
    course: str
    seed: int
    seconds: float
    models: StudyModels
    folder: Path

    def about(self) -> dict[str, str | int | float]:
        """What tells runs apart."""
        names = ("arm", "condition", "stick", "course", "seed", "seconds")
        return {name: getattr(self, name) for name in names}

    def run(self) -> HostileCounts:
        """-> the counts, driven unless they are kept already"""
        kept = self._kept()
        if kept is not None:
            return kept
        counts = self._drive()
        with whole_file(self._file(), "counts") as path:
            path.write_text(json.dumps({**self._key(), **asdict(counts)}, indent=1) + "\n")
        return counts

    def _file(self) -> Path:
        words = "-".join(str(value) for value in self.about().values())
        return self.folder / f"run-{''.join(c if c.isalnum() else '-' for c in words)}.json"

    def _kept(self) -> HostileCounts | None:
        """None also for what is broken, and for what another version of the study or another model counted."""
        if not self._file().exists():
            return None
        try:
            said = json.loads(self._file().read_text())
            counts = HostileCounts(**{name: said[name] for name in HostileCounts.__dataclass_fields__})
            sound = all(0 <= value < math.inf for value in asdict(counts).values()) and counts.lasted > 0
            return counts if sound and self._key().items() <= said.items() else None
        except (ValueError, TypeError, KeyError, AttributeError):
            return None

    def _key(self) -> dict[str, str | int | float]:
        """What the counts are of."""
        model = self.models.file(METHODS[self.arm]) if self.arm in METHODS else None
        digest = "" if model is None else hashlib.sha256(model.read_bytes()).hexdigest()
        return {**self.about(), "model": digest}

    def _drive(self) -> HostileCounts:
        condition = CONDITIONS[self.condition]
        run = condition.run
        course = course_by_name(self.course, 1)
        start = somewhere(course, self.seed, BESIDE if self.stick == "held" else math.inf)
        course = replace(course, start=start)
        people = None if run.people is None else People(course.grid, run.people, (start.x, start.y), self.seed)
        stick = hostile(self.stick, course, self.seed)
        chair = SimulatedChair(course, stick, self.seed, run.chair, run.lidar, people, run.scanner, run.period)
        count = RunCount(chair, Standing(course.grid, run), self.seconds)
        clock = UnsteadyClock(condition.ticks, self.seed)
        drive(chair, make_assistant(self.arm, self.models, run), count, clock=clock)
        return count.result()


class ShownCells:
    """Where scans have shown something in the map: cells of .01 m."""

    SIDE = 0.01

    def __init__(self, chair: ChairGeometry) -> None:
        self._chair = chair
        self._cells: set[tuple[int, int]] = set()

    def add(self, pose: Pose2, scan: LaserScan) -> None:
        """A scan of a chair at `pose`, T_map_base. What it hits inside the outline is the driver's, not the map's."""
        lengths, hit = read_beams(scan)
        angles = scan.angles()[hit]
        ends = self._chair.T_base_laser.transform(lengths[hit, None] * np.stack([np.cos(angles), np.sin(angles)], 1))
        ends = pose.transform(ends[~self._inside(ends)])
        self._cells.update(map(tuple, np.floor(ends / self.SIDE).astype(int).tolist()))

    def _inside(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) whether points (N, 2) [m, base_link] lie inside the outline"""
        body, (x, y) = self._chair.footprint, points.T
        return np.asarray((x < body.front) & (x > -body.rear) & (np.abs(y) < body.half_width))

    def near(self, pose: Pose2, cell: NDArray[np.float64]) -> bool:
        """Whether anything was shown within .02 to .03 m of where a chair at `pose` [map] touches a solid cell around
        `cell` (2,) [m, map]: of its outline, what is nearest."""
        body = self._chair.footprint
        x, y = pose.inverse().transform(cell[None])[0]
        touched = (np.clip(x, -body.rear, body.front), np.clip(y, -body.half_width, body.half_width))
        ix, iy = np.floor(pose.transform(np.array([touched]))[0] / self.SIDE).astype(int).tolist()
        return any((ix + dx, iy + dy) in self._cells for dx in range(-2, 3) for dy in range(-2, 3))


class RunCount:
    """Of the ticks of a run; called with each, it says whether that was the last."""

    def __init__(self, chair: SimulatedChair, standing: Standing, seconds: float) -> None:
        self._chair, self._standing, self._seconds = chair, standing, seconds
        self._ticks = self._moving = self._halted = 0
        self._collisions = self._unseen_collisions = 0
        self._speed = self._contact_speed = 0.0
        self._shown = ShownCells(chair.geometry)
        self._distance = self._stamp = 0.0

    def __call__(self, tick: Tick) -> bool:
        truth, twist = self._chair.truth, self._chair.truth.state.twist
        self._chair.show(tick.assistance.mode, tick.stamp)
        self._ticks += 1
        if truth.collision:
            shown = self._shown.near(truth.state.pose, truth.state.contact_point)
            self._collisions, self._unseen_collisions = int(shown), int(not shown)
            self._contact_speed = self._speed
        self._speed = abs(twist.linear)
        if tick.observation.scan_stamp == tick.stamp:
            self._shown.add(truth.state.pose, tick.observation.scan)
        self._standing.add(tick, truth)
        self._moving += math.hypot(twist.linear, twist.angular) > STANDS_BELOW
        self._halted += tick.assistance.mode in HALTS
        self._distance, self._stamp = truth.state.distance, tick.stamp
        return truth.collision or tick.stamp >= self._seconds

    def result(self) -> HostileCounts:
        met = self._chair.people_met()
        return HostileCounts(
            distance=self._distance,
            lasted=self._stamp,
            collisions=self._collisions,
            unseen_collisions=self._unseen_collisions,
            contact_speed=self._contact_speed,
            nose_met_seen=sum(one.foreseeable for one in met),
            people_met=len(met),
            moving=self._moving / self._ticks,
            halted=self._halted / self._ticks,
            stood=self._standing.times,
        )


def hostile(stick: str, course: Course, seed: int) -> StickHolder:
    """Who sits there. A held stick is drawn from `seed`, half of them ahead."""
    if stick == "random":
        return RandomStick()
    if stick == "adversarial":
        return AdversarialStick(course)
    forward, left = np.random.default_rng([seed, 0x4E]).uniform(-1, 1, 2)
    return HeldStick((float(abs(forward) if seed % 2 else forward), float(left)))


def somewhere(course: Course, seed: int, beside: float = math.inf) -> Pose2:
    """A pose [map] drawn from `seed` at which the chair touches nothing, with something within `beside` [m] of its
    outline."""
    random = np.random.default_rng([seed, 0x51])
    world = DrivingWorld(course.grid)
    roomy = np.argwhere(clearance_field(course.grid) > 0.4)
    while True:
        iy, ix = roomy[random.integers(len(roomy))]
        x, y = np.array(course.grid.origin) + (np.array([ix, iy]) + random.random(2)) * course.grid.resolution
        pose = Pose2(float(x), float(y), float(random.uniform(-math.pi, math.pi)))
        if not world.touches(pose, 0.05) and (math.isinf(beside) or world.touches(pose, beside)):
            return pose
