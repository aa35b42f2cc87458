"""The very firmware on a simulated chip: what docs/joystick-link.md promises, at the chip's pins and by its own clock.

LFDCORE_CHIP_SCHEDULES says how many schedules of a faulty link are run.
"""

import math
import os
import random
from collections.abc import Iterator

import pytest

from joystick_protocol import CALIBRATION, command, frame, reports
from lfdcore.errors import DeviceError
from lfdcore.simulated.joystick_bench import JoystickBench, packaged

try:
    packaged("joystick.elf")
    packaged("joystick_bench")
except DeviceError as missing:
    pytest.skip(str(missing), allow_module_level=True)

NEUTRAL = (2048, 2048)
ENDS = (200, 512, 824, 20, 200, 512, 824, 20, 1000, 2048, 3096, 1000, 2048, 3096, 100, 50, 25, 10)
CENTRE, AHEAD = 512 / 1023 * 5, 824 / 1023 * 5
LIMIT = 0.102
"""[s] of age of the report that was answered last: 100 ms, a turn of the loop and a write to the DAC"""
LATE = 0.006
"""[s] by which Chip.age may say less than it is: a step of 1 ms, and a report's way on the wire"""


class Chip:
    """The chip on a virtual clock, with a PC that answers its reports."""

    def __init__(self) -> None:
        self.bench = JoystickBench(free=True)
        self.bench.set_stick(CENTRE, CENTRE)
        self.wanted: int | None = 5000
        self.stream = b""
        self.answered = 0
        self.behind = math.inf
        self.bench.run(0.2)
        self.bench.send(frame("set_calibration", CALIBRATION.pack(*ENDS)))
        self.run(0.5)

    def run(self, seconds: float, step: float = 0.005) -> None:
        """In steps [s] in which a PC would answer."""
        for _ in range(round(seconds / step)):
            self.bench.run(step)
            self.stream += self.bench.received()
            *whole, self.stream = self.stream.rpartition(b"\0")
            for report in reports(b"".join(whole)):
                self.latest = report
                self.behind = min(self.behind, self.bench.outputs().stamp - report["tick"] / 1000)
                if self.wanted is not None:
                    self.bench.send(command(report["tick"], self.wanted))
                    self.answered = report["tick"]

    def age(self) -> float:
        """[s] by the chip's clock, of the report that was answered last"""
        return self.bench.outputs().stamp - self.behind - self.answered / 1000

    def set_off(self) -> None:
        self.wanted = 5000
        self.bench.set_stick(CENTRE, CENTRE)
        self.run(0.4)
        self.bench.set_stick(AHEAD, CENTRE)
        self.run(0.05)
        assert self.bench.outputs().dac == (2572, 2048)

    @property
    def stands(self) -> bool:
        outputs = self.bench.outputs()
        return outputs.dac == NEUTRAL or not outputs.enable

    def seconds_until_it_stands(self, most: float = 1.0) -> float:
        begin = self.bench.outputs().stamp
        while not self.stands:
            self.run(0.005)
            assert self.bench.outputs().stamp - begin < most
        return self.bench.outputs().stamp - begin


@pytest.fixture
def chip() -> Iterator[Chip]:
    made = Chip()
    with made.bench:
        yield made


def test_it_drives_what_the_pc_answers_and_says_so(chip: Chip) -> None:
    chip.set_off()
    chip.run(0.05)
    assert chip.latest["forward"] == 10000
    assert chip.latest["given_forward"] == 5000
    assert chip.latest["state"] == 2
    assert chip.bench.outputs().enable


def test_without_a_calibration_the_controller_is_not_connected() -> None:
    with JoystickBench(free=True) as bench:
        bench.run(0.5)
        outputs = bench.outputs()
        assert outputs.dac == NEUTRAL
        assert not outputs.enable
        assert reports(bench.received())[-1]["faults"] == 1


