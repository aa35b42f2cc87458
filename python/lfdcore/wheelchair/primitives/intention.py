"""Local intention (Sec. 3.3): where in the local window does the driver want to go?

Every cell that demonstrations ended in has a one-class RBF network over the stick and the one beam that covers the
cell. All networks are asked at once; cells that lie beyond their beam are out of sight and get 0.

A one-class network answers about 1 near its data, whether one demonstration ended there or fifty, and so the map has
plateaus and its maximum jumps about. Beside its weight every centre therefore keeps a frequency: the demonstrations
that lie nearest to it. The same Gaussians weighted with the frequencies say how often (a Parzen estimate), and a cell's
likelihood is the weighted geometric mean of both answers; `frequency=0` is the thesis's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from lfdcore.estimation import RbfNetworkBank, RbfNetworkConfig
from lfdcore.grid import read_beams
from lfdcore.wheelchair.beams import BeamGeometry
from lfdcore.wheelchair.primitives.beam_lengths import filled_lengths, measured_beams
from lfdcore.wheelchair.primitives.compliance import MOST_CENTRES, SIGMA
from lfdcore.wheelchair.stick import DEAD_ZONE, checked_joystick
from lfdcore.wheelchair.window import CELLS, WINDOW, cell_keys, key_centres, require_between

if TYPE_CHECKING:
    from lfdcore.geometry import Pose2
    from lfdcore.grid import LaserScan
    from lfdcore.wheelchair.primitives.local_paths import LocalPaths

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class IntentionConfig:
    """sigma_joystick: of the Gaussians on the stick's direction (a unit vector); sigma_range: on a beam's range divided
    by 2.5 m; threshold, max_centres: see RbfNetworkConfig; blur [cells]: of the map before its maximum is taken;
    slack [m]: a cell is out of sight once its centre is this much farther than its beam; dead_zone: a stick nearer to
    its centre wants nothing; mirror: learn from the left-right mirrored paths too."""

    sigma_joystick: float = 0.2
    sigma_range: float = 0.2
    threshold: float = 0.01
    max_centres: int = 20
    frequency: float = 0.5
    floor: float = 0.01
    blur: float = 3.0
    slack: float = 0.05
    dead_zone: float = DEAD_ZONE
    mirror: bool = True

    def __post_init__(self) -> None:
        for name in ("sigma_joystick", "sigma_range"):
            require_between(name, getattr(self, name), *SIGMA)
        for name in ("threshold", "frequency", "floor", "dead_zone"):
            require_between(name, getattr(self, name), 0, 1)
        require_between("max_centres", self.max_centres, 1, MOST_CENTRES)
        require_between("blur", self.blur, 0, CELLS, " cells")
        require_between("slack", self.slack, 0, WINDOW, " m")

    @classmethod
    def thesis(cls) -> IntentionConfig:
        """One sigma of .3 (ERRATA F5), the networks' bare answers, the maximum of the map as it is, no mirroring."""
        return cls(sigma_joystick=0.3, sigma_range=0.3, frequency=0.0, floor=0.0, blur=0.0, mirror=False)


