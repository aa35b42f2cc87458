"""The covering task (Sec. 5.6): a person and a Baxter pull a bag over an object; a stated generator of both motions.

Base frame: Baxter's, x forward, y left, z up, BASE_HEIGHT above the floor. The object stands before the robot, the
person behind it, facing the robot. The right gripper holds the near lip still at RIGHT_GRIPPER, higher than any
object; the left gripper carries it from the object's right side over its top to the left side; the person's two hands
carry the far lip the same way behind the object.

The generator, all of it. S is the minimum jerk 10 s^3 - 15 s^4 + 6 s^5 with s cut to [0, 1]; a move from p0 over p1 to
p2 in the intervals [a, b], [c, d] of the phase u is p0 + (p1 - p0) S((u - a) / (b - a)) + (p2 - p1) S((u - c) / (d -
c)). `lead` moves all intervals of both agents earlier; the phase is w(u) = u + a sin(2 pi u) / (2 pi). top = the
object's height - BASE_HEIGHT, left = the y of its left face.
  gripper  y: -.08 -> left + .11                    [.17, .87]
           z: -.08 -> top + margin -> top + .04     [.06, .40], [.72, .98];  margin = .115 + .016 style + personal;
              and .035 up and down again            [.28, .53], [.55, .80]
           x: .62 -> .80 -> .76                     [.08, .48], [.60, .95]
           yaw -.35 -> .35 rad [.15, .90]; pitch 1.92 -> 2.06 rad [.05, .50]; roll 0
           all of it with the unsteadiness of an arm that is led by hand: slow, on x, y, z and both angles
  hand     y: -.10 (+ .10 for the hand that leads) -> reach   [.15, .85]
           z: -.05 + .03 style -> carry -> lower    [.02, .34], [.70, .97]
           x: 1.15 (1.25 for the hand that leads), .03 nearer in the middle
           all of it shifted by the inconsistent start, which dies away with S(u / .35)
  reach = i (left + .09) + (1 - i) .55 + personal;  carry = i (top + .16) + (1 - i) .22 + .02 style + personal;
  lower = carry - .10
`informative` = i in [0, 1] says how much the person's own motion follows the object: 0, it is the same for all; 1, as
much as the robot's. Before u = .1 almost nothing of carry and reach has come into the motion, whatever i is.
Shared by both agents and in no environment parameter: style, lead, tempo a and duration. Gloves are tracked with white
noise and a slow drift, and lost (NaN) for spans in which a hand is hidden.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.scene import Box, box_metadata, environment_of, standing_box
from lfdcore.simulated.minimum_jerk import minimum_jerk

Array = NDArray[np.float64]

PERIOD = 0.03
"""[s] between samples: 50 samples are 1.5 s (Sec. 5.6.1)"""
STEPS = 500
"""of a trajectory (Sec. 5.6)"""
RIGHT_GRIPPER = (0.72, -0.32, 0.32)
"""[m, base] held still"""
PLACE = (0.80, 0.27)
"""[m, base] of an object's middle, unless it is put elsewhere"""
SEED = 6
"""of the first of the studies that are reported; chosen before any model was fitted"""
PARTNER_NAMES = tuple(f"{hand}_hand.{axis}" for hand in ("left", "right") for axis in "xyz")
ROBOT_NAMES = tuple(f"left_gripper.{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz", "qw"))


@dataclass(frozen=True)
class CoveredObject:
    """What is covered: height, width (along y) and depth (along x) [m] of its bounding box."""

    name: str
    height: float
    width: float
    depth: float

    def box(self, place: tuple[float, float] = PLACE) -> Box:
        """It, standing on the floor with its middle at `place` [m, base]."""
        return standing_box(self.height, self.width, self.depth, place)


