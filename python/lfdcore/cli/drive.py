"""lfdcore drive: the joystick's link, a scanner and an assistant, closed to a loop (thesis, App. A.1)."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import require_writable
from lfdcore.cli.live import EveryOption, live_facts, usual_interval
from lfdcore.cli.ports import SIMULATED, require_port

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from lfdcore.hardware import JoystickLink
    from lfdcore.wheelchair.chair_file import ChairFile
    from lfdcore.wheelchair.counted_way import CountedWay
    from lfdcore.wheelchair.drive_loop import Tick
    from lfdcore.wheelchair.linked_chair import LinkedChair
    from lfdcore.wheelchair.scan_sources import ScanSource


def drive(
    port: Annotated[
        str, typer.Option(help="Of the joystick's chip: /dev/ttyACM0, or sim: a simulated chair and chip.")
    ],
    scan: Annotated[
        list[str] | None,
        typer.Option(
            help="scip:/dev/ttyACM1 or scip:192.168.0.10:10940; with several scanners NAME=scip:..., once each, with "
            "the names of --chair. Not with --port sim, which has its own."
        ),
    ] = None,
    chair_file: Annotated[
        Path | None, typer.Option("--chair", help="The chair's .json (docs/on-your-robot.md). Not with --port sim.")
    ] = None,
    assistant: Annotated[
        str, typer.Option(metavar="MODEL", help="A learned model, or supervisor, dwa, none.")
    ] = "supervisor",
    record: Annotated[Path | None, typer.Option(help="Write a drive log (.mcap).")] = None,
    seconds: Annotated[float | None, typer.Option(min=0.1, help="Stop after so long. Default: Ctrl-C.")] = None,
    every: EveryOption = None,
    course: Annotated[str, typer.Option(help="With --port sim: where a simulated driver drives.")] = "home",
    seed: Annotated[int, typer.Option(min=0, max=2**32 - 1, help="With --port sim: of the driver.")] = 1,
) -> None:
    """Drive a chair: the user's stick, an assistant, the chair's controller. Ctrl-C stops it."""
    from lfdcore.datasets.drive_log import DriveLogWriter
    from lfdcore.wheelchair.drive_loop import drive as run
    from lfdcore.wheelchair.manual_override import ManualOverride
    from lfdcore.wheelchair.named_assistant import assistant_maker

    if record is not None:
        require_writable(record, [Path(assistant), *([chair_file] if chair_file else [])], "--record")
    make_assistant = assistant_maker(assistant)
    with ExitStack() as stack:
        chair, link, tell = _connected(stack, port, scan or [], chair_file, course, seed)
        helper = ManualOverride(make_assistant(chair.geometry), lambda: chair.manual)
        log = None
        if record is not None:
            mounting = chair.geometry.T_base_laser
            log = stack.enter_context(DriveLogWriter(record, name=record.stem, T_base_laser=mounting))
        show = stack.enter_context(live_facts())
        run(chair, helper, _Display(show, chair, link, tell, every or usual_interval(1.0), seconds), log=log)


def _connected(
    stack: ExitStack, port: str, scan: Sequence[str], chair_file: Path | None, course: str, seed: int
) -> tuple[LinkedChair, JoystickLink, Callable[[bool], None]]:
    """The chair, its link, and what tells a simulated driver to let the stick go."""
    from lfdcore.hardware import JoystickLink
    from lfdcore.wheelchair.chair_file import read_chair_file
    from lfdcore.wheelchair.counted_way import CountedWay
    from lfdcore.wheelchair.linked_chair import LinkedChair

    if port == SIMULATED:
        if scan or chair_file is not None:
            raise typer.BadParameter("--port sim has a chair and a scanner of its own: give no --scan and no --chair")
        return _simulated(stack, course, seed)
    if not scan or chair_file is None:
        raise typer.BadParameter("a real chair needs --scan and --chair: nothing is assumed of it")
    require_port(port)
    addresses = [text.partition("=")[2] or text for text in scan]
    for address in addresses:
        device = Path(address.removeprefix("scip:"))
        if device.exists() and Path(port).exists() and device.samefile(port):
            raise typer.BadParameter(f"--scan {address} and --port {port} are one device: which of both is it?")
    said = read_chair_file(chair_file)
    way = CountedWay(said.wheels)
    scans = _scans(stack, scan, said, way)
    geometry = said.geometry(scans.T_base_laser, scans.scan_period)
    link = JoystickLink(port)
    stack.callback(link.close)
    return LinkedChair(link, way, scans, geometry), link, lambda asked: None


def _scans(stack: ExitStack, texts: Sequence[str], said: ChairFile, way: CountedWay) -> ScanSource:
    """The LIDARs that --scan names, at the places that the chair's file says; of several, all as one."""
    from lfdcore.wheelchair.scan_sources import Merged, ScipSource

    sources = []
    for name, address in _addresses(texts, list(said.scanners)).items():
        place = said.scanners[name]
        sources.append(ScipSource(address, place.T_base_laser, upside_down=place.upside_down))
        stack.callback(sources[-1].close)
    return sources[0] if len(sources) == 1 else Merged(sources, said.footprint, way.pose_at)


