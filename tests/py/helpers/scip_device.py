"""A LIDAR of Hokuyo as its host sees it: SCIP 2.0 over a pty or TCP, with the faults of real ones, in its own thread.

Written from the specification (C-42-03320B), not from lfdcore's codec.
"""

from __future__ import annotations

import os
import pty
import queue
import select
import socket
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Self

Distances = list[int]
CLOCK = 1 << 24
"""[ms] after which its clock begins anew"""


@dataclass(frozen=True)
class Model:
    name: str
    dmin: int
    dmax: int
    ares: int
    amin: int
    amax: int
    afrt: int
    scan: int

    @property
    def beams(self) -> int:
        return self.amax - self.amin + 1

    @property
    def period(self) -> float:
        """[s]"""
        return 60 / self.scan


UTM_30LX = Model("UTM-30LX", 23, 60000, 1440, 0, 1080, 540, 2400)
URG_04LX = Model("URG-04LX(Hokuyo Automatic Co., Ltd.)", 20, 5600, 1024, 44, 725, 384, 600)


def summed(line: str) -> str:
    """A line, the sum of its characters in 6 bits, and its end."""
    return line + chr((sum(line.encode()) & 0x3F) + 0x30) + "\n"


def field(line: str) -> str:
    """The same where a semicolon, which does not count, stands before the sum."""
    return line + ";" + summed(line)[-2:]


@lru_cache(maxsize=1 << 17)
def encoded(value: int, characters: int) -> str:
    return "".join(chr(((value >> (6 * i)) & 0x3F) + 0x30) for i in reversed(range(characters)))


class PtyLink:
    """A serial port under a name that stays the same over unplugging."""

    def __init__(self, folder: Path) -> None:
        self.address = str(folder / "ttyACM0")
        self.plug()

    def plug(self) -> None:
        self._device, self._port = pty.openpty()
        tty.setraw(self._port)
        os.set_blocking(self._device, False)
        os.symlink(os.ttyname(self._port), self.address)

    def unplug(self) -> None:
        os.unlink(self.address)
        os.close(self._device)
        os.close(self._port)

    def baud(self) -> int | None:
        rates = {termios.B19200: 19200, termios.B57600: 57600, termios.B115200: 115200, termios.B500000: 500000}
        return rates.get(termios.tcgetattr(self._port)[4])

    def files(self) -> list[int]:
        return [self._device]

    def read(self) -> bytes:
        return os.read(self._device, 4096)

    def writable(self) -> int | None:
        return self._device

    def write(self, data: bytes) -> int:
        return os.write(self._device, data)


class TcpLink:
    """One connection at a time, always at the same port."""

    def __init__(self) -> None:
        self._port = 0
        self.plug()
        self.address = f"127.0.0.1:{self._port}"

    def plug(self) -> None:
        self._connection: socket.socket | None = None
        self._listener = socket.create_server(("127.0.0.1", self._port))
        self._port = self._listener.getsockname()[1]

    def unplug(self) -> None:
        self._listener.close()
        self._drop()

    def _drop(self) -> None:
        if self._connection is not None:
            self._connection.close()
        self._connection = None

    def baud(self) -> int | None:
        return None

    def files(self) -> list[int]:
        return [(self._connection or self._listener).fileno()]

    def read(self) -> bytes:
        if self._connection is None:
            self._connection = self._listener.accept()[0]
            self._connection.setblocking(False)
            self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        data = self._connection.recv(4096)
        if not data:
            self._drop()
        return data

    def writable(self) -> int | None:
        return None if self._connection is None else self._connection.fileno()

    def write(self, data: bytes) -> int:
        return 0 if self._connection is None else self._connection.send(data)


