"""A small study of Sec. 5.6: what is judged, what is permuted, and its report."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lfdcore.humanoid.scene import box_of
from lfdcore.simulated.covering import BOUNDING_BOX, GROUND_TRUTH, RIGHT_GRIPPER, covering_data, demonstrate_covering
from lfdcore.study.covering.pictures import sweeps_figure
from lfdcore.study.covering.report import covering_headline, findings
from lfdcore.study.covering.study import (
    FEWEST,
    METHODS,
    NOBODY,
    OWN,
    PARTNER_SHARES,
    SHARES,
    SHUFFLED,
    STRANGER,
    CoveringResult,
    CoveringStudy,
    method_config,
    observed,
    rmse,
    run_covering_study,
    shuffled_partners,
)
from lfdcore.study.covering.tables import aims, reached_at
from lfdcore.study.study import write_study
from lfdcore.training.collaborations import NoiseChoice

FEW = replace(GROUND_TRUTH, demonstrations=3)
WIDE = replace(BOUNDING_BOX, demonstrations=4, novel=BOUNDING_BOX.novel[2:])
QUICK = NoiseChoice(factors=(100.0, 1e4), folds=2, shares=(0.4,))
SMALL = CoveringStudy(seeds=2, seed=100, held_out=1, dials=(0.35,), protocols=(FEW, WIDE), choice=QUICK, processes=1)


@pytest.fixture(scope="module")
def result() -> CoveringResult:
    """Two seeds that the reported study does not use."""
    return run_covering_study(SMALL)


@pytest.fixture(scope="module")
def written(result: CoveringResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its report."""
    folder = tmp_path_factory.mktemp("covering")
    write_study(SMALL, findings(result), folder)
    return folder


def test_eaip_covers_all_objects_and_ip_touches_the_larger_ones(result: CoveringResult) -> None:
    """Fig. 5.16-5.17."""
    positions = [trial for trial in result.trials if trial.form == "positions"]
    assert len(positions) == 2 * 2 * (4 + 6)
    assert all(trial.whole.success for trial in positions if trial.method == "EaIP")
    large = [t for t in positions if t.covered_object in ("stepladder", "shelf", "cabinet raised by 10 cm")]
    assert all(trial.whole.collided for trial in large if trial.method == "IP")


def test_the_whole_and_the_executed_motion_are_two_motions_with_the_same_verdict_here(result: CoveringResult) -> None:
    """F14."""
    known = [trial for trial in result.trials if trial.determined]
    assert known
    assert any(t.whole.contact.distance != t.executed.contact.distance for t in known)
    assert all(t.executed.success for t in result.trials if t.method == "EaIP")


def test_errors_shrink_to_nothing_at_the_final_motion_and_eaips_are_smaller_from_the_start(
    result: CoveringResult,
) -> None:
    for run in result.runs:
        objects = len(run.protocol.training) + len(run.protocol.novel)
        for errors in run.errors.values():
            assert errors.to_final.shape == errors.to_demonstration.shape == (objects, 1, len(SHARES))
            assert (errors.to_final[..., -1] == 0).all()
        eaip, ip = (run.errors["positions", method].to_demonstration.mean(axis=(0, 1)) for method in METHODS)
        assert (eaip[SHARES.index(0.1)] < ip).all()


def test_the_own_partner_never_hurts_and_shuffled_partners_teach_no_more_than_the_scene(result: CoveringResult) -> None:
    late = PARTNER_SHARES.index(0.7)
    wide = result.of(WIDE)
    own, nobody, stranger, shuffled = (
        np.mean([run.partners[name][late] for run in wide]) for name in (OWN, NOBODY, STRANGER, SHUFFLED)
    )
    assert own < 1.02 * min(nobody, stranger)  # what it is worth is too little to be seen by two seeds
    assert own < shuffled
    assert all(len(set(run.partners[NOBODY])) == 1 for run in wide)


def test_ip_differs_from_eaip_in_the_scene_alone() -> None:
    for form in ("positions", "forcing"):
        eaip, ip = (method_config(form, method) for method in METHODS)
        assert ip != eaip
        assert replace(ip, environment=True) == eaip