@dataclass(frozen=True)
class CoveringConfig:
    """How people move, are tracked, and put the object down. Standard deviations unless said otherwise.

    ValueError unless informative is in [0, 1] and the others are finite and >= 0.
    """

    informative: float = 0.35
    """0 to 1: how much the person's motion follows the object"""
    duration: float = 10.4
    """[s] mean"""
    tempo: float = 0.08
    """of the logarithm of the duration"""
    warp: float = 0.05
    """of a, the change of tempo within a motion"""
    lead: float = 0.02
    """of the phase by which both begin earlier"""
    start: float = 0.035
    """[m] each hand and axis: inconsistent starts"""
    personal: float = 0.025
    """[m] of the person's reach and carry; a third of it, of the demonstrator's margin and of where the gripper ends"""
    placing: float = 0.0
    """[m] of the object's place along y"""
    wobble: float = 0.004
    """[m] and, times 5, [rad]: how unsteadily the robot's arm is led, slow"""
    noise: float = 0.006
    """[m] white, of each glove and axis"""
    drift: float = 0.006
    """[m] slow, of each glove and axis"""
    occlusions: float = 1.2
    """spans per glove and recording, on average"""
    longest_occlusion: float = 0.45
    """[s]; no glove stays hidden longer"""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} must be finite and >= 0, got {value}")
        if self.informative > 1 or self.duration < 1:
            raise ValueError(f"informative must be <= 1, duration >= 1 s, got {self.informative}, {self.duration} s")


@dataclass(frozen=True)
class CoveringProtocol:
    """Which objects are demonstrated how often, which are new, and what is known of them."""

    name: str
    training: tuple[CoveredObject, ...]
    novel: tuple[CoveredObject, ...]
    demonstrations: int
    """of each training object"""
    observed: float
    """[s] of the partner before the robot moves"""
    environment_names: tuple[str, ...]
    """of object.height, object.width, object.depth, object.x, object.y [m]"""
    placing: float = 0.0
    """[m], see CoveringConfig"""


_STOOL = CoveredObject("stool", 0.75, 0.34, 0.34)
_CHAIR = CoveredObject("chair", 0.80, 0.44, 0.40)
_CABINET = CoveredObject("cabinet", 0.90, 0.40, 0.38)

GROUND_TRUTH = CoveringProtocol(
    "5.6.1",
    (_STOOL, _CHAIR, _CABINET),
    (CoveredObject("cabinet raised by 10 cm", 1.00, 0.40, 0.38),),
    demonstrations=5,
    observed=50 * PERIOD,
    environment_names=("object.height",),
)
"""Sec. 5.6.1: e is the height"""
BOUNDING_BOX = CoveringProtocol(
    "5.6.2",
    (_STOOL, CoveredObject("office chair", 0.84, 0.48, 0.42), _CABINET, CoveredObject("stepladder", 0.98, 0.42, 0.36)),
    (
        CoveredObject("side table", 0.78, 0.42, 0.36),
        CoveredObject("folding table", 0.87, 0.54, 0.38),
        CoveredObject("cabinet raised by 10 cm", 1.00, 0.40, 0.38),
        CoveredObject("shelf", 1.04, 0.46, 0.34),
    ),
    demonstrations=10,
    observed=1.0,
    environment_names=("object.height", "object.width", "object.y"),
    placing=0.01,
)
"""Sec. 5.6.2: stepladder and folding table are named in the text, the other names and all sizes are ours; e is what a
bounding box seen from the robot says (here measured, not detected)"""


@dataclass(frozen=True)
class CoveringData:
    """One study's demonstrations."""

    protocol: CoveringProtocol
    training: tuple[InteractionRecording, ...]
    """protocol.demonstrations of each training object, in their order, by one person after the other"""
    known: dict[str, tuple[InteractionRecording, ...]]
    """by object: the training objects covered with people who were not seen in training, never learned from"""
    novel: dict[str, tuple[InteractionRecording, ...]]
    """by object: the novel objects, with such people"""


def covering_data(
    protocol: CoveringProtocol = BOUNDING_BOX,
    seed: int = SEED,
    config: CoveringConfig | None = None,
    held_out: int = 5,
) -> CoveringData:
    """A study's demonstrations, `held_out` of each object to judge by; the same seed gives the same.

    The protocol's `placing` stands in for the config's. ValueError for a negative seed or held_out < 1.
    """
    if seed < 0 or held_out < 1:
        raise ValueError(f"seed must be >= 0 and held_out >= 1, got {seed} and {held_out}")
    config = replace(config or CoveringConfig(), placing=protocol.placing)
    made = partial(demonstrate_covering, config=config, environment_names=protocol.environment_names)
    each = range(protocol.demonstrations)
    training = [made(one, [seed, 0, k, i]) for k, one in enumerate(protocol.training) for i in each]
    known, novel = (
        {one.name: tuple(made(one, [seed, kind, k, i]) for i in range(held_out)) for k, one in enumerate(objects)}
        for kind, objects in ((1, protocol.training), (2, protocol.novel))
    )
    return CoveringData(protocol, tuple(training), known, novel)


