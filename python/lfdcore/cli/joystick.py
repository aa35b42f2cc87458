"""lfdcore joystick: what a chair's joystick says, and what its voltages mean (thesis, App. A.1)."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from lfdcore.cli.common import JsonOption, print_json
from lfdcore.cli.live import EveryOption, bar, live_facts, usual_interval

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from lfdcore.hardware import JoystickCalibration, JoystickLink, JoystickReading

app = typer.Typer(help="What a chair's joystick says, and what its voltages mean.", no_args_is_help=True)

Port = Annotated[str, typer.Argument(metavar="PORT", help="A serial port, as /dev/ttyACM0, or sim: a simulated chip.")]

RATE_OVER = 0.5
"""[s] over which reports are counted, at least"""
LEAST_SUPPLY, MOST_SUPPLY = 2.7, 5.5
"""[V] that an MCP4725 can be fed with"""
DAC_TOP, LEAST_CODES = 4095, 101
"""[codes] of a DAC: its top, and the least from neutral to an end, as calibration.hpp has them"""
LOWEST, HIGHEST, LEAST_SPAN = 51, 972, 50
"""[ADC counts] where a stick's ends may be, and how far from its centre, as calibration.hpp has them"""
Seen = tuple[int, int, int]
"""(least, median, greatest) [ADC counts]"""
SETTLED = 1.0
"""[s] that the stick is watched in each place"""
LEAST_DEAD_ZONE, TREMBLES = 12, 4
"""[ADC counts]; the dead zone is at least so many times what a stick that was let go moves by"""


