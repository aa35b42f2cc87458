"""Hybrid A* through a .90 m door from 100 skewed starts: success, time, and whether the path can be tracked.

Rival, where it is installed (pip install fastsim-navigation): fastsim_navigation, a C++ hybrid A* on costmaps with
polygon footprints, Dubins analytic expansion and turning in place. It sees the same points as 0.025 m cells, without
a margin (its cells stand for one); it needs a final heading, for which it gets the door's direction +-1 rad. It runs
on the first 10 starts of the first door only, for at most 1 s each (left alone it takes 5 s). Every path of either
planner is checked against the same footprint without margin, exactly and densely. threads=1.
"""

from __future__ import annotations

import time
from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.control import FootprintRolloutConfig, rollout_pursuit
from lfdcore.geometry import Footprint, Pose2
from lfdcore.grid import ObstaclePoints
from lfdcore.planning import HybridAstar, HybridAstarConfig

try:
    import fastsim_navigation as rival_library
except ImportError:
    rival_library = None

FloatArray = NDArray[np.float64]
CHAIR, GOAL, REPEATS = Footprint(), (1.0, 0.0), 5


def segment(a: tuple[float, float], b: tuple[float, float]) -> FloatArray:
    return np.linspace(a, b, int(np.hypot(b[0] - a[0], b[1] - a[1]) / 0.05) + 2)


def door(width: float) -> FloatArray:
    """A room of 6.4 x 6.4 m divided by a wall 0.1 m thick at x = 0, with a door in its middle."""
    corners = [(-3.2, -3.2), (3.2, -3.2), (3.2, 3.2), (-3.2, 3.2), (-3.2, -3.2)]
    parts = [segment(corners[i], corners[i + 1]) for i in range(4)]
    for sign in (1, -1):
        jamb = sign * width / 2
        parts += [segment((x, jamb), (x, sign * 3.2)) for x in (0.0, 0.1)] + [segment((0, jamb), (0.1, jamb))]
    return np.vstack(parts)


def starts(obstacles: ObstaclePoints, bearing: float) -> list[Pose2]:
    """100 starts 1-2.4 m before the door, free with the margin; bearing up to +-bearing, heading +-60 degrees."""
    rng, found = np.random.default_rng(1), list[Pose2]()
    while len(found) < 100:
        distance, angle = rng.uniform(1, 2.4), np.radians(rng.uniform(-bearing, bearing))
        pose = Pose2(-distance * np.cos(angle), -distance * np.sin(angle), np.radians(rng.uniform(-60, 60)))
        if not obstacles.collides(pose, CHAIR.grown(0.04)):
            found.append(pose)
    return found


def dense(path: FloatArray) -> FloatArray:
    step = np.diff(path, axis=0)
    step[:, 2] = np.remainder(step[:, 2] + np.pi, 2 * np.pi) - np.pi
    between = path[:-1, None] + np.linspace(0, 1, 10, endpoint=False)[None, :, None] * step[:, None]
    return np.vstack([between.reshape(-1, 3), path[-1:]])


def is_free(path: FloatArray, obstacles: ObstaclePoints) -> bool:
    # 1 mm for the bulge of an arc between the path's rows.
    return not any(obstacles.collides(Pose2(*pose), CHAIR.grown(-0.001)) for pose in dense(path))


class Rival:
    """fastsim_navigation on the same door."""

    def __init__(self, points: FloatArray) -> None:
        cells = np.zeros((280, 280), dtype=np.uint8)
        ix, iy = np.floor((points + 3.5) / 0.025).astype(int).T
        cells[iy, ix] = 254
        self.planner = rival_library.HybridAStar(rival_library.Costmap(cells, 0.025, -3.5, -3.5))
        self.config = rival_library.PlannerConfig()
        self.config.minimum_turning_radius = 1 / 2.2
        self.config.allow_reverse = False
        self.config.allow_in_place_rotation = True
        self.config.position_tolerance = 0.15
        self.config.path_output_spacing = 0.05
        self.config.yaw_tolerance = 1.0
        self.config.max_planning_time_seconds = 1.0
        self.request = rival_library.PlanRequest()
        self.request.goal = rival_library.Pose2D(*GOAL, 0.0)
        corners = [rival_library.Point2D(float(x), float(y)) for x, y in CHAIR.corners()]
        self.request.footprint = rival_library.PolygonFootprint(corners)

    def plan(self, start: Pose2) -> FloatArray:
        self.request.start = rival_library.Pose2D(start.x, start.y, start.yaw)
        return np.asarray(self.planner.plan(self.request, self.config).path_array)


