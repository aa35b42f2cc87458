"""ONNX that nobody here wrote: refused when it is loaded, in one line, without a word on standard output or error."""

import json

import numpy as np
import pytest
from onnx import TensorProto, helper, numpy_helper

from lfdcore.errors import ModelError
from lfdcore.wheelchair.heatmaps import sensor as sensor_heatmap
from lfdcore.wheelchair.heatmaps.sensor import SensorHeatmap

SAID = {"kind": "sensor", "version": 1, "resolution": 0.05, "cells": 100, "frame": "base_link"}
WINDOW = [1, 1, 100, 100]


def network(*nodes: tuple, said: str | None = None, **constants: object) -> bytes:
    """nodes: (operator, inputs, outputs), attributes in a fourth part"""
    made = [helper.make_node(n[0], n[1], n[2], **(n[3] if len(n) > 3 else {})) for n in nodes]
    weights = [numpy_helper.from_array(np.asarray(value), name) for name, value in constants.items()]
    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, WINDOW) for name in ("free", "heatmap")]
    graph = helper.make_graph(made, "heatmap", ends[:1], ends[1:], weights)
    domains = [helper.make_opsetid("", 17), helper.make_opsetid("elsewhere", 1)]
    model = helper.make_model(graph, opset_imports=domains, ir_version=8)
    helper.set_model_props(model, {"lfdcore": json.dumps(SAID) if said is None else said})
    return bytes(model.SerializeToString())


SIGMOID = ("Sigmoid", ["free"], ["heatmap"])
HOSTILE = {
    "an operator of nobody": network(("Foo", ["free"], ["heatmap"], {"domain": "elsewhere"})),
    "negative heat": network(("Sub", ["free", "one"], ["heatmap"]), one=np.float32(1)),
    "minus infinity": network(("Log", ["free"], ["heatmap"])),
    "NaN": network(("Div", ["free", "zero"], ["heatmap"]), zero=np.float32(0)),
    "4 TB": network(
        ("ConstantOfShape", ["size"], ["much"]),
        ("ReduceSum", ["much"], ["sum"], {"keepdims": 0}),
        ("Add", ["free", "sum"], ["heatmap"]),
        size=np.array([10**6, 10**6]),
    ),
    "weights of another rank": network(("Conv", ["free", "w"], ["heatmap"]), w=np.zeros(12, np.float32)),
    "metadata nested too deep": network(SIGMOID, said="[" * 100_000),
    "metadata that are no text": network(SIGMOID).replace(b"base_link", b"\xf2ase_link"),
}


def test_what_is_refused_below_would_be_taken_without_its_fault():
    assert SensorHeatmap(network(SIGMOID)).predict(np.ones((100, 100), bool)).max() == 1


@pytest.mark.parametrize("fault", HOSTILE)
def test_a_network_that_cannot_be_run_is_refused_when_loaded_and_in_one_line(fault, capfd):
    with pytest.raises(ModelError) as refused:
        SensorHeatmap(HOSTILE[fault])
    assert "\n" not in str(refused.value)
    assert capfd.readouterr() == ("", "")  # `--json` is read by machines


def test_a_network_that_never_ends_is_refused(monkeypatch):
    monkeypatch.setattr(sensor_heatmap, "_PATIENCE", 0.2)
    value = helper.make_tensor_value_info
    inputs = [
        value("i", TensorProto.INT64, []),
        value("go", TensorProto.BOOL, []),
        value("x", TensorProto.FLOAT, WINDOW),
    ]
    outputs = [value("on", TensorProto.BOOL, []), value("y", TensorProto.FLOAT, WINDOW)]
    nodes = [helper.make_node("Identity", ["go"], ["on"]), helper.make_node("Identity", ["x"], ["y"])]
    body = helper.make_graph(nodes, "body", inputs, outputs)
    loop = ("Loop", ["count", "true", "free"], ["heatmap"], {"body": body})
    with pytest.raises(ModelError, match="cannot be run"):
        SensorHeatmap(network(loop, count=np.int64(2**60), true=np.bool_(True)))
