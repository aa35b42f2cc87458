"""lfdcore joystick and lfdcore drive, on the firmware in a simulated chip."""

import json
from pathlib import Path

import pytest

from calling import run
from lfdcore.datasets import open_log
from lfdcore.errors import DeviceError
from lfdcore.simulated.joystick_bench import packaged


@pytest.fixture(autouse=True, scope="module")
def needs_the_simulated_chip() -> None:
    try:
        packaged("joystick.elf")
        packaged("joystick_bench")
    except DeviceError as missing:
        pytest.skip(str(missing))


def test_a_drive_through_the_simulated_chip_moves_the_chair_and_is_recorded(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log_file = tmp_path / "drive.mcap"
    words = ["drive", "--port", "sim", "--seconds", "8", "--record", log_file]
    code, out, err = run(monkeypatch, capsys, *words)
    assert code == 0, err
    assert "driving" in out
    log = open_log(log_file)
    assert len(log.joystick_stamp) > 20
    assert abs(log.twist[:, 0]).max() > 0.05


def test_the_monitor_says_what_the_stick_says(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(
        monkeypatch, capsys, "joystick", "monitor", "sim", "--seconds", "0.5", "--every", "0.5", "--json"
    )
    assert code == 0, err
    said = json.loads(out)
    assert said["faults"] == "none"
    assert abs(said["adc"][0] - 512) <= 1


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["drive", "--port", "/dev/nothing"], "needs --scan and --chair"),
        (["drive", "--port", "sim", "--scan", "scip:/dev/x"], "give no --scan"),
        (["drive", "--port", "sim", "--assistant", "nobody"], "nobody"),
        (["joystick", "monitor", "/dev/nothing"], "/dev/nothing"),
        (["joystick", "calibrate", "sim", "--forward-output", "1,2", "--left-output", "1,2,3"], "3 numbers"),
        (["joystick", "calibrate", "sim", "--forward-output", "1,2,9", "--left-output", "1,2,3"], "9 V"),
    ],
)
def test_what_cannot_be_driven_says_why(
    words: list[str], why: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = run(monkeypatch, capsys, *words)
    assert code in (1, 2)
    assert why in " ".join(err.replace("│", " ").split())
