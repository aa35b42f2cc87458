"""A moment of a simulated drive among people: where they are, how they walk, what the scan shows of them."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from numpy.typing import NDArray

from lfdcore.grid import LaserScan, OccupancyGrid
from lfdcore.pictures.course import draw_footprints, draw_grid
from lfdcore.pictures.style import BEAM, BLUE, PAGE, REFERENCE, SEEN, WAY, line_handle, styled, translucent
from lfdcore.simulation import DrivingWorld, Person

Array = NDArray[np.float64]
_AHEAD = 1.0
"""Arrows show how far one gets in so long [s]."""


@styled
def people_figure(grid: OccupancyGrid, world: DrivingWorld) -> Figure:
    """The world now on its map: chair, scan, and people with their next second."""
    x0, x1, y0, y1 = _known(grid)
    width, height = x1 - x0, y1 - y0
    scale = min((PAGE - 1.0) / width, 9.0 / height)
    figure = Figure(figsize=(scale * width + 1.0, scale * height + 1.0), layout="compressed")
    axes = figure.subplots()
    draw_grid(axes, grid)
    laser, ends = scan_points(world, world.scan())
    beams = np.stack([np.broadcast_to(laser, ends.shape), ends], axis=1)
    axes.add_collection(LineCollection(list(beams), colors=translucent(BEAM, 0.35), linewidths=0.4, zorder=1))
    axes.plot(*ends.T, ".", color=BLUE, ms=2.2, mew=0, zorder=3)
    draw_footprints(axes, np.array([[*world.state.pose]]), world.chair.footprint, WAY, translucent(WAY, 0.6))
    for person, shown in zip(world.people, world.people_in_scan(), strict=True):
        colour = SEEN if shown else REFERENCE
        x, y = person.position
        axes.add_patch(Circle((x, y), person.radius, fc=translucent(colour, 0.55), ec=colour, lw=0.8, zorder=4))
        axes.plot(*_next_second(person).T, color=colour, lw=1.2, zorder=4)
    axes.set(xlim=(x0, x1), ylim=(y0, y1))
    handles = [
        Patch(fc=translucent(WAY, 0.6), ec=WAY, label="chair"),
        line_handle(BEAM, "beam", 1.0),
        Patch(fc=translucent(SEEN, 0.55), ec=SEEN, label="person in the scan"),
        Patch(fc=translucent(REFERENCE, 0.55), ec=REFERENCE, label="person out of it"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, handlelength=1.4)
    return figure


def scan_points(world: DrivingWorld, scan: LaserScan) -> tuple[Array, Array]:
    """Where the laser is (2,) and where its beams (N, 2) of finite range end [m, map]."""
    laser = world.state.pose * world.lidar.T_base_laser
    angles, ranges = np.asarray(scan.angles()), np.asarray(scan.ranges, dtype=np.float64)
    there = np.isfinite(ranges)
    ends = ranges[there, None] * np.stack([np.cos(angles[there]), np.sin(angles[there])], axis=1)
    return np.array([laser.x, laser.y]), laser.transform(ends)


def _known(grid: OccupancyGrid) -> tuple[float, float, float, float]:
    """x0, x1, y0, y1 [m] of the map's known part."""
    iy, ix = np.nonzero(grid.data >= 0)
    (x, y), cell = grid.origin, grid.resolution
    return x + ix.min() * cell, x + (ix.max() + 1) * cell, y + iy.min() * cell, y + (iy.max() + 1) * cell


def _next_second(person: Person) -> Array:
    return np.stack([person.position, person.position + _AHEAD * person.velocity])
