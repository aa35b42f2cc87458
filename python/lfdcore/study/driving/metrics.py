"""Driving and framework metrics, each with its definition (Sec. 3.6, App. E.3; ERRATA 23, 24, 48, F15, F16)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from lfdcore.geometry import arc_length, wrap_angle
from lfdcore.simulated.trace import DriveTrace, Plan
from lfdcore.wheelchair.observation import MOVING
from lfdcore.wheelchair.paths import distance_to_polyline
from lfdcore.wheelchair.planner import COMPLIANT_FROM, LOOK_AHEAD, Compliance

Array = NDArray[np.float64]

JERK_WINDOW = 0.5
"""Savitzky-Golay window [s] of the angular jerk (ERRATA 24: without smoothing odometry noise dominates)."""
ENTROPY_PERIOD = 0.15
"""Sampling period [s] of the steering signal (Nakayama et al. 1999)."""
NEAREST = 0.2
"""Path points nearer to the path's start [m] than this are no control points."""


def angular_jerk(omega: Array, period: float, window: float = JERK_WINDOW) -> float:
    """Mean magnitude of the second derivative of the yaw rate [rad/s^3].

    `omega` (T,) [rad/s] at a fixed `period` [s]; the derivative is that of a Savitzky-Golay parabola over `window` [s].
    NaN for a series shorter than the window.
    """
    size = 2 * round(window / period / 2) + 1
    if size < 3:
        raise ValueError(f"the window is {window} s, must hold at least 3 samples of {period} s")
    if len(omega) < size:
        return float("nan")
    return float(np.abs(savgol_filter(omega, size, polyorder=2, deriv=2, delta=period)).mean())


def prediction_errors(steering: Array) -> Array:
    """Errors of the second-order Taylor prediction of a steering series (T,) -> (T - 3,) (Eq. E.1)."""
    u = np.asarray(steering, float)
    predicted = u[2:-1] + (u[2:-1] - u[1:-2]) + ((u[2:-1] - u[1:-2]) - (u[1:-2] - u[:-3])) / 2
    return np.asarray(u[3:] - predicted)


def entropy_baseline(steering: Array) -> float:
    """Alpha: the 90th percentile of the prediction errors' magnitude, in the unit of `steering` (Fig. E.2).

    NaN for a series (T,) shorter than 4 samples.
    """
    if len(steering) < 4:
        return float("nan")
    return float(np.percentile(np.abs(prediction_errors(steering)), 90))


def steering_entropy(steering: Array, baseline: float | None = None) -> float:
    """Entropy in [0, 1] of the prediction errors over nine bins (Eq. E.2).

    `steering` (T,) at about .15 s. Bins at +-.5, 1, 2.5 and 5 alpha, where alpha is `baseline` (of an unassisted run,
    say) or, without one, that of the series itself, which makes the figure blind to the size of the errors (ERRATA
    48). A perfectly predictable series gives 0; one shorter than 4 samples NaN, and so does a `baseline` of 0 or NaN: a
    run without prediction errors is no measure of another's.
    """
    if len(steering) < 4:
        return float("nan")
    errors = prediction_errors(steering)
    alpha = entropy_baseline(steering) if baseline is None else baseline
    if not alpha > 1e-9 * np.abs(steering).max():
        return 0.0 if baseline is None else float("nan")
    edges = np.array([-np.inf, -5, -2.5, -1, -0.5, 0.5, 1, 2.5, 5, np.inf]) * alpha
    share = np.histogram(errors, edges)[0] / len(errors)
    share = share[share > 0]
    return float(-(share * np.log(share)).sum() / np.log(9))


def steering_signal(stamp: Array, joystick: Array, period: float = ENTROPY_PERIOD) -> Array:
    """The horizontal axis of the joystick resampled linearly to `period` [s]: stamp (T,), joystick (T, 2) -> (N,)."""
    times = np.arange(stamp[0], stamp[-1], period)
    return np.asarray(np.interp(times, stamp, joystick[:, 1]))


def distance(pose: Array) -> float:
    """Length [m] of the way through poses (T, 3)."""
    return float(arc_length(pose[:, :2])[-1])


def mean_free_speed(trace: DriveTrace) -> float:
    """Mean linear speed [m/s] over the ticks at which the chair moves ahead out of contact; NaN if there are none."""
    free = (trace.twist[:, 0] > MOVING) & ~trace.in_contact
    return float(trace.twist[free, 0].mean()) if free.any() else float("nan")


def reversals(trace: DriveTrace) -> int:
    """How many times the chair begins to move backwards."""
    back = trace.twist[:, 0] < -MOVING
    return int((back[1:] & ~back[:-1]).sum() + back[0])


