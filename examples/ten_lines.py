"""Learn from the first 70 % of a drive, then assist its driver on the rest: python examples/ten_lines.py LOG"""

import sys

from lfdcore.datasets import joystick_from_motion, open_log
from lfdcore.training.drive_primitives import learn_drive
from lfdcore.wheelchair.assistants import DriveAssistant
from lfdcore.wheelchair.observation import ChairGeometry, observations
from lfdcore.wheelchair.watch import WatchConfig

log = joystick_from_motion(open_log(sys.argv[1]))  # a recorded joystick is left alone
chair = ChairGeometry.thesis(log.mounting).replayed(log)  # or your own: ChairGeometry(...)
assistant = DriveAssistant(learn_drive([log.share(0, 0.7)]).planner(chair), watch=WatchConfig.of(log))
for observation in observations(log.share(0.7, 1)):
    answer = assistant.update(observation)  # command, path, goal (the intention), mode (who decided), ...
    print(f"{observation.stamp:7.1f} s  {answer.mode:8} {answer.command}  goal {answer.goal}")
