"""Robots from URDF: chains, inverse kinematics, joint trajectories. Re-exports lfdcore._core.kinematics."""

from lfdcore._core.kinematics import (
    FollowConfig,
    FollowResult,
    InverseKinematics,
    InverseKinematicsConfig,
    InverseKinematicsResult,
    JointTrajectory,
    KinematicChain,
    RobotModel,
    SelfCollision,
    follow_poses,
    joint_velocities,
    slow_down,
    solve_inverse_kinematics,
)

__all__ = [
    "FollowConfig",
    "FollowResult",
    "InverseKinematics",
    "InverseKinematicsConfig",
    "InverseKinematicsResult",
    "JointTrajectory",
    "KinematicChain",
    "RobotModel",
    "SelfCollision",
    "follow_poses",
    "joint_velocities",
    "slow_down",
    "solve_inverse_kinematics",
]
