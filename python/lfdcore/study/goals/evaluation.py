"""How well destinations are inferred along held-out drives, sample by sample, beside three baselines (Sec. 2.3.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lfdcore.geometry import wrap_angle
from lfdcore.study.report.statistics import block_bootstrap
from lfdcore.wheelchair.goals.model import GoalModel, prior_belief
from lfdcore.wheelchair.goals.network import network_inputs
from lfdcore.wheelchair.goals.samples import GoalSamples

Floats = NDArray[np.float64]
GoalNumbers = NDArray[np.int64]
"""(N,) a goal each, by its place among the goals"""


def prior_only(model: GoalModel, samples: GoalSamples) -> GoalNumbers:
    """(N,) the goal nearest to the prior's mean, always."""
    mean, _ = prior_belief(model.goals.positions)
    nearest = np.argmin(np.hypot(*(model.goals.positions - mean).T))
    return np.full(len(samples), int(nearest))


def along_heading(model: GoalModel, samples: GoalSamples) -> GoalNumbers:
    """(N,) the goal whose bearing is nearest to where the chair points."""
    to = model.goals.positions[None] - samples.pose[:, None, :2]
    bearing = np.arctan2(to[..., 1], to[..., 0]) - samples.pose[:, 2:]
    return np.asarray(np.abs(wrap_angle(bearing)).argmin(axis=1))


def nearest_neighbour(model: GoalModel, samples: GoalSamples) -> GoalNumbers:
    """(N,) where the most similar sample learned from went: by pose and stick, standardised as the network's inputs."""
    network = model.network
    known, asked = (
        (network_inputs(s.pose, s.joystick, network.heading) - network.centre) / network.scale
        for s in (model.samples, samples)
    )
    return np.asarray(model.samples.goal[cKDTree(known).query(asked)[1]])


BASELINES = {"prior only": prior_only, "along the heading": along_heading, "1-nearest neighbour": nearest_neighbour}


def quarter_of_drive(samples: GoalSamples) -> NDArray[np.int64]:
    """(N,) 0..3: which quarter of its drive's duration a sample lies in."""
    ends = {drive: samples.stamp[samples.drive == drive].max() for drive in np.unique(samples.drive)}
    share = samples.stamp / np.array([max(ends[drive], 1e-9) for drive in samples.drive])
    return np.asarray(np.minimum((4 * share).astype(np.int64), 3))


@dataclass(frozen=True)
class Accuracy:
    """Share of samples whose goal was named, over all and by quarter of the drive (NaN for one without samples); 95 %
    interval over drives."""

    method: str
    samples: int
    drives: int
    share: float
    low: float
    high: float
    quarters: tuple[float, float, float, float]


def accuracy(method: str, said: GoalNumbers, samples: GoalSamples, seed: int = 1) -> Accuracy:
    """Of the goals (N,) said. The interval is a bootstrap of whole drives: samples of one are not independent."""
    right = (said == samples.goal).astype(float)
    low, high = block_bootstrap(right[:, None], samples.drive, seed)
    quarter = quarter_of_drive(samples)
    parts = (right[quarter == k] for k in range(4))
    first, second, third, fourth = (float(part.mean()) if len(part) else float("nan") for part in parts)
    quarters = (first, second, third, fourth)
    drives = len(np.unique(samples.drive))
    return Accuracy(method, len(samples), drives, float(right.mean()), float(low[0]), float(high[0]), quarters)


def agreement(a: GoalNumbers, b: GoalNumbers, goals: int) -> tuple[float, float]:
    """Share of samples with the same answer, and Cohen's kappa (Sec. 2.3.2.1) of two methods' goals (N,)."""
    table = confusion(a, b, goals) / len(a)
    same, by_chance = float(np.trace(table)), float(table.sum(axis=1) @ table.sum(axis=0))
    return same, (same - by_chance) / (1 - by_chance) if by_chance < 1 else 1.0


def confusion(truth: GoalNumbers, said: GoalNumbers, goals: int) -> NDArray[np.int64]:
    """(L, L) counts: a row a true goal, a column an answer (Fig. 2.8)."""
    table = np.zeros((goals, goals), np.int64)
    np.add.at(table, (truth, said), 1)
    return table


def confidence_time(likelihood: Floats, stamp: Floats, goal: int, confidence: float = 0.9) -> float:
    """[s] from which on the likelihood (T, L) of the true goal is `confidence` or more for the rest of the drive (Table
    2.1); NaN where it is not at the end. The first time would be the earlier, the more noise throws it about."""
    unsure = np.flatnonzero(~(likelihood[:, goal] >= confidence))
    if not len(unsure):
        return float(stamp[0])
    return float(stamp[unsure[-1] + 1]) if unsure[-1] + 1 < len(stamp) else float("nan")


def drives_of(samples: GoalSamples) -> Sequence[GoalSamples]:
    """Each drive's samples, in order."""
    return [samples.where(samples.drive == drive) for drive in dict.fromkeys(samples.drive.tolist())]
