"""Pictures of Sec. 5.6: gripper paths (Fig. 5.9, 5.13, 5.14), paths by share observed (5.15), sweeps (5.16, 5.17)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Rectangle
from numpy.typing import NDArray

from lfdcore.humanoid.covering import CoveringVerdict
from lfdcore.humanoid.scene import Box
from lfdcore.pictures.style import (
    ALARM,
    BASELINE,
    BODY,
    CONTACT,
    INK,
    METHOD_COLOURS,
    PAGE,
    PURPLE,
    RANKS,
    REFERENCE,
    RULE,
    VERMILLION,
    styled,
)
from lfdcore.simulated.covering import RIGHT_GRIPPER, CoveredObject
from lfdcore.study.covering.study import (
    EXAMPLE,
    METHODS,
    NOBODY,
    OWN,
    PARTNER_SHARES,
    SHARES,
    SHUFFLED,
    STRANGER,
    CoveringResult,
    CoveringRun,
)
from lfdcore.study.covering.tables import dial_errors, share_errors
from lfdcore.study.report.statistics import summarise

Floats = NDArray[np.float64]

PARTNER_COLOURS = {NOBODY: BASELINE, STRANGER: VERMILLION, SHUFFLED: PURPLE}
MOUTH = INK
Y, Z = "y [m]", "z [m, base]"
_SHORT = {"cabinet raised by 10 cm": "raised cabinet"}


@styled
def paths_figure(run: CoveringRun) -> Figure:
    """Left gripper in the YZ plane: the demonstrations' means, EaIP and IP, a colour an object by its height."""
    figure = Figure(figsize=(PAGE, 0.285 * PAGE), layout="constrained")
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    objects = [*run.protocol.training, *run.protocol.novel]
    colours = _by_height(objects)
    known = {one.name for one in run.protocol.training}
    for axes, title in zip(panels, ("demonstrations, means", *METHODS), strict=True):
        for one in objects:
            motions = run.shown.inferred[title][one.name] if title in METHODS else ()
            mean = np.mean(motions, axis=0) if motions else run.shown.demonstrations.get(one.name)
            for motion in motions:
                _path(axes, motion, colours[one.name], linewidth=0.5, alpha=0.5)
            if mean is not None:
                _path(axes, mean, colours[one.name], linewidth=1.7, linestyle="-" if one.name in known else (0, (4, 2)))
        _yz(axes, title)
    panels[1].set_ylabel("")
    panels[2].set_ylabel("")
    handles = [
        Line2D([], [], color=colours[o.name], linestyle="-" if o.name in known else (0, (4, 2)), label=_label(o))
        for o in objects
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    return figure


def _label(one: CoveredObject) -> str:
    return f"{_SHORT.get(one.name, one.name)}, {one.height:.2f} m"


def _by_height(objects: Sequence[CoveredObject]) -> dict[str, tuple[float, ...]]:
    order = sorted(objects, key=lambda one: one.height)
    shades = RANKS.reversed()(np.linspace(0, 1, len(order)))
    return {one.name: tuple(shade.tolist()) for one, shade in zip(order, shades, strict=True)}


def _path(axes: Axes, motion: Floats, colour: object, **style: object) -> None:
    axes.plot(motion[:, 1], motion[:, 2], color=colour, **style)  # type: ignore[arg-type]


def _yz(axes: Axes, title: str) -> None:
    axes.set_title(title, loc="left")
    axes.set(xlabel=Y, ylabel=Z)
    axes.set_aspect("equal")
    axes.tick_params(length=2.5, width=0.6)
    axes.grid(linewidth=0.3, color=RULE)
    axes.set_axisbelow(True)


@styled
def share_paths_figure(run: CoveringRun) -> Figure:
    """Fig. 5.15a: the motion inferred at EXAMPLE from more and more of the partner's, a panel a method."""
    figure = Figure(figsize=(0.9 * PAGE, 0.285 * PAGE), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    shades = RANKS.reversed()
    for axes, method in zip(panels, METHODS, strict=True):
        axes.add_patch(_front(run.shown.boxes[EXAMPLE], facecolor=BODY))
        for share, motion in zip(SHARES, run.shown.by_share[method], strict=True):
            _path(axes, motion, shades(share), linewidth=1.2)
        _yz(axes, f"{method}, {EXAMPLE}")
        axes.set(ylim=(-0.2, 0.28), xlim=(-0.14, 0.68))
    panels[1].set_ylabel("")
    scale = ScalarMappable(Normalize(0, 1), shades)
    figure.colorbar(scale, ax=list(panels), label="share observed", pad=0.01, aspect=16)
    return figure


def _front(box: Box, **style: object) -> Rectangle:
    """The object as seen from the robot, cut off below."""
    y, width, bottom = box.centre[1], box.size[1], -0.9
    return Rectangle((y - width / 2, bottom), width, box.top - bottom, edgecolor="none", **style)  # type: ignore[arg-type]


@styled
def share_errors_figure(result: CoveringResult) -> Figure:
    """Fig. 5.15b: RMSE against the share observed, to the final motion and to the held-out demonstration."""
    figure = Figure(figsize=(0.9 * PAGE, 0.36 * PAGE), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    what = (("to_final", "to the final motion (100 % observed)"), ("to_demonstration", "to the held-out demonstration"))
    for axes, (name, title) in zip(panels, what, strict=True):
        for method in METHODS:
            for form, dashes in (("positions", "-"), ("forcing", ":")):
                each = share_errors(result, form, method, name)
                label = method if form == "positions" else f"{method}, forcing function"
                _band(axes, np.array(SHARES), each, METHOD_COLOURS[method], label, dashes)
        early = share_errors(result, "positions", "EaIP", name)[:, SHARES.index(0.1)]
        axes.axhline(100 * float(early.mean()), color=REFERENCE, linewidth=0.8, linestyle="--", zorder=0)
        axes.set_title(title, loc="left")
        axes.set(xlabel="share of the partner's motion observed", xlim=(0, 1))
        axes.grid(linewidth=0.3, color=RULE)
    panels[0].set(ylabel="RMSE [cm]", ylim=(0, None))  # after both are drawn: they share it
    figure.legend(handles=panels[0].get_lines()[:4], loc="outside lower center", ncols=4, frameon=False)
    return figure


def _band(
    axes: Axes,
    at: Floats,
    each: Floats,
    colour: str,
    label: str,
    dashes: str = "-",
    marker: str = "",
    floor: float = 0.0,
) -> None:
    """Mean of rows (seeds, n) [m] in cm, and its 95 % interval, cut at `floor` [cm]: no error is negative."""
    sums = [summarise(100 * column) for column in each.T]
    axes.plot(at, [s.mean for s in sums], dashes, color=colour, label=label, linewidth=1.4, marker=marker, markersize=4)
    axes.fill_between(
        at, [max(s.low, floor) for s in sums], [s.high for s in sums], color=colour, alpha=0.15, linewidth=0
    )


@styled
def sweeps_figure(run: CoveringRun, objects: Sequence[CoveredObject]) -> Figure:
    """Fig. 5.16, 5.17: a row a method, a column an object; the mouth where it comes nearest, collisions marked."""
    figure = Figure(figsize=(PAGE, 0.42 * PAGE), layout="constrained")
    panels = figure.subplots(2, len(objects), sharex=True, sharey=True, squeeze=False)
    for row, method in zip(panels, reversed(METHODS), strict=True):
        for axes, one in zip(row, objects, strict=True):
            motion, verdict = run.shown.inferred[method][one.name][0], run.shown.verdicts[method][one.name]
            _sweep(axes, run.shown.boxes[one.name], motion, verdict, METHOD_COLOURS[method])
            _yz(axes, f"{method}: {_SHORT.get(one.name, one.name)}{' *' if verdict.collided else ''}")
            axes.set(xlim=(-0.42, 0.72), ylim=(-0.30, 0.42), xlabel="", ylabel="")
            said = "covered" if verdict.success else "collision" if verdict.collided else "not covered"
            colour = MOUTH if verdict.success else ALARM
            note = f"{said}, nearest {100 * verdict.contact.distance:.1f} cm"
            axes.text(0.03, 0.04, note, transform=axes.transAxes, color=colour, fontsize=8, bbox=_PLATE)
    for axes in panels[-1]:
        axes.set_xlabel(Y)
    for axes in panels[:, 0]:
        axes.set_ylabel(Z)
    handles = [
        *(Line2D([], [], color=METHOD_COLOURS[m], label=f"left gripper, {m}") for m in METHODS),
        Line2D([], [], color=MOUTH, marker="o", markersize=3.5, label="the bag's mouth at its nearest"),
        Patch(facecolor=BODY, label="object"),
        Line2D([], [], color=CONTACT, marker="o", markerfacecolor="none", linestyle="none", label="collision (< 2 cm)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False)
    return figure


_PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}


def _sweep(axes: Axes, box: Box, motion: Floats, verdict: CoveringVerdict, colour: str) -> None:
    axes.add_patch(_front(box, facecolor=BODY))
    _path(axes, motion, colour, linewidth=1.5)
    right = np.array(RIGHT_GRIPPER)
    for k in np.linspace(0, len(motion) - 1, 9).astype(int):
        axes.plot([right[1], motion[k, 1]], [right[2], motion[k, 2]], color=MOUTH, linewidth=0.4, alpha=0.25)
    at = verdict.contact.sample
    left = [float(np.interp(at, np.arange(len(motion)), column)) for column in motion.T]
    axes.plot([right[1], left[1]], [right[2], left[2]], color=MOUTH, linewidth=1.3, marker="o", markersize=3.5)
    if verdict.collided:
        _, y, z = verdict.contact.point
        axes.add_patch(Ellipse((y, z), 0.13, 0.13, fill=False, edgecolor=CONTACT, linewidth=1.8, zorder=5))


@styled
def partners_figure(result: CoveringResult) -> Figure:
    """What the partner's motion is worth: EaIP's RMSE beyond that with its own partner, paired. A panel a protocol."""
    protocols = sorted({run.protocol.name for run in result.runs})
    figure = Figure(figsize=(0.9 * PAGE, 0.33 * PAGE), layout="constrained")
    panels = figure.subplots(1, len(protocols), squeeze=False, sharey=True)[0]
    for axes, name in zip(panels, protocols, strict=True):
        runs = [run for run in result.runs if run.protocol.name == name]
        axes.axhline(0, color=METHOD_COLOURS["EaIP"], linewidth=1.4, label=OWN)
        for partner, colour in PARTNER_COLOURS.items():
            each = np.array([run.partners[partner] - run.partners[OWN] for run in runs])
            _band(
                axes, np.array(PARTNER_SHARES), each, colour, partner, "--" if partner == NOBODY else "-", "o", -np.inf
            )
        axes.set_title(f"protocol {name}", loc="left")
        axes.set(xlabel="share of the partner's motion observed", xticks=PARTNER_SHARES)
        axes.grid(linewidth=0.3, color=RULE)
    panels[0].set_ylabel("EaIP's RMSE beyond that\nwith its own partner [cm]")
    figure.legend(handles=panels[0].get_lines(), loc="outside lower center", ncols=4, frameon=False)
    return figure


@styled
def dials_figure(result: CoveringResult) -> Figure:
    """RMSE over how much the partner's motion tells of the object, a panel a share observed."""
    figure = Figure(figsize=(PAGE, 0.34 * PAGE), layout="constrained")
    panels = figure.subplots(1, len(PARTNER_SHARES), sharey=True)
    for k, (axes, share) in enumerate(zip(panels, PARTNER_SHARES, strict=True)):
        for method in METHODS:
            for personal, dashes in ((True, "-"), (False, ":")):
                label = method if personal else f"{method}, people alike"
                each = np.array([dial_errors(result, dial, personal, method)[:, k] for dial in result.study.dials]).T
                _band(axes, np.array(result.study.dials), each, METHOD_COLOURS[method], label, dashes, "o")
        axes.set_title(f"{100 * share:.0f} % observed", loc="left")
        axes.set(xlabel="how informative the partner is", xticks=(0, 0.5, 1))
        axes.grid(linewidth=0.3, color=RULE)
    panels[0].set(ylabel="RMSE to the demonstration [cm]", ylim=(0, None))
    figure.legend(handles=panels[0].get_lines(), loc="outside lower center", ncols=4, frameon=False)
    return figure
