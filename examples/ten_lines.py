"""Learn from the first 70 % of a drive, then assist its driver on the rest: python examples/ten_lines.py LOG"""

import sys

from lfdcore.datasets import joystick_from_motion, open_log
from lfdcore.training.drive_primitives import learn_drive
from lfdcore.wheelchair.assistants import DriveAssistant
from lfdcore.wheelchair.observation import observations

log = joystick_from_motion(open_log(sys.argv[1]))  # a recorded joystick is left alone
assistant = DriveAssistant(learn_drive([log.share(0, 0.7)]).planner())
for observation in observations(log.share(0.7, 1)):
    answer = assistant.update(observation)  # command, path, goal (the intention), mode (who decided), ...
    print(f"{observation.stamp:7.1f} s  {answer.mode:8} {answer.command}  goal {answer.goal}")
