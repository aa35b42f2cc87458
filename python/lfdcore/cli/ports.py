"""Ports of joysticks that a command names: a serial port, or a simulated chip."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from lfdcore.hardware import JoystickLink
    from lfdcore.simulated.joystick_bench import JoystickBench

SIMULATED = "sim"


def require_port(port: str) -> None:
    """BadParameter for a name that no file can have."""
    try:
        port.encode()
    except UnicodeEncodeError:
        raise typer.BadParameter(f"{port!r} is no name of a port: it is not UTF-8") from None


@contextmanager
def opened(port: str) -> Iterator[JoystickLink]:
    """A link to `port`, closed at the end; for "sim" to a chip that is simulated, and calibrated. DeviceError as
    JoystickLink, and where this lfdcore was built without the simulated chip."""
    from lfdcore.hardware import JoystickLink

    require_port(port)
    if port == SIMULATED:
        with simulated_chip() as (_, link):
            yield link
        return
    link = JoystickLink(port)
    try:
        yield link
    finally:
        link.close()


@contextmanager
def simulated_chip() -> Iterator[tuple[JoystickBench, JoystickLink]]:
    """The firmware in a simulated chip, calibrated, with its stick at neutral; and the link to it."""
    from lfdcore.hardware import JoystickLink
    from lfdcore.simulated.bench_world import CALIBRATION
    from lfdcore.simulated.joystick_bench import JoystickBench

    with JoystickBench() as bench:
        link = JoystickLink(bench.port)
        try:
            link.calibrate(CALIBRATION)
            yield bench, link
        finally:
            link.close()
