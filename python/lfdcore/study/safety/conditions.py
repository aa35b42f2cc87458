"""In what a chair may be worse than it should be, and what of that is promised (docs/safety.md)."""

from __future__ import annotations

from dataclasses import dataclass, field

from lfdcore.simulated.chair import ScannerFaults
from lfdcore.simulated.people import PeopleConfig
from lfdcore.simulated.run import RunConfig
from lfdcore.simulated.unsteady_clock import TickFaults
from lfdcore.simulation import ChairConfig, LidarConfig


@dataclass(frozen=True)
class Condition:
    """A chair, its scanner, who walks about, and the loop's ticks."""

    run: RunConfig
    promised: bool
    """whether no collision with what stands is promised there"""
    ticks: TickFaults = field(default_factory=TickFaults)


def _scanner(faults: ScannerFaults | None = None, beams: int = 181, noise_sd: float = 0.01) -> RunConfig:
    return RunConfig(lidar=LidarConfig(beams=beams, noise_sd=noise_sd), scanner=faults or ScannerFaults())


def _slipping(share: float) -> RunConfig:
    return RunConfig(chair=ChairConfig(linear_slip=share, angular_slip=share))


FOOT = ScannerFaults(foot=(0.70, 0.27))
"""Beside the scanner: the five beams farthest to the left end on it, 8 to 10 cm inside the outline"""
LATE = TickFaults(jitter=0.05, late=0.2, late_share=0.005)
"""All of it is promised. Ticks that jitter by half a period find the command still held. One in 200 comes .2 s later:
then the command has ended, and the chair brakes as the supervisor has tested."""


def _late(latency: float) -> RunConfig:
    return RunConfig(chair=ChairConfig(command_latency=latency))


CONDITIONS = {
    "as declared": Condition(RunConfig(), True),
    "5 % slip": Condition(_slipping(0.05), True),
    "10 % slip": Condition(_slipping(0.10), False),
    "latency .1 s": Condition(_late(0.1), True),
    "latency .3 s": Condition(_late(0.3), True),
    "noise 3 cm": Condition(_scanner(noise_sd=0.03), True),
    "noise 6 cm": Condition(_scanner(noise_sd=0.06), False),
    "10 % of beams dropped": Condition(_scanner(ScannerFaults(dropped=0.1)), True),
    "20 beams": Condition(_scanner(beams=20), False),
    "5 Hz scans": Condition(_scanner(ScannerFaults(period=0.2)), True),
    "5 Hz commands": Condition(RunConfig(period=0.2), True),
    "20 Hz commands": Condition(RunConfig(period=0.05), True),
    "a point inside the outline": Condition(_scanner(FOOT), True),
    "late ticks": Condition(RunConfig(), True, LATE),
    "12 people": Condition(RunConfig(people=PeopleConfig()), True),
}
"""The assistant knows of each what its chair declares: latency, periods of commands and scans, noise and slip. It knows
nothing of what is dropped, of the foot, of ticks to come, nor of who walks there."""
