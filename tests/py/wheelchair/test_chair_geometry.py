"""What an assistant must know of its chair: bounds, which chair it may drive, what a log's replay makes of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Footprint, MotionLimits, Pose2, Twist2, approach, integrate
from lfdcore.wheelchair.observation import PERIOD, ChairGeometry
from lfdcore.wheelchair.surroundings import Surroundings, reach_until_standstill
from lfdcore.wheelchair.watch import WatchConfig

CHAIR = ChairGeometry.thesis()


@pytest.mark.parametrize(
    ("field", "values", "bound"),
    [
        ("period", (0.0, -0.1, 10.1, math.nan, math.inf), r"s, must lie in \(0, 10\]"),
        ("latency", (-0.1, 1.01, math.nan), r"s, must lie in \[0, 1\]"),
        ("scan_period", (0.0, math.inf, math.nan), "s, must be finite and > 0"),
        ("range_noise", (0.0, 0.3, math.nan), r"m, must lie in \[0.001, 0.2\]"),
        ("odometry_error", (-0.1, 0.6, math.nan), r", must be a share in \[0, 0.5\]"),
    ],
)
def test_a_chair_that_cannot_be_is_refused_by_name_value_and_bound(
    field: str, values: tuple[float, ...], bound: str
) -> None:
    for value in values:
        with pytest.raises(ValueError, match=f"{field} is {value} ?{bound}"):
            replace(CHAIR, **{field: value})


@pytest.mark.parametrize("period", [0.02, 0.1, 0.25, 1.0])
def test_a_command_may_come_late_by_half_a_period(period: float) -> None:
    assert replace(CHAIR, period=period).jitter == period / 2


@pytest.mark.parametrize("field", ["latency", "scan_period", "range_noise", "odometry_error"])
def test_an_assistant_drives_a_chair_that_is_better_than_it_thinks_and_none_that_is_worse(field: str) -> None:
    worse = replace(CHAIR, **{field: 1.5 * getattr(CHAIR, field)})
    worse.require_fit(CHAIR)
    with pytest.raises(ValueError, match=f"whose {field} is .*, but it is more"):
        CHAIR.require_fit(worse)


@pytest.mark.parametrize(
    "other",
    [
        {"footprint": Footprint(0.9)},
        {"limits": MotionLimits(max_linear=0.9)},
        {"T_base_laser": Pose2(0.1, 0.0, 0.0)},
        {"period": 0.2},
        {"period": 0.05},
    ],
)
def test_an_assistant_drives_only_a_chair_of_the_same_shape_limits_mounting_and_period(other: dict) -> None:
    for mine, its in ((CHAIR, replace(CHAIR, **other)), (replace(CHAIR, **other), CHAIR)):
        with pytest.raises(ValueError, match=f"whose {next(iter(other))} is .*, but it is"):
            mine.require_fit(its)


def log_at(scan: float, odometry: float, joystick: float, scans: int = 50) -> DriveLog:
    """Its streams come so many seconds apart, but for one long gap in each."""

    def stamps(period: float, count: int) -> np.ndarray:
        return period * (np.arange(count) + 20 * (np.arange(count) > count // 2))

    return DriveLog(
        scan_stamp=stamps(scan, scans),
        ranges=np.ones((scans, 3), np.float32),
        odometry_stamp=stamps(odometry, 50),
        pose=np.zeros((50, 3)),
        twist=np.zeros((50, 2)),
        joystick_stamp=stamps(joystick, 50),
        joystick=np.zeros((50, 2)),
    )


def test_in_a_replay_a_tick_is_a_scan_and_nothing_else_of_the_chair_changes() -> None:
    own = replace(CHAIR, latency=0.3, range_noise=0.03)
    replayed = own.replayed(log_at(0.21, 0.02, 0.3))
    assert (replayed.period, replayed.scan_period) == pytest.approx((0.21, 0.21))
    assert replace(replayed, period=own.period, scan_period=own.scan_period) == own
    assert own.replayed(log_at(0.21, 0.02, 0.3, scans=1)).period == PERIOD


def test_in_a_replay_stick_and_odometry_are_missing_after_two_and_a_half_of_their_own_periods() -> None:
    usual = WatchConfig()
    slow, quick = WatchConfig.of(log_at(0.1, 0.3, 0.4)), WatchConfig.of(log_at(0.5, 0.02, 0.02))
    assert (slow.stale_after, slow.silent_after) == pytest.approx((0.75, 1.0))
    assert quick == usual


@pytest.mark.hazard("The chair goes where no beam has seen", "all that it can sweep over until it stands is looked at")
@pytest.mark.parametrize("seed", range(40))
def test_no_part_of_a_chair_gets_farther_than_its_reach_until_it_stands(seed: int) -> None:
    """1.05 times as fast as declared, with 1.2 of the acceleration and .8 of the braking, at full speed from the
    start: what the supervisor's errors allow."""
    random = np.random.default_rng(seed)
    draw = random.uniform
    limits = MotionLimits(max_linear=draw(0.3, 2), max_reverse=draw(0.2, 2), max_angular=draw(0.3, 2))
    body = Footprint(*draw(0.2, 1.0, 3))
    chair = replace(CHAIR, limits=limits, footprint=body, period=draw(0.02, 1.0), latency=draw(0, 1.0))
    worst = MotionLimits(
        max_linear=1.05 * limits.max_linear,
        max_reverse=1.05 * limits.max_reverse,
        max_angular=1.05 * limits.max_angular,
        linear_acceleration=1.2 * limits.linear_acceleration,
        linear_braking=0.8 * limits.linear_braking,
        angular_acceleration=0.8 * limits.angular_acceleration,
    )
    reach, obeys = reach_until_standstill(chair), chair.latency + chair.period + chair.jitter
    corners = np.array([[x, y] for x in (-body.rear, body.front) for y in (-body.half_width, body.half_width)])
    for linear in (worst.max_linear, -worst.max_reverse):
        for angular in (-worst.max_angular, 0.0, 0.3 * worst.max_angular):
            twist = command = Twist2(linear, angular)
            pose, stamp = Pose2(), 0.0
            while stamp < obeys or any(twist):
                twist = approach(twist, command if stamp < obeys else Twist2(), worst, 0.01)
                pose, stamp = integrate(pose, twist, 0.01), stamp + 0.01
                assert farthest_outside(body, pose.transform(corners)) <= reach


def farthest_outside(body: Footprint, points: np.ndarray) -> float:
    """[m] from the outline of the body at the origin to the farthest of points (N, 2) [m]."""
    x, y = points.T
    beyond = np.maximum(np.maximum(x - body.front, -body.rear - x), 0)
    return float(np.hypot(beyond, np.maximum(np.abs(y) - body.half_width, 0)).max())


def test_a_chair_that_needs_a_street_to_stand_is_refused() -> None:
    fast = replace(CHAIR, limits=MotionLimits(max_linear=6.0))
    with pytest.raises(ValueError, match=r"sweeps over 20.3 m until it stands, must be at most 20.0 m"):
        Surroundings(fast)
