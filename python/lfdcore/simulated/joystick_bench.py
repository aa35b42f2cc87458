"""The joystick interface on a simulated chip: its very firmware runs, and the bench is all that is connected to it.

The program `joystick_bench` (firmware/bench) simulates the ATmega328P with simavr, an instruction at a time, with its
UART on a pseudo-terminal, two DACs, the stick, two wheel encoders, the buttons and the enable line.
"""

from __future__ import annotations

import contextlib
import json
import queue
import subprocess
import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Literal

from lfdcore.errors import DeviceError

STICK_VOLTS = 5.0
"""[V] The supply: a stick gives 0 to this."""
LARGEST_EDGE_RATE = 20000.0
"""[edges/s] of a wheel's encoder"""
LARGEST_CODE = 4095
"""of a DAC, whose output is then the supply's voltage"""

Button = Literal["manual", "emergency"]


@dataclass(frozen=True)
class ResetCounts:
    """How often the chip was reset, by cause."""

    power: int
    external: int
    brown_out: int
    watchdog: int


@dataclass(frozen=True)
class UartCounts:
    """Bytes on the serial cable."""

    from_pc: int
    """that came to the chip"""
    to_pc: int
    """that the chip sent"""
    overrun: int
    """that came while the chip's three bytes of receive buffer were full"""
    cut_off: int
    """that went into a cut cable, in both directions"""


@dataclass(frozen=True)
class Outputs:
    """What the chip does to its surroundings, and what they do to it. Stamps are of the chip's clock."""

    stamp: float
    """[s] now, since it was first powered"""
    dac: tuple[int, int]
    """outputs of the DACs, forward and left: 0 to 4095 of the supply"""
    dac_stamps: tuple[float, float]
    """[s] when each was written last; 0 for never"""
    dac_writes: tuple[int, int]
    dac_eeprom: tuple[int, int]
    """what each gives from its next power-up on"""
    enable: bool
    """the chair's controller gets the DACs' voltages"""
    enable_stamp: float
    """[s] when this changed last"""
    edges: tuple[int, int]
    """of the left and right encoder: forward less backward"""
    powered: bool
    running: bool
    """powered, and not in the 66 ms of a reset"""
    resets: ResetCounts
    crashes: int
    """How often the program came to an invalid instruction, or slept with interrupts off"""
    uart: UartCounts
    pins: dict[str, bool]
    """input pins by name, as the chip sees them: left_a, left_b, right_a, right_b, manual, emergency"""


@dataclass(frozen=True)
class Event:
    """Something that happened at the chip's pins."""

    stamp: float
    """[s] of the chip's clock, exact to a cycle of 62.5 ns"""
    what: str
    """"adc0", "adc1", "dac0", "dac1", "enable", "uart", "reset" or "power" """
    value: str
    """what the ADC reads, 0 to 1023; a code 0 to 4095; "0" or "1"; a byte as two hexadecimal digits; a cause
    as in ResetCounts"""


def packaged(name: str) -> Path:
    """A file of lfdcore/firmware. DeviceError says what to install where it was not built."""
    path = Path(str(files("lfdcore"))) / "firmware" / name
    if not path.is_file():
        raise DeviceError(
            f"this lfdcore was built without {name}: run 'apt-get install gcc-avr avr-libc libsimavr-dev libelf-dev', "
            "then install lfdcore again"
        )
    return path


