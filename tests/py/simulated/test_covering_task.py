"""The covering task: every demonstration covers, in reach, without a collision; what the partner shows is a dial."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import InteractionRecording, environments, load_interaction
from lfdcore.humanoid.covering import CoveringVerdict, covering_verdict
from lfdcore.humanoid.scene import box_of
from lfdcore.simulated.covering import (
    BOUNDING_BOX,
    GROUND_TRUTH,
    RIGHT_GRIPPER,
    CoveredObject,
    CoveringConfig,
    CoveringData,
    CoveringProtocol,
    covering_data,
    demonstrate_covering,
)

Array = np.ndarray
LEFT_SHOULDER, RIGHT_SHOULDER = np.array([0.06, 0.26, 0.13]), np.array([0.06, -0.26, 0.13])
REACH = 1.0
"""[m] from Baxter's shoulder to its gripper, about"""
LOW, TALL = CoveredObject("low", 0.75, 0.34, 0.34), CoveredObject("tall", 1.0, 0.46, 0.38)


def everything(data: CoveringData) -> list[InteractionRecording]:
    held_out = [*data.known.values(), *data.novel.values()]
    return [*data.training, *(one for several in held_out for one in several)]


def judged(one: InteractionRecording) -> CoveringVerdict:
    """By its own gripper and object."""
    return covering_verdict(one.robot, RIGHT_GRIPPER, box_of(one))


@pytest.mark.parametrize("protocol", [GROUND_TRUTH, BOUNDING_BOX], ids=lambda p: p.name)
@pytest.mark.parametrize("seed", [6, 0, 1])
def test_every_demonstration_covers_without_a_collision_and_in_reach(protocol: CoveringProtocol, seed: int) -> None:
    for one in everything(covering_data(protocol, seed)):
        verdict = judged(one)
        assert verdict.success, (one.name, verdict)
        assert 0.04 < verdict.contact.distance < 0.12
        place = one.robot[:, :3]
        assert (place.min(axis=0) > [0.5, -0.1, -0.16]).all()
        assert (place.max(axis=0) < [0.95, 0.7, 0.6]).all()
        assert np.linalg.norm(place - LEFT_SHOULDER, axis=1).max() < 0.85 * REACH
        assert np.linalg.norm(np.diff(place, axis=0), axis=1).max() / 0.03 < 0.4  # [m/s]


def test_the_right_gripper_is_in_reach_and_above_every_object() -> None:
    assert np.linalg.norm(RIGHT_GRIPPER - RIGHT_SHOULDER) < 0.75 * REACH
    for one in (*BOUNDING_BOX.training, *BOUNDING_BOX.novel, *GROUND_TRUTH.novel):
        assert one.box().top < RIGHT_GRIPPER[2] - 0.1


@pytest.mark.parametrize("by", [(0, 0.3, 0), (0, -0.3, 0), (0.3, 0, 0), (-0.3, 0, 0)])
def test_a_box_30_cm_to_the_side_changes_the_verdict(by: tuple[float, float, float]) -> None:
    for one in covering_data(BOUNDING_BOX).training:
        assert not covering_verdict(one.robot, RIGHT_GRIPPER, box_of(one).moved(by)).success, one.name


def test_a_demonstration_for_a_low_object_collides_with_a_tall_one_and_falls_short_of_a_wide_one() -> None:
    low = demonstrate_covering(LOW, 1)
    assert covering_verdict(low.robot, RIGHT_GRIPPER, TALL.box()).collided
    wide = dataclasses.replace(LOW, width=0.7)
    assert not covering_verdict(low.robot, RIGHT_GRIPPER, wide.box()).covered


@pytest.mark.parametrize(
    ("protocol", "training", "novel", "observed"), [(GROUND_TRUTH, 15, 1, 50), (BOUNDING_BOX, 40, 4, 33)]
)
def test_protocols_are_those_of_the_thesis(
    protocol: CoveringProtocol, training: int, novel: int, observed: int
) -> None:
    data = covering_data(protocol, held_out=2)
    assert (len(data.training), len(data.novel)) == (training, novel)
    assert len(data.training[0].partial(seconds=protocol.observed)) == pytest.approx(observed, abs=2)
    names, values = environments(data.training)
    assert names == protocol.environment_names
    assert len(np.unique(values[:, 0])) == len(protocol.training)
    assert max(o.height for o in protocol.novel) > max(o.height for o in protocol.training)
    assert 0.07 < np.mean([1.0 / one.duration for one in data.training]) < 0.13  # 1 s is about 10 %


