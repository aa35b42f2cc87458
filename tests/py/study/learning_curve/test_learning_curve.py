"""How much demonstration is enough: what is compared, what an interval stands for, models found again."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lfdcore.datasets import open_log
from lfdcore.study.arms import StudyModels
from lfdcore.study.learning_curve import models
from lfdcore.study.learning_curve.closed_loop import drives_of
from lfdcore.study.learning_curve.curve import LearningCurve
from lfdcore.study.learning_curve.models import learn_curve_models, model_files, models_folder
from lfdcore.study.learning_curve.pictures import curve_figure
from lfdcore.study.learning_curve.report import curve_headline, curve_table, findings, run_learning_curve
from lfdcore.study.learning_curve.study import LearningCurveStudy
from lfdcore.study.prediction.path_error import path_errors, path_samples, straight
from lfdcore.study.study import write_study
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.primitives.model import DriveAssistantModel

TINY = LearningCurveStudy(runs=(1, 2), drivers=1, predicted=1, every=20, epochs=1, most_epochs=1, seed=6, processes=1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("curve")


@pytest.fixture(scope="module")
def curve(folder: Path) -> LearningCurve:
    return run_learning_curve(TINY, folder)


def test_every_model_and_nobody_meets_the_same_driver_way_and_noise(curve: LearningCurve) -> None:
    seen = [(row["demonstrations"], row["assistant"]) for row in curve.rows]
    assert seen == [(0, "none"), (1, "primitives"), (1, "heatmaps"), (2, "primitives"), (2, "heatmaps")]
    assert {(row["course"], row["seed"]) for row in curve.rows} == {(curve.rows[0]["course"], 6600)}
    assert all(np.isfinite(row["path_rmse"]) for row in curve.rows[1:])


def test_each_driver_has_a_way_and_a_seed_of_its_own() -> None:
    jobs = drives_of(replace(TINY, drivers=4), "none", StudyModels())
    assert [job.seed for job in jobs] == [6600, 6601, 6602, 6603]
    assert len({tuple(job.course.route[-1]) for job in jobs}) == 4


def test_models_are_of_the_first_n_runs(curve: LearningCurve, folder: Path) -> None:
    for n in (1, 2):
        files = model_files(curve.study, folder, n)
        names = [open_log(models_folder(curve.study, folder) / f"maze-{k:02d}.mcap").name for k in range(n)]
        primitives, heatmaps = files.file("primitives"), files.file("heatmaps")
        assert primitives and DriveAssistantModel.load(primitives).metadata["logs"] == names
        assert heatmaps and HeatmapModel.load(heatmaps).metadata["logs"] == names


def test_predicted_paths_are_judged_at_the_same_scans_beside_baselines(curve: LearningCurve, folder: Path) -> None:
    assert len(curve.errors) == 2 + 4 and len({(row["log"], row["samples"]) for row in curve.errors}) == 1
    samples = path_samples(open_log(models_folder(curve.study, folder) / "home-00.mcap"))
    on = path_errors(straight(samples.velocity), samples.driven, 2.5)[::20].mean()
    assert curve.errors[0]["method"] == "straight" and curve.errors[0]["error"] == pytest.approx(on)
    assert all(0 < row["error"] < 2.5 for row in curve.errors)


def test_a_second_study_learns_nothing_anew(
    curve: LearningCurve, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: Any) -> None:
        raise AssertionError("demonstrated again")

    monkeypatch.setattr(models, "demonstrate_in_mazes", refuse)
    learn_curve_models(curve.study, folder, refuse)
    with pytest.raises(AssertionError, match="demonstrated again"):
        learn_curve_models(replace(curve.study, runs=(1, 3)), folder)


def test_table_plot_and_report_show_every_point_with_n_and_seeds(curve: LearningCurve, tmp_path: Path) -> None:
    table = curve_table(curve)
    assert [row[1] for row in table.rows] == ["-", "1", "2", "1", "2", "-"]
    assert "seeds 6000..6001" in table.note and "n = 1 simulated impaired drivers" in table.note
    figure = curve_figure(curve)
    assert len(figure.axes) == 5
    report = write_study(curve.study, findings(curve), tmp_path)
    assert "lfdcore study learning-curve -o out --runs 1,2 --drivers 1 --seed 6" in report.read_text()
    assert len(json.loads((tmp_path / "figures.json").read_text())["rows"]) == 5 + 6
    assert (tmp_path / "learning-curve.png").read_bytes().startswith(b"\x89PNG")


def made_up() -> LearningCurve:
    def row(n: int, arm: str, completed: bool, jerk: float, hits: int) -> dict[str, Any]:
        found = {"demonstrations": n, "assistant": arm, "completed": completed, "angular_jerk": jerk, "time": 10 * jerk}
        return {**found, "collisions": hits, **({} if n == 0 else {"path_rmse": jerk / 10})}

    rows = [row(0, "none", True, 1.0, 2), row(0, "none", True, 2.0, 1), row(0, "none", False, 9.0, 0)]
    for arm in ("primitives", "heatmaps"):
        rows += [row(5, arm, True, 0.5, 1), row(5, arm, True, 0.5, 0), row(5, arm, True, 0.5, 0)]
    errors = [{"demonstrations": n, "method": m, "log": "a", "samples": 1, "error": e} for n, m, e in ERRORS]
    return LearningCurve(LearningCurveStudy(runs=(5,), drivers=3), tuple(rows), tuple(errors))


ERRORS = ((0, "straight", 0.4), (0, "constant arc", 0.3), (5, "primitives", 0.25), (5, "heatmaps", 0.2))


def test_a_ratio_is_over_drivers_who_arrived_with_and_without() -> None:
    nobody, primitives, _ = made_up().points()
    assert primitives.jerk_ratio.n == 2 and primitives.jerk_ratio.mean == pytest.approx((0.5 + 0.25) / 2)
    assert nobody.completed == (2, 3) and nobody.contacts == 3 and nobody.path_rmse.n == 0
    assert primitives.contact_rate[0] == pytest.approx(1 / 3) and primitives.contact_rate[2] < 2
    assert made_up().baseline()[0] == "constant arc"


def test_the_headline_says_errors_and_arrivals_beside_the_better_baseline() -> None:
    said = curve_headline(made_up())
    assert "With 5 runs demonstrated" in said and "(constant arc: 0.300 m)" in said
    assert "0.250 m by primitives, 0.200 m by heatmaps" in said
    assert "Of 3 impaired drivers arrive 3 with primitives, 3 with heatmaps, 2 unassisted." in said


def test_few_runs_are_learned_for_as_many_steps_as_all_within_a_bound() -> None:
    study = LearningCurveStudy()
    assert [study.epochs_of(n) for n in study.runs] == [40, 40, 36, 18, 10]
    fewer = LearningCurveStudy(epochs=3)
    files, others = (model_files(one, Path(), 72) for one in (study, fewer))
    assert files.file("heatmaps") != others.file("heatmaps")  # none is taken for the other


@pytest.mark.parametrize("runs", [(), (0,), (5, 5), (10, 5), (5, 73)])
def test_runs_that_there_are_not_are_refused(runs: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"increasing numbers within 1\.\.72"):
        LearningCurveStudy(runs=runs)
    with pytest.raises(ValueError, match="drivers is 0, must be at least 1"):
        LearningCurveStudy(drivers=0)
    with pytest.raises(ValueError, match=r"predicted is 31 runs, must be 1\.\.30"):
        LearningCurveStudy(predicted=31)
