"""Grid MDPs, dynamic policy programming, hybrid A*. Re-exports lfdcore._core.planning."""

from lfdcore._core.planning import (
    DppConfig,
    DppResult,
    DppSolver,
    GreedyPath,
    GridMdp,
    HybridAstar,
    HybridAstarConfig,
    HybridAstarResult,
    PathOutcome,
    RewardConfig,
    baseline_preference,
    greedy_path,
    path_cells,
    path_reward,
    solve_hybrid_astar,
)

__all__ = [
    "DppConfig",
    "DppResult",
    "DppSolver",
    "GreedyPath",
    "GridMdp",
    "HybridAstar",
    "HybridAstarConfig",
    "HybridAstarResult",
    "PathOutcome",
    "RewardConfig",
    "baseline_preference",
    "greedy_path",
    "path_cells",
    "path_reward",
    "solve_hybrid_astar",
]
