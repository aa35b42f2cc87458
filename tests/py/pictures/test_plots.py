"""Pictures: what is drawn is what was driven and planned; the same input gives the same bytes."""

import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from lfdcore import __version__
from lfdcore.datasets import open_log
from lfdcore.datasets.drive_log import DriveLog
from lfdcore.geometry import Footprint
from lfdcore.grid import LaserScan
from lfdcore.pictures.course import course_figure, demonstrations_figure, every, outlines, split_plans
from lfdcore.pictures.moments import telling_moments
from lfdcore.pictures.path_primitives import bin_heading, primitives_figure
from lfdcore.pictures.path_stages import (
    example_paths,
    intention_figure,
    planning_figure,
    stage_figures,
)
from lfdcore.pictures.style import PLANNED, png
from lfdcore.simulated.courses import campus, doorway_and_docking, home
from lfdcore.simulated.drivers import ExpertDriver, ImpairedDriver
from lfdcore.simulated.run import run_drive
from lfdcore.simulated.trace import DriveTrace, Plan
from lfdcore.study.arms import StudyModels
from lfdcore.study.driving.plan import DrivingPlan
from lfdcore.study.driving.report import findings
from lfdcore.study.driving.study import DrivingStudy, WholeResult
from lfdcore.study.study import write_study
from lfdcore.training.drive_primitives import learn_drive
from lfdcore.wheelchair.assistants import DynamicWindowAssistant, Unassisted
from lfdcore.wheelchair.observation import ChairGeometry
from lfdcore.wheelchair.primitives.local_paths import LocalPaths, extract_local_paths
from lfdcore.wheelchair.primitives.model import DriveAssistantModel
from lfdcore.wheelchair.primitives.path_primitives import PathPrimitives, orientation_bin

CHAIR = ChairGeometry.thesis()


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> DriveLog:
    path = tmp_path_factory.mktemp("log") / "home.mcap"
    course = home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), 1, log_path=path)
    return open_log(path)


@pytest.fixture(scope="module")
def model(log: DriveLog) -> DriveAssistantModel:
    return learn_drive([log])


@pytest.fixture(scope="module")
def runs() -> list[DriveTrace]:
    course = doorway_and_docking(3).course
    return [
        run_drive(course, ImpairedDriver(course), arm, 3) for arm in (Unassisted(CHAIR), DynamicWindowAssistant(CHAIR))
    ]


def drive(pose: np.ndarray, plans: tuple[Plan, ...] = ()) -> DriveTrace:
    n = len(pose)
    pairs, flags = np.zeros((n, 2)), np.zeros(n, bool)
    return DriveTrace(
        "c", "d", "primitives", 1, "completed", Footprint(), np.arange(n) * 0.1, pose, pairs, pairs, pairs, pairs,
        flags, flags, np.full(n, "path"), flags, np.ones(n), pairs * np.nan, pairs * np.nan, plans,
    )  # fmt: skip


def straight(n: int = 41, step: float = 0.1) -> np.ndarray:
    return np.stack([np.arange(n) * step, np.zeros(n), np.zeros(n)], axis=1)


def shown_texts(figure: Figure) -> list[tuple[str, Bbox]]:
    png(figure)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    hidden = {text for axes in figure.axes for text in undrawn(axes)}
    texts = [text for text in set(figure.findobj(Text)) - hidden if text.get_visible() and text.get_text().strip()]
    return [(text.get_text(), text.get_window_extent(renderer)) for text in texts]


def undrawn(axes: Axes) -> set[Text]:
    """Texts of axes that are switched off, and tick labels beyond the axes' limits."""
    if not axes.axison:
        return set(axes.findobj(Text))
    outside = set()
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        outside |= {tick.label1 for tick in axis.get_major_ticks() if not low <= tick.get_loc() <= high}
    return outside


def overlapping(texts: Sequence[tuple[str, Bbox]]) -> list[tuple[str, str]]:
    def meet(a: Bbox, b: Bbox) -> bool:
        return min(a.x1, b.x1) - max(a.x0, b.x0) > 1 and min(a.y1, b.y1) - max(a.y0, b.y0) > 1

    return [(s, t) for i, (s, a) in enumerate(texts) for t, b in texts[i + 1 :] if meet(a, b)]


def test_outlines_are_the_chairs_corners_at_each_pose() -> None:
    corners = outlines(np.array([[2.0, 1.0, np.pi / 2]]), Footprint())[0]
    assert sorted(map(tuple, corners.round(6))) == [(1.65, 0.65), (1.65, 1.8), (2.35, 0.65), (2.35, 1.8)]


@given(st.floats(0.05, 3.0), st.integers(2, 200))
def test_footprints_stand_a_spacing_apart(spacing: float, n: int) -> None:
    pose = straight(n, 0.01)
    gaps = np.diff(every(pose, spacing)[:, 0])
    assert np.all(np.abs(gaps - spacing) <= 0.011)


