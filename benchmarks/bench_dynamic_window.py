"""The dynamic window against the same algorithm in numba; then what a supervisor call costs.

20 x 20 twists x 34 steps, obstacles as points (no distance field on either side), footprint tested exactly. Two rivals:
`numba` is Alg. 8 as printed (every twist), with an early exit at the first touching point; `numba, cheapest first`
also sorts the twists by cost and takes the first free one, as lfdcore does. Both see only the points within reach,
as lfdcore does. threads=1.

    python benchmarks/bench_dynamic_window.py
"""

import math
import statistics
import time
from collections.abc import Callable

import numba
import numpy as np

from lfdcore.control import DynamicWindowConfig, Supervisor, solve_dynamic_window
from lfdcore.geometry import Footprint, MotionLimits, Twist2, approach
from lfdcore.grid import ObstaclePoints

LINEAR, ANGULAR, STEPS, STEP = 20, 20, 34, 0.1
PERIOD = 0.1
"""[s] between two commands: the window is what the accelerations reach in it"""
ROUNDS = 15


@numba.njit(cache=False)
def hits(v, w, points, front, rear, half_width, steps, step):
    for k in range(1, steps + 1):
        t = k * step
        half = 0.5 * w * t
        chord = v * t * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
        x, y = chord * math.cos(half), chord * math.sin(half)
        c, s = math.cos(w * t), math.sin(w * t)
        for i in range(points.shape[0]):
            dx, dy = points[i, 0] - x, points[i, 1] - y
            bx, by = c * dx + s * dy, c * dy - s * dx
            if -rear <= bx <= front and -half_width <= by <= half_width:
                return True
    return False


@numba.njit(cache=False)
def within(points, radius):
    near = np.empty_like(points)
    n = 0
    for i in range(points.shape[0]):
        if points[i, 0] ** 2 + points[i, 1] ** 2 <= radius**2:
            near[n] = points[i]
            n += 1
    return near[:n]


@numba.njit(cache=False)
def end_costs(linear, angular, goal, steps, step):
    cost = np.empty(linear.size * angular.size)
    for i in range(linear.size):
        for j in range(angular.size):
            half = 0.5 * angular[j] * steps * step
            chord = linear[i] * steps * step * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
            cost[i * angular.size + j] = math.hypot(chord * math.cos(half) - goal[0], chord * math.sin(half) - goal[1])
    return cost


