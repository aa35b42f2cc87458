"""Sec. 4.3, 4.6.2: training the heatmaps' networks and running them without torch."""

import dataclasses
import json

import numpy as np
import onnx
import pytest
import torch

from heatmap_drives import around_the_corner
from lfdcore.errors import ModelError
from lfdcore.training.parts.heatmap_net import HeatmapNet, HeatmapNetConfig, export_onnx, train_heatmap_net
from lfdcore.training.parts.heatmap_targets import HeatmapPairs, HeatmapTargetConfig, heatmap_pairs
from lfdcore.wheelchair.heatmaps.sensor import NaiveHeatmap, SensorHeatmap, naive_images

SMALL = HeatmapNetConfig(width=4, epochs=2, batch=16)


@pytest.mark.parametrize("width", [4, 24])
def test_onnxruntime_gives_what_torch_gives_to_1e_5(width):
    torch.manual_seed(3)
    net = HeatmapNet(width)
    runtime = SensorHeatmap(export_onnx(net, "sensor", {}))
    free = np.random.default_rng(1).random((100, 100)) < 0.6
    with torch.no_grad():
        there = torch.sigmoid(net(torch.from_numpy(free[None, None].astype(np.float32))))[0, 0].numpy()
    np.testing.assert_allclose(runtime.predict(free), there / there.max(), atol=1e-5)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(pairs):
    one, again = (train_heatmap_net(pairs, SMALL) for _ in range(2))
    other = train_heatmap_net(pairs, dataclasses.replace(SMALL, seed=1))
    assert one.onnx == again.onnx
    assert one.curve == again.curve
    assert one.onnx != other.onnx


def test_training_leaves_torch_as_it_was(pairs):
    before = torch.get_num_threads(), torch.are_deterministic_algorithms_enabled(), torch.random.get_rng_state()
    train_heatmap_net(pairs, SMALL)
    assert (torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()) == before[:2]
    assert torch.equal(torch.random.get_rng_state(), before[2])


def test_it_learns_where_ways_lead_in_runs_never_trained_on(pairs, trained):
    """The heat of cells on the ways is far above that of other free cells; at chance both are equal."""
    net = SensorHeatmap(trained.onnx)
    for k in np.flatnonzero(trained.validation)[::5]:
        heat, target = net.predict(pairs.free[k]), pairs.target[k].astype(float)
        assert heat[target > 0.3].mean() > 4 * heat[pairs.free[k] & (target == 0)].mean()
    assert trained.best.validation < 0.5 * trained.curve[0].validation


def test_validation_runs_are_whole_runs_never_trained_on(pairs, trained):
    held, kept = set(pairs.log[trained.validation]), set(pairs.log[~trained.validation])
    assert held and kept and not held & kept


def test_of_a_single_run_the_last_scans_validate(pairs):
    one = pairs.take(pairs.log == 0)
    held = train_heatmap_net(one, SMALL).validation
    assert held.any() and held[np.argmax(held) :].all()
    two = train_heatmap_net(one.take(np.array([0, 9])), SMALL)
    np.testing.assert_array_equal(two.validation, [False, True])
    with pytest.raises(ValueError, match="1 training pairs, at least 2"):
        train_heatmap_net(one.take(np.array([0])), SMALL)


def test_it_stops_when_the_validation_loss_no_longer_falls_and_keeps_the_best(pairs):
    rng = np.random.default_rng(0)
    noise = dataclasses.replace(pairs, target=rng.random(pairs.target.shape).astype(np.float16))
    found = train_heatmap_net(noise, HeatmapNetConfig(width=8, epochs=60, batch=8, learning_rate=3e-2, patience=1))
    assert len(found.curve) < 60
    assert found.best == min(found.curve, key=lambda epoch: epoch.validation)
    assert found.curve[-1].epoch == found.best.epoch + 1


def test_progress_grows_to_its_total(pairs):
    reported = []
    train_heatmap_net(pairs, SMALL, lambda done, total: reported.append((done, total)))
    done = [k for k, _ in reported]
    assert done == sorted(done) and reported[-1][0] == reported[-1][1]


def test_a_loss_that_is_no_number_is_said(pairs):
    with pytest.raises(ValueError, match="learning_rate 1e\\+30 is too large"):
        train_heatmap_net(pairs, dataclasses.replace(SMALL, learning_rate=1e30))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kind": "both"}, "kind is 'both'"),
        ({"width": 7}, "width is 7 channels"),
        ({"epochs": 0}, "epochs is 0"),
        ({"learning_rate": float("nan")}, "learning_rate nan"),
        ({"validation": 1.0}, "validation is a share of 1.0"),
    ],
)
def test_a_config_that_cannot_be_trained_is_refused(changes, said):
    with pytest.raises(ValueError, match=said):
        HeatmapNetConfig(**changes)


def test_a_validation_that_leaves_nothing_is_refused(pairs):
    for mask in (np.zeros(len(pairs), bool), np.ones(len(pairs), bool)):
        with pytest.raises(ValueError, match="must be at least 1 and not all"):
            train_heatmap_net(pairs, SMALL, validation=mask)
    with pytest.raises(ValueError, match="validation has shape"):
        train_heatmap_net(pairs, SMALL, validation=np.ones(3, bool))