def timed(call: Any) -> tuple[Any, float]:
    began = time.thread_time()  # of this thread, which does all the work: other jobs on the machine do not count
    answer = call()
    return answer, 1e3 * (time.thread_time() - began)


def report(name: str, paths: list[FloatArray], ms: FloatArray, obstacles: ObstaclePoints) -> None:
    free = sum(len(path) > 0 and is_free(path, obstacles) for path in paths)
    each = np.median(ms, axis=1)
    quantiles = "/".join(f"{q:.2f}" for q in np.percentile(each, [50, 95, 100]))
    print(f"  {name:34s} found and free {free:3d}/{len(paths)}, median/p95/max {quantiles} ms of CPU")


def tracked(starts_: list[Pose2], paths: list[FloatArray], points: FloatArray) -> None:
    """How many of all paths pure pursuit follows to the end without contact, by look-ahead."""
    for look_ahead in (0.2, 0.3, 0.4, 0.6, 0.8):
        config = FootprintRolloutConfig(look_ahead=look_ahead, linear=0.4, duration=30.0)
        arrived = 0
        for start, path in zip(starts_, paths, strict=True):
            to_start = start.inverse()
            if len(path):
                local = ObstaclePoints(to_start.transform(points))
                arrived += rollout_pursuit(to_start.transform(path[:, :2]), local, CHAIR, config=config).reached_end
        print(f"    pursued with look-ahead {look_ahead} m to the end without contact: {arrived}/100")


def measure(planners: dict[str, Any], begin: list[Pose2]) -> tuple[dict[str, list[Any]], dict[str, FloatArray]]:
    """Every planner's last answer and its times [ms] (starts, REPEATS), the planners taking turns."""
    ms = {name: np.zeros((len(begin), REPEATS)) for name in planners}
    answers: dict[str, list[Any]] = {name: [None] * len(begin) for name in planners}
    for repeat in range(REPEATS):
        for i, start in enumerate(begin):
            for name, plan in planners.items():
                answers[name][i], ms[name][i, repeat] = timed(lambda p=plan, s=start: p(s))
    return answers, ms


def run(width: float, bearing: float) -> None:
    points = door(width)
    obstacles = ObstaclePoints(points)
    begin = starts(obstacles, bearing)
    print(f"door {width} m, bearing +-{bearing:.0f} deg, heading +-60 deg, {len(points)} points, threads=1")
    for margin in (0.04, 0.015):
        planner = HybridAstar(CHAIR, config=HybridAstarConfig(margin=margin, window=4.0))
        name = f"lfdcore, margin {margin} m"
        answers, ms = measure({name: lambda s, p=planner: p.solve(obstacles, s, GOAL)}, begin)
        paths = [np.asarray(answer.path) for answer in answers[name]]
        report(name, paths, ms[name], obstacles)
        print(f"    {dict(Counter(answer.outcome for answer in answers[name]))}")
        tracked(begin, paths, points)
        assert all(len(path) == 0 or is_free(path, obstacles) for path in paths)


def against_rival(width: float) -> None:
    points = door(width)
    obstacles = ObstaclePoints(points)
    begin = starts(obstacles, 30.0)[:10]
    planner = HybridAstar(CHAIR, config=HybridAstarConfig(window=4.0))
    planners = {"lfdcore": lambda s: planner.solve(obstacles, s, GOAL).path, "fastsim_navigation": Rival(points).plan}
    answers, ms = measure(planners, begin)
    print(f"door {width} m, the first 10 starts, interleaved, threads=1")
    for name, paths in answers.items():
        report(name, paths, ms[name], obstacles)
    ratio = np.median(ms["fastsim_navigation"]) / np.median(ms["lfdcore"])
    print(f"  ratio of the medians, rival / lfdcore: {ratio:.0f} (the rival's time limit included)")


def main() -> None:
    if rival_library:
        against_rival(0.9)
    else:
        print("no rival: fastsim_navigation is not installed")
    for width, bearing in ((0.9, 30.0), (0.9, 60.0), (0.85, 30.0)):
        run(width, bearing)


if __name__ == "__main__":
    main()
