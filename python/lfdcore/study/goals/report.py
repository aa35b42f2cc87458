"""The report of study goals: tables, and pictures like Fig. 2.4-2.8."""

from __future__ import annotations

from pathlib import Path

from lfdcore.pictures.belief import belief_figure, confusion_figure, likelihood_figure
from lfdcore.pictures.goals import plot_goal_drives
from lfdcore.pictures.style import Picture
from lfdcore.progress import StageProgress
from lfdcore.study.goals.evaluation import BASELINES, confusion, drives_of
from lfdcore.study.goals.study import GoalResult, GoalStudy, run_goal_study
from lfdcore.study.goals.tables import aims, goal_tables
from lfdcore.study.report.cells import in_a_line, percent_cell
from lfdcore.study.report.page import Section
from lfdcore.study.study import Findings

MODEL = "goals.safetensors"
TEXT = (
    "Everything here is simulated: the building, the chair and the able drivers (docs/simulated-drivers.md). The "
    "models are learned from five drives to each destination; the sixth is held out."
)


def goal_headline(result: GoalResult) -> str:
    """The result in a sentence."""
    by = {one.method: one for one in result.accuracies}
    best = max((by[name] for name in BASELINES), key=lambda one: one.share)
    parts = [
        f"{name.removeprefix('Gaussian process, ')} {in_a_line(percent_cell(one.share, one.low, one.high))}"
        for name, one in by.items()
        if name in ("Gaussian process, full", "Gaussian process, sparse", "network")
    ]
    return (
        f"Destination named right: {', '.join(parts)}; best baseline ({best.method}) {percent_cell(best.share)}. "
        f"n = {best.samples} samples of {best.drives} held-out drives, {len(result.model.goals)} destinations, "
        f"simulated able drivers, seed {result.study.seed}."
    )


def goal_pictures(result: GoalResult) -> list[Picture]:
    """Fig. 2.4-2.8."""
    return [_drives_picture(result), *_along_drives(result), _confusion_picture(result)]


def _drives_picture(result: GoalResult) -> Picture:
    drives, world = result.drives, result.drives.world
    ways = [(name, trace.pose) for name, trace in zip(drives.destinations, drives.traces, strict=True)]
    return Picture(
        plot_goal_drives(world, ways, drives.held_out),
        f"As Fig. 2.4a: {len(ways)} drives of simulated able drivers in {world.description}.",
    )


def _along_drives(result: GoalResult) -> list[Picture]:
    """What network and Gaussian process said along the held-out drives."""
    goals, data = result.model.goals, "full" if "full" in result.tracks else "sparse"
    mine = [(one, result.held_out.drive == one.drive[0]) for one in drives_of(result.held_out)]
    network = [(one, result.network[where]) for one, where in mine]
    beliefs = [(one, result.tracks[data].where(where)) for one, where in mine]
    with_data = f"Gaussian process, {'all data' if data == 'full' else 'subset'}"
    return [
        Picture(
            likelihood_figure(goals, [(one, said, said.argmax(axis=1)) for one, said in network]),
            "As Fig. 2.5: the network's likelihoods along the held-out drives, unfiltered; the largest in its goal's "
            "colour.",
        ),
        Picture(
            belief_figure(result.drives.world.grid, goals, beliefs),
            f"As Fig. 2.6: beliefs ({with_data}) along the held-out drives, ellipses of a standard deviation in the "
            "colour of the true destination.",
        ),
        Picture(
            likelihood_figure(goals, [(one, track.likelihood, track.nearest) for one, track in beliefs]),
            "As Fig. 2.7: likelihoods by Mahalanobis distance (grey), the goal nearest to the mean in its colour.",
        ),
    ]


def _confusion_picture(result: GoalResult) -> Picture:
    goals, truth = result.model.goals, result.held_out.goal
    judged: list[str] = [name for name in ("full", "sparse") if name in result.tracks]
    counts = {name: confusion(truth, result.tracks[name].nearest, len(goals)) for name in judged}
    return Picture(
        confusion_figure(goals, counts), f"As Fig. 2.8: what was named, of {len(result.held_out)} held-out samples."
    )


def goal_rows(result: GoalResult) -> list[dict[str, object]]:
    """Accuracies and figures to reach, for machines."""
    accuracies = [{"method": a.method, "accuracy": a.share, "low": a.low, "high": a.high} for a in result.accuracies]
    return [*accuracies, *(aim.as_row() for aim in aims(result))]


def findings(result: GoalResult) -> Findings:
    """Everything that is shown."""
    return Findings(
        headline=goal_headline(result),
        sections=[Section("Where is the driver going?", TEXT, goal_tables(result), goal_pictures(result))],
        rows=goal_rows(result),
        keys=("method", "figure"),
        aims=aims(result),
    )


def run(study: GoalStudy, folder: Path, tell: StageProgress) -> Findings:
    """lfdcore study goals. The drives and the learned model go into `folder` too."""
    result = run_goal_study(study, folder, tell)
    result.model.save(folder / MODEL)
    return findings(result)