def test_the_naive_net_sees_the_stick_in_the_rear_quarters():
    image = naive_images(np.ones((1, 100, 100), bool), np.array([[1.0, -0.5]]))[0]
    assert (image[:, 50:] == 1).all()
    assert (image[:50, :50] == 1.0).all()  # right rear: forward 1
    assert (image[50:, :50] == 0.25).all()  # left rear: left -.5


def test_the_naive_net_tells_left_from_right_by_the_stick_alone():
    """Trained on one scan with the stick to the left and a way to the left; mirroring adds the right."""
    free, n = heatmap_pairs([around_the_corner()], HeatmapTargetConfig(spacing=1.0)).free[:1], 48
    way = np.zeros((n, 100, 100), np.float16)
    way[:, 60:90, 65:90] = 1
    stick = np.tile(np.float32([0.5, 1.0]), (n, 1))
    pairs = HeatmapPairs(np.repeat(free, n, 0), way, stick, np.arange(n) % 2, np.arange(n))
    config = HeatmapNetConfig(kind="naive", width=8, epochs=20, batch=4, learning_rate=1e-2, patience=20)
    net = NaiveHeatmap(train_heatmap_net(pairs, config).onnx)
    for left in (1.0, -1.0):
        heat = net.predict(free[0], np.array([0.5, left]))
        sides = heat[65:75, 72:78].mean(), heat[25:35, 72:78].mean()
        assert sides[left < 0] > 3 * sides[left > 0]


def test_a_naive_net_without_a_joystick_is_refused(pairs):
    still = dataclasses.replace(pairs, joystick=np.zeros_like(pairs.joystick))
    with pytest.raises(ValueError, match="nothing to learn"):
        train_heatmap_net(still, dataclasses.replace(SMALL, kind="naive"))


def test_the_model_says_what_it_is_and_nothing_of_the_machine(trained):
    said = SensorHeatmap(trained.onnx).metadata
    assert (said["kind"], said["version"], said["cells"], said["frame"]) == ("sensor", 1, 100, "base_link")
    assert said["config"]["width"] == 8 and len(said["data_hash"]) == 64
    assert b"/home" not in trained.onnx and b".py" not in trained.onnx


def changed(model, **changes):
    proto = onnx.load_from_string(model)
    said = json.loads(proto.metadata_props[0].value) | changes
    del proto.metadata_props[:]
    onnx.helper.set_model_props(proto, {"lfdcore": json.dumps(said)})
    return proto.SerializeToString()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"resolution": 0.1}, "resolution 0.1, must be 0.05"),
        ({"cells": 50}, "cells 50, must be 100"),
        ({"version": 2}, "version 2, must be 1"),
        ({"frame": "map"}, "frame map, must be base_link"),
        ({"kind": "naive"}, "kind naive, must be sensor"),
    ],
)
def test_a_model_for_another_window_or_version_is_refused(trained, changes, said):
    with pytest.raises(ModelError, match=said):
        SensorHeatmap(changed(trained.onnx, **changes))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
def test_a_model_cut_short_is_refused_in_one_line(trained, share):
    with pytest.raises(ModelError) as refused:
        SensorHeatmap(trained.onnx[: int(share * len(trained.onnx))])
    assert "\n" not in str(refused.value)


def test_an_onnx_model_of_something_else_is_refused(trained):
    proto = onnx.load_from_string(trained.onnx)
    del proto.metadata_props[:]
    with pytest.raises(ModelError, match="nothing of lfdcore"):
        SensorHeatmap(proto.SerializeToString())


def test_a_model_that_gives_no_numbers_is_refused(trained):
    proto = onnx.load_from_string(trained.onnx)
    weights = next(w for w in proto.graph.initializer if w.name == "last.bias")
    weights.CopyFrom(onnx.numpy_helper.from_array(np.full(4, np.nan, np.float32), "last.bias"))
    with pytest.raises(ModelError, match="damaged"):
        SensorHeatmap(proto.SerializeToString()).predict(np.ones((100, 100), bool))


def test_answers_are_heatmaps_of_their_own(trained):
    net = SensorHeatmap(trained.onnx)
    first = net.predict(np.ones((100, 100), bool))
    kept = first.copy()
    net.predict(np.random.default_rng(0).random((100, 100)) < 0.5)
    np.testing.assert_array_equal(first, kept)
    assert first.dtype == np.float32 and first.max() == 1 and first.min() >= 0


def test_a_scan_that_sees_nothing_gives_an_all_zero_heatmap(trained):
    heat = SensorHeatmap(trained.onnx).predict(np.zeros((100, 100), bool))
    assert heat.shape == (100, 100) and not heat.any()


@pytest.mark.parametrize("free", [np.ones((50, 50), bool), np.ones((100, 100)), np.ones((1, 100, 100), bool)])
def test_another_window_is_refused(trained, free):
    with pytest.raises(ValueError, match=r"must be bool \(100, 100\)"):
        SensorHeatmap(trained.onnx).predict(free)


@pytest.mark.parametrize("stick", [[2.0, 0.0], [np.nan, 0.0], [1.0]])
def test_a_stick_out_of_range_is_refused(stick):
    net = NaiveHeatmap(export_onnx(HeatmapNet(4), "naive", {}))
    with pytest.raises(ValueError, match=r"each in \[-1, 1\]"):
        net.predict(np.ones((100, 100), bool), np.array(stick))
