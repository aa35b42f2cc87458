"""
Grid MDPs, dynamic policy programming, Q-learning, user heatmaps, hybrid A*.
"""

from __future__ import annotations
import lfdcore._core.geometry
import lfdcore._core.grid
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "DppConfig",
    "DppResult",
    "DppSolver",
    "GreedyPath",
    "GridMdp",
    "HeatmapRewardConfig",
    "HybridAstar",
    "HybridAstarConfig",
    "HybridAstarResult",
    "MovementTemplate",
    "OrientationMoments",
    "PathOutcome",
    "QLearningConfig",
    "QLearningResult",
    "QLearningSolver",
    "RewardConfig",
    "UserHeatmap",
    "arc_orientation",
    "baseline_preference",
    "compliance",
    "compliances",
    "greedy_path",
    "heatmap_reward",
    "joystick_orientation",
    "path_cells",
    "path_reward",
    "solve_hybrid_astar",
    "user_heatmap",
]

class GridMdp:
    """
    The grid world as a Markov decision process (App. D.2): a state a cell, 9 deterministic moves, row-major over (dy, dx) in (-1, 0, 1)^2 with 4 = stay; a move out of the grid stays. Rewards (H, W) are gained on arrival. No move enters a blocked (H, W) cell or passes diagonally between two. ValueError for shapes that differ, an empty grid or a reward that is not finite.
    """

    @typing.overload
    def __init__(self, reward: numpy.typing.ArrayLike, blocked: numpy.typing.ArrayLike) -> None: ...
    @typing.overload
    def __init__(self, reward: numpy.typing.ArrayLike) -> None: ...
    @property
    def blocked(self) -> numpy.typing.NDArray[numpy.bool]:
        """
        (H, W) bool, a view
        """

    @property
    def reward(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (H, W) float32, a view
        """

class RewardConfig:
    """
    Rewards of Sec. 3.5: obstacle and border (the outermost ring of cells), spread by a Gaussian of blur_sigma [cells] cut off at 4 sigma; path_first .. path_last linearly along the path.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        obstacle: float = -100.0,
        border: float = -100.0,
        blur_sigma: float = 2.0,
        path_first: float = 10.0,
        path_last: float = 100.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def blur_sigma(self) -> float:
        """
        [cells]
        """

    @property
    def border(self) -> float: ...
    @property
    def obstacle(self) -> float: ...
    @property
    def path_first(self) -> float: ...
    @property
    def path_last(self) -> float: ...

class DppConfig:
    """
    discount gamma in (0, 1); inverse_temperature eta [1/reward] > 0; sweeps 1..100 000 (Sec. 3.5 prints K = 100, which is 99 sweeps: ERRATA 16); blocked: moves into blocked cells do not exist, else the mask is ignored and obstacles are soft (ERRATA 20).
    """

    def __hash__(self) -> int: ...
    def __init__(
        self, *, discount: float = 0.99, inverse_temperature: float = 0.001, sweeps: int = 300, blocked: bool = True
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def blocked(self) -> bool: ...
    @property
    def discount(self) -> float: ...
    @property
    def inverse_temperature(self) -> float:
        """
        [1/reward]
        """

    @property
    def sweeps(self) -> int: ...

class DppResult:
    """
    Action preferences after the last sweep, kept as Psi(s, a) = Psi_0(s, a) + A(s') - B(s); the methods work them out on demand [reward].
    """

    def greedy_actions(self) -> numpy.typing.NDArray[numpy.int8]:
        """
        (H, W) int8: argmax_a Psi(s, a), ties to the lowest index; -1 where blocked.
        """

    def preferences(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Psi (H, W, 9) [reward]; -inf for moves that are not available.
        """

    def values(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        M_eta Psi (H, W), the Boltzmann mean of D.8 [reward]; NaN where blocked.
        """

    @property
    def config(self) -> DppConfig: ...
    @property
    def mdp(self) -> GridMdp:
        """
        as solved: nothing is blocked if the config says so
        """

    @property
    def state_part(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        B (H, W) [reward], a view; NaN where blocked
        """

    @property
    def successor_part(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        A (H, W) [reward], a view; NaN where blocked
        """

class PathOutcome:
    """
    Why a greedy path ended (ERRATA 15).

    Members:

      goal : in the goal cell

      stay : the best move is to stay, short of the goal

      cycle : the next cell had been visited

      start_blocked : the start is a blocked cell: there is no move
    """

    __members__: typing.ClassVar[dict[str, PathOutcome]]
    cycle: typing.ClassVar[PathOutcome]
    goal: typing.ClassVar[PathOutcome]
    start_blocked: typing.ClassVar[PathOutcome]
    stay: typing.ClassVar[PathOutcome]

    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: int) -> None: ...
    def __int__(self) -> int: ...
    def __repr__(self) -> str: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class GreedyPath:
    """
    A path over cells and why it ended.
    """

    @property
    def cells(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (N, 2) [ix, iy] from the start (included) to the last cell reached; no cell twice
        """

    @property
    def outcome(self) -> PathOutcome: ...
    @property
    def reached_goal(self) -> bool:
        """
        whether it ended in the goal cell
        """

class DppSolver:
    """
    Dynamic policy programming (App. D.2, Alg. 2; Azar et al. 2012) on a grid. Keeps its workspace between grids of one size. Calls from several threads wait for each other.
    """

    def __init__(self, config: DppConfig = ...) -> None: ...
    def solve(self, mdp: GridMdp, initial_preference: numpy.ndarray | None = None) -> DppResult:
        """
        Runs the sweeps of D.7 from Psi_0 = 0 or a given (H, W, 9) initial preference [reward]. ValueError if rewards are too large against the temperature (exponents beyond 1e9).
        """

    @property
    def config(self) -> DppConfig: ...

class HybridAstarConfig:
    """
    Settings of the hybrid A* search. Costs are lengths [m]: what one would rather drive than suffer the thing once, or per unit of it.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        margin: float = 0.04,
        goal_tolerance: float = 0.15,
        heading_tolerance: float = 0.2,
        window: float = 3.5,
        max_expansions: int = 2500,
        allow_reverse: bool = False,
        turn_cost: float = 0.1,
        curvature_cost: float = 0.05,
        pivot_cost: float = 1.0,
        pivot_turn_cost: float = 0.5,
        reverse_cost: float = 2.0,
        clearance_cost: float = 2.0,
        comfort: float = 0.3,
        eagerness: float = 2.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def allow_reverse(self) -> bool:
        """
        drive backwards too
        """

    @property
    def clearance_cost(self) -> float:
        """
        added to each metre at clearance 0
        """

    @property
    def comfort(self) -> float:
        """
        clearance from which on more is not better [m]
        """

    @property
    def curvature_cost(self) -> float:
        """
        of a change of curvature [m per 1/m]
        """

    @property
    def eagerness(self) -> float:
        """
        weight of the heuristic; 1: least cost, more: sooner found
        """

    @property
    def goal_tolerance(self) -> float:
        """
        of the base_link origin [m]
        """

    @property
    def heading_tolerance(self) -> float:
        """
        of the final heading, if asked for [rad]
        """

    @property
    def margin(self) -> float:
        """
        kept free around the footprint [m]
        """

    @property
    def max_expansions(self) -> int:
        """
        of a search; failed searches cost all of them
        """

    @property
    def pivot_cost(self) -> float:
        """
        of starting to turn in place [m]
        """

    @property
    def pivot_turn_cost(self) -> float:
        """
        of turning in place [m/rad]
        """

    @property
    def reverse_cost(self) -> float:
        """
        added to each metre backwards
        """

    @property
    def turn_cost(self) -> float:
        """
        [m/rad]
        """

    @property
    def window(self) -> float:
        """
        base_link's origin stays within this of the start in x and y [m]
        """

class HybridAstarResult:
    """
    What a hybrid A* search came to.
    """

    @property
    def cost(self) -> float:
        """
        [m], 0 unless found
        """

    @property
    def expansions(self) -> int: ...
    @property
    def found(self) -> bool: ...
    @property
    def margin(self) -> float:
        """
        kept free around the footprint all along the path [m]
        """

    @property
    def outcome(self) -> str:
        """
        'found' | 'no_path' (the whole window was searched) | 'expansion_limit' (gave up) | 'start_blocked' (the footprint holds an obstacle at the start) | 'goal_blocked' (no pose within the goal's tolerance is free)
        """

    @property
    def path(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N, 3) x, y [m], yaw [rad], neighbours within 0.05 m and 0.1 rad; (0, 3) unless found; a view
        """

class HybridAstar:
    """
    Path for the chair's whole body in (x, y, heading) among obstacle points (Dolgov et al. 2010). Keeps its memory (about 3 MB) from search to search; not to be shared between threads. Cells of 0.05 m, 32 headings, arcs of 0.15 m with curvatures 0, +-0.6, +-1.3, +-2.2 1/m, turns in place by 1/32.
    """

    def __init__(self, footprint: lfdcore._core.geometry.Footprint, *, config: HybridAstarConfig = ...) -> None: ...
    def solve(
        self,
        obstacles: lfdcore._core.grid.ObstaclePoints,
        start: lfdcore._core.geometry.Pose2,
        goal: numpy.typing.ArrayLike,
        *,
        goal_heading: float | None = None,
    ) -> HybridAstarResult:
        """
        From `start` to base_link's origin within the tolerance of goal (2,) [m] (and of goal_heading [rad]), all
        in the frame of the obstacles. Where the start is nearer to an obstacle than the margin, the margin
        becomes half of what is free there. ValueError for values that are not finite or a goal outside the
        window.
        """

class HeatmapRewardConfig:
    """
    Rewards of Sec. 4.5 of blocked cells (obstacle) and of the outermost ring (border).
    """

    def __hash__(self) -> int: ...
    def __init__(self, *, obstacle: float = -100.0, border: float = -100.0) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def border(self) -> float: ...
    @property
    def obstacle(self) -> float: ...

class QLearningConfig:
    """
    learning_rate alpha in (0, 1]; discount gamma in (0, 1), .9 in Sec. 4.5, which sees some 10 cells (ERRATA 31, F9); sweeps 1..100 000 (the printed K = 100 is 99: ERRATA 16); initial_value Q_0 [reward]; blocked: moves into blocked cells do not exist, else the mask is ignored and obstacles are soft (as printed; ERRATA 20).
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        learning_rate: float = 0.7,
        discount: float = 0.95,
        sweeps: int = 100,
        initial_value: float = -100.0,
        blocked: bool = True,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def blocked(self) -> bool: ...
    @property
    def discount(self) -> float: ...
    @property
    def initial_value(self) -> float:
        """
        [reward]
        """

    @property
    def learning_rate(self) -> float: ...
    @property
    def sweeps(self) -> int: ...

class QLearningResult:
    """
    Q after the last sweep, kept as Q(s, a) = q(s'); the methods work it out on demand [reward].
    """

    def action_values(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Q (H, W, 9) [reward]; -inf for moves that are not available.
        """

    def greedy_actions(self) -> numpy.typing.NDArray[numpy.int8]:
        """
        (H, W) int8: argmax_a Q(s, a), ties to the lowest index; -1 where blocked.
        """

    def values(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        max_a Q(s, a) (H, W) [reward]; NaN where blocked.
        """

    @property
    def config(self) -> QLearningConfig: ...
    @property
    def mdp(self) -> GridMdp:
        """
        as solved: nothing is blocked if the config says so
        """

    @property
    def successor_value(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        q (H, W) [reward], a view; NaN where blocked
        """

class QLearningSolver:
    """
    Q-learning (App. D.1, Alg. 3; Sutton and Barto 1998) on a grid, synchronous. Keeps its workspace between grids of one size. Calls from several threads wait for each other.
    """

    def __init__(self, config: QLearningConfig = ...) -> None: ...
    def solve(self, mdp: GridMdp) -> QLearningResult:
        """
        Runs the sweeps of D.1 from Q_0.
        """

    @property
    def config(self) -> QLearningConfig: ...

class MovementTemplate:
    """
    Movement template and distance filter of Sec. 4.4.1 over the local window, from a dense fan of arcs: those ahead cover the front half, those backwards the rear half (ERRATA 28). Built once for a chair's limits, in some 100 ms.
    """

    def __init__(self, limits: lfdcore._core.geometry.MotionLimits = ...) -> None: ...
    @property
    def distance_filter(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (100, 100) float32 in (0, 1], a view: mean length of the arcs up to a cell, divided by the largest
        """

    @property
    def limits(self) -> lfdcore._core.geometry.MotionLimits: ...
    @property
    def orientation(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        h_t (100, 100) float32 [rad], a view: circular mean of the stick's orientation over the arcs through a cell
        """

class OrientationMoments:
    """
    Mean [rad] and variance [rad^2] of a stick's orientation h = arctan2(left, forward): 0 = forward, positive to the left.
    """

    def __init__(self, mean: float, variance: float) -> None: ...
    @property
    def mean(self) -> float:
        """
        [rad]
        """

    @property
    def variance(self) -> float:
        """
        [rad^2]
        """

class UserHeatmap:
    """
    A user heatmap over the local window, before and after the filter.
    """

    @property
    def density(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (100, 100) float32 [1/rad], a view: the weights of Eq. 4.3
        """

    @property
    def heatmap(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (100, 100) float32, a view: density times distance filter, divided by the maximum (F12)
        """

def arc_orientation(point: numpy.typing.ArrayLike, limits: lfdcore._core.geometry.MotionLimits = ...) -> float:
    """
    The stick's orientation h = arctan2(left, forward) [rad] in (-pi, pi] whose constant twist leads base_link's origin through a point (2,) [m]: ahead for x >= 0, else backwards, turned by at most 180 degrees (ERRATA 28). ValueError for a point that is not finite or is the origin.
    """

def baseline_preference(
    path_cells: numpy.ndarray, shape: tuple[int, int], probability: float = 0.9, inverse_temperature: float = 0.001
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Psi_0 (H, W, 9) = (log pi_0 + entropy(pi_0)) / eta of a baseline that follows path cells (N, 2) [ix, iy] (ERRATA 19): `probability` on the path's move (to stay on its last cell), the rest shared by the other 8; uniform, so 0, off the path. ValueError unless 0 < probability < 1, consecutive cells are neighbours, there are at most 10 000 000 cells and the preferences are finite.
    """

def compliance(
    control_point: numpy.typing.ArrayLike,
    orientation: OrientationMoments,
    limits: lfdcore._core.geometry.MotionLimits = ...,
) -> float:
    """
    How well a control point (2,) [m, base_link] complies with a stick's OrientationMoments, in [0, 1]: the density at the point's exact orientation relative to its peak, unfiltered (ERRATA 29); above .9 within .46 sd. 1 at the origin. ValueError as user_heatmap, and for a point that is not finite.
    """

def compliances(
    control_points: numpy.typing.NDArray[numpy.float64],
    orientation: OrientationMoments,
    limits: lfdcore._core.geometry.MotionLimits = ...,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    `compliance` of each of N points (N, 2) [m, base_link] -> (N,).
    """

@typing.overload
def greedy_path(result: DppResult, start_cell: tuple[int, int], goal_cell: tuple[int, int]) -> GreedyPath:
    """
    The greedy path (Alg. 2) between cells (ix, iy); it ends in the goal cell, where the best move is to stay, or before a cell visited already (ERRATA 15). ValueError for a cell outside the grid.
    """

@typing.overload
def greedy_path(
    result: QLearningResult, start_cell: tuple[int, int], goal_cell: tuple[int, int] | None = None
) -> GreedyPath:
    """
    The greedy path (Alg. 3) from a cell (ix, iy), ended by the same rules. Alg. 3 names no goal: without one the usual end is `stay`, on a local maximum. Where all moves tie, as on an all-zero heatmap, it wanders by the lowest index: ask whether there is any heat first.
    """

def heatmap_reward(
    heatmap: numpy.typing.ArrayLike, blocked: numpy.typing.ArrayLike, config: HeatmapRewardConfig = ...
) -> numpy.typing.NDArray[numpy.float32]:
    """
    The reward (H, W) float32 of Sec. 4.5: the heatmap (H, W) in [0, 1], the border over it, blocked cells (H, W) bool (the obstacles grown by what the chair needs) over both. ValueError for an empty heatmap, heat outside [0, 1] or NaN, or shapes that differ.
    """

def joystick_orientation(mean: numpy.typing.ArrayLike, variance: numpy.typing.ArrayLike) -> OrientationMoments | None:
    """
    Moments of h from means (2,) [forward, left] and variances (2,) of the stick's axes, Eq. 4.1-4.2 as corrected (ERRATA 25). The sd is kept within [0.05, pi / sqrt(3)] rad: first order is useless beyond (ERRATA 26). None for a stick at rest, closer than 1e-6 to its centre. ValueError for values that are not finite or a negative variance.
    """

def path_cells(
    path: numpy.typing.ArrayLike, grid: lfdcore._core.grid.OccupancyGrid
) -> numpy.typing.NDArray[numpy.int32]:
    """
    The cells (N, 2) [ix, iy] that a polyline (M, 2) [m, frame of the grid] passes: consecutive ones differ and touch at a side or a corner. Cells outside the grid are left out. ValueError for points that are not finite or more than 100 000 cells off.
    """

def path_reward(
    occupied: numpy.typing.ArrayLike, path_cells: numpy.ndarray, config: RewardConfig = ...
) -> numpy.typing.NDArray[numpy.float32]:
    """
    The reward (H, W) float32 of Sec. 3.5 for occupied cells (H, W) bool and path cells (N, 2) [ix, iy]: obstacles and border blurred, the path over that, obstacles and border over the path (ERRATA 21). A cell that the path visits twice keeps its later reward. ValueError for an empty grid or a path cell outside it.
    """

def solve_hybrid_astar(
    obstacles: lfdcore._core.grid.ObstaclePoints,
    footprint: lfdcore._core.geometry.Footprint,
    start: lfdcore._core.geometry.Pose2,
    goal: numpy.typing.ArrayLike,
    config: HybridAstarConfig = ...,
    *,
    goal_heading: float | None = None,
) -> HybridAstarResult:
    """
    One search with a HybridAstar of its own; see HybridAstar.solve.
    """

def user_heatmap(template: MovementTemplate, orientation: OrientationMoments) -> UserHeatmap:
    """
    The heatmap of Sec. 4.4.2: Eq. 4.3 with wrapped differences (ERRATA 27), times the distance filter. ValueError for a mean that is not finite or a variance that is not within 1e-6..1e6 rad^2.
    """
