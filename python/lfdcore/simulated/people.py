"""People who walk to and fro in a course: they give way to walls and to each other, never to the chair.

Each looks for a velocity near the wished one that meets nobody soon: a reciprocal velocity obstacle (van den Berg, Lin
and Manocha 2008), by trying a few velocities. Whatever that says, nobody takes a step into a wall or another person.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
import numpy.typing as npt

from lfdcore.grid import OccupancyGrid
from lfdcore.simulated.courses.routes import Point
from lfdcore.simulated.walkways import FloatArray, Walkways
from lfdcore.simulation import Person

_APART, _OFF_WALLS = 0.02, 0.01
"""Kept between two people and from walls [m]: more than straight steps between checked places can cut off."""
_SPACING = 0.08
"""Between checked places of a step [m]."""
_HORIZON = 3.0
"""How far ahead people look at others [s]."""
_GLIMPSES = np.array([0.3, 0.6, 1.0])
"""When they look ahead for walls [s]."""
_ANGLES = np.radians([0, -15, 15, -30, 30, -60, 60, -90, 90, -135, 135, 180])
"""Tried beside the wished direction."""
_IS_LEFT = np.concatenate([_ANGLES > 0, _ANGLES > 0, [False]])
_STANDING = -1
"""Of the velocities that are tried: which pass on the left, and the one that stands."""
_LEFT = 0.05
"""What passing on the left costs more than on the right [m/s]: so two who meet head on do not stop."""
_ARRIVED, _PROGRESS = 0.6, 0.3
"""Way left [m] at which a place counts as reached, and by which it must shrink to count as getting on."""


@dataclass(frozen=True, kw_only=True)
class PeopleConfig:
    """Who walks in a course. ValueError names a field out of range."""

    count: int = 12
    radius: float = 0.25
    """of a person's disc [m]: body, legs and the room of a stride, a choice"""
    speed: float = 1.1
    """mean of what people walk freely [m/s], a choice for indoors"""
    speed_sd: float = 0.2
    """of the same between people [m/s]; cut at two"""
    places: int = 8
    """in the map, between two of which each walks to and fro"""
    clear_of_start: float = 2.0
    """Nobody sets out nearer to where the chair starts [m]."""
    patience: float = 4.0
    """Mean time without getting on after which one turns back [s]; each has a patience of 50-150 % of it."""

    def __post_init__(self) -> None:
        _require("count", self.count, 0, 1000, "people")
        _require("radius", self.radius, 0.1, 1.0, "m")
        _require("speed", self.speed, 0.05, 3.0, "m/s")
        _require("speed_sd", self.speed_sd, 0.0, self.speed / 2, "m/s")
        _require("places", self.places, 2, 100, "places")
        _require("clear_of_start", self.clear_of_start, 0.0, 100.0, "m")
        _require("patience", self.patience, 0.1, 1000.0, "s")


def _require(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} is {value} {unit}, must be between {low} and {high}")


