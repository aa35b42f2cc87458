"""What is seen of a partner, what is expected of both, and how sure that is (Ch. 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationInference, CollaborationModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


def collaboration_figure(
    model: CollaborationModel, inference: CollaborationInference, seen: InteractionRecording
) -> Figure:
    """Partner and robot over time: what was seen, the posterior's mean, two standard deviations of what the robot
    learns, and where the partner is now."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), layout="constrained")
    partner, robot = figure.subplots(1, 2)
    time = np.linspace(0, inference.duration, inference.steps)
    _partner(partner, model, inference.partner_motion(), time, seen)
    _robot(robot, model, inference, time)
    for axes in (partner, robot):
        axes.axvline(inference.share * inference.duration, color="0.5", linestyle=":", linewidth=1)
        axes.set_xlabel("time of the motion [s]; dotted: now")
        axes.legend(fontsize=7, ncols=2)
    return figure


def _partner(axes: Axes, model: CollaborationModel, motion: Array, time: Array, seen: InteractionRecording) -> None:
    for k, name in enumerate(model.partner_names[: len(_COLOURS)]):
        axes.plot(time, motion[:, k], color=_COLOURS[k], linewidth=1.2, label=name)
        if name in seen.partner_names:
            column = seen.partner[:, seen.partner_names.index(name)]
            axes.plot(seen.stamp - seen.stamp[0], column, ".", color=_COLOURS[k], markersize=3)
    more = len(model.partner_names) - len(_COLOURS)
    axes.set_title("partner: seen (dots), expected" + (f"; {more} columns more" if more > 0 else ""), fontsize=9)


def _robot(axes: Axes, model: CollaborationModel, inference: CollaborationInference, time: Array) -> None:
    motion, deviation = inference.robot_motion(), inference.robot_deviation()
    shown = [k for k, name in enumerate(model.robot.names) if name.rpartition(".")[2] not in ("qx", "qy", "qz", "qw")]
    for place, k in enumerate(shown[: len(_COLOURS)]):
        colour = _COLOURS[place]
        spread = 2 * deviation[:, _learned(model, k)]
        axes.plot(time, motion[:, k], color=colour, linewidth=1.4, label=model.robot.names[k])
        axes.fill_between(time, motion[:, k] - spread, motion[:, k] + spread, color=colour, alpha=0.15, linewidth=0)
    axes.set_title("robot: inferred, and two standard deviations", fontsize=9)


def _learned(model: CollaborationModel, column: int) -> int:
    """Which learned column a recorded one that is no quaternion became."""
    return column - sum(begin < column for begin in model.robot.quaternions)


_COLOURS = [f"C{k}" for k in range(10)]
