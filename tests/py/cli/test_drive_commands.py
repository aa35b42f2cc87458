"""lfdcore joystick and lfdcore drive, on the firmware in a simulated chip."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from calling import run
from lfdcore.cli.ports import simulated_chip
from lfdcore.datasets import open_log
from lfdcore.errors import DeviceError
from lfdcore.geometry import Pose2, Twist2
from lfdcore.hardware import JoystickCalibration
from lfdcore.simulated.bench_world import CALIBRATION, WHEELS, BenchWorld
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import DriverInput
from lfdcore.simulated.joystick_bench import packaged
from lfdcore.wheelchair.counted_way import CountedWay
from lfdcore.wheelchair.linked_chair import LinkedChair


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
    assert said["faults"] == []
    assert abs(said["adc"][0] - 512) <= 1


CALIBRATE = ["joystick", "calibrate", "sim", "--left-output", "1,2,3", "--forward-output", "1,2,3", "--supply", "5"]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["drive", "--port", "/dev/nothing"], "needs --scan and --chair"),
        (["drive", "--port", "sim", "--scan", "scip:/dev/x"], "give no --scan"),
        (["drive", "--port", "sim", "--assistant", "nobody"], "nobody"),
        (["joystick", "monitor", "/dev/nothing"], "/dev/nothing"),
        ([*CALIBRATE, "--forward-output", "1,2"], "3 numbers"),
        ([*CALIBRATE, "--forward-output", "1,2,9"], "9 V"),
        ([*CALIBRATE, "--forward-output", "1,nan,3"], "nan V"),
        ([*CALIBRATE, "--forward-output", "2,1,3"], "the calibration is not sound"),
        ([*CALIBRATE, "--supply", "9"], "must lie in [2.7, 5.5] V"),
        ([*CALIBRATE, "--profiles", "0,50,100,100"], "0 %, must be a whole number from 1 to 100"),
        ([*CALIBRATE, "--profiles", "300,50,100,100"], "300 %"),
    ],
)
def test_what_cannot_be_driven_says_why(
    words: list[str], why: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = run(monkeypatch, capsys, *words)
    assert code in (1, 2)
    assert why in " ".join(err.replace("│", " ").split())


def test_in_a_slower_profile_the_chair_says_what_it_was_commanded() -> None:
    """Limits are those of the profile: its share is no second factor."""
    slow = JoystickCalibration(axes=CALIBRATION.axes, outputs=CALIBRATION.outputs, profiles=[50, 100, 100, 100])
    with simulated_chip() as (bench, link), BenchWorld(bench, home(), StickAhead(), 1) as world:
        link.calibrate(slow)
        chair = LinkedChair(link, CountedWay(WHEELS), world, world.geometry())
        world.ask_neutral(True)
        wait_until(lambda: link.state in {"driving", "ready"})
        world.ask_neutral(False)

        def said() -> float:
            chair.command(Twist2(0.5, 0.0), 0.25)
            command = chair.observe(0.0).command
            return 0.0 if command is None else command.linear

        wait_until(lambda: said() > 0.4)
        assert said() == pytest.approx(0.5, abs=0.01)
        assert bench.outputs().dac[0] == pytest.approx(2048 + 0.25 * 1048, abs=3)


class StickAhead:
    def reset(self, seed: int) -> None:
        pass

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        return DriverInput(np.array([1.0, 0.0]), np.array([1.0, 0.0]))


def wait_until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 10
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)