def test_the_calibration_is_kept_through_a_power_cycle_and_both_dacs_begin_at_neutral(chip: Chip) -> None:
    chip.set_off()
    chip.bench.set_power(False)
    chip.bench.run(0.1)
    chip.bench.set_power(True)
    chip.run(0.3)
    assert chip.stands
    assert chip.latest["faults"] == 0
    assert chip.latest["state"] == 0
    chip.set_off()


@pytest.mark.hazard(
    "The chip fails", "from power-up on each DAC gives neutral by itself, also a new one, and after two calibrations"
)
def test_each_dac_keeps_the_neutral_voltage_in_its_own_memory(chip: Chip) -> None:
    bench = chip.bench
    assert bench.outputs().dac_eeprom == NEUTRAL
    for neutral in (2100, 2200):  # the second while the first is still being stored
        bench.send(
            frame("set_calibration", CALIBRATION.pack(*ENDS[:8], 1000, neutral, 3096, 1000, 2048, 3096, *ENDS[14:]))
        )
        chip.run(0.02)
    chip.run(0.3)
    assert bench.outputs().dac_eeprom == (2200, 2048)
    bench.set_power(False)
    bench.set_dac_eeprom(1, 4095)
    bench.set_power(True)
    chip.run(0.5)
    assert bench.outputs().dac_eeprom == (2200, 2048)


def test_a_dac_whose_memory_takes_nothing_is_a_fault(chip: Chip) -> None:
    bench = chip.bench
    bench.set_dac_eeprom(0, 4095, worn=True)
    bench.reset()
    chip.run(1.0)
    assert chip.latest["faults"] == 32
    assert chip.stands
    bench.set_dac_eeprom(0, NEUTRAL[0])
    bench.reset()
    chip.run(0.5)
    chip.set_off()


def test_a_bus_that_a_dac_holds_is_freed(chip: Chip) -> None:
    chip.set_off()
    chip.bench.set_dac_bus(0, "stuck", clocks=9)
    assert chip.seconds_until_it_stands() <= 0.115
    chip.run(0.5)
    assert chip.latest["faults"] == 0
    chip.set_off()


def test_what_is_cut_off_while_it_is_stored_is_no_calibration() -> None:
    with JoystickBench(free=True) as bench:
        bench.run(0.2)
        bench.send(frame("set_calibration", CALIBRATION.pack(*ENDS)))
        bench.run(0.06)
        bench.set_power(False)
        bench.run(0.1)
        bench.received()
        bench.set_power(True)
        bench.run(0.5)
        assert reports(bench.received())[-1]["faults"] == 1


@pytest.mark.hazard("The link to the chair fails", "a PC that falls silent: neutral within 100 ms, at the DACs")
def test_a_silent_pc_is_neutral_within_100_ms(chip: Chip) -> None:
    chip.set_off()
    chip.run(0.1, step=0.001)
    while not chip.stands:
        chip.bench.run(0.001)
    assert LIMIT - 2 * LATE < chip.age() <= LIMIT


@pytest.mark.parametrize("fault", ["cut", "reset", "brown-out", "hang", "dac"])
@pytest.mark.hazard(
    "The chip fails", "a reset, a brown-out, a loop that hangs, a DAC without an answer: the relay opens"
)
def test_whatever_happens_to_the_chip_the_chair_stands_and_needs_neutral(chip: Chip, fault: str) -> None:
    chip.set_off()
    bench = chip.bench
    {
        "cut": bench.cut_cable,
        "reset": bench.reset,
        "brown-out": bench.brown_out,
        "hang": bench.hang,
        "dac": lambda: bench.set_dac_bus(1, "absent"),
    }[fault]()
    assert chip.seconds_until_it_stands() <= 0.115
    if fault == "cut":
        bench.cut_cable(False)
    if fault == "dac":
        bench.set_dac_bus(1, "present")
    chip.run(0.5)
    if fault != "cut":
        assert chip.stands
    chip.set_off()


