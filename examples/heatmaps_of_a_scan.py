"""The heatmaps of one scan and stick, a call each and a plot: python examples/heatmaps_of_a_scan.py MODEL LOG [SECOND]

MODEL comes from `lfdcore learn drive LOG... --method heatmaps -o MODEL`; shown is the first scan from SECOND on at
which the stick is held. Writes heatmaps.png.
"""

import sys
from itertools import dropwhile

import numpy as np
from matplotlib.figure import Figure

from lfdcore.datasets import joystick_from_motion, open_log
from lfdcore.grid import local_grid
from lfdcore.pictures.window import draw_stick, draw_window, front_axes
from lfdcore.planning import MovementTemplate, joystick_orientation, user_heatmap
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.observation import ChairGeometry, observations
from lfdcore.wheelchair.window import WINDOW

model = HeatmapModel.load(sys.argv[1])
log = joystick_from_motion(open_log(sys.argv[2]))  # a recorded joystick is left alone
second = float(sys.argv[3]) if len(sys.argv) > 3 else 5.0
now = next(dropwhile(lambda o: o.stamp < second or not any(o.joystick), observations(log)), None)
if now is None:
    sys.exit(f"{log.name}: the stick is never held from {second} s on")
chair = ChairGeometry.thesis(log.mounting)

free = local_grid(now.scan, now.scan_mounting(chair.T_base_laser)).data == 0  # what the scan sees free
sensor = model.sensor.predict(free)  # where drivers go in such a place (Sec. 4.3)
wanted = joystick_orientation(*model.joystick.predict(np.array(now.joystick)))  # what the driver means (Eq. 4.1-4.2)
if wanted is None:
    sys.exit(f"{log.name}: the stick {now.joystick} at {now.stamp:.1f} s is taken to mean none")
user = user_heatmap(MovementTemplate(chair.limits), wanted).heatmap  # where that leads (Eq. 4.3)
heatmaps = {"seen free": free, "sensor": sensor, "user": user, "product": sensor * user}

figure = Figure(figsize=(11, 3.2), layout="compressed")
for axes, (name, heat) in zip(figure.subplots(1, 4, sharey=True), heatmaps.items(), strict=True):
    draw_window(axes, heat.astype(float))
    draw_stick(axes, now.joystick)
    front_axes(axes, -WINDOW, WINDOW)
    axes.set_title(name)
    axes.label_outer()
figure.savefig("heatmaps.png", dpi=120)
stick, meant = (np.degrees(angle) for angle in (np.arctan2(*now.joystick[::-1]), wanted.mean))
print(f"heatmaps.png: {log.name} at {now.stamp:.1f} s, stick at {stick:.0f} degrees, taken to mean {meant:.0f}")
