"""lfdcore joystick: what a chair's joystick says, and what its voltages mean (thesis, App. A.1)."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import JsonOption, print_json

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lfdcore.hardware import JoystickCalibration, JoystickLink, JoystickReading

app = typer.Typer(help="What a chair's joystick says, and what its voltages mean.", no_args_is_help=True)

Port = Annotated[str, typer.Argument(metavar="PORT", help="A serial port, as /dev/ttyACM0, or sim: a simulated chip.")]

SUPPLY = 5.0
"""[V] of the DACs"""
SETTLED = 1.0
"""[s] that the stick is watched in each place"""
LEAST_DEAD_ZONE, TREMBLES = 12, 4
"""[ADC counts]; the dead zone is at least so many times what a stick that was let go moves by"""


@app.command()
def monitor(
    port: Port,
    every: Annotated[float, typer.Option(min=0.05, help="Seconds between the lines printed.")] = 0.5,
    seconds: Annotated[float | None, typer.Option(min=0.1, help="Stop after so long. Default: Ctrl-C.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Show axes, wheels, rates and faults of a joystick's chip, live."""
    from lfdcore.cli.ports import opened

    with opened(port) as link:
        for line in _lines(link, every, seconds):
            if as_json:
                print_json(line)
            else:
                typer.echo("  ".join(f"{name} {value}" for name, value in line.items()))


def _lines(link: JoystickLink, every: float, seconds: float | None) -> Iterator[dict[str, object]]:
    begin = time.monotonic()
    before, then = link.statistics.reports, begin
    while seconds is None or time.monotonic() - begin < seconds:
        time.sleep(every)
        said, statistics, now = link.read(), link.statistics, time.monotonic()
        rate = (statistics.reports - before) / (now - then)
        before, then = statistics.reports, now
        yield {
            "state": link.state,
            **({"why": link.fault} if said is None else _of(said)),
            "reports/s": round(rate, 1),
            "lost": statistics.lost_reports,
            "bad": statistics.bad_frames,
        }


def _of(said: JoystickReading) -> dict[str, object]:
    return {
        "forward": round(said.forward, 3),
        "left": round(said.left, 3),
        "adc": tuple(said.adc),
        "edges": tuple(said.edges),
        "given": (round(said.given_forward, 3), round(said.given_left, 3)),
        "faults": ", ".join(said.faults) or "none",
        "manual": said.manual,
        "emergency": said.emergency,
    }


@app.command()
def calibrate(
    port: Port,
    forward_output: Annotated[
        str,
        typer.Option(help="MINUS,NEUTRAL,PLUS [V] that the controller takes: fully back, stand still, fully ahead."),
    ],
    left_output: Annotated[
        str, typer.Option(help="MINUS,NEUTRAL,PLUS [V]: fully to the right, stand still, fully to the left.")
    ],
    profiles: Annotated[str, typer.Option(help="Of full output, in % of each of four profiles.")] = "100,100,100,100",
) -> None:
    """Ask for the stick's places one by one, and store what they mean in the chip. Measure the controller's voltages at
    its own joystick first."""
    from lfdcore.cli.ports import opened
    from lfdcore.hardware import JoystickCalibration

    outputs = [_codes("--forward-output", forward_output), _codes("--left-output", left_output)]
    percent = _numbers("--profiles", profiles, 4)
    with opened(port) as link:
        centre = _watch(link, "Let the stick go.")
        ends = [
            _watch(link, f"Hold the stick fully {way}.") for way in ("ahead", "back", "to the left", "to the right")
        ]
        ahead, back, left, right = (end[axis][1] for end, axis in zip(ends, (0, 0, 1, 1), strict=True))
        dead = [max(LEAST_DEAD_ZONE, TREMBLES * (high - low)) for low, _, high in centre]
        made = JoystickCalibration(
            axes=[(back, centre[0][1], ahead, dead[0]), (right, centre[1][1], left, dead[1])],
            outputs=outputs,
            profiles=[round(value) for value in percent],
        )
        link.calibrate(made)
        _tell(made)


def _tell(made: JoystickCalibration) -> None:
    for name, axis in zip(("forward", "left"), made.axes, strict=True):
        typer.echo(f"{name}: {axis[0]} to {axis[2]}, centre {axis[1]}, dead zone {axis[3]} [ADC counts]")
    typer.echo("stored")


def _watch(link: JoystickLink, what: str) -> list[tuple[int, int, int]]:
    """(least, median, greatest) [ADC counts] of both axes, over a second from Enter on."""
    typer.prompt(f"{what} Then press Enter", default="", show_default=False)
    seen: list[tuple[int, int]] = []
    end = time.monotonic() + SETTLED
    while time.monotonic() < end:
        said = link.read()
        if said is not None:
            seen.append((said.adc[0], said.adc[1]))
        time.sleep(0.01)
    if len(seen) < 10:
        raise ValueError(f"{link.port} fell silent: {link.fault}")
    return [(min(axis), sorted(axis)[len(axis) // 2], max(axis)) for axis in zip(*seen, strict=True)]


def _codes(option: str, text: str) -> tuple[int, int, int]:
    volts = _numbers(option, text, 3)
    for value in volts:
        if not 0 <= value <= SUPPLY:
            raise typer.BadParameter(f"{option} has {value:g} V, must lie in [0, {SUPPLY:g}] V")
    minus, neutral, plus = (round(value / SUPPLY * 4095) for value in volts)
    return minus, neutral, plus


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise typer.BadParameter(f"{option} is '{text}', must be {count} numbers separated by commas")
    return numbers
