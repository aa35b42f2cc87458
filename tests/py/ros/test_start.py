"""What the node refuses to start with, in words that say what to do. Nothing is commanded then."""

import signal
from collections.abc import Iterator

import pytest

from ros_processes import NodeProcess, RobotProcess

MOUNTED = ("--mounting", ".7,0,0")

ROBOT_IS_WRONG = [
    (("--wrong", "scan"), "/scan is of std_msgs/msg/String, must be of sensor_msgs/msg/LaserScan"),
    (("--wrong", "joy"), "/joy is of std_msgs/msg/String, must be of sensor_msgs/msg/Joy"),
    (("--wrong", "rival"), "/robot publishes /cmd_vel too"),
    (("--stamped",), "/cmd_vel is listened to as geometry_msgs/msg/TwistStamped"),
    (("--ahead", "-7200"), "the newest message on /scan is 7200"),
    (("--ahead", "30"), "s in the future"),
    (("--child", ""), "/odom names no child_frame_id: say --base FRAME"),
]
WORDS_ARE_WRONG = [
    (("--scan", "/laser/scan"), "nobody publishes /laser/scan"),
    (("--axes", "1,4"), "/joy has 4 axes, --axes 1,4 counts from 0"),
    (("--ros-args", "-p", "use_sim_time:=true"), "use_sim_time is true, but nothing came on /clock"),
    (("--out", "/nobody"), "nobody listens on /nobody"),
    (("--base", "base_footprint"), "/odom is of base_link, not of --base base_footprint"),
]
UNREADABLE = [
    (("--scan", "no topic"), "no topic"),
    (("--ros-args", "-p", "nonsense"), "nonsense"),
    (("--ros-args", "-p", "use_sim_time:=7"), "use_sim_time"),
    (("--ros-args", "-r", "__ns:=/chair", "--", "more"), "more after --ros-args"),
]


@pytest.fixture(scope="module")
def sound_robot(ros_python: str) -> Iterator[RobotProcess]:
    with RobotProcess(ros_python) as robot:
        yield robot


@pytest.mark.parametrize(("robot_is", "said"), ROBOT_IS_WRONG, ids=[said[:30] for _, said in ROBOT_IS_WRONG])
def test_what_is_wrong_with_the_robot_is_said_and_nothing_is_commanded(
    ros_python: str, robot_is: tuple[str, ...], said: str
) -> None:
    with RobotProcess(ros_python, *robot_is) as robot, NodeProcess(robot, "supervisor", *MOUNTED) as node:
        node.wait_for_line(lambda line: "waiting: " in line and said in line)
        assert not robot.events("command")


@pytest.mark.parametrize(("words", "said"), WORDS_ARE_WRONG, ids=[said[:30] for _, said in WORDS_ARE_WRONG])
def test_words_that_do_not_fit_the_robot_are_said(sound_robot: RobotProcess, words: tuple[str, ...], said: str) -> None:
    with NodeProcess(sound_robot, "supervisor", *MOUNTED, *words) as node:
        node.wait_for_line(lambda line: "waiting: " in line and said in line)
        assert not sound_robot.events("command")


def test_waiting_ends_with_one_line_that_says_all_that_is_missing(sound_robot: RobotProcess) -> None:
    words = (*MOUNTED, "--scan", "/there", "--joy", "/nowhere", "--wait", "2")
    with NodeProcess(sound_robot, "supervisor", *words) as node:
        assert node.ended() == 1
        last = node.text.split("\n")[-1]
        assert last.startswith("lfdcore: after 2 s: nobody publishes /there; ")
        assert "nobody publishes /nowhere" in last


@pytest.mark.parametrize(("words", "said"), UNREADABLE, ids=[said for _, said in UNREADABLE])
def test_words_that_ros_cannot_read_are_said(sound_robot: RobotProcess, words: tuple[str, ...], said: str) -> None:
    with NodeProcess(sound_robot, "supervisor", *MOUNTED, *words) as node:
        assert node.ended() == 1
        assert "Traceback" not in node.text
        assert any(line.startswith("lfdcore: ") and said in line for line in node.text.split("\n"))


def test_a_mounting_is_asked_for_where_tf_cannot_be_read(sound_robot: RobotProcess) -> None:
    with NodeProcess(sound_robot, "supervisor", "--wait", "2") as node:
        assert node.ended() == 1
        assert "say --mounting X,Y,YAW" in node.text.split("\n")[-1]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_who_waits_can_be_ended_and_has_commanded_nothing(sound_robot: RobotProcess, number: signal.Signals) -> None:
    with NodeProcess(sound_robot, "supervisor", *MOUNTED, "--scan", "/there") as node:
        node.wait_for_line(lambda line: "waiting: " in line)
        node.popen.send_signal(number)
        assert node.ended() == 128 + number
        assert "Traceback" not in node.text
        assert not sound_robot.events("command")


def test_a_second_node_is_refused_and_the_first_drives_on(ros_python: str) -> None:
    with RobotProcess(ros_python) as robot, NodeProcess(robot, "supervisor", *MOUNTED) as first:
        first.drives()
        with NodeProcess(robot, "supervisor", *MOUNTED, "--wait", "10") as second:
            assert second.ended() == 1
            assert "publishes /cmd_vel too, but a chair has one master" in second.text.split("\n")[-1]
        robot.wait_for("command", after=robot.tell("joy on"))


def test_topics_can_be_remapped_as_usual(sound_robot: RobotProcess) -> None:
    words = ("supervisor", *MOUNTED, "--scan", "front", "--ros-args", "-r", "front:=/scan", "-r", "__node:=pilot")
    with NodeProcess(sound_robot, *words) as node:
        node.drives()
        assert "[pilot]" in node.text
