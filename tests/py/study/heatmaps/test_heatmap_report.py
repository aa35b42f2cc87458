"""The report's parts on heatmaps: captions name n and seed, the verdict says what came out, pictures can be drawn."""

import numpy as np
import pytest

from lfdcore.grid import OccupancyGrid
from lfdcore.pictures.style import png
from lfdcore.study.heatmaps.calibration import JudgedCells, check_calibration, reliability
from lfdcore.study.heatmaps.comparison import METHODS, ComparedRun, Comparison, ComparisonConfig, MethodRun
from lfdcore.study.heatmaps.pictures import median_runs
from lfdcore.study.heatmaps.report import (
    calibration_table,
    comparison_section,
    comparison_table,
    comparison_verdict,
)
from lfdcore.wheelchair.heatmaps.calibration import HeatmapCalibration


def comparison(rewards: dict[str, float], runs: int = 6) -> Comparison:
    rng = np.random.default_rng(1)
    data = np.zeros((120, 140), np.int8)
    data[:, 0] = 100
    grid = OccupancyGrid(data, 0.05, (-3.0, -3.0))
    way = np.stack([np.arange(0, 1, 0.05), np.zeros(20), np.zeros(20)], axis=1)
    made = []
    for k in range(runs):
        methods = {
            name: MethodRun(
                rng.random((120, 140)).astype(np.float32),
                rewards[name] + 0.01 * k,
                100 * rewards[name],
                *(0.1 - 0.1 * rewards[name] + 0.01 * rng.random((3, 7))),
                np.full(7, 0.01 * (1 + METHODS.index(name))),
                0.0,
            )
            for name in METHODS
        }
        made.append(ComparedRun(f"run-{k}", grid, way, methods))
    return Comparison(tuple(made), ComparisonConfig())


PRINTED = {"primitives": 0.62, "naive": 0.56, "heatmaps": 0.67}


def test_the_table_names_runs_frames_and_seed_and_gives_times_as_ratios() -> None:
    table = comparison_table(comparison(PRINTED), seed=7)
    assert "n = 6 unassisted runs, 42 frames every 0.5 s of driving, seed 7" in table.title
    assert [row[0] for row in table.rows][:2] == ["reward at positions", "its percentile rank [%]"]
    assert table.rows[0][3].startswith("0.695+-0.019\n[") and "thesis 0.67" in table.rows[0][3]
    times = table.rows[-1]
    assert times[1].startswith("0.3+-") and times[2].startswith("0.7+-") and times[3].startswith("1\n")
    assert "(driver_sd): 0 rad" in table.note
    assert table.rows[0][4] == "0.031"  # six pairs of one sign: 2 / 2^6


def test_the_verdict_says_whether_the_order_is_the_thesis_s() -> None:
    agreeing = comparison_verdict(comparison(PRINTED))
    assert agreeing.count("(as in the thesis)") == 3 and "not the thesis's" not in agreeing
    other = comparison_verdict(comparison({"primitives": 0.7, "naive": 0.5, "heatmaps": 0.6}))
    assert "By reward, best first: primitives (Ch. 3) 0.725, heatmaps (CNN/GP) 0.625, naive CNN 0.525 (not the" in other


def test_the_section_draws_three_runs_and_names_n_and_seed() -> None:
    section = comparison_section(comparison(PRINTED), seed=3)
    (picture,) = section.pictures
    assert "of 3 of 6 runs" in picture.caption and "seed 3" in picture.caption
    assert png(picture.figure)[:4] == b"\x89PNG"
    labels = [axes.get_xlabel() for axes in picture.figure.axes[:9]]
    assert labels == [""] * 6 + ["x [m]"] * 3
    assert len(median_runs(comparison(PRINTED, 2).runs)) == 2


def cells(rate: float, seed: int) -> JudgedCells:
    rng = np.random.default_rng(seed)
    heat = rng.beta(0.5, 3, 20_000).astype(np.float32)
    return JudgedCells(heat, rng.random(20_000) < rate * heat, np.arange(20_000) % 4)


def test_a_calibration_is_judged_on_other_runs_with_the_fitted_runs_rate() -> None:
    check = check_calibration(cells(0.6, 1), cells(0.6, 2))
    assert check.judged.error < 0.01 < check.raw.error
    assert check.judged.brier < min(check.judged.constant_brier, check.raw.brier)
    assert check.judged.constant_rate == pytest.approx(cells(0.6, 1).crossed.mean())
    assert len(check.errors) == check.fitted_runs == 4 and check.fitted_cells == 20_000
    said, happened = check.tenths
    assert (np.diff(said) >= 0).all() and np.abs(said - happened).max() < 0.05


def test_a_calibration_knows_nothing_of_the_runs_that_it_is_judged_on() -> None:
    fitted, judged = cells(0.6, 1), cells(0.1, 2)
    check = check_calibration(fitted, judged)
    said = HeatmapCalibration.fit(fitted.heat, fitted.crossed).probabilities(judged.heat)
    assert check.judged.error == reliability(said, judged.crossed).error > 0.05
    each = [reliability(said[judged.run == run], judged.crossed[judged.run == run]).error for run in range(4)]
    np.testing.assert_array_equal(check.errors, each)


def test_the_calibration_s_caption_names_runs_cells_and_seed_and_what_it_was_fitted_on() -> None:
    table = calibration_table(check_calibration(cells(0.6, 1), cells(0.6, 2)), seed=5)
    assert "n = 4 home runs, 20000 cells, seed 5" in table.title
    assert "Fitted on 4 maze runs (20000 cells)" in table.note
    assert [row[0] for row in table.rows] == ["calibrated heat", "constant rate", "heat itself"]
