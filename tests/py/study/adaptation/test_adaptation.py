"""On-line adaptation to the driver, in the closed loop (Sec. 6.2.1)."""

import math
from pathlib import Path

import numpy as np
import pytest

from lfdcore.errors import ModelError
from lfdcore.geometry import Twist2
from lfdcore.simulated.biased_driver import BiasedDriver
from lfdcore.simulated.courses import office
from lfdcore.simulation import DrivingWorld
from lfdcore.study.adaptation.pictures import adaptation_figure
from lfdcore.study.adaptation.report import adaptation_table, findings, ratio_rows
from lfdcore.study.adaptation.study import (
    STAGES,
    AdaptationRun,
    AdaptationStudy,
    angle_errors,
    pooled_ratio,
    run_adaptation_study,
)
from lfdcore.study.compare import compare
from lfdcore.study.study import as_document
from lfdcore.wheelchair.adaptive_assistant import AdaptationConfig, AdaptiveAssistant, SteeringOffset
from lfdcore.wheelchair.assistants import DriveAssistant
from lfdcore.wheelchair.heatmaps.model import HeatmapModel
from lfdcore.wheelchair.observation import ChairGeometry
from observed import observed

CHAIR = ChairGeometry.thesis()


@pytest.fixture(scope="module")
def model(heatmap_model: Path) -> HeatmapModel:
    return HeatmapModel.load(heatmap_model)


@pytest.fixture(scope="module")
def runs(heatmap_model: Path) -> tuple[AdaptationRun, ...]:
    """Of the whole study one driver of each kind, with a network that has seen little and corrects little."""
    study = AdaptationStudy(courses=("office",), model=heatmap_model, biases=(0.0, -0.3), drivers=1, processes=1)
    return run_adaptation_study(study, heatmap_model.parent)


def test_while_adapting_the_error_of_a_biased_driver_falls_and_that_of_an_unbiased_one_stays_small(
    runs: tuple[AdaptationRun, ...],
) -> None:
    unbiased, biased = runs
    assert biased.mean("adapting") < 0.9 * biased.mean("before")  # after 60 s this weak network may know nothing yet
    assert (
        unbiased.mean("adapting") < unbiased.mean("before") + 0.05
    )  # of one drive; over drivers the study's table tells
    assert all(run.collisions == 0 for run in runs)


def test_the_table_has_a_row_a_bias_with_ratios_of_means(runs: tuple[AdaptationRun, ...]) -> None:
    table = adaptation_table(runs)
    assert [row[0] for row in table.rows] == ["-0.30", "+0.00"]
    assert [row[-1] for row in table.rows] == ["<= 0.7", "<= 1.05"]
    ratio = pooled_ratio(runs[1:], "adapting")
    assert ratio == pytest.approx(runs[1].mean("adapting") / runs[1].mean("before"))
    assert table.rows[0][-2].startswith(f"{ratio:.2f}")
    assert ("MISSED" in table.rows[0][-2]) == (ratio > 0.7)
    assert ratio_rows(runs)[0]["ratio_adapting"] == pytest.approx(ratio)


def test_the_picture_has_a_panel_a_bias_and_judges_what_is_kept_only_later(runs: tuple[AdaptationRun, ...]) -> None:
    panels = adaptation_figure(runs).axes
    assert len(panels) == 2
    before, then, adapting = panels[0].get_lines()[:3]
    np.testing.assert_array_equal(before.get_xdata(), adapting.get_xdata())
    assert min(then.get_xdata()) > 60.0 > min(before.get_xdata())
    drawn = max(float(np.nanmax(line.get_ydata())) for axes in panels for line in axes.get_lines()[:3])
    assert panels[0].get_ylim()[0] == 0 and panels[0].get_ylim()[1] > drawn


def test_the_findings_say_ratios_and_aims_of_each_bias_and_hold_every_run(runs: tuple[AdaptationRun, ...]) -> None:
    found = findings(runs)
    assert [aim.found for aim in found.aims] == [pooled_ratio([run], s) for run in runs[::-1] for s in STAGES[1:]]
    assert [aim.wanted for aim in found.aims] == ["<= 0.7", "<= 0.7", "<= 1.05", "<= 1.05"]
    assert list(found.rows[:2]) == [run.row() for run in runs]
    assert [(row["bias"], row["n"]) for row in found.rows[2:]] == [(-0.3, 1), (0.0, 1)]
    assert f"{pooled_ratio(runs[1:], 'adapting'):.2f} (bias -0.30 rad)" in found.headline
    assert f"{pooled_ratio(runs[:1], 'adapting'):.2f} (no bias)" in found.headline and "seeds 1..1" in found.headline


def test_two_reports_are_compared_by_what_was_measured_alone(runs: tuple[AdaptationRun, ...]) -> None:
    document = as_document(AdaptationStudy(), findings(runs))
    measured = {"collisions", "ticks", *STAGES, *(f"ratio_{stage}" for stage in STAGES[1:])}
    assert {one.figure for one in compare(document, document)} == measured


def test_a_drive_that_ends_before_it_is_judged_is_refused(heatmap_model: Path, tmp_path: Path) -> None:
    study = AdaptationStudy(courses=("hall",), model=heatmap_model, biases=(0.0,), drivers=1, after=300.0, processes=1)
    with pytest.raises(ValueError, match=r"drive of hall took \d+ s, must be over 300"):
        run_adaptation_study(study, tmp_path)


def test_angle_errors_go_across_the_rear_too() -> None:
    wanted, meant = np.array([[-1.0, 0.1], [1.0, 0.0]]), np.array([[-1.0, -0.1], [0.0, 1.0]])
    np.testing.assert_allclose(angle_errors(wanted, meant), [2 * math.atan(0.1), math.pi / 2])