class IntentionModel:
    """One network a cell; bank.keys are flat cell indices iy * 100 + ix of the local window. Does not depend on the
    number of beams or the place of the laser it was learned with. frequencies (M,): of the bank's centres."""

    def __init__(self, bank: RbfNetworkBank, frequencies: Floats, config: IntentionConfig) -> None:
        keys = np.asarray(bank.keys)
        if bank.dimensions != 3 or len(keys) == 0 or keys[0] < 0 or keys[-1] >= CELLS**2:
            raise ValueError(f"an intention model needs networks of 3 inputs for cells 0..{CELLS**2 - 1}")
        if frequencies.shape != bank.weights.shape or not (frequencies >= 0).all() or not frequencies.sum() > 0:
            raise ValueError(f"an intention model needs a frequency for each of its {len(bank.weights)} centres")
        self.bank, self.frequencies, self.config = bank, frequencies, config
        most = np.add.reduceat(frequencies, np.asarray(bank.offsets)[:-1]).max()  # so that nothing is clipped at 1
        self._often = RbfNetworkBank(bank.keys, bank.offsets, bank.centres, frequencies / most, bank.sigma)
        self.cells: NDArray[np.int32] = keys.copy()
        self.centres = key_centres(self.cells)
        """(C, 2) [m]: the cells' centres in base_link"""
        self._laser: _LaserView | None = None

    @classmethod
    def fit(cls, local_paths: LocalPaths, config: IntentionConfig | None = None) -> IntentionModel:
        """Learns a network for every cell that a local path ended in. ValueError without paths or with the stick at
        rest in all of them."""
        config = config or IntentionConfig()
        parts = [local_paths, local_paths.mirrored()] if config.mirror else [local_paths]
        joystick = np.concatenate([p.joystick for p in parts])
        usable = np.hypot(*joystick.T) >= max(config.dead_zone, 1e-9)
        if not usable.any():
            raise ValueError(f"none of {len(local_paths)} local paths has the stick pushed: there is nothing to learn")
        beam_range = np.concatenate([p.beam_range for p in parts])[usable]
        goal = np.concatenate([p.goal for p in parts])[usable]
        inputs = np.column_stack([_stick_inputs(joystick[usable], config), _range_inputs(beam_range, config)])
        network = RbfNetworkConfig(sigma=1.0, threshold=config.threshold, max_centres=config.max_centres)
        keys = cell_keys(goal)
        bank = RbfNetworkBank.fit(inputs, keys, network)
        return cls(bank, _frequencies(bank, inputs, keys), config)

    def predict(
        self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2, visible: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float32]:
        """P(goal | stick, scan) over the local window -> (100, 100), blurred, sums to 1; all 0 if nothing is likely.

        joystick (2,): forward, left in [-1, 1]; scan: any number of beams; visible (100, 100): cells that may be a goal
        (default: all that the beams see). All 0 also for a stick within the dead zone and a scan without a measurement.
        ValueError for a stick that is not finite or out of range.
        """
        image = np.zeros((CELLS, CELLS), dtype=np.float32)
        image.flat[self.cells] = self.cell_likelihoods(joystick, scan, T_base_laser)
        allowed = None if visible is None else _checked_mask(visible)
        if allowed is not None:
            image = np.where(allowed, image, np.float32(0))
        if self.config.blur > 0:
            blurred = cv2.GaussianBlur(image, (0, 0), self.config.blur, borderType=cv2.BORDER_CONSTANT)
            image = np.asarray(blurred, dtype=np.float32)
            image = image if allowed is None else np.where(allowed, image, np.float32(0))
        total = float(image.sum(dtype=np.float64))
        return (image / np.float32(total)) if total > 0 else image

    @staticmethod
    def goal(likelihood: NDArray[np.float32]) -> tuple[Floats, float] | None:
        """The likeliest cell of a map (100, 100): its centre (2,) [m] in base_link and its likelihood; ties: the lowest
        iy, then ix. None for an all-zero map: the driver wants nothing that the demonstrations knew."""
        best = int(np.argmax(likelihood))
        if not likelihood.flat[best] > 0:
            return None
        return key_centres(np.array([best], dtype=np.int32))[0], float(likelihood.flat[best])

    def cell_likelihoods(self, joystick: Floats, scan: LaserScan, T_base_laser: Pose2) -> Floats:
        """The networks' bare answers, one a cell of `cells` -> (C,) in [0, 1]; 0 out of sight. See predict."""
        stick = checked_joystick(joystick)
        lengths, hit = read_beams(scan)
        if not measured_beams(lengths, hit).any() or np.hypot(*stick) < max(self.config.dead_zone, 1e-9):
            return np.zeros(len(self.cells))
        laser = self._view(scan, T_base_laser)
        seen = filled_lengths(lengths, hit)[laser.beam]
        own = _range_inputs(np.minimum(seen, laser.cap), self.config)
        likelihood = self._answers(_stick_inputs(stick[None], self.config)[0], own[:, None])
        out_of_sight = laser.covered & (laser.distance > seen + self.config.slack)
        return np.where(out_of_sight, 0.0, likelihood)

    def _answers(self, stick: Floats, own: Floats) -> Floats:
        whether, share = self.bank.predict(stick, own), self.config.frequency
        whether[whether < self.config.floor] = 0.0
        if share == 0:
            return whether
        return np.asarray(whether ** (1 - share) * self._often.predict(stick, own) ** share)

    def _view(self, scan: LaserScan, T_base_laser: Pose2) -> _LaserView:
        key = (len(scan.ranges), scan.angle_min, scan.angle_increment, *T_base_laser)
        if self._laser is None or self._laser.key != key:
            geometry = BeamGeometry(key[0], key[1], key[2], T_base_laser)
            beam, distance, covered = geometry.locate(self.centres)
            self._laser = _LaserView(key, beam, distance, covered, geometry.caps[beam])
        return self._laser


@dataclass(frozen=True)
class _LaserView:
    """What one laser means for the cells: beam, distance [m], whether in its field of view, cap [m], all (C,)."""

    key: tuple[float, ...]
    beam: NDArray[np.intp]
    distance: Floats
    covered: NDArray[np.bool_]
    cap: Floats


def _frequencies(bank: RbfNetworkBank, inputs: Floats, keys: NDArray[np.int32]) -> Floats:
    """How many training inputs lie nearest to each centre, among the centres of their own cell -> (M,)."""
    offsets, counts = np.asarray(bank.offsets), np.zeros(len(bank.weights))
    order = np.argsort(keys, kind="stable")
    pieces = np.split(inputs[order], np.flatnonzero(np.diff(keys[order])) + 1)
    for first, last, mine in zip(offsets[:-1], offsets[1:], pieces, strict=True):
        squared = ((mine[:, None] - bank.centres[first:last]) ** 2).sum(2)
        counts[first:last] = np.bincount(squared.argmin(1), minlength=last - first)
    return counts


def _stick_inputs(joystick: Floats, config: IntentionConfig) -> Floats:
    return np.asarray(joystick / np.hypot(*joystick.T)[:, None] / config.sigma_joystick)


def _range_inputs(beam_range: Floats, config: IntentionConfig) -> Floats:
    return beam_range / WINDOW / config.sigma_range


def _checked_mask(visible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    mask = np.asarray(visible, dtype=bool)
    if mask.shape != (CELLS, CELLS):
        raise ValueError(f"the visible mask has shape {mask.shape}, must be ({CELLS}, {CELLS})")
    return mask