def write_demonstrations(folder: Path, data: CoveringData) -> None:
    """As files: demo-NN.npz to learn from, and for each object, known or novel, a person not seen in training,
    new-OBJECT.npz, with the scene alone in new-OBJECT.json."""
    folder.mkdir(parents=True, exist_ok=True)
    for k, one in enumerate(data.training):
        one.save(folder / f"demo-{k:02d}.npz")
    for name, people in {**data.known, **data.novel}.items():
        stem = folder / f"new-{name.replace(' ', '-')}"
        people[0].save(stem.with_suffix(".npz"))
        stem.with_suffix(".json").write_text(json.dumps(people[0].environment, indent=2) + "\n")


def demonstrate_covering(
    covered: CoveredObject,
    seed: int | Sequence[int],
    config: CoveringConfig | None = None,
    environment_names: Sequence[str] = GROUND_TRUTH.environment_names,
) -> InteractionRecording:
    """One demonstration: the partner's two hands (T, 6) [m, base; NaN = hidden] and the left gripper's pose (T, 7)
    [m, unit quaternion xyzw], every PERIOD [s] for about 10 s.

    Its environment holds `environment_names` of `environment_of`; its metadata the object's name and `box_metadata`.
    """
    config, rng = config or CoveringConfig(), np.random.default_rng(seed)
    box = covered.box((PLACE[0], PLACE[1] + float(_clipped(rng, config.placing))))
    shared = _Shared.drawn(rng, config)
    stamp = PERIOD * np.arange(max(2, round(shared.duration / PERIOD)), dtype=np.float64)
    u = shared.phase(np.linspace(0, 1, len(stamp)))
    robot = _gripper(u, shared, box, _clipped(rng, config.personal / 3, 2), config.wobble * _unsteady(rng, len(u), 5))
    hands = _tracked(_hands(u, shared, box, rng, config), rng, config)
    environment = environment_of(box)
    known = {name: environment[name] for name in environment_names}
    notes = {"task": "covering", "object": covered.name, **box_metadata(box)}
    label = f"{covered.name} seed {seed}"
    return InteractionRecording(stamp, hands, robot, PARTNER_NAMES, ROBOT_NAMES, known, notes, label)


# -- the motions ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Shared:
    """What both agents of a demonstration have in common."""

    style: float
    lead: float
    warp: float
    duration: float

    @staticmethod
    def drawn(rng: np.random.Generator, config: CoveringConfig) -> _Shared:
        style, lead, warp, tempo = (float(_clipped(rng, sd)) for sd in (1.0, config.lead, config.warp, config.tempo))
        return _Shared(style, lead, warp, config.duration * math.exp(tempo))

    def phase(self, u: Array) -> Array:
        """(T,) of the motion at shares (T,) of the time; it begins at 0, still."""
        warped: Array = u + self.warp * np.sin(2 * np.pi * u) / (2 * np.pi)
        return warped + self.lead * minimum_jerk(u / 0.05) * minimum_jerk((1 - u) / 0.05)


def _clipped(rng: np.random.Generator, sd: float, size: int | tuple[int, ...] | None = None) -> Array:
    """Gaussian, cut at 2 standard deviations: no demonstrator is absurd."""
    return np.clip(rng.normal(0.0, 1.0, size), -2, 2) * sd