@pytest.mark.parametrize("volts", [0.0, 5.0])
@pytest.mark.hazard("The stick's wires break", "neutral within two readings, a fault within 100 ms, at the DACs")
def test_a_broken_wire_is_neutral_at_once(chip: Chip, volts: float) -> None:
    chip.set_off()
    chip.bench.set_stick(volts, CENTRE)
    assert chip.seconds_until_it_stands() <= 0.025
    chip.run(0.1)
    assert chip.latest["faults"] == 2


def test_a_stick_that_lost_its_ground_is_a_broken_wire(chip: Chip) -> None:
    chip.set_off()
    supplied = 5 * 100 / (100 + 5 / 2)  # [V] at 5 kilohm and a pull-down of 100
    chip.bench.set_stick(supplied, supplied)
    assert chip.seconds_until_it_stands() <= 0.025
    chip.run(0.1)
    assert chip.latest["faults"] == 2 + 4


def test_a_reset_does_not_close_the_relay_while_the_emergency_is_pressed(chip: Chip) -> None:
    chip.bench.set_button("emergency", True)
    chip.run(0.05)
    chip.bench.trace()
    chip.bench.take_events()
    chip.bench.reset()
    chip.bench.run(0.2)
    assert [event for event in chip.bench.take_events() if (event.what, event.value) == ("enable", "1")] == []


def test_a_dac_that_answers_does_not_excuse_the_other(chip: Chip) -> None:
    chip.set_off()
    chip.bench.trace()
    chip.bench.set_dac_bus(1, "absent")
    chip.run(0.02)
    chip.bench.take_events()
    for wanted in (4000, 3000, 2000):
        chip.wanted = wanted
        chip.run(0.03)
    assert [event for event in chip.bench.take_events() if event.what == "enable"] == []
    assert not chip.bench.outputs().enable


def test_the_emergency_button_opens_the_relay(chip: Chip) -> None:
    chip.set_off()
    chip.bench.set_button("emergency", True)
    chip.run(0.02)
    assert not chip.bench.outputs().enable
    chip.bench.set_button("emergency", False)
    chip.run(0.3)
    assert chip.stands
    chip.set_off()


def test_wheels_are_counted_both_ways(chip: Chip) -> None:
    chip.set_off()
    before = chip.latest
    chip.bench.set_wheels(2000, -500)
    chip.run(1.0)
    edges = chip.bench.outputs().edges
    chip.bench.set_wheels(0, 0)
    chip.run(0.05)
    assert chip.latest["left_edges"] - before["left_edges"] == pytest.approx(edges[0], abs=2)
    assert chip.latest["right_edges"] - before["right_edges"] == pytest.approx(edges[1], abs=2)
    assert chip.latest["lost_edges"] == 0


@pytest.mark.hazard(
    "The link to the chair fails",
    "cut, silent, garbled or repeated: neutral 100 ms after the last report that was answered, at the DACs",
    each="4 schedules on the simulated chip, LFDCORE_CHIP_SCHEDULES",
)
def test_whatever_the_line_does_nothing_moves_on_an_old_answer(chip: Chip) -> None:
    drove, schedules = 0, int(os.environ.get("LFDCORE_CHIP_SCHEDULES", "4"))
    for number in range(schedules):
        chance = random.Random(number)
        chip.set_off()
        chip.run(0.1, step=0.001)
        for _ in range(40):
            trouble = chance.choice(["none", "silent", "garbage", "repeat", "cut"])
            chip.wanted = 5000 if trouble == "none" else None
            chip.bench.cut_cable(trouble == "cut")
            for _ in range(chance.randint(1, 12)):
                if trouble == "garbage":
                    chip.bench.send(chance.randbytes(20))
                if trouble == "repeat":
                    chip.bench.send(command(chip.answered, 5000))
                chip.run(0.01)
                if chip.stands:
                    continue
                drove += 1
                assert chip.age() <= LIMIT, (number, trouble)
        chip.bench.cut_cable(False)
    assert drove > 0
    print(
        f"{schedules} schedules on the simulated chip, it drove in {drove} looks, 0 on an answer older than {LIMIT} s"
    )
