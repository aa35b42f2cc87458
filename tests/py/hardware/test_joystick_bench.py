"""The bench around the simulated chip, shown with a small firmware of its own (firmware/bench/echo_test.cpp)."""

from __future__ import annotations

import os
import select
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from lfdcore.errors import DeviceError
from lfdcore.simulated.joystick_bench import Event, JoystickBench, bytes_of, packaged

SOURCE = Path(__file__).parents[3] / "firmware" / "bench" / "echo_test.cpp"
ESCAPE = b"\x1b"
START_UP = 0.067
BYTE_OF_PC, BYTE_OF_CHIP = 10 / 115200, 10 * 136 / 16e6
CYCLE = 1 / 16e6
WRITTEN = b"\x28"  # TWI status: data sent, acknowledged
ADDRESS_NOT_ACKNOWLEDGED = b"\x20"
POWER_ON, EXTERNAL, BROWN_OUT, WATCHDOG = 1, 2, 4, 8  # MCUSR


@pytest.fixture(scope="session")
def echo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The test's firmware."""
    try:
        packaged("joystick_bench")
    except DeviceError as error:
        pytest.skip(str(error))
    if shutil.which("avr-g++") is None:
        pytest.skip("avr-g++ is missing: apt-get install gcc-avr avr-libc")
    elf = tmp_path_factory.mktemp("echo") / "echo_test.elf"
    options = ["-mmcu=atmega328p", "-DF_CPU=16000000UL", "-std=c++11", "-Os", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["avr-g++", *options, str(SOURCE), "-o", str(elf)], check=True)
    return elf


@pytest.fixture
def free(echo: Path) -> Iterator[JoystickBench]:
    """A bench on the virtual clock, whose chip has started."""
    with JoystickBench(echo, free=True) as bench:
        bench.run(START_UP)
        yield bench


def ask(bench: JoystickBench, command: bytes, seconds: float = 0.01) -> bytes:
    """The answer of the firmware to a command."""
    bench.send(ESCAPE + command)
    bench.run(seconds)
    return bench.received()


def codes(bench: JoystickBench) -> tuple[int, int]:
    forward, left = np.frombuffer(ask(bench, b"a"), "<u2")
    return int(forward), int(left)


def counted_edges(bench: JoystickBench) -> tuple[int, int]:
    left, right = np.frombuffer(ask(bench, b"e"), "<i4")
    return int(left), int(right)


def write_dacs(bench: JoystickBench, forward: int, left: int) -> bytes:
    return ask(bench, b"d" + forward.to_bytes(2, "big") + left.to_bytes(2, "big"))


def of(events: list[Event], what: str) -> list[Event]:
    return [event for event in events if event.what == what]


def test_adc_codes_are_right_to_one_count_over_the_whole_range(free: JoystickBench) -> None:
    for volts in np.linspace(0, 5, 41):
        free.set_stick(float(volts), float(5 - volts))
        for code, given in zip(codes(free), (volts, 5 - volts), strict=True):
            assert abs(code - given / 5 * 1024) <= 1


@pytest.mark.parametrize("code", [0, 1, 0x123, 0x800, 0xFFE, 0xFFF])
def test_a_dac_gives_the_code_that_it_is_written(free: JoystickBench, code: int) -> None:
    assert write_dacs(free, code, 0xFFF - code) == WRITTEN * 2
    assert free.outputs().dac == (code, 0xFFF - code)
    assert free.outputs().dac_writes == (1, 1)


def test_a_write_to_a_dac_takes_the_time_of_the_bus_at_400_kilohertz(free: JoystickBench) -> None:
    free.trace()
    free.send(ESCAPE + b"d\x01\x00\x02\x00")
    free.run(0.01)
    events = free.take_events()
    forward, left = (of(events, name)[0].stamp for name in ("dac0", "dac1"))
    bus = 29 / 400e3  # stop, start, an address and two bytes of nine bits
    assert bus < left - forward < bus + 70e-6  # the program's own time


