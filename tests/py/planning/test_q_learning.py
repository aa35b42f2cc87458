"""Q-learning: against plain NumPy and value iteration, laws, and the claims of ERRATA 31 and F9."""

import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from lfdcore.planning import (
    GridMdp,
    HeatmapRewardConfig,
    PathOutcome,
    QLearningConfig,
    QLearningSolver,
    greedy_path,
    heatmap_reward,
)
from q_learning_oracle import optimal_path, q_learning

PRINTED = QLearningConfig(discount=0.9, sweeps=99, blocked=False)
SIDE, START = 50, (25, 25)


def scene(shape: tuple[int, int], seed: int, blocked_share: float = 0.3) -> GridMdp:
    rng = np.random.default_rng(seed)
    reward = rng.uniform(-100, 100, shape).astype(np.float32)
    return GridMdp(reward, rng.random(shape) < blocked_share)


def heatmap_scene(seed: int) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """A smooth random heatmap and a few walls away from the start."""
    rng = np.random.default_rng(seed)
    heat = gaussian_filter(rng.random((SIDE, SIDE)) ** 20, 4.0)
    blocked = np.zeros((SIDE, SIDE), bool)
    for _ in range(4):
        x, y = rng.integers(2, SIDE - 2, 2)
        w, h = rng.permutation([rng.integers(3, 15), 2])
        blocked[y : y + h, x : x + w] = True
    blocked[20:31, 20:31] = False
    return (heat / heat.max()).astype(np.float32), blocked


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (9, 1), (2, 2), (8, 16), (19, 26)])
@pytest.mark.parametrize(
    "config", [QLearningConfig(), PRINTED, QLearningConfig(learning_rate=1, sweeps=1), QLearningConfig(initial_value=3)]
)
def test_values_equal_plain_numpy_over_states_and_moves(shape: tuple[int, int], config: QLearningConfig) -> None:
    given_mdp = scene(shape, seed=3)
    mdp = given_mdp if config.blocked else GridMdp(given_mdp.reward)
    wanted = q_learning(mdp, config)
    result = QLearningSolver(config).solve(given_mdp)
    np.testing.assert_allclose(result.action_values(), wanted, rtol=0, atol=1e-10)
    np.testing.assert_array_equal(
        result.greedy_actions(), np.where(mdp.blocked, -1, result.action_values().argmax(axis=2))
    )
    highest = np.where(mdp.blocked, np.nan, result.action_values().max(axis=2))
    np.testing.assert_array_equal(result.values(), highest)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("soft", [True, False])
def test_the_greedy_path_is_the_exact_optimums_with_the_printed_numbers(seed: int, soft: bool) -> None:
    """ERRATA 31: K = 100 is enough; F9: no obstacle is crossed, since rewards are at most 1 against -100."""
    heat, blocked = heatmap_scene(seed)
    config = QLearningConfig(discount=0.9, sweeps=99, blocked=not soft)
    path = greedy_path(QLearningSolver(config).solve(GridMdp(heatmap_reward(heat, blocked), blocked)), START)
    mdp = GridMdp(heatmap_reward(heat, blocked), np.zeros_like(blocked) if soft else blocked)
    assert [tuple(cell) for cell in path.cells] == optimal_path(mdp, 0.9, START)
    assert path.outcome == PathOutcome.stay
    assert not blocked[path.cells[:, 1], path.cells[:, 0]].any()


@pytest.mark.parametrize(("distance", "leaves"), [(10, True), (22, True), (23, False)])
def test_a_tenth_of_the_heat_underfoot_beats_a_goal_22_cells_off_with_the_printed_discount(
    distance: int, leaves: bool
) -> None:
    """ERRATA 31: b > .9^(d - 1)."""
    reward = np.zeros((1, 40), np.float32)
    reward[0, 2], reward[0, 2 + distance] = 0.1, 1.0
    config = QLearningConfig(discount=0.9, sweeps=1000)
    path = greedy_path(QLearningSolver(config).solve(GridMdp(reward)), (2, 0))
    assert path.cells[-1, 0] == (2 + distance if leaves else 2)


def test_a_lone_goal_is_found_at_96_cells_with_the_printed_numbers() -> None:
    heat = np.zeros((100, 100), np.float32)
    heat[50, 97] = 1
    mdp = GridMdp(heatmap_reward(heat, np.zeros_like(heat, bool)))
    path = greedy_path(QLearningSolver(PRINTED).solve(mdp), (1, 50))
    assert tuple(path.cells[-1]) == (97, 50)
    assert len(path.cells) == 97


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), height=st.integers(1, 20), width=st.integers(1, 20), share=st.floats(0, 0.7))
def test_no_path_enters_a_blocked_cell_or_cuts_between_two(seed: int, height: int, width: int, share: float) -> None:
    mdp = scene((height, width), seed, share)
    open_cells = np.argwhere(~mdp.blocked)
    if not len(open_cells):
        return
    iy, ix = open_cells[seed % len(open_cells)]
    cells = greedy_path(QLearningSolver().solve(mdp), (int(ix), int(iy))).cells
    assert not mdp.blocked[cells[:, 1], cells[:, 0]].any()
    assert np.abs(np.diff(cells, axis=0)).max(initial=0) <= 1
    for (x0, y0), (x1, y1) in itertools.pairwise(cells):
        assert not (mdp.blocked[y0, x1] and mdp.blocked[y1, x0])


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), height=st.integers(1, 25), width=st.integers(1, 25))
def test_a_mirrored_map_gives_mirrored_values(seed: int, height: int, width: int) -> None:
    mdp, solver = scene((height, width), seed), QLearningSolver()
    values = solver.solve(mdp).successor_value.copy()
    for turned in (np.fliplr, np.flipud, np.transpose):
        mirrored = GridMdp(turned(mdp.reward).copy(), turned(mdp.blocked).copy())
        np.testing.assert_array_equal(solver.solve(mirrored).successor_value, turned(values))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), more=st.floats(0, 50))
