"""`lfdcore node` drives a robot over real topics: two processes, each with its own middleware.

These tests wait for events, not for times. Bounds in time are those that are promised, plus what this machine was late
itself and time to spare for the delivery.
"""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from lfdcore import models
from lfdcore.datasets import open_log
from lfdcore.wheelchair.watch import HALTS, UNTIL_NEUTRAL
from ros_processes import NodeProcess, RobotProcess

MOUNTED = ("--mounting", ".7,0,0")
PERIOD = 0.1
SPARE = 0.25
"""[s] on top of the machine's own delay: two processes share its cores with other tests."""


def is_zero(command: list[float]) -> bool:
    return command == [0.0, 0.0]


def moves(command: list[float]) -> bool:
    return not is_zero(command)


def seconds_to_zero(robot: RobotProcess, since: float) -> float:
    """How long after `since` the last command that moves came, once 0 has come ten times in a row."""
    at = since
    for _ in range(10):
        at = robot.wait_for("command", after=at)["at"]
    moving = [event["at"] for event in robot.events("command", since) if moves(event["command"])]
    last = max(moving, default=since)
    zero = robot.wait_for("command", is_zero, after=last)["at"]
    return zero - since


class Pair:
    """A robot and a node that drives it."""

    def __init__(self, robot: RobotProcess, node: NodeProcess) -> None:
        self.robot, self.node = robot, node

    def neutral(self) -> None:
        """Both stream on and the stick is at neutral, until the node says that it is not stopped."""
        for sense in ("scan", "odom", "joy"):
            self.robot.tell(f"{sense} on")
        at = self.robot.tell("stick 0 0")
        self.robot.wait_for("state", lambda mode: mode in ("user", "rest"), after=at)

    def turn(self) -> float:
        """-> a time at which it turns on the spot."""
        while True:
            self.neutral()
            begun = self.goes_on(self.robot.tell("stick 0 .4"))
            if begun is not None:
                return begun

    def drive_until(self, stick: str, done: Callable[[], bool]) -> None:
        """Holds the stick until `done` says so; where the machine was so late that the stick counts as silent, anew."""
        self.neutral()
        self.robot.tell(f"stick {stick}")
        while not done():
            self.robot.wait_for("pose", after=self.robot.events("pose")[-1]["at"])
            if self.robot.events("state")[-1]["state"] in UNTIL_NEUTRAL:
                self.neutral()
                self.robot.tell(f"stick {stick}")

    def turn_until_said(self, line: str) -> None:
        """Turns until the node prints `line`."""
        self.drive_until("0 .4", lambda: line in self.node.text.split("\n"))

    def pose(self) -> np.ndarray:
        """x, y [m], yaw [rad] in the map, now"""
        return np.array(self.robot.events("pose")[-1]["pose"])

    def goes_on(self, since: float) -> float | None:
        """When it moves, or None where only a stick at neutral helps: on a loaded machine the stick may be late too."""
        came = self.robot.wait_for_any({"command": moves, "state": lambda mode: mode in UNTIL_NEUTRAL}, since)
        return float(came["at"]) if "command" in came else None


@pytest.fixture(scope="module")
def pair(ros_python: str) -> Iterator[Pair]:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "supervisor", *MOUNTED) as node:
        node.drives()
        yield Pair(robot, node)


def test_the_robot_moves_as_the_stick_asks(pair: Pair) -> None:
    pair.neutral()
    begin = pair.pose()
    ahead = [np.cos(begin[2]), np.sin(begin[2])]
    pair.drive_until(".4 0", lambda: (pair.pose() - begin)[:2] @ ahead > 0.6)
    assert max(event["command"][0] for event in pair.robot.events("command")) == pytest.approx(0.4, abs=0.05)
    pair.drive_until("0 .4", lambda: pair.pose()[2] - begin[2] > 0.5)
    assert not any(event["contact"] for event in pair.robot.events("pose"))


@pytest.mark.hazard("The stick falls silent", "over ROS: 0 on the topic within 250 ms and a period, until neutral")
def test_a_stick_that_falls_silent_stops_the_robot(pair: Pair) -> None:
    pair.turn()
    silent = pair.robot.tell("joy off")
    took = seconds_to_zero(pair.robot, silent)
    assert took < 0.25 + PERIOD + 2 * pair.robot.longest_gap(silent) + SPARE
    back = pair.robot.tell("joy on")  # still pushed
    assert seconds_to_zero(pair.robot, back) < PERIOD + SPARE + 2 * pair.robot.longest_gap(back)
    assert not any(moves(event["command"]) for event in pair.robot.events("command", back))
    pair.turn()


