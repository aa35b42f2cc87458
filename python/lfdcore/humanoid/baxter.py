"""The Baxter robot: where its URDF is, and its arms' chains."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lfdcore.humanoid.contact import Capsule
from lfdcore.kinematics import InverseKinematics, KinematicChain, RobotModel, SelfCollision

Side = Literal["left", "right"]

ROBOTIQ_LENGTH = 0.16
"""[m] from the hand's plate to where a Robotiq 2-finger 85 grasps, about"""

NEUTRAL: dict[Side, tuple[float, ...]] = {
    "left": (-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.50),
    "right": (0.08, -1.0, 1.19, 1.94, -0.67, 1.03, 0.50),
}
"""Rethink's neutral posture of each arm (baxter_interface, Limb.move_to_neutral) [rad], joints s0 to w2."""


ARM_PARTS = ("upper arm", "forearm", "hand")
"""of arm_capsules"""
_PART_LINKS = (
    ("lower_shoulder", "upper_elbow"),
    ("lower_elbow", "upper_forearm", "lower_forearm"),
    ("wrist", "gripper_base_link"),
)
"""whose collision shapes make up each of ARM_PARTS"""
_PART_ENDS = ("lower_shoulder", "lower_elbow", "lower_forearm", "hand_link")
"""links at whose frames each part begins; the last, where the hand's plate is"""
_HAND = 0.08
"""[m] beyond the hand's plate where the hand's capsule ends; the URDF's gripper body goes on to 0.105 m"""


def neutral_posture(model: RobotModel) -> NDArray[np.float64]:
    """(N,) [rad]: both arms neutral, the head straight; joints as in model.joint_names."""
    q = np.zeros(len(model.joint_names))
    for side, values in NEUTRAL.items():
        for joint, value in zip(("s0", "s1", "e0", "e1", "w0", "w1", "w2"), values, strict=True):
            q[model.joint_names.index(f"{side}_{joint}")] = value
    return q


def baxter_urdf() -> Path:
    """urdf/baxter.urdf: beside the package's modules where it is installed, at the root of a source tree otherwise."""
    package = Path(__file__).parents[1]
    installed = package / "urdf" / "baxter.urdf"
    return installed if installed.exists() else package.parents[1] / "urdf" / "baxter.urdf"


def baxter() -> RobotModel:
    """The robot of baxter_urdf(): head_pan and two arms of seven joints each."""
    return RobotModel.from_urdf_file(str(baxter_urdf()))


def baxter_arm(model: RobotModel, side: Side, T_hand_tool: NDArray[np.float64] | None = None) -> KinematicChain:
    """From `base` to a tool on the hand's mounting plate; T_hand_tool (4, 4), by default robotiq_tool()."""
    tool = robotiq_tool() if T_hand_tool is None else T_hand_tool
    return model.chain("base", f"{side}_hand_link", tool)


def arm_capsules(model: RobotModel, side: Side, positions: NDArray[np.float64]) -> tuple[Capsule, ...]:
    """ARM_PARTS at the arm's joint positions (T, 7) [rad], s0 to w2: s1 to e1, e1 to w1, w1 to _HAND beyond the plate
    [m, base], each as thick as the thickest of its links' collision shapes. The gripper's fingers are not among them.
    ValueError for a robot without these shapes."""
    q, joints = neutral_posture(model), [model.joint_names.index(name) for name in baxter_arm(model, side).joint_names]
    ends = np.zeros((len(_PART_ENDS), len(positions), 3))
    for k, row in enumerate(positions):
        q[joints] = row
        for place, link in enumerate(_PART_ENDS):
            pose = model.forward(q, f"{side}_{link}")
            ends[place, k] = pose[:3, 3] + (_HAND * pose[:3, 2] if link == "hand_link" else 0)
    return tuple(Capsule(ends[k], ends[k + 1], radius) for k, radius in enumerate(_part_radii(model, side)))


def _part_radii(model: RobotModel, side: Side) -> list[float]:
    """[m] of ARM_PARTS."""
    shapes = model.collision_shapes  # built anew whenever it is asked for
    parts = [{f"{side}_{name}" for name in links} for links in _PART_LINKS]
    radii = [[radius for link, _, _, radius in shapes if link in part] for part in parts]
    if not all(radii):
        raise ValueError(f"the robot's {side} {ARM_PARTS[radii.index([])]} has no collision shapes")
    return [max(each) for each in radii]


def robotiq_tool(length: float = ROBOTIQ_LENGTH) -> NDArray[np.float64]:
    """T_hand_tool (4, 4) of a gripper that grasps `length` [m] beyond the plate along its z axis.

    The default is about that of a Robotiq 2-finger 85 on its coupling; the thesis names the maker but no length.
    Measure your own.
    """
    if not np.isfinite(length):
        raise ValueError(f"length is {length} m, must be finite")
    tool = np.eye(4)
    tool[2, 3] = length
    return tool


def holding_posture(model: RobotModel, side: Side, place: tuple[float, float, float]) -> NDArray[np.float64]:
    """(N,) [rad]: neutral_posture, but the gripper of `side` holds its tool at `place` [m, base], pointing forward and
    down. Of the postures met from 24 fixed seeds that which keeps the robot's links farthest apart: the first that
    comes along may have its elbow in the head. ValueError where none reaches the place or all touch."""
    chain, q, surroundings = baxter_arm(model, side), neutral_posture(model), SelfCollision(model)
    joints = [model.joint_names.index(name) for name in chain.joint_names]
    solver, seeds = InverseKinematics(chain), np.random.default_rng(0).uniform(chain.lower, chain.upper, (23, 7))
    postures, apart = [], []
    for seed in [q[joints], *seeds]:
        found = solver.solve(_forward_and_down(place), seed)
        if not found.solved:
            raise ValueError(f"the {side} gripper cannot hold at {place} m: {found.position_error:.3f} m away at best")
        q[joints] = found.joints
        postures.append(q.copy())
        apart.append(surroundings.distance(q))
    if max(apart) < 0:
        raise ValueError(f"the {side} gripper cannot hold at {place} m: links touch in all postures found")
    return postures[int(np.argmax(apart))]


def _forward_and_down(place: tuple[float, float, float]) -> NDArray[np.float64]:
    """T_base_tool (4, 4) at `place` [m], its z axis 20 degrees below the horizontal."""
    down = np.radians(110)
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(down), 0, np.sin(down)], [0, 1, 0], [-np.sin(down), 0, np.cos(down)]]
    pose[:3, 3] = place
    return pose