def test_a_dac_keeps_its_output_through_a_reset_and_takes_its_eeprom_at_power_up(free: JoystickBench) -> None:
    ask(free, b"p\x01\x23", 0.06)
    write_dacs(free, 0x456, 0x789)
    free.reset()
    assert free.outputs().dac == (0x456, 0x789)
    free.set_power(False)
    assert free.outputs().dac == (0, 0)
    free.set_power(True)
    assert free.outputs().dac == (0x123, 0x800)
    free.run(START_UP)
    assert ask(free, b"q") == bytes([0xC0, 0x12, 0x30, 0x01, 0x23])


def test_a_dac_that_is_storing_takes_no_write(free: JoystickBench) -> None:
    ask(free, b"p\x01\x23")
    write_dacs(free, 0x456, 0x789)
    assert free.outputs().dac == (0x123, 0x789)
    assert ask(free, b"q")[:1] == b"\x40", "it says that it is busy"


def test_an_absent_dac_does_not_acknowledge_and_keeps_its_output(free: JoystickBench) -> None:
    write_dacs(free, 0x100, 0x200)
    free.set_dac_bus(1, "absent")
    assert write_dacs(free, 0x300, 0x400) == WRITTEN + ADDRESS_NOT_ACKNOWLEDGED
    assert free.outputs().dac == (0x300, 0x200)
    free.set_dac_bus(1, "present")
    assert write_dacs(free, 0x300, 0x400) == WRITTEN * 2


def test_a_bus_held_low_lets_no_start_through_until_nine_clocks_free_it(free: JoystickBench) -> None:
    free.set_dac_bus(0, "stuck", clocks=9)
    assert write_dacs(free, 0x300, 0x400) == b"\0\0"
    assert free.outputs().dac == (0x800, 0x800)
    ask(free, b"c")
    assert write_dacs(free, 0x300, 0x400) == WRITTEN * 2


def test_the_enable_line_is_traced_with_the_chips_time_and_falls_at_a_reset(free: JoystickBench) -> None:
    assert not free.outputs().enable
    free.trace()
    ask_time = free.outputs().stamp
    free.send(ESCAPE + b"n")
    free.run(0.01)
    rise = of(free.take_events(), "enable")
    assert [event.value for event in rise] == ["1"]
    assert ask_time + 2 * BYTE_OF_PC < rise[0].stamp < ask_time + 0.002
    free.reset()
    assert not free.outputs().enable
    assert [(event.what, event.value) for event in free.take_events()] == [("enable", "0"), ("reset", "external")]


@pytest.mark.parametrize(
    "rates", [(1.0, -1.0), (333.3, 1234.5), (-20000.0, 0.0), (7000.1, -6999.9), (10000.0, 10000.0)]
)
def test_edges_are_made_at_their_rate_and_counted_exactly(free: JoystickBench, rates: tuple[float, float]) -> None:
    expected = np.zeros(2)
    for sign, seconds in ((1, 1.3), (-1, 2.1), (1, 0.7)):
        free.set_wheels(sign * rates[0], sign * rates[1])
        free.run(seconds)
        expected += sign * seconds * np.array(rates)
    free.set_wheels(0, 0)
    made = free.outputs().edges
    assert np.abs(np.array(made) - expected).max() <= 1
    assert counted_edges(free) == made


def test_an_encoders_edges_come_evenly_to_a_microsecond(free: JoystickBench) -> None:
    """At 1 kHz an edge comes each ms, the first 0.5 ms after the wheel has begun to turn."""
    free.set_wheels(1000, 0)
    seen = []
    free.run(0.0005 - 1e-6)
    for _ in range(8):
        before = free.outputs().edges[0]
        free.run(2e-6)
        seen.append((before, free.outputs().edges[0]))
        free.run(0.001 - 2e-6)
    assert seen == [(k, k + 1) for k in range(8)]


def test_buttons_and_their_broken_wires_are_levels_at_pins(free: JoystickBench) -> None:
    def pressed() -> tuple[bool, bool]:
        pins = ask(free, b"i")[0]
        assert (bool(pins & 64), bool(pins & 128)) == tuple(free.outputs().pins[n] for n in ("manual", "emergency"))
        return not pins & 64, bool(pins & 128)

    assert pressed() == (False, False)
    free.set_button("manual", True)
    assert pressed() == (True, False)
    free.break_button_wire("manual")
    assert pressed() == (False, False), "a broken manual button is never pressed"
    free.set_button("emergency", True)
    assert pressed() == (False, True)
    free.set_button("emergency", False)
    free.break_button_wire("emergency")
    assert pressed() == (False, True), "a broken emergency button is pressed"
    free.break_button_wire("emergency", False)
    assert pressed() == (False, False)