@app.command()
def monitor(
    port: Port,
    every: EveryOption = None,
    seconds: Annotated[float | None, typer.Option(min=0.1, help="Stop after so long. Default: Ctrl-C.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Show axes, wheels, rates and faults of a joystick's chip, live."""
    from lfdcore.cli.ports import opened

    with opened(port) as link, live_facts() as show:
        for facts in _looks(link, every or usual_interval(0.5), seconds):
            if as_json:
                print_json(facts)
            else:
                show(_words(facts))


def _looks(link: JoystickLink, every: float, seconds: float | None) -> Iterator[dict[str, object]]:
    from lfdcore.wheelchair.link_trouble import link_trouble

    begin = time.monotonic()
    before, then = link.statistics.reports, begin
    while seconds is None or time.monotonic() - begin < seconds:
        left = every if seconds is None else begin + seconds - time.monotonic()
        time.sleep(max(0.0, min(every, left)))
        said, statistics, now = link.read(), link.statistics, time.monotonic()
        rate = (statistics.reports - before) / (now - then)
        if now - then >= RATE_OVER:
            before, then = statistics.reports, now
        yield {
            "state": link.state,
            **({} if said is None else _of(said)),
            "reports/s": round(rate),
            "lost": statistics.lost_reports,
            "bad": statistics.bad_frames,
            "why": link_trouble(link),
        }


def _of(said: JoystickReading) -> dict[str, object]:
    return {
        "forward": round(said.forward, 3),
        "left": round(said.left, 3),
        "adc": tuple(said.adc),
        "edges": tuple(said.edges),
        "edges lost": said.lost_edges,
        "given": (round(said.given_forward, 3), round(said.given_left, 3)),
        "profile": said.profile,
        "faults": list(said.faults),
        "manual": said.manual,
        "emergency": said.emergency,
    }


def _words(facts: Mapping[str, object]) -> dict[str, str]:
    words = {name: _word(value) for name, value in facts.items()}
    for axis in ("forward", "left"):
        if axis in facts:
            words[axis] = f"{facts[axis]:+.3f} {bar(float(str(facts[axis])))}"
    return words


def _word(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        return ", ".join(map(str, value)) or "none"
    return str(value)


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
    supply: Annotated[float, typer.Option(help="Of the DACs [V], measured: their outputs are shares of it.")],
    profiles: Annotated[str, typer.Option(help="Of full output, in % of each of four profiles.")] = "100,100,100,100",
) -> None:
    """Ask for the stick's places one by one, and store what they mean in the chip. Measure the controller's voltages at
    its own joystick first."""
    from lfdcore.cli.ports import opened
    from lfdcore.hardware import JoystickCalibration
    from lfdcore.wheelchair.link_trouble import link_trouble

    if not LEAST_SUPPLY <= supply <= MOST_SUPPLY:
        raise typer.BadParameter(f"--supply is {supply:g} V, must lie in [{LEAST_SUPPLY:g}, {MOST_SUPPLY:g}] V")
    outputs = [_codes("--forward-output", forward_output, supply), _codes("--left-output", left_output, supply)]
    percent = _percent("--profiles", profiles)
    with opened(port) as link:
        rest = _watch(link, "Let the stick go.")
        ends = [
            _watch(link, f"Hold the stick fully {way}.") for way in ("ahead", "back", "to the left", "to the right")
        ]
        again = _watch(link, "Let the stick go once more.")
        axes = [
            _axis("forward", rest[0], again[0], ends[1][0], ends[0][0]),
            _axis("left", rest[1], again[1], ends[3][1], ends[2][1]),
        ]
        made = JoystickCalibration(axes=axes, outputs=outputs, profiles=percent)
        link.calibrate(made)
        _tell(made)
        if trouble := link_trouble(link):
            typer.echo(f"now: {trouble}")


def _axis(name: str, rest: Seen, again: Seen, minus: Seen, plus: Seen) -> tuple[int, int, int, int]:
    """(minus, centre, plus, dead zone) [ADC counts] of an axis as it was seen in each place. ValueError, naming what
    was seen, for what no stick does."""
    least, centre, most = rest
    back, ahead = minus[1], plus[1]
    dead = max(LEAST_DEAD_ZONE, TREMBLES * (most - least))
    noted = f"the {name} axis was at {centre} let go, {again[1]} let go again, {back} and {ahead} at its ends"
    if abs(again[1] - centre) > dead:
        raise ValueError(f"{noted}: was it let go? Try again")
    if min(abs(back - centre), abs(ahead - centre)) < LEAST_SPAN:
        raise ValueError(f"{noted}: it hardly moved; are the wires of both axes swapped, or is one broken?")
    if (back < centre) == (ahead < centre):
        raise ValueError(f"{noted}: both on one side; was it held to each side? Try again")
    if not all(LOWEST <= end <= HIGHEST for end in (back, ahead)):
        raise ValueError(
            f"{noted}: its ends must lie within {LOWEST} to {HIGHEST} of 1023, or a broken wire looks like a stick: "
            "put a resistor at each end of it (docs/joystick-link.md)"
        )
    return back, centre, ahead, min(dead, min(abs(back - centre), abs(ahead - centre)) // 2)


def _tell(made: JoystickCalibration) -> None:
    for name, axis in zip(("forward", "left"), made.axes, strict=True):
        typer.echo(f"{name}: {axis[0]} to {axis[2]}, centre {axis[1]}, dead zone {axis[3]} [ADC counts]")
    typer.echo("stored")


def _watch(link: JoystickLink, what: str) -> list[Seen]:
    """(least, median, greatest) [ADC counts] of both axes, over a second from Enter on."""
    _wait_for_enter(f"{what} Then press Enter: ")
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


def _wait_for_enter(what: str) -> None:
    try:
        input(what)
    except EOFError:
        raise ValueError("standard input has ended: calibrate in a terminal, somebody must move the stick") from None


def _codes(option: str, text: str, supply: float) -> tuple[int, int, int]:
    volts = _numbers(option, text, 3)
    for value in volts:
        if not 0 <= value <= supply:
            raise typer.BadParameter(f"{option} has {value:g} V, must lie in [0, {supply:g}] V, the supply's")
    minus, neutral, plus = volts
    least = LEAST_CODES / DAC_TOP * supply
    if (minus < neutral) != (neutral < plus) or min(abs(minus - neutral), abs(plus - neutral)) < least:
        raise typer.BadParameter(
            f"{option} is {minus:g}, {neutral:g}, {plus:g} V: neutral must lie between both ends, {least:.2f} V or "
            "more from each"
        )
    back, still, ahead = (round(value / supply * DAC_TOP) for value in volts)
    return back, still, ahead


def _percent(option: str, text: str) -> list[int]:
    percent = _numbers(option, text, 4)
    for value in percent:
        if not (1 <= value <= 100 and value == round(value)):
            raise typer.BadParameter(f"{option} has {value:g} %, must be a whole number from 1 to 100")
    return [round(value) for value in percent]


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise typer.BadParameter(f"{option} is '{text}', must be {count} numbers separated by commas")
    return numbers
