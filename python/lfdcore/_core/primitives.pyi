"""
Dynamic movement primitives and interaction primitives.
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
    "InteractionObserver",
    "InteractionPosterior",
    "InteractionPrimitive",
    "InteractionPrimitiveConfig",
    "InteractionTrajectory",
    "basis",
    "forcing_terms",
    "partner_forcing",
    "phases",
]

class DmpConfig:
    """
    The constants of 5.1 and 5.2 (ERRATA F13): basis_functions M, stiffness alpha_y, damping beta_y (critical at alpha_y / 4), phase_decay alpha_x. ValueError unless 2 <= M <= 1000, 0 < alpha_y, beta_y <= 1e4, 0 < alpha_x <= 100.
    """

    def __init__(
        self,
        *,
        basis_functions: int = 20,
        stiffness: float = 25.0,
        damping: float = 6.25,
        phase_decay: float = 4.605170185988092,
    ) -> None: ...
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

    def __init__(
        self,
        *,
        dmp: DmpConfig = ...,
        observe: str = "forcing",
        noise: float | None = None,
        environment_noise: float = 0.001,
        printed_environment_weights: bool = False,
    ) -> None: ...
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

def forcing_terms(
    positions: numpy.typing.ArrayLike, goal: numpy.typing.ArrayLike, config: DmpConfig = ...
) -> numpy.typing.NDArray[numpy.float64]:
    """
    5.3 for positions (T, D), T >= 3, at normalised times k / (T - 1), and the goal (D,) -> (T, D); derivatives as np.gradient(edge_order=2). ValueError for other shapes and values not finite or beyond 1e9.
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
