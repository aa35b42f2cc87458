"""Dynamic movement primitives and interaction primitives.

Re-exports lfdcore._core.primitives.
"""

from lfdcore._core.primitives import (
    Dmp,
    DmpConfig,
    DmpStepper,
    DmpTrajectory,
    InteractionObserver,
    InteractionPosterior,
    InteractionPrimitive,
    InteractionPrimitiveConfig,
    InteractionTrajectory,
    basis,
    forcing_terms,
    partner_forcing,
    phases,
)

__all__ = [
    "Dmp",
    "DmpConfig",
    "DmpStepper",
    "DmpTrajectory",
    "InteractionObserver",
    "InteractionPosterior",
    "InteractionPrimitive",
    "InteractionPrimitiveConfig",
    "InteractionTrajectory",
    "basis",
    "forcing_terms",
    "partner_forcing",
    "phases",
]
