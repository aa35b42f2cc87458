"""
Movement and interaction primitives, dynamic time warping, orientations, sequences of tasks.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "DtwResult",
    "OpenEndDtw",
    "OpenEndPhase",
    "PartnerPhase",
    "PhaseEstimator",
    "PhaseEstimatorConfig",
    "SequenceBelief",
    "SequenceConfig",
    "SequenceHmm",
    "SequencePrimitive",
    "continuous_quaternions",
    "dtw",
    "dtw_distance",
    "geodesic_angle",
    "imaginary_parts",
    "mean_orientation",
    "open_end_dtw",
    "quaternions_from_imaginary",
]

class DtwResult:
    """
    An alignment of two series of m and n samples.
    """

    @property
    def costs(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (m, n) accumulated costs, inf outside the window; a view
        """

    @property
    def distance(self) -> float:
        """
        D(m, n), in the series' unit
        """

    @property
    def path(self) -> numpy.typing.NDArray[numpy.int64]:
        """
        (K, 2) int64 rows that correspond, (0, 0) to (m - 1, n - 1); a view
        """

class OpenEndPhase:
    """
    Where in the reference a partial series has come to.
    """

    @property
    def distance(self) -> float:
        """
        D(m, t*), in the series' unit
        """

    @property
    def index(self) -> int:
        """
        t* - 1: row of the reference, argmin_j D(m, j), ties to the smallest; -1 before any sample
        """

class OpenEndDtw:
    """
    Dynamic time warping whose end in the reference is open, sample by sample (Sec. 5.3.1, ERRATA 49).
    """

    def __init__(self, reference: numpy.typing.ArrayLike) -> None:
        """
        (n, D) or (n,). ValueError if it is empty or not finite and within 1e100.
        """

    def __len__(self) -> int: ...
    def observe(self, sample: numpy.typing.ArrayLike) -> OpenEndPhase:
        """
        The next sample (D,) in O(n D). NaN in a dimension: not seen; the distance over the others is scaled by sqrt(D / seen). A sample without any seen dimension changes nothing. ValueError, and it stays as it was, for another D and for what is infinite or beyond 1e100.
        """

    def reset(self) -> None:
        """
        Forgets all samples.
        """

    @property
    def dimensions(self) -> int:
        """
        D
        """

class PhaseEstimatorConfig:
    """
    How PhaseEstimator reads phase and tempo. ValueError names a field.
    """

    def __init__(
        self,
        *,
        phase_decay: float = 4.605170185988092,
        tempo_window: float = 0.5,
        rest_share: float = 0.05,
        pause_rate: float = 0.15,
    ) -> None: ...
    @property
    def pause_rate(self) -> float:
        """
        slower than this share of the reference's tempo is a pause
        """

    @property
    def phase_decay(self) -> float:
        """
        alpha_x > 0 of the DMPs' canonical system, ln 100
        """

    @property
    def rest_share(self) -> float:
        """
        no further from its start than this share of the way is rest
        """

    @property
    def tempo_window(self) -> float:
        """
        the rate is of the last [s], 0 < .. <= 60
        """

class PartnerPhase:
    """
    How far a partner has come, and how fast.
    """

    @property
    def determined(self) -> bool:
        """
        False while partner or reference still rest at their start: then index says nothing
        """

    @property
    def distance(self) -> float:
        """
        of the open-end DTW
        """

    @property
    def index(self) -> int:
        """
        t* - 1, row of the reference; -1 before any sample
        """

    @property
    def mean_rate(self) -> float:
        """
        reference_time / time since the first sample (t* / T' of F14); 1 until determined
        """

    @property
    def paused(self) -> bool:
        """
        the partner stands still, or has come to the end
        """

    @property
    def phase(self) -> float:
        """
        x* = exp(-alpha_x (t* - 1) / (n - 1)) (5.5, ERRATA 38)
        """

    @property
    def rate(self) -> float:
        """
        the tempo now, 1 = the reference's, >= 0; 1 until known
        """

    @property
    def reference_time(self) -> float:
        """
        of that row [s]
        """

