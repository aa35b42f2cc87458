"""lfdcore joystick and lfdcore drive, on the firmware in a simulated chip."""

import io
import json
import re
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
from lfdcore.simulated.joystick_bench import JoystickBench, packaged
from lfdcore.wheelchair.counted_way import CountedWay
from lfdcore.wheelchair.linked_chair import LinkedChair
from scip_device import UTM_30LX, ScipDevice, TcpLink

PAGE = Path(__file__).parents[3] / "docs" / "on-your-robot.md"


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
        ([*CALIBRATE, "--forward-output", "2,1,3"], "neutral must lie between both ends"),
        (["joystick", "monitor", "\udcff"], "not UTF-8"),
        (["joystick", "monitor", "sim", "--every", "inf"], "--every"),
        (["drive", "--port", "sim", "--seed", str(2**64)], "--seed"),
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


PLACES = {
    "go.": (2.5, 2.5),
    "once more": (2.5, 2.5),
    "ahead": (4.0, 2.5),
    "back": (1.0, 2.5),
    "left": (2.5, 4.0),
    "right": (2.5, 1.0),
}


@pytest.mark.parametrize(
    ("places", "why"),
    [
        ({}, "stored"),
        ({"once more": (2.9, 2.5)}, "was it let go?"),
        ({"ahead": (2.5, 4.0), "back": (2.5, 1.0), "left": (4.0, 2.5), "right": (1.0, 2.5)}, "swapped"),
        ({"back": (4.2, 2.5)}, "both on one side"),
        ({"ahead": (4.9, 2.5)}, "a resistor at each end"),
    ],
)
def test_a_calibration_asks_for_each_place_and_refuses_what_no_stick_does(
    places: dict[str, tuple[float, float]],
    why: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with JoystickBench() as bench:

        def move(asked: str) -> str:
            volts = next(volts for place, volts in (PLACES | places).items() if place in asked)
            bench.set_stick(*volts)
            time.sleep(0.1)
            return ""

        monkeypatch.setattr("builtins.input", move)
        monkeypatch.setattr("lfdcore.cli.joystick.SETTLED", 0.2)
        words = ["joystick", "calibrate", bench.port, *CALIBRATE[3:]]
        code, out, err = run(monkeypatch, capsys, *words)
        assert why in out + err
        assert code == (0 if why == "stored" else 1)


def test_a_calibration_without_anybody_to_move_the_stick_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    code, _, err = run(monkeypatch, capsys, *CALIBRATE)
    assert code == 1
    assert "calibrate in a terminal" in err


def test_two_scanners_drive_and_are_recorded_as_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = json.loads(re.findall(r"```json\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)[0])
    told["scanners"]["rear"] = told["scanners"]["front"] | {"x": -0.3, "yaw_degrees": 180}
    chair = tmp_path / "chair.json"
    chair.write_text(json.dumps(told))
    hall = [2500] * UTM_30LX.beams
    with (
        simulated_chip() as (bench, link),
        ScipDevice(TcpLink(), lambda _: hall) as front,
        ScipDevice(TcpLink(), lambda _: hall) as rear,
    ):
        link.close()
        bench.set_wheels(600, 600)
        scans = ["--scan", f"front=scip:{front.address}", "--scan", f"rear=scip:{rear.address}"]
        words = ["drive", "--port", bench.port, *scans, "--chair", chair, "--seconds", "1.5"]
        code, _, err = run(monkeypatch, capsys, *words, "--record", tmp_path / "drive.mcap")
        assert code == 0, err
        log = open_log(tmp_path / "drive.mcap")
        assert log.ranges.shape[1] == 720
        assert len(log.scan_stamp) > 5
        code, _, err = run(monkeypatch, capsys, *words[:3], *scans[:2], *words[-4:])
        assert code == 2
        assert "--scan is missing for the scanner rear" in " ".join(err.replace("│", " ").split())
        code, _, err = run(monkeypatch, capsys, *words, "--record", chair)
        assert code == 2
        assert "is read, so nothing is written there" in " ".join(err.replace("│", " ").split())


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
