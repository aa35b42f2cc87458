"""Tables against counts done by hand; none is wider than the terminal it is laid out for."""

from dataclasses import replace
from math import comb
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from lfdcore.control import DynamicWindowConfig
from lfdcore.pictures.course import ARM_NAMES
from lfdcore.simulated.courses import campus, flat, from_map
from lfdcore.study.arms import StudyModels
from lfdcore.study.driving.aims import headline
from lfdcore.study.driving.plan import DrivingPlan, DrivingResult
from lfdcore.study.driving.report import driving_tables
from lfdcore.study.driving.tables import DRIVING, FRAMEWORK, course_labels
from lfdcore.study.driving.task_tables import task_tables
from lfdcore.study.driving.tasks import TaskPlan, TaskResult
from lfdcore.study.report.statistics import paired_proportions_test
from lfdcore.study.report.table import Table

cells = st.text(st.characters(codec="ascii", categories=("L", "N")), min_size=1, max_size=24)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    columns = draw(st.integers(1, 9))
    row = st.tuples(*[cells] * columns)
    return Table(draw(cells), draw(row), tuple(draw(st.lists(row, max_size=4))))


@given(tables(), st.integers(60, 160))
def test_no_line_is_wider_than_the_terminal_and_no_cell_is_lost(table: Table, width: int) -> None:
    text = table.as_text(width)
    assert max(map(len, text.split("\n"))) <= width
    words = text.split()
    for cell in (*table.header, *(cell for row in table.rows for cell in row)):
        assert cell in words


def test_columns_that_do_not_fit_come_below_with_the_first_one_again() -> None:
    table = Table("T", ("row", "a" * 20, "b" * 20, "c" * 20), (("x", "1", "2", "3"), ("y", "4", "5", "6")))
    text = table.as_text(50)
    assert text.count("row") == 2
    last = text.split("\n\n")[1].split("\n")
    assert [line.split() for line in last if line][2:] == [["x", "3"], ["y", "6"]]


def test_the_lines_of_a_cell_stand_below_each_other() -> None:
    text = Table("T", ("", "arm"), (("time", "12+-3\n[10, 14]"),)).as_text()
    assert text.split("\n") == ["T", "           arm", "----  --------", "time     12+-3", "      [10, 14]", ""]


def test_a_row_of_another_length_than_the_header_is_refused() -> None:
    with pytest.raises(ValueError, match="has 1 cells, must have 2"):
        Table("T", ("a", "b"), (("x",),))


ARMS = ("none", "dwa", "primitives")

HEATMAP_ARMS = ("none", "heatmaps", "primitives")
PRIMITIVES = StudyModels(primitives=Path("m"))
BOTH = StudyModels(primitives=Path("m"), heatmaps=Path("h"))


def row(arm: str, driver: int, **changes: Any) -> dict[str, Any]:
    base = {metric.key: 10.0 + driver for metric in DRIVING} | {"collisions": 0, "outcome": "completed"}
    if arm == "primitives":
        base |= {metric.key: 0.5 + driver / 100 for metric in FRAMEWORK}
    return {"course": "flat", "driver": driver, "seed": driver, "assistant": arm, **base, **changes}


def result(rows: list[dict[str, Any]], drivers: int = 5) -> DrivingResult:
    study = DrivingPlan(courses=(flat(),), models=PRIMITIVES, arms=ARMS, drivers=drivers)
    return DrivingResult(study, (), tuple(rows))


def study_rows(**of_primitives: Any) -> list[dict[str, Any]]:
    rows = []
    for driver in range(5):
        rows.append(row("none", driver, collisions=driver, angular_jerk=4.0, time=100.0 + driver))
        rows.append(row("dwa", driver, outcome="stuck" if driver == 0 else "completed"))
        rows.append(row("primitives", driver, **({"angular_jerk": 2.0, "time": 90.0 + 2 * driver} | of_primitives)))
    return rows


def cell(table: Table, label: str, column: str) -> str:
    found = next(r for r in table.rows if r[0].replace("\n", " ").startswith(label))
    return found[next(k for k, head in enumerate(table.header) if head.startswith(column))]


def named(found: list[Table], start: str) -> Table:
    return next(table for table in found if table.title.startswith(start))


def test_failures_stay_in_the_denominator_of_completion() -> None:
    driving = named(driving_tables(result(study_rows())), "Driving")
    assert cell(driving, "completed", "DWA").startswith("4 of 5\n80 %")
    assert cell(driving, "completed", "unassisted").startswith("5 of 5")