def test_bytes_take_their_time_on_the_line_to_the_cycle(free: JoystickBench) -> None:
    data = bytes(range(0x40, 0x80)) * 4
    begin = free.outputs().stamp
    free.send(data)
    free.run(0.05)
    echoed = of(free.take_events(), "uart")
    assert bytes_of(echoed) == data
    gaps = np.diff([event.stamp for event in echoed])
    latency = echoed[0].stamp - begin - BYTE_OF_PC - BYTE_OF_CHIP
    assert 0 < latency < 20e-6
    assert abs(gaps.mean() - BYTE_OF_PC) < 0.1e-6, "the chip's baud rate is higher, so that it waits for the PC's bytes"
    assert gaps.min() > BYTE_OF_CHIP - CYCLE / 2
    answer = ESCAPE + b"e"
    free.send(answer)
    free.run(0.01)
    stamps = [event.stamp for event in of(free.take_events(), "uart")]
    assert np.diff(stamps) == pytest.approx(BYTE_OF_CHIP, abs=1e-9), "the chip's own bytes come without a gap"


def test_no_byte_is_lost_at_the_full_rate_for_seconds(free: JoystickBench) -> None:
    data = np.random.default_rng(1).integers(0x20, 0x100, 40000, dtype=np.uint8).tobytes()
    free.send(data)
    free.run(len(data) * BYTE_OF_PC + 0.01)
    assert free.received() == data
    assert free.outputs().uart.overrun == 0


def test_a_chip_that_does_not_fetch_its_bytes_loses_all_but_three(free: JoystickBench) -> None:
    free.hang()
    free.send(b"0123456789")
    free.run(0.01)
    counts = free.outputs().uart
    assert (counts.from_pc, counts.overrun) == (10, 7)


def test_a_cut_cable_swallows_bytes_of_both_directions(free: JoystickBench) -> None:
    free.cut_cable()
    free.send(b"lost")
    free.run(0.01)
    assert free.outputs().uart.cut_off == 4
    free.cut_cable(False)
    free.send(b"heard")
    free.run(0.01)
    assert free.received() == b"heard"


def test_the_same_commands_give_the_same_bytes_at_the_same_cycles(echo: Path) -> None:
    def record() -> tuple[list[Event], object]:
        random = np.random.default_rng(7)
        with JoystickBench(echo, free=True) as bench:
            bench.trace()
            bench.run(START_UP)
            for _ in range(60):
                bench.set_stick(*map(float, random.uniform(0, 5, 2)))
                bench.set_wheels(*map(float, random.uniform(-9000, 9000, 2)))
                bench.send(bytes(random.integers(0x20, 0x100, 50, dtype=np.uint8)))
                bench.send(ESCAPE + random.choice([b"a", b"e", b"n", b"f", b"d\x01\x02\x03\x04"]))
                bench.run(float(random.uniform(0, 0.02)))
                if random.random() < 0.05:
                    bench.reset()
            return bench.take_events(), bench.outputs()

    first, second = record(), record()
    assert len(first[0]) > 500
    assert first == second


def test_a_program_that_hangs_is_reset_by_its_watchdog(free: JoystickBench) -> None:
    ask(free, b"n")
    free.trace()
    begin = free.outputs().stamp
    free.hang()
    free.run(0.3)
    reset = of(free.take_events(), "reset")
    assert [event.value for event in reset] == ["watchdog"]
    assert 0.24 < reset[0].stamp - begin < 0.2561, "the watchdog waits 32768 cycles of 128 kHz"
    assert not free.outputs().enable
    free.run(START_UP)
    assert free.outputs().resets.watchdog == 1
    assert ask(free, b"m") == bytes([WATCHDOG])


