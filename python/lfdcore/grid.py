"""Occupancy grids, scans, distance fields and ray casting. Re-exports lfdcore._core.grid."""

from lfdcore._core.grid import (
    LaserScan,
    ObstaclePoints,
    OccupancyGrid,
    RayCaster,
    RollingMap,
    distance_field,
    inflate,
    local_grid,
)

__all__ = [
    "LaserScan",
    "ObstaclePoints",
    "OccupancyGrid",
    "RayCaster",
    "RollingMap",
    "distance_field",
    "inflate",
    "local_grid",
]
