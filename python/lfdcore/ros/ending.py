"""How a node ends: the first signal ends the drive, further ones do not disturb the stop."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def one_ending() -> Iterator[None]:
    """Until its end the first of SIGINT (KeyboardInterrupt), SIGTERM and SIGHUP (SystemExit) raises; those that follow
    are ignored. A terminal and `ros2 launch` both send SIGINT for one Ctrl-C."""

    def end(number: int, _: FrameType | None) -> None:
        for one in ENDING:
            signal.signal(one, signal.SIG_IGN)
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)

    before = {one: signal.signal(one, end) for one in ENDING}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