def test_a_hung_program_whose_interrupts_go_on_is_reset_too(free: JoystickBench) -> None:
    free.hang(interrupts_served=True)
    free.set_wheels(5000, 0)
    free.run(0.3)
    assert free.outputs().resets.watchdog == 1


def test_a_program_that_resets_its_watchdog_no_more_is_reset_again_only_after_that(free: JoystickBench) -> None:
    free.run(1.0)
    assert free.outputs().resets.watchdog == 0
    ask(free, b"w")
    free.run(0.4)
    assert free.outputs().resets.watchdog == 1
    free.run(1.0)
    assert free.outputs().resets.watchdog == 1


@pytest.mark.parametrize(
    ("cause", "flag"),
    [(JoystickBench.reset, EXTERNAL), (JoystickBench.brown_out, BROWN_OUT)],
    ids=["reset button", "brown-out"],
)
def test_a_reset_starts_the_program_again_and_says_why(
    free: JoystickBench, cause: Callable[[JoystickBench], None], flag: int
) -> None:
    assert ask(free, b"m") == bytes([POWER_ON])
    write_dacs(free, 0x111, 0x222)
    cause(free)
    assert not free.outputs().running
    free.run(START_UP)
    assert ask(free, b"m") == bytes([flag])
    assert free.outputs().dac == (0x111, 0x222)


def test_without_power_nothing_happens_and_with_it_again_all_begins_anew(free: JoystickBench) -> None:
    free.set_wheels(1000, 1000)
    free.run(0.1)
    free.set_power(False)
    free.send(b"not heard")
    free.run(0.5)
    off = free.outputs()
    assert (off.powered, off.running, off.enable) == (False, False, False)
    assert free.received() == b""
    free.set_wheels(0, 0)
    free.set_power(True)
    free.run(START_UP)
    assert ask(free, b"m") == bytes([POWER_ON])
    assert counted_edges(free) == (0, 0)
    assert free.outputs().resets.power == 2


def test_the_eeprom_outlasts_power_and_the_program(echo: Path, tmp_path: Path) -> None:
    kept = tmp_path / "eeprom"
    with JoystickBench(echo, free=True, eeprom=kept) as bench:
        bench.run(START_UP)
        assert ask(bench, b"r\x10") == b"\xff"
        assert ask(bench, b"s\x10\x42") == b"\x10"
        bench.set_power(False)
        bench.set_power(True)
        bench.run(START_UP)
        assert ask(bench, b"r\x10") == b"\x42"
    assert kept.read_bytes() == b"\xff" * 16 + b"\x42" + b"\xff" * 1007
    with JoystickBench(echo, free=True, eeprom=kept) as bench:
        bench.run(START_UP)
        assert ask(bench, b"r\x10") == b"\x42"


def test_a_byte_that_is_being_stored_when_the_power_fails_is_lost(free: JoystickBench) -> None:
    ask(free, b"s\x10\x42")
    free.send(ESCAPE + b"s\x10\x43")
    free.run(0.002)
    free.set_power(False)
    free.set_power(True)
    free.run(START_UP)
    assert ask(free, b"r\x10") == b"\xff"


def write_all(fd: int, data: bytes) -> None:
    while data:
        data = data[os.write(fd, data) :]


def read_all(fd: int, size: int) -> bytes:
    """So many bytes, or fewer where none come for 20 s."""
    data = b""
    while len(data) < size and select.select([fd], [], [], 20)[0]:
        data += os.read(fd, 4096)
    return data


def test_over_the_pseudo_terminal_no_byte_is_lost_in_either_direction(echo: Path) -> None:
    data = np.random.default_rng(2).integers(0x20, 0x100, 30000, dtype=np.uint8).tobytes()
    with JoystickBench(echo) as bench:
        bench.wait_until_answering()
        fd = os.open(bench.port, os.O_RDWR | os.O_NOCTTY)
        writer = threading.Thread(target=write_all, args=(fd, data))
        begin = bench.outputs().stamp
        writer.start()
        assert read_all(fd, len(data)) == data
        took = bench.outputs().stamp - begin
        writer.join()
        os.close(fd)
        counts = bench.outputs().uart
    assert counts.from_pc == counts.to_pc == len(data)
    assert took > len(data) * BYTE_OF_PC, "no byte comes faster than the line"


