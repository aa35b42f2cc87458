"""The user heatmap of Sec. 4.4.2 from a known orientation, against the same in NumPy (float32); one thread each.

Run: python benchmarks/bench_user_heatmap.py
"""

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lfdcore.planning import MovementTemplate, OrientationMoments, joystick_orientation, user_heatmap

Float = NDArray[np.float32]


def numpy_heatmap(movement: MovementTemplate, orientation: OrientationMoments) -> tuple[Float, Float]:
    """Eq. 4.3 with a wrapped difference, and the product with the distance filter, scaled."""
    error = np.float32(orientation.mean) - movement.orientation
    error -= np.float32(2 * np.pi) * np.round(error / np.float32(2 * np.pi))
    peak = np.float32(1 / np.sqrt(2 * np.pi * orientation.variance))
    density = peak * np.exp(error * error * np.float32(-0.5 / orientation.variance))
    filtered = density * movement.distance_filter
    return density, filtered / filtered.max()


def interleaved(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, NDArray[np.float64]]:
    """Median wall and processor time [ms] of each."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            wall, processor = time.perf_counter(), time.process_time()
            run()
            times[name].append((time.perf_counter() - wall, time.process_time() - processor))
    return {name: 1e3 * np.median(taken, axis=0) for name, taken in times.items()}


def main() -> None:
    begin = time.perf_counter()
    movement = MovementTemplate()
    print(f"Movement template: built once in {1e3 * (time.perf_counter() - begin):.0f} ms")
    orientation = joystick_orientation(mean=(0.8, 0.3), variance=(0.01, 0.02))
    assert orientation is not None
    found, (density, heatmap) = user_heatmap(movement, orientation), numpy_heatmap(movement, orientation)
    np.testing.assert_allclose(found.density, density, rtol=2e-4, atol=1e-6)
    np.testing.assert_allclose(found.heatmap, heatmap, rtol=2e-4, atol=1e-6)
    times = interleaved(
        {
            "numpy": lambda: numpy_heatmap(movement, orientation),
            "lfdcore": lambda: user_heatmap(movement, orientation),
        },
        rounds=501,
    )
    print("User heatmap, 100 x 100 cells, single precision, threads=1, median of 501:")
    for name, (wall, processor) in times.items():
        print(f"  {name:8s} {wall:8.4f} ms wall  {processor:8.4f} ms processor")
    wall, processor = times["numpy"] / times["lfdcore"]
    print(f"  numpy / lfdcore: {wall:.1f} x wall, {processor:.1f} x processor")


if __name__ == "__main__":
    main()
