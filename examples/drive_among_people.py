"""A driver who sees nobody drives through a home in which people walk to and fro; then the first scan that shows three.

python examples/drive_among_people.py [SEED] prints whom the chair met, unassisted and with the supervisor alone, and
writes people.png.
"""

import sys

from lfdcore.geometry import Twist2
from lfdcore.pictures.people import people_figure
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import ImpairedDriver
from lfdcore.simulated.people import People, PeopleConfig
from lfdcore.simulated.run import RunConfig, run_drive
from lfdcore.simulation import DrivingWorld
from lfdcore.study.arms import StudyModels, make_assistant

seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
course, run = home(0), RunConfig(people=PeopleConfig(count=12))
for arm in ("none", "supervisor"):
    trace = run_drive(course, ImpairedDriver(course), make_assistant(arm, StudyModels(), run), seed, run)
    met = trace.people_met
    print(
        f"{arm:10}  {trace.outcome:9}  {trace.stamp[-1]:5.1f} s  {trace.collision.sum()} contacts with walls"
        f"  {len(met)} with people: {sum(m.foreseeable for m in met)} by the moving nose after a second's warning,"
        f" {sum(m.walked_into_standing_chair for m in met)} walked into the standing chair"
    )

world = DrivingWorld(course.grid, seed=seed)
world.reset(course.start)
people = People(course.grid, PeopleConfig(count=12), (course.start.x, course.start.y), seed)
while sum(world.people_in_scan()) < 3:
    world.set_people(people.walk(0.1))
    world.step(Twist2(), 0.1)
people_figure(course.grid, world).savefig("people.png", dpi=120, metadata={"Software": None})