def test_a_plan_is_followed_up_to_where_the_next_one_came_and_half_of_the_rest_is_shown_as_discarded() -> None:
    path = np.stack([np.linspace(0, 3, 31), np.zeros(31)], axis=1)
    other = path + np.array([1.0, 0.0])
    followed, discarded = split_plans(drive(straight(), (Plan(0.0, path), Plan(1.0, other))))
    assert followed[0][-1, 0] == pytest.approx(1.0)
    assert discarded[0][0, 0] == pytest.approx(1.0)
    assert discarded[0][-1, 0] == pytest.approx(2.0)
    assert followed[1][-1, 0] == pytest.approx(4.0)  # to the end of the run


def test_the_same_runs_give_the_same_bytes_whatever_the_users_style(runs: list[DriveTrace]) -> None:
    course = doorway_and_docking(3).course
    before = png(course_figure(course, runs))
    with mpl.rc_context({"font.size": 20, "axes.facecolor": "red", "savefig.dpi": 30}):
        assert png(course_figure(course, runs)) == before


def test_every_arm_has_a_panel_that_says_how_its_run_ended(runs: list[DriveTrace]) -> None:
    figure = course_figure(doorway_and_docking(3).course, runs)
    titles = [axes.get_title() for axes in figure.axes]
    hits = int(runs[0].collision.sum())
    assert titles[0].startswith(f"unassisted\n{runs[0].outcome}, {runs[0].stamp[-1]:.0f} s, {hits} contact")
    assert titles[1].startswith("DWA\n")
    assert {axes.get_aspect() for axes in figure.axes} == {1.0}


def test_no_text_of_a_course_figure_overlaps_another(runs: list[DriveTrace]) -> None:
    assert overlapping(shown_texts(course_figure(doorway_and_docking(3).course, runs))) == []


def test_wide_courses_stand_below_each_other() -> None:
    course = campus()
    way = np.column_stack([course.route, np.zeros(len(course.route))])
    first, second = course_figure(course, [drive(way)] * 2).axes
    assert first.get_subplotspec().rowspan.start < second.get_subplotspec().rowspan.start


@pytest.mark.parametrize("panels", [4, 5, 6, 8])
def test_many_arms_stand_in_rows_and_no_text_overlaps(runs: list[DriveTrace], panels: int) -> None:
    figure = course_figure(doorway_and_docking(3).course, [runs[k % 2] for k in range(panels)])
    assert len(figure.axes) == panels
    grid = figure.axes[0].get_gridspec()
    assert (grid.nrows, grid.ncols) == {4: (1, 4), 5: (2, 3), 6: (2, 3), 8: (2, 4)}[panels]
    assert [bool(axes.get_xlabel()) for axes in figure.axes[-grid.ncols :]] == [True] * grid.ncols
    assert overlapping(shown_texts(figure)) == []


def test_a_long_course_of_many_arms_is_no_column_of_panels() -> None:
    course = campus()
    way = np.column_stack([course.route, np.zeros(len(course.route))])
    figure = course_figure(course, [drive(way)] * 6)
    assert figure.axes[0].get_gridspec().ncols == 2
    assert figure.get_figheight() < 1.5 * figure.get_figwidth()


def test_a_picture_needs_no_pyplot() -> None:
    modules = "lfdcore.study.driving.report, lfdcore.study.prediction.picture"
    code = f"import sys, {modules}; print('matplotlib.pyplot' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "False"


def test_the_middle_of_an_orientation_bin_lies_in_it() -> None:
    headings = np.array([bin_heading(k) for k in range(17)])
    assert orientation_bin(headings).tolist() == list(range(17))


def test_example_paths_show_each_reason_once(log: DriveLog) -> None:
    paths = extract_local_paths(log)
    reasons = paths.reason[example_paths(paths)].tolist()
    assert len(set(reasons)) == len(reasons) == min(4, len(set(paths.reason.tolist())))


def test_moments_are_the_same_for_the_same_log(model: DriveAssistantModel, log: DriveLog) -> None:
    paths = extract_local_paths(log)
    first, again = (telling_moments(model, log, paths) for _ in range(2))
    assert first
    assert {k: m.observation.stamp for k, m in first.items()} == {k: m.observation.stamp for k, m in again.items()}
    for source, moment in first.items():
        assert moment.planned.source == source


def test_the_rays_of_a_scan_end_where_its_beams_do(model: DriveAssistantModel, log: DriveLog) -> None:
    moment = next(iter(telling_moments(model, log, extract_local_paths(log)).values()))
    scan = LaserScan(np.tile(np.float32([-np.inf, np.nan, 0.125, 2.0, np.inf]), 36), -np.pi / 2, np.pi / 180, 0.25, 8.0)
    axes = intention_figure(replace(moment, observation=replace(moment.observation, scan=scan))).axes[0]
    rays = np.array(next(one for one in axes.collections if isinstance(one, LineCollection)).get_segments())
    lengths = np.hypot(*np.diff(rays, axis=1)[:, 0].T)  # of every second beam
    np.testing.assert_allclose(lengths[:5], [0.25, 0.0, 8.0, 0.0, 2.0], atol=1e-6)
    assert any(len(line.get_xdata()) == 72 for line in axes.lines)  # the hits: -inf and 2 m


