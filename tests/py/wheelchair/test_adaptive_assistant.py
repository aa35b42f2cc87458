"""What is known of a driver comes back from its file, whatever the joystick model's processes model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.estimation import Kernel
from lfdcore.wheelchair.adaptive_assistant import AdaptiveAssistant
from lfdcore.wheelchair.heatmaps.joystick import JoystickBins, JoystickModel, JoystickModelConfig, JoystickPrior
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.observation import ChairGeometry

CHAIR = ChairGeometry.thesis()

PRIOR = JoystickPrior(Kernel(0.5, [0.5, 0.5]), 0.05)


@pytest.mark.parametrize("config", [JoystickModelConfig(), JoystickModelConfig(prior="zero", noise="of_samples")])
def test_a_resumed_driver_is_turned_as_before(heatmap_model: Path, tmp_path: Path, config: JoystickModelConfig) -> None:
    angle = np.random.default_rng(1).uniform(-0.4, 0.4, 900)
    raw = 0.8 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    wanted = 0.8 * np.stack([np.cos(angle - 0.3), np.sin(angle - 0.3)], axis=1)
    joystick = JoystickModel(JoystickBins.of_pairs(raw, raw, config), (PRIOR, PRIOR), config)
    model = replace(HeatmapModel.load(heatmap_model), joystick=joystick)
    before, after = AdaptiveAssistant(model, CHAIR), AdaptiveAssistant(model, CHAIR)
    for pair in zip(raw, wanted, strict=True):
        before.adapter.add(*pair)
    before.save_driver(tmp_path / "driver")
    after.resume_driver(tmp_path / "driver")
    assert after.turn == pytest.approx(-0.3, abs=0.02)
    after.forget_driver()
    assert after.turn == 0
