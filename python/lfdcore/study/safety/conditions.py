"""In what a chair may be worse than it should be, and what of that is promised (docs/safety.md)."""

from __future__ import annotations

from dataclasses import dataclass

from lfdcore.simulated.chair import ScannerFaults
from lfdcore.simulated.people import PeopleConfig
from lfdcore.simulated.run import RunConfig
from lfdcore.simulation import ChairConfig, LidarConfig


@dataclass(frozen=True)
class Condition:
    """A chair, its scanner and who walks about."""

    run: RunConfig
    promised: bool
    """whether no collision with what stands is promised there"""


def _scanner(beams: int = 181, noise_sd: float = 0.01, **faults: float) -> RunConfig:
    return RunConfig(lidar=LidarConfig(beams=beams, noise_sd=noise_sd), scanner=ScannerFaults(**faults))


def _slipping(share: float) -> RunConfig:
    return RunConfig(chair=ChairConfig(linear_slip=share, angular_slip=share))


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
    "10 % of beams dropped": Condition(_scanner(dropped=0.1), True),
    "20 beams": Condition(_scanner(beams=20), False),
    "5 Hz scans": Condition(_scanner(period=0.2), True),
    "5 Hz commands": Condition(RunConfig(period=0.2), True),
    "20 Hz commands": Condition(RunConfig(period=0.05), True),
    "12 people": Condition(RunConfig(people=PeopleConfig()), True),
}
"""The assistant knows of each what its chair declares: latency, periods of commands and scans, noise and slip; not what
is dropped, nor who walks there."""
