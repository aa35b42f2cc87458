"""Joint-space primitives beside Cartesian ones (Sec. 6.2.2): the covering task with a Baxter's left arm.

The same demonstrations are learned from twice: the gripper's poses, and the joints that follow those poses by inverse
kinematics, the right arm holding the bag's other end. Inferred from the protocol's first seconds of a person who was
not seen in training, and e; judged through the forward kinematics of the joints that the arm would be sent.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.datasets.joint_motion import JointMotion
from lfdcore.humanoid.arm import follow_gripper, follow_joints, gripper_poses, self_clearance
from lfdcore.humanoid.baxter import ARM_PARTS, arm_capsules, baxter, baxter_arm, holding_posture
from lfdcore.humanoid.collaboration import CollaborationInference, CollaborationModel
from lfdcore.humanoid.covering import covering_verdict
from lfdcore.humanoid.scene import Box, box_of
from lfdcore.kinematics import FollowConfig, KinematicChain, RobotModel
from lfdcore.progress import StageProgress, silent
from lfdcore.simulated.covering import (
    BOUNDING_BOX,
    PERIOD,
    RIGHT_GRIPPER,
    ROBOT_NAMES,
    SEED,
    CoveringData,
    CoveringProtocol,
    covering_data,
)
from lfdcore.study.jobs import run_jobs
from lfdcore.study.study import Option, Seed, Study
from lfdcore.training.collaborations import NoiseChoice, learn_collaboration

Floats = NDArray[np.float64]

JOINTS, GRIPPER = "joint space", "Cartesian"
SPACES = (JOINTS, GRIPPER)
FOLLOWED, OUTSIDE = "followed", "outside_limits"
SHOWN = 100
"""steps of the motions that pictures show"""


@dataclass(frozen=True, kw_only=True)
class JointSpaceStudy(Study):
    """The covering task learned as joint angles and as gripper poses: paths, limits, collisions, time."""

    name = "joints"
    title = "joint-space primitives"

    seeds: Annotated[int, Option("Repetitions with people of their own, from --seed on.", minimum=1)] = 10
    held_out: Annotated[int, Option("People who are not learned from, at each object.", minimum=1)] = 3
    seed: Seed = SEED
    protocol: CoveringProtocol = BOUNDING_BOX
    few: int = 2
    """demonstrations of each object in a second round: what does each space make of little?"""
    choice: NoiseChoice = dataclasses.field(default_factory=NoiseChoice)
    """of the noise, for each space by itself"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.few < 1:
            raise ValueError(f"few is {self.few}, must be at least 1")


@dataclass(frozen=True)
class ArmTrial:
    """What one space's model made of one person's first seconds at one object. Errors are of the whole inferred motion.
    All below them are of its part still ahead, as joints that the arm would be sent; NaN where it cannot be sent."""

    seed: int
    space: str
    covered_object: str
    novel: bool
    person: int
    position_error: float
    """[m] RMS of the gripper's place to the held-out demonstration's, along the motion"""
    rotation_error: float
    """[rad] RMS of the gripper's orientation"""
    beyond: float
    """[rad] farthest of an inferred joint outside its position limits; 0 in Cartesian space, which has no joints yet"""
    outcome: str
    """'followed', 'outside_limits', or as lfdcore.kinematics.FollowResult"""
    slowdown: float
    """duration over the inferred one: above 1 where joints would have been too fast"""
    clearance: float
    """[m] smallest distance of the robot's own links"""
    covered: bool
    """without mouth or arm nearer to the object than CLEARANCE"""
    covered_by_mouth: bool
    """the same, the arm left out of account"""
    mouth: float
    """[m] nearest to the object"""
    arm: tuple[float, float, float]
    """[m] nearest of each of ARM_PARTS"""
    margin: float
    """[rad] smallest distance of a joint from its position limits"""
    speed: float
    """largest share of a joint's velocity limit"""
    seconds: tuple[float, float, float]
    """to infer the rest of the motion; to make joints of it; in joint space, to look for self-collision after"""

    def row(self) -> dict[str, object]:
        """For machines, without times."""
        said: dict[str, object] = dataclasses.asdict(self)
        del said["seconds"], said["arm"]
        return {**said, **dict(zip(ARM_PARTS, self.arm, strict=True))}


