"""Short tasks whose start is drawn from a seed: through a doorway and dock at a table; a narrow gap from the side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lfdcore.geometry import Footprint, Pose2
from lfdcore.simulated.courses.course import Course, FloatArray
from lfdcore.simulated.courses.drawing import Door, Drawing
from lfdcore.simulated.courses.ideal import FootprintOnGrid
from lfdcore.simulated.courses.routes import Point, RouteConfig, RoutePlanner

DOCKING_DISTANCE = 0.30
"""A chair is docked when its outline is this near [m] to the table (issue 2)."""


@dataclass(frozen=True, eq=False)
class Task:
    """A course with an end that counts as success.

    table: (x0, y0, x1, y1) [m] to dock at, or None; beyond_x: the line [m] that the whole chair must have passed, or
    None; time_limit [s].
    """

    course: Course
    seed: int
    time_limit: float
    table: tuple[float, float, float, float] | None = None
    beyond_x: float | None = None

    def reached(self, pose: Pose2, footprint: Footprint | None = None) -> bool:
        """Whether the chair at `pose` is where the task wants it. Success also needs a drive without contact."""
        body = footprint or Footprint()
        corners = pose.transform(body.corners())
        if self.beyond_x is not None and corners[:, 0].min() <= self.beyond_x:
            return False
        return self.table is None or distance_to_box(pose, body, self.table) <= DOCKING_DISTANCE


def distance_to_box(pose: Pose2, footprint: Footprint, box: tuple[float, float, float, float]) -> float:
    """Distance [m] between the chair's outline and an axis-aligned box (x0, y0, x1, y1); 0 if a corner is inside."""
    x0, y0, x1, y1 = box
    corners = pose.transform(footprint.corners())
    there = pose.inverse().transform(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
    outline = (-footprint.rear, -footprint.half_width, footprint.front, footprint.half_width)
    # two convex bodies that do not overlap are nearest at a corner of one of them
    return float(min(_to_box(corners, box).min(), _to_box(there, outline).min()))


def _to_box(points: FloatArray, box: tuple[float, float, float, float]) -> FloatArray:
    x0, y0, x1, y1 = box
    dx = np.maximum(np.maximum(x0 - points[:, 0], points[:, 0] - x1), 0.0)
    dy = np.maximum(np.maximum(y0 - points[:, 1], points[:, 1] - y1), 0.0)
    return np.asarray(np.hypot(dx, dy))


def doorway_and_docking(seed: int) -> Task:
    """Through a 1.00 m doorway, then nose on at a table in the next room (cf. Fig. 3.13).

    The start pose and the table's place along the wall are drawn from the seed. Reached: outline within .3 m of the
    table. The route ends .15 m before it.
    """
    rng = np.random.default_rng([_DOCKING, _checked(seed)])
    table_y, start_x, start_y = rng.uniform(1.7, 2.3), rng.uniform(1.2, 2.0), rng.uniform(1.4, 4.6)
    d = Drawing(9.0, 6.0)
    d.wall(4.5, 0, 4.5, 6.0)
    door = d.door(4.5, 3.6, "x", 1.0)
    table_y = round(table_y / 0.05) * 0.05
    table = (8.0, table_y - 0.7, 8.9, table_y + 0.7)
    d.boxes(table, (0.1, 5.4, 1.6, 5.9), (5.4, 5.3, 7.0, 5.9), (0.1, 0.1, 0.7, 0.9))
    end = table[0] - Footprint().front - 0.15
    way: list[Point] = [(start_x, start_y), *door.waypoints(1), (end - 1.0, table_y), (end, table_y)]
    start = Pose2(start_x, start_y, float(rng.uniform(-0.6, 0.6)))
    berth = Door(end - 0.2, table_y, "x", 1.0)  # met straight on, as a door would be
    return Task(_task_course("doorway-docking", d, way, start, berth), seed, 120.0, table=table)


def narrow_gap(seed: int, width: float = 0.90, thickness: float = 0.10) -> Task:
    """A gap of `width` [m] in a wall of `thickness` [m], from 1.4-2.4 m away and turned by up to 60 degrees.

    Reached: the whole chair is behind the wall. Raises ValueError for a gap that the chair's .70 m do not fit, or that
    is not a multiple of .10 m.
    """
    if not Footprint().half_width * 2 < width <= 3.0:
        raise ValueError(f"width must be in (0.7, 3.0] m, got {width} m")
    if not 0.05 <= thickness <= 1.5:
        raise ValueError(f"thickness must be in [0.05, 1.5] m, got {thickness} m")
    rng = np.random.default_rng([_GAP, _checked(seed)])
    d = Drawing(9.0, 6.0)
    near, far = 4.5, 4.5 + thickness
    d.box(near, 0.0, far, 6.0)
    middle = 3.0
    gap = d.door(near + thickness / 2, middle, "x", width, depth=thickness)
    start = _beside_the_gap(d, rng, near, middle)
    behind: Point = (far + 2.0, middle)
    way: list[Point] = [(start.x, start.y), *gap.waypoints(1, 0.5 + thickness / 2), behind]
    narrow = RouteConfig(min_clearance=min(RouteConfig().min_clearance, width / 2 - d.resolution))
    return Task(_task_course(f"gap-{width:.2f}", d, way, start, config=narrow), seed, 90.0, beyond_x=far)


_DOCKING, _GAP = 0xD0C, 0x6A9
"""Streams of random numbers of the two tasks."""


def _beside_the_gap(d: Drawing, rng: np.random.Generator, near: float, middle: float) -> Pose2:
    """A free start pose, badly aligned with the gap."""
    body = FootprintOnGrid(d.grid(), Footprint().grown(0.1))
    while True:
        away, side, yaw = rng.uniform(1.4, 2.4), rng.uniform(-1.2, 1.2), rng.uniform(-np.pi / 3, np.pi / 3)
        pose = np.array([[near - away, middle + side, yaw]])
        if not body.touches(pose)[0] and abs(yaw) + abs(side) > 0.5:
            return Pose2(*map(float, pose[0]))


def _task_course(
    name: str, d: Drawing, way: list[Point], start: Pose2, *berths: Door, config: RouteConfig | None = None
) -> Course:
    grid = d.grid()
    route = RoutePlanner(grid, config, doors=[*d.doors, *berths]).route(way)
    return Course(
        name, grid, start, route, False, "a short task from a start drawn from the seed", "test", tuple(d.doors)
    )


def _checked(seed: int) -> int:
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    return seed