class ScipDevice:
    """Measures `scan(number)`: the distances [mm] of its beams in its turn `number`, which counts from 0 for ever.

    What is set while it runs: `mangle` turns each reply into what goes over the wire; `statuses` are given instead of
    00 to commands that begin so; `silent`: it hears and says nothing; `clock_rate` and `clock_start` [ms] are its
    clock's, at the next power-on.
    """

    def __init__(
        self,
        link: PtyLink | TcpLink,
        scan: Callable[[int], Distances],
        model: Model = UTM_30LX,
        *,
        scip_1: bool = False,
        baud: int | None = None,
        clock_rate: float = 1.0,
        clock_start: int = 0,
    ) -> None:
        self.model, self._scan, self._link, self._baud = model, scan, link, baud
        self.address = link.address
        self.mangle: Callable[[bytes], Iterable[bytes]] = lambda reply: [reply]
        self.statuses: dict[str, str] = {}
        self.silent = False
        self.clock_rate, self.clock_start = clock_rate, clock_start
        self.taken: dict[int, float] = {}
        """When each turn that was sent began, by time.monotonic() [s]"""
        self.heard: list[str] = []
        self._scip_1 = scip_1
        self._plugged = True
        self._work: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._wake = os.pipe()
        self._power_on()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._work.put(None)
        os.write(self._wake[1], b"x")
        self._thread.join()
        if self._plugged:
            self._link.unplug()
        for file in self._wake:
            os.close(file)

    def unplug(self) -> None:
        self._do(self._unplug)

    def replug(self) -> None:
        self._do(self._replug)

    def reset(self) -> None:
        """As after the power failed for a moment, while its cable stays."""
        self._do(self._power_on)

    def ticks(self, now: float) -> int:
        """Its clock at a time of time.monotonic() [s]."""
        return (self.clock_start + int((now - self._began) * 1000 * self.clock_rate)) % CLOCK

    def _do(self, work: Callable[[], None]) -> None:
        done = threading.Event()

        def work_and_tell() -> None:
            work()
            done.set()

        self._work.put(work_and_tell)
        os.write(self._wake[1], b"x")
        assert done.wait(30)

    def _power_on(self) -> None:
        self._began = self._turns_since = time.monotonic()
        self._measuring: str | None = None
        self._adjusting = self._laser = False
        self._input = b""
        self._next_turn = 0
        self._turn_offset = len(self.taken) and max(self.taken) + 1

    def _unplug(self) -> None:
        self._plugged = False
        self._link.unplug()

    def _replug(self) -> None:
        self._link.plug()
        self._plugged = True
        self._power_on()

    def _run(self) -> None:
        while True:
            files = [self._wake[0], *(self._link.files() if self._plugged else [])]
            ready = select.select(files, [], [], self._until_next())[0]
            if self._wake[0] in ready:
                os.read(self._wake[0], 1)
                work = self._work.get()
                if work is None:
                    return
                work()
                continue
            if ready:
                self._listen()
            if self._plugged and self._measuring is not None and self._until_next() == 0:
                self._send_turn()

    def _until_next(self) -> float | None:
        """[s] until its mirror has passed the last step of the turn that comes next."""
        if self._measuring is None or not self._plugged:
            return None
        return max(0.0, self._turns_since + (self._next_turn + 0.9) * self.model.period - time.monotonic())

    def _listen(self) -> None:
        try:
            self._input += self._link.read()
        except OSError:
            return
        if self._baud is not None and self._link.baud() != self._baud:
            self._input = b""
            self._put(b"\xf8\x00\x86\xff")
        *commands, self._input = self._input.split(b"\n")
        for command in commands:
            self.heard.append(command.decode("latin-1"))
            self._obey(self.heard[-1])

    def _obey(self, command: str) -> None:
        status = next((s for start, s in self.statuses.items() if command.startswith(start)), None)
        if self._scip_1:
            self._scip_1 = command != "SCIP2.0"
            self._put(f"{command}\n{'E' if self._scip_1 else '0'}\n\n".encode())
        elif status is not None:
            self._answer(command, status)
        elif self._adjusting and command[:2] not in ("TM", "VV"):
            self._answer(command, "0B")
        else:
            getattr(self, f"_obey_{command[:2].lower()}", self._refuse)(command)

    def _refuse(self, command: str) -> None:
        self._answer(command, "0E")

    def _answer(self, command: str, status: str, *lines: str) -> None:
        self._put((command + "\n" + summed(status) + "".join(lines) + "\n").encode())

    def _obey_vv(self, command: str) -> None:
        said = (
            "VEND:Hokuyo Automatic Co.,Ltd.",
            f"PROD:SOKUIKI Sensor {self.model.name}",
            "FIRM:1.18.00(08/Jan./2013)",
        )
        self._answer(command, "00", *map(field, (*said, "PROT:SCIP 2.0", "SERI:H0614967")))

    def _obey_pp(self, command: str) -> None:
        names = ("dmin", "dmax", "ares", "amin", "amax", "afrt", "scan")
        said = [f"MODL:{self.model.name}", *(f"{name.upper()}:{getattr(self.model, name)}" for name in names)]
        self._answer(command, "00", *map(field, said))

    def _obey_ii(self, command: str) -> None:
        said = (f"MODL:{self.model.name}", f"LASR:{'ON' if self._laser else 'OFF'}", "STAT:Sensor works well.")
        self._answer(command, "00", *map(field, said))

    def _obey_tm(self, command: str) -> None:
        if command == "TM1" and self._adjusting:
            self._answer(command, "00", summed(encoded(self.ticks(time.monotonic()), 4)))
        elif command in ("TM0", "TM2"):
            on = command == "TM0"
            status = "00" if on != self._adjusting else "02" if on else "03"
            self._adjusting = on
            if on:
                self._measuring, self._laser = None, False
            self._answer(command, status)
        else:
            self._answer(command, "04" if command == "TM1" else "01")

    def _obey_bm(self, command: str) -> None:
        self._answer(command, "02" if self._laser else "00")
        self._laser = True

    def _obey_qt(self, command: str) -> None:
        self._measuring, self._laser = None, False
        self._answer(command, "00")

    def _obey_md(self, command: str) -> None:
        first, last, self._cluster = int(command[2:6]), int(command[6:10]), command[10:12]
        if last > self.model.amax or first < self.model.amin:
            self._answer(command, "04")
            return
        self._measuring, self._laser = command, True
        self._next_turn = int((time.monotonic() - self._turns_since) / self.model.period) + 1
        self._answer(command, "00")

    def _send_turn(self) -> None:
        """The last turn that is over. Those that it was too late for are lost: it has no place for them."""
        assert self._measuring is not None
        over = int((time.monotonic() - self._turns_since) / self.model.period - 0.9)
        turn = max(self._next_turn, over)
        self._next_turn = turn + 1
        began = self._turns_since + turn * self.model.period
        number = self._turn_offset + turn
        data = "".join(encoded(distance, 3) for distance in self._scan(number))
        lines = [summed(data[i : i + 64]) for i in range(0, len(data), 64)]
        self.taken[number] = began
        self._answer(self._measuring, "99", summed(encoded(self.ticks(began), 4)), *lines)

    def _put(self, reply: bytes) -> None:
        if self.silent:
            return
        for part in self.mangle(reply):
            if not self._send(part):
                return

    def _send(self, data: bytes) -> bool:
        """-> whether all of it went; as of a device with a small buffer, what its host does not take is lost."""
        while data:
            file = self._link.writable()
            if file is None or not select.select([], [file], [], 1.0)[1]:
                return False
            try:
                data = data[self._link.write(data) :]
            except OSError:
                return False
        return True
