"""
Robots from URDF: chains, inverse kinematics, joint trajectories.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
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

class KinematicChain:
    """
    The joints from a base link to a tool, n of them; made by RobotModel.chain().
    """

    def __len__(self) -> int: ...
    def forward(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        T_base_tool (4, 4) at q (n,), also outside the limits. ValueError for another length or values that are not finite.
        """

    def jacobian(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        (6, n): linear [m/s], then angular [rad/s] velocity of the tool's origin in the base frame by joint velocity. Errors like forward().
        """

    @property
    def joint_names(self) -> list[str]: ...
    @property
    def lower(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n,) [rad or m], -inf of a continuous joint
        """

    @property
    def reach(self) -> float:
        """
        the tool is never farther than this from the first joint [m]; a bound
        """

    @property
    def upper(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n,) [rad or m], inf of a continuous joint
        """

    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n,) [rad/s or m/s]
        """

class RobotModel:
    """
    A robot read from a URDF (urdfdom, KDL). Joints and links come depth first from the root, siblings by the names of their joints; a mimic joint is a joint of its own.
    """

    @staticmethod
    def from_urdf(xml: str) -> RobotModel:
        """
        From a URDF's text. DataError for what is no URDF of a tree of fixed, revolute, continuous and
        prismatic joints: malformed or truncated XML, XML with a document type or entities, above 16 MiB
        or 2000 links, links without names or with two parents, loops, joints without limits or with axes of
        length zero.
        """

    @staticmethod
    def from_urdf_file(path: typing.Any) -> RobotModel:
        """
        The same from a file; also DataError where it cannot be read.
        """

    def chain(self, base: str, tip: str, T_tip_tool: numpy.typing.ArrayLike = ...) -> KinematicChain:
        """
        The chain from `base` to the tool that T_tip_tool (4, 4) places in the frame of `tip`, both names of
        links. ValueError for unknown links, a chain without movable joints or no rigid transform.
        """

    def forward(self, q: numpy.typing.ArrayLike, link: str) -> numpy.typing.NDArray[numpy.float64]:
        """
        T_root_link (4, 4) at q (N,), joints as in joint_names. ValueError for another length, values that are not finite or an unknown link.
        """

    @property
    def collision_shapes(
        self,
    ) -> list[tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], float]]:
        """
        (link, begin (3,), end (3,) [m, in the link's frame], radius [m]) of every sphere and of
        the capsules that contain cylinders and boxes; meshes are not read
        """

    @property
    def joint_names(self) -> list[str]:
        """
        N movable joints
        """

    @property
    def limits(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N, 3) lower, upper [rad or m; -inf, inf of a continuous joint], velocity [rad/s or m/s]
        """

    @property
    def link_names(self) -> list[str]:
        """
        the root first
        """

    @property
    def name(self) -> str: ...

class InverseKinematicsConfig:
    """
    Settings of the inverse kinematics.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        position_tolerance: float = 1e-05,
        rotation_tolerance: float = 1e-05,
        iterations: int = 60,
        restarts: int = 1500,
        postures: int = 4096,
        damping: float = 0.01,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def damping(self) -> float:
        """
        times the squared error, of the normal equations
        """

    @property
    def iterations(self) -> int:
        """
        at most, of one descent
        """

    @property
    def position_tolerance(self) -> float:
        """
        of a solution [m]
        """

    @property
    def postures(self) -> int:
        """
        fixed ones that restarts are chosen from
        """

    @property
    def restarts(self) -> int:
        """
        descents at most, besides that from a seed; 0: only from the seed
        """

    @property
    def rotation_tolerance(self) -> float:
        """
        of a solution [rad]
        """

