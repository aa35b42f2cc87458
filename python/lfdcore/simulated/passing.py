"""The passing task (Sec. 5.5): a mouse passes neatly over a rectangle on a screen.

Image axes: x to the right, y DOWN [px], on a screen of 640 x 480. The rectangle stands on the ground line y = GROUND.
A demonstration is STEPS samples of the cursor, from its left to its right.

Reading of Sec. 5.5: the cursor's two axes are the partner, and the motion that is generated is the same motion
completed; the robot's two columns repeat them, so that a primitive has a robot to drive. "Horizontal only" is a partner
of whom only mouse.x is seen. Environment: the rectangle's width and height [px].

The generator, all of it, with u = k / (STEPS - 1) and the minimum jerk S(s) = 10 s^3 - 15 s^4 + 6 s^5, s cut to [0, 1]:
  x(u) = x0 + (x1 - x0) S((w(u) - b) / (1 - b - r)),  w(u) = u + a sin(2 pi u) / (2 pi)
  y(u) = y0 + (y1 - y0) p + (GROUND - H - m - crown - y0 - (y1 - y0) p) S((x - l) / run) S((q - x) / run)
with p = (x - x0) / (x1 - x0), crown = 12 px (1 - ((x - MIDDLE) / (width / 2 + side))^2), l = left edge - side - run and
q = right edge + side + run: the motion along x knows nothing of the rectangle, and
nothing along y does before x reaches l. x0, y0, x1, y1, the rest at the begin b and end r, the tempo a, the margin m,
the side and the run are drawn for each demonstration; a hand's tremor (Gaussian noise smoothed over 9 samples, .8 px)
is added where the cursor moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.contact import segment_distance
from lfdcore.primitives import dtw_distance
from lfdcore.simulated.minimum_jerk import minimum_jerk

Array = NDArray[np.float64]

STEPS = 150
SCREEN = (640, 480)
"""[px]"""
GROUND = 400.0
"""[px] y of the line that rectangles stand on; larger y is lower"""
MIDDLE = 320.0
"""[px] x of every rectangle's middle"""
CROWN = 12.0
"""[px] that a path rises over the rectangle's middle"""
PERIOD = 0.02
"""[s] between samples"""
DEMONSTRATIONS = 10
"""of each training rectangle"""
SEED = 5
"""of the first of the studies that are reported; chosen before any model was fitted"""


@dataclass(frozen=True)
class Rectangle:
    """Width and height [px] of what is passed over. ValueError unless both are > 0 and it fits beside the ends."""

    width: float
    height: float

    def __post_init__(self) -> None:
        for what, value, most in (("width", self.width, 220.0), ("height", self.height, 300.0)):
            if not 0 < value <= most:
                raise ValueError(f"{what} of the rectangle must be in (0, {most:g}] px, got {value} px")

    @property
    def name(self) -> str:
        """Such as 120x140."""
        return f"{self.width:g}x{self.height:g}"


TRAINING = (Rectangle(100, 80), Rectangle(160, 110), Rectangle(120, 140))
NOVEL = (Rectangle(140, 70), Rectangle(110, 115), Rectangle(150, 155))


@dataclass(frozen=True)
class PassingData:
    """One study's demonstrations: what is learned from, and by which it is judged."""

    training: tuple[InteractionRecording, ...]
    """DEMONSTRATIONS of each of TRAINING, in their order"""
    known: dict[Rectangle, tuple[InteractionRecording, ...]]
    """more demonstrations of TRAINING, never learned from"""
    novel: dict[Rectangle, tuple[InteractionRecording, ...]]
    """demonstrations of NOVEL"""


def passing_data(seed: int = SEED, demonstrations: int = DEMONSTRATIONS) -> PassingData:
    """A study's demonstrations; the same seed gives the same. ValueError for a negative seed, demonstrations < 1."""
    if seed < 0 or demonstrations < 1:
        raise ValueError(f"seed must be >= 0 and demonstrations >= 1, got {seed} and {demonstrations}")
    training = [demonstrate_passing(r, [seed, 0, k, i]) for k, r in enumerate(TRAINING) for i in range(demonstrations)]
    known = {r: _several(r, [seed, 1, k], demonstrations) for k, r in enumerate(TRAINING)}
    novel = {r: _several(r, [seed, 2, k], demonstrations) for k, r in enumerate(NOVEL)}
    return PassingData(tuple(training), known, novel)


def _several(rectangle: Rectangle, seed: list[int], count: int) -> tuple[InteractionRecording, ...]:
    return tuple(demonstrate_passing(rectangle, [*seed, i]) for i in range(count))


