"""What the driver wants, from what the driver gives: one Gaussian process a joystick axis (Sec. 4.4.2).

Pairs of raw and safe (or followed) joystick are put into 10 x 10 bins over [-1, 1]^2; each bin with data is one
training sample. `JoystickAdapter` goes on learning from its driver (Sec. 6.2.1).
"""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lfdcore.datasets.tensor_file import Tensors, read_tensor_file, write_tensor_file
from lfdcore.errors import ModelError
from lfdcore.estimation import GaussianProcess, Kernel

Floats = NDArray[np.float64]
_KIND, _DRIVER, _VERSION = "joystick model", "joystick adaptation", 1
_NOTHING = 1e-3
"""A bin with fewer samples, long forgotten, has none."""
_LIMIT = 1 + 1e-6
"""A stick's end stop, with the rounding that an Observation grants it."""


@dataclass(frozen=True)
class JoystickModelConfig:
    """How pairs become a model. The defaults depart from the print where it has no sensible outcome."""

    bins: int = 10
    """For each axis."""
    prior: Literal["identity", "zero"] = "identity"
    """Far from all data the wanted input is the raw one (the processes model safe - raw), or 0 (the thesis)."""
    noise: Literal["of_mean", "of_samples"] = "of_mean"
    """A bin's target is a mean of n samples, so its noise is var / n, and the variance predicted is that of a wanted
    input: of f plus the scatter around it. "of_samples" is the thesis: noise var (ERRATA 33), variance of f alone
    (C.4)."""
    pooled_samples: float = 5.0
    """A bin's variance is taken together with so many samples of the variance pooled over all bins: one or two samples
    have none to speak of."""

    def __post_init__(self) -> None:
        if not 1 <= self.bins <= 100:
            raise ValueError(f"bins is {self.bins}, must be 1 .. 100 for each axis")
        if self.prior not in ("identity", "zero"):
            raise ValueError(f"prior is '{self.prior}', must be identity or zero")
        if self.noise not in ("of_mean", "of_samples"):
            raise ValueError(f"noise is '{self.noise}', must be of_mean or of_samples")
        if not 0 < self.pooled_samples < np.inf:
            raise ValueError(f"pooled_samples is {self.pooled_samples}, must be > 0 and finite")


class JoystickPrior(NamedTuple):
    """One axis's covariance function and the standard deviation of its noise."""

    kernel: Kernel
    noise: float


class JoystickEstimate(NamedTuple):
    """Mean and variance of the wanted joystick, each (forward, left)."""

    mean: tuple[float, float]
    variance: tuple[float, float]


def _pairs(raw: ArrayLike, safe: ArrayLike) -> tuple[Floats, Floats]:
    pairs = np.asarray(raw, dtype=float), np.asarray(safe, dtype=float)
    for name, values in zip(("raw", "safe"), pairs, strict=True):
        if values.ndim != 2 or values.shape[1] != 2:
            raise ValueError(f"{name} joystick must be (N, 2), got {values.shape}")
        if not np.all(np.abs(values) <= _LIMIT):  # NaN too
            raise ValueError(f"{name} joystick must be finite and within [-1, 1]")
    if len(pairs[0]) != len(pairs[1]):
        raise ValueError(f"{len(pairs[0])} raw joystick samples but {len(pairs[1])} safe ones")
    return pairs


