"""Dynamic policy programming: against plain NumPy, against value iteration, and the claims of ERRATA 15-20."""

import pickle
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from dpp_oracle import MOVES, dpp, optimal_values
from lfdcore.planning import (
    DppConfig,
    DppSolver,
    GreedyPath,
    GridMdp,
    PathOutcome,
    baseline_preference,
    greedy_path,
    path_reward,
)

# Both sides round in double; with these rewards, 1e-13 of the largest preference has been seen.
ROUNDING = 1e-10


def scene(shape: tuple[int, int], seed: int, blocked_share: float = 0.3) -> GridMdp:
    rng = np.random.default_rng(seed)
    reward = rng.uniform(-100, 100, shape).astype(np.float32)
    return GridMdp(reward, rng.random(shape) < blocked_share)


def assert_same(found: NDArray[np.float64], wanted: NDArray[np.float64]) -> None:
    there = np.isfinite(wanted)
    np.testing.assert_array_equal(np.isfinite(found), there)
    scale = np.abs(wanted[there]).max(initial=1.0)
    np.testing.assert_allclose(found[there], wanted[there], rtol=0, atol=ROUNDING * scale)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (9, 1), (2, 2), (8, 16), (19, 26)])
@pytest.mark.parametrize(("sweeps", "eta"), [(1, 0.001), (99, 0.001), (120, 5.0)])
@pytest.mark.parametrize("with_initial", [False, True])
def test_preferences_equal_plain_numpy_of_d7(
    shape: tuple[int, int], sweeps: int, eta: float, with_initial: bool
) -> None:
    mdp = scene(shape, seed=3)
    initial = np.random.default_rng(4).normal(0, 1000, (*shape, 9)) if with_initial else None
    psi, mean = dpp(mdp.reward, mdp.blocked, 0.99, eta, sweeps, initial)
    config = DppConfig(sweeps=sweeps, inverse_temperature=eta)
    result = DppSolver(config).solve(mdp, initial)
    assert_same(result.preferences(), psi)
    assert_same(result.values(), np.where(mdp.blocked, np.nan, mean))


def test_preferences_survive_exponents_far_beyond_the_range_of_exp() -> None:
    """eta times the spread of Psi reaches 3e6 here; e^745 is the end of doubles."""
    reward = np.zeros((12, 40), np.float32)
    reward[6, 37] = 1000
    reward[0, :4] = -1000
    mdp = GridMdp(reward)
    psi, mean = dpp(mdp.reward, mdp.blocked, 0.95, 0.5, 300)
    result = DppSolver(DppConfig(discount=0.95, inverse_temperature=0.5, sweeps=300)).solve(mdp)
    assert 0.5 * np.ptp(result.successor_part) > 1e6
    assert_same(result.preferences(), psi)
    assert_same(result.values(), mean)


def test_a_tiny_initial_preference_on_every_state_changes_nothing() -> None:
    """The general path (9 exponentials a state) and the stencil agree."""
    mdp = scene((30, 41), seed=5)
    solver = DppSolver()
    assert_same(solver.solve(mdp, np.full((30, 41, 9), 1e-300)).preferences(), solver.solve(mdp).preferences())


def test_values_tend_to_the_optimum_of_value_iteration() -> None:
    mdp = scene((12, 15), seed=6)
    config = DppConfig(discount=0.9, inverse_temperature=0.001, sweeps=20000)
    values = DppSolver(config).solve(mdp).values()
    wanted = optimal_values(mdp.reward, mdp.blocked, 0.9)
    np.testing.assert_allclose(values[~mdp.blocked], wanted[~mdp.blocked], rtol=1e-6)


def test_a_transposed_map_gives_transposed_values() -> None:
    mdp = scene((23, 14), seed=7)
    turned = GridMdp(mdp.reward.T.copy(), mdp.blocked.T.copy())
    solver = DppSolver()
    np.testing.assert_allclose(solver.solve(turned).values(), solver.solve(mdp).values().T, rtol=1e-9)


def test_a_reused_solver_gives_the_same_bytes_as_a_new_one() -> None:
    reused = DppSolver()
    for seed, shape in enumerate([(20, 20), (7, 33), (33, 7), (20, 20)]):
        mdp = scene(shape, seed)
        initial = np.ones((*shape, 9)) if seed % 2 else None
        fresh = DppSolver().solve(mdp, initial).preferences()
        np.testing.assert_array_equal(reused.solve(mdp, initial).preferences(), fresh)


