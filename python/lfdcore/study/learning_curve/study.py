"""How much demonstration is enough (Sec. 6.2.1): both methods learned from the first n of the 72 runs in the mazes.

Judged in home_20x19, a test world that is like neither maze (docs/courses.md). Its ways are short (10-30 m) and drawn
from a seed, so that each simulated driver has a way of its own and the figures are no one route's:
- closed_loop: impaired drivers, each with the same way and noise for every n and method, and unassisted beside;
- predictions: able drivers, unassisted, to 30 destinations; the path predicted at a scan against the one driven.

Networks learn for as many steps as they take on 72 runs, within `most_epochs`, and keep their best epoch: with a fixed
number of epochs few runs would mean few steps too, and the curve would show that.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated

from lfdcore.simulated.run import RunConfig
from lfdcore.study.demonstrations import HOME_DRIVERS, MAZE_RUNS, RUNS_EACH
from lfdcore.study.study import Option, Study

RUNS = (5, 10, 20, 40, MAZE_RUNS)
METHODS = ("primitives", "heatmaps")
NOBODY = "none"
"""The arm that is unassisted"""


@dataclass(frozen=True, kw_only=True)
class LearningCurveStudy(Study):
    """Both methods by the number of demonstrations: contacts, path RMSE, predicted paths. Needs torch to learn.

    Models stay in the folder: a second study there drives only.
    """

    name = "learning-curve"
    title = "how much demonstration is enough (Sec. 6.2.1)"

    runs: Annotated[tuple[int, ...], Option("Numbers of demonstrations to learn from, increasing.")] = RUNS
    drivers: Annotated[int, Option("Simulated impaired drivers.", minimum=1)] = 10
    predicted: int = HOME_DRIVERS * RUNS_EACH
    """runs of able drivers, for predictions"""
    every: int = 10
    """of so many samples of a log one is predicted"""
    epochs: int = 10
    """of the network on 72 runs"""
    most_epochs: int = 40
    run: RunConfig = field(default_factory=RunConfig)

    def __post_init__(self) -> None:
        super().__post_init__()
        ends = (0, *self.runs, MAZE_RUNS + 1)
        if not self.runs or any(b <= a for a, b in pairwise(ends)):
            raise ValueError(f"runs are {self.runs}, must be increasing numbers within 1..{MAZE_RUNS}")
        for name in ("every", "epochs", "most_epochs"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is {getattr(self, name)}, must be at least 1")
        if not 1 <= self.predicted <= HOME_DRIVERS * RUNS_EACH:
            raise ValueError(f"predicted is {self.predicted} runs, must be 1..{HOME_DRIVERS * RUNS_EACH}")

    def epochs_of(self, runs: int) -> int:
        """Epochs on so many runs: as many steps as on 72, within `most_epochs`."""
        return min(self.most_epochs, round(self.epochs * MAZE_RUNS / runs))
