"""
Movement and interaction primitives, dynamic time warping, orientations, sequences of tasks.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "Dmp",
    "DmpConfig",
    "DmpStepper",
    "DmpTrajectory",
    "DtwResult",
    "InteractionObserver",
    "InteractionPosterior",
    "InteractionPrimitive",
    "InteractionPrimitiveConfig",
    "InteractionTrajectory",
    "OpenEndDtw",
    "OpenEndPhase",
    "PartnerPhase",
    "PhaseEstimator",
    "PhaseEstimatorConfig",
    "SequenceBelief",
    "SequenceConfig",
    "SequenceHmm",
    "SequencePrimitive",
    "basis",
    "continuous_quaternions",
    "dtw",
    "dtw_distance",
    "forcing_terms",
    "geodesic_angle",
    "imaginary_parts",
    "mean_orientation",
    "open_end_dtw",
    "partner_forcing",
    "phases",
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

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        phase_decay: float = 4.605170185988092,
        tempo_window: float = 0.5,
        rest_share: float = 0.05,
        pause_rate: float = 0.15,
    ) -> None: ...
    def __repr__(self) -> str: ...
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

    def __hash__(self) -> int: ...
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
    def __repr__(self) -> str: ...
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

class DmpConfig:
    """
    The constants of 5.1 and 5.2 (ERRATA F13): basis_functions M, stiffness alpha_y, damping beta_y (critical at alpha_y / 4), phase_decay alpha_x. ValueError unless 2 <= M <= 1000, 0 < alpha_y, beta_y <= 1e4, 0 < alpha_x <= 100.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        basis_functions: int = 20,
        stiffness: float = 25.0,
        damping: float = 6.25,
        phase_decay: float = 4.605170185988092,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def basis_functions(self) -> int: ...
    @property
    def damping(self) -> float: ...
    @property
    def phase_decay(self) -> float: ...
    @property
    def stiffness(self) -> float: ...