def test_greedy_actions_are_the_first_largest_preference() -> None:
    mdp = scene((25, 18), seed=8)
    result = DppSolver(DppConfig(sweeps=50)).solve(mdp)
    wanted = np.where(mdp.blocked, -1, result.preferences().argmax(axis=2))
    np.testing.assert_array_equal(result.greedy_actions(), wanted)


@pytest.mark.parametrize("sweeps", [99, 300])
def test_the_plan_around_an_obstacle_is_that_of_plain_numpy(sweeps: int) -> None:
    rng = np.random.default_rng(10)
    occupied = np.zeros((40, 40), bool)
    occupied[12:30, 20:24] = True
    path = np.array([[8, 17], [9, 18], *([x, 19] for x in range(10, 33)), [33, 20]])
    # No two cells alike: where paths tie, rounding would decide.
    mdp = GridMdp(path_reward(occupied, path) + rng.uniform(0, 0.1, (40, 40)).astype(np.float32), occupied)
    psi, _ = dpp(mdp.reward, mdp.blocked, 0.99, 0.001, sweeps)
    result = DppSolver(DppConfig(sweeps=sweeps)).solve(mdp)
    np.testing.assert_array_equal(result.greedy_actions(), np.where(occupied, -1, psi.argmax(axis=2)))
    # D.8 is no contraction: the rounding of one sweep can grow a million times before it shrinks again.
    found, there = result.preferences(), np.isfinite(psi)
    np.testing.assert_allclose(found[there], psi[there], rtol=0, atol=1e-7 * np.abs(psi[there]).max())
    assert greedy_path(result, (8, 17), (33, 20)).outcome == PathOutcome.goal


def check_path(path: GreedyPath, blocked: NDArray[np.bool_]) -> None:
    cells = path.cells
    assert len(np.unique(cells, axis=0)) == len(cells)
    assert not blocked[cells[:, 1], cells[:, 0]].any()
    steps = np.diff(cells, axis=0)
    assert (np.abs(steps).max(axis=1, initial=1) == 1).all()
    diagonal = (steps != 0).all(axis=1)
    here, there = cells[:-1][diagonal], cells[1:][diagonal]
    assert not (blocked[here[:, 1], there[:, 0]] & blocked[there[:, 1], here[:, 0]]).any()


@settings(max_examples=200, deadline=None)
@given(
    blocked=hnp.arrays(bool, st.tuples(st.integers(1, 24), st.integers(1, 24))),
    seed=st.integers(0, 2**32 - 1),
    sweeps=st.integers(1, 60),
)
def test_a_path_never_enters_a_blocked_cell_nor_squeezes_between_two(
    blocked: NDArray[np.bool_], seed: int, sweeps: int
) -> None:
    height, width = blocked.shape
    rng = np.random.default_rng(seed)
    mdp = GridMdp(rng.uniform(-100, 100, blocked.shape).astype(np.float32), blocked)
    ends = rng.integers(0, [width, height], (2, 2))
    start, goal = (int(ends[0, 0]), int(ends[0, 1])), (int(ends[1, 0]), int(ends[1, 1]))
    path = greedy_path(DppSolver(DppConfig(sweeps=sweeps)).solve(mdp), start, goal)
    assert tuple(path.cells[0]) == start
    if blocked[start[1], start[0]]:
        assert path.outcome == PathOutcome.start_blocked
        return
    check_path(path, blocked)
    assert (path.outcome == PathOutcome.goal) == (tuple(path.cells[-1]) == goal)


def wall_scene(thickness: int, gap_row: int) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """A wall across the window with one opening of 5 rows, and a straight path through the wall, (ix, iy)."""
    occupied = np.zeros((100, 100), bool)
    occupied[:, 65 : 65 + thickness] = True
    occupied[gap_row - 2 : gap_row + 3, :] = False
    path = np.array([[x, 50] for x in range(50, 91)])
    return occupied, path


def wall_cells_crossed(occupied: NDArray[np.bool_], cells: NDArray[np.int32]) -> int:
    return int(occupied[cells[:, 1], cells[:, 0]].sum())


@pytest.mark.parametrize("sweeps", [99, 300])
def test_printed_soft_obstacles_drive_through_a_thin_wall(sweeps: int) -> None:
    """ERRATA 20: rewards of Sec. 3.5, no hard obstacles, an opening 10 cells aside."""
    occupied, path = wall_scene(1, gap_row=60)
    soft = DppSolver(DppConfig(sweeps=sweeps, blocked=False))
    found = greedy_path(soft.solve(GridMdp(path_reward(occupied, path), occupied)), (50, 50), (90, 50))
    assert found.outcome == PathOutcome.goal
    assert wall_cells_crossed(occupied, found.cells) == 1


