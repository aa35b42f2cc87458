"""A driver who can only steer roughly goes through a doorway and docks at a table, with and without assistance.

python examples/drive_a_course.py [SEED]
"""

import sys
import tempfile
from pathlib import Path

from lfdcore.geometry import Pose2
from lfdcore.simulated.courses import doorway_and_docking
from lfdcore.simulated.drivers import ImpairedDriver
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.study.arms import StudyModels, make_assistant
from lfdcore.study.demonstrations import learn_from_demonstrations
from lfdcore.study.driving.metrics import driving_metrics

seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
task = doorway_and_docking(seed)
run = RunConfig()
with tempfile.TemporaryDirectory() as folder:
    # an expert drives three routes through a simulated home
    models = StudyModels(primitives=learn_from_demonstrations(Path(folder), seed))
    for arm in ("none", "dwa", "primitives"):
        trace = run_drive(task.course, ImpairedDriver(task.course), make_assistant(arm, models, run), seed, run)
        metrics = driving_metrics(trace)
        docked = task.reached(Pose2(*trace.pose[-1]))
        print(
            f"{arm:10}  {trace.outcome:9}  docked {docked!s:5}  {metrics.time:5.1f} s  {metrics.collisions} contacts"
            f"  angular jerk {metrics.angular_jerk:.2f} rad/s^3"
        )