class PhaseEstimator:
    """
    How far a partner has come in a movement, and how fast (5.5, ERRATA 38). Open-end DTW gives t*: it does not care about tempo, a pausing partner leaves it where it is. The rate is the slope of t* over the last tempo_window: the line through the medians of its first and its last third, so that single jumps of t* do not count. The phase is determined, for good, once partner and reference have both gone further from their starts than rest_share of the reference's greatest distance from its own. Sample the reference about as densely as the partner: many more rows make t* lag.
    """

    def __init__(self, reference: numpy.typing.ArrayLike, duration: float, config: PhaseEstimatorConfig = ...) -> None:
        """
        reference (n, D) evenly sampled over `duration` [s]. ValueError for n < 2, what is not finite and within 1e100, a reference that never leaves its start, and a duration that is not > 0.
        """

    def __len__(self) -> int: ...
    def observe(self, stamp: float, sample: numpy.typing.ArrayLike) -> PartnerPhase:
        """
        The partner's sample (D,) at stamp [s]; NaN as in OpenEndDtw: one without any seen dimension changes nothing but the clock. ValueError, and it stays as it was, for a stamp that is not finite or not later than the last and for samples that OpenEndDtw refuses.
        """

    def reset(self) -> None:
        """
        Forgets all samples.
        """

    @property
    def config(self) -> PhaseEstimatorConfig: ...
    @property
    def dimensions(self) -> int:
        """
        D
        """

    @property
    def duration(self) -> float:
        """
        [s]
        """

class SequenceConfig:
    """
    Transition probabilities (a sample's) and densities of SequenceHmm; none is learned. ValueError names a field.
    """

    def __init__(
        self,
        *,
        phase_steps: int = 50,
        pause: float = 0.1,
        finish: float = 0.1,
        chain: float = 0.5,
        abandon: float = 0.001,
        start: float = 0.02,
        none_prior: float = 0.1,
        background_width: float = 1.5,
        widening: float = 1.5,
        least_deviation: float = 0.02,
    ) -> None: ...
    @property
    def abandon(self) -> float:
        """
        P(any other step -> none of them), [0, 1)
        """

    @property
    def background_width(self) -> float:
        """
        none of them is uniform over this many times the demonstrations' range, > 0
        """

    @property
    def chain(self) -> float:
        """
        P(another primitive begins at once | one was left), else none of them
        """

    @property
    def finish(self) -> float:
        """
        P(a primitive's last step is left), (0, 1]
        """

    @property
    def least_deviation(self) -> float:
        """
        least standard deviation, as a share of the demonstrations' range, > 0
        """

    @property
    def none_prior(self) -> float:
        """
        P(none of them at the first sample), [0, 1)
        """

    @property
    def pause(self) -> float:
        """
        P(the partner stands still), [0, 1)
        """

    @property
    def phase_steps(self) -> int:
        """
        S, states a primitive, 2..1000
        """

    @property
    def start(self) -> float:
        """
        P(none of them -> the beginning of a primitive), [0, 1]
        """

    @property
    def widening(self) -> float:
        """
        factor on the demonstrations' variance, > 0
        """