def test_converged_soft_obstacles_cross_15_wall_cells_where_99_sweeps_stop_short() -> None:
    """ERRATA 20: where printed DPP stops before a thick wall, that is under-convergence; it never takes the opening."""
    occupied, path = wall_scene(15, gap_row=65)
    mdp = GridMdp(path_reward(occupied, path), occupied)
    printed, converged = (
        greedy_path(DppSolver(DppConfig(sweeps=k, blocked=False)).solve(mdp), (50, 50), (90, 50)) for k in (99, 1000)
    )
    assert printed.outcome == PathOutcome.stay
    assert wall_cells_crossed(occupied, printed.cells) == 0
    assert converged.outcome == PathOutcome.goal
    assert wall_cells_crossed(occupied, converged.cells) == 15


@pytest.mark.parametrize("thickness", [1, 15])
def test_blocked_obstacles_send_the_plan_through_the_opening(thickness: int) -> None:
    """ERRATA 20: what hard obstacles change."""
    occupied, path = wall_scene(thickness, gap_row=60)
    found = greedy_path(DppSolver().solve(GridMdp(path_reward(occupied, path), occupied)), (50, 50), (90, 50))
    assert found.outcome == PathOutcome.goal
    assert wall_cells_crossed(occupied, found.cells) == 0


def test_blocked_obstacles_need_more_sweeps_than_printed() -> None:
    """ERRATA 20: 99 sweeps stop short of an opening 15 cells aside, 300 pass it."""
    occupied, path = wall_scene(15, gap_row=65)
    mdp = GridMdp(path_reward(occupied, path), occupied)
    outcomes = [greedy_path(DppSolver(DppConfig(sweeps=k)).solve(mdp), (50, 50), (90, 50)).outcome for k in (99, 300)]
    assert outcomes == [PathOutcome.stay, PathOutcome.goal]


def test_a_sealed_wall_ends_in_stay_not_in_the_wall() -> None:
    occupied, path = wall_scene(1, gap_row=60)
    occupied[:, 65] = True
    found = greedy_path(DppSolver().solve(GridMdp(path_reward(occupied, path), occupied)), (50, 50), (90, 50))
    assert found.outcome == PathOutcome.stay
    assert found.cells[:, 0].max() < 65


def test_the_baseline_has_boltzmann_mean_zero_and_its_policy_is_the_baseline() -> None:
    """ERRATA 19: Psi_0 = (log pi_0 + entropy) / eta is no hidden reward."""
    path = np.array([[1, 2], [2, 2], [3, 3]])
    psi = baseline_preference(path, (6, 5), 0.9, 0.001)
    assert psi.shape == (6, 5, 9)
    weights = np.exp(0.001 * psi)
    policy = weights / weights.sum(axis=2, keepdims=True)
    np.testing.assert_allclose((policy * psi).sum(axis=2), 0, atol=1e-9)
    moves = [MOVES.index((0, 1)), MOVES.index((1, 1)), MOVES.index((0, 0))]
    np.testing.assert_allclose(policy[path[:, 1], path[:, 0], moves], 0.9)
    off = np.ones((6, 5), bool)
    off[path[:, 1], path[:, 0]] = False
    assert (psi[off] == 0).all()


@pytest.mark.parametrize("sweeps", [99, 300])
def test_the_baseline_alone_does_not_lead_around_an_obstacle_but_the_path_reward_does(sweeps: int) -> None:
    """ERRATA 19: why the path is put into the reward."""
    occupied, path = wall_scene(1, gap_row=60)
    psi = baseline_preference(path, (100, 100), 0.9, 0.001)
    solver = DppSolver(DppConfig(sweeps=sweeps))
    alone = solver.solve(GridMdp(path_reward(occupied, path[:0]), occupied), psi)
    both = solver.solve(GridMdp(path_reward(occupied, path), occupied), psi)
    assert greedy_path(alone, (50, 50), (90, 50)).outcome == PathOutcome.stay
    assert greedy_path(both, (50, 50), (90, 50)).outcome == PathOutcome.goal


