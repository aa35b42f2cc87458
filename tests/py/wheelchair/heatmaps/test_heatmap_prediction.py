"""Paths predicted from heatmaps: the rule against one computed cell by cell, what predicts nothing, and compliance."""

import dataclasses

import numpy as np
import pytest

from lfdcore.errors import DataError
from lfdcore.geometry import MotionLimits, Twist2
from lfdcore.grid import LaserScan, local_grid
from lfdcore.planning import arc_orientation, joystick_orientation
from lfdcore.wheelchair.heatmaps.path import heatmap_path
from lfdcore.wheelchair.heatmaps.planner import HeatmapPlanner, HeatmapPlannerConfig
from lfdcore.wheelchair.heatmaps.prediction import HeatmapPathPredictor, HeatmapPredictionConfig
from lfdcore.wheelchair.models import load_model
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.stick import full_deflection_of
from lfdcore.wheelchair.window import cell_centres
from synthetic_drive import AHEAD, LEFT, T_BASE_LASER, scan_at


@pytest.fixture(scope="module")
def model(heatmap_model):
    return load_model(heatmap_model)


@pytest.fixture(scope="module")
def predictor(model):
    return HeatmapPathPredictor(model)


def test_the_heat_is_that_of_the_rule_computed_cell_by_cell(model, predictor):
    scan = scan_at(5.5, 0, 0.2)
    heat = predictor.heat(LEFT, scan, T_BASE_LASER)
    sensor = model.sensor.predict(local_grid(scan, T_BASE_LASER).data == 0)
    meant = joystick_orientation(*model.joystick.predict(LEFT)).mean
    full = full_deflection_of(model)
    limits = MotionLimits(max_linear=full.linear, max_reverse=full.linear, max_angular=full.angular)
    for iy, ix in np.random.default_rng(1).integers((0, 62), (100, 100), size=(40, 2)):
        centre = cell_centres()[iy, ix]
        beside = arc_orientation(centre, limits) - meant
        sd = 0.25 + 0.1 * np.hypot(*centre)
        wanted = float(sensor[iy, ix]) ** 1.5 * np.exp(-0.5 * (beside / sd) ** 2)
        assert heat[iy, ix] == pytest.approx(wanted, rel=0.2, abs=1e-6)  # the template is a fan of arcs


def test_the_path_is_the_median_of_the_heat(predictor):
    scan = scan_at(5.5, 0, 0.2)
    path = predictor.predict(LEFT, scan, T_BASE_LASER)
    assert path.shape == (26, 2)
    np.testing.assert_array_equal(path, heatmap_path(predictor.heat(LEFT, scan, T_BASE_LASER)))


def test_the_stick_bends_the_path_to_its_side(predictor):
    scan = scan_at(2.0, 0, 0)
    left, ahead, right = (predictor.predict(np.array(s), scan, T_BASE_LASER) for s in ((0.5, 0.5), AHEAD, (0.5, -0.5)))
    assert left[-1, 1] > ahead[-1, 1] > right[-1, 1]


@pytest.mark.parametrize("stick", [(0.0, 0.0), (-0.5, 0.0), (-0.5, 0.4)])
def test_a_stick_at_rest_or_pulled_back_predicts_nothing(predictor, stick):
    assert predictor.predict(np.array(stick), scan_at(2.0, 0, 0), T_BASE_LASER) is None


@pytest.mark.parametrize("ranges", [np.zeros(181), np.full(181, np.nan)])
def test_a_scan_that_sees_nothing_predicts_nothing(predictor, ranges):
    blind = LaserScan(ranges.astype(np.float32), -np.pi / 2, np.pi / 180, 0.0, 30.0)
    assert predictor.predict(AHEAD, blind, T_BASE_LASER) is None


def test_a_stick_out_of_range_is_refused(predictor):
    with pytest.raises(ValueError, match="joystick is"):
        predictor.predict(np.array([2.0, 0.0]), scan_at(2.0, 0, 0), T_BASE_LASER)


def test_compliance_is_the_planner_s(model, predictor):
    full = full_deflection_of(model)
    limits = MotionLimits(max_linear=full.linear, max_reverse=full.linear, max_angular=full.angular)
    planner = HeatmapPlanner(model, HeatmapPlannerConfig(), dataclasses.replace(ChairGeometry.thesis(), limits=limits))
    points = np.random.default_rng(2).uniform(-0.8, 0.8, (30, 2))
    for stick in (AHEAD, LEFT):
        np.testing.assert_allclose(predictor.compliances(points, stick), planner.compliances(points, stick))
    assert not predictor.compliances(points, np.zeros(2)).any()


def test_full_deflection_of_several_demonstrations_is_their_geometric_mean(model):
    said = dataclasses.replace(model, metadata={"full_deflection": [[1.0, 2.0], [4.0, 0.5]]})
    assert [*full_deflection_of(said)] == pytest.approx([2.0, 1.0])
    assert full_deflection_of(dataclasses.replace(model, metadata={})) is None
    assert isinstance(full_deflection_of(model), Twist2)


@pytest.mark.parametrize("wrong", [[[0.0, 1.0]], [[np.nan, 1.0]], "fast", [[1.0, 2.0, 3.0]], {"a": 1}])
def test_a_full_deflection_that_is_no_pair_of_speeds_is_refused(model, wrong):
    with pytest.raises(DataError, match="full_deflection"):
        HeatmapPathPredictor(dataclasses.replace(model, metadata={"full_deflection": wrong}))


@pytest.mark.parametrize("wrong", [{"sharpness": 0.0}, {"sharpness": np.nan}, {"sd": 0.0}, {"sd_per_metre": -1.0}])
def test_a_config_that_cannot_be_used_is_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        HeatmapPredictionConfig(**wrong)