@dataclass(frozen=True, eq=False)
class ShownArms:
    """What pictures show of one person at one object, all SHOWN steps of whole motions."""

    covered_object: str
    box: Box
    names: tuple[str, ...]
    """of the joints, (7,)"""
    time: Floats
    """(SHOWN,) [s]"""
    demonstrated: Floats
    """(S, SHOWN, 7) [rad]"""
    joints: dict[str, Floats]
    """by space: (SHOWN, 7) [rad] inferred, or by inverse kinematics of what was inferred"""
    deviation: Floats
    """(SHOWN, 7) [rad] of the joint-space posterior"""
    paths: dict[str, Floats]
    """'demonstration' and by space: (SHOWN, 3) [m, base] of the gripper"""


@dataclass(frozen=True, eq=False)
class JointSpaceRun:
    """One seed."""

    seed: int
    demonstrations: int
    """learned from in both spaces"""
    left_out: int
    """demonstrations that the arm cannot follow, learned from in neither"""
    trials: tuple[ArmTrial, ...]
    shown: ShownArms


@dataclass(frozen=True, eq=False)
class JointSpaceResult:
    """All seeds."""

    study: JointSpaceStudy
    runs: tuple[JointSpaceRun, ...]
    """with the protocol's demonstrations"""
    few: tuple[JointSpaceRun, ...]
    """with study.few of each object, the same seeds and held-out people"""

    @property
    def trials(self) -> list[ArmTrial]:
        """Of all seeds, with the protocol's demonstrations."""
        return [trial for run in self.runs for trial in run.trials]


def run_joint_space_study(study: JointSpaceStudy, tell: StageProgress = silent) -> JointSpaceResult:
    """Every seed of `study` twice, over processes."""
    seeds = range(study.seed, study.seed + study.seeds)
    counts = (study.protocol.demonstrations, study.few)
    jobs = [JointSpaceJob(study, seed, count) for count in counts for seed in seeds]
    runs = run_jobs(jobs, partial(tell, "learn and judge, seed by seed"), study.processes)
    return JointSpaceResult(study, runs[: study.seeds], runs[study.seeds :])


@dataclass(frozen=True)
class JointSpaceJob:
    """One seed's work, for another process."""

    study: JointSpaceStudy
    seed: int
    demonstrations: int
    """of each object"""

    def run(self) -> JointSpaceRun:
        """Learns in both spaces and judges all held-out people."""
        protocol = dataclasses.replace(self.study.protocol, demonstrations=self.demonstrations)
        data = covering_data(protocol, self.seed, held_out=self.study.held_out)
        setting = ArmSetting.of(data)
        pairs = [(one, made) for one in data.training if (made := setting.in_joints(one)) is not None]
        training = {GRIPPER: [one for one, _ in pairs], JOINTS: [made for _, made in pairs]}
        models = {space: learn_collaboration(training[space], choice=self.study.choice) for space in SPACES}
        trials = [
            _trial(self.seed, setting, data.protocol, models[space], space, one, (novel, person))
            for novel, people in ((False, data.known), (True, data.novel))
            for each in people.values()
            for person, one in enumerate(each)
            for space in SPACES
        ]
        example = list(data.novel.values())[-1][0]
        shown = _shown(setting, data.protocol, models, training[JOINTS], example)
        return JointSpaceRun(self.seed, len(pairs), len(data.training) - len(pairs), tuple(trials), shown)


