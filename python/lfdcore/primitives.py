"""Movement and interaction primitives, dynamic time warping, orientations, sequences of tasks.

Re-exports lfdcore._core.primitives.
"""

from lfdcore._core.primitives import (
    DtwResult,
    OpenEndDtw,
    OpenEndPhase,
    PartnerPhase,
    PhaseEstimator,
    PhaseEstimatorConfig,
    SequenceBelief,
    SequenceConfig,
    SequenceHmm,
    SequencePrimitive,
    continuous_quaternions,
    dtw,
    dtw_distance,
    geodesic_angle,
    imaginary_parts,
    mean_orientation,
    open_end_dtw,
    quaternions_from_imaginary,
)

__all__ = [
    "DtwResult",
    "OpenEndDtw",
    "OpenEndPhase",
    "PartnerPhase",
    "PhaseEstimator",
    "PhaseEstimatorConfig",
    "SequenceBelief",
    "SequenceConfig",
    "SequenceHmm",
    "SequencePrimitive",
    "continuous_quaternions",
    "dtw",
    "dtw_distance",
    "geodesic_angle",
    "imaginary_parts",
    "mean_orientation",
    "open_end_dtw",
    "quaternions_from_imaginary",
]
