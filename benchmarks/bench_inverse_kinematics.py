"""Inverse kinematics of Baxter's arms: 10 000 random reachable poses each, and poses out of reach.

Poses are those of joints drawn uniformly inside the limits; no solver knows them. Ours starts from fixed postures,
KDL's LMA from mid-range (one attempt), roboticstoolbox's ik_LM at random (100 restarts at most). A pose counts as
solved if forward kinematics of the answer, checked here for all alike, is within 1e-4 m and 1e-4 rad and inside the
joint limits. Rivals run in the same process run, block by block in turn; those that are missing are left out: KDL's
needs a C++ compiler, the other `pip install roboticstoolbox-python`. Ours and the toolbox are timed in Python, KDL in
C++. Out of reach for sure: poses beyond the stretched arm, and poses nearer by with the gripper pointing back at the
shoulder, so that the wrist would be beyond it. threads=1.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.humanoid.baxter import baxter, baxter_urdf
from lfdcore.kinematics import InverseKinematics, KinematicChain

try:
    import roboticstoolbox as toolbox
except ImportError:
    toolbox = None

FloatArray = NDArray[np.float64]
Answers = tuple[FloatArray, FloatArray]  # microseconds (m,), joints (m, n)
Solver = Callable[[FloatArray], Answers]
COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
BLOCKS = 5


def ours(chain: KinematicChain) -> Solver:
    solver = InverseKinematics(chain)

    def solve(poses: FloatArray) -> Answers:
        taken, joints = [], []
        for pose in poses:
            start = time.perf_counter()
            result = solver.solve(pose)
            taken.append((time.perf_counter() - start) * 1e6)
            joints.append(result.joints)
        return np.array(taken), np.array(joints)

    return solve


def rotation(roll: float, pitch: float, yaw: float) -> FloatArray:
    (a, b, c), (x, y, z) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_z, about_y = np.array([[c, -z, 0], [z, c, 0], [0, 0, 1]]), np.array([[b, 0, y], [0, 1, 0], [-y, 0, b]])
    return about_z @ about_y @ np.array([[1, 0, 0], [0, a, -x], [0, x, a]])


def fixed_transforms(side: str) -> tuple[list[FloatArray], FloatArray]:
    """Of each joint the fixed transform before it, and the tool, read from the URDF without lfdcore."""
    joints = {j.find("child").get("link"): j for j in ET.parse(baxter_urdf()).getroot().findall("joint")}  # type: ignore[union-attr]
    link, collected, since = f"{side}_gripper", [], np.eye(4)
    tool: FloatArray | None = None
    while link != "base":
        joint = joints[link]
        origin, T = joint.find("origin"), np.eye(4)
        assert origin is not None
        T[:3, :3] = rotation(*map(float, str(origin.get("rpy")).split()))
        T[:3, 3] = [float(v) for v in str(origin.get("xyz")).split()]
        if joint.get("type") == "revolute":
            if tool is None:
                tool = since
            else:
                collected.append(since)
            since = T
        else:
            since = T @ since
        link = str(joint.find("parent").get("link"))  # type: ignore[union-attr]
    collected.append(since)
    assert tool is not None
    return collected[::-1], tool


def kdl(chain: KinematicChain, side: str, folder: Path) -> Solver | None:
    compiler = shutil.which("c++")
    if compiler is None:
        return None
    program = folder / "kdl_lma"
    source = Path(__file__).with_name("kdl_lma.cpp")
    flags = ["-O3", "-DNDEBUG", "-std=c++17", "-I/usr/include/eigen3"]
    if subprocess.run([compiler, *flags, str(source), "-lorocos-kdl", "-o", str(program)], check=False).returncode != 0:
        return None
    before, tool = fixed_transforms(side)
    text = [str(len(before))]
    for T, low, high in zip(before, chain.lower, chain.upper, strict=True):
        text.append(" ".join(map(repr, [*T[:3].ravel().tolist(), float(low), float(high)])))
    text.append(" ".join(map(repr, tool[:3].ravel().tolist())))

    def solve(poses: FloatArray) -> Answers:
        rows = [" ".join(map(repr, pose[:3].ravel().tolist())) for pose in poses]
        asked = "\n".join([*text, str(len(poses)), *rows])
        done = subprocess.run([str(program)], input=asked, capture_output=True, text=True, check=True)
        found = np.array([line.split() for line in done.stdout.splitlines()], float)
        return found[:, 0], found[:, 1:]

    return solve


def robotics_toolbox(chain: KinematicChain, side: str) -> Solver | None:
    if toolbox is None:
        return None
    before, tool = fixed_transforms(side)
    ets = toolbox.ETS()
    for i, (T, low, high) in enumerate(zip(before, chain.lower, chain.upper, strict=True)):
        ets = ets * toolbox.ET.SE3(T) * toolbox.ET.Rz(jindex=i, qlim=[low, high])
    ets = ets * toolbox.ET.SE3(tool)
    q = np.full(len(before), 0.3)
    np.testing.assert_allclose(ets.fkine(q).A, chain.forward(q), atol=1e-9)

    def solve(poses: FloatArray) -> Answers:
        taken, joints = [], []
        for pose in poses:
            start = time.perf_counter()
            answer = ets.ik_LM(pose, tol=5e-9)  # half the squared error: 1e-4
            taken.append((time.perf_counter() - start) * 1e6)
            joints.append(np.asarray(answer[0] if isinstance(answer, tuple) else answer.q))
        return np.array(taken), np.array(joints)

    return solve


def solved(chain: KinematicChain, poses: FloatArray, joints: FloatArray) -> NDArray[np.bool_]:
    inside = np.all((joints >= chain.lower - 1e-9) & (joints <= chain.upper + 1e-9), axis=1)
    reached = np.array([chain.forward(q) for q in joints])
    distance = np.linalg.norm(reached[:, :3, 3] - poses[:, :3, 3], axis=1)
    # The angle between rotations from the chord of their matrices: |R - S|_F = 2 sqrt(2) sin(angle / 2).
    chord = np.linalg.norm(reached[:, :3, :3] - poses[:, :3, :3], axis=(1, 2))
    angle = 2 * np.arcsin(np.clip(chord / (2 * np.sqrt(2)), 0, 1))
    return inside & (distance <= 1e-4) & (angle <= 1e-4)


def row(name: str, taken: FloatArray, ok: NDArray[np.bool_]) -> str:
    low, mid, high = np.percentile(taken, [50, 90, 99])
    return f"  {name:<28}{100 * ok.mean():8.2f} %{low:11.1f}{mid:11.1f}{high:11.1f}{taken.max():11.0f}"


def root_of(chain: KinematicChain) -> FloatArray:
    link = chain.joint_names[0].replace("_s0", "_upper_shoulder")
    return baxter().forward(np.zeros(15), link)[:3, 3]


def out_of_reach(chain: KinematicChain, poses: FloatArray, share: float, *, back: bool) -> FloatArray:
    """In the same directions at `share` of the stretched arm's length from its root, `back`: pointing at it."""
    root, moved = root_of(chain), poses.copy()
    direction = poses[:, :3, 3] - root
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    moved[:, :3, 3] = root + share * chain.reach * direction
    if back:
        side = np.cross(direction, poses[:, :3, 0])
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        moved[:, :3, :3] = np.stack([np.cross(side, -direction), side, -direction], axis=2)
    return moved


