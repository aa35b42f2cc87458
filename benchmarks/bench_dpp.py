"""Dynamic policy programming on 100 x 100 x 9 against the same recursion as a numba loop; one thread each.

Also prints how often plans in random contexts reach the goal, by the number of sweeps.
Run: python benchmarks/bench_dpp.py [--contexts N]
"""

import argparse
import math
import time
from collections.abc import Callable

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from lfdcore.grid import OccupancyGrid
from lfdcore.planning import (
    DppConfig,
    DppSolver,
    GridMdp,
    PathOutcome,
    baseline_preference,
    greedy_path,
    path_cells,
    path_reward,
)

SIZE = 100
CENTRE = (SIZE // 2, SIZE // 2)


@numba.njit  # type: ignore[misc]
def boltzmann_means(psi, available, eta, mean):  # type: ignore[no-untyped-def]
    """D.8, max-subtracted."""
    for y in range(psi.shape[0]):
        for x in range(psi.shape[1]):
            top = -np.inf
            for a in range(9):
                if available[y, x, a]:
                    top = max(top, psi[y, x, a])
            total = weighted = 0.0
            for a in range(9):
                if available[y, x, a]:
                    weight = math.exp(eta * (psi[y, x, a] - top))
                    total += weight
                    weighted += weight * psi[y, x, a]
            mean[y, x] = weighted / total if total > 0 else 0.0


@numba.njit  # type: ignore[misc]
def numba_dpp(reward, available, discount, eta, sweeps):  # type: ignore[no-untyped-def]
    """D.7 on (s, a) as it is printed."""
    height, width = reward.shape
    psi = np.zeros((height, width, 9))
    mean = np.zeros((height, width))
    for _ in range(sweeps):
        boltzmann_means(psi, available, eta, mean)
        for y in range(height):
            for x in range(width):
                for a in range(9):
                    v, u = y + a // 3 - 1, x + a % 3 - 1
                    if v < 0 or u < 0 or v >= height or u >= width:
                        v, u = y, x
                    psi[y, x, a] += reward[v, u] + discount * mean[v, u] - mean[y, x]
    return psi


Context = tuple[GridMdp, NDArray[np.int32], tuple[int, int]]


def random_obstacles(rng: np.random.Generator) -> NDArray[np.bool_]:
    """Boxes and thin walls inflated by 7 cells, the patch under the chair's axle left free."""
    hits = np.zeros((SIZE, SIZE), bool)
    for _ in range(rng.integers(1, 7)):
        x, y = rng.integers(5, SIZE - 5, 2)
        w, h = rng.permutation([rng.integers(1, 30), rng.integers(1, 4)])
        hits[y : y + h, x : x + w] = True
    yy, xx = np.mgrid[:SIZE, :SIZE]
    from_centre = np.hypot(xx - CENTRE[0], yy - CENTRE[1])
    hits &= from_centre > 12
    return (distance_transform_edt(~hits) <= 7) & (from_centre > 4) if hits.any() else hits


def random_context(rng: np.random.Generator) -> Context | None:
    """A bent path to a goal 1 to 2.3 m ahead among random obstacles; None where no free way leads there."""
    occupied = random_obstacles(rng)
    angle, length, bend = rng.uniform(-1.4, 1.4), rng.uniform(1.0, 2.3), rng.uniform(-0.4, 0.4)
    along = np.linspace(0, 1, 50)[:, None]
    ahead = np.array([math.cos(angle), math.sin(angle)])
    path = length * (along * ahead + bend * along * (1 - along) * np.array([-ahead[1], ahead[0]]))
    cells = path_cells(path, OccupancyGrid(np.zeros((SIZE, SIZE), np.int8), 0.05, (-2.5, -2.5)))
    goal = (int(cells[-1, 0]), int(cells[-1, 1]))
    regions, _ = label(~occupied)
    if occupied[goal[1], goal[0]] or regions[goal[1], goal[0]] != regions[CENTRE[1], CENTRE[0]]:
        return None
    return GridMdp(path_reward(occupied, cells), occupied), cells, goal


def contexts(count: int, seed: int) -> list[Context]:
    rng = np.random.default_rng(seed)
    found: list[Context] = []
    while len(found) < count:
        context = random_context(rng)
        if context is not None:
            found.append(context)
    return found


def interleaved(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, NDArray[np.float64]]:
    """Median wall and processor time [ms] of each."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            wall, processor = time.perf_counter(), time.process_time()
            run()
            times[name].append((time.perf_counter() - wall, time.process_time() - processor))
    return {name: 1e3 * np.median(taken, axis=0) for name, taken in times.items()}


def compare(context: Context, sweeps: int) -> None:
    mdp, cells, goal = context
    config = DppConfig(sweeps=sweeps)
    solver = DppSolver(config)
    result = solver.solve(mdp)
    available = np.isfinite(result.preferences())
    baseline = baseline_preference(cells, (SIZE, SIZE))

    def rival() -> NDArray[np.float64]:
        psi: NDArray[np.float64] = numba_dpp(mdp.reward, available, config.discount, config.inverse_temperature, sweeps)
        return psi

    scale = np.abs(rival()[available]).max()
    # D.8 is no contraction: in some scenes the rounding of one sweep grows a million times until K = 100.
    np.testing.assert_allclose(result.preferences()[available], rival()[available], rtol=0, atol=1e-7 * scale)
    times = interleaved(
        {
            "numba": rival,
            "lfdcore": lambda: solver.solve(mdp),
            "lfdcore, path as Psi_0": lambda: solver.solve(mdp, baseline),
            "lfdcore, greedy path": lambda: greedy_path(result, CENTRE, goal),
        },
        rounds=9,
    )
    for name, (wall, processor) in times.items():
        print(f"  K = {sweeps:3d}  {name:24s} {wall:8.3f} ms wall  {processor:8.3f} ms processor")
    wall, processor = times["numba"] / times["lfdcore"]
    print(f"  K = {sweeps:3d}  numba / lfdcore: {wall:.1f} x wall, {processor:.1f} x processor")


def reach(problems: list[Context]) -> None:
    print(f"Goal reached in {len(problems)} random contexts that have a way (obstacles grown by 7 cells, blocked):")
    for sweeps in (50, 99, 100, 150, 200, 300, 500, 1000):
        solver = DppSolver(DppConfig(sweeps=sweeps))
        goals = sum(
            greedy_path(solver.solve(mdp), CENTRE, goal).outcome == PathOutcome.goal for mdp, _, goal in problems
        )
        print(f"  {sweeps:4d} sweeps: {100 * goals / len(problems):5.1f} %")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contexts", type=int, default=300)
    problems = contexts(parser.parse_args().contexts, seed=0)
    print(f"DPP on {SIZE} x {SIZE} cells x 9 actions, double precision, threads=1, median of 9:")
    for sweeps in (100, 300):
        compare(problems[0], sweeps)
    reach(problems)


if __name__ == "__main__":
    main()
