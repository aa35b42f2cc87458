"""The learned assistants' whole update() along a recorded drive; one thread. Aims: median <= 10 ms and p99 <= 20 ms
with primitives, half of each with heatmaps.

Records an impaired driver in the office, replays it (each time asserting the first replay's commands: the drive's own
where no two paths are as good to 1e-15, which a log's rounding decides) and prints times, a profile by stage, and the
memory of an assistant and of a run's trace.
Run: python benchmarks/bench_update.py [--updates N] [--runs N] [--heatmaps MODEL]
Without MODEL the heatmaps' network is trained briefly on four runs in the mazes; its size is the default one.
"""

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets import open_log
from lfdcore.simulated.courses import office
from lfdcore.simulated.drivers import ImpairedDriver, population
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.study.demonstrations import learn_from_demonstrations
from lfdcore.wheelchair import assistants, drivable_path
from lfdcore.wheelchair.assistants import DriveAssistant
from lfdcore.wheelchair.heatmaps import planner as heatmap_planner
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.observation import ChairGeometry, Observation, observations
from lfdcore.wheelchair.primitives import planner as primitives_planner

CHAIR = ChairGeometry.thesis()

CLOCKS = {"wall": time.perf_counter, "CPU": time.thread_time}
"""CPU time tells what a quiet machine would show where this one is not."""
PERCENTILES = {"median": 50, "p90": 90, "p99": 99, "most": 100}
AIMS = {"primitives": {"median": 10.0, "p99": 20.0}, "heatmaps": {"median": 5.0, "p99": 10.0}}
"""[ms] on a quiet machine"""


class Stopwatch:
    """Seconds spent in each stage, and how often."""

    def __init__(self) -> None:
        self.spent: dict[str, list[float]] = {}

    def around(self, stage: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **kwargs: Any) -> Any:
            start = time.perf_counter()
            try:
                return call(*args, **kwargs)
            finally:
                self.spent.setdefault(stage, []).append(time.perf_counter() - start)

        return timed


class Timed:
    """An object whose named methods are timed; all else is passed on."""

    def __init__(self, watch: Stopwatch, inner: Any, stages: dict[str, str]) -> None:
        self._inner = inner
        for method, stage in stages.items():
            setattr(self, method, watch.around(stage, getattr(inner, method)))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


MODULES = {
    drivable_path: {"inflate": "inflate", "smooth": "greedy path", "rollout_pursuit": "roll-out"},
    heatmap_planner: {
        "local_grid": "free space of the scan",
        "user_heatmap": "user heatmap",
        "squashed": "product",
        "heatmap_reward": "reward",
        "GridMdp": "Q-learning: MDP",
        "greedy_path": "greedy path",
        "compliances": "compliance",
        "joystick_orientation": "orientation",
    },
    primitives_planner: {
        "path_cells": "reward",
        "path_reward": "reward",
        "GridMdp": "DPP: MDP",
        "greedy_path": "greedy path",
    },
    assistants: {"pure_pursuit": "pursuit", "time_to_contact": "time to contact"},
}
"""Stages that are functions, by the module that calls them."""


def instrument(assistant: Any, watch: Stopwatch) -> Callable[[], None]:
    """Times the stages of one assistant -> a function that takes the watches off the modules again."""
    around = assistant._surroundings
    stages = {"insert": "rolling map: insert", "obstacles": "rolling map: obstacles", "local_grid": "rolling map: grid"}
    around._map = Timed(watch, around._map, stages)
    assistant._supervisor = Timed(watch, assistant._supervisor, {"filter": "supervisor"})
    planner = assistant.planner
    model = planner.model
    planner._finder._hybrid_astar = Timed(watch, planner._finder._hybrid_astar, {"solve": "hybrid A*"})
    planner._finder._last_free = watch.around("last free end", planner._finder._last_free)
    if model.method == "heatmaps":
        planner.model = replace(model, sensor=Timed(watch, model.sensor, {"predict": "sensor heatmap"}))
        planner.joystick = Timed(watch, planner.joystick, {"predict": "joystick model"})
        planner._q_learning = Timed(watch, planner._q_learning, {"solve": "Q-learning: sweeps"})
    else:
        planner._dpp = Timed(watch, planner._dpp, {"solve": "DPP: sweeps"})
        model.intention.predict = watch.around("intention", model.intention.predict)
        model.compliance.compliances = watch.around("compliance", model.compliance.compliances)
    kept = [(module, name, getattr(module, name)) for module, stages in MODULES.items() for name in stages]
    for module, name, call in kept:
        setattr(module, name, watch.around(MODULES[module][name], call))

    def restore() -> None:
        for module, name, call in kept:
            setattr(module, name, call)

    return restore