@pytest.mark.parametrize("sense", ["scan", "odom"])
@pytest.mark.hazard("A scan or odometry is old", "over ROS: 0 on the topic, and on again when it speaks")
def test_a_sensor_that_falls_silent_stops_the_robot_until_it_speaks_again(pair: Pair, sense: str) -> None:
    pair.turn()
    dead = pair.robot.tell(f"{sense} off")
    pair.robot.wait_for("state", lambda mode: mode == "stale", after=dead)
    assert seconds_to_zero(pair.robot, dead) < 0.25 + PERIOD + 2 * pair.robot.longest_gap(dead) + SPARE
    back = pair.robot.tell(f"{sense} on")
    if pair.goes_on(back) is None:
        pair.turn()


BROKEN = [
    ("scan empty", "blind"),
    ("scan nan", "blind"),
    ("scan flat", "blind"),
    ("scan frame", "stale"),
    ("odom nan", "fault"),
    ("odom unturned", "fault"),
    ("odom frame", "stale"),
    ("joy short", "fault"),
]


@pytest.mark.parametrize(("broken", "mode"), BROKEN)
@pytest.mark.hazard(
    "Data that cannot be: NaN, a clock set back, a jump", "over ROS: 0 on the topic, and the node lives on"
)
def test_what_makes_no_sense_stops_the_robot_and_not_the_node(pair: Pair, broken: str, mode: str) -> None:
    pair.turn()
    at = pair.robot.tell(broken)
    pair.robot.wait_for("state", lambda said: said == mode, after=at)
    assert seconds_to_zero(pair.robot, at) < 0.25 + PERIOD + 2 * pair.robot.longest_gap(at) + SPARE
    pair.turn()


@pytest.mark.parametrize(
    ("signals", "code"),
    [([signal.SIGINT, signal.SIGINT], 130), ([signal.SIGTERM], 143), ([signal.SIGHUP], 129)],
    ids=["interrupt twice", "terminate", "hang up"],
)
@pytest.mark.hazard("The program ends", "over ROS: by a signal, the last command is 0")
def test_a_signal_ends_the_node_with_a_zero(ros_python: str, signals: list[signal.Signals], code: int) -> None:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "supervisor", *MOUNTED) as node:
        node.drives()
        Pair(robot, node).turn()
        for one in signals:
            node.popen.send_signal(one)
        assert node.ended() == code, node.text
        robot.tell("joy on")  # its line comes after all commands that came before
        assert is_zero(robot.events("command")[-1]["command"])
        assert "Traceback" not in node.text


def test_a_node_that_is_killed_sends_nothing_more_and_the_robots_own_watchdog_stops_it(ros_python: str) -> None:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "supervisor", *MOUNTED) as node:
        node.drives()
        Pair(robot, node).turn()
        robot.wait_for("command", moves)
        node.popen.kill()
        node.ended()
        last = robot.events("command")[-1]
        standing = [robot.wait_for("pose", after=last["at"] + 2.0)["pose"] for _ in range(2)]
        assert standing[0] == standing[1]
        assert moves(robot.events("command")[-1]["command"])


@pytest.mark.hazard("The program ends", "over ROS: by an exception, the last command is 0")
def test_an_exception_ends_the_node_with_a_zero(ros_python: str) -> None:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "breaks", script="failing_node.py") as node:
        node.drives()
        Pair(robot, node).turn_until_said("breaks")
        assert node.ended() == 1
        assert "RuntimeError: broken on purpose" in node.text
        robot.tell("joy on")
        assert is_zero(robot.events("command")[-1]["command"])


@pytest.mark.hazard("The loop is late", "over ROS: 0 on the topic once the command has held for its time")
def test_a_loop_that_hangs_has_its_command_ended_for_it(ros_python: str) -> None:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "hangs", script="failing_node.py") as node:
        node.drives()
        Pair(robot, node).turn_until_said("hangs")
        last = [event for event in robot.events("command") if moves(event["command"])][-1]["at"]
        zero = robot.wait_for("command", is_zero, after=last)["at"]
        assert zero - last < 1.5 * PERIOD + 2 * robot.longest_gap(last) + SPARE
        node.wait_for_line(lambda line: line == "goes on")
        robot.wait_for("state", lambda mode: mode == "late", after=zero)


