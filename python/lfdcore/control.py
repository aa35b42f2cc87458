"""Pure pursuit, dynamic window, footprint roll-out and the supervisor. Re-exports lfdcore._core.control."""

from lfdcore._core.control import (
    CommandTiming,
    DynamicWindowConfig,
    DynamicWindowResult,
    FootprintRollout,
    FootprintRolloutConfig,
    PurePursuitResult,
    Supervisor,
    SupervisorConfig,
    SupervisorResult,
    pure_pursuit,
    rollout_pursuit,
    solve_dynamic_window,
    time_to_contact,
)

__all__ = [
    "CommandTiming",
    "DynamicWindowConfig",
    "DynamicWindowResult",
    "FootprintRollout",
    "FootprintRolloutConfig",
    "PurePursuitResult",
    "Supervisor",
    "SupervisorConfig",
    "SupervisorResult",
    "pure_pursuit",
    "rollout_pursuit",
    "solve_dynamic_window",
    "time_to_contact",
]
