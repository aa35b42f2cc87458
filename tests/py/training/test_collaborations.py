"""The noise of a collaboration: chosen by leaving demonstrations out, against a slow loop that does the same."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lfdcore.datasets.interaction import InteractionRecording
from lfdcore.humanoid.collaboration import CollaborationConfig, CollaborationModel
from lfdcore.simulated.passing import Rectangle, demonstrate_passing
from lfdcore.training.collaborations import NoiseChoice, _LeftOut, learn_collaboration, left_out_errors

CONFIG = CollaborationConfig(steps=60)
CHOICE = NoiseChoice(factors=(1.0, 100.0, 1e4), folds=3, shares=(0.1, 0.6))
PASSES = [demonstrate_passing(Rectangle(100 + 30 * (k % 4), 60 + 20 * (k % 3)), [k]) for k in range(7)]


def turning(seed: int, most: float = 0.8) -> InteractionRecording:
    """A hand reaches out; the gripper turns about z by up to `most` half turns, the more the farther it reaches."""
    random = np.random.default_rng(seed)
    reach = random.uniform(0.3, 1.0)
    u = np.linspace(0, 1, 50)
    s = 10 * u**3 - 15 * u**4 + 6 * u**5
    partner = reach * s[:, None] + random.normal(0, 0.003, (50, 1))
    robot = Rotation.from_rotvec(np.outer(most * np.pi * reach * (2 * s - 1), [0, 0, 1])).as_quat()
    names = ("g.qx", "g.qy", "g.qz", "g.qw")
    return InteractionRecording(2 * u, partner, robot, ("hand.x",), names, name=f"turning {seed}")


def slow_errors(demonstrations: list, candidates: list[CollaborationConfig], choice: NoiseChoice) -> list[float]:
    """The docstring of left_out_errors, word by word, for columns that are no orientations."""
    found = []
    for config in candidates:
        folds = []
        for fold in range(choice.folds):
            kept = [one for k, one in enumerate(demonstrations) if k % choice.folds != fold]
            model = CollaborationModel.fit(kept, config)
            squares = []
            for k, one in enumerate(demonstrations):
                if k % choice.folds == fold:
                    truth = one.resample(config.steps).robot
                    for share in choice.shares:
                        said = model.infer(one.partial(share=share), one.environment).robot_motion()
                        squares.append(np.mean([(said[:, c] - truth[:, c]) ** 2 / truth[:, c].var() for c in range(2)]))
            folds.append(np.mean(squares))
        found.append(np.sqrt(np.mean(folds)))
    return found


def test_errors_are_those_of_the_slow_loop() -> None:
    candidates = [dataclasses.replace(CONFIG, noise=noise) for noise in (1.0, 1e3)]
    found = left_out_errors(PASSES, candidates, CHOICE)
    np.testing.assert_allclose(found, slow_errors(PASSES, candidates, CHOICE), rtol=1e-9)


@pytest.mark.parametrize(("observe", "phase"), [("positions", "likeliest"), ("forcing", "warped")])
def test_the_learned_noise_is_the_one_with_the_least_error(observe: str, phase: str) -> None:
    config = dataclasses.replace(CONFIG, observe=observe, phase=phase)
    model, reported = CollaborationModel.fit(PASSES, config), []
    learned = learn_collaboration(PASSES, config, CHOICE, lambda done, total: reported.append((done, total)))
    candidates = [dataclasses.replace(config, noise=f * model.primitive.config.noise) for f in CHOICE.factors]
    errors = left_out_errors(PASSES, candidates, CHOICE)
    assert learned.primitive.config.noise == candidates[int(np.argmin(errors))].noise
    np.testing.assert_array_equal(
        learned.metadata["noise_choice"], [[c.noise, e] for c, e in zip(candidates, errors, strict=True)]
    )
    assert reported == [(k + 1, 9) for k in range(9)]
    again = learn_collaboration(PASSES, config, CHOICE)
    np.testing.assert_array_equal(again.infer().robot_motion(), learned.infer().robot_motion())


def test_a_noise_that_is_given_stays_and_few_demonstrations_keep_the_residual() -> None:
    assert learn_collaboration(PASSES, dataclasses.replace(CONFIG, noise=7.0)).primitive.config.noise == 7.0
    few = learn_collaboration(PASSES[:3], CONFIG)
    assert few.primitive.config.noise == CollaborationModel.fit(PASSES[:3], CONFIG).primitive.config.noise
    assert "noise_choice" not in few.metadata


def test_orientations_beyond_half_a_turn_from_the_reference_can_be_judged() -> None:
    """What is inferred or held out may turn farther from the mean orientation than can be learned: on the real KTH
    handovers that was an error. Here the last demonstration alone turns the other way."""
    names = ("g.qx", "g.qy", "g.qz", "g.qw")
    ways = [1.0, 1.1, 0.9, 1.0, 1.1, 0.9, -4.4]
    demonstrations = []
    for k, way in enumerate(ways):
        u = np.linspace(0, 1, 50)
        robot = Rotation.from_rotvec(np.outer(way * u, [0, 0, 1])).as_quat()
        partner = np.column_stack([u + 0.01 * k])
        demonstrations.append(InteractionRecording(2 * u, partner, robot, ("hand.x",), names, name=f"way {way}"))
    kept = CollaborationModel.fit(demonstrations[:-1], CONFIG)
    with pytest.raises(ValueError, match="turned by"):
        kept.robot.learned(demonstrations[-1].robot)
    candidates = [dataclasses.replace(CONFIG, noise=0.01)]
    choice = NoiseChoice(folds=3, shares=(0.5,))
    with pytest.raises(ValueError, match="turned by"):  # it cannot be learned from
        left_out_errors(demonstrations, candidates, choice)
    last_alone = [demonstrations[k] for k in (6, 0, 1, 2, 3)]
    one = _LeftOut.of(last_alone[0], (0.5,), kept.config)
    assert np.isfinite(one.square_error(kept, one.partials[0]))


@given(st.integers(0, 2**20))
def test_signs_of_quaternions_do_not_change_what_is_chosen(seed: int) -> None:
    demonstrations, random = [turning(k) for k in range(4)], np.random.default_rng(seed)
    flipped = [dataclasses.replace(d, robot=d.robot * random.choice([-1, 1], (50, 1))) for d in demonstrations]
    candidates = [dataclasses.replace(CONFIG, steps=30, noise=0.01)]
    choice = NoiseChoice(folds=2, shares=(0.5,))
    found = [left_out_errors(some, candidates, choice) for some in (demonstrations, flipped)]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6)


def test_folds_without_which_the_environment_does_not_vary_are_passed_over() -> None:
    """Two objects in turn: without every second demonstration there is one object, of which no EaIP can learn."""
    by_turns = [demonstrate_passing(Rectangle(100 + 40 * (k % 2), 60 + 20 * (k % 2)), [k]) for k in range(4)]
    learned = learn_collaboration(by_turns, CONFIG)
    assert "noise_choice" not in learned.metadata
    assert learned.primitive.config.noise == CollaborationModel.fit(by_turns, CONFIG).primitive.config.noise
    odd_one = [demonstrate_passing(Rectangle(100 + 40 * (k == 0), 60 + 20 * (k == 0)), [k]) for k in range(6)]
    chosen = learn_collaboration(odd_one, CONFIG, CHOICE)
    assert np.isfinite(np.array(chosen.metadata["noise_choice"], float)).all()


def test_demonstrations_that_teach_nothing_are_refused_as_by_fit() -> None:
    for bad, said in (([], "2 demonstrations or more"), (PASSES[:1], "2 demonstrations or more")):
        with pytest.raises(ValueError, match=said):
            learn_collaboration(bad)
    same = [dataclasses.replace(one, environment={"width": 1.0}) for one in PASSES]
    with pytest.raises(ValueError, match="must vary"):
        learn_collaboration(same)


@pytest.mark.parametrize(
    "change",
    [{"factors": ()}, {"factors": (0.0,)}, {"factors": (np.nan,)}, {"factors": (np.inf,)}, {"folds": 1}, {"shares": ()},
     {"shares": (1.1,)}, {"shares": (np.nan,)}],
)  # fmt: skip
def test_a_choice_without_sense_is_refused(change: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(change))):
        NoiseChoice(**change)
