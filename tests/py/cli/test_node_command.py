"""lfdcore node as a user calls it, up to where ROS is asked for: one clear line for what cannot be."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from calling import run
from lfdcore.models import NAIVE, PRIMITIVES

WRONG = [
    (("--axes", "1"), 2, "--axes '1' must be FORWARD,LEFT"),
    (("--axes", "1,1"), 2, "must be two different numbers from 0"),
    (("--axes", "-1,0"), 2, "must be two different numbers from 0"),
    (("--mounting", "1,2"), 2, "--mounting '1,2' must be X,Y,YAW in metres and degrees"),
    (("--mounting", "nan,0,0"), 2, "--mounting 'nan,0,0' must be finite"),
    (("--mounting", "70,0,0"), 1, "T_base_laser is Pose2(70, 0, 0), must be within 10 m"),
    (("--footprint", "1,2,-3"), 2, "--footprint '1,2,-3' must lie in (0, 100] m"),
    (("--limits", "max_linear"), 2, "--limits 'max_linear' must be NAME=VALUE"),
    (("--limits", "speed=1"), 2, "'speed' is unknown or there twice, names are"),
    (("--limits", "__init__=1"), 2, "'__init__' is unknown"),
    (("--limits", "max_linear=1,max_linear=2"), 2, "'max_linear' is unknown or there twice"),
    (("--limits", "max_linear=0"), 1, "max_linear is 0 m/s, must be positive and finite"),
    (("--latency", "3"), 1, "latency is 3.0 s, must lie in [0, 1]"),
    (("--scan-period", "0"), 1, "scan_period is 0.0 s, must be finite and > 0"),
    (("--wait", "0"), 2, "Invalid value for '--wait'"),
    (("--record", "/nowhere/drive.mcap"), 1, "there is no folder /nowhere to write to"),
    (("--no-such-option",), 2, "No such option"),
    (("-p", "use_sim_time:=true"), 2, "No such option"),
]


@pytest.mark.parametrize(("words", "code", "said"), WRONG, ids=[" ".join(words) for words, *_ in WRONG])
def test_what_cannot_be_is_said_in_one_line(
    words: tuple[str, ...], code: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    got, _, err = run(monkeypatch, capsys, "node", "supervisor", *words)
    assert got == code
    assert said in " ".join(err.split())
    assert "Traceback" not in err


def test_a_model_that_is_none_or_drives_nothing_is_refused(monkeypatch, capsys, tmp_path: Path) -> None:
    other = tmp_path / "other.safetensors"
    other.write_text("nothing")
    for model, said in ((tmp_path / "none", "No such file"), (other, str(other)), (NAIVE, "which drives nothing")):
        code, _, err = run(monkeypatch, capsys, "node", model)
        assert code == 1
        assert said in err


def test_the_model_is_not_written_over_by_the_record_of_its_drive(monkeypatch, capsys) -> None:
    code, _, err = run(monkeypatch, capsys, "node", PRIMITIVES, "--record", PRIMITIVES)
    assert code == 2
    assert "--record" in err
    assert PRIMITIVES.stat().st_size > 1000


@pytest.mark.skipif(find_spec("rclpy") is not None, reason="this Python has rclpy")
def test_without_ros_it_says_what_to_source_or_install(monkeypatch, capsys) -> None:
    code, _, err = run(monkeypatch, capsys, "node", "supervisor", "--ros-args", "-p", "use_sim_time:=true")
    assert code == 1
    assert "source /opt/ros/DISTRO/setup.bash" in err
    assert "the extra 'ros2'" in err
    assert len(err.strip().splitlines()) == 1
