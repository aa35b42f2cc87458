"""Which settings logs are learned with, and which pairs say what a driver means by the stick."""

import dataclasses

import numpy as np
import pytest

from heatmap_drives import corridor_log
from lfdcore.datasets import followed_pairs, full_deflection, joystick_pairs
from lfdcore.datasets.safe_joystick import limits_note
from lfdcore.geometry import MotionLimits
from lfdcore.training.drive_heatmaps import HeatmapLearningConfig, learn_joystick
from lfdcore.training.parts.gp_hyperparameters import fit_joystick_model

LIMITS = MotionLimits(max_linear=2.0, max_reverse=0.5, max_angular=1.5)


@pytest.fixture(scope="module")
def driven():
    return corridor_log([(2.0, 1.0, 0.4), (2.0, 1.0, -0.4), (1.0, 0.6, 0.0)])


@pytest.fixture(scope="module")
def commanded(driven):
    """The same drive with commands and a note of what full stick means"""
    command = np.tile([1.0, 0.3], (len(driven.scan_stamp), 1))
    return dataclasses.replace(
        driven, command_stamp=driven.scan_stamp, command=command, metadata=driven.metadata | limits_note(LIMITS)
    )


def meant(model):
    return model.predict_many(np.array([[1.0, 0.0], [0.8, 0.4], [0.3, -0.3]]))


def test_logs_that_all_name_a_place_share_their_paths_and_one_that_does_not_ends_that(driven) -> None:
    placed, config = dataclasses.replace(driven, metadata={"place": "L"}), HeatmapLearningConfig()
    assert config.for_logs([placed, placed]) == config
    own = config.for_logs([placed, driven])
    assert (own.targets.paths, own.targets.spacing) == ("own", 0.05)
    assert (own.network.epochs, own.network.weight_decay, own.network.width) == (12, 1e-2, 24)
    assert own.joystick == config.joystick
    thesis = HeatmapLearningConfig.thesis().for_logs([driven])
    assert thesis.targets == own.targets
    assert thesis.joystick.prior == "zero"


def test_memory_is_bounded_on_the_longest_drives(driven) -> None:
    far = dataclasses.replace(driven, pose=driven.pose * [1e3, 1e3, 1], metadata={})
    assert HeatmapLearningConfig().for_logs([far]).targets.spacing == pytest.approx(5 * 1e3 / 20_000, rel=0.1)
    beyond = dataclasses.replace(driven, pose=driven.pose * [1e6, 1e6, 1], metadata={})
    assert HeatmapLearningConfig().for_logs([beyond]).targets.spacing == 2.5


def test_a_stick_at_rest_throughout_teaches_nothing_and_says_so(driven, commanded) -> None:
    for log in (driven, commanded):
        still = dataclasses.replace(log, joystick=log.joystick * 0)
        with pytest.raises(ValueError, match=r"joystick is at rest in all \d+ pairs"):
            learn_joystick([still], HeatmapLearningConfig())
        learn_joystick([still, log], HeatmapLearningConfig())


def test_a_log_with_commands_and_a_note_teaches_by_the_safe_stick(commanded) -> None:
    pairs = joystick_pairs(commanded)
    np.testing.assert_array_equal(
        meant(learn_joystick([commanded], HeatmapLearningConfig())),
        meant(fit_joystick_model(pairs.raw, pairs.safe, search=HeatmapLearningConfig().hyper_parameters)),
    )


@pytest.mark.parametrize("lacking", ["commands", "note"])
def test_a_log_without_commands_or_note_teaches_by_the_followed_stick(driven, commanded, lacking) -> None:
    log = driven if lacking == "commands" else dataclasses.replace(commanded, metadata={})
    pairs = followed_pairs(log, full_deflection(log))
    np.testing.assert_array_equal(
        meant(learn_joystick([log], HeatmapLearningConfig())),
        meant(fit_joystick_model(pairs.raw, pairs.safe, search=HeatmapLearningConfig().hyper_parameters)),
    )


def test_full_deflection_is_what_the_log_notes(driven, commanded) -> None:
    assert [*full_deflection(commanded)] == [2.0, 1.5]
    assert [*full_deflection(driven)] != [2.0, 1.5]
