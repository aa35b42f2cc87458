"""Dynamic time warping of 500 x 500 samples against dtaidistance's C, in 1, 6 and 3 dimensions; open-end steps.

Both sum Euclidean distances; theirs without pruning, since ours bounds nothing either. One thread each; times are
of the process, interleaved, medians. Run: python benchmarks/bench_dtw.py [--rounds N]
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
from dtaidistance import dtw as rival
from dtaidistance import dtw_ndim as rival_nd
from numpy.typing import NDArray

from lfdcore.primitives import OpenEndDtw, dtw, dtw_distance

Floats = NDArray[np.float64]
SAMPLES = 500


def seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def interleaved(rounds: int, *works: Callable[[], object]) -> list[float]:
    """Median seconds of each, run in turn."""
    return np.median([[seconds(work) for work in works] for _ in range(rounds)], axis=0).tolist()


def report(what: str, times: list[float], difference: float) -> None:
    ours, theirs = times
    print(
        f"{what:24} lfdcore {ours * 1e6:7.0f} us   dtaidistance {theirs * 1e6:7.0f} us   ratio {theirs / ours:5.1f}   "
        f"largest difference {difference:.1e}"
    )


def compare(dimensions: int, rounds: int) -> None:
    random = np.random.default_rng(dimensions)
    a, b = (np.cumsum(random.normal(size=(SAMPLES, dimensions)), axis=0) for _ in range(2))
    if dimensions == 1:
        a, b, library = a[:, 0].copy(), b[:, 0].copy(), rival
    else:
        library = rival_nd
    _, theirs = library.warping_paths_fast(a, b, inner_dist="euclidean")
    ours = dtw(a, b)
    assert np.allclose(ours.costs, theirs[1:, 1:], rtol=1e-12)
    difference = float(np.abs(ours.costs - theirs[1:, 1:]).max())
    both = (lambda: dtw(a, b), lambda: library.warping_paths_fast(a, b, inner_dist="euclidean"))
    report(f"{dimensions}-D, matrix and path", interleaved(rounds, *both), difference)
    options = {"inner_dist": "euclidean", "use_pruning": False}
    difference = abs(dtw_distance(a, b) - library.distance_fast(a, b, **options))
    assert difference < 1e-9 * dtw_distance(a, b)
    both = (lambda: dtw_distance(a, b), lambda: library.distance_fast(a, b, **options))
    report(f"{dimensions}-D, distance", interleaved(rounds, *both), difference)


def steps(rounds: int) -> None:
    random = np.random.default_rng(0)
    for dimensions in (1, 6, 45):
        reference, query = (np.cumsum(random.normal(size=(SAMPLES, dimensions)), axis=0) for _ in range(2))
        online = OpenEndDtw(reference)

        def follow(online: OpenEndDtw = online, query: Floats = query) -> None:
            for sample in query:
                online.observe(sample)

        took = interleaved(rounds, follow)[0] / SAMPLES
        print(f"open end, {dimensions:2d}-D reference of {SAMPLES}: {took * 1e6:.1f} us a sample")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=31)
    rounds = options.parse_args().rounds
    # glibc keeps blocks smaller than the largest freed so far: else page faults of 2 MB, by chance, drown either.
    large = np.ones(2**21)
    del large
    print(f"{SAMPLES} x {SAMPLES} samples, threads=1, medians of {rounds} rounds")
    for dimensions in (1, 6, 3):
        compare(dimensions, rounds)
    steps(rounds)


if __name__ == "__main__":
    main()
