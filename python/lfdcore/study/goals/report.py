"""The report of study goals: figures to reach, accuracies, Tables 2.1 and 2.2, pictures like Fig. 2.4-2.8."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from lfdcore import __version__
from lfdcore.pictures.belief import belief_figure, confusion_figure, likelihood_figure
from lfdcore.pictures.goals import plot_goal_drives
from lfdcore.pictures.style import Picture
from lfdcore.study.goals.evaluation import BASELINES, Accuracy, agreement, confusion, drives_of
from lfdcore.study.goals.study import FILTERED, NOISE, TRIALS, GoalResult, NoiseTrial
from lfdcore.study.report.aims import Aim
from lfdcore.study.report.page import Section, write_figures, write_report
from lfdcore.study.report.statistics import block_bootstrap, summarise
from lfdcore.study.report.table import Row, Table

WIDE_ENOUGH = (0.5, 2.0)
"""NEES over its dimension, where a belief's covariance is called right"""


def _percent(share: float) -> str:
    return "-" if np.isnan(share) else f"{100 * share:.0f} %"


def accuracy_table(result: GoalResult) -> Table:
    """A row a method: over all held-out samples and by quarter of the drive."""
    rows = [_accuracy_row(one) for one in result.accuracies]
    first = result.accuracies[0]
    return Table(
        f"Share of held-out samples whose destination was named (n = {first.samples} samples of {first.drives} drives, "
        f"seed {result.study.seed})",
        ("", "all", "1st quarter", "2nd quarter", "3rd quarter", "4th quarter"),
        tuple(rows),
        "Below: 95 % interval by a bootstrap of whole drives, of which there are few: it is too narrow. Quarters: of "
        "each drive's duration. Gaussian process: the goal nearest to the belief's mean. The thesis has 65 % with all "
        "data, 62 % with the subset.",
    )


def _accuracy_row(one: Accuracy) -> Row:
    interval = f"\n[{100 * one.low:.0f}, {100 * one.high:.0f}]"
    return (one.method, _percent(one.share) + interval, *map(_percent, one.quarters))


def consistency_table(result: GoalResult) -> Table:
    """NEES of every filter: is the belief as sure as it may be?"""
    rows = []
    for name, track in result.tracks.items():
        errors = track.normalised_errors(result.truth)
        low, high = block_bootstrap(errors[:, None], result.held_out.drive, 1)
        by_drive = [float(errors[result.held_out.drive == drive].mean()) for drive in np.unique(result.held_out.drive)]
        rows.append(
            (
                name,
                f"{errors.mean() / 2:.2f}\n[{low[0] / 2:.2f}, {high[0] / 2:.2f}]",
                f"{np.median(errors) / 2:.2f}",
                ", ".join(f"{value / 2:.2f}" for value in by_drive),
            )
        )
    return Table(
        "Normalised estimation error squared (NEES) over its dimension, 2: 1 where covariances are right",
        ("", "mean", "median", "mean of each drive"),
        tuple(rows),
        f"Above 1 the belief is surer than it may be. Process noise: {result.model.config.process_noise:g} m^2 an "
        "update. Below the mean: 95 % interval by a bootstrap of whole drives.",
    )


def process_noise_table(result: GoalResult) -> Table | None:
    """How the process noise was chosen, on the drives to learn from alone; None where it was not."""
    if not result.model.left_out:
        return None
    rows = [(f"{one.process_noise:g}", _percent(one.accuracy), f"{one.nees:.2f}") for one in result.model.left_out]
    first = result.model.left_out[0]
    return Table(
        f"Process noise, by leaving {first.drives} of the drives to learn from out (n = {first.samples} samples)",
        ("process noise [m^2]", "named right", "NEES / 2"),
        tuple(rows),
        f"Chosen: {result.model.config.process_noise:g} m^2 an update, whose NEES is nearest to its dimension. The "
        "held-out drives had no part in it.",
    )


def noise_table(result: GoalResult) -> Table:
    """Table 2.1: when the network was 90 % sure, by noise on the stick."""
    rows = []
    for goal in sorted({trial.goal for trial in result.trials}):
        of_goal = [trial for trial in result.trials if trial.goal == goal]
        for noise in NOISE:
            rows.append(_noise_row(result, [trial for trial in of_goal if trial.noise == noise]))
    share, filtered = (summarise(_sure_shares(result.trials, which)) for which in ("sure_after", "filtered"))
    never, never_filtered = (_never(result.trials, which) for which in ("sure_after", "filtered"))
    return Table(
        f"Time [s] until the network is 90 % sure of the true destination (as Table 2.1; n = {len(result.trials)} "
        f"drives and noises, {TRIALS} simulated able drivers)",
        ("to (mean drive)", "noise [%]", *(f"driver {k + 1}" for k in range(TRIALS)), "share of drive", "filtered"),
        tuple(rows),
        "From when on its likelihood is .9 or more for the rest of the drive. Over all: "
        f"{_percent(share.mean)} +- {_percent(share.sd)} of the drive (thesis 45 +- 12 %), never, which counts as the "
        f"whole drive, in {never} of {len(result.trials)}; filtered over {FILTERED:g} s {_percent(filtered.mean)} +- "
        f"{_percent(filtered.sd)}, never in {never_filtered}. Noise: zero-mean Gaussian on both "
        "axes of the recorded stick, cut at full scale; the chair was driven without it.",
    )


