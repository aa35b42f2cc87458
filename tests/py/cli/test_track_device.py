"""`lfdcore track --full --device`: the model of all samples through torch."""

import json
import sys

import numpy as np
import pytest
import torch

from goal_worlds import GOALS, drive_to, samples_of
from lfdcore.cli.main import main
from lfdcore.estimation import ActionKernel
from lfdcore.wheelchair.goals.model import GoalFilterConfig, GoalModel
from lfdcore.wheelchair.goals.network import GoalNetwork


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """A model of three drives (its network is none) and a drive."""
    folder = tmp_path_factory.mktemp("track")
    samples = samples_of([drive_to(goal, seed=goal, period=0.4) for goal in range(3)])
    kernel = ActionKernel(0.6, [2.0, 2.0, 0.7, 0.7, 0.5, 0.5], [5.0, 6.0], 0.1)
    network = GoalNetwork("embedded", np.zeros(6), np.ones(6), np.zeros((1, 7)), np.zeros((3, 2)))
    model = GoalModel(GOALS, samples, (kernel, kernel), np.arange(20), network, GoalFilterConfig())
    model.save(folder / "goals.safetensors")
    drive_to(1, seed=50, period=0.4).save(folder / "drive.mcap")
    return str(folder / "goals.safetensors"), str(folder / "drive.mcap")


def outcome(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    monkeypatch.setattr(sys, "argv", ["lfdcore", "track", *arguments])
    with pytest.raises(SystemExit) as stopped:
        main()
    return int(stopped.value.code or 0)


def test_torch_follows_a_drive_as_cpp_does(
    files: tuple[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = []
    for device in ([], ["--device", "cpu"]):
        assert outcome(monkeypatch, *files, "--full", "--json", *device) == 0
        printed.append(json.loads(capsys.readouterr().out)["beliefs"])
    assert len(printed[0]) == len(printed[1]) > 3
    for one, other in zip(*printed, strict=True):
        assert one["likelihood"] == pytest.approx(other["likelihood"], rel=1e-6)
        assert one["mean"] == pytest.approx(other["mean"], rel=1e-6)


def test_a_device_without_the_model_of_all_samples_is_wrong_use(
    files: tuple[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(monkeypatch, *files, "--device", "cpu") == 2
    assert "--full" in capsys.readouterr().err


@pytest.mark.skipif(torch.cuda.is_available(), reason="torch finds a CUDA device here, so nothing is missing")
def test_without_cuda_one_line_says_so(
    files: tuple[str, str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert outcome(monkeypatch, *files, "--full", "--device", "cuda") == 1
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("lfdcore: device 'cuda' is not there")