def test_collisions_are_totals_with_the_number_of_drivers_who_had_any() -> None:
    driving = named(driving_tables(result(study_rows())), "Driving")
    assert cell(driving, "collisions", "unassisted") == "10\n4 of 5 drivers"
    assert cell(driving, "collisions", "thesis") == "5 -> 0"


def test_a_metric_shows_mean_sd_interval_and_the_paired_p_beside_the_thesis() -> None:
    driving = named(driving_tables(result(study_rows())), "Driving")
    times = np.array([90.0, 92, 94, 96, 98])
    half = stats.t.ppf(0.975, 4) * times.std(ddof=1) / np.sqrt(5)
    expected = f"94+-{times.std(ddof=1):.0f}\n[{94 - half:.0f}, {94 + half:.0f}]"
    assert cell(driving, "time taken", "primitives") == expected
    p = stats.wilcoxon(times - (100.0 + np.arange(5))).pvalue
    assert next(r for r in driving.rows if r[0].startswith("time"))[5] == f"{p:.3f}"
    assert cell(driving, "time taken", "thesis") == "166+-25\n-> 146+-16"


def test_missing_values_are_left_out_and_the_n_says_so() -> None:
    rows = study_rows()
    rows[0]["mean_free_speed"] = float("nan")
    driving = named(driving_tables(result(rows)), "Driving")
    assert cell(driving, "mean free speed", "unassisted").endswith("\nn 4")


def test_the_driving_table_of_three_arms_fits_120_columns_in_one_piece() -> None:
    for table in driving_tables(result(study_rows())):
        text = table.as_text()
        assert max(map(len, text.split("\n"))) <= 120
        assert "\n\n" not in text.rstrip("\n")


def test_a_figure_that_was_not_reached_is_called_missed() -> None:
    aims = named(driving_tables(result(study_rows(angular_jerk=2.6, path_rmse=0.03))), "Figures to reach")
    assert cell(aims, "angular jerk", "flat") == "0.65\nMISSED"
    assert cell(aims, "path RMSE", "flat") == "0.030\nreached"
    assert cell(aims, "time", "flat") == "0.92\nreached"
    assert "flat\n(tuning)" in aims.header


def test_a_figure_that_could_not_be_measured_is_missed() -> None:
    aims = named(driving_tables(result(study_rows(path_rmse=float("nan")))), "Figures to reach")
    assert cell(aims, "path RMSE", "flat") == "-\nMISSED"


def test_without_the_unassisted_arm_there_are_no_figures_to_reach() -> None:
    rows = [r for r in study_rows() if r["assistant"] != "none"]
    study = DrivingPlan(courses=(flat(),), models=PRIMITIVES, arms=("dwa", "primitives"), drivers=5)
    titles = [table.title for table in driving_tables(DrivingResult(study, (), tuple(rows)))]
    assert not any(title.startswith("Figures to reach") for title in titles)


def test_the_learned_arm_has_one_name_in_all_tables() -> None:
    for table in driving_tables(result(study_rows())):
        heads = [" ".join(head.split("\n")) for head in table.header]
        assert ARM_NAMES["primitives"] in table.title + " ".join(heads)
        assert "assisted (" not in table.as_text()


def test_the_thesis_columns_say_which_of_its_experiments_they_are_of() -> None:
    found = driving_tables(result(study_rows()))
    assert named(found, "Driving").header[-1] == "thesis,\nCh. 3"
    framework = named(found, "Framework")
    assert framework.header[-2:] == ("thesis,\nsimulated", "thesis,\nreal")
    assert framework.rows[0][-2:] == ("0.87+-0.11", "0.88+-0.09")


def test_heatmaps_stand_beside_table_4_1_and_are_to_halve_the_jerk() -> None:
    rows = [r | {"assistant": "heatmaps"} if r["assistant"] == "dwa" else r for r in study_rows()]
    study = DrivingPlan(courses=(flat(),), models=BOTH, arms=HEATMAP_ARMS, drivers=5)
    of_both = driving_tables(DrivingResult(study, (), tuple(rows)))
    driving = named(of_both, "Driving")
    assert "Table 3.1 and 4.1" in driving.title
    assert cell(driving, "time taken", "thesis,\nCh. 4") == "162+-22\n-> 150+-20"
    aims = next(t for t in of_both if t.title.startswith(f"Figures to reach, {ARM_NAMES['heatmaps']}"))
    assert [row[1] for row in aims.rows] == ["0", ">= 0.95", "<= 0.5", "<= 1"]
    assert cell(aims, "completed", "flat") == "0.80\nMISSED"