class InverseKinematicsResult:
    """
    What a search for joint positions came to.
    """

    @property
    def iterations(self) -> int:
        """
        of all descents together
        """

    @property
    def joints(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (n,) inside the limits; unless solved, the nearest that was met; a view
        """

    @property
    def position_error(self) -> float:
        """
        [m]
        """

    @property
    def restarts(self) -> int:
        """
        descents made after the first
        """

    @property
    def rotation_error(self) -> float:
        """
        [rad]
        """

    @property
    def solved(self) -> bool:
        """
        within both tolerances
        """

class InverseKinematics:
    """
    Solver for one chain. Descents are Levenberg-Marquardt's, damped in proportion to the squared error (Sugihara
    2011), joints that would leave their limits held at them and the rest solved again. Restarts begin at those of
    a fixed set of postures (mid-range and Halton's points of the joint space, whatever the pose) whose tools are
    nearest to the pose. Deterministic; may be shared between threads.
    """

    def __init__(self, chain: KinematicChain, *, config: InverseKinematicsConfig = ...) -> None: ...
    def solve(
        self, T_base_tool: numpy.typing.ArrayLike, seed: numpy.typing.ArrayLike | None = None
    ) -> InverseKinematicsResult:
        """
        For the pose T_base_tool (4, 4): from `seed` (n,) first, where one is given (brought inside the limits),
        then by restarts; beyond the length of the stretched arm one descent must do. ValueError for no rigid
        transform or a seed of another length.
        """

class SelfCollision:
    """
    How far a robot's links are from each other: spheres as they are, cylinders and boxes as the capsules that
    contain them. Not compared: links that at most two joints move against each other (their limits must keep them
    apart), pairs that overlap in every one of 200 fixed random postures, and `ignored` pairs of names.
    """

    def __init__(self, model: RobotModel, ignored: collections.abc.Sequence[tuple[str, str]] = []) -> None:
        """
        ValueError for unknown links or a robot without collision shapes (meshes are not read).
        """

    def distance(self, q: numpy.typing.ArrayLike) -> float:
        """
        Smallest distance [m] at q (N,) of all of the robot's joints, below 0 where links overlap.
        """

    def nearest(self, q: numpy.typing.ArrayLike) -> tuple[typing.Any, ...]:
        """
        The smallest distance [m] and the names of the two links.
        """

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """
        the names of the links that are compared
        """

class FollowConfig:
    """
    Settings of follow_poses.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        inverse_kinematics: InverseKinematicsConfig = ...,
        centring: float = 0.3,
        clearance: float = 0.02,
        avoidance: float = 0.1,
        avoidance_speed: float = 0.5,
        largest_step: float = 0.3,
        velocity_share: float = 1.0,
        smoothing: float = 0.2,
        starts: int = 8,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def avoidance(self) -> float:
        """
        from this distance of links on, free joints part them [m]
        """

    @property
    def avoidance_speed(self) -> float:
        """
        of that motion where links touch [rad/s]
        """

    @property
    def centring(self) -> float:
        """
        rate at which free joints tend to mid-range [1/s]
        """

    @property
    def clearance(self) -> float:
        """
        that links must keep from each other [m]
        """

    @property
    def inverse_kinematics(self) -> InverseKinematicsConfig:
        """
        of each pose
        """

    @property
    def largest_step(self) -> float:
        """
        of a joint from sample to sample; more counts as a jump [rad or m]
        """

    @property
    def smoothing(self) -> float:
        """
        slowing down spreads this far to both sides [s]
        """

    @property
    def starts(self) -> int:
        """
        first postures tried where none is given
        """

    @property
    def velocity_share(self) -> float:
        """
        of the velocity limits that is used
        """

class JointTrajectory:
    """
    Positions and velocities of n joints at T times.
    """

    @property
    def positions(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (T, n) [rad or m]; a view
        """

    @property
    def time(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (T,) [s], increasing; a view
        """

    @property
    def velocities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (T, n) [rad/s or m/s]; a view
        """

class FollowResult:
    """
    What following a trajectory of the tool came to.
    """

    @property
    def clearance(self) -> float:
        """
        smallest distance of links [m]; inf without self_collision
        """

    @property
    def first_failure(self) -> int | None:
        """
        index of the first pose not followed, or None
        """

    @property
    def nearest_links(self) -> tuple[int, int] | None:
        """
        indices into RobotModel.link_names of the two links at `clearance`, or None
        """

    @property
    def outcome(self) -> str:
        """
        'followed' | 'out_of_reach' (no posture inside the limits reaches the pose) | 'no_continuous_path' (one does, but not without a jump) | 'self_collision' (links nearer than the clearance, free joints cannot help)
        """

    @property
    def position_error(self) -> float:
        """
        largest [m]
        """

    @property
    def rotation_error(self) -> float:
        """
        largest [rad]
        """

    @property
    def slowdown(self) -> float:
        """
        duration over the wanted duration
        """

    @property
    def trajectory(self) -> JointTrajectory:
        """
        unless followed, only what comes before the failure
        """

def follow_poses(
    chain: KinematicChain,
    time: numpy.typing.ArrayLike,
    T_base_tool: numpy.typing.ArrayLike,
    start: numpy.typing.ArrayLike | None = None,
    config: FollowConfig = ...,
    *,
    self_collision: SelfCollision | None = None,
    posture: numpy.typing.ArrayLike | None = None,
) -> FollowResult:
    """
    Joint positions and velocities that follow poses T_base_tool (T, 4, 4) at `time` (T,) [s], sample by sample
    from the last posture, inside the position limits; joints that the pose leaves free tend to mid-range and away
    from self-collision. Where a joint would be faster than its limit, time is stretched there, smoothly: nothing
    is clipped, the path stays, it takes longer. From `start` (n,) (the first pose's posture is the one found from
    there), or from the best of several first postures. With self_collision, `posture` says where the robot's
    other joints are: (N,) or (T, N), the chain's own are replaced. Failure is in the result. ValueError for fewer
    than 2 poses, times that do not increase, other lengths, velocity limits of 0 or values that are not finite.
    """

def joint_velocities(
    time: numpy.typing.ArrayLike, positions: numpy.typing.ArrayLike
) -> numpy.typing.NDArray[numpy.float64]:
    """
    (T, n): slopes of the parabolas through each of positions (T, n) and its neighbours, of the chords at the
    ends; never above the fastest chord. ValueError like follow_poses.
    """

def slow_down(
    time: numpy.typing.ArrayLike,
    positions: numpy.typing.ArrayLike,
    velocity: numpy.typing.ArrayLike,
    smoothing: float = 0.2,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Times (T,) [s], from time[0] on, at which positions (T, n) keep inside velocity limits (n,): each interval
    takes as long as before or longer, stretches spread smoothly over `smoothing` [s] to both sides. For two arms:
    stack their positions. ValueError like follow_poses.
    """

def solve_inverse_kinematics(
    chain: KinematicChain,
    T_base_tool: numpy.typing.ArrayLike,
    config: InverseKinematicsConfig = ...,
    seed: numpy.typing.ArrayLike | None = None,
) -> InverseKinematicsResult:
    """
    One pose with a solver of its own (1 ms to make); see InverseKinematics.solve.
    """
