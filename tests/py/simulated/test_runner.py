"""Runs and studies: the same bytes whatever the number of processes, the same noise in every arm, failures counted."""

import dataclasses
import signal
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import open_log
from lfdcore.geometry import Twist2
from lfdcore.simulated.courses import Course, figure_eight, flat, training_courses
from lfdcore.simulated.drivers import Driver, ExpertDriver, ImpairedDriver
from lfdcore.simulated.run import Job, RunConfig, run_drive
from lfdcore.simulated.trace import DriveTrace
from lfdcore.simulation import LidarConfig
from lfdcore.study.arms import ARMS, FOOTNOTE_ARMS, StudyModels, make_assistant
from lfdcore.study.demonstrations import demonstrate
from lfdcore.study.driving.plan import DrivingPlan, run_driving_plan
from lfdcore.study.jobs import _end_deferred, run_jobs
from lfdcore.wheelchair.assistants import STOP, Unassisted
from lfdcore.wheelchair.observation import Assistance, ChairGeometry, Observation

CHAIR = ChairGeometry.thesis()


def for_seconds(course: Course, seconds: float, **changes: object) -> RunConfig:
    """A run that times out after `seconds`."""
    return RunConfig(slowest=course.length / seconds, **changes)  # type: ignore[arg-type]


class Refusing:
    """An assistant that never lets the chair move, and keeps what it saw."""

    name = "refusing"
    chair = CHAIR

    def __init__(self) -> None:
        self.seen: list[Observation] = []

    def reset(self) -> None:
        self.seen.clear()

    def update(self, observation: Observation) -> Assistance:
        self.seen.append(observation)
        return Assistance(STOP, "rest")


class Spinning(Refusing):
    """... or that turns in place."""

    name = "spinning"

    def update(self, observation: Observation) -> Assistance:
        super().update(observation)
        return Assistance(Twist2(0.0, 0.3), "user")


def assert_same_bytes(a: DriveTrace, b: DriveTrace) -> None:
    for field in dataclasses.fields(DriveTrace):
        one, other = getattr(a, field.name), getattr(b, field.name)
        if isinstance(one, np.ndarray):
            assert one.tobytes() == other.tobytes(), field.name
        elif field.name == "plans":
            assert [(p.stamp, p.path.tobytes()) for p in one] == [(p.stamp, p.path.tobytes()) for p in other]
        else:
            assert repr(one) == repr(other), field.name


@pytest.fixture(scope="module")
def study(home_model: Path) -> DrivingPlan:
    course = flat()
    return DrivingPlan(
        courses=(course,),
        models=StudyModels(primitives=home_model),
        arms=("none", "dwa", "primitives"),
        drivers=2,
        seed=5,
        run=for_seconds(course, 15),
    )


def test_a_study_gives_the_same_bytes_with_one_process_and_with_two(study: DrivingPlan) -> None:
    one, two = (run_driving_plan(study, processes=count) for count in (1, 2))
    assert len(one.traces) == len(two.traces) == 6
    for a, b in zip(one.traces, two.traces, strict=True):
        assert_same_bytes(a, b)
    np.testing.assert_equal(one.rows, two.rows)  # NaN equals NaN
    assert any(trace.plans for trace in one.traces)


def test_a_used_assistant_and_driver_drive_as_fresh_ones(study: DrivingPlan) -> None:
    course, run = study.courses[0], study.run
    driver, assistant = ImpairedDriver(course), make_assistant("primitives", study.models, run)
    first, again = (run_drive(course, driver, assistant, 5, run) for _ in range(2))
    assert_same_bytes(first, again)
    assert first.pose.tobytes() != run_drive(course, driver, assistant, 6, run).pose.tobytes()


def test_every_arm_and_driver_number_has_its_seed_and_order(study: DrivingPlan) -> None:
    jobs = study.jobs()
    assert [job.seed for job in jobs] == [5, 5, 5, 6, 6, 6]
    assert [job.make_assistant().name for job in jobs] == ["none", "dwa", "primitives"] * 2
    configs = [job.make_driver(job.course).config for job in jobs]
    assert configs[0] == configs[1] == configs[2] != configs[3] == configs[4] == configs[5]


def test_scan_noise_depends_on_seed_and_tick_only() -> None:
    """Two arms that move differently: what they see differs from the truth by the same noise."""
    course = figure_eight()  # open: every beam hits a wall in both arms, so noises can be compared
    noises = [_noises(course, arm, seed) for arm, seed in ((Refusing(), 3), (Spinning(), 3), (Refusing(), 4))]
    rest, spinning, other_seed = noises
    assert rest.std() == pytest.approx(RunConfig().lidar.noise_sd, rel=0.1)
    np.testing.assert_allclose(rest, spinning, atol=1e-5)
    assert np.abs(rest - other_seed).max() > 0.01


def _noises(course: Course, arm: Refusing, seed: int) -> np.ndarray:
    """Noise (ticks, beams) [m] in the scans that an arm saw: against the same run without noise."""
    seen = []
    for lidar in (LidarConfig(), LidarConfig(noise_sd=0.0)):
        run_drive(course, ImpairedDriver(course), arm, seed, for_seconds(course, 4, lidar=lidar))
        seen.append(np.array([o.scan.ranges for o in arm.seen]))
    return np.asarray(seen[0] - seen[1])


