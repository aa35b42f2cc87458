"""lfdcore drive: the joystick's link, a scanner and an assistant, closed to a loop (thesis, App. A.1)."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import require_writable
from lfdcore.cli.ports import SIMULATED

if TYPE_CHECKING:
    from collections.abc import Callable

    from lfdcore.hardware import JoystickLink
    from lfdcore.wheelchair.drive_loop import Tick
    from lfdcore.wheelchair.linked_chair import LinkedChair


def drive(
    port: Annotated[
        str, typer.Option(help="Of the joystick's chip: /dev/ttyACM0, or sim: a simulated chair and chip.")
    ],
    scan: Annotated[
        str | None,
        typer.Option(help="scip:/dev/ttyACM1 or scip:192.168.0.10:10940. Not with --port sim, which has its own."),
    ] = None,
    chair_file: Annotated[
        Path | None, typer.Option("--chair", help="The chair's .json (docs/on-your-robot.md). Not with --port sim.")
    ] = None,
    assistant: Annotated[
        str, typer.Option(metavar="MODEL", help="A learned model, or supervisor, dwa, none.")
    ] = "supervisor",
    record: Annotated[Path | None, typer.Option(help="Write a drive log (.mcap).")] = None,
    seconds: Annotated[float | None, typer.Option(min=0.1, help="Stop after so long. Default: Ctrl-C.")] = None,
    every: Annotated[float, typer.Option(min=0.1, help="Seconds between the lines printed.")] = 1.0,
    course: Annotated[str, typer.Option(help="With --port sim: where a simulated driver drives.")] = "home",
    seed: Annotated[int, typer.Option(min=0, help="With --port sim: of the driver.")] = 1,
) -> None:
    """Drive a chair: the user's stick, an assistant, the chair's controller. Ctrl-C stops it."""
    from lfdcore.datasets.drive_log import DriveLogWriter
    from lfdcore.wheelchair.drive_loop import drive as run
    from lfdcore.wheelchair.manual_override import ManualOverride
    from lfdcore.wheelchair.named_assistant import assistant_maker

    if record is not None:
        require_writable(record, [Path(assistant)], "--record")
    make_assistant = assistant_maker(assistant)
    with ExitStack() as stack:
        chair, link, tell = _connected(stack, port, scan, chair_file, course, seed)
        helper = ManualOverride(make_assistant(chair.geometry), lambda: chair.manual)
        log = None
        if record is not None:
            mounting = chair.geometry.T_base_laser
            log = stack.enter_context(DriveLogWriter(record, name=record.stem, T_base_laser=mounting))
        run(chair, helper, _Lines(chair, link, tell, every, seconds), log=log)


def _connected(
    stack: ExitStack, port: str, scan: str | None, chair_file: Path | None, course: str, seed: int
) -> tuple[LinkedChair, JoystickLink, Callable[[bool], None]]:
    """The chair, its link, and what tells a simulated driver to let the stick go."""
    from lfdcore.hardware import JoystickLink
    from lfdcore.wheelchair.chair_file import read_chair_file
    from lfdcore.wheelchair.linked_chair import LinkedChair
    from lfdcore.wheelchair.scan_sources import scan_source

    if port == SIMULATED:
        if scan is not None or chair_file is not None:
            raise typer.BadParameter("--port sim has a chair and a scanner of its own: give no --scan and no --chair")
        return _simulated(stack, course, seed)
    if scan is None or chair_file is None:
        raise typer.BadParameter("a real chair needs --scan and --chair: nothing is assumed of it")
    said = read_chair_file(chair_file)
    scans = scan_source(scan, T_base_laser=said.T_base_laser)
    stack.callback(scans.close)
    link = JoystickLink(port)
    stack.callback(link.close)
    return LinkedChair(link, said.wheels, scans, said.geometry(scans.scan_period)), link, lambda asked: None


def _simulated(stack: ExitStack, course: str, seed: int) -> tuple[LinkedChair, JoystickLink, Callable[[bool], None]]:
    from lfdcore.cli.ports import simulated_chip
    from lfdcore.simulated.bench_world import WHEELS, BenchWorld
    from lfdcore.simulated.courses import course_by_name
    from lfdcore.simulated.drivers import ImpairedDriver, population
    from lfdcore.wheelchair.linked_chair import LinkedChair

    bench, link = stack.enter_context(simulated_chip())
    where = course_by_name(course, 1)
    driver = ImpairedDriver(where, population(1, seed)[0])
    world = stack.enter_context(BenchWorld(bench, where, driver, seed))
    return LinkedChair(link, WHEELS, world, world.geometry()), link, world.ask_neutral


class _Lines:
    """Says now and then what happens; true of the last tick."""

    def __init__(
        self,
        chair: LinkedChair,
        link: JoystickLink,
        ask_neutral: Callable[[bool], None],
        every: float,
        seconds: float | None,
    ) -> None:
        self._chair, self._link, self._ask_neutral = chair, link, ask_neutral
        self._every, self._seconds = every, seconds
        self._begin = time.monotonic()
        self._next = 0.0

    def __call__(self, tick: Tick) -> bool:
        from lfdcore.wheelchair.watch import UNTIL_NEUTRAL

        state = self._link.state
        self._ask_neutral(state == "neutral_required" or tick.assistance.mode in UNTIL_NEUTRAL)
        if tick.stamp >= self._next:
            self._next = tick.stamp + self._every
            typer.echo(_line(tick, state, self._link.fault or _faults(self._link)))
        return self._seconds is not None and tick.stamp >= self._seconds


def _faults(link: JoystickLink) -> str:
    said = link.read()
    return "" if said is None else ", ".join([*said.faults, *["emergency"] * said.emergency, *["manual"] * said.manual])


def _line(tick: Tick, state: str, trouble: str) -> str:
    seen, answer = tick.observation, tick.assistance
    forward, left = seen.joystick
    return (
        f"{tick.stamp:7.1f} s  {state:16}  {answer.mode:8}  stick {forward:+.2f} {left:+.2f}  "
        f"asked {answer.command.linear:+.2f} m/s {answer.command.angular:+.2f} rad/s  "
        f"drives {seen.twist.linear:+.2f} m/s {seen.twist.angular:+.2f} rad/s"
        f"{'  supervised' if answer.supervised else ''}{'  ' + trouble if trouble else ''}"
    )
