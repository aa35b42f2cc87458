"""The likeliest tempo: the evidence against SciPy's Gaussian, small motions that are no early ones, refusals."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lifts import DURATION, PARTNER, lift, lifts
from scipy.stats import multivariate_normal

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel
from lfdcore.humanoid.partner_tempo import PartnerTempo, _partner_motions

CONFIG = CollaborationConfig(steps=80, noise=1e-3)
MODEL = CollaborationModel.fit(lifts(), CONFIG)
TEMPO = PartnerTempo(MODEL)


def test_the_evidence_is_scipys_up_to_a_constant() -> None:
    shares, found, wanted = np.linspace(0, 0.6, 5), [], []
    motions = _partner_motions(MODEL)
    for seed in range(4):
        seen = np.random.default_rng(seed).normal(0.3, 0.2, (5, 2))
        seen[seed, 0] = np.nan
        at = [
            np.array([[np.interp(s, np.linspace(0, 1, 80), m[:, c]) for c in range(2)] for s in shares])
            for m in motions
        ]
        known = np.isfinite(seen.ravel())
        rows = np.array(at).reshape(len(at), -1)[:, known]
        covariance = np.cov(rows.T, bias=True) + 1e-3 * np.eye(known.sum())
        wanted.append(multivariate_normal(rows.mean(axis=0), covariance).logpdf(seen.ravel()[known]))
        found.append(TEMPO._log_evidence(shares, seen))
    np.testing.assert_allclose(np.diff(found), np.diff(wanted), rtol=1e-3)


@settings(deadline=None, max_examples=20)
@given(st.integers(50, 2**20), st.floats(0.6, 1.7), st.floats(0.5, 1.0))
def test_who_moves_less_is_not_taken_for_who_is_early(seed: int, slow: float, share: float) -> None:
    """Where DTW says .6 of a whole motion of low height."""
    one = lift(seed, duration=slow * DURATION)
    assert TEMPO.duration(one.partial(share=share)) == pytest.approx(slow * DURATION, rel=0.3)
    low = lift(seed, duration=DURATION, height=0.5)
    assert TEMPO.duration(low) == pytest.approx(DURATION, rel=0.1)
    assert MODEL.infer(low).share < 0.9


def test_nothing_seen_takes_the_mean_duration_and_long_observations_what_has_passed() -> None:
    one = lift(9)
    unseen = dataclasses.replace(one.partial(share=0.2), partner=np.full((len(one.partial(share=0.2)), 2), np.nan))
    assert TEMPO.duration(unseen) == pytest.approx(DURATION)
    assert TEMPO.duration(one.partial(share=0)) == pytest.approx(DURATION, rel=0.5)
    for seconds in (3.9, 4.1, 100.0):
        stays = InteractionRecording(np.array([0.0, seconds]), one.partner[[0, -1]], np.zeros((2, 0)), PARTNER)
        assert TEMPO.duration(stays) >= seconds * (1 - 1e-9)


def test_other_columns_models_and_spreads_are_refused() -> None:
    with pytest.raises(ValueError, match=r"columns are hand.x, must be hand.x, hand.y"):
        TEMPO.duration(InteractionRecording(np.zeros(1), np.zeros((1, 1)), np.zeros((1, 0)), ("hand.x",)))
    for spread in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="spread"):
            PartnerTempo(MODEL, spread)
    with pytest.raises(ValueError, match="observes forcing, must observe positions"):
        PartnerTempo(CollaborationModel.fit(lifts(), CollaborationConfig(observe="forcing", steps=80)))