def test_every_demonstration_gets_another_ones_partner_and_keeps_its_robot_and_scene() -> None:
    before = covering_data(GROUND_TRUTH, 100).training
    after = shuffled_partners(before, 1)
    where = []
    for one, mixed in zip(before, after, strict=True):
        assert mixed.environment == one.environment
        assert np.allclose(mixed.robot[[0, -1]], one.robot[[0, -1]])
        where.append(next(k for k, b in enumerate(before) if np.array_equal(b.partner, mixed.partner, equal_nan=True)))
    assert sorted(where) == list(range(len(before)))
    assert all(k != place for k, place in enumerate(where))


def test_at_least_ten_samples_are_observed() -> None:
    one = demonstrate_covering(GROUND_TRUTH.training[0], 1)
    assert len(observed(one, 0.0)) == len(observed(one, 0.02)) == FEWEST
    assert len(observed(one, 1.0)) == len(one)


def test_rmse_is_the_root_of_the_mean_squared_distance() -> None:
    assert rmse(np.zeros((4, 3)), np.tile([0.0, 3.0, 4.0], (4, 1))) == pytest.approx(5.0)


def test_where_an_error_falls_to_a_level_is_interpolated() -> None:
    errors = np.linspace(13.0, 1.0, len(SHARES))  # 10 at SHARES[3], 9 at SHARES[4]
    assert reached_at(errors, 9.5) == pytest.approx((SHARES[3] + SHARES[4]) / 2)
    assert reached_at(errors, 20.0) == SHARES[0]
    assert np.isnan(reached_at(errors, 0.5))


def test_a_study_is_the_same_whatever_the_number_of_processes(written: Path, tmp_path: Path) -> None:
    two = replace(SMALL, processes=2)
    write_study(two, findings(run_covering_study(two)), tmp_path)
    for file in ("report.html", "figures.json"):
        assert (tmp_path / file).read_bytes() == (written / file).read_bytes()


def test_the_report_says_that_it_is_synthetic_and_has_every_picture(result: CoveringResult, written: Path) -> None:
    report = (written / "report.html").read_text()
    assert "simulated" in report
    assert "largely built in" in report
    assert report.count("<img") == 8
    document = json.loads((written / "figures.json").read_text())
    assert sum("whole_success" in row for row in document["rows"]) == len(result.trials)
    assert [aim["figure"] for aim in document["aims"]] == [aim.label for aim in aims(result)]


def test_tables_name_n_and_the_headline_counts_successes(result: CoveringResult) -> None:
    text = "\n".join(table.as_text() for table in findings(result).tables)
    assert "n = 2 an object: 1 unseen people x 2 seeds" in text
    assert "EaIP 8 of 8 (protocol 5.6.1)" in covering_headline(result)


def test_a_collision_is_marked_at_its_object(result: CoveringResult) -> None:
    run = result.of(WIDE)[0]
    titles = [axes.get_title("left") for axes in sweeps_figure(run, WIDE.training).axes]
    assert "IP: stepladder *" in titles
    assert "EaIP: stepladder" in titles


def test_what_is_shown_is_what_was_judged(result: CoveringResult) -> None:
    run = result.of(FEW)[0]
    for method in METHODS:
        for trial in run.trials:
            if (trial.form, trial.method, trial.person) == ("positions", method, 0):
                assert run.shown.verdicts[method][trial.covered_object] == trial.whole
    stool = covering_data(FEW, run.seed, held_out=1).known["stool"][0]
    assert run.shown.boxes["stool"] == box_of(stool)
    assert RIGHT_GRIPPER[2] > run.shown.boxes["stool"].top


@pytest.mark.parametrize("given", [{"seeds": 0}, {"held_out": 0}, {"seed": -1}], ids=str)
def test_counts_that_cannot_be_are_refused(given: dict[str, int]) -> None:
    with pytest.raises(ValueError, match="must be at least"):
        CoveringStudy(**given)
