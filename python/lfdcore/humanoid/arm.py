"""An inferred motion as joints of an arm (Sec. 5.6): a gripper's pose, followed, or joint positions themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.joint_motion import JointMotion
from lfdcore.humanoid.baxter import ROBOTIQ_LENGTH, neutral_posture, robotiq_tool
from lfdcore.kinematics import (
    FollowResult,
    RobotModel,
    SelfCollision,
    follow_poses,
    joint_velocities,
    slow_down,
)

Array = NDArray[np.float64]
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")


def gripper_poses(names: Sequence[str], motion: ArrayLike) -> Array:
    """Columns (T, r) by name -> T_base_gripper (T, 4, 4). ValueError unless one gripper's x, y, z, qx, qy, qz, qw are
    among them, each once, and for another r."""
    values = _of_columns(names, motion)
    places = [[k for k, name in enumerate(names) if name.rpartition(".")[2] == part] for part in _POSE]
    if any(len(found) != 1 for found in places):
        raise ValueError(f"a gripper's pose needs one column each of {', '.join(_POSE)}, got {', '.join(names)}")
    x, y, z, *quaternion = (values[:, found[0]] for found in places)
    poses = np.tile(np.eye(4), (len(values), 1, 1))
    poses[:, :3, :3] = rotations(np.stack(quaternion, axis=1))
    poses[:, :3, 3] = np.stack([x, y, z], axis=1)
    return poses


def rotations(quaternions: Array) -> Array:
    """(T, 4) x y z w of any length > 0 -> (T, 3, 3). ValueError for one of length 0."""
    length = np.linalg.norm(quaternions, axis=1, keepdims=True)
    if not (length > 1e-9).all():
        k = int(np.argmin(length[:, 0]))
        raise ValueError(f"quaternion of sample {k} has length {length[k, 0]:.3g}, must be > 0")
    x, y, z, w = (quaternions / length).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@dataclass(frozen=True, eq=False)
class ArmMotion:
    """What became of following a gripper's motion."""

    joints: JointMotion | None
    """up to the first failure; None where not even the second pose could be followed"""
    result: FollowResult
    """outcome, errors, clearance, slowdown; see lfdcore.kinematics"""

    @property
    def followed(self) -> bool:
        """The whole motion, inside all limits."""
        return str(self.result.outcome) == "followed"


@dataclass(frozen=True)
class GripperMount:
    """Where on its robot a gripper sits."""

    base: str = "base"
    """link in whose frame its motion is given"""
    tip: str | None = None
    """link that carries it; None: left_hand_link or right_hand_link, as the columns' names begin"""
    tool: float = ROBOTIQ_LENGTH
    """[m] from that link to where it grasps, along z"""


def follow_gripper(
    robot: RobotModel,
    names: Sequence[str],
    time: ArrayLike,
    motion: ArrayLike,
    mount: GripperMount | None = None,
    *,
    posture: ArrayLike | None = None,
    start: ArrayLike | None = None,
) -> ArmMotion:
    """A gripper's columns (T, r) by name at times (T,) [s], in the frame of the mount's base, as joints inside position
    and velocity limits and, if the robot has collision shapes, clear of itself with its other joints at `posture` (N,)
    (by default as resting_posture).

    mount: by default that of a Baxter; start: (n,) posture from which the first pose's is sought, by default the best
    of several. ValueError for columns that are no pose, unknown links, and as follow_poses.
    """
    mount = mount or GripperMount()
    chain = robot.chain(mount.base, mount.tip or _hand(names), robotiq_tool(mount.tool))
    surroundings = SelfCollision(robot) if robot.collision_shapes else None
    result = follow_poses(
        chain,
        time,
        gripper_poses(names, motion),
        None if start is None else np.asarray(start, np.float64),
        self_collision=surroundings,
        posture=None if surroundings is None else (resting_posture(robot) if posture is None else posture),
    )
    run = result.trajectory
    if len(run.time) < 2:
        return ArmMotion(None, result)
    begun = np.asarray(run.time) - run.time[0]
    return ArmMotion(JointMotion(tuple(chain.joint_names), begun, run.positions, run.velocities), result)


def follow_joints(robot: RobotModel, names: Sequence[str], time: ArrayLike, motion: ArrayLike) -> JointMotion:
    """Joint positions (T, r) of the named joints at times (T,) [s], slowed down where they would be faster than the
    robot's limits. ValueError naming joint, value and bounds for a position outside them, for an unknown joint, what is
    not finite and another r."""
    positions = _of_columns(names, motion)
    unknown = [name for name in names if name not in robot.joint_names]
    if unknown:
        raise ValueError(f"{unknown[0]} is none of the robot's joints: {', '.join(robot.joint_names)}")
    if not np.isfinite(positions).all():
        raise ValueError("joint positions must be finite")
    limits = robot.limits[[robot.joint_names.index(name) for name in names]]
    outside = (positions < limits[:, 0]) | (positions > limits[:, 1])
    if outside.any():
        sample, joint = (int(k) for k in np.argwhere(outside)[0])
        low, high = limits[joint, :2].tolist()
        raise ValueError(
            f"{names[joint]} is to go to {positions[sample, joint]:.3f} at sample {sample}, must be in "
            f"[{low:g}, {high:g}] rad or m"
        )
    slowed = slow_down(time, positions, limits[:, 2])
    return JointMotion(tuple(names), slowed - slowed[0], positions, joint_velocities(slowed, positions))


def self_clearance(robot: RobotModel, motion: JointMotion, posture: ArrayLike | None = None) -> tuple[float, int]:
    """Smallest distance [m] of the robot's links along a motion and the sample where it is, its other joints at
    `posture` (N,) (by default as resting_posture); inf for a robot without collision shapes."""
    if not robot.collision_shapes:
        return np.inf, 0
    surroundings, q = SelfCollision(robot), np.array(resting_posture(robot) if posture is None else posture, np.float64)
    joints = [robot.joint_names.index(name) for name in motion.names]
    apart = []
    for positions in motion.positions:
        q[joints] = positions
        apart.append(surroundings.distance(q))
    return float(np.min(apart)), int(np.argmin(apart))


def resting_posture(robot: RobotModel) -> Array:
    """(N,) Baxter's neutral posture; of another robot the middle of each joint's range, 0 where it has none."""
    if robot.name == "baxter":
        return neutral_posture(robot)
    low, high = robot.limits[:, 0], robot.limits[:, 1]
    bounded = np.isfinite(low) & np.isfinite(high)
    return np.where(bounded, (np.where(bounded, low, 0) + np.where(bounded, high, 0)) / 2, 0.0)


def _of_columns(names: Sequence[str], motion: ArrayLike) -> Array:
    values = np.asarray(motion, np.float64)
    if values.ndim != 2 or values.shape[1] != len(names):
        raise ValueError(f"motion has shape {values.shape}, must be (T, {len(names)}): {', '.join(names)}")
    return values


def _hand(names: Sequence[str]) -> str:
    for side in ("left", "right"):
        if all(name.startswith(f"{side}_") for name in names):
            return f"{side}_hand_link"
    raise ValueError(f"which hand moves? The columns {', '.join(names)} begin neither with left_ nor with right_")