def _gripper(u: Array, shared: _Shared, box: Box, personal: Array, wobble: Array) -> Array:
    """(T, 7) the left gripper's pose; wobble (T, 5) [m]."""
    left = box.centre[1] + box.size[1] / 2
    margin = 0.115 + 0.016 * shared.style + personal[0]
    x = _moves(u, 0.62, (0.80, 0.08, 0.48), (0.76, 0.60, 0.95))
    y = _moves(u, -0.08, (left + 0.11 + personal[1], 0.17, 0.87))
    z = _moves(u, -0.08, (box.top + margin, 0.06, 0.40), (box.top + 0.04, 0.72, 0.98))
    z += _moves(u, 0.0, (0.035, 0.28, 0.53), (0.0, 0.55, 0.80))
    yaw = _moves(u, -0.35, (0.35, 0.15, 0.90)) + 5 * wobble[:, 3]
    pitch = _moves(u, 1.92, (2.06, 0.05, 0.50)) + 5 * wobble[:, 4]
    return np.hstack([np.stack([x, y, z], axis=1) + wobble[:, :3], _pointing(yaw, pitch)])


def _moves(u: Array, start: float, *moves: tuple[float, float, float]) -> Array:
    """From `start` over each (place, begin, end) in turn by minimum jerk; intervals may overlap."""
    at, value = start, np.full(len(u), start)
    for place, begin, end in moves:
        value += (place - at) * minimum_jerk((u - begin) / (end - begin))
        at = place
    return value


def _pointing(yaw: Array, pitch: Array) -> Array:
    """(T, 4) quaternions xyzw of R_z(yaw) R_y(pitch): at pitch pi/2 its z axis points forward, beyond it down."""
    cy, sy, cp, sp = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    return np.stack([-sy * sp, cy * sp, sy * cp, cy * cp], axis=1)


def _hands(u: Array, shared: _Shared, box: Box, rng: np.random.Generator, config: CoveringConfig) -> Array:
    """(T, 6) where the partner's hands are. Facing the robot, the right hand is the one that leads to the left."""
    follows, left = config.informative, box.centre[1] + box.size[1] / 2
    own = _clipped(rng, config.personal, 2)
    reach = follows * (left + 0.09) + (1 - follows) * 0.55 + own[0]
    carry = follows * (box.top + 0.16) + (1 - follows) * 0.22 + 0.02 * shared.style + own[1]
    height = _moves(u, -0.05 + 0.03 * shared.style, (carry, 0.02, 0.34), (carry - 0.10, 0.70, 0.97))
    hands = []
    for ahead in (0.0, 0.10):
        x = _moves(u, 1.15 + ahead, (1.12 + ahead, 0.10, 0.50), (1.15 + ahead, 0.55, 0.95))
        y = _moves(u, -0.10 + ahead, (reach - 0.10 + ahead, 0.15, 0.85))
        off = _clipped(rng, config.start, 3)[:, None] * (1 - minimum_jerk(u / 0.35))
        hands += [x + off[0], y + off[1], height + off[2]]
    return np.stack(hands, axis=1)


def _tracked(hands: Array, rng: np.random.Generator, config: CoveringConfig) -> Array:
    """The same as gloves are tracked: noise, drift, and NaN while a hand is hidden."""
    drift = _unsteady(rng, *hands.shape)
    seen = hands + rng.normal(0, config.noise, hands.shape) + config.drift * drift
    for hand in (slice(0, 3), slice(3, 6)):
        seen[_hidden(rng, len(hands), config), hand] = np.nan
    return seen


def _unsteady(rng: np.random.Generator, samples: int, columns: int) -> Array:
    """(T, columns) Gaussian values of unit variance (cut at 2) every second, joined smoothly."""
    knots = _clipped(rng, 1.0, (int(samples * PERIOD) + 3, columns))
    at = PERIOD * np.arange(samples, dtype=np.float64)
    whole = at.astype(int)
    joined: Array = knots[whole] + (knots[whole + 1] - knots[whole]) * minimum_jerk(at - whole)[:, None]
    return joined


def _hidden(rng: np.random.Generator, samples: int, config: CoveringConfig) -> NDArray[np.bool_]:
    """(T,) where a glove is not seen: spans that neither touch nor hide the last of a motion's samples."""
    hidden = np.zeros(samples + 1, bool)
    for _ in range(int(rng.poisson(config.occlusions))):
        begin, length = int(rng.integers(1, samples)), int(rng.uniform(0.1, 1) * config.longest_occlusion / PERIOD)
        end = min(begin + length, samples)
        if not hidden[begin - 1 : end + 1].any():
            hidden[begin:end] = True
    return hidden[:samples]