def _sure_shares(trials: Sequence[NoiseTrial], which: Literal["sure_after", "filtered"]) -> list[float]:
    """Of each drive's duration; 1 where the network never was sure."""
    times = [(getattr(trial, which), trial.duration) for trial in trials]
    return [1.0 if np.isnan(time) else time / duration for time, duration in times]


def _never(trials: Sequence[NoiseTrial], which: Literal["sure_after", "filtered"]) -> int:
    return sum(bool(np.isnan(getattr(trial, which))) for trial in trials)


def _noise_row(result: GoalResult, trials: list[NoiseTrial]) -> Row:
    mean = float(np.mean([trial.duration for trial in trials]))
    shares = [float(np.mean(_sure_shares(trials, "sure_after"))), float(np.mean(_sure_shares(trials, "filtered")))]
    times = ["never" if np.isnan(trial.sure_after) else f"{trial.sure_after:.1f}" for trial in trials]
    name = f"{result.model.goals.names[trials[0].goal]} ({mean:.0f} s)"
    return (name, f"{trials[0].noise:g}", *times, *map(_percent, shares))


def pose_table(result: GoalResult) -> Table:
    """Accuracy of the sparse model where poses are off, and with those of the scan matcher."""
    rows = [_accuracy_row(one.accuracy) for one in result.pose_errors]
    position, heading = result.matcher_errors.T
    return Table(
        "Accuracy of the sparse model by the error of the pose in the map",
        ("pose off by", "all", "1st quarter", "2nd quarter", "3rd quarter", "4th quarter"),
        tuple((one.label, *row[1:]) for one, row in zip(result.pose_errors, rows, strict=True)),
        "Errors of fixed size and random direction, the same all along a drive. The scan matcher knows scans, odometry "
        f"and where the drive began; its error at {len(position)} scans is {position.mean():.3f} m and "
        f"{np.degrees(heading.mean()):.2f} degrees on average, at most {position.max():.2f} m and "
        f"{np.degrees(heading.max()):.1f} degrees.",
    )


def time_table(result: GoalResult) -> Table:
    """Table 2.2 as a ratio: seconds are the machine's."""
    full, sparse = result.update_seconds.get("full"), result.update_seconds["sparse"]
    n, s = len(result.model.samples), len(result.model.subset)
    ratio = "-" if full is None else f"{full / sparse:.0f}"
    return Table(
        "Time of a belief's update, all data / subset (as Table 2.2)",
        ("", "here", "thesis, CPU", "thesis, GPU"),
        ((f"N = {n} / {s}", ratio, "258 (9153 / 800)", "31 (9153 / 800)"),),
        f"One thread, median of 20 updates; the subset's took {1e3 * sparse:.2f} ms on this machine (thesis 41 ms, 28 "
        "ms). benchmarks/bench_action_model.py compares with other implementations.",
    )


def likelihood_table(result: GoalResult) -> Table | None:
    """C.3 of the kernels found; None where all data were not judged."""
    if result.likelihoods is None:
        return None
    rows = tuple(
        (axis, f"{one.of_drawn / one.drawn:.2f}", f"{one.of_all / one.samples:.2f}")
        for axis, one in zip(("forward", "left"), result.likelihoods, strict=True)
    )
    first = result.likelihoods[0]
    return Table(
        "Log likelihood a sample (C.3) of the action kernels",
        ("", f"n = {first.drawn} searched on", f"n = {first.samples}, all"),
        rows,
        "In nats. The kernels were searched on a seeded draw and judged on all samples once. With all, a sample's "
        "neighbours in its drive foretell it better than those left by the draw: the second column may be the larger.",
    )


def aims(result: GoalResult) -> list[Aim]:
    """What was to be reached. Those of the full model only where it was judged."""
    by = {one.method: one.share for one in result.accuracies}
    best = max(by[name] for name in BASELINES)
    sparse = by["Gaussian process, sparse"]
    share = summarise(_sure_shares(result.trials, "filtered"))
    low, high = WIDE_ENOUGH
    found = []
    if "full" in result.tracks:
        full = by["Gaussian process, full"]
        _, kappa = agreement(result.tracks["full"].nearest, result.tracks["sparse"].nearest, len(result.model.goals))
        found += [
            Aim("accuracy, full", ">= 0.65", full, 3, full >= 0.65),
            Aim("... above the best baseline", ">= 0.10", full - best, 3, full - best >= 0.10),
            Aim("accuracy, full - sparse", "<= 0.03", full - sparse, 3, abs(full - sparse) <= 0.03),
            Aim("agreement full, sparse (kappa)", ">= 0.78", kappa, 2, kappa >= 0.78),
        ]
    found.append(Aim("accuracy, sparse, above the best baseline", ">= 0.10", sparse - best, 3, sparse - best >= 0.10))
    found.append(Aim("90 % sure after, filtered (share of drive)", "<= .57", share.mean, 2, share.mean <= 0.57))
    for name in ("full", "sparse"):
        if name in result.tracks:
            nees = float(result.tracks[name].normalised_errors(result.truth).mean()) / 2
            found.append(Aim(f"NEES / 2, {name}, with process noise", ".5 - 2", nees, 2, low <= nees <= high))
    return found


