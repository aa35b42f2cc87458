"""Occupancy grids, scans, distance fields, ray casting, heatmaps along a drive. Re-exports lfdcore._core.grid."""

from lfdcore._core.grid import (
    HeatmapMap,
    LaserScan,
    ObstaclePoints,
    OccupancyGrid,
    RayCaster,
    RollingMap,
    distance_field,
    inflate,
    local_grid,
    read_beams,
)

__all__ = [
    "HeatmapMap",
    "LaserScan",
    "ObstaclePoints",
    "OccupancyGrid",
    "RayCaster",
    "RollingMap",
    "distance_field",
    "inflate",
    "local_grid",
    "read_beams",
]
