"""Predict where a driver is going along a real log, against two baselines: python examples/predict_a_log.py LOG

Learns from the first 70 % of the log's scans and predicts on the rest; the metric is that of
lfdcore.study.prediction.path_error.
"""

import sys

import numpy as np

from lfdcore.datasets import joystick_from_motion, open_log
from lfdcore.study.prediction.path_error import (
    REACHES,
    at_arc_lengths,
    constant_arc,
    path_errors,
    path_samples,
    straight,
)
from lfdcore.training.drive_primitives import learn_drive

log = joystick_from_motion(open_log(sys.argv[1]))
predictor = learn_drive([log.share(0, 0.7)]).predictor()
rest = log.share(0.7, 1)
samples = path_samples(rest)
stick = rest.joystick_at(rest.scan_stamp[samples.scan])
learned = []
for scan, joystick, fallback in zip(samples.scan, stick, constant_arc(samples.velocity), strict=True):
    path = predictor.predict(joystick, rest.scan(scan), rest.T_base_laser)
    learned.append(fallback if path is None else at_arc_lengths(path))  # nothing likely: the present arc
predictions = {
    "learned": np.reshape(learned, samples.driven.shape),
    "constant arc": constant_arc(samples.velocity),
    "straight on": straight(samples.velocity),
}
print(f"{len(samples)} samples; mean and median error [m] over " + ", ".join(f"{reach} m" for reach in REACHES))
for name, paths in predictions.items():
    errors = [path_errors(paths, samples.driven, reach) for reach in REACHES]
    print(f"{name:14}" + "".join(f"{e.mean():8.3f} {np.median(e):6.3f}" for e in errors))
