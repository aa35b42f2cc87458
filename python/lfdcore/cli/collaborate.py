"""lfdcore collaborate: the robot's motion, from a glimpse of its partner and the scene (Ch. 5)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lfdcore.cli.common import (
    JsonOption,
    print_facts,
    print_json,
    progress_bar,
    require_drawable,
    require_writable,
    save_picture,
)

if TYPE_CHECKING:
    from lfdcore.datasets.interaction import InteractionRecording
    from lfdcore.datasets.joint_motion import JointMotion
    from lfdcore.humanoid.arm import ArmMotion, GripperMount
    from lfdcore.humanoid.collaboration import CollaborationInference, CollaborationModel
    from lfdcore.humanoid.execution import Execution
    from lfdcore.kinematics import RobotModel

PERIOD = 0.02
"""[s] between the samples of a written motion"""
SHOWN = 9
"""lines of the motion that are printed"""
STOPPED = 130
"""exit code where Ctrl-C stopped the robot, as of every command that it ends"""


def collaborate(
    model_file: Annotated[Path, typer.Argument(metavar="MODEL", help="What `lfdcore learn collaboration` made.")],
    observe: Annotated[Path, typer.Option(help="What was seen of the partner: a recording (.npz).")],
    until: Annotated[float | None, typer.Option(min=0, help="Use only its first seconds. Default: all of it.")] = None,
    environment: Annotated[
        Path | None, typer.Option(help="The scene: JSON with names and numbers. Default: as the recording has it.")
    ] = None,
    urdf: Annotated[Path | None, typer.Option(help="The robot. Default: Baxter.")] = None,
    base: Annotated[str, typer.Option(help="Link in whose frame motions are given.")] = "base",
    tip: Annotated[
        str | None, typer.Option(help="Link that carries the gripper. Default: left_hand_link or right_hand_link.")
    ] = None,
    tool: Annotated[
        float | None,
        typer.Option(help="Metres from that link to where the gripper grasps, along z. Default: a Robotiq gripper's."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Joint trajectory (.mcap, .csv), from now on.")
    ] = None,
    picture: Annotated[Path | None, typer.Option(help="What is seen, expected and done (.png, .pdf, .svg).")] = None,
    execute: Annotated[
        bool,
        typer.Option(
            "--execute", help="Run it at 100 Hz on a kinematic robot; Ctrl-C stops it, it holds, exit code 130."
        ),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Infer the robot's whole motion. The part still ahead is written as joint positions inside the robot's limits.

    Where the arm cannot follow, the inferred motion is printed, nothing is written or executed, and the exit code is 1.
    """
    from lfdcore.datasets.interaction import load_interaction
    from lfdcore.humanoid.arm import GripperMount
    from lfdcore.humanoid.collaboration import CollaborationModel
    from lfdcore.humanoid.scene import read_environment

    _require_options(output, picture, tool, [model_file, observe])
    mount = GripperMount(base, tip) if tool is None else GripperMount(base, tip, tool)
    model, recording = CollaborationModel.load(model_file), load_interaction(observe)
    seen = recording.partial(share=1.0) if until is None else recording.partial(seconds=until)
    scene = read_environment(environment) if environment is not None else recording.environment
    inference = model.infer(seen, scene)
    facts, robot = _facts(model, inference, seen, scene), _robot(urdf)
    joints, outcome = _joints(robot, model, inference, mount)
    facts["arm"] = outcome
    if picture is not None:
        from lfdcore.pictures.collaboration import collaboration_figure

        save_picture(collaboration_figure(model, inference, seen), picture)
    aborted = joints is not None and _done(joints, robot, output, execute, facts)
    _print(facts, model, inference, as_json)
    if joints is None:
        raise ValueError(f"the arm {outcome}. Nothing was written or executed")
    if aborted:
        raise typer.Exit(STOPPED)


def _require_options(output: Path | None, picture: Path | None, tool: float | None, inputs: list[Path]) -> None:
    """Before the work."""
    require_drawable("--picture", picture)
    if tool is not None and not math.isfinite(tool):
        raise typer.BadParameter(f"--tool {tool} must be finite")
    if output is None:
        return
    if output.suffix not in (".mcap", ".csv"):
        raise typer.BadParameter(f"--output {output} must end in .mcap or .csv")
    require_writable(output, inputs)


def _done(joints: JointMotion, robot: RobotModel, output: Path | None, execute: bool, facts: dict[str, Any]) -> bool:
    """Writes and executes what was asked for -> was it stopped?"""
    if output is not None:
        from lfdcore.datasets.joint_motion import write_joint_motion

        write_joint_motion(joints, output)
        facts["written"] = f"{output}: {len(joints.time)} samples of {len(joints.names)} joints"
    if not execute:
        return False
    execution = _execute(robot, joints)
    facts["executed"] = _execution_words(execution)
    return execution.aborted


def _facts(
    model: CollaborationModel, inference: CollaborationInference, seen: InteractionRecording, scene: dict[str, float]
) -> dict[str, Any]:
    phase = inference.phase
    known = phase is not None and phase.determined
    used = {name: scene[name] for name in model.environment_names}
    return {
        "observed": f"{seen.duration:.2f} s of the partner, {len(seen)} samples",
        "phase": f"{100 * inference.share:.0f} % of the motion" if known else "not distinguishable from the start yet",
        "duration": f"{inference.duration:.2f} s at the partner's tempo (demonstrated {model.duration:.2f} s)",
        "environment": ", ".join(f"{name} {_environment_words(model, name, value)}" for name, value in used.items())
        or "not used",
    }


