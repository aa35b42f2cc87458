"""Heatmaps from trained networks (Sec. 4.3, 4.6.2) through onnxruntime; torch is not needed.

`SensorHeatmap` takes the free space that a scan sees, `NaiveHeatmap` the joystick beside it. Both give a heatmap
(100, 100) in [0, 1], divided by its maximum. Models come from lfdcore.training.parts.heatmap_net.
"""

from __future__ import annotations

import json
import threading
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lfdcore.errors import ModelError
from lfdcore.wheelchair.window import CELLS, RESOLUTION

VERSION = 1
"""of what the model means; counts changes that an older reader cannot use"""
METADATA_KEY = "lfdcore"
INPUT, OUTPUT = "free", "heatmap"
HALF = CELLS // 2
_PATIENCE = 10.0
"""[s] that a network may take for its first heatmap; ours takes milliseconds."""
Images = NDArray[np.float32]
Heatmap = NDArray[np.float32]


def naive_images(free: NDArray[Any], joystick: NDArray[np.floating]) -> Images:
    """Fig. 4.15a: the naive net's input. free (N, 100, 100), joystick (N, 2) forward, left in [-1, 1] -> (N, 100, 100).

    The two quarters behind base_link hold the axes squashed to (0, 1): the left rear (iy >= 50) how far the stick is
    pushed to the left, the right rear how far forward. What a scanner sees there is lost.
    """
    images = np.array(free, np.float32)
    _fill_rear(images, joystick)
    return images


def _fill_rear(images: Images, joystick: NDArray[np.floating]) -> None:
    images[:, :HALF, :HALF] = (joystick[:, 0, None, None] + 1) / 2
    images[:, HALF:, :HALF] = (joystick[:, 1, None, None] + 1) / 2


class _Network:
    """An onnxruntime session with its buffers: one thread, nothing allocated while it runs but the answer."""

    kind: ClassVar[str]

    def __init__(self, onnx_bytes: bytes) -> None:
        self.onnx_bytes = bytes(onnx_bytes)
        self.session = _session(self.onnx_bytes)
        self.metadata = _metadata(self.session, self.kind)
        """what the trainer said: kind, version, resolution, cells, frame, config, data_hash"""
        shape = (1, 1, CELLS, CELLS)
        self._input, self._output = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
        self._binding = self.session.io_binding()
        self._binding.bind_input(INPUT, "cpu", 0, np.float32, shape, self._input.ctypes.data)
        self._binding.bind_output(OUTPUT, "cpu", 0, np.float32, shape, self._output.ctypes.data)
        self._try()

    def _try(self) -> None:
        """What cannot be run, or does not end, is refused when it is loaded, not on the way."""
        import onnxruntime

        options = onnxruntime.RunOptions()
        watch = threading.Timer(_PATIENCE, setattr, (options, "terminate", True))
        watch.daemon = True
        watch.start()
        try:
            self._run(options)
        finally:
            watch.cancel()

    def _run(self, options: Any = None) -> Heatmap:
        try:
            self.session.run_with_iobinding(self._binding, options)
        except Exception as broken:  # onnxruntime's exceptions share no base
            raise ModelError(f"the {self.kind} heatmap's network cannot be run: {_first_line(broken)}") from broken
        heatmap = self._output[0, 0]
        least, most = heatmap.min(), heatmap.max()
        if not (least >= 0 and most < np.inf):  # NaN neither
            raise ModelError(f"the {self.kind} heatmap is {least} .. {most}: the model is damaged")
        return np.asarray(heatmap / most if most > 0 else heatmap.copy())

    def __reduce__(self) -> tuple[type[_Network], tuple[bytes]]:
        return type(self), (self.onnx_bytes,)


class SensorHeatmap(_Network):
    """The sensor heatmap of Sec. 4.3. ModelError for bytes that are no such model, or one of another kind, version,
    resolution or size. Not to be shared between threads: it owns its buffers."""

    kind = "sensor"

    def predict(self, free: NDArray[np.bool_]) -> Heatmap:
        """free (100, 100): cells that the scan sees free -> (100, 100) in [0, 1]; all 0 if it sees none."""
        if not _checked(free).any():
            return np.zeros((CELLS, CELLS), np.float32)
        self._input[0, 0] = free
        return self._run()


class NaiveHeatmap(_Network):
    """The naive net of Sec. 4.6.2. Errors and threads as for SensorHeatmap."""

    kind = "naive"

    def predict(self, free: NDArray[np.bool_], joystick: NDArray[np.floating]) -> Heatmap:
        """free (100, 100), joystick (2,) forward, left in [-1, 1] -> (100, 100) in [0, 1]; all 0 if the scan sees no
        free cell. ValueError for a stick out of range."""
        stick = np.asarray(joystick, np.float32)
        if stick.shape != (2,) or not (np.abs(stick) <= 1 + 1e-6).all():  # NaN is not
            raise ValueError(f"joystick is {joystick}, must be (forward, left), each in [-1, 1]")
        if not _checked(free).any():
            return np.zeros((CELLS, CELLS), np.float32)
        self._input[0, 0] = free
        _fill_rear(self._input[0], stick[None])
        return self._run()


def _checked(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    if free.shape != (CELLS, CELLS) or free.dtype != np.bool_:
        raise ValueError(f"free is {free.dtype} of shape {free.shape}, must be bool ({CELLS}, {CELLS})")
    return free


def _session(onnx_bytes: bytes) -> Any:
    import onnxruntime

    onnxruntime.set_default_logger_severity(4)  # what is wrong is said by the exception
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    try:
        # without its fallback, which is the same provider again, and prints to standard output
        return onnxruntime.InferenceSession(
            onnx_bytes, options, providers=["CPUExecutionProvider"], enable_fallback=False
        )
    except Exception as broken:
        raise ModelError(f"{len(onnx_bytes)} bytes are no ONNX model or are damaged: {_first_line(broken)}") from broken


def _first_line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__


def _metadata(session: Any, kind: str) -> dict[str, Any]:
    try:
        said = json.loads(session.get_modelmeta().custom_metadata_map.get(METADATA_KEY, "null"))
    except (ValueError, RecursionError) as broken:
        raise ModelError(f"the heatmap model's metadata are damaged: {broken}") from broken
    if not isinstance(said, dict):
        raise ModelError("the ONNX model says nothing of lfdcore: no heatmap model")
    needed = {"kind": kind, "version": VERSION, "resolution": RESOLUTION, "cells": CELLS, "frame": "base_link"}
    for name, value in needed.items():
        if said.get(name) != value:
            raise ModelError(f"the heatmap model has {name} {said.get(name)}, must be {value}")
    shapes = [(part.name, part.type, part.shape) for part in (*session.get_inputs(), *session.get_outputs())]
    wanted = [(name, "tensor(float)", [1, 1, CELLS, CELLS]) for name in (INPUT, OUTPUT)]
    if shapes != wanted:
        raise ModelError(f"the heatmap model takes and gives {shapes}, must be {wanted}")
    return said