def test_path_intention_and_state_are_shown(ros_python: str) -> None:
    model = Path(models.__file__).parent / "primitives.safetensors"
    with RobotProcess(ros_python) as robot, NodeProcess(robot, str(model), *MOUNTED) as node:
        node.drives()
        Pair(robot, node).drive_until(".5 0", lambda: any(event["path"] > 5 for event in robot.events("path")))
        path = robot.wait_for("path", lambda points: points > 5)
        assert path["frame"] == "odom"
        assert path["ends"][1][0] > path["ends"][0][0] + 0.5  # ahead, in odom
        intention = robot.wait_for("intention")
        assert intention["frame"] == "odom"
        assert intention["intention"][0] > 0.5
        at = robot.tell("stick 0 0")
        robot.wait_for("state", lambda mode: mode == "rest", after=at)
        robot.wait_for("path", lambda points: points == 0, after=at)


def test_commands_may_be_stamped_and_the_drive_recorded(ros_python: str, tmp_path: Path) -> None:
    log = tmp_path / "drive.mcap"
    words = ("supervisor", *MOUNTED, "--stamped", "--record", str(log), "--joy", "/joy")
    with RobotProcess(ros_python, "--stamped", "--stamped-stick") as robot, NodeProcess(robot, *words) as node:
        node.drives()
        at = Pair(robot, node).turn()
        robot.wait_for("command", moves, after=at + 1)
        assert robot.events("command")[-1]["frame"] == "base_link"
        node.popen.send_signal(signal.SIGTERM)
        assert node.ended() == 143
        assert is_zero(robot.events("command")[-1]["command"])
    drive = open_log(log)
    assert drive.metadata["assistant"] == "supervisor"
    assert "incomplete" not in drive.metadata
    assert len(drive.scan_stamp) > 10
    assert np.abs(drive.command[:, 1]).max() > 0.1
    assert np.abs(drive.joystick[:, 1]).max() == pytest.approx(0.4)


TIMED = ("--ros-args", "-p", "use_sim_time:=true")


def test_a_drive_by_a_simulators_clock_at_half_speed_is_the_same_drive(ros_python: str) -> None:
    with RobotProcess(ros_python, "--clock") as robot, NodeProcess(robot, "supervisor", *MOUNTED, *TIMED) as node:
        node.drives()
        robot.tell("clock .5")
        pair = Pair(robot, node)
        while True:
            begin = pair.turn()
            robot.wait_for("pose", after=begin + 2.0)
            if not any(event["state"] in HALTS for event in robot.events("state", begin)):
                break  # else this machine was late
        commands = robot.events("command", begin)
        assert np.diff([event["at"] for event in commands]).mean() == pytest.approx(2 * PERIOD, rel=0.15)
        assert all(moves(event["command"]) for event in commands)  # it holds by the simulator's time: no 0 between


@pytest.mark.hazard("A clock stands still", "over ROS, also set back: 0 on the topic, and the node can be ended")
@pytest.mark.parametrize("told", ["clock 0", "back 5"])
def test_time_that_stands_still_or_goes_back_stops_the_robot(ros_python: str, told: str) -> None:
    with RobotProcess(ros_python, "--clock") as robot, NodeProcess(robot, "supervisor", *MOUNTED, *TIMED) as node:
        node.drives()
        pair = Pair(robot, node)
        pair.turn()
        at = robot.tell(told)
        robot.wait_for("state", lambda mode: mode in ("stale", "fault"), after=at)
        zero = robot.wait_for("command", is_zero, after=at)["at"]
        assert zero - at < 1.0 + 2 * robot.longest_gap(at) + SPARE
        robot.tell("clock 1")
        pair.turn()
        at = robot.tell("clock 0")
        robot.wait_for("state", lambda mode: mode == "stale", after=at)
        node.popen.send_signal(signal.SIGTERM)
        assert node.ended() == 143
        robot.tell("joy on")
        assert is_zero(robot.events("command")[-1]["command"])
