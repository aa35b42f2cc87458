"""The sensor heatmap's cost around onnxruntime's own run: aim <= 10 %; one thread.

Untrained weights (the time does not depend on them) of the default width. The rivals, in the same run and
interleaved: the session alone on bound buffers, and session.run() on new arrays as in onnxruntime's tutorials. Asserts
that they agree.
Run: python benchmarks/bench_sensor_heatmap.py [--runs N]
"""

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from lfdcore.training.parts.heatmap_net import HeatmapNet, HeatmapNetConfig, export_onnx
from lfdcore.wheelchair.heatmaps.sensor import INPUT, NaiveHeatmap, SensorHeatmap


def timed(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return (time.perf_counter() - start) * 1e3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=2000)
    wanted = parser.parse_args()
    net = HeatmapNet(HeatmapNetConfig().width)
    sensor, naive = (kind(export_onnx(net, kind.kind, {})) for kind in (SensorHeatmap, NaiveHeatmap))
    free = np.random.default_rng(1).random((100, 100)) < 0.5
    stick = np.array([0.5, -0.5])

    def plainly() -> np.ndarray:
        heat = sensor.session.run(None, {INPUT: free.astype(np.float32)[None, None]})[0][0, 0]
        return heat / heat.max()

    np.testing.assert_allclose(sensor.predict(free), plainly(), atol=1e-6)
    calls = {
        "session alone": lambda: sensor.session.run_with_iobinding(sensor._binding),
        "SensorHeatmap.predict": lambda: sensor.predict(free),
        "session.run, new arrays": plainly,
        "naive session alone": lambda: naive.session.run_with_iobinding(naive._binding),
        "NaiveHeatmap.predict": lambda: naive.predict(free, stick),
    }
    times = {name: np.zeros(wanted.runs) for name in calls}
    for run in range(wanted.runs):
        for name, call in calls.items():
            times[name][run] = timed(call)
    print(f"100 x 100, width {HeatmapNetConfig().width}, {wanted.runs} runs, threads=1")
    for name, spent in times.items():
        alone = times["naive session alone" if "aive" in name else "session alone"]
        over = np.median(spent - alone) / np.median(alone)  # paired: what else runs here hits both
        print(f"  {name:24} median {np.median(spent):.3f} ms, p99 {np.percentile(spent, 99):.3f} ms, over {over:+.1%}")


if __name__ == "__main__":
    main()
