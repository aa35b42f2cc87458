"""Hybrid A*: laws of the path, doors passed, outcomes and refusals."""

import pickle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import ObstaclePoints
from lfdcore.planning import HybridAstar, HybridAstarConfig, HybridAstarResult, solve_hybrid_astar

FloatArray = NDArray[np.float64]
CHAIR = Footprint()


def wall(a: tuple[float, float], b: tuple[float, float], spacing: float = 0.05) -> FloatArray:
    """Points along a segment, `spacing` or less apart."""
    count = int(np.ceil(np.hypot(b[0] - a[0], b[1] - a[1]) / spacing)) + 1
    return np.linspace(a, b, count)


def room(half: float = 3.2) -> FloatArray:
    """A closed square room around the origin."""
    corners = [(-half, -half), (half, -half), (half, half), (-half, half), (-half, -half)]
    return np.vstack([wall(a, b) for a, b in pairwise(corners)])


def door(width: float = 0.9, thickness: float = 0.1) -> FloatArray:
    """A room divided at x = 0 by a wall with a door in its middle."""
    sides = [room()]
    for sign in (1, -1):
        jamb, end = sign * width / 2, sign * 3.2
        sides += [wall((x, jamb), (x, end)) for x in (0.0, thickness)] + [wall((0, jamb), (thickness, jamb))]
    return np.vstack(sides)


def skewed_starts(count: int, obstacles: ObstaclePoints, seed: int) -> list[Pose2]:
    """Free starts 1-2.4 m before the door, bearing within 30 and heading within 60 degrees."""
    rng = np.random.default_rng(seed)
    starts: list[Pose2] = []
    while len(starts) < count:
        distance, bearing = rng.uniform(1, 2.4), np.radians(rng.uniform(-30, 30))
        yaw = np.radians(rng.uniform(-60, 60))
        pose = Pose2(-distance * np.cos(bearing), -distance * np.sin(bearing), yaw)
        if not obstacles.collides(pose, CHAIR.grown(0.04)):
            starts.append(pose)
    return starts


def dense(path: FloatArray, parts: int = 10) -> FloatArray:
    """The path's poses with `parts` between neighbours, straight in position and in the nearest yaw."""
    step = np.diff(path, axis=0)
    step[:, 2] = np.remainder(step[:, 2] + np.pi, 2 * np.pi) - np.pi
    between = path[:-1, None] + np.linspace(0, 1, parts, endpoint=False)[None, :, None] * step[:, None]
    return np.vstack([between.reshape(-1, 3), path[-1:]])


def assert_free(result: HybridAstarResult, obstacles: ObstaclePoints) -> None:
    # Between rows the arc bulges off the chord by less than 1 mm (0.05 m at 2.2 1/m).
    body = CHAIR.grown(max(0.0, result.margin - 0.001))
    assert not any(obstacles.collides(Pose2(*pose), body) for pose in dense(np.asarray(result.path)))