class JoystickBench:
    """The chip and what is around it. To be used in a `with` statement, or to be closed with `close()`.

    Without `free`, time passes as on the wall and `port` is the PC's serial port of the chip. With `free`, time passes
    by `run` alone, and the UART's bytes go through `send` and `received`: the same calls give the same bytes at the
    same cycles.
    """

    def __init__(
        self,
        firmware: Path | None = None,
        *,
        eeprom: Path | None = None,
        free: bool = False,
        patience: float = 10.0,
    ) -> None:
        """Starts it with a firmware (an ELF file), by default the joystick interface's own.

        `eeprom` keeps the chip's 1024 bytes: read where the file exists, written after each change. `patience` [s] is
        how long an answer may take, on top of four times the time that `run` asks for. DeviceError: the bench was not
        built, or it cannot use one of the files.
        """
        if eeprom is not None and not eeprom.parent.is_dir():
            raise DeviceError(f"{eeprom}: there is no folder {eeprom.parent} to keep the chip's memory in")
        program = packaged("joystick_bench")
        chosen = packaged("joystick.elf") if firmware is None else firmware
        options = ["--free"] * free + (["--eeprom", str(eeprom)] if eeprom else [])
        self._patience = patience
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._events: list[Event] = []
        self._events_lock = threading.Lock()
        self._asking = threading.Lock()
        """Each answer belongs to the command before it, whichever thread gives it."""
        self._complaints: deque[str] = deque(maxlen=100)
        self._process = subprocess.Popen(
            [str(program), str(chosen), *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._readers = [
            threading.Thread(target=read, args=(stream,), daemon=True)
            for read, stream in (
                (self._read, self._process.stdout),
                (self._complaints.extend, self._process.stderr),
            )
        ]
        for reader in self._readers:
            reader.start()
        try:
            self._port = self._next_line(patience).removeprefix("PTY ")
        except DeviceError:
            self.close()
            raise

    def __enter__(self) -> JoystickBench:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Ends it, saving the EEPROM. At any moment, and twice."""
        assert self._process.stdin and self._process.stdout and self._process.stderr
        with contextlib.suppress(OSError):  # it has ended already
            self._process.stdin.close()  # it ends with its input
        try:
            self._process.wait(self._patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join()
        self._process.stdout.close()
        self._process.stderr.close()

    @property
    def port(self) -> str:
        """The path of the pseudo-terminal, another one after `plug_in`; "none" with `free`."""
        return self._port

    @property
    def process_id(self) -> int:
        """Of the program: to stop it as a frozen machine would be."""
        return self._process.pid

    def command(self, text: str, *, patience: float | None = None) -> str:
        """Gives the program a command as its help lists them -> its answer.

        ValueError: the program refuses it. DeviceError: it has ended, or does not answer.
        """
        if "\n" in text:
            raise ValueError(f"{text!r} is several lines, must be one command")
        with self._asking:
            answer = self._ask(text, self._patience if patience is None else patience)
        if answer.startswith("error "):
            raise ValueError(f"the joystick bench refuses '{text}': {answer.removeprefix('error ')}")
        return answer

    def _ask(self, text: str, patience: float) -> str:
        assert self._process.stdin
        try:
            self._process.stdin.write(text + "\n")
            self._process.stdin.flush()
        except (OSError, ValueError) as error:
            raise self._ended() from error
        return self._next_line(patience)

    def set_stick(self, forward: float, left: float) -> None:
        """The stick's voltages [V], 0 to 5; 2.5 each at the beginning."""
        for channel, volts in enumerate((forward, left)):
            if not 0 <= volts <= STICK_VOLTS:
                raise ValueError(f"the stick's voltage is {volts} V, must lie in [0, {STICK_VOLTS:g}] V")
            self.command(f"adc {channel} {volts * 1000:.6f}")

    def set_wheels(self, left: float, right: float) -> None:
        """The encoders turn so fast from now on [edges/s], -20000 to 20000; positive: A rises before B."""
        self.command(f"wheels {left!r} {right!r}")

    def set_button(self, button: Button, pressed: bool) -> None:
        """Presses or releases a button."""
        self.command(f"button {button} {int(pressed)}")

    def break_button_wire(self, button: Button, broken: bool = True) -> None:
        """Breaks a button's wire, or joins it."""
        self.command(f"button_wire {button} {'broken' if broken else 'joined'}")

    def set_dac_bus(self, dac: int, state: Literal["present", "absent", "stuck"], clocks: int = 0) -> None:
        """DAC 0 (forward) or 1 (left) on its bus: absent, its wires are cut and its output stays; stuck, it holds SDA
        low, for ever or until the chip makes so many `clocks` on SCL as a port pin."""
        self.command(f"i2c dac{dac} {state}" + (f" {clocks}" if clocks else ""))

    def set_dac_eeprom(self, dac: int, code: int, *, worn: bool = False) -> None:
        """What a DAC gives at its next power-up, 0 to 4095; 2048 at first. Worn: it takes no other code."""
        self.command(f"dac_eeprom dac{dac} {code} {'worn' if worn else 'sound'}")

    def cut_cable(self, cut: bool = True) -> None:
        """Cuts the serial cable, or joins it."""
        self.command(f"uart {'cut' if cut else 'join'}")

    def unplug(self) -> None:
        """Without `free`: the PC's port vanishes, as that of a USB device. The chip stays powered."""
        self.command("usb unplug")

    def plug_in(self) -> None:
        """Without `free`: there is a port again, whose path may be another."""
        self._port = self.command("usb plug").removeprefix("PTY ")

    def set_power(self, on: bool) -> None:
        """Off: the chip's RAM and the DACs' registers are lost."""
        self.command(f"power {'on' if on else 'off'}")

    def reset(self) -> None:
        """The reset button."""
        self.command("reset")

    def brown_out(self) -> None:
        """The supply fails for a moment: the chip resets; RAM and DACs stay."""
        self.command("brownout")

    def hang(self, *, interrupts_served: bool = False) -> None:
        """The program loops for ever, as a wrong one would."""
        self.command(f"hang {'main' if interrupts_served else 'all'}")

    def trace(self, on: bool = True) -> None:
        """From now on `take_events` gives each change of what the ADC reads, of the DACs and of the enable line, and
        each reset."""
        self.command(f"trace {'on' if on else 'off'}")

    def outputs(self) -> Outputs:
        """All that can be seen at its pins now."""
        said: dict[str, Any] = json.loads(self.command("get"))
        return Outputs(
            stamp=said["time_us"] * 1e-6,
            dac=(said["dac"][0], said["dac"][1]),
            dac_stamps=(said["dac_time_us"][0] * 1e-6, said["dac_time_us"][1] * 1e-6),
            dac_writes=(said["dac_writes"][0], said["dac_writes"][1]),
            dac_eeprom=(said["dac_eeprom"][0], said["dac_eeprom"][1]),
            enable=bool(said["enable"]),
            enable_stamp=said["enable_time_us"] * 1e-6,
            edges=(said["edges"][0], said["edges"][1]),
            powered=said["powered"],
            running=said["running"],
            resets=ResetCounts(**said["resets"]),
            crashes=said["crashes"],
            uart=UartCounts(**said["uart"]),
            pins={name: bool(level) for name, level in said["pins"].items()},
        )

    def run(self, seconds: float) -> None:
        """With `free`: lets time pass [s], 0 to 3600."""
        self.command(f"run {seconds * 1e6:.4f}", patience=self._patience + 4 * seconds)

    def send(self, data: bytes) -> None:
        """With `free`: bytes of the PC, from now on without a gap, after those that are still on their way."""
        for begin in range(0, len(data), 16384):
            self.command(f"send {data[begin : begin + 16384].hex()}")

    def take_events(self) -> list[Event]:
        """What has happened since this was called last: see `trace`; with `free`, also the bytes of the chip."""
        with self._events_lock:
            events, self._events = self._events, []
        return events

    def received(self) -> bytes:
        """With `free`: the chip's bytes since events were taken last. Other events are dropped: see `bytes_of`."""
        return bytes_of(self.take_events())

    def wait_until_answering(self, seconds: float = 10.0) -> None:
        """Without `free`: until the chip has come out of its reset. DeviceError after `seconds`."""
        end = time.monotonic() + seconds
        while not self.outputs().running:
            if time.monotonic() > end:
                raise DeviceError(f"the simulated chip is still in reset after {seconds} s")
            time.sleep(0.01)

    def _read(self, lines: IO[str]) -> None:
        for line in lines:
            if line.startswith("@"):
                stamp, what, value = line[1:].split()
                with self._events_lock:
                    self._events.append(Event(float(stamp) * 1e-6, what, value))
            else:
                self._lines.put(line.rstrip("\n"))
        self._lines.put(None)

    def _next_line(self, patience: float) -> str:
        try:
            line = self._lines.get(timeout=patience)
        except queue.Empty:
            self._process.kill()  # what it says later would be taken for another answer
            raise DeviceError(f"the joystick bench gave no answer within {patience:g} s; it was ended") from None
        if line is None:
            self._lines.put(None)
            raise self._ended()
        return line

    def _ended(self) -> DeviceError:
        self._readers[1].join(self._patience)  # all that it had to say
        said = "".join(self._complaints).strip()
        return DeviceError(f"the joystick bench has ended: {said or 'it was closed or killed'}")


def bytes_of(events: Sequence[Event]) -> bytes:
    """The chip's bytes among events."""
    return bytes(int(event.value, 16) for event in events if event.what == "uart")