def test_what_the_chip_says_waits_for_a_reader(echo: Path) -> None:
    """More than the kernel keeps, while nobody reads."""
    data = bytes(range(0x20, 0x100)) * 60
    with JoystickBench(echo) as bench:
        bench.wait_until_answering()
        fd = os.open(bench.port, os.O_RDWR | os.O_NOCTTY)
        write_all(fd, data)
        end = time.monotonic() + 60
        while bench.outputs().uart.to_pc < len(data) and time.monotonic() < end:
            time.sleep(0.01)
        assert read_all(fd, len(data)) == data
        os.close(fd)


def test_an_unplugged_port_vanishes_for_its_user_and_works_again_when_opened_anew(echo: Path) -> None:
    with JoystickBench(echo) as bench:
        bench.wait_until_answering()
        fd = os.open(bench.port, os.O_RDWR | os.O_NOCTTY)
        bench.unplug()
        assert select.select([fd], [], [], 20)[0], "a reader is woken"
        with pytest.raises(OSError, match="Input/output error"):
            os.write(fd, b"gone")
        os.close(fd)
        bench.plug_in()
        fd = os.open(bench.port, os.O_RDWR | os.O_NOCTTY)
        os.write(fd, b"again")
        assert read_all(fd, 5) == b"again"
        os.close(fd)


def test_the_chips_time_is_never_ahead_of_the_wall(echo: Path) -> None:
    with JoystickBench(echo) as bench:
        first, begin = bench.outputs().stamp, time.monotonic()
        bench.wait_until_answering()
        last = bench.outputs().stamp
        assert last - first <= time.monotonic() - begin + 0.051, "what was late may be caught up with, up to 50 ms"


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("fly", "unknown command 'fly'"),
        ("adc 0 5001", "MILLIVOLTS is '5001', must be a number from 0 to 5000"),
        ("adc 2 100", "'2' must be '0' or '1'"),
        ("wheels 1", "usage: wheels LEFT_EDGES_PER_S RIGHT_EDGES_PER_S"),
        ("wheels 20001 nan", "LEFT_EDGES_PER_S is '20001', must be a number from -20000 to 20000"),
        ("i2c dac0 lost", "'lost' must be 'present' or 'absent'"),
        ("send 4", "HEX is '4', must be two hexadecimal digits a byte"),
        ("run -1", "MICROSECONDS is '-1', must be a number from 0 to 3.6e+09"),
    ],
)
def test_a_command_that_is_wrong_is_refused_with_the_reason(free: JoystickBench, command: str, said: str) -> None:
    before = free.outputs()
    with pytest.raises(ValueError, match="the joystick bench refuses") as refusal:
        free.command(command)
    assert said in str(refusal.value)
    assert free.outputs() == before


def test_a_chip_in_reset_cannot_hang(free: JoystickBench) -> None:
    free.reset()
    with pytest.raises(ValueError, match="the chip does not run"):
        free.hang()


def test_a_file_that_is_no_firmware_or_no_eeprom_is_refused(echo: Path, tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match="is not an AVR firmware"):
        JoystickBench(SOURCE, free=True)
    short = tmp_path / "short"
    short.write_bytes(b"\0" * 100)
    with pytest.raises(DeviceError, match="short holds 100 bytes, an EEPROM's file has 1024"):
        JoystickBench(echo, free=True, eeprom=short)


def test_a_bench_that_dies_or_hangs_is_an_error_and_not_a_wait(echo: Path) -> None:
    with JoystickBench(echo, free=True, patience=0.5) as bench:
        os.kill(bench.process_id, signal.SIGSTOP)
        with pytest.raises(DeviceError, match=r"gave no answer within 0\.5 s"):
            bench.outputs()
        with pytest.raises(DeviceError, match="has ended"):
            bench.outputs()


def test_a_bench_that_was_not_built_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("lfdcore.simulated.joystick_bench.files", lambda _: tmp_path)
    with pytest.raises(DeviceError, match="apt-get install gcc-avr avr-libc libsimavr-dev libelf-dev"):
        JoystickBench()
