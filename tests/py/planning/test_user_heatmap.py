"""The user heatmap: template against exact arcs, moments against Monte Carlo, claims of ERRATA 25-29."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import norm

from lfdcore.geometry import MotionLimits, Pose2, integrate
from lfdcore.planning import (
    MovementTemplate,
    OrientationMoments,
    arc_orientation,
    compliance,
    joystick_orientation,
    user_heatmap,
)
from lfdcore.simulation import joystick_to_twist

CENTRES = (np.arange(100) + 0.5) * 0.05 - 2.5
X, Y = np.meshgrid(CENTRES, CENTRES)
CHAIRS = [
    MotionLimits(),
    MotionLimits(max_linear=0.67, max_reverse=0.3, max_angular=1.4),
    MotionLimits(max_linear=2.0, max_reverse=2.0, max_angular=0.1),
]
TEMPLATE = MovementTemplate()


def wrapped(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.angle(np.exp(1j * angles))


def exact_orientation(limits: MotionLimits) -> NDArray[np.float64]:
    """ERRATA 28 ahead, the same arcs driven backwards behind."""
    left = 2 * Y / (X**2 + Y**2) / limits.max_angular
    return np.where(X > 0, np.arctan2(left * limits.max_linear, 1), np.arctan2(-left * limits.max_reverse, -1))


def exact_length() -> NDArray[np.float64]:
    radius = (X**2 + Y**2) / (2 * np.abs(Y))
    return 2 * np.arctan2(np.abs(Y), np.abs(X)) * radius


@settings(max_examples=200, deadline=None)
@given(
    orientation=st.floats(-math.pi, math.pi),
    size=st.floats(0.05, 1),
    turned=st.floats(0.01, 0.99),
    chair=st.integers(0, 2),
)
def test_the_orientation_of_a_point_is_the_stick_that_drives_there(
    orientation: float, size: float, turned: float, chair: int
) -> None:
    limits = CHAIRS[chair]
    twist = joystick_to_twist(size * math.cos(orientation), size * math.sin(orientation), limits)
    seconds = min(turned * math.pi / max(abs(twist.angular), 1e-9), 3 / max(abs(twist.linear), 1e-9))
    pose = integrate(Pose2(), twist, seconds)
    if math.hypot(pose.x, pose.y) < 1e-6:
        return
    error = wrapped(np.array(arc_orientation((pose.x, pose.y), limits) - orientation))
    assert abs(error) < 1e-5


@pytest.mark.parametrize("limits", CHAIRS)
def test_the_template_is_the_exact_formula_at_the_cells_centres(limits: MotionLimits) -> None:
    """ERRATA 28: brute force agrees to .0005 rad (median). Cells that span a wide angle, near the axle, differ."""
    movement = MovementTemplate(limits)
    error = np.abs(wrapped(movement.orientation - exact_orientation(limits)))
    assert np.median(error) < 0.0005
    assert error[np.hypot(X, Y) > 0.5].max() < 0.01 * max(1, limits.max_linear / limits.max_angular)
    far = np.abs(movement.distance_filter * exact_length().max() - exact_length())
    assert far.max() < 0.02


@pytest.mark.parametrize(
    "limits", [*CHAIRS, MotionLimits(max_linear=1e-3), MotionLimits(max_linear=20, max_angular=1e-3)]
)
def test_the_template_covers_the_whole_window(limits: MotionLimits) -> None:
    movement = MovementTemplate(limits)
    assert np.isfinite(movement.orientation).all()
    assert (np.abs(movement.orientation) <= np.float32(np.pi)).all()
    assert (movement.distance_filter > 0).all()
    assert movement.distance_filter.max() == 1
    backwards = np.cos(movement.orientation[:, :50])
    assert (backwards <= 1e-3).all()
    assert (np.cos(movement.orientation[:, 50:]) >= -1e-3).all()


def test_the_distance_filter_is_a_fifth_at_a_look_ahead() -> None:
    """ERRATA 29: .19 at 0.8 m, which is why compliance goes without it."""
    assert TEMPLATE.distance_filter[50, 65] == pytest.approx(0.2, abs=0.01)


def test_moments_agree_with_monte_carlo_where_first_order_does() -> None:
    """ERRATA 25: arctan2(mu_i, mu_j), mu_i^2 + mu_j^2."""
    rng = np.random.default_rng(1)
    for forward, left in [(0.8, 0.3), (-0.2, 0.9), (-0.9, -0.1)]:
        found = joystick_orientation((forward, left), (0.01, 0.03))
        assert found is not None
        draws = rng.normal((forward, left), np.sqrt([0.01, 0.03]), (200_000, 2))
        turned = wrapped(np.arctan2(draws[:, 1], draws[:, 0]) - found.mean)
        assert found.mean == pytest.approx(math.atan2(left, forward))
        assert turned.mean() == pytest.approx(0, abs=0.03)
        assert found.variance == pytest.approx(turned.var(), rel=0.12)


@settings(max_examples=100, deadline=None)
@given(
    forward=st.floats(-1.5, 1.5),
    left=st.floats(-1.5, 1.5),
    forward_variance=st.floats(0, 10),
    left_variance=st.floats(0, 10),
)
def test_the_orientations_sd_stays_within_its_bounds(
    forward: float, left: float, forward_variance: float, left_variance: float
) -> None:
    found = joystick_orientation((forward, left), (forward_variance, left_variance))
    if math.hypot(forward, left) < 1e-6:
        assert found is None
        return
    assert found is not None
    r2 = forward**2 + left**2
    printed = left_variance * (forward / r2) ** 2 + forward_variance * (left / r2) ** 2
    assert found.variance == pytest.approx(np.clip(printed, 0.05**2, math.pi**2 / 3), rel=1e-9)
    assert -math.pi < found.mean <= math.pi


def test_a_stick_at_rest_has_no_orientation() -> None:
    assert joystick_orientation((0.0, 0.0), (0.1, 0.1)) is None
    assert joystick_orientation((1e-300, -1e-300), (0.1, 0.1)) is None


@pytest.mark.parametrize("mean", [0.0, 0.7, -2.0, 3.0, math.pi, 40.0])
@pytest.mark.parametrize("variance", [0.0025, 0.1, math.pi**2 / 3])
def test_the_density_is_eq_4_3_with_wrapped_differences(mean: float, variance: float) -> None:
    """ERRATA 27; F12: the heatmap is divided by its maximum."""
    found = user_heatmap(TEMPLATE, OrientationMoments(mean, variance))
    wanted = norm.pdf(wrapped(mean - TEMPLATE.orientation.astype(float)), scale=math.sqrt(variance))
    np.testing.assert_allclose(found.density, wanted, rtol=3e-4, atol=1e-6)
    filtered = wanted * TEMPLATE.distance_filter
    np.testing.assert_allclose(found.heatmap, filtered / filtered.max(), rtol=3e-4, atol=1e-6)
    assert found.heatmap.max() == 1
    assert found.heatmap.dtype == np.float32


def test_a_stick_back_and_slightly_left_is_near_one_back_and_slightly_right() -> None:
    """ERRATA 27: mu_h = 3, h_t = -3, sd .3: 2e-87 without wrapping, .852 with."""
    rear = np.unravel_index(np.abs(TEMPLATE.orientation + 3).argmin(), (100, 100))
    at = float(TEMPLATE.orientation[rear])
    density = user_heatmap(TEMPLATE, OrientationMoments(3, 0.09)).density[rear]
    assert density == pytest.approx(norm.pdf(3 - at - 2 * math.pi, scale=0.3), rel=1e-3)
    assert density > 0.8


@settings(max_examples=20, deadline=None)
@given(mean=st.floats(-3, 3), sd=st.floats(0.1, 1.8))
def test_a_mirrored_stick_gives_a_mirrored_heatmap(mean: float, sd: float) -> None:
    one = user_heatmap(TEMPLATE, OrientationMoments(mean, sd * sd)).heatmap
    other = user_heatmap(TEMPLATE, OrientationMoments(-mean, sd * sd)).heatmap
    np.testing.assert_allclose(np.flipud(other), one, atol=0.02)


def test_the_most_likely_cells_lie_where_the_stick_leads() -> None:
    for forward, left in [(1.0, 0.0), (0.9, 0.3), (0.5, -0.5), (-1.0, 0.2)]:
        orientation = joystick_orientation((forward, left), (0.002, 0.002))
        assert orientation is not None
        iy, ix = np.unravel_index(user_heatmap(TEMPLATE, orientation).heatmap.argmax(), (100, 100))
        error = arc_orientation((CENTRES[ix], CENTRES[iy])) - math.atan2(left, forward)
        assert abs(wrapped(np.array(error))) < 0.1


def test_an_uncertain_stick_gives_a_flatter_heatmap() -> None:
    spreads = [user_heatmap(TEMPLATE, OrientationMoments(0.2, sd**2)).heatmap.mean() for sd in (0.05, 0.2, 0.6, 1.8)]
    assert spreads == sorted(spreads)


def test_compliance_exceeds_the_threshold_within_46_hundredths_of_the_sd() -> None:
    """ERRATA 29."""
    for point in [(0.8, 0.0), (0.7, 0.4), (0.1, -0.8), (-0.6, 0.3)]:
        at = arc_orientation(point)
        for sd in (0.1, 0.5):
            assert compliance(point, OrientationMoments(at, sd**2)) == 1
            assert compliance(point, OrientationMoments(at + 0.45 * sd, sd**2)) > 0.9
            assert compliance(point, OrientationMoments(at - 0.47 * sd, sd**2)) < 0.9


def test_compliance_is_the_density_at_the_cell_relative_to_its_peak() -> None:
    orientation = OrientationMoments(0.3, 0.2)
    density = user_heatmap(TEMPLATE, orientation).density * math.sqrt(2 * math.pi * 0.2)
    for ix, iy in [(66, 50), (60, 60), (20, 30), (90, 12)]:
        assert compliance((CENTRES[ix], CENTRES[iy]), orientation) == pytest.approx(density[iy, ix], abs=0.01)


def test_compliance_takes_the_chairs_limits() -> None:
    slow = MotionLimits(max_linear=0.5)
    point = (0.6, 0.5)
    assert compliance(point, OrientationMoments(arc_orientation(point, slow), 0.01), slow) == 1
    assert compliance(point, OrientationMoments(arc_orientation(point, slow), 0.01)) < 0.5


def test_every_stick_complies_at_the_origin() -> None:
    assert compliance((0.0, 0.0), OrientationMoments(2.0, 0.01)) == 1


def test_values_that_mean_nothing_are_refused() -> None:
    nan = math.nan
    with pytest.raises(ValueError, match=r"left variance is -0\.1.* of full stick squared"):
        joystick_orientation((1, 0), (0.1, -0.1))
    with pytest.raises(ValueError, match="forward mean is nan"):
        joystick_orientation((nan, 0), (0.1, 0.1))
    with pytest.raises(ValueError, match="forward variance is inf"):
        joystick_orientation((1, 0), (math.inf, 0.1))
    for variance in (0.0, -1.0, nan, math.inf, 1e-7, 1e7):
        with pytest.raises(ValueError, match="orientation variance"):
            user_heatmap(TEMPLATE, OrientationMoments(0, variance))
        with pytest.raises(ValueError, match="orientation variance"):
            compliance((1, 0), OrientationMoments(0, variance))
    with pytest.raises(ValueError, match="orientation mean is nan"):
        user_heatmap(TEMPLATE, OrientationMoments(nan, 1))
    with pytest.raises(ValueError, match="point y is inf m"):
        compliance((1, math.inf), OrientationMoments(0, 1))
    with pytest.raises(ValueError, match="origin"):
        arc_orientation((0, 0))
    with pytest.raises(ValueError, match="max_linear"):
        MovementTemplate(MotionLimits(max_linear=0))


def test_huge_values_are_answered() -> None:
    far = joystick_orientation((1e200, 1e200), (0.1, 0.1))
    assert far is not None
    assert far.mean == pytest.approx(math.pi / 4)
    wide = joystick_orientation((0.1, 0.1), (1e200, 1e200))
    assert wide is not None
    assert wide.variance == pytest.approx(math.pi**2 / 3)
    assert math.isfinite(compliance((1e200, 1e200), OrientationMoments(0, 1)))
    assert user_heatmap(TEMPLATE, OrientationMoments(0, 1e6)).heatmap.max() == 1


def test_template_and_moments_survive_pickling() -> None:
    movement = pickle.loads(pickle.dumps(MovementTemplate(CHAIRS[1])))
    np.testing.assert_array_equal(movement.orientation, MovementTemplate(CHAIRS[1]).orientation)
    assert movement.limits.max_reverse == CHAIRS[1].max_reverse
    moments = pickle.loads(pickle.dumps(OrientationMoments(0.5, 0.25)))
    assert (moments.mean, moments.variance) == (0.5, 0.25)