def lived(model: Path, folder: Path, updates: int) -> tuple[list[Observation], NDArray[np.float64], str]:
    """The first `updates` observations of a drive, the commands they bring, and what the run's trace takes."""
    course, path = office(), folder / "drive.mcap"
    config = RunConfig(slowest=course.length / (updates / 10))
    driver = ImpairedDriver(course, population(1, 1)[0])
    trace = run_drive(course, driver, DriveAssistant(load_model(model).planner(CHAIR)), 1, config, path)
    log = open_log(path)
    of_trace, of_log = trace.nbytes / len(trace.stamp), path.stat().st_size / len(log.scan_stamp)
    size = f"a tick takes {of_trace:.0f} B of a study's trace, {of_log:.0f} B of a drive log"
    seen, assistant = list(observations(log))[:updates], DriveAssistant(load_model(model).planner(CHAIR))
    commands = np.array([[*assistant.update(observation).command] for observation in seen])
    return seen, commands, size


def replay(assistant: DriveAssistant, seen: list[Observation], expected: NDArray[np.float64]) -> tuple[Any, Any]:
    """-> times [ms] (N, clocks) and whether each update planned (N,)."""
    assistant.reset()
    times, commands, planned = np.zeros((len(seen), 2)), np.zeros((len(seen), 2)), np.zeros(len(seen), bool)
    for i, observation in enumerate(seen):
        start = [clock() for clock in CLOCKS.values()]
        said = assistant.update(observation)
        times[i] = [(clock() - before) * 1e3 for clock, before in zip(CLOCKS.values(), start, strict=True)]
        commands[i], planned[i] = tuple(said.command), said.planned
    np.testing.assert_allclose(commands, expected, rtol=0, atol=1e-9)
    return times, planned


def print_times(times: NDArray[np.float64], planned: NDArray[np.bool_], aims: dict[str, float]) -> None:
    """times (runs, updates, clocks) [ms]; medians over the runs of each run's percentile."""
    print(f"  {'':24}" + "".join(f"{clock + ' ms':>10}" for clock in CLOCKS))
    for name, percentile in PERCENTILES.items():
        values = np.median(np.percentile(times, percentile, axis=1), axis=0)
        aim = f"   aim <= {aims[name]:.0f} ms" if name in aims else ""
        print(f"  {name:24}{values[0]:10.2f}{values[1]:10.2f}{aim}")
    typical = np.median(times, axis=0)
    for name, rows in ((f"{planned.sum()} made a path", planned), ("the others", ~planned)):
        values = np.median(typical[rows], axis=0)
        print(f"  {name:24}{values[0]:10.2f}{values[1]:10.2f}   (medians)")


def print_profile(watch: Stopwatch, total: float, updates: int) -> None:
    print(f"  {'stage':24}{'calls':>7}{'median ms':>11}{'p99 ms':>9}{'share':>8}")
    for stage, spent in sorted(watch.spent.items(), key=lambda item: -sum(item[1])):
        calls = np.array(spent) * 1e3
        share = calls.sum() / total
        print(f"  {stage:24}{len(calls):7}{np.median(calls):11.3f}{np.percentile(calls, 99):9.3f}{share:8.1%}")
    rest = total - 1e3 * sum(map(sum, watch.spent.values()))
    print(f"  {'Python between':24}{updates:7}{rest / updates:11.3f}{'':9}{rest / total:8.1%}  (mean an update)")


def resident() -> float:
    """Most memory this process has had so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def briefly_trained(folder: Path) -> Path:
    """The file of a heatmaps' model. A network takes as long whatever it says, but the drive must lead somewhere."""
    from lfdcore.study.demonstrations import demonstrate_in_mazes
    from lfdcore.training.drive_heatmaps import HeatmapLearningConfig, learn_heatmaps
    from lfdcore.training.parts.heatmap_net import HeatmapNetConfig

    mazes = folder / "mazes"
    mazes.mkdir()
    drives = demonstrate_in_mazes(mazes, seed=1, runs=4, processes=1)
    config = HeatmapLearningConfig(network=HeatmapNetConfig(epochs=4))
    path = folder / "heatmaps.safetensors"
    learn_heatmaps([open_log(drive) for drive in drives.paths], config).model.save(path)
    return path


def measure(method: str, file: Path, updates: int, runs: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        seen, commands, size = lived(file, Path(folder), updates)
    fresh = [DriveAssistant(load_model(file).planner(CHAIR)) for _ in range(2)]
    replay(fresh[0], seen, commands)  # warms up
    before = resident()
    done = [replay(fresh[0], seen, commands) for _ in range(runs)]
    grown = resident() - before
    times, planned = np.array([run[0] for run in done]), done[0][1]
    print(f"{method}: {len(seen)} updates in the office, commands as recorded, median of {runs} runs, threads=1")
    print_times(times, planned, AIMS[method])
    watch = Stopwatch()
    restore = instrument(fresh[1], watch)
    profiled, _ = replay(fresh[1], seen, commands)
    restore()
    print_profile(watch, float(profiled[:, 0].sum()), len(seen))
    print(f"memory: model {file.stat().st_size / 1e3:.0f} kB; {size}; process {resident():.0f} MB,")
    print(f"  of which {grown:.1f} MB came during {runs * len(seen)} updates after the first {len(seen)}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--updates", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--heatmaps", type=Path)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure("primitives", learn_from_demonstrations(Path(folder), seed=1), wanted.updates, wanted.runs)
        heatmaps = wanted.heatmaps or briefly_trained(Path(folder))
        measure("heatmaps", heatmaps, wanted.updates, wanted.runs)


if __name__ == "__main__":
    main()