def test_the_start_in_the_goal_cell_is_there_at_once() -> None:
    path = greedy_path(DppSolver(DppConfig(sweeps=1)).solve(GridMdp(np.zeros((3, 3), np.float32))), (2, 1), (2, 1))
    assert path.outcome == PathOutcome.goal
    assert path.reached_goal
    np.testing.assert_array_equal(path.cells, [[2, 1]])


def test_opposed_preferences_end_as_a_cycle() -> None:
    """Two cells whose initial preferences, not worn off after one sweep, send the plan from one to the other."""
    psi = np.zeros((1, 3, 9))
    psi[0, 0, MOVES.index((0, 1))] = psi[0, 1, MOVES.index((0, -1))] = 1000
    mdp = GridMdp(np.zeros((1, 3), np.float32), np.array([[False, False, True]]))
    result = DppSolver(DppConfig(sweeps=1)).solve(mdp, psi)
    path = greedy_path(result, (0, 0), (2, 0))
    assert path.outcome == PathOutcome.cycle
    np.testing.assert_array_equal(path.cells, [[0, 0], [1, 0]])


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("discount", 1.0, r"discount is 1\.0+, must lie within \(0, 1\)"),
        ("discount", float("nan"), "discount"),
        ("inverse_temperature", 0.0, "inverse_temperature is 0 1/reward, must be positive"),
        ("sweeps", 0, "sweeps is 0, must be between 1 and 100000"),
    ],
)
def test_config_refuses_what_has_no_meaning(field: str, value: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        DppConfig(**{field: value})


def test_mdp_refuses_bad_grids() -> None:
    with pytest.raises(ValueError, match="blocked is 3 x 4, must be 4 x 3"):
        GridMdp(np.zeros((4, 3), np.float32), np.zeros((3, 4), bool))
    with pytest.raises(ValueError, match="NaN or infinity"):
        GridMdp(np.array([[np.nan]], np.float32))
    with pytest.raises(ValueError, match="at least 1 x 1"):
        GridMdp(np.zeros((0, 3), np.float32))


def test_solver_refuses_bad_initial_preferences_and_exponents() -> None:
    mdp = GridMdp(np.ones((4, 3), np.float32))
    with pytest.raises(ValueError, match=r"\(4, 3, 9\)"):
        DppSolver().solve(mdp, np.zeros((3, 4, 9)))
    with pytest.raises(ValueError, match="initial preference holds NaN"):
        DppSolver().solve(mdp, np.full((4, 3, 9), np.nan))
    with pytest.raises(ValueError, match="exponents"):
        DppSolver(DppConfig(inverse_temperature=1e6)).solve(mdp)


def test_greedy_path_refuses_cells_outside() -> None:
    result = DppSolver(DppConfig(sweeps=1)).solve(GridMdp(np.zeros((4, 3), np.float32)))
    with pytest.raises(ValueError, match=r"start cell is \(3, 0\), must lie in the grid of 3 x 4"):
        greedy_path(result, (3, 0), (0, 0))
    with pytest.raises(ValueError, match=r"goal cell is \(0, -1\)"):
        greedy_path(result, (0, 0), (0, -1))


def test_baseline_refuses_a_torn_path_and_a_certain_move() -> None:
    with pytest.raises(ValueError, match="next to its follower"):
        baseline_preference(np.array([[0, 0], [2, 0]]), (4, 4), 0.9, 0.001)
    with pytest.raises(ValueError, match=r"probability is 1\.0+, must lie within"):
        baseline_preference(np.array([[0, 0]]), (4, 4), 1.0, 0.001)


def test_one_solver_serves_several_threads() -> None:
    solver, results = DppSolver(DppConfig(sweeps=50)), {}
    mdps = [scene((20 + i, 30 - i), seed=i) for i in range(6)]

    def work(i: int) -> None:
        results[i] = solver.solve(mdps[i]).preferences()

    threads = [threading.Thread(target=work, args=(i,)) for i in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i, mdp in enumerate(mdps):
        np.testing.assert_array_equal(results[i], DppSolver(solver.config).solve(mdp).preferences())


def test_configs_and_problems_pickle() -> None:
    config = pickle.loads(pickle.dumps(DppConfig(sweeps=99, blocked=False, discount=0.9)))
    assert (config.sweeps, config.blocked, config.discount) == (99, False, 0.9)
    mdp = scene((4, 5), seed=9)
    again = pickle.loads(pickle.dumps(mdp))
    np.testing.assert_array_equal(again.reward, mdp.reward)
    np.testing.assert_array_equal(again.blocked, mdp.blocked)