class DmpTrajectory:
    """
    A motion of D degrees of freedom; its arrays are views, one degree of freedom contiguous.
    """

    @property
    def accelerations(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (steps, D) a second squared
        """

    @property
    def positions(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (steps, D)
        """

    @property
    def time(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (steps,) [s] since the begin
        """

    @property
    def velocities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (steps, D) a second
        """

class DmpStepper:
    """
    A motion that is run step by step (Dmp.begin).
    """

    def step(self, dt: float) -> numpy.typing.NDArray[numpy.float64]:
        """
        Advances by dt >= 0 [s], exact up to 1e-9 of the range whatever dt is -> position (D,). ValueError for dt * rate > 1e4 or not finite.
        """

    @property
    def goal(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,); may be set on the run, position and velocity stay continuous. ValueError unless finite.
        """

    @goal.setter
    def goal(self, arg1: numpy.typing.ArrayLike) -> None: ...
    @property
    def phase(self) -> float:
        """
        x; below exp(-alpha_x) the motion is over
        """

    @property
    def position(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a copy
        """

    @property
    def rate(self) -> float:
        """
        tau [1/s]; may be set on the run, position and velocity stay continuous. ValueError unless > 0.
        """

    @rate.setter
    def rate(self, arg1: float) -> None: ...
    @property
    def velocity(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,) a second, a copy
        """

class Dmp:
    """
    A dynamic movement primitive of D degrees of freedom (5.1-5.4): y'' = (alpha_y (beta_y (g - y) - y' / tau) + phi(x)^T w) tau^2, x' = -alpha_x x tau. tau is a rate, 1 / duration (ERRATA 34).
    """

    @staticmethod
    def fit(positions: numpy.typing.ArrayLike, config: DmpConfig = ..., *, by: str = "forcing") -> Dmp:
        """
        Positions (T, D), T >= 3, evenly spaced in time; the demonstration's duration does not matter, a run's rate gives it back. by='forcing': least squares of 5.3 with differences as derivatives, the goal is the last position (5.4, ERRATA 37). by='positions': start, goal and weights are least squares of the motion from rest itself, without derivatives, which noise spoils. ValueError for fewer samples and values not finite or beyond 1e9.
        """

    def __init__(
        self,
        start: numpy.typing.ArrayLike,
        goal: numpy.typing.ArrayLike,
        weights: numpy.typing.ArrayLike,
        config: DmpConfig = ...,
    ) -> None:
        """
        start (D,), goal (D,), weights (D, M). ValueError for other shapes and what is not finite.
        """

    def begin(
        self,
        *,
        rate: float = 1.0,
        phase: float = 1.0,
        position: numpy.typing.ArrayLike | None = None,
        velocity: numpy.typing.ArrayLike | None = None,
    ) -> DmpStepper:
        """
        A DmpStepper from anywhere: phase in (0, 1], position (D,), velocity (D,) a second; else as rollout.
        """

    def rollout(
        self,
        steps: int,
        *,
        rate: float = 1.0,
        phase: float = 1.0,
        position: numpy.typing.ArrayLike | None = None,
        velocity: numpy.typing.ArrayLike | None = None,
        duration: float | None = None,
    ) -> DmpTrajectory:
        """
        The motion in `steps` evenly spread samples, exact up to 1e-9 of its range. rate tau [1/s]; phase in (0, 1] at the begin; position (D,) there, by default the start; velocity (D,) a second, by default at rest; duration [s], by default up to the demonstration's end. The matrix that maps (w, g, position, velocity) to the samples is kept for the next call with the same steps, phase and duration * rate. ValueError unless steps in [2, 1e6], rate > 0 and all finite, and for a phase at the end without a duration.
        """

    @property
    def config(self) -> DmpConfig: ...
    @property
    def dimensions(self) -> int:
        """
        D
        """

    @property
    def goal(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a view
        """

    @property
    def start(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), a view
        """

    @property
    def weights(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D, M), a view
        """

class InteractionPrimitiveConfig:
    """
    observe: what enters the likelihood, and by what demonstrations are fitted: 'forcing' (5.11) or 'positions', which needs no derivatives. noise: sigma^2, a variance in the unit of what is observed (ERRATA 41), by default the partner's squared residual after the fit, pooled over samples, dimensions and demonstrations (ERRATA F13). environment_noise: sigma_e^2 of the standardised environment. printed_environment_weights: the environment as w_e theta as printed after 5.16, instead of jointly Gaussian with theta (ERRATA 42). ValueError unless the variances are > 0.
    """

    def __hash__(self) -> int: ...
    def __init__(
        self,
        *,
        dmp: DmpConfig = ...,
        observe: str = "positions",
        noise: float | None = None,
        environment_noise: float = 0.001,
        printed_environment_weights: bool = False,
    ) -> None: ...
    def __repr__(self) -> str: ...
    @property
    def dmp(self) -> DmpConfig: ...
    @property
    def environment_noise(self) -> float: ...
    @property
    def noise(self) -> float | None: ...
    @property
    def observe(self) -> str: ...
    @property
    def printed_environment_weights(self) -> bool: ...

class InteractionTrajectory:
    """
    N degrees of freedom, the partner's first, at evenly spread samples of the motion.
    """

    @property
    def covariance(self) -> numpy.ndarray:
        """
        (steps, N, N), a view: between the degrees of freedom at one time
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (steps, N), a view
        """

class InteractionPosterior:
    """
    p(theta | what was seen) = N(mean, factor factor^T) (5.15); rank < S.
    """

    def sample(self, count: int, seed: int) -> numpy.typing.NDArray[numpy.float64]:
        """
        theta (count, D); the same seed gives the same.
        """

    def sample_trajectories(self, count: int, steps: int, seed: int) -> numpy.ndarray:
        """
        Motions (count, steps, N) of the same draws as sample(count, seed).
        """

    def trajectory(self, steps: int) -> InteractionTrajectory:
        """
        Mean and covariance of the motion, linear in theta and its start. ValueError unless 2 <= steps <= 1e6.
        """

    @property
    def factor(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D, S), the covariance is factor @ factor.T; computed anew
        """

    @property
    def log_likelihood(self) -> float:
        """
        ln p(what was seen), the environment standardised (first block of 5.14)
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (D,), D = N (M + 1): w_1, g_1, w_2, ...; computed anew
        """

    @property
    def partner(self) -> Dmp:
        """
        The mean's Dmp of the partner
        """

    @property
    def robot(self) -> Dmp:
        """
        The mean's Dmp of the robot, to be run from phase x* and the robot's own state (ERRATA F14). ValueError if the primitive has no robot.
        """

    @property
    def start(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N,) expected begin of the motion
        """

    @property
    def trace(self) -> float:
        """
        of theta's covariance
        """

class InteractionObserver:
    """
    Gathers what is seen, sample by sample (InteractionPrimitive.begin).
    """

    def observe(self, phase: float, values: numpy.typing.ArrayLike) -> None:
        """
        The partner's forcing (n,), as partner_forcing gives it, or positions (n,), as the config says, at a phase in [exp(-alpha_x), 1]; NaN where not seen. In any order. ValueError for other shapes and infinity.
        """

    def posterior(self) -> InteractionPosterior:
        """
        The same as condition() gives for all that was observed.
        """

class InteractionPrimitive:
    """
    A Gaussian over the parameters of S demonstrations of partner and robot (5.6-5.9), and of the environment (5.16-5.19), conditioned on what is seen (5.15 in its S x S form, ERRATA 40).
    """

    @staticmethod
    def fit(
        partner: collections.abc.Sequence[numpy.typing.ArrayLike],
        robot: collections.abc.Sequence[numpy.typing.ArrayLike],
        environment: numpy.typing.ArrayLike | None = None,
        config: InteractionPrimitiveConfig = ...,
    ) -> InteractionPrimitive:
        """
        S >= 2 demonstrations: partner, robot: lists of (T_j, n) and (T_j, r), evenly spaced in time, each fitted in its own normalised time, so that lengths may differ; environment (S, E), any units: it is standardised. ValueError as Dmp.fit, for different dimensions or counts, and for an environment column that does not vary.
        """

    def __init__(
        self,
        parameters: numpy.typing.ArrayLike,
        starts: numpy.typing.ArrayLike,
        environment: numpy.typing.ArrayLike | None,
        partner_dimensions: int,
        config: InteractionPrimitiveConfig,
    ) -> None:
        """
        From another primitive's attributes of the same names, with the same answers. parameters (S, N (M + 1)), starts (S, N), environment (S, E) or None, config.noise set. ValueError for shapes that do not fit, what is not finite and an environment column that does not vary.
        """

    def begin(self, environment: numpy.typing.ArrayLike | None = None) -> InteractionObserver:
        """
        An InteractionObserver, for an observation that grows.
        """

    def condition(
        self,
        partner: numpy.typing.ArrayLike | None = None,
        phase: numpy.typing.ArrayLike | None = None,
        environment: numpy.typing.ArrayLike | None = None,
    ) -> InteractionPosterior:
        """
        Partner's positions (K, n) at falling phases (K,), environment (E,). NaN: not seen; nothing seen gives the prior. With observe='forcing', fewer than 3 seen samples in a row are left out. Phases are in [exp(-alpha_x), 1]: an observation longer than the motion is refused. ValueError for other shapes, phases and values beyond 1e9.
        """

    @property
    def config(self) -> InteractionPrimitiveConfig:
        """
        with the noise in use
        """

    @property
    def environment(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        (S, E) as given, or None
        """

    @property
    def parameters(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (S, D), a view
        """

    @property
    def partner_dimensions(self) -> int:
        """
        n
        """

    @property
    def robot_dimensions(self) -> int:
        """
        r
        """

    @property
    def starts(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (S, N), a view
        """

def basis(phase: numpy.typing.ArrayLike, config: DmpConfig = ...) -> numpy.typing.NDArray[numpy.float64]:
    """
    phi(x)^T of 5.2 at phases (T,), the factor x included -> (T, M). ValueError for a phase outside (0, 1].
    """

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

def forcing_terms(
    positions: numpy.typing.ArrayLike, goal: numpy.typing.ArrayLike, config: DmpConfig = ...
) -> numpy.typing.NDArray[numpy.float64]:
    """
    5.3 for positions (T, D), T >= 3, at normalised times k / (T - 1), and the goal (D,) -> (T, D); derivatives as np.gradient(edge_order=2). ValueError for other shapes and values not finite or beyond 1e9.
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

def partner_forcing(
    positions: numpy.typing.ArrayLike, phase: numpy.typing.ArrayLike, config: DmpConfig = ...
) -> numpy.typing.NDArray[numpy.float64]:
    """
    F of 5.12 of a partner's positions (K, n) at falling phases (K,); NaN where fewer than 3 samples in a row were seen. ValueError as for condition().
    """

def phases(steps: int, config: DmpConfig = ...) -> numpy.typing.NDArray[numpy.float64]:
    """
    Phases (steps,) of samples evenly spread over a demonstration: exp(-alpha_x k / (steps - 1)). ValueError unless 2 <= steps <= 1e6.
    """

def quaternions_from_imaginary(
    parts: numpy.typing.ArrayLike, reference: numpy.typing.ArrayLike
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Inverse of imaginary_parts: (T, 3), (4,) -> (T, 4) of length 1, w = sqrt(max(0, 1 - |v|^2)) (ERRATA 44): parts longer than 1 count as half a turn about their axis. ValueError for what is not finite.
    """