def test_the_drivers_noise_depends_on_seed_and_tick_only() -> None:
    """Arms that keep the chair on the spot, one slowly turning: both drivers have drawn the same noise by the end."""
    course, drawn = figure_eight(), []
    for arm in (Refusing(), Spinning()):
        driver = ImpairedDriver(course)
        run_drive(course, driver, arm, 3, for_seconds(course, 4))
        drawn.append(driver._draw())
    assert drawn[0] == drawn[1]


def test_a_driver_who_does_not_get_on_is_stuck_and_one_too_slow_times_out() -> None:
    course = flat()
    stuck = run_drive(course, ImpairedDriver(course), Refusing(), 0, RunConfig(stuck_after=5.0))
    assert stuck.outcome == "stuck" and not stuck.completed
    assert stuck.stamp[-1] == pytest.approx(5.1, abs=0.11)
    slow = run_drive(course, ImpairedDriver(course), Unassisted(CHAIR), 0, for_seconds(course, 8))
    assert slow.outcome == "time_out" and not slow.completed
    assert slow.stamp[-1] == pytest.approx(8.1, abs=0.11)


def test_failures_stay_in_a_studys_rows(study: DrivingPlan) -> None:
    result = run_driving_plan(study, processes=1)
    assert [row["outcome"] for row in result.rows] == ["time_out"] * 6
    assert len(result.column(None, "none", "collisions")) == 2
    assert result.nbytes == sum(trace.nbytes for trace in result.traces) < 6 * 100_000


def test_the_drive_log_of_a_run_agrees_with_its_trace(home_model: Path, tmp_path: Path) -> None:
    course = flat()
    run, path = for_seconds(course, 10), tmp_path / "run.mcap"
    assistant = make_assistant("primitives", StudyModels(primitives=home_model), run)
    trace = run_drive(course, ImpairedDriver(course), assistant, 1, run, path)
    log = open_log(path)
    assert log.name == course.name and "incomplete" not in log.metadata
    assert log.ranges.shape == (len(trace.stamp), run.lidar.beams)
    for stamps in (log.scan_stamp, log.odometry_stamp, log.joystick_stamp, log.desired_stamp, log.command_stamp):
        np.testing.assert_allclose(stamps, trace.stamp, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(log.command, trace.command)
    np.testing.assert_array_equal(log.joystick, trace.joystick)
    np.testing.assert_allclose(log.desired, trace.desired, rtol=0, atol=1e-7)  # float32 in the file
    in_map = course.start.transform(log.pose[:, :2])
    np.testing.assert_allclose(in_map, trace.pose[:, :2], atol=0.05)  # odometry slips a little, or not at all
    assert [plan.stamp for plan in log.plans] == pytest.approx([plan.stamp for plan in trace.plans])
    for recorded, kept in zip(log.plans, trace.plans, strict=True):
        np.testing.assert_allclose(course.start.transform(recorded.path), kept.path, atol=1e-9)


def test_a_log_is_whole_up_to_where_a_run_broke_off(tmp_path: Path) -> None:
    class Breaking(Refusing):
        def update(self, observation: Observation) -> Assistance:
            if len(self.seen) == 20:
                raise RuntimeError("broken on purpose")
            return super().update(observation)

    course, path = flat(), tmp_path / "broken.mcap"
    with pytest.raises(RuntimeError, match="on purpose"):
        run_drive(course, ImpairedDriver(course), Breaking(), 0, None, path)
    assert len(open_log(path).command_stamp) == 20


def _driver(course: Course) -> Driver:
    return ImpairedDriver(course)


def _no_assistant() -> Unassisted:
    raise ValueError("no assistant to be had")


@pytest.mark.parametrize("processes", [1, 2])
def test_an_error_in_a_job_reaches_the_caller(processes: int) -> None:
    course = flat()
    jobs = [
        Job(course, _driver, make, 0, for_seconds(course, 1)) for make in (partial(Unassisted, CHAIR), _no_assistant)
    ]
    with pytest.raises(ValueError, match="no assistant"):
        run_jobs(jobs, processes=processes)


def test_an_unknown_arm_is_refused_by_name(home_model: Path) -> None:
    with pytest.raises(ValueError, match=r"'magic'.*none.*dwa.*primitives"):
        make_assistant("magic", StudyModels(primitives=home_model), RunConfig())


@pytest.mark.parametrize("arm", [*ARMS, *FOOTNOTE_ARMS])
def test_every_arm_drives(arm: str, home_model: Path, heatmap_model: Path) -> None:
    course = flat()
    run = for_seconds(course, 6)
    make = partial(make_assistant, arm, StudyModels(primitives=home_model, heatmaps=heatmap_model), run)
    trace = run_drive(course, ImpairedDriver(course), make(), 1, run)
    assert trace.assistant == arm
    assert np.hypot(*(trace.pose[-1, :2] - trace.pose[0, :2])) > 0.5


def test_ctrl_c_while_processes_are_started_counts_once_all_are_known() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    reached = False
    with pytest.raises(KeyboardInterrupt), _end_deferred():
        signal.raise_signal(signal.SIGINT)
        reached = True
    restored = signal.signal(signal.SIGINT, before)
    assert reached
    assert restored is signal.default_int_handler


def test_an_expert_who_touches_something_demonstrates_again(tmp_path: Path) -> None:
    """Seed 12 touches in the first home; the log that stays is of the next attempt."""
    course = training_courses()[0]
    assert run_drive(course, ExpertDriver(course), Unassisted(CHAIR), 12).collision.any()
    path, trace = demonstrate(tmp_path, 12)[0]
    assert trace.seed == 1012 and not trace.collision.any()
    np.testing.assert_allclose(open_log(path).scan_stamp[-1], trace.stamp[-1])
