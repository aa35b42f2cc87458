"""Q-learning on 100 x 100 x 9, K = 100, against the same recursion as a numba loop over Q(s, a); one thread each.

Also prints how often the greedy path is the exact optimum's, and the heat at its end, by discount and sweeps.
Run: python benchmarks/bench_q_learning.py [--heatmaps N]
"""

import argparse
import time
from collections.abc import Callable

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from lfdcore.planning import GridMdp, QLearningConfig, QLearningSolver, greedy_path, heatmap_reward

SIZE = 100
CENTRE = (SIZE // 2, SIZE // 2)


@numba.njit  # type: ignore[misc]
def numba_q_learning(reward, available, alpha, gamma, sweeps, initial):  # type: ignore[no-untyped-def]
    """D.1 on (s, a), synchronous, with max_a Q(s', a) taken once a state."""
    height, width = reward.shape
    q = np.full((height, width, 9), initial)
    best = np.empty((height, width))
    for _ in range(sweeps):
        for y in range(height):
            for x in range(width):
                top = -np.inf
                for a in range(9):
                    if available[y, x, a]:
                        top = max(top, q[y, x, a])
                best[y, x] = top
        for y in range(height):
            for x in range(width):
                for a in range(9):
                    v, u = y + a // 3 - 1, x + a % 3 - 1
                    if v < 0 or u < 0 or v >= height or u >= width:
                        v, u = y, x
                    q[y, x, a] += alpha * (reward[v, u] + gamma * best[v, u] - q[y, x, a])
    return q


def random_mdp(rng: np.random.Generator) -> GridMdp:
    """Heat of a few soft ways and blobs, among inflated walls; the patch under the chair's axle left free."""
    yy, xx = np.mgrid[:SIZE, :SIZE]
    heat = np.zeros((SIZE, SIZE))
    for _ in range(rng.integers(2, 6)):
        x, y = rng.uniform(5, SIZE - 5, 2)
        spread = rng.uniform(3, 15)
        heat += rng.uniform(0.2, 1) * np.exp(-((xx - x) ** 2 + (yy - y) ** 2) / (2 * spread**2))
    hits = np.zeros((SIZE, SIZE), bool)
    for _ in range(rng.integers(1, 6)):
        x, y = rng.integers(5, SIZE - 5, 2)
        w, h = rng.permutation([rng.integers(1, 30), rng.integers(1, 4)])
        hits[y : y + h, x : x + w] = True
    from_centre = np.hypot(xx - CENTRE[0], yy - CENTRE[1])
    hits &= from_centre > 12
    blocked = (distance_transform_edt(~hits) <= 7) & (from_centre > 4) if hits.any() else hits
    heatmap = (heat / heat.max()).astype(np.float32)
    return GridMdp(heatmap_reward(heatmap, blocked), blocked)


def interleaved(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, NDArray[np.float64]]:
    """Median wall and processor time [ms] of each."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            wall, processor = time.perf_counter(), time.process_time()
            run()
            times[name].append((time.perf_counter() - wall, time.process_time() - processor))
    return {name: 1e3 * np.median(taken, axis=0) for name, taken in times.items()}


def compare(mdp: GridMdp, config: QLearningConfig) -> None:
    solver = QLearningSolver(config)
    result = solver.solve(mdp)
    available = np.isfinite(result.action_values())

    def rival() -> NDArray[np.float64]:
        q: NDArray[np.float64] = numba_q_learning(
            mdp.reward, available, config.learning_rate, config.discount, config.sweeps, config.initial_value
        )
        return q

    np.testing.assert_allclose(result.action_values()[available], rival()[available], rtol=0, atol=1e-10)
    times = interleaved(
        {
            "numba": rival,
            "lfdcore": lambda: solver.solve(mdp),
            "lfdcore, greedy path": lambda: greedy_path(result, CENTRE),
        },
        rounds=21,
    )
    for name, (wall, processor) in times.items():
        print(f"  K = {config.sweeps:3d}  {name:22s} {wall:8.3f} ms wall  {processor:8.3f} ms processor")
    wall, processor = times["numba"] / times["lfdcore"]
    print(f"  K = {config.sweeps:3d}  numba / lfdcore: {wall:.1f} x wall, {processor:.1f} x processor")


def quality(problems: list[GridMdp]) -> None:
    print(f"Greedy paths in {len(problems)} random heatmaps (optimum: 20 000 sweeps with learning rate 1):")
    for discount in (0.9, 0.95, 0.99):
        exact = QLearningSolver(QLearningConfig(learning_rate=1, discount=discount, sweeps=20000, initial_value=0))
        optima = [greedy_path(exact.solve(mdp), CENTRE).cells for mdp in problems]
        for sweeps in (99, 100, 300):
            solver = QLearningSolver(QLearningConfig(discount=discount, sweeps=sweeps))
            paths = [greedy_path(solver.solve(mdp), CENTRE).cells for mdp in problems]
            same = np.mean([np.array_equal(path, best) for path, best in zip(paths, optima, strict=True)])
            heat = np.mean([mdp.reward[path[-1, 1], path[-1, 0]] for mdp, path in zip(problems, paths, strict=True)])
            print(
                f"  gamma {discount}  {sweeps:3d} sweeps: {100 * same:5.1f} % the optimum's, heat at the end {heat:.2f}"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--heatmaps", type=int, default=20)
    count = parser.parse_args().heatmaps
    rng = np.random.default_rng(0)
    problems = [random_mdp(rng) for _ in range(count)]
    print(f"Q-learning on {SIZE} x {SIZE} cells x 9 actions, double precision, threads=1, median of 21:")
    compare(problems[0], QLearningConfig())
    quality(problems)


if __name__ == "__main__":
    main()
