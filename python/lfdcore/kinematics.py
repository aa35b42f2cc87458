"""Robots from URDF: chains, inverse kinematics, joint trajectories. Re-exports lfdcore._core.kinematics."""

from lfdcore._core.kinematics import (
    InverseKinematics,
    InverseKinematicsConfig,
    InverseKinematicsResult,
    KinematicChain,
    RobotModel,
    solve_inverse_kinematics,
)

__all__ = [
    "InverseKinematics",
    "InverseKinematicsConfig",
    "InverseKinematicsResult",
    "KinematicChain",
    "RobotModel",
    "solve_inverse_kinematics",
]
