"""720-beam exact scans in a 2000 x 2000 map, and 181 beams in a 25 x 40 m course: RayCaster against a numba DDA.

The same ranges from both (float32), interleaved in one run, one thread, median of 15. Run: python bench_ray_casting.py
"""

import math
import statistics
import time
from collections.abc import Callable

import numba
import numpy as np
import numpy.typing as npt

from lfdcore.geometry import Pose2
from lfdcore.grid import OccupancyGrid, RayCaster

Mask = npt.NDArray[np.bool_]
Ranges = npt.NDArray[np.float32]
RESOLUTION, RANGE_MAX, POSES, REPEATS = 0.05, 30.0, 50, 15


@numba.njit(cache=False)
def numba_dda(
    occupied: Mask, x: float, y: float, yaw: float, angles: npt.NDArray[np.float64], resolution: float, range_max: float
) -> Ranges:
    """Amanatides & Woo from cell to cell."""
    height, width = occupied.shape
    ranges = np.full(angles.size, np.inf, np.float32)
    for i in range(angles.size):
        dx, dy = math.cos(yaw + angles[i]), math.sin(yaw + angles[i])
        cx, cy = x / resolution, y / resolution
        ix, iy = math.floor(cx), math.floor(cy)
        sx, sy = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
        step_x, step_y = abs(1 / dx) if dx != 0 else np.inf, abs(1 / dy) if dy != 0 else np.inf
        t_x = ((ix + 1 - cx) if dx > 0 else (cx - ix)) * step_x
        t_y = ((iy + 1 - cy) if dy > 0 else (cy - iy)) * step_y
        t, reach = 0.0, range_max / resolution
        while 0 <= ix < width and 0 <= iy < height and t <= reach:
            if occupied[iy, ix]:
                ranges[i] = t * resolution
                break
            if t_x < t_y:
                t, t_x, ix = t_x, t_x + step_x, ix + sx
            else:
                t, t_y, iy = t_y, t_y + step_y, iy + sy
    return ranges


def rooms(height: int, width: int, room: int, seed: int) -> Mask:
    """Rooms with walls 0.1 m thick, doors of 0.9 m and a few pieces of furniture."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros((height, width), bool)
    for k in range(0, max(height, width), room):
        occupied[k : k + 2] = True
        occupied[:, k : k + 2] = True
    occupied[-2:] = occupied[:, -2:] = True
    for y in range(0, height, room):
        for x in range(0, width, room):
            door = rng.integers(4, room - 22, 2)
            if 0 < y < height - room:
                occupied[y : y + 2, x + door[0] : x + door[0] + 18] = False
            if 0 < x < width - room:
                occupied[y + door[1] : y + door[1] + 18, x : x + 2] = False
            for _ in range(3):
                at = rng.integers(4, room - 16, 2)
                occupied[y + at[0] : y + at[0] + 8, x + at[1] : x + at[1] + 12] = True
    return occupied


def free_poses(occupied: Mask, seed: int) -> list[Pose2]:
    rng = np.random.default_rng(seed)
    cells = np.argwhere(~occupied)[rng.integers(0, (~occupied).sum(), POSES)]
    at = (cells[:, ::-1] + rng.uniform(0.1, 0.9, (POSES, 2))) * RESOLUTION
    return [Pose2(x, y, yaw) for (x, y), yaw in zip(at, rng.uniform(-3, 3, POSES), strict=True)]


def seconds_a_scan(cast: Callable[[Pose2], Ranges], poses: list[Pose2]) -> float:
    start = time.perf_counter()
    for pose in poses:
        cast(pose)
    return (time.perf_counter() - start) / len(poses)


def compare(name: str, occupied: Mask, beams: int, field_of_view: float) -> None:
    angles = np.linspace(-field_of_view / 2, field_of_view / 2, beams)
    caster = RayCaster(OccupancyGrid(np.where(occupied, 100, 0).astype(np.int8), RESOLUTION), RANGE_MAX)
    poses = free_poses(occupied, 1)

    def ours(pose: Pose2) -> Ranges:
        return caster.cast(pose, angles)

    def rival(pose: Pose2) -> Ranges:
        return numba_dda(occupied, pose.x, pose.y, pose.yaw, angles, RESOLUTION, RANGE_MAX)

    agree = np.concatenate([np.isclose(ours(p), rival(p), rtol=1e-5, atol=1e-5) for p in poses])
    # A ray within rounding (1e-12 cells) of a corner may pass it on either side.
    assert agree.mean() > 1 - 1e-4, f"{(~agree).sum()} of {agree.size} ranges differ"
    times = [(seconds_a_scan(ours, poses), seconds_a_scan(rival, poses)) for _ in range(REPEATS)]
    mine, theirs = (statistics.median(column) for column in zip(*times, strict=True))
    print(
        f"{name}: {occupied.shape[1]} x {occupied.shape[0]} cells, {beams} beams, threads=1: "
        f"RayCaster {mine * 1e6:.1f} us, numba DDA {theirs * 1e6:.1f} us, ratio {theirs / mine:.2f}; "
        f"{(~agree).sum()} of {agree.size} ranges differ"
    )


if __name__ == "__main__":
    compare("large map of rooms", rooms(2000, 2000, 100, 0), 720, 2 * math.pi)
    compare("large map of halls", rooms(2000, 2000, 400, 0), 720, 2 * math.pi)
    compare("course", rooms(500, 800, 100, 0), 181, math.pi)
    compare("clutter", np.random.default_rng(0).random((2000, 2000)) < 0.002, 720, 2 * math.pi)
