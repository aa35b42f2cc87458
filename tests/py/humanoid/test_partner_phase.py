"""How far a partner has come: where what was seen is likeliest, beside time warping (Sec. 5.3.1)."""

import numpy as np
import pytest

from lfdcore.humanoid.partner_phase import Followed, condition_at, follow, likeliest_share
from lfdcore.primitives import InteractionPrimitive, InteractionPrimitiveConfig

DURATION, PERIOD = 4.0, 0.04
SEEN_UNTIL = (0.3, 0.5, 0.8, 1.0)


def reach(end: float, share: np.ndarray) -> np.ndarray:
    """(T, 2) a hand's way to `end`, and a curve that is the same for all; resting at begin and end."""
    s = np.clip((share - 0.05) / 0.9, 0, 1)
    jerk = s**3 * (10 - 15 * s + 6 * s**2)
    return np.stack([end * jerk, 0.2 * np.sin(np.pi * jerk)], axis=1)


@pytest.fixture(scope="module")
def primitive() -> InteractionPrimitive:
    """Of eight people who reach differently far."""
    even = np.linspace(0, 1, 200)
    motions = [reach(end, even) for end in np.linspace(0.4, 0.6, 8)]
    config = InteractionPrimitiveConfig(observe="positions", noise=1e-4)
    return InteractionPrimitive.fit(motions, [motion[:, :1] for motion in motions], None, config)


def seen(end: float, share: float, tempo: float = 1.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Stamps (T,) and samples (T, 2) of one person up to a share of the motion, tracked with 3 mm of noise."""
    stamp = np.arange(0, share * DURATION / tempo + 1e-9, PERIOD)
    noise = np.random.default_rng(seed).normal(0, 0.003, (len(stamp), 2))
    return stamp, reach(end, stamp * tempo / DURATION) + noise


REFERENCE = reach(0.5, np.linspace(0, 1, 101))


def followed(end: float, share: float, tempo: float = 1.0) -> Followed:
    return follow(REFERENCE, DURATION, *seen(end, share, tempo))


@pytest.mark.parametrize("tempo", [0.5, 0.8, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("share", SEEN_UNTIL)
def test_the_likeliest_share_is_near_the_true_one_at_any_tempo(
    primitive: InteractionPrimitive, share: float, tempo: float
) -> None:
    found = likeliest_share(primitive, followed(0.5, share, tempo), DURATION, None)
    assert found == pytest.approx(share, abs=0.06)


def test_a_person_who_stops_short_has_come_to_the_end_where_time_warping_says_otherwise(
    primitive: InteractionPrimitive,
) -> None:
    one = followed(0.42, 1.0)
    assert one.warped_share < 0.85
    assert likeliest_share(primitive, one, DURATION, None) > 0.93


def test_a_pause_of_3_s_counts_as_less_than_half_a_second(primitive: InteractionPrimitive) -> None:
    stamp, samples = seen(0.5, 0.5)
    wait = np.arange(1, 76) * PERIOD
    rng = np.random.default_rng(1)
    waited = np.concatenate([samples, samples[-1] + rng.normal(0, 0.003, (75, 2))])
    one = follow(REFERENCE, DURATION, np.concatenate([stamp, stamp[-1] + wait]), waited)
    assert one.active[-1] < stamp[-1] + 0.5  # reported within the phase estimator's window
    assert one.active[-1] == pytest.approx((len(one.samples) - 1) * PERIOD)  # the time of the samples that are kept
    assert likeliest_share(primitive, one, DURATION, None) == pytest.approx(0.5, abs=0.5 / DURATION)


def test_time_goes_on_when_a_partner_who_paused_does(primitive: InteractionPrimitive) -> None:
    stamp, samples = seen(0.5, 0.8)
    half = len(stamp) // 2
    waited = np.concatenate([samples[:half], np.repeat(samples[half - 1 : half], 50, axis=0), samples[half:]])
    one = follow(REFERENCE, DURATION, np.arange(len(waited)) * PERIOD, waited)
    assert len(one.samples) < len(waited)
    np.testing.assert_allclose(np.diff(one.active), PERIOD)
    assert likeliest_share(primitive, one, DURATION, None) == pytest.approx(0.8, abs=0.06)


def test_it_is_the_maximum_over_all_shares(primitive: InteractionPrimitive) -> None:
    one = followed(0.45, 0.6)
    found = likeliest_share(primitive, one, DURATION, None)
    scores = {
        share: condition_at(primitive, one, share, None).log_likelihood
        - 0.5 * (np.log(share * DURATION / one.moved) / 0.5) ** 2
        for share in np.linspace(0.005, 1, 200)
    }
    assert found == pytest.approx(max(scores, key=lambda share: scores[share]), abs=0.006)


def test_where_samples_say_nothing_the_tempo_is_the_demonstrations(primitive: InteractionPrimitive) -> None:
    deaf = InteractionPrimitiveConfig(observe="positions", noise=1e6)
    unsure = InteractionPrimitive(primitive.parameters, primitive.starts, None, primitive.partner_dimensions, deaf)
    one = followed(0.5, 0.6)
    assert likeliest_share(unsure, one, DURATION, None) == pytest.approx(one.active[-1] / DURATION, abs=0.01)


def test_time_warping_has_come_to_the_end_with_the_references_last_row() -> None:
    line = np.linspace(0, 1, 11)[:, None]
    assert follow(line, 1.0, np.linspace(0, 1, 11), line).warped_share == 1.0
    assert follow(line, 1.0, np.linspace(0, 1, 11)[:6], line[:6]).warped_share == 0.5


def test_a_partner_who_has_not_left_the_start_has_come_nowhere(primitive: InteractionPrimitive) -> None:
    one = followed(0.5, 0.04)
    assert likeliest_share(primitive, one, DURATION, None) == 0.0
    assert len(one.samples) == 1
    assert np.isfinite(condition_at(primitive, one, 0.0, None).mean).all()
