"""Tables of study goals: figures to reach, accuracies, consistency, Tables 2.1 and 2.2, the drives themselves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from lfdcore.geometry import arc_length
from lfdcore.study.goals.drives import GoalDrives
from lfdcore.study.goals.evaluation import BASELINES, Accuracy, agreement
from lfdcore.study.goals.study import FILTERED, NOISE, TRIALS, GoalResult, NoiseTrial
from lfdcore.study.report.aims import Aim, aims_table
from lfdcore.study.report.cells import figure_cell, percent_cell
from lfdcore.study.report.statistics import block_bootstrap, summarise
from lfdcore.study.report.table import Row, Table

WIDE_ENOUGH = (0.5, 2.0)
"""NEES over its dimension, where a belief's covariance is called right"""
CLOSE = 0.03
"""by which the accuracies of all data and of the subset may differ"""
QUARTERS = ("all", "1st quarter", "2nd quarter", "3rd quarter", "4th quarter")


# -- figures to reach -----------------------------------------------------------------------------------------------


def aims(result: GoalResult) -> list[Aim]:
    """What was to be reached. Those of the full model only where it was judged."""
    by = {one.method: one.share for one in result.accuracies}
    best = max(by[name] for name in BASELINES)
    share = summarise(_sure_shares(result.trials, "filtered")).mean
    return [
        *(_full_aims(result, by, best) if "full" in result.tracks else []),
        Aim.at_least(0.1, "accuracy, sparse, above the best baseline", by["Gaussian process, sparse"] - best, 3),
        Aim.at_most(0.57, "90 % sure after, filtered (share of drive)", share, 2),
        *(_nees_aim(result, name) for name in ("full", "sparse") if name in result.tracks),
    ]


def _full_aims(result: GoalResult, by: dict[str, float], best: float) -> list[Aim]:
    full, sparse = by["Gaussian process, full"], by["Gaussian process, sparse"]
    _, kappa = agreement(result.tracks["full"].nearest, result.tracks["sparse"].nearest, len(result.model.goals))
    apart = full - sparse
    return [
        Aim.at_least(0.65, "accuracy, full", full, 3),
        Aim.at_least(0.1, "... above the best baseline", full - best, 3),
        Aim("accuracy, full - sparse", f"+-{CLOSE:g}", apart, 3, abs(apart) <= CLOSE),
        Aim.at_least(0.78, "agreement full, sparse (kappa)", kappa, 2),
    ]


def _nees_aim(result: GoalResult, name: str) -> Aim:
    nees = float(result.tracks[name].normalised_errors(result.truth).mean()) / 2
    return Aim.between(*WIDE_ENOUGH, f"NEES / 2, {name}, with process noise", nees, 2)


# -- the drives -----------------------------------------------------------------------------------------------------


def drives_table(drives: GoalDrives) -> Table:
    """A row a destination."""
    train, test = drives.samples(drives.training), drives.samples(drives.held_out)
    return Table(
        f"Drives to each destination, of simulated able drivers in {drives.world.description}",
        ("", "drives", "mean [s]", "min [s]", "max [s]", "way [m]", "arrived", "contacts"),
        tuple(_drives_row(drives, name) for name in drives.world.goals.names),
        f"Way: mean length. Samples at 10 Hz: {train} to learn from ({len(drives.training)} drives), {test} held out.",
    )


def _drives_row(drives: GoalDrives, name: str) -> Row:
    mine = [trace for trace, goal in zip(drives.traces, drives.destinations, strict=True) if goal == name]
    times = [len(trace.stamp) * trace.period for trace in mine]
    ways = [float(arc_length(trace.pose[:, :2])[-1]) for trace in mine]
    seconds = (figure_cell(value, digits=1) for value in (float(np.mean(times)), min(times), max(times)))
    contacts, arrived = sum(int(trace.collision.sum()) for trace in mine), sum(trace.completed for trace in mine)
    return (name, str(len(mine)), *seconds, figure_cell(float(np.mean(ways)), digits=1), str(arrived), str(contacts))


# -- accuracy -------------------------------------------------------------------------------------------------------


def accuracy_table(result: GoalResult) -> Table:
    """A row a method: over all held-out samples and by quarter of the drive."""
    first = result.accuracies[0]
    return Table(
        f"Share of held-out samples whose destination was named (n = {first.samples} samples of {first.drives} drives, "
        f"seed {result.study.seed})",
        ("", *QUARTERS),
        tuple(_accuracy_row(one.method, one) for one in result.accuracies),
        "Below: 95 % interval by a bootstrap of whole drives. There are few drives, so it is too narrow. Quarters: of "
        "each drive's duration. Gaussian process: the goal nearest to the belief's mean. The thesis has 65 % with all "
        "data, 62 % with the subset.",
    )


def _accuracy_row(name: str, one: Accuracy) -> Row:
    return (name, percent_cell(one.share, one.low, one.high), *map(percent_cell, one.quarters))


def pose_table(result: GoalResult) -> Table:
    """Accuracy of the sparse model where poses are off, and with those of the scan matcher."""
    position, heading = result.matcher_errors.T
    return Table(
        "Accuracy of the sparse model by the error of the pose in the map",
        ("pose off by", *QUARTERS),
        tuple(_accuracy_row(one.label, one.accuracy) for one in result.pose_errors),
        "Errors of fixed size and random direction, the same all along a drive. The scan matcher knows scans, odometry "
        f"and where the drive began; its error at {len(position)} scans is {position.mean():.3f} m and "
        f"{np.degrees(heading.mean()):.2f} degrees on average, at most {position.max():.2f} m and "
        f"{np.degrees(heading.max()):.1f} degrees.",
    )


# -- how sure -------------------------------------------------------------------------------------------------------


