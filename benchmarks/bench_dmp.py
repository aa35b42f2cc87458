"""Roll-out of dynamic movement primitives: 500 steps, 7 degrees of freedom, 30 basis functions, and LASA shapes.

Rivals: mp-pytorch's ProDMP (its times set once, as ours keeps its matrix; new parameters each time; positions and
velocities) and movement_primitives' open loop. Ours gives positions, velocities and accelerations. Each rival has its
own basis functions, so that outputs are compared after fitting our motion's samples with them (ProDMP by least squares
over its own response; movement_primitives by its imitate). With LFDCORE_DATA the reproduction error of 15 handwriting
shapes (Khansari-Zadeh and Billard 2011). One thread each; interleaved, medians.
Run: python benchmarks/bench_dmp.py [--rounds N]
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from movement_primitives.dmp import DMP
from mp_pytorch.basis_gn import ProDMPBasisGenerator
from mp_pytorch.mp import ProDMP
from mp_pytorch.phase_gn import ExpDecayPhaseGenerator
from numpy.typing import NDArray

from lfdcore.primitives import Dmp, DmpConfig

Floats = NDArray[np.float64]
STEPS, DOF, BASIS = 500, 7, 30
torch.set_num_threads(1)


def seconds(work: Callable[[], object], times: int) -> float:
    begin = time.process_time()
    for _ in range(times):
        work()
    return (time.process_time() - begin) / times


def motion() -> Floats:
    """A smooth reaching motion from rest to rest."""
    t = np.linspace(0, 1, STEPS)[:, None]
    rise = t**3 * (10 - 15 * t + 6 * t**2)
    k = np.arange(DOF)
    return k * 0.1 + rise * (1 - 0.2 * k) + 0.3 * np.sin(np.pi * rise * (1 + k % 3)) ** 2


def prodmp(demonstration: Floats) -> tuple[Callable[[], object], Floats]:
    phase = ExpDecayPhaseGenerator(tau=1.0, delay=0.0, alpha_phase=np.log(100), dtype=torch.float64)
    generator = ProDMPBasisGenerator(
        phase, num_basis=BASIS, dt=1 / (STEPS - 1), alpha=25, pre_compute_length_factor=1, dtype=torch.float64
    )
    primitive = ProDMP(generator, DOF, dtype=torch.float64)
    times = torch.linspace(0, 1, STEPS, dtype=torch.float64)
    zero, start = torch.tensor(0.0, dtype=torch.float64), torch.tensor(demonstration[0])
    rest = torch.zeros(DOF, dtype=torch.float64)
    size = BASIS + 1
    unit = torch.zeros(DOF * size, dtype=torch.float64)
    primitive.update_inputs(times, unit, None, zero, start, rest)
    primitive.get_traj_pos()
    response = primitive.pos_H_single.numpy()
    offset = primitive.get_traj_pos().numpy()
    parameters = torch.tensor(np.linalg.lstsq(response, demonstration - offset, rcond=None)[0].T.ravel())

    def run() -> tuple[torch.Tensor, torch.Tensor]:
        primitive.set_params(parameters)
        return primitive.get_traj_pos(), primitive.get_traj_vel()

    return run, run()[0].numpy()


def movement_primitive(demonstration: Floats) -> tuple[Callable[[], object], Floats]:
    primitive = DMP(demonstration.shape[1], 1.0, dt=1 / (len(demonstration) - 1), n_weights_per_dim=BASIS)
    primitive.imitate(np.linspace(0, 1, len(demonstration)), demonstration)

    def run() -> Floats:
        primitive.reset()
        return primitive.open_loop()[1]

    return run, run()


def rollouts(rounds: int) -> None:
    demonstration = motion()
    ours = Dmp.fit(demonstration, DmpConfig(basis_functions=BASIS))
    positions = ours.rollout(STEPS).positions.copy()
    its_run, its_positions = prodmp(demonstration)
    other_run, other_positions = movement_primitive(demonstration)
    shared = min(len(other_positions), STEPS)
    fresh = iter(range(STEPS, 10**6))

    def first() -> None:
        ours.rollout(STEPS, duration=1 + next(fresh) * 1e-9)  # a grid that no call before had

    took = [
        (seconds(lambda: ours.rollout(STEPS), 200), seconds(first, 5), seconds(its_run, 20), seconds(other_run, 2))
        for _ in range(rounds)
    ]
    fast, cold, its, other = np.median(took, axis=0)
    span = np.ptp(positions)
    print(f"{STEPS} steps x {DOF} x {BASIS}: lfdcore {fast * 1e6:.1f} us (a grid seen first {cold * 1e6:.0f} us)")
    for name, slow, rival in (
        ("ProDMP", its, its_positions),
        ("movement_primitives", other, other_positions),
    ):
        off = np.abs(rival[:shared] - positions[:shared]).max() / span
        assert off < 0.02, f"{name} gives another motion"
        print(f"  {name:20}{slow * 1e6:9.1f} us   ratio {slow / fast:6.1f}   largest difference {off:.1e} of the range")


def handwriting(folder: Path) -> None:
    from scipy.io import loadmat

    print(
        "LASA, 7 demonstrations a shape, 20 basis functions: RMS and largest error of the reproduction, % of the range"
    )
    for path in sorted(folder.glob("*.mat")):
        errors = []
        for demo in loadmat(path)["demos"][0]:
            y = np.ascontiguousarray(demo["pos"][0, 0].T, float)
            its = DMP(2, 1.0, dt=1 / (len(y) - 1), n_weights_per_dim=20)
            its.imitate(np.linspace(0, 1, len(y)), y)
            made_by = [Dmp.fit(y, by=by).rollout(len(y)).positions for by in ("forcing", "positions")]
            made_by.append(its.open_loop()[1][: len(y)])
            scale = 100 / np.ptp(y, axis=0).max()
            away = [np.linalg.norm(made - y[: len(made)], axis=1) * scale for made in made_by]
            errors.append([f(a) for a in away for f in (lambda a: np.sqrt((a**2).mean()), np.max)])
        m = np.mean(errors, axis=0)
        print(
            f"  {path.stem:16} lfdcore {m[0]:5.2f} {m[1]:6.2f}   fitted by positions {m[2]:5.2f} {m[3]:6.2f}   "
            f"movement_primitives {m[4]:5.2f} {m[5]:6.2f}"
        )


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=9)
    rollouts(options.parse_args().rounds)
    folder = os.environ.get("LFDCORE_DATA")
    if folder:
        handwriting(Path(folder) / "lasa")


if __name__ == "__main__":
    main()
