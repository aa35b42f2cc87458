"""A step of the simulated chair with a scan of 181 beams, against IR-SIM: the same home, chair, route and LIDAR.

Run: python benchmarks/bench_simulator.py (needs ir-sim). IR-SIM gets the home twice: as the occupancy grid that
lfdcore drives in, and, easier for it, as 14 rectangles. One thread each, interleaved, median of 7 runs. All must agree:
poses within 1e-9 m and rad on a route of straight legs and turns on the spot (on arcs they differ, as IR-SIM takes
Euler steps and lfdcore exact ones), each of the 181 ranges within 1e-4 m at every step.
"""

from __future__ import annotations

import argparse
import logging
import os
import statistics
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import cv2
import irsim
import numpy as np
import numpy.typing as npt
import yaml

from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2
from lfdcore.grid import OccupancyGrid
from lfdcore.simulation import ChairConfig, DrivingWorld, LidarConfig

WIDTH, HEIGHT, RESOLUTION = 20.0, 10.0, 0.05
# x0, y0, x1, y1 [m]: outer walls, two partitions with doors of 1.2 m, furniture.
BLOCKS = [
    (0, 0, 20, 0.1),
    (0, 9.9, 20, 10),
    (0, 0.1, 0.1, 9.9),
    (19.9, 0.1, 20, 9.9),
    (7, 0.1, 7.1, 4),
    (7, 5.2, 7.1, 9.9),
    (13, 0.1, 13.1, 4),
    (13, 5.2, 13.1, 9.9),
    (2, 7, 3.5, 8.5),
    (4, 1, 5, 2),
    (9, 1, 11, 2.5),
    (9.5, 7, 10.5, 8),
    (15, 1.5, 17.5, 2.5),
    (16, 7, 17, 9),
]
# Not along an axis: there IR-SIM 2.12 sees a false hit in its grid (one beam, metres too short).
START = (2.0, 4.613, 0.003)
LASER = (0.575, 0.0, 0.0)
LEG = [(0.8, 0.0)] * 100 + [(0.0, 0.4)] * 5 + [(0.4, 0.0)] * 5 + [(0.0, -0.4)] * 5 + [(0.4, 0.0)] * 85


def home() -> npt.NDArray[np.int8]:
    """(height, width) cells, 0 or 100."""
    data = np.zeros((round(HEIGHT / RESOLUTION), round(WIDTH / RESOLUTION)), np.int8)
    for block in BLOCKS:
        x0, y0, x1, y1 = (round(side / RESOLUTION) for side in block)
        data[y0:y1, x0:x1] = 100
    return data


def our_world() -> DrivingWorld:
    # IR-SIM's chair has no acceleration limits and turns about its middle.
    limits = MotionLimits(linear_acceleration=1e6, linear_braking=1e6, angular_acceleration=1e6)
    chair = ChairConfig(footprint=Footprint(0.575, 0.575, 0.35), limits=limits)
    lidar = LidarConfig(noise_sd=0, T_base_laser=Pose2(*LASER))
    world = DrivingWorld(OccupancyGrid(home(), RESOLUTION), chair, lidar, seed=0)
    world.reset(Pose2(*START))
    return world


def their_world(folder: Path, as_grid: bool) -> irsim.EnvBase:
    lidar = {"name": "lidar2d", "range_max": 30, "angle_range": float(np.pi), "number": 181, "offset": list(LASER)}
    robot = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "rectangle", "length": 1.15, "width": 0.7},
        "state": list(START),
        "vel_min": [-1, -1],
        "vel_max": [1, 1],
        "acce": [1e6, 1e6],
        "sensors": [lidar],
    }
    world: dict[str, Any] = {"width": WIDTH, "height": HEIGHT, "step_time": 0.1, "collision_mode": "stop"}
    config: dict[str, Any] = {"world": world, "robot": [robot]}
    if as_grid:
        world["obstacle_map"] = str(folder / "home.png")
        cv2.imwrite(world["obstacle_map"], np.where(home()[::-1] == 100, 0, 255).astype(np.uint8))
    else:
        config["obstacle"] = [rectangle(*block) for block in BLOCKS]
    file = folder / "home.yaml"
    file.write_text(yaml.safe_dump(config))
    return irsim.make(str(file), display=False, log_level="ERROR")


def rectangle(x0: float, y0: float, x1: float, y1: float) -> dict[str, Any]:
    shape = {"name": "rectangle", "length": x1 - x0, "width": y1 - y0}
    return {"shape": shape, "state": [(x0 + x1) / 2, (y0 + y1) / 2, 0]}


def assert_agreement(ours: DrivingWorld, theirs: irsim.EnvBase) -> None:
    pose_error = range_error = 0.0
    ours.reset(Pose2(*START))
    for command in LEG:
        result = ours.step(Twist2(*command))
        theirs.step(np.array(command).reshape(2, 1))
        pose_error = max(pose_error, float(np.abs(theirs.get_robot_state().ravel()[:3] - [*result.pose]).max()))
        difference = np.abs(theirs.get_lidar_scan()["ranges"] - ours.scan().ranges)
        range_error = max(range_error, float(difference.max()))
    assert ours.state.collisions == 0
    assert pose_error < 1e-9, f"poses differ by {pose_error}"
    assert range_error < 1e-4, f"ranges differ by {range_error} m"
    print(f"agree on {len(LEG)} steps: poses within {pose_error:.0e}, ranges within {range_error:.0e} m")


def time_ours(world: DrivingWorld, with_scan: bool) -> float:
    world.reset(Pose2(*START))
    start = time.perf_counter()
    for command in LEG:
        world.step(Twist2(*command))
        if with_scan:
            world.scan()
    return (time.perf_counter() - start) / len(LEG)


def time_theirs(env: irsim.EnvBase) -> float:
    env.reset()
    commands: list[npt.NDArray[np.float64]] = [np.array(command).reshape(2, 1) for command in LEG]
    start = time.perf_counter()
    for command in commands:
        env.step(command)
        env.get_lidar_scan()
    return (time.perf_counter() - start) / len(LEG)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=7)
    runs = parser.parse_args().runs
    logging.disable(logging.WARNING)
    ours = our_world()
    for form in ("grid", "rectangles"):
        with tempfile.TemporaryDirectory() as folder:
            theirs = their_world(Path(folder), as_grid=form == "grid")
            assert_agreement(ours, theirs)
            times = [(time_ours(ours, True), time_theirs(theirs), time_ours(ours, False)) for _ in range(runs)]
        full, rival, bare = (statistics.median(column) for column in zip(*times, strict=True))
        ratio = statistics.median(b / a for a, b, _ in times)
        print(f"home of 20 x 10 m, 181 beams, {len(LEG)} steps of .1 s, median of {runs}, threads=1")
        print(f"  lfdcore               step + scan {full * 1e6:8.1f} us (step alone {bare * 1e6:.2f} us)")
        print(f"  IR-SIM {irsim.__version__}, {form:10} step + scan {rival * 1e6:8.1f} us")
        print(f"  ratio {ratio:.0f} x")


if __name__ == "__main__":
    main()
