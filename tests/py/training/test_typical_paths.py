"""Typical demonstrations: laws of the likelihood ratio, and what it does to compliance as runs are added."""

import numpy as np
import pytest

from lfdcore.training.drive_primitives import LearningConfig, learn_drive
from lfdcore.training.parts.typical_paths import TypicalPathConfig, typical, typical_paths
from lfdcore.wheelchair.primitives.compliance import ComplianceModel
from lfdcore.wheelchair.primitives.local_paths import LocalPaths

HARD_LEFT = np.array([np.cos(np.radians(72.0)), np.sin(np.radians(72.0))])


def unit(degrees):
    radians = np.radians(np.asarray(degrees, dtype=float))
    return np.stack([np.cos(radians), np.sin(radians)], axis=-1)


def demonstrations(count, odd, seed=1):
    """Ways (N, 2) [m] with sticks twice as far to the side, 5 degrees of noise, and as many `odd` pairs: stick hard
    left, way straight on."""
    rng = np.random.default_rng(seed)
    way = rng.choice([-40.0, -20.0, 0.0, 0.0, 0.0, 0.0, 20.0, 40.0], count) + rng.normal(0, 3, count)
    stick = np.clip(2 * way, -80, 80) + rng.normal(0, 5, count)
    return np.vstack([0.8 * unit(way), 0.8 * unit(np.full(odd, 2.5))]), np.vstack(
        [unit(stick), np.tile(HARD_LEFT, (odd, 1))]
    )


def local_paths(ways, sticks):
    n = len(ways)
    paths = [way * np.linspace(0, 1.2, 13)[:, None] for way in ways]
    yaw = np.arctan2(ways[:, 1], ways[:, 0])
    goal = np.array([path[-1] for path in paths])
    return LocalPaths(
        sticks, np.full(n, 2.5), goal, yaw, paths, np.full(n, 1.0), np.full(n, "window"), np.arange(n, dtype=float)
    )


def obvious(ways, sticks, config):
    """The definition, pair by pair."""
    way = np.degrees(np.arctan2(*ways.T[::-1]))
    bin_of = np.floor(np.r_[way, -way] % 360 / 5).astype(int)
    at = np.floor(np.degrees(np.arctan2(*np.vstack([sticks, sticks * [1, -1]]).T[::-1])) % 360).astype(int)
    kept = []
    for i in range(len(ways)):
        near = np.exp(-0.5 * ((unit(at) - unit(at[i])) ** 2).sum(1) / config.sigma**2)
        shares = [near[bin_of == b].sum() / ((bin_of == b).sum() + config.rare) for b in range(72)]
        kept.append(shares[bin_of[i]] >= config.ratio * max(shares))
    return np.array(kept)


def test_a_pair_is_typical_by_the_ratio_of_two_parzen_likelihoods():
    rng = np.random.default_rng(3)
    ways, sticks = unit(rng.uniform(-90, 90, 150)), unit(rng.uniform(-80, 80, 150))
    config = TypicalPathConfig(ratio=0.3, rare=2.0)
    kept = typical(ways, sticks, config)
    assert 0 < kept.sum() < len(kept)
    assert np.array_equal(kept, obvious(ways, sticks, config))


def test_odd_pairs_are_dropped_and_the_others_kept():
    ways, sticks = demonstrations(2000, odd=10)
    kept = typical(ways, sticks)
    assert not kept[-10:].any()
    assert kept[:-10].mean() > 0.95


def test_as_many_more_demonstrations_of_the_same_kind_change_nothing():
    ways, sticks = demonstrations(1500, odd=8)
    config = TypicalPathConfig(rare=0.0)
    many = typical(np.tile(ways, (7, 1)), np.tile(sticks, (7, 1)), config)
    assert np.array_equal(many, np.tile(typical(ways, sticks, config), 7))


def test_how_often_one_goes_straight_on_does_not_matter():
    """Compliance asks how likely the stick is for a way, not how likely the way is."""
    ways, sticks = demonstrations(1500, odd=0)
    corridor = np.tile([[0.8, 0.01]], (30000, 1)), np.tile([[0.5, 0.01]], (30000, 1))
    kept = typical(np.vstack([ways, corridor[0]]), np.vstack([sticks, corridor[1]]))
    turning = np.abs(np.arctan2(*ways.T[::-1])) > np.radians(10)
    assert kept[: len(ways)][turning].mean() > 0.95


def test_left_and_right_count_alike():
    ways, sticks = demonstrations(800, odd=5)
    flip = np.array([1.0, -1.0])
    assert np.array_equal(typical(ways, sticks), typical(ways * flip, sticks * flip))


def test_a_ratio_of_0_keeps_everything_as_printed():
    ways, sticks = demonstrations(300, odd=30)
    assert typical(ways, sticks, TypicalPathConfig(ratio=0.0)).all()
    assert LearningConfig.thesis().typical.ratio == 0


def test_added_odd_runs_make_straight_on_comply_with_hard_left_unless_only_typical_paths_teach():
    """What 72 maze runs do to a one-class network (docs/heatmaps.md)."""
    paths = local_paths(*demonstrations(2000, odd=10))
    straight, turn = 0.8 * unit(2.5), 0.8 * unit(37.5)
    everything, learned = ComplianceModel.fit(paths), ComplianceModel.fit(typical_paths(paths, 0.8))
    assert everything.compliance(straight, HARD_LEFT) > 0.9
    assert learned.compliance(straight, HARD_LEFT) < 0.1
    assert learned.compliance(turn, HARD_LEFT) > 0.9
    assert learned.compliance(straight, unit(0.0)) > 0.9


def test_typical_paths_are_judged_by_where_they_lead_within_the_look_ahead():
    """A path that turns beyond it is straight on; one that ends before it counts by its end."""
    paths = local_paths(*demonstrations(1000, odd=0))
    late = np.array([[0.0, 0.0], [0.4, 0.0], [0.9, 0.0], [0.9, 1.5]])
    short = unit(38.0)[None] * np.linspace(0, 0.7, 8)[:, None]
    extra = local_paths(np.array([[0.8, 0.0], [0.8, 0.0]]), np.tile(HARD_LEFT, (2, 1)))
    extra.paths[:] = [late, short]
    kept = typical_paths(LocalPaths.concatenate([paths, extra]), 0.8)
    assert not any(path is late for path in kept.paths)
    assert any(path is short for path in kept.paths)


def test_only_compliance_learns_from_fewer_paths(corner_logs):
    loose, strict = (learn_drive(corner_logs, LearningConfig(typical=TypicalPathConfig(ratio=r))) for r in (0.0, 0.9))
    assert np.array_equal(loose.intention.bank.centres, strict.intention.bank.centres)
    assert np.array_equal(loose.primitives.shapes, strict.primitives.shapes)
    assert len(strict.compliance.bank.centres) < len(loose.compliance.bank.centres)


def test_no_path_gives_no_path():
    assert not len(typical(np.zeros((0, 2)), np.zeros((0, 2))))


@pytest.mark.parametrize("values", [{"ratio": -0.1}, {"ratio": float("nan")}, {"sigma": 0.0}, {"rare": -1.0}])
def test_a_config_out_of_bounds_is_refused_by_name(values):
    with pytest.raises(ValueError, match=f"{next(iter(values))} is .*, must be between"):
        TypicalPathConfig(**values)


def test_a_stick_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="must be finite"):
        typical(np.array([[1.0, 0.0]]), np.array([[np.nan, 0.0]]))