@pytest.mark.parametrize("margin", [0.015, 0.04])
def test_a_door_of_90_cm_is_passed_from_100_skewed_starts_without_touching_it(margin: float) -> None:
    points = door()
    obstacles = ObstaclePoints(points)
    planner = HybridAstar(CHAIR, config=HybridAstarConfig(margin=margin))
    found = 0
    for start in skewed_starts(100, obstacles, seed=1):
        result = planner.solve(obstacles, start, (1.0, 0.0))
        found += result.found
        if result.found:
            assert result.margin == margin
            assert result.expansions <= 2500
            assert np.hypot(*(result.path[-1, :2] - (1.0, 0.0))) <= 0.15
            np.testing.assert_allclose(result.path[0], [*start], atol=1e-12)
            assert_free(result, obstacles)
    assert found == 100 if margin < 0.04 else found >= 98


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), reverse=st.booleans(), scattered=st.integers(0, 40))
def test_no_path_among_scattered_points_ever_touches_one(seed: int, reverse: bool, scattered: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = ObstaclePoints(np.vstack([room(), rng.uniform(-3, 3, (scattered, 2))]))
    config = HybridAstarConfig(allow_reverse=reverse, max_expansions=800)
    start = Pose2(*rng.uniform(-1, 1, 2), rng.uniform(-np.pi, np.pi))
    result = solve_hybrid_astar(obstacles, CHAIR, start, rng.uniform(-2, 2, 2), config)
    assert result.found == (result.outcome == "found") == (len(result.path) > 0)
    if obstacles.collides(start, CHAIR):
        assert result.outcome == "start_blocked"
    if not result.found:
        return
    path = np.asarray(result.path)
    steps = np.diff(path, axis=0)
    turned = np.abs(np.remainder(steps[:, 2] + np.pi, 2 * np.pi) - np.pi)
    assert np.all(np.hypot(steps[:, 0], steps[:, 1]) <= 0.05 + 1e-9)
    assert np.all(turned <= 0.11 + 1e-9)
    ahead = steps[:, 0] * np.cos(path[:-1, 2]) + steps[:, 1] * np.sin(path[:-1, 2])
    assert reverse or np.all(ahead >= -1e-9)
    assert_free(result, obstacles)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_mirrored_problem_has_the_mirrored_cost(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.vstack([room(), rng.uniform(-2.5, 2.5, (8, 2))])
    goal, mirror = rng.uniform(-2, 2, 2), np.array([1.0, -1.0])
    yaw = rng.uniform(-np.pi, np.pi)
    config = HybridAstarConfig(eagerness=1.0, max_expansions=20000)
    one = solve_hybrid_astar(ObstaclePoints(points), CHAIR, Pose2(0, 0, yaw), goal, config)
    other = solve_hybrid_astar(ObstaclePoints(points * mirror), CHAIR, Pose2(0, 0, -yaw), goal * mirror, config)
    assert one.outcome == other.outcome
    # Ties between equally cheap nodes of a cell may fall otherwise, which shifts later poses within their cells.
    assert other.cost == pytest.approx(one.cost, rel=0.03, abs=0.05)


def test_eagerness_costs_at_most_its_factor_and_expands_less() -> None:
    obstacles = ObstaclePoints(door())
    start, goal = Pose2(-2.0, 0.8, 0.3), (1.2, 0.0)
    careful = solve_hybrid_astar(obstacles, CHAIR, start, goal, HybridAstarConfig(eagerness=1, max_expansions=200000))
    eager = solve_hybrid_astar(obstacles, CHAIR, start, goal, HybridAstarConfig(max_expansions=200000))
    assert careful.found
    assert eager.found
    assert eager.expansions < careful.expansions
    assert 0.95 * careful.cost <= eager.cost <= 2 * careful.cost


def test_in_the_open_the_way_ahead_is_straight_and_costs_its_length() -> None:
    result = solve_hybrid_astar(ObstaclePoints(np.zeros((0, 2))), CHAIR, Pose2(), (2.0, 0.0))
    assert result.found
    np.testing.assert_allclose(result.path[:, 1:], 0, atol=1e-12)
    assert result.cost == pytest.approx(result.path[-1, 0])
    assert 1.85 <= result.cost <= 2.0


def test_the_middle_of_a_wide_gap_is_preferred_to_its_edge() -> None:
    walls = np.vstack([wall((0.5, 0.5), (3, 0.5)), wall((0.5, -0.9), (3, -0.9))])
    result = solve_hybrid_astar(ObstaclePoints(walls), CHAIR, Pose2(-0.8, 0, 0), (2.4, 0.0))
    inside = result.path[(result.path[:, 0] > 1.0) & (result.path[:, 0] < 2.0), 1]
    assert np.all(inside < -0.05)  # the middle is at -0.2; the goal at 0, 0.15 from the nearer wall's reach


def test_the_final_heading_is_kept_where_asked_for() -> None:
    result = solve_hybrid_astar(
        ObstaclePoints(room()), CHAIR, Pose2(), (1.5, 0.0), HybridAstarConfig(heading_tolerance=0.15), goal_heading=1.5
    )
    assert result.found
    assert abs(result.path[-1, 2] - 1.5) <= 0.15


def test_only_with_reverse_a_dead_end_too_narrow_to_turn_is_left() -> None:
    garage = np.vstack([wall((1, 0.5), (-1, 0.5)), wall((1, -0.5), (-1, -0.5)), wall((1, 0.5), (1, -0.5))])
    backwards = HybridAstarConfig(allow_reverse=True, max_expansions=20000)
    ahead = HybridAstarConfig(max_expansions=20000)
    assert solve_hybrid_astar(ObstaclePoints(garage), CHAIR, Pose2(), (-2, 0), backwards).found
    assert solve_hybrid_astar(ObstaclePoints(garage), CHAIR, Pose2(), (-2, 0), ahead).outcome == "no_path"


def test_a_closed_wall_gives_no_path_without_a_search() -> None:
    result = solve_hybrid_astar(ObstaclePoints(door(width=0.0)), CHAIR, Pose2(-1.5, 0, 0), (1.5, 0.0))
    assert (result.outcome, result.expansions, len(result.path)) == ("no_path", 0, 0)


def test_a_gap_narrower_than_the_chair_gives_no_path() -> None:
    config = HybridAstarConfig(max_expansions=200000)
    obstacles = ObstaclePoints(door(width=0.74))
    assert solve_hybrid_astar(obstacles, CHAIR, Pose2(-1.5, 0, 0), (1.5, 0.0), config).outcome == "no_path"


def test_a_blocked_start_a_blocked_goal_and_a_spent_budget_are_distinguished() -> None:
    obstacles = ObstaclePoints(np.vstack([door(), wall((1.0, 1.0), (2.0, 2.0))]))
    assert solve_hybrid_astar(obstacles, CHAIR, Pose2(-0.2, 0.6, 0), (1.2, 0.0)).outcome == "start_blocked"
    assert solve_hybrid_astar(obstacles, CHAIR, Pose2(-1.5, 0, 0), (1.5, 1.5)).outcome == "goal_blocked"
    few = HybridAstarConfig(max_expansions=5)
    spent = solve_hybrid_astar(obstacles, CHAIR, Pose2(-1.5, 0.5, 1.0), (1.2, 0.0), few)
    assert (spent.outcome, spent.expansions) == ("expansion_limit", 5)


def test_beside_a_wall_the_margin_shrinks_to_half_of_what_is_free() -> None:
    obstacles = ObstaclePoints(wall((-1, 0.37), (3, 0.37)))
    result = solve_hybrid_astar(obstacles, CHAIR, Pose2(), (2.0, -0.5))
    assert result.found
    assert result.margin == pytest.approx(0.01, abs=1e-4)
    assert_free(result, obstacles)


def test_at_the_goal_already_the_path_is_the_start() -> None:
    result = solve_hybrid_astar(ObstaclePoints(room()), CHAIR, Pose2(0.1, 0, 7.0), (0.0, 0.0))
    assert (result.outcome, result.cost, len(result.path)) == ("found", 0.0, 1)
    assert result.path[0, 2] == pytest.approx(7.0 - 2 * np.pi)


def test_a_planner_used_again_answers_as_a_fresh_one() -> None:
    planner, obstacles = HybridAstar(CHAIR), ObstaclePoints(door())
    for start in skewed_starts(5, obstacles, seed=2):
        again, fresh = (
            planner.solve(obstacles, start, (1.2, 0.0)),
            solve_hybrid_astar(obstacles, CHAIR, start, (1.2, 0.0)),
        )
        assert again.cost == fresh.cost
        np.testing.assert_array_equal(again.path, fresh.path)


def test_moving_the_whole_problem_by_a_whole_cell_moves_the_path() -> None:
    obstacles, moved = ObstaclePoints(door()), ObstaclePoints(door() + np.array([64.0, -32.0]))
    here = solve_hybrid_astar(obstacles, CHAIR, Pose2(-1.5, 0.5, 0.4), (1.2, 0.0))
    there = solve_hybrid_astar(moved, CHAIR, Pose2(62.5, -31.5, 0.4), (65.2, -32.0))
    assert there.cost == pytest.approx(here.cost, rel=0.02)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("margin", -0.01),
        ("margin", np.nan),
        ("goal_tolerance", 0.0),
        ("window", 100.0),
        ("max_expansions", 0),
        ("eagerness", 0.5),
        ("comfort", 0.0),
        ("turn_cost", np.inf),
    ],
)
def test_a_bad_setting_is_refused_by_name(field: str, value: float) -> None:
    with pytest.raises(ValueError, match=field):
        HybridAstarConfig(**{field: value})


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_refused(bad: float) -> None:
    none = ObstaclePoints(np.zeros((0, 2)))
    with pytest.raises(ValueError, match=r"start\.x"):
        solve_hybrid_astar(none, CHAIR, Pose2(bad, 0, 0), (1, 0))
    with pytest.raises(ValueError, match="goal"):
        solve_hybrid_astar(none, CHAIR, Pose2(), (1, bad))
    with pytest.raises(ValueError, match="goal_heading"):
        solve_hybrid_astar(none, CHAIR, Pose2(), (1, 0), goal_heading=bad)
    with pytest.raises(ValueError, match=r"footprint\.half_width"):
        solve_hybrid_astar(none, Footprint(half_width=bad), Pose2(), (1, 0))


def test_a_goal_outside_the_window_is_refused_with_the_bound() -> None:
    with pytest.raises(ValueError, match=r"goal x from the start is 4 m, must be between -3.5 and 3.5"):
        solve_hybrid_astar(ObstaclePoints(np.zeros((0, 2))), CHAIR, Pose2(), (4, 0))


def test_the_config_survives_pickling() -> None:
    config = pickle.loads(pickle.dumps(HybridAstarConfig(margin=0.02, allow_reverse=True, eagerness=1.25)))
    assert (config.margin, config.allow_reverse, config.eagerness) == (0.02, True, 1.25)
    assert config.max_expansions == HybridAstarConfig().max_expansions
