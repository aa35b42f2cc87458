"""The ways of the same drivers through a course, without and with help: python examples/draw_assisted.py [DRIVERS]

The drivers are simulated, and their stick knows five directions. The assistant learns from three demonstrations in
another place. Writes assisted.png; with 10 drivers (the default) it is the README's picture, in a minute on 2 cores.
"""

import sys
import tempfile
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lfdcore.pictures.course import draw_grid
from lfdcore.pictures.style import CONTACT, DRIVEN
from lfdcore.simulated.courses import standard_course
from lfdcore.simulated.trace import DriveTrace
from lfdcore.study.arms import StudyModels
from lfdcore.study.demonstrations import learn_from_demonstrations
from lfdcore.study.driving.plan import DrivingPlan, run_driving_plan

SEED = 1
PANELS = {"none": "Without help", "primitives": "With help"}


def draw_ways(axes: Axes, traces: list[DriveTrace], title: str) -> None:
    """All ways in one panel, a cross where a contact begins."""
    for trace in traces:
        hits = trace.pose[trace.collision]
        axes.plot(*trace.pose[:, :2].T, color=DRIVEN, lw=1.2, alpha=0.6, label="way of a driver")
        axes.plot(*hits[:, :2].T, "X", color=CONTACT, mec="black", mew=0.9, ms=12, zorder=4, label="contact")
    contacts = sum(int(trace.collision.sum()) for trace in traces)
    axes.set_title(f"{title}: {contacts} contacts", fontsize=17)
    axes.set(xticks=[], yticks=[], xlabel="", ylabel="")
    print(f"{title}: {contacts} contacts, {sum(trace.completed for trace in traces)} of {len(traces)} completed")


drivers = int(sys.argv[1]) if len(sys.argv) > 1 else 10
course = standard_course()
with tempfile.TemporaryDirectory() as folder:
    models = StudyModels(primitives=learn_from_demonstrations(Path(folder), SEED))
    plan = DrivingPlan(courses=(course,), models=models, arms=tuple(PANELS), drivers=drivers, seed=SEED)
    result = run_driving_plan(plan)

figure = Figure(figsize=(8, 7.8), layout="compressed")
panels = figure.subplots(1, 2)
for axes, (arm, title) in zip(panels, PANELS.items(), strict=True):
    draw_grid(axes, course.grid)
    draw_ways(axes, [trace for trace in result.traces if trace.assistant == arm], title)
figure.legend(handles=panels[0].lines[:2], loc="outside lower center", ncols=2, fontsize=16, frameon=False)
figure.savefig("assisted.png", dpi=120, metadata={"Software": None})
