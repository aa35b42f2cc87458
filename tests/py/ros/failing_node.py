"""A node whose assistant breaks, or hangs for two seconds, once the robot moves."""

import sys
import time

from lfdcore.geometry import Pose2
from lfdcore.ros.node import drive_node
from lfdcore.ros.options import NodeOptions
from lfdcore.wheelchair.assistants import Supervised
from lfdcore.wheelchair.observation import Assistance, Observation

MOVING_TICKS = 10


class Failing(Supervised):
    moved = 0

    def update(self, observation: Observation) -> Assistance:
        said = super().update(observation)
        self.moved += said.command.angular != 0
        if self.moved == MOVING_TICKS:
            self.moved += 1
            fail()
        return said


def fail() -> None:
    print(sys.argv[1], flush=True)
    if sys.argv[1] == "breaks":
        raise RuntimeError("broken on purpose")
    time.sleep(2)
    print("goes on", flush=True)


drive_node(Failing, NodeOptions(mounting=Pose2(0.7, 0.0, 0.0)))