def main() -> None:
    model, rng = baxter(), np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        for side in ("left", "right"):
            chain = model.chain("base", f"{side}_gripper")
            poses = np.array([chain.forward(q) for q in rng.uniform(chain.lower, chain.upper, (COUNT, len(chain)))])
            solvers = {
                "lfdcore": ours(chain),
                "KDL LMA, mid-range, 1 try": kdl(chain, side, Path(folder)),
                "roboticstoolbox ik_LM": robotics_toolbox(chain, side),
            }
            there = {name: solver for name, solver in solvers.items() if solver is not None}
            parts: dict[str, list[Answers]] = {name: [] for name in there}
            for block in np.array_split(poses, BLOCKS):
                for name, solver in there.items():
                    parts[name].append(solver(block))
            print(f"{side} arm, {COUNT} reachable poses   solved    median us    p90 us     p99 us     max us")
            for name, found in parts.items():
                taken, joints = np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])
                ok = solved(chain, poses, joints)
                print(row(name, taken, ok))
                if name == "lfdcore":
                    assert ok.all(), f"{np.sum(~ok)} poses not solved"
            for share, back, words in ((1.05, False, "too far"), (0.7, True, "pointing back")):
                far = out_of_reach(chain, poses[:500], share, back=back)
                taken, joints = there["lfdcore"](far)
                ok = solved(chain, far, joints)
                print(row(f"lfdcore, {words}", taken, ok))
                assert not ok.any()


if __name__ == "__main__":
    main()
