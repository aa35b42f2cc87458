"""The figure-8 of App. A.2, driven by the able driver: Table A.1 with our column beside the thesis's two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lfdcore.geometry import MotionLimits, Twist2, approach, integrate
from lfdcore.simulated.courses import Course, figure_eight
from lfdcore.simulated.drivers import AbleConfig, AbleDriver
from lfdcore.study.driving.metrics import angular_jerk, distance, steering_entropy, steering_signal
from lfdcore.wheelchair.observation import PERIOD

FloatArray = npt.NDArray[np.float64]

FIGURE_EIGHT_LIMITS = MotionLimits(max_linear=0.67)
"""Table A.1 implies this top speed: 13 m in 42 s at a mean forward stick of .46."""

TABLE_A1: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "distance": ((13.0, 0.4), (12.7, 0.8)),
    "deviation": ((0.05, 0.01), (0.07, 0.006)),
    "steering_entropy": ((0.56, 0.03), (0.61, 0.04)),
    "angular_jerk": ((0.01, 0.01), (0.02, 0.01)),
    "forward": ((0.46, 0.1), (0.41, 0.1)),
    "time": ((42.0, 8.0), (46.0, 6.0)),
}
"""Table A.1: (mean, sd) in the thesis's simulation and in reality. m, m, -, rad/s^3, -, s."""


@dataclass(frozen=True)
class TableRow:
    """One metric: the thesis's simulated and real (mean, sd), and ours over n seeds."""

    metric: str
    simulated: tuple[float, float]
    real: tuple[float, float]
    ours: tuple[float, float]
    n: int


def drive_figure_eight(
    seed: int, config: AbleConfig | None = None, limits: MotionLimits = FIGURE_EIGHT_LIMITS
) -> dict[str, float]:
    """The metrics of Table A.1 for one lap. The hall is open, so the chair is its motion limits and nothing else.

    Raises RuntimeError if the driver is not done within 200 s.
    """
    course = figure_eight()
    driver = AbleDriver(course, config, limits)
    driver.reset(seed)
    pose, twist = course.start, Twist2()
    rows: list[list[float]] = []
    for tick in range(2000):
        stick = driver.act(tick * PERIOD, pose, twist, False).joystick
        if driver.done:
            return _metrics(course, np.array(rows))
        wanted = Twist2(float(stick[0]) * limits.max_linear, float(stick[1]) * limits.max_angular)
        twist = approach(twist, wanted, limits, PERIOD)
        pose = integrate(pose, twist, PERIOD)
        rows.append([tick * PERIOD, *pose, *twist, *stick])
    raise RuntimeError("the able driver did not finish the figure-8 within 200 s")


def figure_eight_table(n: int = 20, config: AbleConfig | None = None) -> list[TableRow]:
    """Table A.1 with our mean and sd over seeds 0..n-1. Raises ValueError if n < 2."""
    if n < 2:
        raise ValueError(f"n must be at least 2, got {n}")
    laps = [drive_figure_eight(seed, config) for seed in range(n)]
    rows = []
    for metric, (simulated, real) in TABLE_A1.items():
        values = np.array([lap[metric] for lap in laps])
        rows.append(TableRow(metric, simulated, real, (float(values.mean()), float(values.std(ddof=1))), n))
    return rows


def _metrics(course: Course, rows: FloatArray) -> dict[str, float]:
    stamp, pose, omega, stick = rows[:, 0], rows[:, 1:4], rows[:, 5], rows[:, 6:8]
    return {
        "distance": distance(pose),
        "deviation": float(np.mean(np.abs(_off_circles(pose[:, :2])))),
        "steering_entropy": steering_entropy(steering_signal(stamp, stick)),
        "angular_jerk": angular_jerk(omega, PERIOD),
        "forward": float(stick[:, 0].mean()),
        "time": float(stamp[-1]),
    }


def _off_circles(points: FloatArray) -> FloatArray:
    """Distance [m] of points (T, 2) from the nearer of the two circles."""
    away = [np.abs(np.hypot(points[:, 0] - x, points[:, 1] - 4.0) - 1.0) for x in (4.0, 6.0)]
    return np.minimum(*away)


def format_table(rows: list[TableRow]) -> str:
    """The table as text: thesis simulated, thesis real, ours."""
    lines = [f"{'metric':18}{'thesis simulated':>20}{'thesis real':>18}{f'ours (n = {rows[0].n})':>20}"]
    for row in rows:
        cells = [f"{mean:.3g} +- {sd:.2g}" for mean, sd in (row.simulated, row.real, row.ours)]
        lines.append(f"{row.metric:18}{cells[0]:>20}{cells[1]:>18}{cells[2]:>20}")
    return "\n".join(lines)