@dataclass(frozen=True)
class JoystickBins:
    """Running statistics, one row a bin, bins row-major over (forward, left). B = bins * bins."""

    count: Floats
    """(B,) samples, not whole numbers once old ones are forgotten; 0: none."""
    raw: Floats
    """(B, 2) mean raw joystick."""
    target: Floats
    """(B, 2) mean of what the processes model: safe - raw, or safe where the prior is zero."""
    variance: Floats
    """(B, 2) of that."""

    @staticmethod
    def empty(config: JoystickModelConfig) -> JoystickBins:
        """No sample in any bin."""
        size = config.bins**2
        return JoystickBins(np.zeros(size), np.zeros((size, 2)), np.zeros((size, 2)), np.zeros((size, 2)))

    @staticmethod
    def of_pairs(raw: ArrayLike, safe: ArrayLike, config: JoystickModelConfig | None = None) -> JoystickBins:
        """Pairs (N, 2) -> statistics. ValueError unless N >= 1 and all is finite and within [-1, 1]."""
        config = config or JoystickModelConfig()
        x, wanted = _pairs(raw, safe)
        if len(x) == 0:
            raise ValueError("a joystick model needs at least one pair, got none")
        y = wanted - x if config.prior == "identity" else wanted
        index, size = bin_of(x, config.bins), config.bins**2
        count = np.bincount(index, minlength=size).astype(float)
        inside = np.maximum(count, 1)[:, None]

        def total(values: Floats) -> Floats:
            return np.stack([np.bincount(index, values[:, k], minlength=size) for k in (0, 1)], axis=1)

        target = total(y) / inside
        return JoystickBins(count, total(x) / inside, target, total((y - target[index]) ** 2) / inside)

    def joined(self, other: JoystickBins) -> JoystickBins:
        """The statistics of both sets of samples together."""
        count = self.count + other.count
        ours, theirs = (c[:, None] / np.where(count > 0, count, 1)[:, None] for c in (self.count, other.count))
        target = ours * self.target + theirs * other.target
        spread = ours * (self.variance + (self.target - target) ** 2)
        spread += theirs * (other.variance + (other.target - target) ** 2)
        return JoystickBins(count, ours * self.raw + theirs * other.raw, target, spread)

    def wanted(self, config: JoystickModelConfig) -> Floats:
        """(B, 2): each bin's mean wanted joystick; (0, 0) without data."""
        return self.raw + self.target if config.prior == "identity" else self.target

    def tensors(self) -> Tensors:
        """The arrays to store."""
        return {name: np.asarray(getattr(self, name)) for name in ("count", "raw", "target", "variance")}

    @staticmethod
    def of_tensors(tensors: Tensors, config: JoystickModelConfig) -> JoystickBins:
        """From what `tensors` gave. KeyError or ValueError if that is not what it claims to be."""
        bins = JoystickBins(*(_floats(tensors, name) for name in ("count", "raw", "target", "variance")))
        _check_bins(bins, config)
        return bins

    def shared_variance(self, pooled_samples: float) -> Floats:
        """(B, 2): each bin's variance with `pooled_samples` samples of the pooled one; that alone where no data is."""
        freedom = np.sum(np.maximum(self.count - 1, 0))
        pooled = np.sum(self.count[:, None] * self.variance, axis=0) / max(freedom, 1.0)
        weight = self.count[:, None]
        shared: Floats = (weight * self.variance + pooled_samples * pooled) / (weight + pooled_samples)
        return shared

    def training_data(self, axis: int, config: JoystickModelConfig) -> tuple[Floats, Floats, Floats]:
        """-> inputs (N, 2), targets (N,), noise variances (N,) of the bins with data."""
        there = self.count > _NOTHING
        variance = self.shared_variance(config.pooled_samples)[there, axis]
        if config.noise == "of_mean":
            variance = variance / self.count[there]
        return self.raw[there], self.target[there, axis], variance


def bin_of(joystick: Floats, bins: int) -> NDArray[np.int64]:
    """(N, 2) in [-1, 1] -> (N,) index of the bin."""
    cell = np.minimum(((joystick + 1) * (bins / 2)).astype(np.int64), bins - 1)
    return cell[:, 0] * bins + cell[:, 1]