def _robot(urdf: Path | None) -> RobotModel:
    from lfdcore.humanoid.baxter import baxter_urdf
    from lfdcore.kinematics import RobotModel

    return RobotModel.from_urdf_file(str(urdf or baxter_urdf()))


def _joints(
    robot: RobotModel, model: CollaborationModel, inference: CollaborationInference, mount: GripperMount
) -> tuple[JointMotion | None, str]:
    """The motion from now on, None where the arm cannot follow it; what became of it, in words."""
    from lfdcore.humanoid.arm import follow_gripper, follow_joints

    time, motion = inference.motion_from_now(PERIOD)
    if set(model.robot.names) <= set(robot.joint_names):
        return _learned_joints(robot, follow_joints(robot, model.robot.names, time, motion), time[-1])
    arm = follow_gripper(robot, model.robot.names, time, motion, mount)
    return (arm.joints if arm.followed else None), _arm_words(robot, arm)


def _learned_joints(robot: RobotModel, joints: JointMotion, wanted: float) -> tuple[JointMotion | None, str]:
    from lfdcore.humanoid.arm import self_clearance
    from lfdcore.kinematics import FollowConfig

    apart, sample = self_clearance(robot, joints)
    if apart < FollowConfig().clearance:
        return None, f"cannot follow from sample {sample} on: self collision; links come to {apart:.3f} m"
    near = f"links keep {apart:.3f} m apart" if robot.collision_shapes else _UNCHECKED
    return joints, f"joints were learned: {joints.duration / wanted:.2f} times as long inside all limits; {near}"


_UNCHECKED = "self-collision was not looked for: the robot has no collision shapes"


def _environment_words(model: CollaborationModel, name: str, value: float) -> str:
    """A value of the environment, and a warning where nothing like it was demonstrated."""
    low, high = model.demonstrated(name)
    return f"{value:g}" if low <= value <= high else f"{value:g} (BEYOND THE DEMONSTRATIONS: {low:g} to {high:g})"


def _arm_words(robot: RobotModel, arm: ArmMotion) -> str:
    from lfdcore.kinematics import FollowConfig

    result = arm.result
    names = [robot.link_names[k] for k in result.nearest_links] if result.nearest_links else []
    near = f"links keep {result.clearance:.3f} m apart ({', '.join(names)})" if names else ""
    near = near if robot.collision_shapes else _UNCHECKED
    if arm.followed:
        errors = f"{1e3 * result.position_error:.2f} mm, {result.rotation_error:.1e} rad off at most"
        return f"followed inside all limits: {errors}; {result.slowdown:.2f} times as long; {near}"
    if result.outcome == "self_collision":
        near += f", must be {FollowConfig().clearance:g} m"
    outcome = f"cannot follow from sample {result.first_failure} on: {result.outcome.replace('_', ' ')}"
    return f"{outcome}; {near}" if near else outcome


def _execute(robot: RobotModel, joints: JointMotion) -> Execution:
    """In real time. Ctrl-C aborts: the robot holds where it is."""
    from lfdcore.humanoid.execution import KinematicRobot, in_real_time

    limits = robot.limits[[robot.joint_names.index(name) for name in joints.names]]
    arm = KinematicRobot(joints.positions[0], limits, joints.names)
    with progress_bar() as bar:
        bar.start()
        task = bar.add_task("execute", total=joints.duration)
        return in_real_time(joints, arm, lambda time: bar.update(task, completed=time))


def _execution_words(execution: Execution) -> str:
    worst, joint = execution.largest_error
    end = f"; stopped after {execution.ticks[-1].time:.2f} s, it holds where it is" if execution.aborted else ""
    errors = f"tracking error {execution.rms_error:.1e} rad RMS, at most {worst:.1e} ({joint})"
    return f"{len(execution.ticks)} targets at 100 Hz, {errors}{end}"


def _rows(inference: CollaborationInference, model: CollaborationModel) -> list[dict[str, float]]:
    import numpy as np

    motion = inference.robot_motion()
    rows = []
    for k in np.linspace(0, len(motion) - 1, SHOWN).round().astype(int).tolist():
        time = inference.duration * k / (len(motion) - 1)
        rows.append({"time": time, **dict(zip(model.robot.names, motion[k].tolist(), strict=True))})
    return rows


def _print(facts: dict[str, Any], model: CollaborationModel, inference: CollaborationInference, as_json: bool) -> None:
    rows = _rows(inference, model)
    if as_json:
        print_json({**facts, "share": inference.share, "motion": rows})
        return
    print_facts(facts)
    width = max(8, *(len(name.rpartition(".")[2]) + 2 for name in model.robot.names))
    names = ["time [s]", *(name.rpartition(".")[2] or name for name in model.robot.names)]
    typer.echo("\n" + "".join(f"{name:>{max(width, 10)}}" for name in names))
    for row in rows:
        typer.echo("".join(f"{value:>{max(width, 10)}.3f}" for value in row.values()))