@dataclass(frozen=True, eq=False)
class ArmSetting:
    """The robot whose right gripper holds the bag, and where its left arm begins."""

    robot: RobotModel
    chain: KinematicChain
    posture: Floats
    """(N,) [rad]"""
    start: Floats
    """(7,) [rad] at the first demonstration's first pose: what all inverse kinematics begins from, or a redundant arm
    would do the same motion in another way each time, and the mean of two ways is none"""

    @staticmethod
    def of(data: CoveringData) -> ArmSetting:
        """For these demonstrations. ValueError where the arm cannot follow the first of them."""
        robot, first = baxter(), data.training[0]
        posture = holding_posture(robot, "right", RIGHT_GRIPPER)
        arm = follow_gripper(robot, first.robot_names, first.stamp, first.robot, posture=posture)
        if not arm.followed or arm.joints is None:
            raise ValueError(f"{first.name}: the arm cannot follow it: {arm.result.outcome}")
        return ArmSetting(robot, baxter_arm(robot, "left"), posture, arm.joints.positions[0])

    def in_joints(self, one: InteractionRecording) -> InteractionRecording | None:
        """The same with joint columns, as a demonstrator's led arm records them; None where the arm cannot follow at
        the demonstrated pace."""
        joints, outcome, slowdown = self.follow(one.stamp, one.robot)
        if joints is None or outcome != FOLLOWED or slowdown > 1:
            return None
        return dataclasses.replace(one, robot=joints.positions, robot_names=joints.names)

    def follow(self, time: Floats, motion: Floats) -> tuple[JointMotion | None, str, float]:
        """Gripper's columns (T, 7) -> joints unless it fails, outcome, slowdown."""
        arm = follow_gripper(self.robot, ROBOT_NAMES, time, motion, posture=self.posture, start=self.start)
        return (arm.joints if arm.followed else None), arm.result.outcome, arm.result.slowdown

    def sent(self, space: str, time: Floats, motion: Floats) -> tuple[JointMotion | None, str, float]:
        """An inferred motion of either space as joints inside the limits unless it fails, outcome, slowdown."""
        if space == GRIPPER:
            return self.follow(time, motion)
        if self.beyond(motion) > 0:
            return None, OUTSIDE, np.nan
        joints = follow_joints(self.robot, self.chain.joint_names, time, motion)
        return joints, FOLLOWED, joints.duration / (time[-1] - time[0])

    def checked(self, space: str, joints: JointMotion | None, outcome: str) -> tuple[JointMotion | None, str]:
        """Joints of joint space only where links keep apart; in Cartesian space they do, or `follow` failed."""
        if space == GRIPPER or joints is None:
            return joints, outcome
        apart, _ = self_clearance(self.robot, joints, self.posture)
        return (joints, outcome) if apart >= FollowConfig().clearance else (None, "self_collision")

    def beyond(self, positions: Floats) -> float:
        """[rad] farthest outside the position limits, 0 inside."""
        return max(self.excess(positions), 0.0)

    def excess(self, positions: Floats) -> float:
        """[rad] farthest outside the position limits, negative inside."""
        return float(np.maximum(self.chain.lower - positions, positions - self.chain.upper).max())

    def poses(self, positions: Floats) -> Floats:
        """(T, 7) [rad] -> T_base_gripper (T, 4, 4)."""
        return np.array([self.chain.forward(q) for q in positions])


def rotation_angles(a: Floats, b: Floats) -> Floats:
    """(T,) [rad] between orientations of poses (T, 4, 4)."""
    cosine = (np.einsum("tij,tij->t", a[:, :3, :3], b[:, :3, :3]) - 1) / 2
    return np.asarray(np.arccos(cosine.clip(-1, 1)))


def _infer(model: CollaborationModel, protocol: CoveringProtocol, one: InteractionRecording) -> CollaborationInference:
    return model.infer(one.partial(seconds=protocol.observed), one.environment)


