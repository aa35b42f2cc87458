"""Hostile sticks: the same seed gives the same stick, what is kept is not driven again, and the rival collides."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.geometry import MotionLimits, Pose2, Twist2, integrate
from lfdcore.progress import silent
from lfdcore.simulated.courses import home
from lfdcore.simulated.drivers import StickHolder
from lfdcore.simulated.hostile_drivers import AdversarialStick, HeldStick, RandomStick
from lfdcore.simulation import DrivingWorld, joystick_to_twist
from lfdcore.study.safety.conditions import CONDITIONS
from lfdcore.study.safety.errands import ERRANDS
from lfdcore.study.safety.hostile_run import somewhere
from lfdcore.study.safety.report import findings
from lfdcore.study.safety.study import SafetyStudy, run_safety_study

SMALL = SafetyStudy(
    conditions=("as declared",),
    courses=("home",),
    sticks=("random", "held"),
    runs=1,
    seconds=40,
    processes=1,
    errands=0,
)


def sticks(holder: StickHolder, seed: int) -> list[tuple[float, float]]:
    holder.reset(seed)
    given = [holder.act(k / 10, Pose2(8.0, 3.0, 0.1 * k), Twist2(), False) for k in range(100)]
    return [(float(one.joystick[0]), float(one.joystick[1])) for one in given]


@pytest.mark.parametrize("holder", [HeldStick((0.7, 0.7)), RandomStick(), AdversarialStick(home())])
def test_the_same_seed_gives_the_same_stick_within_its_stops(holder: StickHolder) -> None:
    first = sticks(holder, 1)
    assert first == sticks(holder, 1)
    assert np.abs(first).max() <= 1


@pytest.mark.parametrize("holder", [RandomStick(), AdversarialStick(home())])
def test_another_seed_gives_another_stick(holder: StickHolder) -> None:
    assert sticks(holder, 1) != sticks(holder, 2)


def test_the_adversary_steers_at_what_is_nearest() -> None:
    """With a wall .5 m ahead, it finds a way into something within its horizon."""
    course = home()
    world = DrivingWorld(course.grid)
    facing = next(
        pose
        for pose in (somewhere(course, seed, 0.4) for seed in range(200))
        if world.touches(Pose2(pose.x + 0.5 * math.cos(pose.yaw), pose.y + 0.5 * math.sin(pose.yaw), pose.yaw))
        and not world.touches(pose, 0.2)
    )
    stick = AdversarialStick(course)
    stick.reset(1)
    forward, left = stick.act(0.0, facing, Twist2(), False).joystick
    twist = joystick_to_twist(forward, left, MotionLimits())
    ways = [integrate(facing, twist, share * AdversarialStick.HORIZON) for share in (0.25, 0.5, 1.0)]
    assert any(world.touches(pose, 0.05) for pose in ways)


def test_a_start_touches_nothing_and_lies_beside_something_where_asked() -> None:
    course = home()
    world = DrivingWorld(course.grid)
    for seed in range(20):
        pose = somewhere(course, seed, 0.3)
        assert not world.touches(pose, 0.05)
        assert world.touches(pose, 0.3)


def test_what_is_kept_is_not_driven_again_and_says_the_same(tmp_path: Path) -> None:
    first = run_safety_study(SMALL, tmp_path)
    files = sorted((tmp_path / "runs").glob("*.json"))
    assert len(files) == len(first.runs) == 4
    kept = json.loads(files[0].read_text())
    files[0].write_text(json.dumps({**kept, "collisions": 1234}))
    again = run_safety_study(SMALL, tmp_path)
    assert sorted(one.collisions for one in again.counts)[-1] == 1234
    files[0].write_text(json.dumps(kept))
    assert run_safety_study(SMALL, tmp_path).counts == first.counts


@pytest.mark.hazard(
    "Hostile sticks, chairs that are not as they should be",
    "no collision with what stands, and no standing where a free motion is asked for",
    each="3 minutes, make safety",
)
@pytest.mark.parametrize("condition", [name for name, one in CONDITIONS.items() if one.promised])
def test_a_small_share_of_make_safety(condition: str, tmp_path: Path) -> None:
    study = replace(SMALL, conditions=(condition,), sticks=("random", "adversarial", "held"), seconds=60)
    result = run_safety_study(study, tmp_path)
    assert sum(one.collisions for one in result.of(arm="supervisor")) == 0
    assert sum(one.stood for one in result.of(arm="supervisor")) == 0
    assert sum(one.collisions for one in result.of(arm="none")) > 0
    assert sum(one.distance for one in result.of(arm="supervisor")) > 10


def test_the_report_says_what_was_driven_and_which_condition_promises_nothing(tmp_path: Path) -> None:
    study = replace(SMALL, conditions=("as declared", "20 beams"))
    result = run_safety_study(study, tmp_path, silent)
    found = findings(result)
    promised, all_of_them = found.tables
    names = ["as declared", "as declared", "20 beams †", "20 beams †"]
    assert [row[0].split("\n")[0] for row in all_of_them.rows] == names
    assert [row[2:] for row in promised.rows] == [row[1:6] for row in all_of_them.rows[:2]]
    assert all(aim.reached for aim in found.aims)
    assert found.headline.endswith("2 of 2 reached.")
    assert len(found.rows) == 8


def test_the_report_says_what_caution_costs(tmp_path: Path) -> None:
    study = replace(SMALL, sticks=("held",), seconds=10, errands=1)
    found = findings(run_safety_study(study, tmp_path, silent))
    costs = found.tables[-1]
    assert [row[0] for row in costs.rows[:2]] == ["door of 0.80 m\nunassisted", "door of 0.80 m\nsupervisor only"]
    assert len(costs.rows) == 2 * len(ERRANDS)
    assert [aim.label.split(":")[0] for aim in found.aims[2:]] == [
        *["arrived"] * 3,
        "time over unassisted",
        "progress over unassisted",
        "wall contacts",
        "people met by the nose",
    ]
    assert {row["errand"] for row in found.rows if "errand" in row} == set(ERRANDS)


def test_the_table_of_what_is_promised_is_of_all_such_conditions_together(tmp_path: Path) -> None:
    study = replace(SMALL, arms=("none",), conditions=("as declared", "late ticks", "20 beams"))
    result = run_safety_study(study, tmp_path, silent)
    counts = [replace(one, collisions=1, stood=2, distance=10e3, lasted=3600.0) for one in result.counts]
    found = findings(replace(result, counts=tuple(counts)))
    ((_, at_most, km, collisions, rate, _, stood),) = found.tables[0].rows
    assert (km, collisions, stood) == ("40.00", "4", "2.00\n8 in 4.0 h")
    low, high = 100 / 40 * 1.0899, 100 / 40 * 10.2416  # Garwood's interval of 4, from tables
    assert (at_most, rate) == (f"{high:.1f}", f"10\n[{low:.0f}, {high:.0f}]")


def test_what_another_version_counted_is_driven_again(tmp_path: Path) -> None:
    first = run_safety_study(SMALL, tmp_path)
    file = sorted((tmp_path / "runs").glob("*.json"))[0]
    older = {name: value for name, value in json.loads(file.read_text()).items() if name != "stood"}
    file.write_text(json.dumps({**older, "collisions": 1234}))
    assert run_safety_study(SMALL, tmp_path).counts == first.counts


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"conditions": ("fog",)}, "condition is 'fog'"),
        ({"sticks": ("kind",)}, "stick is 'kind'"),
        ({"arms": ("nobody",)}, "assistant is 'nobody'"),
        ({"seconds": 1}, "seconds is 1"),
    ],
)
def test_a_study_that_cannot_be_is_refused_by_name(options: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SafetyStudy(**options)  # type: ignore[arg-type]
