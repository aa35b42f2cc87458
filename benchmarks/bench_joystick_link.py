"""From a reading of the stick to the controller's voltage: the firmware on a simulated chip, a link, an assistant.

Time is the chip's own, from the ADC's sample to the DAC's write. The answer is checked: the DAC gets what the stick
says, or moves as the stick does. The simulation is paced by the wall clock, so a loaded machine shows as a slow PC. The
rival that knows nothing is the link that passes the stick through.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from lfdcore.geometry import Pose2, Twist2
from lfdcore.hardware import JoystickLink
from lfdcore.models import HEATMAPS, PRIMITIVES
from lfdcore.simulated.bench_world import CALIBRATION, WHEELS, BenchWorld
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import DriverInput
from lfdcore.simulated.joystick_bench import Event, JoystickBench
from lfdcore.wheelchair.counted_way import CountedWay
from lfdcore.wheelchair.drive_loop import Tick, drive
from lfdcore.wheelchair.linked_chair import LinkedChair
from lfdcore.wheelchair.named_assistant import NAMED, assistant_maker

STEPS = 300
PULSES, DRIVES = 4, 10
HELD, LET_GO = 0.5, 1.0
"""[s] that a simulated driver holds the stick ahead, and lets it go"""
CENTRE, AHEAD = 512 / 1023 * 5, 824 / 1023 * 5
NEARLY_FULL = 0.98 * CALIBRATION.outputs[0][2]
"""[code]: the stick is read to a count of 312"""
MOVED = 60
"""[codes] from neutral: 3 % of full output and more"""


def answers(events: list[Event], moved: Callable[[int], bool]) -> list[float]:
    """[s] from each sample of the stick out of its centre to the first code of the forward DAC that is `moved`"""
    found, sampled = [], None
    for event in sorted(events, key=lambda event: event.stamp):
        if event.what == "adc0":
            sampled = event.stamp if abs(int(event.value) - 512) > 100 else None
        if event.what == "dac0" and sampled is not None and moved(int(event.value)):
            found.append(event.stamp - sampled)
            sampled = None
    return found


def passed_through() -> list[float]:
    """(STEPS,) of a link that is told full output all the time: what the stick allows goes through."""
    with JoystickBench() as bench:
        link, ended = JoystickLink(bench.port), threading.Event()
        link.calibrate(CALIBRATION)

        def command() -> None:
            while not ended.wait(0.05):
                link.command(1.0, 0.0)

        thread = threading.Thread(target=command, daemon=True)
        thread.start()
        bench.trace()
        chance = np.random.default_rng(1)
        for _ in range(STEPS):
            bench.set_stick(CENTRE, CENTRE)
            time.sleep(0.25 + 0.02 * chance.random())
            bench.set_stick(AHEAD, CENTRE)
            time.sleep(0.06)
        ended.set()
        thread.join()
        link.close()
        return answers(bench.take_events(), lambda code: code >= NEARLY_FULL)


class Pulses:
    """A driver who pushes the stick ahead and lets it go, again and again."""

    def reset(self, seed: int) -> None:
        pass

    def act(self, stamp: float, pose: Pose2, twist: Twist2, in_contact: bool) -> DriverInput:
        forward = float(stamp % (HELD + LET_GO) >= LET_GO)
        return DriverInput(np.array([forward, 0.0]), np.array([forward, 0.0]))


def assisted(name: str, seed: int) -> list[float]:
    """(PULSES,) of a drive with an assistant through a simulated home."""
    with JoystickBench() as bench, BenchWorld(bench, home(), Pulses(), seed) as world:
        link = JoystickLink(bench.port)
        link.calibrate(CALIBRATION)
        chair = LinkedChair(link, CountedWay(WHEELS), world, world.geometry())
        bench.trace()
        world.ask_neutral(False)
        time.sleep(0.1 * np.random.default_rng(seed).random())

        def ended(tick: Tick) -> bool:
            return tick.stamp >= PULSES * (HELD + LET_GO)

        drive(chair, assistant_maker(name)(chair.geometry), ended)
        link.close()
        return answers(bench.take_events(), lambda code: abs(code - CALIBRATION.outputs[0][1]) > MOVED)


def tell(name: str, seconds: list[float]) -> None:
    took = 1000 * np.array(seconds)
    print(
        f"{name:12} n {len(took):4}  median {np.median(took):6.1f} ms  p99 {np.percentile(took, 99):6.1f} ms  "
        f"most {took.max():6.1f} ms",
        flush=True,
    )


def main() -> None:
    print("ADC sample to DAC write, the chip's own time")
    through = passed_through()
    assert len(through) >= 0.98 * STEPS, f"{len(through)} of {STEPS} steps of the stick came through"
    tell("pass-through", through)
    for name in (*NAMED, str(PRIMITIVES), str(HEATMAPS)):
        took = [each for seed in range(DRIVES) for each in assisted(name, seed)]
        assert len(took) >= 0.5 * PULSES * DRIVES, f"{name} answered {len(took)} pulses of the stick"
        tell(name.rpartition("/")[2].removesuffix(".safetensors"), took)


if __name__ == "__main__":
    main()
