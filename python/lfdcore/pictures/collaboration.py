"""What is seen of a partner, what is expected of both, and how sure that is (Ch. 5)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationInference, CollaborationModel
from lfdcore.pictures.style import PAGE, REFERENCE, SERIES, series_colour, styled

Array = NDArray[np.float64]

_MOST = 10
"""columns of the partner and of the robot that are drawn"""


@styled
def collaboration_figure(
    model: CollaborationModel, inference: CollaborationInference, seen: InteractionRecording
) -> Figure:
    """Partner and robot over time: what was seen, the posterior's mean, two standard deviations of what the robot
    learns, and where the partner is now."""
    figure = Figure(figsize=(PAGE, 4.6), layout="constrained")
    partner, robot = figure.subplots(1, 2)
    time = np.linspace(0, inference.duration, inference.steps)
    _partner(partner, model, inference.partner_motion(), time, seen)
    _robot(robot, model, inference, time)
    for axes in (partner, robot):
        axes.axvline(inference.share * inference.duration, color=REFERENCE, linestyle=":", linewidth=1)
        axes.set_xlabel("time of the motion [s]; dotted: now")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, frameon=False)
    return figure


def _partner(axes: Axes, model: CollaborationModel, motion: Array, time: Array, seen: InteractionRecording) -> None:
    for k, name in enumerate(model.partner_names[:_MOST]):
        axes.plot(time, motion[:, k], _dashes(k), color=series_colour(k), linewidth=1.2, label=name)
        if name in seen.partner_names:
            column = seen.partner[:, seen.partner_names.index(name)]
            axes.plot(seen.stamp - seen.stamp[0], column, ".", color=series_colour(k), markersize=3)
    more = len(model.partner_names) - _MOST
    axes.set_title("partner: seen (dots), expected" + (f"; {more} columns more" if more > 0 else ""))


def _robot(axes: Axes, model: CollaborationModel, inference: CollaborationInference, time: Array) -> None:
    motion, deviation = inference.robot_motion(), inference.robot_deviation()
    shown = [k for k, name in enumerate(model.robot.names) if name.rpartition(".")[2] not in ("qx", "qy", "qz", "qw")]
    for place, k in enumerate(shown[:_MOST]):
        colour = series_colour(place)
        spread = 2 * deviation[:, _learned(model, k)]
        axes.plot(time, motion[:, k], _dashes(place), color=colour, linewidth=1.4, label=model.robot.names[k])
        axes.fill_between(time, motion[:, k] - spread, motion[:, k] + spread, color=colour, alpha=0.15, linewidth=0)
    axes.set_title("robot: inferred, and two standard deviations")


def _learned(model: CollaborationModel, column: int) -> int:
    """Which learned column a recorded one that is no quaternion became."""
    return column - sum(begin < column for begin in model.robot.quaternions)


def _dashes(place: int) -> str:
    """Of a column: dashed where the colours have begun again."""
    return "-" if place < len(SERIES) else "--"