class SequencePrimitive:
    """
    A partner's movement over the phase grid s / (S - 1).
    """

    def __init__(self, mean: numpy.typing.ArrayLike, variance: numpy.typing.ArrayLike, samples: float) -> None:
        """
        mean (S, D), variance (S, D) > 0, samples >= 2: duration at tempo 1. Checked by SequenceHmm.
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (S, D), a view
        """

    @property
    def samples(self) -> float: ...
    @property
    def variance(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (S, D), a view
        """

class SequenceBelief:
    """
    What the filter knows after a sample.
    """

    @property
    def log_likelihood(self) -> float:
        """
        ln p(all samples so far)
        """

    @property
    def none(self) -> float:
        """
        that it is in none of them; all sum to 1
        """

    @property
    def probabilities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (P,) that the partner is within each; a view
        """

    @property
    def progress(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (P,) mean of s / (S - 1) given the primitive, NaN where its probability is 0; a view
        """

    @property
    def recognised(self) -> int:
        """
        the most probable, ties to the first primitive; -1 = none of them
        """

    @property
    def steps(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (P, S) joint probabilities of primitive and phase step; a view
        """

class SequenceHmm:
    """
    Which task a partner has begun (Sec. 6.2.2): a hidden Markov model, left to right through the phase steps of each primitive. A sample advances by 0 with probability `pause`, else by a Poisson number of steps, S - 1 in `samples` samples on average; the last step holds until it is left. Samples are diagonal Gaussians around a step's mean; in 'none of them' they have a constant density. Forward filter in log space. Positions and their differences from the sample before, side by side, tell tasks apart sooner than positions.
    """

    @staticmethod
    def fit(
        demonstrations: collections.abc.Sequence[collections.abc.Sequence[numpy.typing.ArrayLike]],
        config: SequenceConfig = ...,
    ) -> SequenceHmm:
        """
        From demonstrations[p], each (T, D) with T >= 2, sampled as the partner will be: stretched to the grid and once aligned with their mean by DTW; their variance (unbiased, averaged with its mean over the phase) times `widening`, plus a step's extent, at least `least_deviation` squared. ValueError for none, other shapes and what is not finite and within 1e100, naming primitive and demonstration.
        """

    def __init__(
        self,
        primitives: collections.abc.Sequence[SequencePrimitive],
        background_density: numpy.typing.ArrayLike,
        config: SequenceConfig = ...,
    ) -> None:
        """
        background_density (D,) [1 / unit]: of 'none of them' in each dimension. ValueError for no primitives and for what does not fit or is not finite and positive.
        """

    def __len__(self) -> int: ...
    def log_advances(self, primitive: int) -> numpy.typing.NDArray[numpy.float64]:
        """
        (K,) ln P(a sample advances by k = 0, 1, .. steps). IndexError for no such primitive.
        """

    def observe(self, sample: numpy.typing.ArrayLike) -> SequenceBelief:
        """
        One step of the forward filter with a sample (D,). NaN in a dimension: not seen, the others count; a sample without any only lets time pass. ValueError, and it stays as it was, for another D and for what is infinite or beyond 1e100.
        """

    def reset(self) -> None:
        """
        To the prior, before the first sample.
        """

    @property
    def background_density(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a copy
        """

    @property
    def belief(self) -> SequenceBelief: ...
    @property
    def config(self) -> SequenceConfig: ...
    @property
    def primitives(self) -> list[SequencePrimitive]: ...

def continuous_quaternions(quaternions: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    (T, 4) x y z w -> the same rotations of length 1, the first with w >= 0, each on its predecessor's side (ERRATA 44). Steps of half a turn are ambiguous. ValueError for a length that is not within [1e-9, 1e9].
    """

def dtw(a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike, window: int | None = None) -> DtwResult:
    """
    Alg. 9 (ERRATA 49): aligns a (m, D) and b (n, D), or (m,) and (n,), by Euclidean distance. window: only |i - j| <= window counts (Sakoe-Chiba). Among equal predecessors the path prefers (i-1, j-1), then (i-1, j), then (i, j-1). Takes 8 m n bytes. ValueError for series that are empty, of different D or not finite and within 1e100, and for a window narrower than |m - n|.
    """

def dtw_distance(a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike, window: int | None = None) -> float:
    """
    dtw(a, b, window).distance, the same to the last bit, in O(m + n) memory.
    """

def geodesic_angle(a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    (T, 4), (T, 4) -> (T,) angles in [0, pi] [rad] between rows. ValueError for other shapes and zero lengths.
    """

def imaginary_parts(
    quaternions: numpy.typing.ArrayLike, reference: numpy.typing.ArrayLike
) -> numpy.typing.NDArray[numpy.float64]:
    """
    (T, 4), (4,) -> (T, 3): imaginary parts of conj(reference) q with w >= 0, that is axis * sin(angle / 2) in the reference's frame. ValueError, naming sample and angle, where a series, followed without jumps from its first sample, turns beyond pi from the reference: take mean_orientation of it.
    """

def mean_orientation(quaternions: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
    """
    (T, 4) -> (4,) with w >= 0: the rotation with the least sum of squared chordal distances (largest eigenvector of sum q q'). ValueError for no rows and where no mean stands out.
    """

def open_end_dtw(query: numpy.typing.ArrayLike, reference: numpy.typing.ArrayLike) -> OpenEndPhase:
    """
    The OpenEndPhase after all samples of query (m, D) or (m,); NaN and errors as in OpenEndDtw.
    """

def quaternions_from_imaginary(
    parts: numpy.typing.ArrayLike, reference: numpy.typing.ArrayLike
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Inverse of imaginary_parts: (T, 3), (4,) -> (T, 4) of length 1, w = sqrt(max(0, 1 - |v|^2)) (ERRATA 44): parts longer than 1 count as half a turn about their axis. ValueError for what is not finite.
    """