@numba.njit(cache=False)
def numba_printed(linear, angular, goal, points, front, rear, half_width, steps, step):
    reach = max(abs(linear[0]), abs(linear[-1])) * steps * step + math.hypot(max(front, rear), half_width)
    near = within(points, reach)
    cost = end_costs(linear, angular, goal, steps, step)
    best, best_cost = -1, math.inf
    for n in range(cost.size):
        v, w = linear[n // angular.size], angular[n % angular.size]
        if not hits(v, w, near, front, rear, half_width, steps, step) and cost[n] < best_cost:
            best, best_cost = n, cost[n]
    return best, best_cost


@numba.njit(cache=False)
def numba_cheapest_first(linear, angular, goal, points, front, rear, half_width, steps, step):
    reach = max(abs(linear[0]), abs(linear[-1])) * steps * step + math.hypot(max(front, rear), half_width)
    near = within(points, reach)
    cost = end_costs(linear, angular, goal, steps, step)
    for n in np.argsort(cost):
        v, w = linear[n // angular.size], angular[n % angular.size]
        if not hits(v, w, near, front, rear, half_width, steps, step):
            return n, cost[n]
    return -1, math.inf


def corridor(width: float, seed: int, count: int = 800) -> np.ndarray:
    """`count` points [m] on two walls `width` apart, a wall 3 m ahead, 1 cm noise."""
    rng = np.random.default_rng(seed)
    along = rng.uniform(-3, 3, count)
    side = rng.integers(0, 3, count)
    points = np.column_stack([along, np.where(side == 0, width / 2, -width / 2)])
    points[side == 2] = np.column_stack([np.full(count, 3.0), along / 3 * width / 2])[side == 2]
    return points + rng.normal(0, 0.01, points.shape)


def blocked(seed: int) -> np.ndarray:
    """A box around the chair .06 m beyond its footprint: no twist of the window is free for 3.4 s."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-0.41, 0.86, 400), rng.uniform(-0.41, 0.41, 400)
    sides = [np.column_stack([x[:200], np.full(200, 0.41)]), np.column_stack([x[200:], np.full(200, -0.41)])]
    ends = [np.column_stack([np.full(200, 0.86), y[:200]]), np.column_stack([np.full(200, -0.41), y[200:]])]
    return np.vstack(sides + ends)


def seconds(call: Callable[[], object], repeats: int) -> float:
    start = time.perf_counter()
    for _ in range(repeats):
        call()
    return (time.perf_counter() - start) / repeats


def compare(name: str, points: np.ndarray, twist: Twist2, goal: np.ndarray) -> None:
    limits, foot = MotionLimits(), Footprint()
    config = DynamicWindowConfig(linear_samples=LINEAR, angular_samples=ANGULAR, horizon=STEPS * STEP, step=STEP)
    low = approach(twist, Twist2(-limits.max_reverse, -limits.max_angular), limits, PERIOD)
    high = approach(twist, Twist2(limits.max_linear, limits.max_angular), limits, PERIOD)
    linear, angular = np.linspace(low.linear, high.linear, LINEAR), np.linspace(low.angular, high.angular, ANGULAR)
    obstacles = ObstaclePoints(points)
    rest = (linear, angular, goal, points, foot.front, foot.rear, foot.half_width, STEPS, STEP)
    runs: dict[str, Callable[[], object]] = {
        "lfdcore": lambda: solve_dynamic_window(twist, goal, obstacles, foot, limits, config, period=PERIOD),
        "numba": lambda: numba_printed(*rest),
        "numba, cheapest first": lambda: numba_cheapest_first(*rest),
    }
    ours = solve_dynamic_window(twist, goal, obstacles, foot, limits, config, period=PERIOD)
    theirs = numba_printed(*rest)
    assert ours.feasible == (theirs[0] >= 0), name
    assert not ours.feasible or abs(ours.cost - theirs[1]) < 1e-9, name
    assert numba_cheapest_first(*rest)[1] == theirs[1], name
    timings: dict[str, list[float]] = {run: [] for run in runs}
    for _ in range(ROUNDS):
        for run, call in runs.items():
            timings[run].append(seconds(call, 5))
    median = {run: statistics.median(values) for run, values in timings.items()}
    print(f"{name}: {len(points)} points, {'free twist found' if ours.feasible else 'all twists collide'}")
    for run, value in median.items():
        print(f"  {run:24s}{value * 1e6:10.1f} us   x {value / median['lfdcore']:.1f}")


def time_supervisor(name: str, points: np.ndarray, wanted: Twist2, current: Twist2) -> None:
    supervisor, obstacles = Supervisor(), ObstaclePoints(points)
    result = supervisor.filter(wanted, current, obstacles)
    median = statistics.median(
        seconds(lambda: supervisor.filter(wanted, current, obstacles), 20) for _ in range(ROUNDS)
    )
    what = "stopped" if result.stopped else f"scale {result.scale:.2f}" if result.changed else "passed"
    print(f"supervisor, {name}: {len(points)} points, {what}: {median * 1e6:.1f} us")


def main() -> None:
    print(
        f"dynamic window, {LINEAR} x {ANGULAR} twists x {STEPS} steps, threads=1, median of {ROUNDS} interleaved rounds"
    )
    compare("open corridor 2.4 m", corridor(2.4, 0), Twist2(0.5, 0.1), np.array([0.8, 0.1]))
    compare("narrow corridor 1.2 m", corridor(1.2, 1), Twist2(0.5, 0.1), np.array([1.5, 0.5]))
    compare("blocked", blocked(2), Twist2(0.6, 0.0), np.array([1.0, 0.0]))
    time_supervisor("open corridor", corridor(2.4, 0), Twist2(0.5, 0.1), Twist2(0.5, 0.1))
    time_supervisor("narrow corridor, steering at the wall", corridor(0.9, 1), Twist2(0.6, 0.4), Twist2(0.5, 0.0))
    time_supervisor("narrow corridor, turning", corridor(0.9, 1), Twist2(0.3, 1.0), Twist2(0.3, 0.0))
    time_supervisor("boxed in", blocked(2), Twist2(0.5, 0.5), Twist2(0.0, 0.0))


if __name__ == "__main__":
    main()
