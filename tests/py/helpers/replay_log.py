"""What a real chair would run: replays a drive log through a fresh assistant, in a process without a world.

python replay_log.py MODEL LOG -> one line a scan: stamp, linear and angular command, mode, whether a path was made.
"""

import sys
from dataclasses import replace
from pathlib import Path

from lfdcore import _core, simulation

del _core.simulation.DrivingWorld, simulation.DrivingWorld  # whoever asks for a world fails

from lfdcore.datasets import open_log  # noqa: E402
from lfdcore.wheelchair.assistants import DriveAssistant  # noqa: E402
from lfdcore.wheelchair.observation import ChairGeometry, observations  # noqa: E402
from lfdcore.wheelchair.primitives.model import DriveAssistantModel  # noqa: E402

CHAIR = replace(ChairGeometry.thesis(), latency=0.0, odometry_error=0.0)  # of the simulated chair


def main(model: str, log: str) -> None:
    assistant = DriveAssistant(DriveAssistantModel.load(Path(model)).planner(CHAIR))
    for seen in observations(open_log(Path(log))):
        said = assistant.update(seen)
        print(repr(seen.stamp), *map(repr, said.command), said.mode, said.planned)
    above = ("lfdcore.study", "lfdcore.simulated", "lfdcore.training")
    known = [name for name in sys.modules if name.startswith(above)]
    if known:
        sys.exit(f"the assistant imported {known}")


if __name__ == "__main__":
    main(*sys.argv[1:])