def closed_loop(bias: float, ticks: int, share: float, noise: float = 0.0) -> SteeringOffset:
    """Places correct `share` of what the model does not know of a bias; the rest of the way follows the model."""
    offset, rng = SteeringOffset(AdaptationConfig()), np.random.default_rng(1)
    for _ in range(ticks):
        known = offset.turn
        shown = -share * bias + (1 - share) * known
        offset.add(shown + noise * rng.standard_normal(), known)
    return offset


def test_of_a_bias_the_turn_is_learned_that_undoes_it() -> None:
    for bias in (0.3, -0.3, 0.2):
        learned = closed_loop(bias, 3000, AdaptationConfig().corrected_share).turn
        assert learned == pytest.approx(-bias, rel=0.25)


def test_what_chance_explains_is_no_bias() -> None:
    assert closed_loop(0.0, 3000, 0.22, noise=0.28).turn == 0.0
    assert closed_loop(0.3, 10, 0.22).turn == 0.0  # too soon


def test_earlier_pairs_are_understood_anew(model: HeatmapModel) -> None:
    """A model kept after a minute must not hold what was believed before."""
    assistant = AdaptiveAssistant(model, CHAIR)
    drive(assistant, 300)
    own, turn = assistant.adapter.own, assistant.turn
    there = own.count > 0.5
    wanted, raw = (own.raw + own.target)[there], own.raw[there]
    angles = np.arctan2(wanted[:, 1], wanted[:, 0]) - np.arctan2(raw[:, 1], raw[:, 0])
    assert np.abs(np.angle(np.exp(1j * angles)) - turn).max() < 0.05  # the last pair came after the last word


def test_the_turn_is_bounded_whatever_is_followed() -> None:
    offset = SteeringOffset(AdaptationConfig())
    for _ in range(2000):
        offset.add(3.0, 0.0)
    assert offset.turn == AdaptationConfig().largest_turn


@pytest.mark.parametrize(("turn", "ticks"), [(0.2, 500.0), (-0.4, 1000.0), (0.0, 0.0)])
def test_a_turn_is_resumed(turn: float, ticks: float) -> None:
    offset = SteeringOffset(AdaptationConfig())
    offset.resume(turn, ticks)
    assert offset.turn == pytest.approx(turn)


@pytest.mark.parametrize("name", ["chance", "corrected_share", "steepest"])
def test_a_configuration_out_of_bounds_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is 0"):
        AdaptationConfig(**{name: 0.0})
    with pytest.raises(ValueError, match="memory is 0"):
        AdaptationConfig(memory=0)


def drive(assistant: AdaptiveAssistant | DriveAssistant, ticks: int, bias: float = 0.3) -> list[tuple[float, float]]:
    course, world = office(), DrivingWorld(office().grid, seed=1)
    world.reset(course.start)
    driver, commands = BiasedDriver(course, bias), []
    for tick in range(ticks):
        given = driver.act(tick / 10, world.state.pose, world.state.twist, world.state.in_contact).joystick
        pose = world.odometry
        seen = observed(tick / 10, world.scan(), (float(given[0]), float(given[1])), pose=pose)
        commands.append(tuple(assistant.update(seen).command))
        world.step(Twist2(*commands[-1]), 0.1)
    return commands


def test_until_it_has_learned_it_drives_as_the_assistant_it_wraps(model: HeatmapModel) -> None:
    assert drive(AdaptiveAssistant(model, CHAIR), 10) == drive(DriveAssistant(model.planner(CHAIR)), 10)


def test_a_driver_is_kept_over_drives_saved_resumed_and_forgotten(model: HeatmapModel, tmp_path: Path) -> None:
    assistant, file = AdaptiveAssistant(model, CHAIR), tmp_path / "driver.safetensors"
    drive(assistant, 300)
    assistant.reset()
    adapted, turn = assistant.adapter.model, assistant.turn
    assert assistant.planner.joystick.predict((0.7, 0.2)) == adapted.predict((0.7, 0.2))
    assert adapted is not model.joystick
    assistant.save_driver(file)
    other = AdaptiveAssistant(model, CHAIR)
    other.resume_driver(file)
    assert other.planner.joystick is other.adapter.model
    assert other.turn == pytest.approx(turn, abs=0.1)  # recalled from the pairs, which hold the last half minute
    assistant.forget_driver()
    assert assistant.planner.joystick is model.joystick and assistant.turn == 0.0


def test_a_file_that_holds_no_driver_changes_nothing(model: HeatmapModel, heatmap_model: Path) -> None:
    assistant = AdaptiveAssistant(model, CHAIR)
    with pytest.raises(ModelError):
        assistant.resume_driver(heatmap_model)
    assert assistant.planner.joystick is model.joystick


def test_a_stick_at_rest_and_a_stale_scan_teach_nothing(model: HeatmapModel) -> None:
    assistant, world = AdaptiveAssistant(model, CHAIR), DrivingWorld(office().grid, seed=1)
    world.reset(office().start)
    scan = world.scan()
    assistant.update(observed(0.0, scan, (0.0, 0.0)))
    assistant.update(observed(1.0, scan, (0.5, 0.0), scan_stamp=0.0))
    assert assistant.adapter.own.count.sum() == 0


def test_memory_is_bounded_by_the_bins(model: HeatmapModel) -> None:
    assistant = AdaptiveAssistant(model, CHAIR)
    drive(assistant, 200)
    assert assistant.adapter.own.count.shape == (100,)
    assert assistant.adapter.own.count.sum() <= assistant.adaptation.adapter.memory + 1
