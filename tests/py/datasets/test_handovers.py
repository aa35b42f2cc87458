"""Readers of the public handovers and of LASA: shapes, units and order on the real files; refusals on broken ones."""

from pathlib import Path

import numpy as np
import pytest

from lfdcore.datasets import (
    KTH_FAULTS,
    read_all_handwriting,
    read_dynamic_handovers,
    read_handwriting,
    read_kth_handovers,
)
from lfdcore.errors import DataError


@pytest.mark.realdata
def test_kth_handovers_are_97_sound_ones_and_9_with_faults(data_folder: Path) -> None:
    path = data_folder / "interaction" / "kth_handover_6d.npz"
    sound, everything = read_kth_handovers(path), read_kth_handovers(path, with_faults=True)
    assert (len(sound), len(everything)) == (97, 106)
    assert {one.name for one in everything} - {one.name for one in sound} == KTH_FAULTS
    for one in everything:
        assert (one.partner.shape, one.robot.shape) == ((801, 7), (801, 7))
        assert one.duration == pytest.approx(800 / 120)
        for pose in (one.partner, one.robot):
            np.testing.assert_allclose(np.linalg.norm(pose[:, 3:], axis=1), 1, atol=1e-9)
            assert ((pose[1:, 3:] * pose[:-1, 3:]).sum(axis=1) >= 0).all()
            assert pose[0, 6] >= 0


@pytest.mark.realdata
def test_giver_and_taker_meet_in_every_sound_kth_handover(data_folder: Path) -> None:
    for one in read_kth_handovers(data_folder / "interaction" / "kth_handover_6d.npz"):
        apart = np.linalg.norm(one.partner[:, :3] - one.robot[:, :3], axis=1)
        assert apart.min() < 0.35, one.name


@pytest.mark.realdata
def test_dynamic_handovers_are_cut_at_their_lengths(data_folder: Path) -> None:
    path = data_folder / "interaction" / "dynamic_handover_120.npz"
    hands, bodies = read_dynamic_handovers(path), read_dynamic_handovers(path, "skeleton", "skeleton", with_object=True)
    assert (len(hands), sum(len(one) for one in hands)) == (120, 16305)
    assert (hands[0].partner.shape[1], hands[0].robot.shape[1]) == (6, 6)
    assert (bodies[0].partner.shape[1], bodies[0].robot.shape[1]) == (48, 45)
    for few, all_joints in zip(hands, bodies, strict=True):
        columns = [all_joints.robot_names.index(name) for name in few.robot_names]
        np.testing.assert_array_equal(all_joints.robot[:, columns], few.robot)
        steps = np.linalg.norm(np.diff(few.partner[:, :3], axis=0), axis=1)
        assert steps.max() < 0.6  # no jump to another recording


@pytest.mark.realdata
def test_lasa_shapes_have_seven_demonstrations_that_end_in_the_origin(data_folder: Path) -> None:
    shapes = read_all_handwriting(data_folder / "lasa")
    assert len(shapes) == 15
    for shape in shapes:
        assert [p.shape for p in shape.positions] == [(1000, 2)] * 7
        assert all((np.diff(t) > 0).all() for t in shape.stamps)
        assert max(np.abs(p[-1]).max() for p in shape.positions) < 1e-9


@pytest.mark.parametrize(
    ("arrays", "reason"),
    [
        ({"train_002": np.zeros((5, 14))}, "a quaternion has the length 0, must be 1"),
        ({"train_002": np.full((5, 14), np.nan)}, "must be .T, 14. and finite"),
        ({"train_002": np.zeros((5, 13))}, r"train_002 has shape \(5, 13\)"),
        ({"train_002": np.array([None] * 5)}, "allow_pickle|Object arrays"),
    ],
)
def test_broken_kth_handovers_are_refused(tmp_path: Path, arrays: dict[str, np.ndarray], reason: str) -> None:
    np.savez(tmp_path / "kth.npz", **arrays)
    with pytest.raises(DataError, match=rf"kth\.npz: .*{reason}"):
        read_kth_handovers(tmp_path / "kth.npz")


def dynamic(**changes: np.ndarray) -> dict[str, np.ndarray]:
    joints = np.arange(9)
    whole = {"names": np.array(["a", "b"]), "lengths": np.array([3, 4]), "joints": joints}
    places = {"giver": np.zeros((7, 9, 3)), "receiver": np.ones((7, 9, 3)), "object_pos": np.zeros((7, 3))}
    return {**whole, **places, **changes}


@pytest.mark.parametrize(
    ("arrays", "reason"),
    [
        ({}, "has no giver"),
        (dynamic(lengths=np.array([3, 5])), r"giver has shape \(7, 9, 3\), must be \(8, 9, 3\)"),
        (dynamic(lengths=np.array([8, -1])), "lengths -1"),
        (dynamic(joints=np.arange(9) + 50), "joints are"),
        (dynamic(object_pos=np.zeros(7)), "object_pos"),
        (dynamic(joints=np.array(["left"] * 9)), "invalid literal"),
    ],
)
def test_broken_dynamic_handovers_are_refused(tmp_path: Path, arrays: dict[str, np.ndarray], reason: str) -> None:
    np.savez(tmp_path / "dynamic.npz", **arrays)
    with pytest.raises(DataError, match=rf"dynamic\.npz: .*{reason}"):
        read_dynamic_handovers(tmp_path / "dynamic.npz", with_object=True)


def test_other_words_than_hands_and_skeleton_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="partner must be hands or skeleton, got 'feet'"):
        read_dynamic_handovers(tmp_path / "none.npz", "feet")  # type: ignore[arg-type]


def test_files_that_are_something_else_are_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("nothing")
    (tmp_path / "text.mat").write_text("nothing" * 100)
    for read in (read_kth_handovers, read_dynamic_handovers):
        with pytest.raises(DataError, match=r"text\.npz"):
            read(tmp_path / "text.npz")
    with pytest.raises(DataError, match=r"text\.mat"):
        read_handwriting(tmp_path / "text.mat")
    with pytest.raises(DataError, match=r"holds no \.mat file"):
        read_all_handwriting(tmp_path / "nowhere")


def test_an_empty_file_is_refused_by_name(tmp_path: Path) -> None:
    (tmp_path / "x.mat").write_bytes(b"")
    with pytest.raises(DataError, match="is no handwriting"):
        read_handwriting(tmp_path / "x.mat")
