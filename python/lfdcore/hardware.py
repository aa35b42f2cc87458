"""Devices: LIDARs that speak SCIP 2.0. Re-exports lfdcore._core.hardware."""

from lfdcore._core.hardware import ScipLidar, ScipStatistics, TimedScan

__all__ = ["ScipLidar", "ScipStatistics", "TimedScan"]