def test_the_campus_stands_beside_the_thesis_real_course() -> None:
    rows = [r | {"course": campus().name} for r in study_rows()]
    study = DrivingPlan(courses=(campus(),), models=PRIMITIVES, arms=ARMS, drivers=5)
    driving = named(driving_tables(DrivingResult(study, (), tuple(rows))), "Driving")
    assert "Table 3.2" in driving.title
    assert driving.header[-1] == "thesis,\nreal"
    assert cell(driving, "collisions", "thesis") == "8 -> 0"
    assert cell(driving, "time taken", "thesis") == "566\n-> 252"


def test_ratios_are_over_the_drivers_who_completed_in_both_arms() -> None:
    rows = study_rows(angular_jerk=2.0, time=80.0)
    of_primitives = [r for r in rows if r["assistant"] == "primitives"]
    unassisted = [r for r in rows if r["assistant"] == "none"]
    of_primitives[0] |= {"outcome": "stuck", "time": 1.0, "angular_jerk": 0.0}
    unassisted[1] |= {"outcome": "time_out", "time": 900.0, "angular_jerk": 50.0}
    aims = named(driving_tables(result(rows)), "Figures to reach")
    assert cell(aims, "time", "flat") == f"{80 / 103:.2f}\nreached\nn 3"  # drivers 2, 3, 4 took 102, 103, 104 s
    assert cell(aims, "angular jerk", "flat") == "0.50\nreached\nn 3"
    assert "completed in both arms" in aims.note


def test_a_ratio_without_a_pair_that_completed_in_both_arms_is_missed() -> None:
    aims = named(driving_tables(result(study_rows(outcome="stuck"))), "Figures to reach")
    assert cell(aims, "time", "flat") == "-\nMISSED\nn 0"


def test_no_interval_leaves_what_is_possible() -> None:
    """Two drivers, one of whom was never stuck: Student's intervals would reach from below 0 to above 1."""
    rows = [
        r
        | {"stuck": 0.9 * k, "reversals": 5 * k, "supervised": 1.0 * k, "time": 1.0 + 300 * k, "obedience": 0.5 + k / 2}
        for k in range(2)
        for r in study_rows()[3 * k : 3 * k + 3]
    ]
    found = driving_tables(result(rows, drivers=2))
    assert not any("[-" in table.as_text() for table in found)
    assert cell(named(found, "Driving"), "share of time stuck", "unassisted").endswith("[0.000, 0.900]")
    assert cell(named(found, "Framework"), "user obedience", "primitives").endswith("[0.50, 1.00]")


def test_what_was_not_measured_is_a_dash_that_the_note_explains() -> None:
    rows = [r | {"steering_entropy_fixed": float("nan")} for r in study_rows()]
    driving = named(driving_tables(result(rows)), "Driving")
    assert next(r for r in driving.rows if "fixed" in r[0])[1:] == ("-", "-", "-", "-", "-", "")
    assert "'-': not measured" in driving.note
    assert "nan" not in driving.as_text()
    assert "'-'" not in named(driving_tables(result(study_rows())), "Driving").note


def test_tables_leave_out_the_seed_of_a_random_route_unless_two_would_be_called_the_same() -> None:
    one, two = (from_map(flat().grid, seed, length=5.0, name="wide_depot") for seed in (5001, 5002))
    assert one.name == "wide_depot-5001"
    assert course_labels([one, flat()]) == {one.name: "wide_depot", "flat": "flat"}
    assert course_labels([one, two]) == {one.name: one.name, two.name: two.name}
    rows = [r | {"course": one.name} for r in study_rows()]
    study = DrivingPlan(courses=(one,), models=PRIMITIVES, arms=ARMS, drivers=5)
    for table in driving_tables(DrivingResult(study, (), tuple(rows))):
        assert "wide_depot" in table.as_text()
        assert "5001" not in table.as_text()


def test_the_headline_counts_the_learned_arm_against_the_unassisted_one() -> None:
    rows = study_rows()
    rows[0]["outcome"] = "stuck"
    said = headline(result(rows))
    assert said.startswith(
        "primitives (learned): 0 collisions, 5 of 5 runs completed; unassisted: 10 collisions, 4 of 5"
    )
    assert "Angular jerk / unassisted: 0.50 (flat)." in said
    assert said.endswith("n = 5 simulated impaired drivers a course, seeds 1..5.")


