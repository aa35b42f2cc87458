"""From the stick to the controller's voltage: the firmware on a simulated chip, a link that passes the stick through.

Time is the chip's own. The answer is checked: the DAC gets what the stick says. The simulation is paced by the wall
clock, so a loaded machine shows as a slow PC.
"""

from __future__ import annotations

import threading
import time

import numpy as np

from lfdcore.hardware import JoystickLink
from lfdcore.simulated.bench_world import CALIBRATION
from lfdcore.simulated.joystick_bench import JoystickBench

STEPS = 300
CENTRE, AHEAD = 512 / 1023 * 5, 824 / 1023 * 5
NEARLY_FULL = 0.98 * CALIBRATION.outputs[0][2]
"""[code]: the stick is read to a count of 312"""


def pass_through(link: JoystickLink, ended: threading.Event) -> None:
    while not ended.wait(0.05):
        link.command(1.0, 0.0)


def latencies(bench: JoystickBench) -> np.ndarray:
    """(STEPS,) [s] from before the stick moves to the DAC's first code of full output"""
    found = []
    chance = np.random.default_rng(1)
    for _ in range(STEPS):
        bench.set_stick(CENTRE, CENTRE)
        time.sleep(0.05 + 0.02 * chance.random())
        bench.take_events()
        before = bench.outputs().stamp
        bench.set_stick(AHEAD, CENTRE)
        time.sleep(0.06)
        given = [
            event.stamp for event in bench.take_events() if event.what == "dac0" and float(event.value) >= NEARLY_FULL
        ]
        assert given, "the DAC did not get full output within 60 ms"
        found.append(given[0] - before)
    return np.array(found)


def main() -> None:
    with JoystickBench() as bench:
        link = JoystickLink(bench.port)
        link.calibrate(CALIBRATION)
        bench.trace()
        ended = threading.Event()
        thread = threading.Thread(target=pass_through, args=(link, ended), daemon=True)
        thread.start()
        time.sleep(1.0)
        took = 1000 * latencies(bench)
        ended.set()
        thread.join()
        link.close()
    print(
        f"stick to DAC, {STEPS} steps: median {np.median(took):.1f} ms, p99 {np.percentile(took, 99):.1f} ms, "
        f"most {took.max():.1f} ms (up to 10 ms of it until the stick is read)"
    )


if __name__ == "__main__":
    main()