def stuck_time(trace: DriveTrace, reach: float = 0.1, window: float = 10.0) -> float:
    """Share of ticks in a stretch of `window` [s] with less than `reach` [m] of motion while forward is asked."""
    size = round(window / trace.period)
    if len(trace.stamp) <= size:
        return 0.0
    moved = np.hypot(*(trace.pose[size:, :2] - trace.pose[:-size, :2]).T)
    asked = trace.desired[:, 0] > 0.1
    asks = np.convolve(asked, np.ones(size), "valid")[: len(moved)] / size
    begins = np.flatnonzero((moved < reach) & (asks > 0.5))
    stuck = np.zeros(len(trace.stamp), bool)
    for i in begins:
        stuck[i : i + size + 1] = True
    return float(stuck.mean())


@dataclass(frozen=True)
class DrivingMetrics:
    """One run (Tables 3.1, 3.2, 4.1)."""

    completed: bool
    angular_jerk: float
    """[rad/s^3]"""
    time: float
    """[s]"""
    distance: float
    """[m]"""
    mean_free_speed: float
    """[m/s]"""
    collisions: int
    steering_entropy: float
    """self-baselined, as the thesis has it"""
    steering_entropy_fixed: float
    """against a fixed baseline (of the same driver's unassisted run); NaN without one"""
    reversals: int
    stuck: float
    """share of time in [0, 1]"""
    supervised: float
    """share of ticks at which the supervisor changed the command"""


def driving_metrics(trace: DriveTrace, baseline: float | None = None) -> DrivingMetrics:
    """All driving metrics of a run; `baseline` is the steering entropy's fixed alpha.

    Steering entropy is that of the input as meant (before a disability snaps it to a few orientations): held values
    have no prediction error and hide effort.
    """
    steering = steering_signal(trace.stamp, trace.desired)
    fixed = float("nan") if baseline is None else steering_entropy(steering, baseline)
    return DrivingMetrics(
        completed=trace.completed,
        angular_jerk=angular_jerk(trace.twist[:, 1], trace.period),
        time=float(trace.stamp[-1] - trace.stamp[0]),
        distance=distance(trace.pose),
        mean_free_speed=mean_free_speed(trace),
        collisions=int(trace.collision.sum()),
        steering_entropy=steering_entropy(steering),
        steering_entropy_fixed=fixed,
        reversals=reversals(trace),
        stuck=stuck_time(trace),
        supervised=float(trace.supervised.mean()),
    )


@dataclass(frozen=True)
class PlanUse:
    """What became of one plan."""

    length: float
    """[m] of the path"""
    compliant_length: float
    """[m] from the path's start up to its last compliant control point, at most `length`"""
    followed: Array
    """(N,) [m] deviation of the way driven from each path point that the chair passed while it complied"""
    ahead: Array
    """(M,) [m] the same for the compliant path points beyond those: planned, agreed to, perhaps never reached"""


def _tracked_ticks(trace: DriveTrace, number: int) -> NDArray[np.intp]:
    """The ticks from a plan's making until the next plan, or until there is no path."""
    until = trace.plans[number + 1].stamp if number + 1 < len(trace.plans) else np.inf
    ticks = np.flatnonzero((trace.stamp >= trace.plans[number].stamp - 1e-9) & (trace.stamp < until - 1e-9))
    ends = np.flatnonzero(np.isnan(trace.compliance[ticks]))
    return ticks[: ends[0]] if len(ends) else ticks


def use_of_plan(trace: DriveTrace, number: int, horizon: float = 5.0) -> PlanUse:
    """How far a plan was agreed to and followed.

    A path point complies if it was the control point, a look-ahead on from the chair, on a tick on which the plan was
    tracked with a compliance of at least .9 (Sec. 3.4.3, 3.5.2). Deviations are from the way driven up to `horizon` [s]
    after the plan.
    """
    plan = trace.plans[number]
    way = arc_length(plan.path)
    ticks = _tracked_ticks(trace, number)
    good = ticks[trace.compliance[ticks] >= COMPLIANT_FROM]
    if not len(good):
        return PlanUse(float(way[-1]), 0.0, np.zeros(0), np.zeros(0))
    position = trace.pose[good[-1], :2]
    passed = float(way[np.argmin(((plan.path - position) ** 2).sum(1))])
    compliant = min(passed + LOOK_AHEAD, float(way[-1]))
    driven = trace.pose[(trace.stamp >= plan.stamp - 1e-9) & (trace.stamp <= plan.stamp + horizon), :2]
    points = plan.path[way <= compliant + 1e-9]
    off = distance_to_polyline(points, driven) if len(driven) > 1 else np.full(len(points), np.nan)
    split = int((way <= passed + 1e-9).sum())
    return PlanUse(float(way[-1]), compliant, off[:split], off[split:])