def _addresses(texts: Sequence[str], names: Sequence[str]) -> dict[str, str]:
    """Of each scanner of the chair's file, where it is."""
    addresses: dict[str, str] = {}
    for text in texts:
        name, equals, source = text.partition("=")
        if not equals and len(names) == 1:
            name, source = names[0], text
        if name not in names or name in addresses:
            raise typer.BadParameter(f"--scan {text}: must be NAME=scip:..., once for each of {', '.join(names)}")
        kind, _, addresses[name] = source.partition(":")
        if kind != "scip" or not addresses[name]:
            raise typer.BadParameter(
                f"--scan {text}: must be scip:/dev/ttyACM1 or scip:192.168.0.10:10940; what was recorded elsewhere "
                "does not steer a chair"
            )
    for name in names:
        if name not in addresses:
            raise typer.BadParameter(f"--scan is missing for the scanner {name} of --chair")
    return addresses


def _simulated(stack: ExitStack, course: str, seed: int) -> tuple[LinkedChair, JoystickLink, Callable[[bool], None]]:
    from lfdcore.cli.ports import simulated_chip
    from lfdcore.simulated.bench_world import WHEELS, BenchWorld
    from lfdcore.simulated.courses import course_by_name
    from lfdcore.simulated.drivers import ImpairedDriver, population
    from lfdcore.wheelchair.counted_way import CountedWay
    from lfdcore.wheelchair.linked_chair import LinkedChair

    bench, link = stack.enter_context(simulated_chip())
    where = course_by_name(course, 1)
    driver = ImpairedDriver(where, population(1, seed)[0])
    world = stack.enter_context(BenchWorld(bench, where, driver, seed))
    return LinkedChair(link, CountedWay(WHEELS), world, world.geometry()), link, world.ask_neutral


class _Display:
    """Shows what happens; true of the last tick."""

    def __init__(
        self,
        show: Callable[[Mapping[str, str]], None],
        chair: LinkedChair,
        link: JoystickLink,
        ask_neutral: Callable[[bool], None],
        every: float,
        seconds: float | None,
    ) -> None:
        self._show, self._chair, self._link, self._ask_neutral = show, chair, link, ask_neutral
        self._every, self._seconds = every, seconds
        self._next = 0.0

    def __call__(self, tick: Tick) -> bool:
        from lfdcore.wheelchair.watch import UNTIL_NEUTRAL

        state = self._link.state
        self._ask_neutral(state == "neutral_required" or tick.assistance.mode in UNTIL_NEUTRAL)
        if tick.stamp >= self._next:
            self._next = tick.stamp + self._every
            self._show(_facts(tick, state, self._chair))
        return self._seconds is not None and tick.stamp >= self._seconds


def _facts(tick: Tick, state: str, chair: LinkedChair) -> dict[str, str]:
    seen, answer = tick.observation, tick.assistance
    forward, left = seen.joystick
    return {
        "time": f"{tick.stamp:.1f} s",
        "link": state,
        "why": chair.trouble,
        "mode": answer.mode + (", supervised" if answer.supervised else "") + (", manual" if chair.manual else ""),
        "stick": f"{forward:+.2f} ahead {left:+.2f} left",
        "asked": f"{answer.command.linear:+.2f} m/s {answer.command.angular:+.2f} rad/s",
        "drives": f"{seen.twist.linear:+.2f} m/s {seen.twist.angular:+.2f} rad/s",
    }