def aims_table(result: GoalResult) -> Table:
    """Figures to reach."""
    rows = tuple((aim.label, aim.wanted, aim.as_text()) for aim in aims(result))
    return Table(f"Figures to reach (seed {result.study.seed})", ("", "wanted", "found"), rows)


def goal_tables(result: GoalResult) -> list[Table]:
    """All tables, figures to reach first."""
    made = (
        aims_table,
        accuracy_table,
        consistency_table,
        process_noise_table,
        noise_table,
        pose_table,
        likelihood_table,
        time_table,
    )
    return [table for make in made if (table := make(result)) is not None]


def goal_pictures(result: GoalResult) -> list[Picture]:
    """Fig. 2.4-2.8."""
    drives, goals, world = result.drives, result.model.goals, result.study.world
    ways = [(name, trace.pose) for name, trace in zip(drives.destinations, drives.traces, strict=True)]
    of_drives = drives_of(result.held_out)
    data = "full" if "full" in result.tracks else "sparse"
    track = result.tracks[data]
    each = [(one, track.where(result.held_out.drive == one.drive[0])) for one in of_drives]
    network = [(one, result.network[result.held_out.drive == one.drive[0]]) for one in of_drives]
    with_data = f"Gaussian process, {'all data' if data == 'full' else 'subset'}"
    return [
        Picture(
            plot_goal_drives(world, ways, drives.held_out),
            f"As Fig. 2.4a: {len(ways)} drives of simulated able drivers in {world.description}.",
        ),
        Picture(
            likelihood_figure(goals, [(one, said, said.argmax(axis=1)) for one, said in network]),
            "As Fig. 2.5: the network's likelihoods along the held-out drives, unfiltered; the largest in its goal's "
            "colour.",
        ),
        Picture(
            belief_figure(world.grid, goals, each),
            f"As Fig. 2.6: beliefs ({with_data}) along the held-out drives, ellipses of a standard deviation in the "
            "colour of the true destination.",
        ),
        Picture(
            likelihood_figure(goals, [(one, t.likelihood, t.nearest) for one, t in each]),
            "As Fig. 2.7: likelihoods by Mahalanobis distance (grey), the goal nearest to the mean in its colour.",
        ),
        Picture(
            confusion_figure(
                goals,
                {
                    name: confusion(result.held_out.goal, result.tracks[name].nearest, len(goals))
                    for name in ("full", "sparse")
                    if name in result.tracks
                },
            ),
            f"As Fig. 2.8: what was named, of {len(result.held_out)} held-out samples.",
        ),
    ]


def goal_headline(result: GoalResult) -> str:
    """The result in a sentence."""
    by = {one.method: one for one in result.accuracies}
    best = max((by[name] for name in BASELINES), key=lambda one: one.share)
    parts = [
        f"{name.removeprefix('Gaussian process, ')} {_percent(one.share)} [{100 * one.low:.0f}, {100 * one.high:.0f}]"
        for name, one in by.items()
        if name in ("Gaussian process, full", "Gaussian process, sparse", "network")
    ]
    return (
        f"Destination named right: {', '.join(parts)}; best baseline ({best.method}) {_percent(best.share)}. "
        f"n = {best.samples} samples of {best.drives} held-out drives, {len(result.model.goals)} destinations, "
        f"simulated able drivers, seed {result.study.seed}."
    )


def write_goal_report(result: GoalResult, folder: Path, command: str) -> Path:
    """Writes report.html and figures.json into `folder` -> the report's path. The same result gives the same bytes, but
    for the times."""
    text = (
        "Everything here is simulated: the building, the chair and the able drivers (docs/simulated-drivers.md). Five "
        "drives to each destination teach, the sixth is held out.\n\n" + result.drives.table()
    )
    section = Section("Where is the driver going?", text, goal_tables(result), goal_pictures(result))
    rows = [{"method": a.method, "accuracy": a.share, "low": a.low, "high": a.high} for a in result.accuracies]
    rows += [{"figure": a.label, "wanted": a.wanted, "found": a.found, "reached": a.reached} for a in aims(result)]
    write_figures(folder / "figures.json", rows)
    origin = f"lfdcore {__version__}, seed {result.study.seed}. Made by: `{command}`"
    return write_report(folder / "report.html", "lfdcore: global goals", [section], goal_headline(result), origin)