def consistency_table(result: GoalResult) -> Table:
    """NEES of every filter: is the belief as sure as it may be?"""
    return Table(
        "Normalised estimation error squared (NEES) over its dimension, 2: 1 where covariances are right",
        ("", "mean", "median", "mean of each drive"),
        tuple(_consistency_row(result, name) for name in result.tracks),
        f"Above 1 the belief is surer than it may be. Process noise: {result.model.config.process_noise:g} m^2 an "
        "update. Below the mean: 95 % interval by a bootstrap of whole drives.",
    )


def _consistency_row(result: GoalResult, name: str) -> Row:
    nees, drive = result.tracks[name].normalised_errors(result.truth) / 2, result.held_out.drive
    low, high = block_bootstrap(nees[:, None], drive, 1)
    by_drive = [f"{nees[drive == one].mean():.2f}" for one in np.unique(drive)]
    mean = figure_cell(float(nees.mean()), float(low[0]), float(high[0]), digits=2)
    return (name, mean, figure_cell(float(np.median(nees)), digits=2), ", ".join(by_drive))


def process_noise_table(result: GoalResult) -> Table | None:
    """How the process noise was chosen, on the drives to learn from alone; None where it was not."""
    if not result.model.left_out:
        return None
    first = result.model.left_out[0]
    rows = [
        (f"{one.process_noise:g}", percent_cell(one.accuracy), figure_cell(one.nees, digits=2))
        for one in result.model.left_out
    ]
    return Table(
        f"Process noise, by leaving {first.drives} of the drives to learn from out (n = {first.samples} samples)",
        ("process noise [m^2]", "named right", "NEES / 2"),
        tuple(rows),
        f"Chosen: {result.model.config.process_noise:g} m^2 an update, whose NEES is nearest to its dimension. The "
        "held-out drives had no part in it.",
    )


# -- Tables 2.1 and 2.2 ---------------------------------------------------------------------------------------------


def noise_table(result: GoalResult) -> Table:
    """Table 2.1: when the network was 90 % sure, by noise on the stick."""
    n, goals = len(result.trials), sorted({trial.goal for trial in result.trials})
    by_setting = {
        (goal, noise): [one for one in result.trials if (one.goal, one.noise) == (goal, noise)]
        for goal in goals
        for noise in NOISE
    }
    return Table(
        f"Time [s] until the network is 90 % sure of the true destination (as Table 2.1; n = {n} drives and noises, "
        f"{TRIALS} simulated able drivers)",
        ("to (mean drive)", "noise [%]", *(f"driver {k + 1}" for k in range(TRIALS)), "share of drive", "filtered"),
        tuple(_noise_row(result, trials) for trials in by_setting.values()),
        f"From when on its likelihood is .9 or more for the rest of the drive. Over all: "
        f"{_over_all(result.trials, 'sure_after')} of the drive (thesis 45 +- 12 %), never, which counts as the whole "
        f"drive, in {_never(result.trials, 'sure_after')} of {n}; filtered over {FILTERED:g} s "
        f"{_over_all(result.trials, 'filtered')}, never in {_never(result.trials, 'filtered')}. Noise: zero-mean "
        "Gaussian on both axes of the recorded stick, cut at full scale; the chair was driven without it.",
    )


Which = Literal["sure_after", "filtered"]


def _sure_shares(trials: Sequence[NoiseTrial], which: Which) -> list[float]:
    """Of each drive's duration; 1 where the network never was sure."""
    times = [(getattr(trial, which), trial.duration) for trial in trials]
    return [1.0 if np.isnan(time) else time / duration for time, duration in times]


def _over_all(trials: Sequence[NoiseTrial], which: Which) -> str:
    """Mean+-sd of the shares."""
    s = summarise(_sure_shares(trials, which))
    return figure_cell(100 * s.mean, digits=0, sd=100 * s.sd, unit=" %")


def _never(trials: Sequence[NoiseTrial], which: Which) -> int:
    return sum(bool(np.isnan(getattr(trial, which))) for trial in trials)


def _noise_row(result: GoalResult, trials: Sequence[NoiseTrial]) -> Row:
    """Of one destination and noise."""
    mean = float(np.mean([trial.duration for trial in trials]))
    shares = [float(np.mean(_sure_shares(trials, "sure_after"))), float(np.mean(_sure_shares(trials, "filtered")))]
    times = ["never" if np.isnan(trial.sure_after) else f"{trial.sure_after:.1f}" for trial in trials]
    name = f"{result.model.goals.names[trials[0].goal]} ({mean:.0f} s)"
    return (name, f"{trials[0].noise:g}", *times, *map(percent_cell, shares))


def time_table(result: GoalResult) -> Table:
    """Table 2.2 as a ratio: seconds are the machine's."""
    full, sparse = result.update_seconds.get("full", np.nan), result.update_seconds["sparse"]
    n, s = len(result.model.samples), len(result.model.subset)
    return Table(
        "Time of a belief's update, all data / subset (as Table 2.2)",
        ("", "here", "thesis, CPU", "thesis, GPU"),
        ((f"N = {n} / {s}", figure_cell(full / sparse, digits=0), "258 (9153 / 800)", "31 (9153 / 800)"),),
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
        "neighbours in its drive predict it better than those left by the draw: the second column may be the larger.",
    )


def goal_tables(result: GoalResult) -> list[Table]:
    """All tables, figures to reach first."""
    made = (
        aims_table(f"Figures to reach (seed {result.study.seed})", aims(result)),
        accuracy_table(result),
        consistency_table(result),
        process_noise_table(result),
        noise_table(result),
        pose_table(result),
        likelihood_table(result),
        time_table(result),
        drives_table(result.drives),
    )
    return [table for table in made if table is not None]
