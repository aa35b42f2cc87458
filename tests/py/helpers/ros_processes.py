"""Processes of ROS 2 for tests: a robot, and the node that drives it, which talk over real topics."""

from __future__ import annotations

import itertools
import json
import os
import random
import socket
import subprocess
import sys
import sysconfig
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lfdcore

HERE = Path(__file__).parents[1] / "ros"
PATIENCE = 20.0
"""[s] No part of a test takes longer on any machine that builds this."""

Event = dict[str, Any]


DOMAINS = range(1, 101)
"""Those whose ports are nobody else's, on Linux"""


def reserve_domain() -> tuple[int, socket.socket]:
    """One in which no process of this machine speaks, and what keeps it so until it is closed.

    A domain's first process holds its port 10. Port 0 is for multicast, which nobody uses who speaks to his own machine
    alone: who reserves holds that (DDS-RTPS 9.6.1.1).
    """
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        reserved = _hold(7400 + 250 * domain)
        if reserved is None:
            continue
        first = _hold(7410 + 250 * domain)
        if first is not None:
            first.close()
            return domain, reserved
        reserved.close()
    raise AssertionError("processes of this machine speak in all domains of ROS")


def _hold(port: int) -> socket.socket | None:
    held = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        held.bind(("", port))
    except OSError:
        held.close()
        return None
    return held


def environment(domain: int) -> dict[str, str]:
    """Of ROS processes: on this machine alone, with lfdcore and what it needs from here."""
    paths = [str(Path(lfdcore.__file__).parents[1]), sysconfig.get_path("purelib"), str(HERE.parent / "helpers")]
    return os.environ | {
        "PYTHONPATH": os.pathsep.join(paths),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(domain),
        "COLUMNS": "200",
    }


class Process:
    """A process whose lines of output are kept with the time at which they came; killed at the end of a `with`."""

    def __init__(self, words: list[str], environ: dict[str, str]) -> None:
        self._came = threading.Condition()
        self._lines: list[str] = []
        pipe = subprocess.PIPE
        self.popen = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True, env=environ)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *_: object) -> None:
        self.popen.kill()
        self.popen.wait()
        self._reader.join()
        for end in (self.popen.stdin, self.popen.stdout):
            if end is not None:
                end.close()

    def _read(self) -> None:
        assert self.popen.stdout is not None
        for line in self.popen.stdout:
            with self._came:
                self._lines.append(line.rstrip("\n"))
                self._came.notify_all()

    @property
    def text(self) -> str:
        """All that was printed."""
        with self._came:
            return "\n".join(self._lines)

    def ended(self) -> int:
        """Its exit code, once it has ended."""
        code = self.popen.wait(PATIENCE)
        self._reader.join(PATIENCE)
        return code

    def wait_for_line(self, is_it: Callable[[str], bool], since: int = 0) -> str:
        """The first line from number `since` on of which `is_it` says so."""
        end, seen = time.monotonic() + PATIENCE, since
        with self._came:
            while True:
                for line in self._lines[seen:]:
                    if is_it(line):
                        return line
                seen = max(seen, len(self._lines))
                if not self._came.wait(end - time.monotonic()):
                    raise AssertionError("waited in vain; the last lines:\n" + "\n".join(self._lines[-30:]))


class RobotProcess(Process):
    """simulated_robot.py. Its events are dictionaries, with `at`: time.monotonic() [s], which processes share."""

    def __init__(self, python: str, *options: str) -> None:
        domain, self._reserved = reserve_domain()
        self.python, self.environ = python, environment(domain)
        super().__init__([python, str(HERE / "simulated_robot.py"), *options], self.environ)
        self.wait_for("pose")

    def __exit__(self, *how: object) -> None:
        super().__exit__(*how)
        self._reserved.close()

    def tell(self, line: str) -> float:
        """-> the time at which the robot did as told."""
        since = len(self._lines)
        assert self.popen.stdin is not None
        self.popen.stdin.write(line + "\n")
        self.popen.stdin.flush()
        return float(self.wait_for("told", since=since)["at"])

    def wait_for(
        self, key: str, is_it: Callable[[Any], bool] = lambda _: True, *, after: float = 0, since: int = 0
    ) -> Event:
        """The first event after the time `after` that has `key` with a value of which `is_it` says so."""
        return self.wait_for_any({key: is_it}, after, since)

    def wait_for_any(self, wanted: dict[str, Callable[[Any], bool]], after: float, since: int = 0) -> Event:
        """The first event after the time `after` that has a key of `wanted` with a value of which that says so."""

        def matches(line: str) -> bool:
            event = _event(line)
            return bool(event) and event["at"] > after and any(k in event and wanted[k](event[k]) for k in wanted)

        return _event(self.wait_for_line(matches, since))

    def events(self, key: str, after: float = 0) -> list[Event]:
        """All so far that have `key`."""
        return [event for line in self.text.split("\n") if key in (event := _event(line)) and event["at"] > after]

    def longest_gap(self, after: float) -> float:
        """[s] between two ticks since then: how much this machine delayed the robot itself."""
        ticks = [event["at"] for event in self.events("pose", after)]
        return max((b - a for a, b in itertools.pairwise(ticks)), default=0.0)


class NodeProcess(Process):
    """`lfdcore node` as a user calls it, or another script that drives the robot."""

    def __init__(self, robot: RobotProcess, *words: str, script: str | None = None) -> None:
        program = ["-m", "lfdcore", "node"] if script is None else [str(HERE / script)]
        super().__init__([robot.python, *program, *words], robot.environ)

    def drives(self) -> None:
        """Returns once it does."""
        self.wait_for_line(lambda line: " drives; " in line)


def _event(line: str) -> Event:
    try:
        event = json.loads(line)
    except ValueError:
        return {}
    return event if isinstance(event, dict) else {}


def has_ros(python: str) -> str | None:
    """None, or why ROS processes cannot run there."""
    code = "import rclpy, sensor_msgs.msg, nav_msgs.msg, sys; print(*sys.version_info[:2])"
    if not Path(python).exists():
        return f"{python} is not there"
    said = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    if said.returncode:
        return f"{python} has no rclpy: {said.stderr.strip().splitlines()[-1]}"
    own = f"{sys.version_info[0]} {sys.version_info[1]}"
    return None if said.stdout.strip() == own else f"{python} is Python {said.stdout.strip()}, lfdcore's is {own}"