def test_the_headline_names_every_learned_arm() -> None:
    rows = study_rows()
    more = [row | {"assistant": "heatmaps"} for row in rows if row["assistant"] == "primitives"]
    study = DrivingPlan(courses=(flat(),), models=BOTH, arms=(*ARMS, "heatmaps"), drivers=5)
    said = headline(DrivingResult(study, (), (*rows, *more)))
    assert said.startswith(
        "primitives (learned): 0 collisions, 5 of 5 runs completed; heatmaps (learned): 0 collisions"
    )
    assert "Angular jerk / unassisted: primitives (learned) 0.50 (flat); heatmaps (learned) 0.50 (flat)." in said


def test_the_headline_does_without_arms_that_were_not_driven() -> None:
    study = DrivingPlan(courses=(flat(),), models=PRIMITIVES, arms=("none",), drivers=5)
    rows = tuple(r for r in study_rows() if r["assistant"] == "none")
    assert headline(DrivingResult(study, (), rows)).startswith(
        "unassisted: 10 collisions, 5 of 5 runs completed. n = 5"
    )


def task_result(successes: dict[str, int], n: int = 20) -> TaskResult:
    rows = [
        {"task": "narrow_gap", "assistant": arm, "seed": k, "success": k < good, "reached": True, "stuck": k == 0}
        | {"contacts": int(k >= good), "reversals": 2, "time": 10.0}
        for k in range(n)
        for arm, good in successes.items()
    ]
    study = TaskPlan(models=PRIMITIVES, tasks=("narrow_gap",), arms=tuple(successes), starts=n)
    return TaskResult(study, tuple(rows), (), ())


def test_task_shares_have_wilsons_interval_and_mcnemars_p() -> None:
    (table,) = task_tables(task_result({"none": 13, "dwa": 20, "primitives": 19}))
    assert cell(table, "success", "unassisted") == "13 of 20\n65 % [43, 82]"  # Wilson, by hand
    assert table.rows[0][4:] == (f"{2 * 0.5**7:.3f}", f"{2 * 0.5**6:.3f}")  # 7 and 6 gained, none lost
    assert cell(table, "stuck", "DWA") == "1 of 20\n5 % [1, 24]"


def test_a_task_says_what_reached_means_and_how_stuck_runs_ended() -> None:
    (gap,) = task_tables(task_result({"none": 13, "primitives": 19}))
    assert "the whole chair is behind the wall" in gap.note
    assert "of these runs 1 of 1 (unassisted), 1 of 1 (primitives (learned)) still reached it" in gap.note
    free = task_result({"none": 13})
    rows = tuple(r | {"task": "doorway_and_docking", "stuck": False} for r in free.rows)
    (docking,) = task_tables(TaskResult(replace(free.plan, tasks=("doorway_and_docking",)), rows, (), ()))
    assert "docked: at the end of the run the chair's outline is within 0.3 m of the table" in docking.note
    assert "still reached it" not in docking.note


def test_the_task_table_prints_the_horizon_of_dwa_only_with_dwa_in_it() -> None:
    horizon = f"{DynamicWindowConfig().horizon:g} s"
    assert horizon in task_tables(task_result({"none": 3, "dwa": 4}))[0].note
    assert "50% of the asked speed" in task_tables(task_result({"none": 3, "dwa": 4}))[0].note
    assert "horizon" not in task_tables(task_result({"none": 3, "primitives": 4}))[0].note


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=40))
def test_mcnemars_test_agrees_with_the_binomial_sum(pairs: list[tuple[bool, bool]]) -> None:
    a, b = (np.array(column) for column in zip(*pairs, strict=True))
    gained, lost = sum(y and not x for x, y in pairs), sum(x and not y for x, y in pairs)
    n, few = gained + lost, min(gained, lost)
    expected = min(1.0, 2 * sum(comb(n, k) for k in range(few + 1)) / 2**n)
    assert paired_proportions_test(a, b) == pytest.approx(expected)
    assert paired_proportions_test(b, a) == pytest.approx(expected)


def test_mcnemars_test_refuses_samples_of_unequal_length() -> None:
    with pytest.raises(ValueError, match="must be equal"):
        paired_proportions_test([True], [True, False])


def test_an_unknown_task_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="'parking', must be one of doorway_and_docking, narrow_gap"):
        TaskPlan(models=PRIMITIVES, tasks=("parking",))