class People:
    """N people in a map. The same map, config, start and seed give the same people and steps, to the byte.

    start: where the chair starts [m]; they walk where one gets to from there. ValueError for a map without room for
    all of them.
    """

    def __init__(self, grid: OccupancyGrid, config: PeopleConfig, start: Point, seed: int) -> None:
        self.config = config
        rng = np.random.default_rng([0x9E0, seed])
        self._ways = Walkways(grid, config.radius, start, config.places, rng)
        self.position = self._spread(start, rng)
        """(N, 2) of their centres in map [m]"""
        self.velocity = np.zeros_like(self.position)
        """(N, 2) of the latest step [m/s]"""
        cut = np.clip(rng.standard_normal(config.count), -2, 2)
        self._speed = config.speed + config.speed_sd * cut
        self._patience = config.patience * rng.uniform(0.5, 1.5, config.count)
        pairs = [rng.choice(config.places, 2, replace=False) for _ in range(config.count)]
        self._to, self._fro = np.array(pairs, dtype=np.int64).reshape(-1, 2).T.copy()
        self._best, self._idle = np.full(config.count, np.inf), np.zeros(config.count)

    def _spread(self, start: Point, rng: np.random.Generator) -> FloatArray:
        ground = self._ways.ground
        ground = ground[np.hypot(*(ground - start).T) >= self.config.clear_of_start]
        ground = ground[self._ways.gap(ground) >= self.config.radius + _OFF_WALLS]
        chosen: list[FloatArray] = []
        for point in rng.permutation(ground):
            if len(chosen) == self.config.count:
                break
            if all(np.hypot(*(point - other)) >= 2 * self.config.radius + 2 * _APART for other in chosen):
                chosen.append(point)
        if len(chosen) < self.config.count:
            raise ValueError(f"count is {self.config.count} people, the map has room for {len(chosen)}")
        return np.array(chosen).reshape(-1, 2)

    def walk(self, duration: float) -> list[Person]:
        """Takes a step of `duration` [s] -> the people as they set out on it, each at a constant velocity."""
        self._choose_ends(duration)
        wished = self._speed[:, None] * self._ways.heading(self._to, self.position)
        trials = _trials(wished)
        badness = np.where(self._off_walls(trials, duration), self._badness(trials, wished), np.inf)
        steps = self._together(trials, badness, duration)
        self.velocity = steps
        set_out = self.bodies()
        self.position = self.position + steps * duration
        return set_out

    def bodies(self) -> list[Person]:
        """The people where they are, with the velocity of their latest step: before the first they stand."""
        pairs = zip(self.position, self.velocity, strict=True)
        return [Person(position=at, velocity=step, radius=self.config.radius) for at, step in pairs]

    def _choose_ends(self, duration: float) -> None:
        """Who has arrived, or does not get on, turns back."""
        left = self._ways.way_left(self._to, self.position)
        on = left < self._best - _PROGRESS
        self._best = np.where(on, left, self._best)
        self._idle = np.where(on, 0.0, self._idle + duration)
        back = (left < _ARRIVED) | (self._idle > self._patience)
        self._to, self._fro = np.where(back, self._fro, self._to), np.where(back, self._to, self._fro)
        self._best[back], self._idle[back] = np.inf, 0.0

    def _badness(self, trials: FloatArray, wished: FloatArray) -> FloatArray:
        """How much (N, K) [m/s] is against velocities (N, K, 2): off the wish, soon a person, soon a wall."""
        off = _length(trials - wished[:, None]) + _LEFT * _IS_LEFT
        ends = self.position[:, None] + _GLIMPSES[:, None, None, None] * trials
        walled = self._ways.gap(ends) < self.config.radius + _OFF_WALLS
        wall = (walled * (0.5 / _GLIMPSES)[:, None, None]).max(axis=0)
        return np.asarray(off + 1.0 / self._time_to_meeting(trials) + wall)

    def _time_to_meeting(self, trials: FloatArray) -> FloatArray:
        """Until the first other is met (N, K) [s] if the others do as much to avoid it; inf beyond the horizon."""
        away = self.position[None] - self.position[:, None]
        closing = 2 * trials[:, :, None] - (self.velocity[:, None] + self.velocity[None])[:, None]
        along = _dot(closing, away[:, None])
        square = np.maximum(_dot(closing, closing), 1e-12)
        beyond = _dot(away, away) - (2 * self.config.radius + _APART) ** 2
        root = along**2 - square * beyond[:, None]
        meets = (along > 0) & (root > 0) & ~np.eye(len(away), dtype=bool)[:, None]
        time = np.maximum((along - np.sqrt(np.maximum(root, 0.0))) / square, 0.1)
        return np.asarray(np.where(meets & (time < _HORIZON), time, np.inf).min(axis=2, initial=np.inf))

    def _off_walls(self, trials: FloatArray, duration: float) -> npt.NDArray[np.bool_]:
        """Which velocities (N, K, 2) take nobody to a wall. Standing never does."""
        pieces = max(1, ceil(float(self._speed.max(initial=0.0)) * duration / _SPACING))
        shares = duration * np.arange(1, pieces + 1) / pieces
        places = self.position[:, None] + shares[:, None, None, None] * trials
        free = np.asarray((self._ways.gap(places) >= self.config.radius + _OFF_WALLS).all(axis=0))
        free[:, _STANDING] = True
        return free

    def _together(self, trials: FloatArray, badness: FloatArray, duration: float) -> FloatArray:
        """Steps (N, 2) [m/s] of the least badness (N, K) with which nobody meets another.

        If everyone's best do not go together, people choose in turn, beside those who have chosen and, as if they
        stood, those who have not. Standing is always left: whoever chose before did so beside one who stands.
        """
        away = self.position[None] - self.position[:, None]
        kept = np.minimum(2 * self.config.radius + _APART, _length(away) - 1e-12)
        np.fill_diagonal(kept, -np.inf)
        everyone = np.arange(len(away))
        steps: FloatArray = trials[everyone, badness.argmin(axis=1)]
        if (_nearest(away, steps[:, None] - steps, duration) >= kept).all():
            return steps
        steps = np.zeros_like(steps)
        for one in everyone:
            apart = (_nearest(away[one], trials[one][:, None] - steps, duration) >= kept[one]).all(axis=1)
            apart[_STANDING] = True
            steps[one] = trials[one, np.where(apart, badness[one], np.inf).argmin()]
        return steps


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


def _nearest(away: FloatArray, closing: FloatArray, duration: float) -> FloatArray:
    """How near (...) [m] one comes to another who is `away` (..., 2) [m] in a step at `closing` (..., 2) [m/s]."""
    square = np.maximum(_dot(closing, closing), 1e-12)
    when = np.clip(_dot(closing, away) / square, 0.0, duration)
    return _length(away - when[..., None] * closing)


def _trials(wished: FloatArray) -> FloatArray:
    """Velocities (N, K, 2) to try beside the wished (N, 2): turned, at full and half speed, and to stand."""
    c, s = np.cos(_ANGLES), np.sin(_ANGLES)
    x, y = wished[:, :1], wished[:, 1:]
    turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    return np.concatenate([turned, 0.5 * turned, np.zeros((len(wished), 1, 2))], axis=1)