class JoystickModel:
    """Asked with a raw joystick, gives mean and variance of the wanted one. Immutable."""

    def __init__(
        self,
        bins: JoystickBins,
        priors: tuple[JoystickPrior, JoystickPrior],
        config: JoystickModelConfig | None = None,
    ) -> None:
        """priors: (forward, left). ValueError if the statistics are not those of config.bins x config.bins."""
        self.bins, self.priors, self.config = bins, priors, config or JoystickModelConfig()
        size = self.config.bins**2
        if bins.count.shape != (size,):
            raise ValueError(f"statistics of {bins.count.shape} bins for a model of {size}")
        self._processes = tuple(self._condition(axis) for axis in (0, 1))
        self._scatter = self._scatter_map().tolist()

    def _condition(self, axis: int) -> GaussianProcess | None:
        inputs, targets, variances = self.bins.training_data(axis, self.config)
        return GaussianProcess(inputs, targets, variances, *self.priors[axis]) if len(inputs) else None

    def _scatter_map(self) -> Floats:
        """(bins + 2, bins + 2, 2) variance around f at the bins' centres, repeated outside."""
        n = self.config.bins
        if self.config.noise == "of_samples":
            return np.zeros((n + 2, n + 2, 2))
        noise = np.square([prior.noise for prior in self.priors])
        scatter = self.bins.shared_variance(self.config.pooled_samples) + noise
        return np.pad(scatter.reshape(n, n, 2), ((1, 1), (1, 1), (0, 0)), mode="edge")

    def predict(self, joystick: ArrayLike) -> JoystickEstimate:
        """Raw (forward, left) in [-1, 1] -> the wanted one's mean and variance. ValueError outside or for NaN.

        The mean is not clipped. At rest (0, 0) it says how the chair went on with the stick at rest: that has no
        orientation, and is the caller's to see.
        """
        forward, left = np.asarray(joystick, dtype=float).tolist()
        if not (abs(forward) <= _LIMIT and abs(left) <= _LIMIT):
            raise ValueError(f"joystick is ({forward}, {left}), must be finite and within [-1, 1]")
        base = (forward, left) if self.config.prior == "identity" else (0.0, 0.0)
        query = np.array((forward, left))
        scatter = self._scatter_at(forward, left)
        moments = [self._moments(axis, query) for axis in (0, 1)]
        return JoystickEstimate(
            (base[0] + moments[0][0], base[1] + moments[1][0]),
            (scatter[0] + moments[0][1], scatter[1] + moments[1][1]),
        )

    def _moments(self, axis: int, query: Floats) -> tuple[float, float]:
        process = self._processes[axis]
        if process is None:
            return 0.0, self.priors[axis].kernel.amplitude ** 2
        return process.predict_one(query)

    def _scatter_at(self, forward: float, left: float) -> tuple[float, float]:
        """Bilinear between the bins' centres."""
        half = self.config.bins / 2
        x, y = (forward + 1) * half + 0.5, (left + 1) * half + 0.5
        i, j = int(x), int(y)
        u, v = x - i, y - j
        near, far = self._scatter[i], self._scatter[min(i + 1, len(self._scatter) - 1)]
        k = min(j + 1, len(near) - 1)
        weights = ((1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v)
        corners = (near[j], near[k], far[j], far[k])
        return (
            sum(w * c[0] for w, c in zip(weights, corners, strict=True)),
            sum(w * c[1] for w, c in zip(weights, corners, strict=True)),
        )

    def predict_many(self, joystick: ArrayLike) -> tuple[Floats, Floats]:
        """(N, 2) -> means (N, 2), variances (N, 2): `predict` for each."""
        estimates = [self.predict(row) for row in np.asarray(joystick, dtype=float)]
        return np.array([e.mean for e in estimates]), np.array([e.variance for e in estimates])

    def tensors(self) -> Tensors:
        """The arrays to store."""
        scales = np.array([prior.kernel.lengthscales for prior in self.priors])
        return {**self.bins.tensors(), "lengthscales": scales}

    def header(self) -> dict[str, Any]:
        """What to store beside the arrays, as JSON."""
        axes = [{"amplitude": p.kernel.amplitude, "family": p.kernel.family, "noise": p.noise} for p in self.priors]
        return {"config": asdict(self.config), "axes": axes}

    @staticmethod
    def of_tensors(header: dict[str, Any], tensors: Tensors) -> JoystickModel:
        """From what `header` and `tensors` gave. ModelError if that is not what it claims to be."""
        try:
            config = JoystickModelConfig(**header["config"])
            bins = JoystickBins.of_tensors(tensors, config)
            scales, axes = _floats(tensors, "lengthscales"), header["axes"]
            if scales.shape != (2, 2) or len(axes) != 2:
                raise ValueError(f"lengthscales are {scales.shape} for {len(axes)} axes, must be (2, 2) for 2")
            return JoystickModel(bins, (_prior(axes[0], scales[0]), _prior(axes[1], scales[1])), config)
        except (KeyError, TypeError, ValueError, OverflowError) as broken:
            raise ModelError(f"not a usable joystick model: {broken}") from broken

    def save(self, path: str | os.PathLike[str]) -> None:
        """One file: safetensors with a JSON header."""
        write_tensor_file(path, _KIND, _VERSION, self.header(), self.tensors())

    @staticmethod
    def load(path: str | os.PathLike[str]) -> JoystickModel:
        """ModelError for a file that is damaged, of another kind or version."""
        return JoystickModel.of_tensors(*read_tensor_file(path, _KIND, _VERSION))


def _floats(tensors: Tensors, name: str) -> Floats:
    array = tensors[name]
    if array.dtype != np.float64:
        raise ValueError(f"{name} is {array.dtype}, must be float64")
    return array


def _prior(axis: dict[str, Any], lengthscales: Floats) -> JoystickPrior:
    for name, kinds in (("amplitude", (int, float)), ("noise", (int, float)), ("family", str)):
        if not isinstance(axis[name], kinds) or isinstance(axis[name], bool):
            raise ValueError(f"{name} is {axis[name]!r}, must be {'a name' if kinds is str else 'a number'}")
    noise = float(axis["noise"])
    if not 0 <= noise < np.inf:
        raise ValueError(f"noise is {noise} of full stick, must be >= 0 and finite")
    return JoystickPrior(Kernel(float(axis["amplitude"]), lengthscales, family=axis["family"]), noise)


_MOST = {"count": 1e12, "raw": 1.0, "target": 2.0, "variance": 4.0}
"""Beyond which (with rounding) no statistics of a stick within [-1, 1] lie; a variance is one of offsets within 2."""


def _check_bins(bins: JoystickBins, config: JoystickModelConfig) -> None:
    size = config.bins**2
    for name, shape in (("count", (size,)), ("raw", (size, 2)), ("target", (size, 2)), ("variance", (size, 2))):
        values = getattr(bins, name)
        if values.shape != shape or not np.all(np.isfinite(values)):
            raise ValueError(f"{name} must be finite and {shape}, is {values.shape}")
        if np.any(np.abs(values) > _MOST[name] * (1 + 1e-3)):
            raise ValueError(f"{name} is {np.abs(values).max():g} somewhere, must be at most {_MOST[name]:g}")
    if np.any(bins.count < 0) or np.any(bins.variance < 0):
        raise ValueError("counts and variances must not be negative")


@dataclass(frozen=True)
class JoystickAdapterConfig:
    """How fast a driver's own pairs replace what was learned before."""

    trained_samples: float = 3.0
    """A bin's demonstrations count as at most so many of the driver's samples, for ever."""
    memory: float = 3000.0
    """A pair counts e times less after so many others: 5 minutes at 10 Hz. Then the demonstrations hold again."""
    every: int = 10
    """New pairs between two conditionings of the processes."""

    def __post_init__(self) -> None:
        if not 0 <= self.trained_samples < np.inf:
            raise ValueError(f"trained_samples is {self.trained_samples}, must be >= 0 and finite")
        if not 1 <= self.memory < np.inf:
            raise ValueError(f"memory is {self.memory}, must be at least 1 pair and finite")
        if self.every < 1:
            raise ValueError(f"every is {self.every}, must be at least 1 pair")


class JoystickAdapter:
    """Adapts a joystick model to its driver while driving (Sec. 6.2.1).

    The driver's own pairs go into bins of their own, joined with the demonstrations' for every conditioning. Memory:
    the bins' statistics, nothing else. The hyper-parameters stay.
    """

    def __init__(self, trained: JoystickModel, config: JoystickAdapterConfig | None = None) -> None:
        """Starts from `trained`."""
        self.trained, self.config = trained, config or JoystickAdapterConfig()
        self.reset()

    @property
    def model(self) -> JoystickModel:
        """As of the last conditioning: at most `every` - 1 pairs behind."""
        return self._model

    @property
    def own(self) -> JoystickBins:
        """The driver's own statistics."""
        return self._own

    def reset(self) -> None:
        """Back to the trained model: another driver."""
        self._own, self._new, self._model = JoystickBins.empty(self.trained.config), 0, self.trained

    def save(self, path: str | os.PathLike[str]) -> None:
        """The driver's own statistics in one file, for `resume`."""
        write_tensor_file(path, _DRIVER, _VERSION, {"config": asdict(self.trained.config)}, self._own.tensors())

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Goes on where `save` was called, over this adapter's trained model. ModelError for a file that is damaged, of
        another kind, version or configuration; then nothing is changed."""
        header, tensors = read_tensor_file(path, _DRIVER, _VERSION)
        if header.get("config") != asdict(self.trained.config):
            raise ModelError(f"{path} was made with another configuration than the trained joystick model")
        try:
            own = JoystickBins.of_tensors(tensors, self.trained.config)
        except (KeyError, TypeError, ValueError, OverflowError) as broken:
            raise ModelError(f"{path} does not hold a driver's joystick statistics: {broken}") from broken
        self._own = own
        self._condition()

    def add(self, raw: ArrayLike, followed: ArrayLike) -> JoystickModel:
        """A pair (2,), (2,) of the raw joystick and the one that was followed -> the model now. ValueError for what is
        not finite or outside [-1, 1]; then nothing is learned."""
        x, wanted = _pairs(np.asarray(raw)[None], np.asarray(followed)[None])
        config, own = self.trained.config, self._own
        y = (wanted - x if config.prior == "identity" else wanted)[0]
        b = int(bin_of(x, config.bins)[0])
        np.multiply(own.count, 1 - 1 / self.config.memory, out=own.count)
        own.count[b] += 1
        share, off = 1 / own.count[b], y - own.target[b]
        own.variance[b] = (1 - share) * (own.variance[b] + share * off**2)
        own.target[b] += share * off
        own.raw[b] += share * (x[0] - own.raw[b])
        self._new += 1
        if self._new >= self.config.every:
            self._condition()
        return self._model

    def relabel(self, wanted: ArrayLike) -> None:
        """Says anew what was wanted, where the driver has been: (B, 2), for each bin's mean raw joystick. Counts from
        the next conditioning on. ValueError unless finite and (B, 2); then nothing is changed."""
        meant, own = np.asarray(wanted, dtype=float), self._own
        if meant.shape != own.target.shape or not np.all(np.isfinite(meant)):
            raise ValueError(f"wanted must be finite and {own.target.shape}, is {meant.shape}")
        base = own.raw if self.trained.config.prior == "identity" else 0.0
        own.target[:] = np.where(own.count[:, None] > 0, meant - base, 0.0)

    def _condition(self) -> None:
        self._new = 0
        known = self.trained.bins
        limited = replace(known, count=np.minimum(known.count, self.config.trained_samples))
        self._model = JoystickModel(limited.joined(self._own), self.trained.priors, self.trained.config)
