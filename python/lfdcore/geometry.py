"""Planar poses, twists, paths and the chair's outline. Re-exports lfdcore._core.geometry."""

from lfdcore._core.geometry import (
    Footprint,
    MotionLimits,
    Pose2,
    Twist2,
    approach,
    arc_length,
    integrate,
    resample,
    wrap_angle,
)

__all__ = [
    "Footprint",
    "MotionLimits",
    "Pose2",
    "Twist2",
    "approach",
    "arc_length",
    "integrate",
    "resample",
    "wrap_angle",
]