def demonstrate_passing(rectangle: Rectangle, seed: int | Sequence[int]) -> InteractionRecording:
    """One demonstration by a person: STEPS samples of mouse.x, mouse.y [px], and the same as path.x, path.y."""
    path = _drawn_path(rectangle, np.random.default_rng(seed))
    environment = {"rectangle.width": rectangle.width, "rectangle.height": rectangle.height}
    names = (("mouse.x", "mouse.y"), ("path.x", "path.y"))
    stamp = PERIOD * np.arange(STEPS, dtype=np.float64)
    label = f"{rectangle.name} seed {seed}"
    return InteractionRecording(stamp, path, path, *names, environment, {"task": "passing"}, label, "screen")


def _drawn_path(rectangle: Rectangle, rng: np.random.Generator) -> NDArray[np.float64]:
    x0, x1 = rng.normal(50, 4), rng.normal(590, 4)
    y0, y1 = rng.normal(GROUND - 30, 2, 2)
    rest, end = rng.uniform(0.03, 0.08), rng.uniform(0.01, 0.05)
    tempo = np.clip(rng.normal(0, 0.06), -0.15, 0.15)
    margin = np.clip(rng.normal(22, 2), 14, 30)
    side, run = np.clip(rng.normal(20, 2), 12, 28), np.clip(rng.normal(120, 4), 105, 135)
    u = np.linspace(0, 1, STEPS)
    progress = minimum_jerk((u + tempo * np.sin(2 * np.pi * u) / (2 * np.pi) - rest) / (1 - rest - end))
    x = x0 + (x1 - x0) * progress
    half = rectangle.width / 2 + side + run
    bump = minimum_jerk((x - (MIDDLE - half)) / run) * minimum_jerk(((MIDDLE + half) - x) / run)
    crown = CROWN * (1 - ((x - MIDDLE) / (half - run)) ** 2)
    top = GROUND - rectangle.height - margin - crown
    level = y0 + (y1 - y0) * progress
    path: Array = np.stack([x, level + (top - level) * bump], axis=1)
    tremor = np.stack([_smooth(rng.normal(0, 0.8 * 3, STEPS), 9) for _ in range(2)], axis=1)
    path += tremor * (4 * progress * (1 - progress))[:, None]
    return path


def _smooth(noise: Array, width: int) -> Array:
    return np.convolve(noise, np.ones(width) / width, mode="same")


# -- what a path is worth -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PassingVerdict:
    """Whether a path passes over a rectangle."""

    passed: bool
    """from one side to the other, above it, without touching"""
    touched: bool
    clearance: float
    """[px] between path and rectangle, 0 where they touch"""


def passing_verdict(path: ArrayLike, rectangle: Rectangle) -> PassingVerdict:
    """Judges a path (T, 2) [px]. It passes if it begins left of the rectangle, ends right of it, stays above it in
    between and never touches it, straight lines between samples included. ValueError for T < 2 or NaN."""
    points = _require_path(path)
    local = points + np.array([-MIDDLE, rectangle.height / 2 - GROUND])
    half = np.array([rectangle.width, rectangle.height]) / 2
    clearance = float(segment_distance(local[:-1], local[1:], half)[0].min())
    above = bool((_heights_beside(local, half[0]) < 0).all())  # it does not touch: above or below, never both
    across = points[0, 0] < MIDDLE - half[0] and points[-1, 0] > MIDDLE + half[0]
    return PassingVerdict(bool(across and above and clearance > 0), clearance <= 0, clearance)


def _heights_beside(points: Array, half: float) -> Array:
    """y, halfway through the strip -half <= x <= half, of every piece of a path (T, 2) that enters it."""
    begin, end = points[:-1], points[1:]
    run = end[:, 0] - begin[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        edges = np.sort(np.stack([(-half - begin[:, 0]) / run, (half - begin[:, 0]) / run]), axis=0)
    upright = np.where(np.abs(begin[:, 0]) <= half, [[0.0], [1.0]], [[1.0], [0.0]])
    enter, leave = np.clip(np.where(run == 0, upright, edges), [[0.0], [-np.inf]], [[np.inf], [1.0]])
    inside = enter <= leave
    middle = (enter + leave)[inside] / 2
    heights: Array = begin[inside, 1] + middle * (end - begin)[inside, 1]
    return heights


def dtw_per_sample(path: ArrayLike, sample: ArrayLike) -> float:
    """DTW distance [px per sample] of two paths (T, 2), (U, 2): the least sum of Euclidean distances (Alg. 9, ERRATA
    49) over the longer path's number of samples. The measure of Fig. 5.7."""
    a, b = _require_path(path), _require_path(sample)
    return dtw_distance(a, b) / max(len(a), len(b))


def distance_to_samples(path: ArrayLike, samples: Sequence[InteractionRecording]) -> float:
    """Mean `dtw_per_sample` [px] of a path to demonstrations; ValueError without any."""
    if not samples:
        raise ValueError("there are no samples")
    return float(np.mean([dtw_per_sample(path, sample.partner[:, :2]) for sample in samples]))


def _require_path(path: ArrayLike) -> Array:
    points = np.asarray(path, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2 or not np.isfinite(points).all():
        raise ValueError(f"path has shape {points.shape}, must be (T, 2), T >= 2, and finite")
    return points
