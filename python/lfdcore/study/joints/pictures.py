"""Joint trajectories with their spread, and the gripper's paths that they make, in both spaces (Sec. 6.2.2)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from lfdcore.pictures.style import ANOTHER, BODY, LEARNED, PAGE, UNKNOWN, styled
from lfdcore.simulated.covering import RIGHT_GRIPPER
from lfdcore.study.joints.study import GRIPPER, JOINTS, SPACES, JointSpaceRun, ShownArms

COLOURS = {JOINTS: ANOTHER, GRIPPER: LEARNED}
_STYLES = {JOINTS: "-", GRIPPER: "--"}


@styled
def joint_space_figure(run: JointSpaceRun) -> Figure:
    """A person at the protocol's last novel object: seven joints over time, then the gripper from behind the robot and
    from above."""
    shown = run.shown
    figure = Figure(figsize=(PAGE, 0.8 * PAGE), layout="constrained")
    axes = figure.subplots(3, 3).ravel()
    for k, name in enumerate(shown.names):
        _joint(axes[k], shown, k, name)
    _paths(axes[7], shown, (1, 2), "gripper and object, seen by the robot")
    axes[7].invert_xaxis()  # y points left
    _paths(axes[8], shown, (1, 0), "the same from above")
    axes[8].invert_xaxis()
    handles, labels = axes[0].get_legend_handles_labels()
    path_handles, path_labels = axes[7].get_legend_handles_labels()
    figure.legend(handles + path_handles[-3:], labels + path_labels[-3:], loc="outside lower center", ncols=3)
    return figure


def _joint(axes: Axes, shown: ShownArms, joint: int, name: str) -> None:
    share = np.linspace(0, 1, shown.demonstrated.shape[1])
    for k, one in enumerate(shown.demonstrated):
        axes.plot(share, one[:, joint], color=BODY, linewidth=0.5, label="demonstrations" if k == 0 else None)
    mean, spread = shown.joints[JOINTS][:, joint], 2 * shown.deviation[:, joint]
    said, colour = f"{JOINTS}: two standard deviations", COLOURS[JOINTS]
    axes.fill_between(share, mean - spread, mean + spread, color=colour, alpha=0.2, linewidth=0, label=said)
    labels = {JOINTS: f"{JOINTS}: inferred", GRIPPER: f"{GRIPPER}: inverse kinematics of what was inferred"}
    for space in SPACES:
        values = shown.joints[space][:, joint]
        axes.plot(share, values, _STYLES[space], color=COLOURS[space], linewidth=1.6, label=labels[space])
    axes.set_title(name)
    axes.set_xlabel("share of the motion")
    axes.set_ylabel("[rad]")


def _paths(axes: Axes, shown: ShownArms, columns: tuple[int, int], title: str) -> None:
    across, up = columns
    corner = [shown.box.centre[k] - shown.box.size[k] / 2 for k in columns]
    size = [shown.box.size[k] for k in columns]
    axes.add_patch(Rectangle((corner[0], corner[1]), size[0], size[1], color=UNKNOWN, label=shown.covered_object))
    axes.plot(RIGHT_GRIPPER[across], RIGHT_GRIPPER[up], "k^", label="right gripper, still")
    path = shown.paths["demonstration"]
    axes.plot(path[:, across], path[:, up], color="black", linewidth=1, label="held-out demonstration")
    for space in SPACES:
        path = shown.paths[space]
        axes.plot(path[:, across], path[:, up], _STYLES[space], color=COLOURS[space], linewidth=1.6)
    _frame(axes, shown, columns)
    axes.set_title(title)
    axes.set_xlabel(f"{'xyz'[across]} [m]")
    axes.set_ylabel(f"{'xyz'[up]} [m]")


def _frame(axes: Axes, shown: ShownArms, columns: tuple[int, int]) -> None:
    """Of the picture: paths and the right gripper; the box stands on the floor and would make them small."""
    points = np.vstack([*shown.paths.values(), RIGHT_GRIPPER])[:, list(columns)]
    low, high = points.min(axis=0) - 0.06, points.max(axis=0) + 0.06
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