def _trial(
    seed: int,
    setting: ArmSetting,
    protocol: CoveringProtocol,
    model: CollaborationModel,
    space: str,
    one: InteractionRecording,
    where: tuple[bool, int],
) -> ArmTrial:
    begin = perf_counter()
    inference = _infer(model, protocol, one)
    time, motion = inference.motion_from_now(PERIOD)
    between = perf_counter()
    joints, outcome, slowdown = setting.sent(space, time, motion)
    made = perf_counter()
    joints, outcome = setting.checked(space, joints, outcome)
    seconds = (between - begin, made - between, perf_counter() - made)
    whole = inference.robot_motion()
    position, rotation = _errors(setting, space, whole, one)
    beyond = setting.beyond(whole) if space == JOINTS else 0.0
    judged = _judged(setting, joints, box_of(one))
    named = {"seed": seed, "space": space, "covered_object": one.metadata["object"], "novel": where[0]}
    errors = {"position_error": position, "rotation_error": rotation, "beyond": beyond}
    sent = {"outcome": outcome, "slowdown": slowdown, "seconds": seconds}
    said: dict[str, Any] = {**named, "person": where[1], **errors, **sent, **judged}
    return ArmTrial(**said)


def _errors(setting: ArmSetting, space: str, whole: Floats, one: InteractionRecording) -> tuple[float, float]:
    """RMS [m] and [rad] of an inferred whole motion to the demonstration's, at equal shares of the time."""
    truth = gripper_poses(ROBOT_NAMES, one.resample(len(whole), np.inf).robot)
    made = setting.poses(whole) if space == JOINTS else gripper_poses(ROBOT_NAMES, whole)
    off = np.linalg.norm(made[:, :3, 3] - truth[:, :3, 3], axis=1)
    return float(np.sqrt(np.mean(off**2))), float(np.sqrt(np.mean(rotation_angles(made, truth) ** 2)))


def _judged(setting: ArmSetting, joints: JointMotion | None, box: Box) -> dict[str, Any]:
    """What comes of the joints at the object and at the robot itself."""
    if joints is None:
        never = dict.fromkeys(("clearance", "mouth", "margin", "speed"), np.nan)
        return {**never, "covered": False, "covered_by_mouth": False, "arm": (np.nan,) * len(ARM_PARTS)}
    links = arm_capsules(setting.robot, "left", joints.positions)
    verdict = covering_verdict(setting.poses(joints.positions)[:, :3, 3], RIGHT_GRIPPER, box, links=links)
    clearance, _ = self_clearance(setting.robot, joints, setting.posture)
    return {
        "covered": verdict.success,
        "covered_by_mouth": verdict.success_of_mouth,
        "clearance": clearance,
        "mouth": verdict.mouth.distance,
        "arm": tuple(link.distance for link in verdict.links),
        "margin": -setting.excess(joints.positions),
        "speed": float((np.abs(joints.velocities) / setting.chain.velocity).max()),
    }


def _shown(
    setting: ArmSetting,
    protocol: CoveringProtocol,
    models: dict[str, CollaborationModel],
    training: Sequence[InteractionRecording],
    one: InteractionRecording,
) -> ShownArms:
    inferred = {space: _infer(models[space], protocol, one) for space in SPACES}
    wholes = {space: _thinned(inferred[space].robot_motion()) for space in SPACES}
    time = np.linspace(0, inferred[JOINTS].duration, SHOWN)
    followed, _, _ = setting.follow(time, wholes[GRIPPER])
    by_kinematics = np.full((SHOWN, len(setting.start)), np.nan) if followed is None else followed.positions
    return ShownArms(
        one.metadata["object"],
        box_of(one),
        tuple(setting.chain.joint_names),
        time,
        np.array([each.resample(SHOWN, np.inf).robot for each in training]),
        {JOINTS: wholes[JOINTS], GRIPPER: by_kinematics},
        _thinned(inferred[JOINTS].robot_deviation()),
        {
            "demonstration": one.resample(SHOWN, np.inf).robot[:, :3],
            JOINTS: setting.poses(wholes[JOINTS])[:, :3, 3],
            GRIPPER: wholes[GRIPPER][:, :3],
        },
    )


def _thinned(motion: Floats) -> Floats:
    return np.asarray(motion[np.linspace(0, len(motion) - 1, SHOWN).round().astype(int)])