def test_the_same_seed_gives_the_same_and_no_demonstration_comes_twice() -> None:
    first, again = everything(covering_data(held_out=2)), everything(covering_data(held_out=2))
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a.partner, b.partner)
        np.testing.assert_array_equal(a.robot, b.robot)
    assert len({one.robot.tobytes() for one in first}) == len(first)


def test_orientations_are_unit_quaternions_far_from_half_a_turn() -> None:
    for one in covering_data().training:
        np.testing.assert_allclose(np.linalg.norm(one.robot[:, 3:], axis=1), 1, atol=1e-12)
        assert (one.robot[:, 6] > 0.4).all()


def quiet(informative: float) -> CoveringConfig:
    """A partner without noise, haste or habits of the own."""
    return CoveringConfig(informative, lead=0, start=0, personal=0, noise=0, drift=0, occlusions=0, tempo=0)


def difference(informative: float) -> Array:
    """(T, 6) [m] by which the partner's hands differ between a low and a tall object."""
    low, tall = (demonstrate_covering(o, 3, quiet(informative)).partner for o in (LOW, TALL))
    return np.abs(tall - low)


def test_a_partner_of_informativeness_0_moves_the_same_for_all_objects() -> None:
    assert difference(0.0).max() == 0


@pytest.mark.parametrize("informative", [0.25, 0.5, 1.0])
def test_the_dial_says_how_much_of_the_object_the_partner_shows_and_little_at_the_beginning(informative: float) -> None:
    shown = difference(informative)
    assert shown[:, 2].max() == pytest.approx(0.25 * informative, rel=0.02)  # of the heights
    assert shown[-1, 1] == pytest.approx(0.06 * informative, rel=0.02)  # of the half widths
    assert shown[: len(shown) // 10].max() < 0.2 * shown.max()


def test_the_partners_starts_are_inconsistent_and_gloves_are_lost_now_and_then() -> None:
    data = covering_data()
    starts = np.array([np.nan_to_num(one.partner[0]) for one in data.training])
    assert (starts.std(axis=0) > 0.025).all()
    lost = np.array([np.isnan(one.partner).mean() for one in data.training])
    assert 0.005 < lost.mean() < 0.08
    assert len({len(one) for one in data.training}) > 10


@pytest.mark.parametrize("seed", range(4))
def test_every_recording_and_every_beginning_can_be_resampled(seed: int) -> None:
    busy = CoveringConfig(occlusions=6)
    for k in range(20):
        one = demonstrate_covering(TALL, [seed, k], busy)
        assert np.isfinite(one.resample(500).partner).all()
        for seconds in (0.5, 1.0, 1.5, 5.0):
            assert np.isfinite(one.partial(seconds=seconds).resample(50).partner).all()


def test_partner_and_demonstrator_share_a_style_that_no_environment_holds() -> None:
    one_object = [demonstrate_covering(LOW, [9, k]) for k in range(150)]
    hands = np.array([np.nanmean(one.partner[:10, [2, 5]]) for one in one_object])
    crossing = np.array([one.robot[:, 2].max() for one in one_object])
    assert np.corrcoef(hands, crossing)[0, 1] > 0.35


def test_a_saved_demonstration_still_knows_its_box(tmp_path: Path) -> None:
    one = covering_data(held_out=1).training[7]
    one.save(tmp_path / "one.npz")
    read = load_interaction(tmp_path / "one.npz")
    assert box_of(read) == box_of(one)
    assert judged(read) == judged(one)


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"informative": 1.1}, "informative must be <= 1"),
        ({"informative": -0.1}, "informative must be finite and >= 0, got -0.1"),
        ({"noise": float("nan")}, "noise must be finite and >= 0, got nan"),
        ({"duration": 0.5}, "duration >= 1 s, got 0.35, 0.5 s"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings: dict[str, float], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        CoveringConfig(**settings)


def test_seeds_and_counts_that_cannot_be_are_refused() -> None:
    with pytest.raises(ValueError, match="seed must be >= 0 and held_out >= 1, got 1 and 0"):
        covering_data(seed=1, held_out=0)


def test_gloves_have_the_white_noise_that_is_stated() -> None:
    noisy, exact = (
        demonstrate_covering(GROUND_TRUTH.training[0], 3, CoveringConfig(noise=noise, occlusions=0)).partner
        for noise in (0.006, 0.0)
    )
    noise = noisy - exact
    assert noise.std(axis=0) == pytest.approx(0.006, rel=0.2)
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.15
