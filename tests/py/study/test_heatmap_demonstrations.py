"""The drives of Ch. 4: who drives what, the same bytes for a seed, both joysticks in the log."""

from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import joystick_pairs, open_log
from lfdcore.simulated.courses import mazes
from lfdcore.simulated.drivers import ABLE_POPULATION, able_population
from lfdcore.simulated.run import Job
from lfdcore.study import demonstrations
from lfdcore.study.demonstrations import RecordedDrives, demonstrate_in_mazes, drive_to_destinations


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> RecordedDrives:
    return demonstrate_in_mazes(tmp_path_factory.mktemp("mazes"), 1, runs=3, processes=1)


def planned(monkeypatch: pytest.MonkeyPatch, record, seed: int) -> list[Job]:  # type: ignore[no-untyped-def]
    """The jobs that would be run."""
    jobs: list[Job] = []
    monkeypatch.setattr(demonstrations, "_record", lambda planned, *_: jobs.extend(planned))
    record(Path(), seed)
    return jobs


def test_72_runs_take_every_route_three_times_with_three_drivers_of_nine_runs_each(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    jobs = planned(monkeypatch, demonstrate_in_mazes, 1)
    who = [(job.course.name, job.make_driver.keywords["config"]) for job in jobs]  # type: ignore[attr-defined]
    assert len(who) == len(set(who)) == 72
    assert {name for name, _ in who} == {course.name for course in mazes()}
    drivers = able_population(8, 1)
    assert [sum(driver == d for _, driver in who) for d in drivers] == [9] * 8
    assert all(sum(name == course.name for name, _ in who) == 3 for course in mazes())
    for n in (4, 10, 20, 40):  # a learning curve's first runs are drivers and mazes in turn
        assert abs(sum(name.startswith("maze-1") for name, _ in who[:n]) - n / 2) <= 1


def test_30_runs_in_the_home_are_of_10_drivers_to_30_destinations_and_share_no_seed_with_the_mazes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    jobs = planned(monkeypatch, drive_to_destinations, 1)
    demonstrated = planned(monkeypatch, demonstrate_in_mazes, 1) + planned(monkeypatch, demonstrate_in_mazes, 2)
    assert len(jobs) == 30 and len({job.course.route.tobytes() for job in jobs}) == 30
    drivers = [job.make_driver.keywords["config"] for job in jobs]  # type: ignore[attr-defined]
    assert len(set(drivers)) == 10 and not set(drivers) & set(able_population(8, 1))
    assert all(job.course.split == "test" for job in jobs)
    assert not {job.seed for job in jobs} & {job.seed for job in demonstrated}
    assert len({job.seed for job in demonstrated}) == 144


def test_able_drivers_reach_their_destinations_with_dwa_without_contact(drives: RecordedDrives) -> None:
    assert drives.unfinished == 0 and drives.collisions == 0
    assert {trace.assistant for trace in drives.traces} == {"dwa_1s"}


def test_a_log_holds_the_raw_and_the_safe_joystick(drives: RecordedDrives) -> None:
    for path, trace in zip(drives.paths, drives.traces, strict=True):
        log = open_log(path)
        pairs = joystick_pairs(log)
        assert len(pairs.stamp) == len(log.scan_stamp) == len(trace.stamp)
        np.testing.assert_allclose(pairs.raw, trace.joystick, atol=1e-7)
        np.testing.assert_allclose(pairs.safe[:, 1], trace.command[:, 1], atol=1e-12)  # 1 rad/s at full stick
        assert np.abs(pairs.safe).max() <= 1
        assert np.abs(pairs.safe - pairs.raw).max() > 0
        assert log.metadata["driver"] == "able" and log.metadata["seed"] == str(trace.seed)


def test_the_same_seed_gives_the_same_bytes_over_processes_and_another_seed_others(
    drives: RecordedDrives, tmp_path: Path
) -> None:
    seen: list[tuple[int, int]] = []
    again = demonstrate_in_mazes(tmp_path, 1, runs=2, processes=2, progress=lambda *at: seen.append(at))
    assert [p.read_bytes() for p in again.paths] == [p.read_bytes() for p in drives.paths[:2]]
    assert seen == [(1, 2), (2, 2)]
    other = demonstrate_in_mazes(tmp_path, 2, runs=1, processes=1)
    assert other.paths[0].read_bytes() != drives.paths[0].read_bytes()


def test_a_drive_in_the_home_is_unassisted_so_the_safe_joystick_is_the_raw_one(tmp_path: Path) -> None:
    drives = drive_to_destinations(tmp_path, 3, runs=1, processes=1)
    pairs = joystick_pairs(open_log(drives.paths[0]))
    assert drives.traces[0].assistant == "none" and drives.traces[0].completed
    np.testing.assert_allclose(pairs.safe, pairs.raw, atol=1e-12)


@pytest.mark.parametrize(("record", "most"), [(demonstrate_in_mazes, 72), (drive_to_destinations, 30)])
def test_a_number_of_runs_that_the_thesis_has_not_is_refused(record, most: int) -> None:  # type: ignore[no-untyped-def]
    for runs in (0, most + 1):
        with pytest.raises(ValueError, match=rf"runs must be 1\.\.{most}, got {runs}"):
            record(Path(), 1, runs=runs)
    with pytest.raises(ValueError, match="seed"):
        record(Path(), -1)


def test_able_drivers_stay_in_their_ranges_and_driver_i_does_not_depend_on_n() -> None:
    many = able_population(8, 5)
    assert many[:3] == able_population(3, 5) and len(set(many)) == 8
    for name, (low, high) in ABLE_POPULATION.items():
        assert all(low <= getattr(config, name) <= high for config in many)
    with pytest.raises(ValueError, match="n must be at least 1"):
        able_population(0, 5)