def lasting_compliance(trace: DriveTrace, plan: Plan, compliance: Compliance, horizon: float = 15.0) -> float:
    """Share of a plan's points that complied at any later time within `horizon` [s], tracked or not (Sec. 3.5.2).

    A path point p is incompliant if the compliance of p' (p seen from the chair) with the input stays below .9 on all
    later ticks on which p' lies within the look-ahead distance, ahead of the axle. The path's first .2 m are left out:
    they never lie ahead.
    """
    ticks = np.flatnonzero((trace.stamp >= plan.stamp - 1e-9) & (trace.stamp <= plan.stamp + horizon))
    points = plan.path[arc_length(plan.path) >= NEAREST]
    pose, stick = trace.pose[ticks], trace.joystick[ticks]
    to = points[:, None] - pose[None, :, :2]  # (N, T, 2)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    ahead, left = c * to[..., 0] + s * to[..., 1], -s * to[..., 0] + c * to[..., 1]
    near = (np.hypot(ahead, left) <= LOOK_AHEAD) & (ahead > 0)
    compliant = np.zeros(len(points), bool)
    for tick in np.flatnonzero(near.any(0)):
        asked = np.flatnonzero(near[:, tick] & ~compliant)
        if len(asked):
            seen = np.stack([ahead[asked, tick], left[asked, tick]], axis=1)
            compliant[asked] = compliance.compliances(seen, stick[tick]) >= COMPLIANT_FROM
    return float(compliant.mean()) if len(points) else float("nan")


@dataclass(frozen=True)
class FrameworkMetrics:
    """One assisted run (Table 3.3)."""

    obedience: float
    """mean over plans of exp(-.003 |alpha|), alpha the angular error [deg] of the plan, goal_errors (Li et al. 2011)"""
    angular_error: float
    """[deg] mean of |alpha|: what lies behind the obedience: exp(-.003 |alpha|) never falls under .583 (ERRATA 23)"""
    path_compliance: float
    """mean over plans of the share of points that complied at any later time (Sec. 3.5.2, lasting_compliance)"""
    tracked_compliance: float
    """mean over plans of the share of length that complied while the plan itself was tracked (use_of_plan)"""
    compliant_length: float
    """[m] mean over plans"""
    path_rmse: float
    """[m] of the compliant path points that the chair passed against the way driven: how well paths are tracked"""
    path_rmse_ahead: float
    """[m] of the compliant points beyond: how well the agreed path predicts the way, replanned or not"""
    replans_per_metre: float
    """[1/m]"""
    plans: int


def _rms(values: Array) -> float:
    good = values[np.isfinite(values)]
    return float(np.sqrt((good**2).mean())) if len(good) else float("nan")


def goal_errors(trace: DriveTrace) -> Array:
    """|alpha| [deg] at the last compliant tick of each plan: between the chair's heading and the bearing of g* there.

    Goals closer than .3 m have no bearing and are left out.
    """
    errors = []
    for number in range(len(trace.plans)):
        ticks = _tracked_ticks(trace, number)
        good = ticks[trace.compliance[ticks] >= COMPLIANT_FROM]
        if not len(good) or not np.isfinite(trace.goal[ticks[0]]).all():
            continue
        x, y, yaw = trace.pose[good[-1]]
        dx, dy = trace.goal[ticks[0]] - (x, y)
        if np.hypot(dx, dy) >= 0.3:
            errors.append(abs(np.degrees(wrap_angle(np.arctan2(dy, dx) - yaw))))
    return np.array(errors)


def framework_metrics(trace: DriveTrace, compliance: Compliance, every: int = 5) -> FrameworkMetrics:
    """Metrics of an assistant's plans in a run; NaN without plans. Path compliance, the slow one, is asked of one plan
    in `every`."""
    uses = [use_of_plan(trace, number) for number in range(len(trace.plans))]
    errors = goal_errors(trace)
    if not uses:
        nan = float("nan")
        return FrameworkMetrics(nan, nan, nan, nan, nan, nan, nan, replans_per_metre=0.0, plans=0)
    return FrameworkMetrics(
        obedience=float(np.exp(-0.003 * errors).mean()) if len(errors) else float("nan"),
        angular_error=float(errors.mean()) if len(errors) else float("nan"),
        path_compliance=float(np.nanmean([lasting_compliance(trace, p, compliance) for p in trace.plans[::every]])),
        tracked_compliance=float(np.mean([use.compliant_length / max(use.length, 1e-9) for use in uses])),
        compliant_length=float(np.mean([use.compliant_length for use in uses])),
        path_rmse=_rms(np.concatenate([use.followed for use in uses])),
        path_rmse_ahead=_rms(np.concatenate([use.ahead for use in uses])),
        replans_per_metre=len(uses) / max(distance(trace.pose), 1e-9),
        plans=len(uses),
    )