def test_the_drawn_dpp_path_is_the_planned_one_where_the_planner_kept_it(
    model: DriveAssistantModel, log: DriveLog
) -> None:
    moment = telling_moments(model, log, extract_local_paths(log))["grid"]
    plan = next(line for line in planning_figure(moment).axes[1].lines if line.get_color() == PLANNED)
    drawn = np.stack([plan.get_ydata(), plan.get_xdata()], axis=1)
    gap = np.hypot(*(drawn[:, None] - moment.planned.path[None]).transpose(2, 0, 1)).min(axis=1)
    assert gap.max() < 0.15  # the planner smooths the cells' staircase


def test_stage_figures_are_those_of_the_thesis_in_order_and_name_their_log(
    model: DriveAssistantModel, log: DriveLog
) -> None:
    pictures = stage_figures(model, log, origin="Simulated, seed 1.")
    found = [re.match(r"As Fig. 3.(\d+)", picture.caption) for picture in pictures]
    numbers = [int(match[1]) for match in found if match]
    assert numbers == sorted(numbers)
    assert set(numbers) == {7, 8, 9, 10, 11}
    assert all("Simulated, seed 1." in p.caption for p in pictures[:-1])


def test_no_text_of_a_stage_figure_overlaps_another(model: DriveAssistantModel, log: DriveLog) -> None:
    for picture in stage_figures(model, log):
        assert overlapping(shown_texts(picture.figure)) == []


def test_a_log_without_a_local_path_is_refused(model: DriveAssistantModel, log: DriveLog) -> None:
    still = replace(log, joystick=log.joystick * 0)
    with pytest.raises(ValueError, match="no local path"):
        stage_figures(model, still)


def grey_paths(panel: Axes) -> list[LineCollection]:
    return [made for made in panel.collections if isinstance(made, LineCollection)]


def only(paths: LocalPaths, chosen: np.ndarray) -> LocalPaths:
    arrays = {name: value[chosen] for name, value in vars(paths).items() if isinstance(value, np.ndarray)}
    return replace(paths, **arrays, paths=[paths.paths[k] for k in chosen])


def test_a_few_paths_behind_a_primitive_are_drawn_wide_enough_to_be_seen_below_it(log: DriveLog) -> None:
    paths = extract_local_paths(log)
    few = only(paths, np.flatnonzero(orientation_bin(paths.end_yaw) == 4)[:1])
    for found, wider in ((few, True), (paths, False)):
        primitives = PathPrimitives.fit(found)
        panel = primitives_figure(primitives, found).axes[list(primitives.bins).index(4)]
        (grey,) = grey_paths(panel)
        assert len(grey.get_segments()) >= 1
        assert (grey.get_linewidth()[0] > panel.lines[0].get_linewidth()) == wider


def test_the_paths_behind_the_primitives_are_those_of_all_logs(model: DriveAssistantModel, log: DriveLog) -> None:
    few = int(np.argmin(model.primitives.counts))

    def shown(others: Sequence[DriveLog]) -> int:
        picture = next(p for p in stage_figures(model, log, others=others) if p.caption.startswith("As Fig. 3.9"))
        return len(grey_paths(picture.figure.axes[few])[0].get_segments())

    still = replace(log, joystick=log.joystick * 0)  # holds no local path
    assert shown([log]) == 2 * shown([])
    assert shown([still]) == shown([])


def test_demonstrations_start_where_their_course_does(log: DriveLog) -> None:
    course = home(2)
    line = demonstrations_figure([course], [log]).axes[0].lines[0]
    assert (line.get_xdata()[0], line.get_ydata()[0]) == pytest.approx((course.start.x, course.start.y), abs=1e-6)


def test_the_driving_report_has_tables_courses_and_stages_and_stays_the_same(
    model: DriveAssistantModel, log: DriveLog, tmp_path: Path
) -> None:
    from lfdcore.study.driving.plan import run_driving_plan

    model.save(tmp_path / "m.safetensors")
    path = tmp_path / "demonstration.mcap"
    course = home(2)
    run_drive(course, ExpertDriver(course), Unassisted(CHAIR), 1, log_path=path)
    short = replace(doorway_and_docking(3).course, name="short")
    arms = ("none", "primitives")
    study = DrivingPlan(
        courses=(short,), models=StudyModels(primitives=tmp_path / "m.safetensors"), arms=arms, drivers=2
    )
    result = WholeResult(run_driving_plan(study, processes=1), None, (path,))
    written = DrivingStudy()
    report = write_study(written, findings(result), tmp_path)
    first = report.read_bytes()
    assert f"lfdcore {__version__}, seed 1. Made by: <code>{written.command()}</code>".encode() in first
    assert b"4 runs" in first
    for text in (b"Driving metrics, short", b"Figures to reach", b"As Fig. 3.14", b"As Fig. 3.12", b"As Fig. 3.7"):
        assert text in first
    assert len(first) < 6e6
    again = write_study(written, findings(result), tmp_path)
    assert again.read_bytes() == first