def test_more_reward_anywhere_lowers_no_value(seed: int, more: float) -> None:
    mdp = scene((12, 17), seed)
    richer = mdp.reward.copy()
    richer[seed % 12, seed % 17] += np.float32(more)
    solver = QLearningSolver()
    there = ~mdp.blocked
    before = solver.solve(mdp).successor_value[there]
    assert (solver.solve(GridMdp(richer, mdp.blocked)).successor_value[there] >= before).all()


def test_a_reused_solver_gives_the_same_bytes_as_a_new_one() -> None:
    reused = QLearningSolver()
    for seed, shape in enumerate([(20, 20), (7, 33), (33, 7), (20, 20)]):
        mdp = scene(shape, seed)
        np.testing.assert_array_equal(reused.solve(mdp).successor_value, QLearningSolver().solve(mdp).successor_value)


def test_largest_rewards_stay_finite() -> None:
    largest = np.finfo(np.float32).max
    reward = np.array([[-largest, largest, 0.0]], np.float32)
    values = QLearningSolver(QLearningConfig(discount=1 - 1e-12, sweeps=1000)).solve(GridMdp(reward)).successor_value
    assert np.isfinite(values).all()
    assert values.argmax() == 1


def test_a_path_stops_in_a_given_goal_and_says_why_it_cannot_start() -> None:
    heat, blocked = heatmap_scene(1)
    blocked[0, 0] = True
    result = QLearningSolver().solve(GridMdp(heatmap_reward(heat, blocked), blocked))
    third = tuple(int(i) for i in greedy_path(result, START).cells[2])
    stopped = greedy_path(result, START, (third[0], third[1]))
    assert stopped.outcome == PathOutcome.goal
    assert len(stopped.cells) == 3
    assert greedy_path(result, (0, 0)).outcome == PathOutcome.start_blocked
    with pytest.raises(ValueError, match=r"start cell is \(50, 0\), must lie in the grid of 50 x 50"):
        greedy_path(result, (50, 0))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"learning_rate": 0.0}, r"learning_rate is 0.0*, must lie within \(0, 1\]"),
        ({"learning_rate": 1.5}, "learning_rate"),
        ({"learning_rate": float("nan")}, "learning_rate"),
        ({"discount": 1.0}, r"discount is 1.0*, must lie within \(0, 1\)"),
        ({"discount": float("nan")}, "discount"),
        ({"sweeps": 0}, "sweeps"),
        ({"initial_value": float("inf")}, "initial_value"),
    ],
)
def test_a_config_out_of_bounds_is_refused(values: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        QLearningConfig(**values)  # type: ignore[arg-type]


def test_configs_survive_pickling() -> None:
    config = QLearningConfig(learning_rate=0.5, discount=0.8, sweeps=7, initial_value=-3, blocked=False)
    again = pickle.loads(pickle.dumps(config))
    assert (again.learning_rate, again.discount, again.sweeps) == (0.5, 0.8, 7)
    assert (again.initial_value, again.blocked) == (-3, False)
    reward = pickle.loads(pickle.dumps(HeatmapRewardConfig(obstacle=-5, border=-2)))
    assert (reward.obstacle, reward.border) == (-5, -2)


def test_the_reward_is_the_heat_framed_by_the_border_with_obstacles_on_top() -> None:
    heat, blocked = heatmap_scene(2)
    blocked[0, :5] = True
    wanted = np.full_like(heat, -100)
    wanted[1:-1, 1:-1] = heat[1:-1, 1:-1]
    wanted[blocked] = -30
    np.testing.assert_array_equal(heatmap_reward(heat, blocked, HeatmapRewardConfig(obstacle=-30)), wanted)


@pytest.mark.parametrize("wrong", [np.nan, -0.1, 1.01, np.inf])
def test_heat_outside_the_unit_interval_is_refused(wrong: float) -> None:
    heat = np.zeros((4, 5), np.float32)
    heat[1, 1] = wrong
    with pytest.raises(ValueError, match=r"heatmap holds values outside \[0, 1\] or NaN"):
        heatmap_reward(heat, np.zeros((4, 5), bool))


def test_shapes_that_differ_are_refused() -> None:
    with pytest.raises(ValueError, match=r"blocked is 5 x 4, must be 4 x 5"):
        heatmap_reward(np.zeros((4, 5), np.float32), np.zeros((5, 4), bool))
    with pytest.raises(ValueError, match="at least 1 x 1"):
        heatmap_reward(np.zeros((0, 5), np.float32), np.zeros((0, 5), bool))
